//! Tracers: three ways to the same picture behind one trait.
//!
//! `gpu` (WGSL, f32), `cpu` (rayon, f32: the report's "emulation mode") and `reference` (f64, plain, the
//! oracle). All follow one algorithm, Whitted's (1980), with an explicit stack of deferred rays. They
//! continue the tracing part of the report (Allgyer 2008, "Real-time Ray Tracing using CUDA"): its iterative
//! ray queue in place of recursion, whose fixed arrays could overflow, and its CPU emulation mode:
//!
//! 1. *Camera ray*, generation 1, through the pixel's sample ([`crate::frame::sample_offset`]). All pixels take as many,
//!    or after the first only those that differ from a neighbour (Whitted's section on aliasing).
//! 2. *Closest hit* over all instances. Equal t resolves to the lower (instance id, primitive id), so
//!    neither tree nor traversal order shows in the picture. Of things in one place under one transform, or one that
//!    differs in scale by a power of two, the lower instance is seen. Where other transforms bring surfaces to one place,
//!    each has its roundings, in f64 too, and what is seen changes from pixel to pixel, if never from run to run: t cannot
//!    tell them from surfaces that lie so close, whose order it must keep, and a tolerance would not order three of
//!    them. They need one transform, or a distance. The primitive a ray starts on is left out by
//!    id (curved ones answer with their other root); origins are moved off the surface along its normal by
//!    a bound on the hit point's rounding error (pbrt-v4, 6.8), never by a length out of the air.
//! 3. *Local light* (POV-Ray 3.7's model, see [`crate::world::Material`]): emission, and for each light with N.L > 1e-10 a
//!    shadow ray. Opaque surfaces end it; transparent ones multiply in order of (t, id).
//! 4. *Refraction and reflection*, each a ray of the next generation. With eta = n_from / n_to and
//!    c = -D.N the refracted direction is eta D + (eta c - sqrt(1 - eta^2 (1 - c^2))) N; a negative root
//!    is total internal reflection, of weight 1. Index ratios come from the list of media the ray is
//!    inside of, innermost last: leaving one that is not the innermost changes nothing. Where the two
//!    indices agree the ray goes straight on in its generation.
//! 5. Of two rays one is followed and one deferred. The deferred one belongs to the hit's generation, and
//!    the followed subtree ends before it is taken up, so one slot a generation is enough: the stack
//!    cannot overflow. (Straight-through and reflection: the straight one is deferred.)
//! 6. A ray past the last generation is black; a miss sees the background.
//! 7. With a cut-off, a ray too faint to matter is not followed, and a light too faint to matter not asked for, within a proven
//!    bound on the pixel's error (Hall and Greenberg 1983; `cpu/cutoff.rs`). The reference follows every ray.

mod choose;
mod counters;
pub mod cpu;
mod device;
pub mod gpu;
mod hierarchy;
mod pack;
mod picture;
mod progress;
pub mod reference;
mod systems;

pub use choose::{BackendChoice, open_tracer};
pub use counters::Counters;
pub use device::{DeviceClock, DevicePass, DeviceReport, Upload};
pub use hierarchy::{Form, Hierarchy, Level, Owner, Volume};
pub use pack::PackedScene;
pub use picture::Picture;
pub use systems::{ActiveTracer, OtherPasses, TraceFault, plugin};

use std::fmt;
use std::sync::Arc;

use glam::{UVec2, Vec3};

use crate::frame::{FrameScene, TraceSettings};

/// Which tracer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Backend {
    /// Compute shaders.
    Gpu,
    /// All cores, f32.
    Cpu,
    /// f64, unhurried.
    Reference,
}

impl Backend {
    /// All, in order of speed.
    pub const ALL: [Self; 3] = [Self::Gpu, Self::Cpu, Self::Reference];
}

impl fmt::Display for Backend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Gpu => "gpu",
            Self::Cpu => "cpu",
            Self::Reference => "reference",
        })
    }
}

/// A ray relative to the render origin (the eye of the last uploaded frame). Hits have t in (t_min, t_max).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start.
    pub origin: Vec3,
    /// Direction of any length but zero; t counts in its length.
    pub dir: Vec3,
    /// Lower end, exclusive.
    pub t_min: f32,
    /// Upper end, exclusive.
    pub t_max: f32,
}

