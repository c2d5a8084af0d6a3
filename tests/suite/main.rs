//! Every test that needs more than one module, in one binary.

mod animated;
mod bench;
mod cli;
mod coincident;
mod device_instances;
mod device_trees;
mod geometry;
mod gpu;
mod ground_truth;
mod house;
mod importers;
mod invariance;
mod layout;
mod leaving;
mod looks;
mod looks_known;
mod motion;
mod moving;
mod numerics;
mod pictures;
mod present;
mod sampling;
mod shaders;
mod stability;
mod tracers;
mod window;
