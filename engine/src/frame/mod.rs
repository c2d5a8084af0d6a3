//! The frame as plain data: what tracers are given, and nothing else.

mod extract;
mod features;
mod kernels;
mod overview;
mod samples;
mod scene;
mod settings;
mod skips;
pub mod wire;

pub use features::{Features, NamedFeature};
pub use kernels::{BoxTest, FIXED_OFFSET, Kernels, Offset, TriangleTest};
pub use samples::sample_offset;
pub use scene::{FrameScene, Instance, Light, LightKind, Shape, View, ViewProjection};
pub use settings::TraceSettings;
pub use skips::{Skip, Skips};

use crate::app::Engine;

/// Adds the [`FrameScene`], the settings and extraction (set [`crate::schedule::FrameSet::Extract`]).
pub fn plugin(engine: &mut Engine) {
    engine.world.init_resource::<FrameScene>();
    engine.world.init_resource::<TraceSettings>();
    extract::plugin(engine);
}

#[cfg(test)]
mod tests;
