//! [`GpuTracer`]: the frame's three steps on the device.

use std::sync::Arc;
use std::time::Instant;

use super::DevicePicture;
use super::canvas::Canvas;
use super::context::Gpu;
use super::layout::Layouts;
use super::pace::Pace;
use super::pipelines::Pipelines;
use super::rays::RayBuffers;
use super::report::{Report, Reports, Traced};
use super::shader::{Kernel, Specialisation};
use super::stack::StackNeed;
use super::trees::{DeviceTrees, Plan};
use super::upload::SceneOnDevice;
use crate::frame::wire::CounterRow;
use crate::frame::{Features, FrameScene, Skip, TraceSettings};
use crate::trace::progress::{Due, Progress};
use crate::trace::{
    Backend, Counters, DeviceClock, DevicePass, DeviceReport, Hierarchy, Hit, Level, PackedScene,
    PassTime, Picture, PictureTime, Query, Ray, TraceError, Tracer, Upload, no_picture_yet,
};

/// Reports that are kept for whoever takes them.
const MOST_TOLD: usize = 64;

/// Traces with compute shaders.
pub struct GpuTracer {
    pub(super) gpu: Arc<Gpu>,
    pub(super) layouts: Layouts,
    pub(super) packed: PackedScene,
    pub(super) on_device: SceneOnDevice,
    pub(super) pipelines: Pipelines,
    pub(super) special: Option<Specialisation>,
    /// Of a traversal's stack, by the trees up to now.
    stack: StackNeed,
    pub(super) rays: Option<RayBuffers>,
    /// None before the first picture.
    pub(super) canvas: Option<Canvas>,
    progress: Progress,
    pub(super) reports: Reports,
    /// The frame's number.
    pub(super) frame: u64,
    /// Bytes written for this frame.
    uploads: Vec<Upload>,
    /// What has come back and nobody took.
    told: Vec<DeviceReport>,
    counters: Counters,
    host_passes: Vec<PassTime>,
    pub(super) device_millis: Option<f64>,
    /// Milliseconds of the device on edges.
    edges_millis: Option<f64>,
    /// What came in this frame of a picture from its start.
    pub(super) timed_picture: Option<PictureTime>,
    pub(super) pace: Pace,
    /// Pictures traced, for those of which the host takes the time.
    pub(super) pictures: u64,
    trees: DeviceTrees,
    /// Milliseconds of the device on trees.
    tree_millis: Option<f64>,
}

impl GpuTracer {
    /// A tracer on an open device.
    ///
    /// # Errors
    /// [`TraceError::Device`].
    pub fn new(gpu: Arc<Gpu>) -> Result<Self, TraceError> {
        let layouts = Layouts::new(&gpu);
        let tracer = Self {
            on_device: SceneOnDevice::new(&gpu, &layouts),
            reports: Reports::new(&gpu, [Kernel::Whitted.name(), Kernel::Antialias.name()]),
            frame: 0,
            uploads: Vec::new(),
            told: Vec::new(),
            layouts,
            packed: PackedScene::for_device(),
            trees: DeviceTrees::new(Arc::clone(&gpu)),
            tree_millis: None,
            pipelines: Pipelines::default(),
            special: None,
            stack: StackNeed::default(),
            rays: None,
            canvas: None,
            progress: Progress::default(),
            counters: Counters::default(),
            host_passes: Vec::new(),
            device_millis: None,
            edges_millis: None,
            timed_picture: None,
            pace: Pace::default(),
            pictures: 0,
            gpu,
        };
        tracer.gpu.check()?;
        Ok(tracer)
    }

    /// Nothing is traced and nothing is on its way.
    fn rest(&mut self) {
        self.counters = Counters {
            bytes_uploaded: self.counters.bytes_uploaded,
            trees_updated: self.counters.trees_updated,
            tree_nodes: self.counters.tree_nodes,
            trees_kept: self.counters.trees_kept,
            bytes_kept: self.counters.bytes_kept,
            missing_features: self.counters.missing_features,
            kept_samples: self.canvas.as_ref().map_or(0, |canvas| {
                u64::from(canvas.size.element_product()) * u64::from(self.progress.samples())
            }),
            ..Counters::default()
        };
        self.device_millis = None;
        self.edges_millis = None;
        self.tree_millis = None;
    }

    /// Brings the device up to the packed frame; returns the bytes written.
    fn write_changes(&mut self) -> Result<u64, TraceError> {
        let rows = self
            .on_device
            .upload(&self.gpu, &self.layouts, &mut self.packed)?;
        let trees = self.update_trees()?;
        self.uploads = self.on_device.take_written();
        self.uploads.push(Upload {
            buffer: "deformations",
            bytes: trees,
        });
        self.gpu.check()?;
        Ok(rows + trees)
    }