/// What is asked of rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Query {
    /// The nearest hit; equal t resolves to the lower (instance, primitive).
    Closest,
    /// Whether there is a hit at all (transparent or not).
    Any,
    /// Whether rays come off what they start on, as reflected, refracted and shadow rays must. Rays come in
    /// pairs: the first is answered as [`Query::Closest`]; the second leaves from there (what its `origin` says
    /// is not read), its `dir` given in a frame of the surface whose z is the normal on the side that was
    /// met. Where the first misses the second does. A ray without a second is answered with a miss.
    Leave,
}

/// What a ray met. A miss has t = infinity and `instance == u32::MAX`; an [`Query::Any`] hit has t = 0
/// and instance 1, its miss t = infinity and instance 0 (the rivals' format).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// In lengths of the ray's direction.
    pub t: f64,
    /// Row of `FrameScene::instances`.
    pub instance: u32,
    /// Primitive of the instance.
    pub prim: u32,
    /// Barycentric weights of a triangle's second and third corner; 0 for other shapes.
    pub uv: [f64; 2],
}

impl Hit {
    /// No hit of a closest query.
    pub const MISS: Self = Self {
        t: f64::INFINITY,
        instance: u32::MAX,
        prim: u32::MAX,
        uv: [0.0; 2],
    };

    /// The answer of an any-hit query.
    pub fn any(occluded: bool) -> Self {
        Self {
            t: if occluded { 0.0 } else { f64::INFINITY },
            instance: u32::from(occluded),
            prim: 0,
            uv: [0.0; 2],
        }
    }
}

/// Time of one pass of the last picture.
#[derive(Clone, Debug, PartialEq)]
pub struct PassTime {
    /// Name of the pass, as its shader file or step is called.
    pub name: &'static str,
    /// Milliseconds, by the device's timestamps on a GPU.
    pub millis: f64,
    /// When it began, of a pass on the host; none: on the device, or only how long it took is known.
    pub start: Option<std::time::Instant>,
}

impl PassTime {
    /// A pass on the host that ends now.
    pub fn since(name: &'static str, start: std::time::Instant) -> Self {
        Self {
            name,
            millis: start.elapsed().as_secs_f64() * 1e3,
            start: Some(start),
        }
    }
}

/// What a picture from its start took where its rays are traced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureTime {
    /// Pixels across and down.
    pub size: UVec2,
    /// Milliseconds of its rays.
    pub rays: f64,
}

/// The processor and the threads that trace on it, in words.
pub(crate) fn host_description() -> String {
    let model = std::fs::read_to_string("/proc/cpuinfo")
        .ok()
        .and_then(|text| {
            let line = text.lines().find(|line| line.starts_with("model name"))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        });
    let model = model.unwrap_or_else(|| std::env::consts::ARCH.to_owned());
    format!("{model}, {} threads", rayon::current_num_threads())
}

/// The error of asking for a picture before one was traced.
pub(crate) fn no_picture_yet() -> TraceError {
    TraceError::Device("no picture has been traced yet".into())
}

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq)]
pub enum TraceError {
    /// No device that could do it; the sentence says what was tried and what to do.
    NoDevice(String),
    /// The scene is larger than a limit of the device.
    TooLarge(String),
    /// The device failed.
    Device(String),
    /// The device is gone for good, with all that was on it: [`Tracer::recover`].
    DeviceLost(String),
}

impl fmt::Display for TraceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (Self::NoDevice(why) | Self::TooLarge(why) | Self::Device(why) | Self::DeviceLost(why)) =
            self;
        f.write_str(why)
    }
}

impl std::error::Error for TraceError {}

/// A way to the picture. The three steps are those of the frame: refit, upload, render.
pub trait Tracer: Send + Sync {
    /// Which one this is.
    fn backend(&self) -> Backend;

    /// The device in words: processor and threads, or adapter, driver and API.
    fn device(&self) -> String;

    /// The frame whose steps follow, as the clock counts frames: what a device tells later bears its number.
    fn begin_frame(&mut self, _frame: u64) {}

