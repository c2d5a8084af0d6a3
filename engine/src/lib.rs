//! Orrery: a data-oriented, real-time Whitted ray-tracing engine for scenes in which everything moves.
//!
//! An [`Engine`] is a world of entities and one schedule. A frame goes through the sets of
//! [`schedule::FrameSet`], top to bottom:
//!
//! | module | room of the house |
//! |---|---|
//! | [`app`], [`schedule`], [`time`], [`input`] | the loop |
//! | [`world`] | components, and what keeps them true (f64) |
//! | [`geom`], [`bvh`] | pure maths; trees |
//! | [`frame`] | the frame as plain data |
//! | [`trace`] | three tracers behind one trait |
//! | [`profile`] | what a frame cost |
//! | [`present`] | from linear light to a screen or a file |
//! | [`editor`], [`window`] | panels over the picture; where it is shown |

pub mod app;
pub mod bvh;
pub mod editor;
pub mod frame;
pub mod geom;
pub mod import;
pub mod input;
mod pod;
pub mod present;
pub mod profile;
pub mod scene;
pub mod schedule;
#[cfg(test)]
mod testing;
pub mod time;
pub mod trace;
pub mod window;
pub mod world;

pub use app::Engine;