    /// Has the device deform and refit what is deformed otherwise than before, and build the tree over instances
    /// where that is its part; returns the bytes written.
    fn update_trees(&mut self) -> Result<u64, TraceError> {
        if let Some(report) = self.trees.collect() {
            self.tree_millis = report.millis;
            for (frame, pass) in report.passes {
                tell(&mut self.told, frame, vec![pass], None);
            }
            for (row, cost) in report.costs {
                if let Some(mesh) = self.packed.meshes.get_mut(row as usize) {
                    mesh.note_cost(cost);
                }
            }
        }
        let mut plan = Plan::default();
        let rows = self.on_device.take_undeformed();
        let buffers = self.on_device.tree_buffers();
        self.trees
            .update_meshes(&mut plan, buffers, &rows, &self.packed.meshes)?;
        let root = self.packed.instance_nodes_start();
        if let Some(boxes) = self.packed.instances.take_boxes_to_build() {
            self.trees
                .build_instances(&mut plan, buffers, boxes, root)?;
        }
        self.trees.submit(&plan, self.frame)
    }

    fn take_report(&mut self) {
        let told = &mut self.told;
        let each = |frame, report: &Report, passes| {
            tell(told, frame, passes, Some(rays_of(&report.counters)));
        };
        if let Some(report) = self.reports.collect(&self.gpu, each) {
            (self.device_millis, self.edges_millis) = (report.millis, report.edges_millis);
            if let Some(millis) = report.millis {
                let Traced { epoch, samples, .. } = report.traced;
                self.pace.note(epoch, samples, millis);
                self.note_time(report.traced, millis + report.edges_millis.unwrap_or(0.0));
            }
            self.counters.kept_samples = 0;
            self.counters = self.counters.with_rays_of(rays_of(&report.counters));
        }
    }
}

impl Tracer for GpuTracer {
    fn backend(&self) -> Backend {
        Backend::Gpu
    }

    fn device(&self) -> String {
        self.gpu.describe()
    }

    fn begin_frame(&mut self, frame: u64) {
        self.frame = frame;
    }

    fn uploads(&self) -> Vec<Upload> {
        self.uploads.clone()
    }

    fn take_device_reports(&mut self) -> Vec<DeviceReport> {
        std::mem::take(&mut self.told)
    }

    fn refit(&mut self, scene: &FrameScene) -> Result<(), TraceError> {
        let start = Instant::now();
        self.packed.refit(scene);
        self.host_passes = vec![PassTime::since("mesh trees", start)];
        self.gpu.check()
    }

    fn upload(&mut self, scene: &FrameScene, settings: &TraceSettings) -> Result<(), TraceError> {
        let start = Instant::now();
        self.packed.pack(scene, settings);
        self.progress.note(self.packed.has_changed, settings);
        self.host_passes
            .push(PassTime::since("rows and instance tree", start));
        self.host_passes.push(self.packed.tree_time());
        if !settings.skips.has(Skip::Uploads) {
            self.packed.lose_copy();
        }
        let start = Instant::now();
        let written = self.write_changes().map_err(|error| {
            // Whatever did get there, the next frame brings everything.
            self.packed.lose_copy();
            with_size(error, scene)
        })?;
        self.host_passes.push(PassTime::since("upload", start));
        self.counters.bytes_uploaded = written;
        self.counters.bytes_kept = self.packed.bytes().saturating_sub(written);
        self.counters.trees_updated = self.packed.trees_updated;
        self.counters.trees_kept = self.packed.trees_kept();
        self.counters.tree_nodes = self.packed.tree_nodes_written();
        let generations = self.packed.view.max_generations;
        let mut features = scene.features;
        // A tree that had more in it may still have another form.
        features.instances |= !self.packed.is_one_mesh();
        let missing = Features::NAMED.len() - features.count();
        self.counters.missing_features = missing as u64;
        if !settings.skips.has(Skip::Kernels) {
            features = Features::all();
            self.counters.missing_features = 0;
        }
        let has_texels = self.on_device.texels.group.is_some();
        features.textures &= has_texels;
        features.panorama &= has_texels;
        let special = Specialisation::new(features, generations);
        let need = self.stack.note(self.packed.stack_bound());
        let special = Specialisation {
            cutoff: self.packed.view.cutoff > 0.0,
            counts: settings.count_rays,
            ..special
                .with(settings.kernels)
                .skipping(settings.skips)
                .with_stack(need)
        };
        if self.special.replace(special) != Some(special) {
            self.pace.forget();
        }
        Ok(())
    }

    fn render(&mut self) -> Result<(), TraceError> {
        let special = self.special.ok_or_else(nothing_uploaded)?;
        let view = self.packed.view;
        let steps: Vec<Due> = self.progress.steps(&view).collect();
        self.timed_picture = None;
        if self.reports.is_waiting() {
            // Reports of earlier pictures; an error here shows in `check` below.
            let _ = self.gpu.device.poll(wgpu::PollType::Poll);
            self.take_report();
        } else if steps.is_empty() {
            self.rest();
        }
        for &due in &steps {
            let traced = self.bring_to(due, special, &view);
            if traced.is_err() {
                // What there is, if anything, is not to be refined.
                self.progress.lose();
            }
            traced?;
            self.progress.done(due, &view);
        }
        self.gpu.check()
    }

