//! Every test that needs more than one module, in one binary.

mod gpu;
mod layout;
mod present;
mod shaders;
mod tracers;
mod window;
