//! [`GpuTracer`]: the frame's three steps on the device.

use std::sync::Arc;
use std::time::Instant;

use glam::UVec2;

use super::DevicePicture;
use super::canvas::{Canvas, Pass, passes};
use super::context::Gpu;
use super::layout::Layouts;
use super::pipelines::Pipelines;
use super::rays::RayBuffers;
use super::report::{COUNTERS, Ends, Reports};
use super::shader::{Kernel, Specialisation};
use super::trees::{DeviceTrees, Plan};
use super::upload::SceneOnDevice;
use crate::frame::wire::ViewRow;
use crate::frame::{FrameScene, TraceSettings};
use crate::trace::progress::{Due, Progress};
use crate::trace::{
    Backend, Counters, Hierarchy, Hit, Level, PackedScene, PassTime, Picture, PictureTime, Query,
    Ray, TraceError, Tracer, no_picture_yet,
};

/// Traces with compute shaders.
pub struct GpuTracer {
    pub(super) gpu: Arc<Gpu>,
    pub(super) layouts: Layouts,
    pub(super) packed: PackedScene,
    pub(super) on_device: SceneOnDevice,
    pub(super) pipelines: Pipelines,
    pub(super) special: Option<Specialisation>,
    pub(super) rays: Option<RayBuffers>,
    /// None before the first picture.
    canvas: Option<Canvas>,
    progress: Progress,
    reports: Reports,
    counters: Counters,
    host_passes: Vec<PassTime>,
    device_millis: Option<f64>,
    /// Milliseconds of the device on edges.
    edges_millis: Option<f64>,
    /// What came in this frame of a picture from its start.
    timed_picture: Option<PictureTime>,
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
            reports: Reports::new(&gpu),
            layouts,
            packed: PackedScene::for_device(),
            trees: DeviceTrees::new(Arc::clone(&gpu)),
            tree_millis: None,
            pipelines: Pipelines::default(),
            special: None,
            rays: None,
            canvas: None,
            progress: Progress::default(),
            counters: Counters::default(),
            host_passes: Vec::new(),
            device_millis: None,
            edges_millis: None,
            timed_picture: None,
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
        self.gpu.check()?;
        Ok(rows + trees)
    }

    /// Has the device deform and refit what is deformed otherwise than before, and build the tree over instances
    /// where that is its part; returns the bytes written.
    fn update_trees(&mut self) -> Result<u64, TraceError> {
        if let Some(report) = self.trees.collect() {
            self.tree_millis = report.millis;
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
        self.trees.submit(&plan)
    }

    fn take_report(&mut self) {
        if let Some(report) = self.reports.collect(&self.gpu) {
            let counters = report.counters;
            (self.device_millis, self.edges_millis) = (report.millis, report.edges_millis);
            if let Some(millis) = report.millis {
                let rays = millis + report.edges_millis.unwrap_or(0.0);
                self.packed.instances.note_trace_time(rays * 1e6);
                self.timed_picture = report.whole.map(|size| PictureTime { size, rays });
            }
            self.counters = Counters {
                primary_rays: u64::from(counters.primary_rays),
                reflected_rays: u64::from(counters.reflected_rays),
                refracted_rays: u64::from(counters.refracted_rays),
                shadow_rays: u64::from(counters.shadow_rays),
                media_overflows: u64::from(counters.media_overflows),
                straight_overflows: u64::from(counters.straight_overflows),
                dropped_rays: u64::from(counters.dropped_rays),
                edge_pixels: u64::from(counters.edge_pixels),
                ..self.counters
            };
        }
    }

    /// Brings the picture to what is due.
    fn bring_to(
        &mut self,
        due: Due,
        special: Specialisation,
        view: &ViewRow,
    ) -> Result<(), TraceError> {
        let (gpu, reports) = (&self.gpu, &mut self.reports);
        Canvas::fit(&mut self.canvas, gpu, &self.layouts, reports, view)?;
        // Should it fail, what it holds is no picture.
        if let Some(canvas) = self.canvas.take() {
            let whole = (due == Due::Picture).then_some(canvas.size);
            self.submit(special, &canvas, &passes(view, due), whole)?;
            self.canvas = Some(canvas);
        }
        self.gpu.check()
    }

    /// One submission a pass, so that no single one is long.
    fn submit(
        &mut self,
        special: Specialisation,
        canvas: &Canvas,
        passes: &[Pass],
        whole: Option<UVec2>,
    ) -> Result<(), TraceError> {
        let kernels = [Kernel::Whitted, Kernel::Edges, Kernel::Antialias];
        let mut compiled = Vec::new();
        for kernel in kernels {
            if passes.iter().any(|pass| pass.kernel == kernel) {
                let pipelines = &mut self.pipelines;
                let pipeline = pipelines.get(&self.gpu, &self.layouts, kernel, special)?;
                compiled.push((kernel, pipeline));
            }
        }
        let rows: Vec<_> = passes.iter().map(|pass| pass.row).collect();
        let offsets = self
            .on_device
            .write_passes(&self.gpu, &self.layouts, &rows)?;
        for (i, (work, offset)) in passes.iter().zip(offsets).enumerate() {
            let next = passes.get(i + 1).map(|next| next.kernel);
            let ends = match (work.kernel, next) {
                (Kernel::Whitted, next) if next != Some(Kernel::Whitted) => Some(Ends::Picture),
                (_, None) => Some(Ends::Edges),
                _ => None,
            };
            let mut encoder = self
                .gpu
                .device
                .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            if i == 0 {
                encoder.clear_buffer(&self.reports.counters, 0, Some(COUNTERS));
            }
            {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label: Some(work.kernel.name()),
                    timestamp_writes: self.reports.writes(i == 0, ends),
                });
                for (_, pipeline) in compiled.iter().filter(|(kernel, _)| *kernel == work.kernel) {
                    pass.set_pipeline(&pipeline.compute);
                }
                pass.set_bind_group(0, &self.on_device.frame, &[offset]);
                pass.set_bind_group(1, &self.on_device.scene, &[]);
                pass.set_bind_group(2, &canvas.group, &[]);
                if let Some(texels) = &self.on_device.texels.group {
                    pass.set_bind_group(3, texels, &[]);
                }
                pass.dispatch_workgroups(work.groups[0], work.groups[1], 1);
            }
            let last = ends.filter(|_| next.is_none());
            let report = last.and_then(|last| self.reports.record(&mut encoder, last));
            self.gpu.queue.submit([encoder.finish()]);
            if let Some(slot) = report {
                self.reports.mark(slot, whole);
                self.reports.request(slot);
            }
        }
        Ok(())
    }
}