    fn picture(&mut self) -> Result<Picture, TraceError> {
        let canvas = self.canvas.as_mut().ok_or_else(no_picture_yet)?;
        let picture = canvas.picture(&self.gpu)?;
        self.take_report();
        Ok(picture)
    }

    fn compile_in_background(&mut self) {
        let texels = &mut self.on_device.texels;
        // Where nothing can be bound for textures, asking waits for the compiler as it did.
        if texels.bind_always(&self.gpu, &self.layouts).is_ok() {
            self.pipelines.compile_in_background(&self.gpu);
        }
    }

    fn recover(&mut self, gpu: Option<Arc<Gpu>>) -> Result<(), TraceError> {
        let gpu = match gpu {
            Some(gpu) => gpu,
            None => Arc::new(self.gpu.reopened()?),
        };
        let mut anew = Self::new(gpu)?;
        // What the host packed is as good as before; the device has none of it.
        std::mem::swap(&mut anew.packed, &mut self.packed);
        anew.packed.lose_copy();
        if self.pipelines.is_in_background() {
            anew.compile_in_background();
        }
        anew.pace = self.pace.after_loss();
        anew.frame = self.frame;
        anew.progress = self.progress;
        anew.progress.lose();
        *self = anew;
        Ok(())
    }

    fn device_picture(&self) -> Option<DevicePicture> {
        let canvas = self.canvas.as_ref()?;
        Some(DevicePicture {
            size: canvas.size,
            pixels: canvas.pixels.clone(),
        })
    }

    fn intersect(&mut self, rays: &[Ray], query: Query) -> Result<Vec<Hit>, TraceError> {
        self.answer_rays(rays, query)
    }

    fn time_rays(
        &mut self,
        rays: &[Ray],
        query: Query,
        runs: usize,
    ) -> Result<Vec<f64>, TraceError> {
        self.time_on_device(rays, query, runs)
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

    fn timed_picture(&self) -> Option<PictureTime> {
        self.timed_picture
    }

    fn device_millis(&self) -> Option<f64> {
        let passes = [self.tree_millis, self.device_millis, self.edges_millis];
        Some(passes.into_iter().flatten().sum())
    }

    fn runs_on_processor(&self) -> bool {
        self.gpu.is_software()
    }

    fn pass_times(&self) -> Vec<PassTime> {
        let pass = |name, millis: Option<f64>| {
            let start = None;
            millis.map(|millis| PassTime {
                name,
                millis,
                start,
            })
        };
        let trees = pass("trees", self.tree_millis);
        let picture = pass(Kernel::Whitted.name(), self.device_millis);
        let host = self.host_passes.iter().cloned();
        let edges = pass(Kernel::Antialias.name(), self.edges_millis);
        host.chain(trees).chain(picture).chain(edges).collect()
    }
}

/// What a kernel counted.
fn rays_of(row: &CounterRow) -> Counters {
    Counters {
        primary_rays: u64::from(row.primary_rays),
        reflected_rays: u64::from(row.reflected_rays),
        refracted_rays: u64::from(row.refracted_rays),
        shadow_rays: u64::from(row.shadow_rays),
        media_overflows: u64::from(row.media_overflows),
        straight_overflows: u64::from(row.straight_overflows),
        dropped_rays: u64::from(row.dropped_rays),
        edge_pixels: u64::from(row.edge_pixels),
        away_shadows: u64::from(row.away_shadows),
        black_shadows: u64::from(row.black_shadows),
        faint_shadows: u64::from(row.faint_shadows),
        weightless_rays: u64::from(row.weightless_rays),
        ..Counters::default()
    }
}

/// Keeps what came back of a frame until somebody takes it; of what nobody takes, the newest.
fn tell(told: &mut Vec<DeviceReport>, frame: u64, passes: Vec<DevicePass>, rays: Option<Counters>) {
    if told.len() >= MOST_TOLD {
        told.remove(0);
    }
    told.push(DeviceReport {
        frame,
        clock: DeviceClock::Tracer,
        passes,
        rays,
    });
}

/// A scene that is too large, with how large it is and what to do.
fn with_size(error: TraceError, scene: &FrameScene) -> TraceError {
    match error {
        TraceError::TooLarge(why) => TraceError::TooLarge(format!(
            "{why}. The scene has {}. `--backend cpu` has no such limit; on this one it takes fewer things, or simpler meshes",
            scene.size_in_words()
        )),
        other => other,
    }
}

/// What a tracer without a frame says.
pub(super) fn nothing_uploaded() -> TraceError {
    TraceError::Device("no frame has been uploaded yet".into())
}
