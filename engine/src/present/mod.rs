//! From linear light to a screen or a file: exposure, tone curve, sRGB, overlay.
//!
//! The tone curve exists twice, as `tone.rs` and as `shaders/present.wgsl`; a test compares the two.

mod files;
mod tone;

pub use files::{FileError, write_exr, write_png8, write_png16_linear};
pub use tone::{display_rgb, display_rgb8, srgb_from_linear};
