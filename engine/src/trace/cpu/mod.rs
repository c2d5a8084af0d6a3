//! The CPU tracer: f32, every core. What the report called emulation mode; the product where there is no GPU.
//!
//! It reads the same rows as the GPU's kernel ([`PackedScene`]) and follows it file by file. Rays that are much alike go as
//! packets of 64 (`packet.rs`, `beam.rs`, `triangles.rs`), in lanes of the widest instructions there are (`simd.rs`): camera
//! rays of 8 x 8 pixels, and the shadow rays from what they meet. Others go one by one, against eight boxes or four
//! triangles at a time (`traverse.rs`, `eights.rs`). What a ray finds does not depend on the way it went.

mod beam;
mod canvas;
mod cutoff;
mod edges;
mod eights;
mod enter;
mod group;
mod light;
mod look;
mod media;
mod packet;
mod path;
mod pixel;
mod query;
mod simd;
mod sky;
mod stack;
mod surface;
mod texture;
mod traverse;
mod triangles;

pub use self::enter::{enter_boxes, enter_spheres};
pub use self::simd::Instructions;

use std::time::Instant;

use rayon::prelude::*;

use self::canvas::Canvas;
use self::packet::{PACKET, Packet, trace_all};
use self::query::{AnyHit, Found, Key, Nearest, Probe, Start, Until};
use self::stack::Stack;
use self::surface::resolve;
use self::traverse::trace;
use super::gpu::Kernel;
use super::progress::{Due, Progress, is_adaptive};
use super::{
    Backend, Counters, Hierarchy, Hit, Level, PackedScene, PassTime, Picture, PictureTime, Query,
    Ray, TraceError, Tracer,
};
use crate::frame::{FrameScene, TraceSettings};
use crate::geom::out_of_frame;

/// Rays a task takes.
const RAYS_PER_TASK: usize = 1024;

/// See the module.
#[derive(Default)]
pub struct CpuTracer {
    packed: PackedScene,
    canvas: Option<Canvas>,
    progress: Progress,
    /// Of the last frame, if it traced a picture from its start.
    timed_picture: Option<PictureTime>,
    /// Bytes of rows written for this frame.
    bytes_written: u64,
    counters: Counters,
    passes: Vec<PassTime>,
    /// Of rays that were asked for one by one; kept, since memory that is new is slow.
    answers: Vec<Option<Found>>,
    instructions: Instructions,
}

impl CpuTracer {
    /// A tracer on rayon's global pool.
    pub fn new() -> Self {
        Self::default()
    }

    /// The same with instructions other than the widest; pictures and hits are the same, bit for bit.
    pub fn with(instructions: Instructions) -> Self {
        Self {
            instructions,
            ..Self::default()
        }
    }
}

impl Tracer for CpuTracer {
    fn backend(&self) -> Backend {
        Backend::Cpu
    }

    fn device(&self) -> String {
        let instructions = self.instructions.name();
        format!("{}, {instructions}", super::host_description())
    }

    fn refit(&mut self, scene: &FrameScene) -> Result<(), TraceError> {
        let start = Instant::now();
        self.packed.refit(scene);
        self.passes = vec![PassTime::since("mesh trees", start)];
        Ok(())
    }

    fn upload(&mut self, scene: &FrameScene, settings: &TraceSettings) -> Result<(), TraceError> {
        let start = Instant::now();
        self.packed.pack(scene, settings);
        self.progress.note(self.packed.has_changed, settings);
        self.bytes_written = self.packed.keep_no_copy();
        let meshes = Instant::now();
        if self.packed.bring_lanes() > 0 {
            self.passes.push(PassTime::since("meshes by lanes", meshes));
        }
        self.passes
            .push(PassTime::since("rows and instance tree", start));
        self.passes.push(self.packed.tree_time());
        Ok(())
    }

    fn render(&mut self) -> Result<(), TraceError> {
        let start = Instant::now();
        let steps: Vec<Due> = self.progress.steps(&self.packed.view).collect();
        self.counters = self.work_done();
        for due in &steps {
            self.take(*due);
        }
        let rays = start.elapsed().as_secs_f64() * 1e3;
        let canvas = self.canvas.get_or_insert_default();
        if steps.is_empty() {
            let samples = canvas.picture.pixels.len() as u64 * u64::from(self.progress.samples());
            self.counters.kept_samples = samples;
        } else {
            self.packed.instances.note_trace_time(rays * 1e6);
        }
        self.timed_picture = steps.contains(&Due::Picture).then_some(PictureTime {
            size: canvas.picture.size,
            rays,
        });
        Ok(())
    }

    fn picture(&mut self) -> Result<Picture, TraceError> {
        let canvas = self.canvas.as_ref().filter(|_| self.progress.samples() > 0);
        let canvas = canvas.ok_or_else(super::no_picture_yet)?;
        Ok(canvas.picture.clone())
    }

