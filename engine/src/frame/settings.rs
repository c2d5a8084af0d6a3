//! How a picture is to be traced: what belongs to the viewer rather than the scene.

use bevy_ecs::prelude::*;
use glam::UVec2;

use super::Kernels;

/// Settings of a run.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct TraceSettings {
    /// Size of the traced picture in pixels; each at least 1.
    pub size: UVec2,
    /// Samples along each side of a pixel, on a regular grid: 1 is the pixel's centre, 2 is four
    /// samples. Cost grows with its square.
    pub samples_per_axis: u32,
    /// Overrides the scene's number of generations.
    pub max_generations: Option<u32>,
    /// The arithmetic of the f32 tracers; the robust forms unless something is measured against them.
    pub kernels: Kernels,
}

impl Default for TraceSettings {
    fn default() -> Self {
        Self {
            // 16:9 and small enough for a CPU; windows and commands set their own.
            size: UVec2::new(1280, 720),
            samples_per_axis: 1,
            max_generations: None,
            kernels: Kernels::default(),
        }
    }
}