impl Tracer for GpuTracer {
    fn backend(&self) -> Backend {
        Backend::Gpu
    }

    fn device(&self) -> String {
        self.gpu.describe()
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
        let start = Instant::now();
        let written = self.write_changes();
        if written.is_err() {
            // Whatever did get there, the next frame brings everything.
            self.packed.lose_copy();
        }
        let written = written?;
        self.host_passes.push(PassTime::since("upload", start));
        self.counters.bytes_uploaded = written;
        self.counters.trees_updated = self.packed.trees_updated;
        self.counters.tree_nodes = self.packed.tree_nodes_written();
        let generations = self.packed.view.max_generations;
        let mut features = scene.features;
        let has_texels = self.on_device.texels.group.is_some();
        features.textures &= has_texels;
        features.panorama &= has_texels;
        let special = Specialisation::new(features, generations);
        self.special = Some(Specialisation {
            cutoff: self.packed.view.cutoff > 0.0,
            ..special.with(settings.kernels)
        });
        Ok(())
    }

    fn render(&mut self) -> Result<(), TraceError> {
        let special = self.special.ok_or_else(nothing_uploaded)?;
        let view = self.packed.view;
        let due = self.progress.due();
        self.timed_picture = None;
        if self.reports.is_waiting() {
            // Reports of earlier pictures; an error here shows in `check` below.
            let _ = self.gpu.device.poll(wgpu::PollType::Poll);
            self.take_report();
        } else if due == Due::Nothing {
            self.rest();
        }
        if due == Due::Nothing {
            return self.gpu.check();
        }
        let traced = self.bring_to(due, special, &view);
        if traced.is_err() {
            // What there is, if anything, is not to be refined.
            self.progress.lose();
        }
        traced?;
        self.progress.done(due, &view);
        Ok(())
    }

    fn picture(&mut self) -> Result<Picture, TraceError> {
        let canvas = self.canvas.as_mut().ok_or_else(no_picture_yet)?;
        let picture = canvas.picture(&self.gpu)?;
        self.take_report();
        Ok(picture)
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
        let pass = |name, millis: Option<f64>| millis.map(|millis| PassTime { name, millis });
        let trees = pass("trees", self.tree_millis);
        let picture = pass(Kernel::Whitted.name(), self.device_millis);
        let host = self.host_passes.iter().cloned();
        let edges = pass(Kernel::Antialias.name(), self.edges_millis);
        host.chain(trees).chain(picture).chain(edges).collect()
    }
}

/// What a tracer without a frame says.
pub(super) fn nothing_uploaded() -> TraceError {
    TraceError::Device("no frame has been uploaded yet".into())
}