    fn intersect(&mut self, rays: &[Ray], query: Query) -> Result<Vec<Hit>, TraceError> {
        self.answer(rays, query);
        let hit = |found: &Option<Found>| match query {
            Query::Any => Hit::any(found.is_some()),
            Query::Closest | Query::Leave => found.as_ref().map_or(Hit::MISS, hit_of),
        };
        Ok(self.answers.par_iter().map(hit).collect())
    }

    fn time_rays(
        &mut self,
        rays: &[Ray],
        query: Query,
        runs: usize,
    ) -> Result<Vec<f64>, TraceError> {
        let timed = |_| {
            let start = Instant::now();
            self.answer(rays, query);
            start.elapsed().as_secs_f64() * 1e3
        };
        Ok((0..runs).map(timed).collect())
    }

    fn hierarchy(&self, level: Level, alone: Option<u32>, most: usize) -> Option<Hierarchy> {
        Some(self.packed.hierarchy(level, alone, most))
    }

    fn samples(&self) -> u32 {
        self.progress.samples()
    }

    fn counters(&self) -> Counters {
        self.counters
    }

    fn pass_times(&self) -> Vec<PassTime> {
        self.passes.clone()
    }

    fn timed_picture(&self) -> Option<PictureTime> {
        self.timed_picture
    }
}

impl CpuTracer {
    /// Answers rays in order.
    fn answer(&mut self, rays: &[Ray], query: Query) {
        let packed = &self.packed;
        self.answers.resize(rays.len(), None);
        let rays = rays.par_chunks(RAYS_PER_TASK);
        let tasks = rays.zip(self.answers.par_chunks_mut(RAYS_PER_TASK));
        let kept = || (Packet::default(), Stack::with(self.instructions));
        tasks.for_each_init(kept, |(packet, stack), (rays, answers)| match query {
            Query::Any => in_packets::<AnyHit>(packed, rays, answers, packet, stack),
            Query::Closest => in_packets::<Nearest>(packed, rays, answers, packet, stack),
            Query::Leave => {
                for (pair, answers) in rays.chunks(2).zip(answers.chunks_mut(2)) {
                    let found = leave(packed, pair, stack);
                    answers.copy_from_slice(&found[..answers.len()]);
                }
            }
        });
    }

    /// Takes the picture to what is due.
    fn take(&mut self, due: Due) {
        let (packed, canvas) = (&self.packed, self.canvas.get_or_insert_default());
        canvas.instructions = self.instructions;
        let start = Instant::now();
        let mut counters = match due {
            Due::Nothing => Counters::default(),
            Due::Picture => canvas.start(packed),
            Due::Refinement { limit, by } => (0..by)
                .map(|_| canvas.refine(packed, limit))
                .fold(Counters::default(), |sum, counters| sum + counters),
        };
        self.passes
            .push(PassTime::since(Kernel::Whitted.name(), start));
        if due == Due::Picture && is_adaptive(&packed.view) {
            let start = Instant::now();
            counters = counters + canvas.antialias(packed);
            self.passes
                .push(PassTime::since(Kernel::Antialias.name(), start));
        }
        self.progress.done(due, &packed.view);
        self.counters = self.counters + counters;
    }

    /// What bringing rows and trees up to the frame took, rays aside.
    fn work_done(&self) -> Counters {
        Counters {
            trees_updated: self.packed.trees_updated,
            trees_kept: self.packed.trees_kept(),
            tree_nodes: self.packed.tree_nodes_written(),
            bytes_uploaded: self.bytes_written,
            ..Counters::default()
        }
    }
}

fn probe_of(ray: &Ray) -> Probe {
    Probe {
        origin: ray.origin,
        dir: ray.dir,
        after: Key::after(ray.t_min),
        before: Key::before(ray.t_max),
        start: Start::FREE,
    }
}

fn hit_of(found: &Found) -> Hit {
    Hit {
        t: f64::from(found.key.t),
        instance: found.key.id,
        prim: found.key.prim,
        uv: found.uv.map(f64::from),
    }
}

fn in_packets<U: Until>(
    scene: &PackedScene,
    rays: &[Ray],
    answers: &mut [Option<Found>],
    packet: &mut Packet,
    stack: &mut Stack,
) {
    let mut probes = Vec::with_capacity(PACKET);
    for (rays, answers) in rays.chunks(PACKET).zip(answers.chunks_mut(PACKET)) {
        probes.clear();
        probes.extend(rays.iter().map(probe_of));
        trace_all::<U>(scene, &probes, answers, (packet, stack));
    }
}

/// [`Query::Leave`] of a pair.
fn leave(scene: &PackedScene, pair: &[Ray], stack: &mut Stack) -> [Option<Found>; 2] {
    let [arriving, leaving] = pair else {
        return [None; 2];
    };
    let Some(found) = trace::<Nearest>(scene, &probe_of(arriving), stack) else {
        return [None; 2];
    };
    let surface = resolve(scene, &found, arriving.origin, arriving.dir);
    let dir = out_of_frame(surface.n_geom, leaving.dir);
    let (origin, start) = surface.leave_towards(dir);
    let probe = Probe {
        origin,
        dir,
        start,
        ..probe_of(leaving)
    };
    [Some(found), trace::<Nearest>(scene, &probe, stack)]
}
