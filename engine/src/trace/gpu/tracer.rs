//! [`GpuTracer`]: the frame's three steps on the device.

use std::sync::Arc;
use std::time::Instant;

use glam::{UVec2, Vec3, Vec4};

use super::DevicePicture;
use super::buffers::{create, read};
use super::context::Gpu;
use super::layout::{Layouts, bind};
use super::pipelines::{Pipeline, Pipelines};
use super::rays::RayBuffers;
use super::report::{Report, Reports};
use super::shader::{Kernel, Specialisation};
use super::trees::{DeviceTrees, Plan};
use super::upload::SceneOnDevice;
use crate::frame::wire::{PassRow, ViewRow};
use crate::frame::{FrameScene, TraceSettings};
use crate::trace::{
    Backend, Counters, Hierarchy, Hit, Level, PackedScene, PassTime, Picture, Query, Ray,
    TraceError, Tracer, no_picture_yet,
};

/// Samples of a dispatch: enough to fill a GPU many times over, few enough that a display driver's
/// watchdog (seconds) does not take a slow one for dead.
const BAND_SAMPLES: u64 = 1 << 20;

/// Traces with compute shaders.
pub struct GpuTracer {
    pub(super) gpu: Arc<Gpu>,
    pub(super) layouts: Layouts,
    pub(super) packed: PackedScene,
    pub(super) on_device: SceneOnDevice,
    pub(super) pipelines: Pipelines,
    pub(super) special: Option<Specialisation>,
    pub(super) rays: Option<RayBuffers>,
    target: Option<Target>,
    /// The frame shows something that the picture does not.
    is_due: bool,
    reports: Reports,
    counters: Counters,
    host_passes: Vec<PassTime>,
    device_millis: Option<f64>,
    trees: DeviceTrees,
    /// Milliseconds of the device on trees.
    tree_millis: Option<f64>,
}

