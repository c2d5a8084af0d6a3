//! How a picture is to be traced: what belongs to the viewer rather than the scene.

use bevy_ecs::prelude::*;
use glam::UVec2;

use super::{Kernels, Skips};

/// Settings of a run.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct TraceSettings {
    /// Size of the traced picture in pixels; each at least 1.
    pub size: UVec2,
    /// Samples of a pixel, 1 to [`super::wire::SAMPLES_CAPACITY`]: the first so many points of
    /// [`super::sample_offset`]. 1 is the pixel's centre. Cost grows with it.
    pub samples: u32,
    /// Contrast with a neighbour above which a pixel takes all its samples, the others one: the largest
    /// difference of a channel over the greater of the two values, but for the dark. None: every pixel takes all.
    /// The f64 reference always takes all.
    pub adaptive: Option<f32>,
    /// Frames in which nothing changed add a sample to every pixel that has fewer than this, up to
    /// [`super::wire::SAMPLES_CAPACITY`]; 0: the picture stays. The f64 reference does not refine.
    pub refine_to: u32,
    /// Samples that such a frame adds, one after the other: the picture is the same however many, and is there sooner.
    pub refine_by: u32,
    /// Overrides the scene's number of generations.
    pub max_generations: Option<u32>,
    /// The arithmetic of the f32 tracers; the robust forms unless something is measured against them.
    pub kernels: Kernels,
    /// What is left out because no picture shows it: all of it, unless somebody wants to know what that is worth.
    pub skips: Skips,
    /// Largest error that leaving out shadow, reflected and refracted rays may cause in a pixel, in linear light before
    /// exposure, a channel: of all of them together, however many lights there are. 0.002 is half a step of 8 bits of linear
    /// light; higher is faster. 0 leaves out nothing. First samples of adaptive pictures leave out nothing, so that the
    /// same pixels take more; nor does the f64 reference. (Besides, sums round otherwise where terms are missing.)
    pub cutoff: f32,
    /// Rays are counted by kind, and those left out: on a GPU that takes a kernel of its own, and time, so those who read no
    /// counts do without. What did not fit and what was brought there is counted always; on the host, where it costs
    /// nothing, everything is.
    pub count_rays: bool,
}

impl TraceSettings {
    /// A contrast that finds the edges one sees.
    pub const EDGE_CONTRAST: f32 = 0.1;
}

impl Default for TraceSettings {
    fn default() -> Self {
        Self {
            // 16:9 and small enough for a CPU; windows and commands set their own.
            size: UVec2::new(1280, 720),
            samples: 1,
            adaptive: None,
            refine_to: 0,
            refine_by: 1,
            max_generations: None,
            kernels: Kernels::default(),
            skips: Skips::ALL,
            // A bound in linear light would say nothing of a dim scene that exposure lifts.
            cutoff: 0.0,
            count_rays: true,
        }
    }
}