    /// Builds or refits the trees whose geometry changed since the last call.
    ///
    /// # Errors
    /// See [`TraceError`].
    fn refit(&mut self, scene: &FrameScene) -> Result<(), TraceError>;

    /// Packs the frame's rows and brings them to where rays are traced.
    ///
    /// # Errors
    /// See [`TraceError`].
    fn upload(&mut self, scene: &FrameScene, settings: &TraceSettings) -> Result<(), TraceError>;

    /// Traces the picture of the uploaded frame. On a GPU this submits; [`Tracer::picture`] waits.
    ///
    /// # Errors
    /// See [`TraceError`].
    fn render(&mut self) -> Result<(), TraceError>;

    /// The last picture, on the host.
    ///
    /// # Errors
    /// See [`TraceError`]; [`TraceError::Device`] before the first [`Tracer::render`].
    fn picture(&mut self) -> Result<Picture, TraceError>;

    /// From now on no frame waits for a compiler where something more general will do meanwhile: for those who play. The
    /// first picture with a kernel of its own may differ by roundings from the one before.
    fn compile_in_background(&mut self) {}

    /// Goes on on another device in place of one that was lost: on this one, or else on the same adapter opened anew. The
    /// next frame brings everything there, and its picture is what it would have been. The host is not lost.
    ///
    /// # Errors
    /// [`TraceError::NoDevice`] if the adapter is no longer there or does not open.
    fn recover(&mut self, _gpu: Option<Arc<gpu::Gpu>>) -> Result<(), TraceError> {
        Ok(())
    }

    /// The last picture where the GPU left it, for presenting without a copy; none on the host's tracers.
    fn device_picture(&self) -> Option<gpu::DevicePicture> {
        None
    }

    /// Answers rays against the uploaded frame, in order.
    ///
    /// # Errors
    /// See [`TraceError`].
    fn intersect(&mut self, rays: &[Ray], query: Query) -> Result<Vec<Hit>, TraceError>;

    /// Milliseconds that [`Tracer::intersect`] takes where rays are traced, run after run: on a GPU of the kernel alone, by
    /// the device's timestamps, without the rays' way there and back.
    ///
    /// # Errors
    /// See [`TraceError`].
    fn time_rays(
        &mut self,
        rays: &[Ray],
        query: Query,
        runs: usize,
    ) -> Result<Vec<f64>, TraceError> {
        let timed = |_| {
            let start = std::time::Instant::now();
            self.intersect(rays, query)?;
            Ok(start.elapsed().as_secs_f64() * 1e3)
        };
        (0..runs).map(timed).collect()
    }

    /// A level of the trees of the uploaded frame: of all of them, or alone of the mesh that this row of
    /// `FrameScene::instances` shows if it shows one. At most `most` volumes, those that look largest; none: a tracer that
    /// keeps trees of another kind.
    fn hierarchy(&self, _level: Level, _alone: Option<u32>, _most: usize) -> Option<Hierarchy> {
        None
    }

    /// Samples that every pixel of the picture has; those of edges may have more. They grow while a picture refines.
    fn samples(&self) -> u32;

    /// What the last picture took. On a GPU: of the last picture that has come back.
    fn counters(&self) -> Counters;

    /// Times of the last picture's passes, in order. On a GPU: of the last picture that has come back.
    fn pass_times(&self) -> Vec<PassTime>;

    /// What a device has told since the last call of the frames it worked for; those of earlier frames come late.
    fn take_device_reports(&mut self) -> Vec<DeviceReport> {
        Vec::new()
    }

    /// Bytes written for the last frame, buffer by buffer.
    fn uploads(&self) -> Vec<Upload> {
        let bytes = self.counters().bytes_uploaded;
        let buffer = "rows";
        vec![Upload { buffer, bytes }]
    }

    /// What a picture from its start took, if that is new in this frame: not of a sample that refined one, not of a frame
    /// that rested.
    fn timed_picture(&self) -> Option<PictureTime>;

    /// Milliseconds that the device worked on the last picture that has come back, and on its trees; none: the host works.
    fn device_millis(&self) -> Option<f64> {
        None
    }

    /// Whether rays are traced by the processor, be it as software Vulkan.
    fn runs_on_processor(&self) -> bool {
        true
    }
}