/// The picture on the device.
struct Target {
    size: UVec2,
    pixels: wgpu::Buffer,
    group: wgpu::BindGroup,
    /// For [`Tracer::picture`]; made when first asked for.
    staging: Option<wgpu::Buffer>,
    traced: bool,
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
            target: None,
            is_due: false,
            counters: Counters::default(),
            host_passes: Vec::new(),
            device_millis: None,
            gpu,
        };
        tracer.gpu.check()?;
        Ok(tracer)
    }

    fn make_target(&mut self, size: UVec2) -> Result<(), TraceError> {
        if self
            .target
            .as_ref()
            .is_some_and(|target| target.size == size)
        {
            return Ok(());
        }
        let bytes = u64::from(size.x) * u64::from(size.y) * size_of::<Vec4>() as u64;
        let limits = self.gpu.device.limits();
        let most = limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size);
        // A workgroup covers at least a pixel each way, so this many groups always suffice.
        let longest = size.max_element();
        if bytes == 0 || bytes > most || longest > limits.max_compute_workgroups_per_dimension {
            return Err(TraceError::TooLarge(format!(
                "a picture of {} x {} pixels does not fit {}: it takes {bytes} bytes of at most {most}; ask for a smaller size",
                size.x,
                size.y,
                self.gpu.describe()
            )));
        }
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let pixels = create(&self.gpu, "pixels", usage, bytes);
        let buffers = [&pixels, &self.reports.counters];
        self.target = Some(Target {
            size,
            group: bind(&self.gpu, "picture", &self.layouts.picture, &buffers),
            pixels,
            staging: None,
            traced: false,
        });
        Ok(())
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
        if let Some(Report { counters, millis }) = self.reports.collect(&self.gpu) {
            self.device_millis = millis;
            if let Some(millis) = millis {
                self.packed.instances.note_trace_time(millis * 1e6);
            }
            self.counters = Counters {
                primary_rays: u64::from(counters.primary_rays),
                reflected_rays: u64::from(counters.reflected_rays),
                refracted_rays: u64::from(counters.refracted_rays),
                shadow_rays: u64::from(counters.shadow_rays),
                media_overflows: u64::from(counters.media_overflows),
                straight_overflows: u64::from(counters.straight_overflows),
                dropped_rays: u64::from(counters.dropped_rays),
                ..self.counters
            };
        }
    }

    /// One submission a band, so that no single one is long.
    fn submit_bands(
        &self,
        pipeline: &Pipeline,
        target: &Target,
        bands: &[PassRow],
        offsets: &[u32],
    ) {
        for (i, (band, offset)) in bands.iter().zip(offsets).enumerate() {
            let (first, last) = (i == 0, i + 1 == bands.len());
            let mut encoder = self
                .gpu
                .device
                .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            if first {
                encoder.clear_buffer(&self.reports.counters, 0, None);
            }
            {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label: Some(Kernel::Whitted.name()),
                    timestamp_writes: self.reports.writes(first, last),
                });
                pass.set_pipeline(&pipeline.compute);
                pass.set_bind_group(0, &self.on_device.frame, &[*offset]);
                pass.set_bind_group(1, &self.on_device.scene, &[]);
                pass.set_bind_group(2, &target.group, &[]);
                let [wide, high, _] = pipeline.workgroup;
                pass.dispatch_workgroups(
                    target.size.x.div_ceil(wide),
                    band.count.div_ceil(high),
                    1,
                );
            }
            let report = last.then(|| self.reports.record(&mut encoder)).flatten();
            self.gpu.queue.submit([encoder.finish()]);
            if let Some(slot) = report {
                self.reports.request(slot);
            }
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

    fn refit(&mut self, scene: &FrameScene) -> Result<(), TraceError> {
        let start = Instant::now();
        self.packed.refit(scene);
        self.host_passes = vec![PassTime::since("mesh trees", start)];
        self.gpu.check()
    }

    fn upload(&mut self, scene: &FrameScene, settings: &TraceSettings) -> Result<(), TraceError> {
        let start = Instant::now();
        self.packed.pack(scene, settings);
        self.is_due |= self.packed.has_changed;
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
        let special = Specialisation::new(scene.features, generations);
        self.special = Some(Specialisation {
            cutoff: self.packed.view.cutoff > 0.0,
            ..special.with(settings.kernels)
        });
        Ok(())
    }

    fn render(&mut self) -> Result<(), TraceError> {
        let special = self.special.ok_or_else(nothing_uploaded)?;
        let view = self.packed.view;
        if self.reports.is_waiting() {
            // Reports of earlier pictures; an error here shows in `check` below.
            let _ = self.gpu.device.poll(wgpu::PollType::Poll);
            self.take_report();
        } else if !self.is_due {
            self.rest();
        }
        if !self.is_due {
            return self.gpu.check();
        }
        self.make_target(UVec2::new(view.width, view.height))?;
        let kernel = Kernel::Whitted;
        let pipeline = self
            .pipelines
            .get(&self.gpu, &self.layouts, kernel, special)?;
        let bands = bands(&view, pipeline.workgroup[1]);
        let offsets = self
            .on_device
            .write_passes(&self.gpu, &self.layouts, &bands)?;
        if let Some(mut target) = self.target.take() {
            self.submit_bands(&pipeline, &target, &bands, &offsets);
            target.traced = true;
            self.target = Some(target);
        }
        self.gpu.check()?;
        self.is_due = false;
        Ok(())
    }

    fn picture(&mut self) -> Result<Picture, TraceError> {
        let target = self.target.as_mut().filter(|target| target.traced);
        let target = target.ok_or_else(no_picture_yet)?;
        let gpu = &self.gpu;
        let staging = target.staging.get_or_insert_with(|| {
            let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
            create(gpu, "picture on its way", usage, target.pixels.size())
        });
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(&target.pixels, 0, staging, 0, target.pixels.size());
        gpu.queue.submit([encoder.finish()]);
        let bytes = read(gpu, staging)?;
        let pixels = bytes
            .chunks_exact(size_of::<Vec4>())
            .map(|pixel| {
                let [r, g, b, _]: [f32; 4] = bytemuck::pod_read_unaligned(pixel);
                Vec3::new(r, g, b)
            })
            .collect();
        let size = target.size;
        self.take_report();
        Ok(Picture { size, pixels })
    }

    fn device_picture(&self) -> Option<DevicePicture> {
        let target = self.target.as_ref().filter(|target| target.traced)?;
        Some(DevicePicture {
            size: target.size,
            pixels: target.pixels.clone(),
        })
    }

    fn intersect(&mut self, rays: &[Ray], query: Query) -> Result<Vec<Hit>, TraceError> {
        self.answer_rays(rays, query)
    }

    fn hierarchy(&self, level: Level, alone: Option<u32>, most: usize) -> Option<Hierarchy> {
        Some(self.packed.hierarchy(level, alone, most))
    }

    fn counters(&self) -> Counters {
        self.counters
    }

    fn pass_times(&self) -> Vec<PassTime> {
        let pass = |name, millis: Option<f64>| millis.map(|millis| PassTime { name, millis });
        let trees = pass("trees", self.tree_millis);
        let picture = pass(Kernel::Whitted.name(), self.device_millis);
        let host = self.host_passes.iter().cloned();
        host.chain(trees).chain(picture).collect()
    }
}

/// What a tracer without a frame says.
pub(super) fn nothing_uploaded() -> TraceError {
    TraceError::Device("no frame has been uploaded yet".into())
}

/// Bands of whole workgroups of `group` rows, with at most [`BAND_SAMPLES`] samples where that is possible.
fn bands(view: &ViewRow, group: u32) -> Vec<PassRow> {
    let row = u64::from(view.width) * u64::from(view.samples);
    let rows = u32::try_from(BAND_SAMPLES / row.max(1)).unwrap_or(u32::MAX) / group * group;
    let rows = rows.clamp(group, view.height.max(group));
    (0..view.height)
        .step_by(rows as usize)
        .map(|first| PassRow {
            first,
            count: rows.min(view.height - first),
            ..PassRow::default()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_cover_every_row_once() {
        let view = |width, height, samples| ViewRow {
            width,
            height,
            samples,
            ..ViewRow::default()
        };
        for view in [
            view(1, 1, 1),
            view(640, 480, 1),
            view(1920, 1081, 1),
            view(4096, 2160, 64),
        ] {
            let mut next = 0;
            for band in bands(&view, 8) {
                assert_eq!(band.first, next);
                assert!(band.count > 0);
                next += band.count;
            }
            assert_eq!(next, view.height);
        }
        assert_eq!(bands(&view(1024, 768, 1), 8).len(), 1);
    }
}
