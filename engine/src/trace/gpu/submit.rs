//! What is due of a picture, as passes recorded and submitted, and what they took.
//!
//! Called by [`super::tracer`] once a frame. Each pass is a submission, so that no single one is long.

use std::time::Instant;

use super::GpuTracer;
use super::buffers::{create, read};
use super::canvas::{Canvas, Pass, edge_passes, most_edge_passes, passes};
use super::report::{COUNTERS, Ends, Traced};
use super::shader::{Kernel, Specialisation};
use crate::frame::wire::{CounterRow, ViewRow};
use crate::trace::progress::{Due, first_samples, is_adaptive};
use crate::trace::{PictureTime, TraceError};

/// Where a device tells no times, one picture of so many is waited for.
const WAITED_FOR: u64 = 8;
/// Parts of the list of edges from which on a slow device is asked how long the list is: each part is a submission, and asking
/// waits for those before.
const MANY_PASSES: u64 = 65;

/// Passes, and where in the picture they are.
struct Batch {
    passes: Vec<Pass>,
    is_first: bool,
    is_last: bool,
}

impl GpuTracer {
    /// Takes note of what rays took.
    pub(super) fn note_time(&mut self, traced: Traced, rays: f64) {
        self.packed.instances.note_trace_time(rays * 1e6);
        let size = traced.size;
        self.timed_picture = traced.is_whole.then_some(PictureTime { size, rays });
    }

    /// Waits for what was submitted since `start`, where the device tells no times: its time is then the host's.
    fn time_by_waiting(&mut self, traced: Traced, start: Instant) -> Result<(), TraceError> {
        let waited = self.gpu.device.poll(wgpu::PollType::wait_indefinitely());
        self.gpu.check()?;
        waited.map_err(|error| TraceError::Device(error.to_string()))?;
        let millis = start.elapsed().as_secs_f64() * 1e3;
        self.device_millis = Some(millis);
        self.pace.note(traced.epoch, traced.samples, millis);
        self.note_time(traced, millis);
        Ok(())
    }

    /// Brings the picture to what is due.
    pub(super) fn bring_to(
        &mut self,
        due: Due,
        special: Specialisation,
        view: &ViewRow,
    ) -> Result<(), TraceError> {
        let (gpu, reports) = (&self.gpu, &mut self.reports);
        Canvas::fit(&mut self.canvas, gpu, &self.layouts, reports, view)?;
        // Should it fail, what it holds is no picture.
        if let Some(canvas) = self.canvas.take() {
            let traced = Traced {
                size: canvas.size,
                is_whole: due == Due::Picture,
                epoch: self.pace.epoch(),
                samples: u64::from(view.width)
                    * u64::from(view.height)
                    * u64::from(match due {
                        Due::Nothing => 0,
                        Due::Picture => first_samples(view),
                        Due::Refinement { by, .. } => by,
                    }),
            };
            let most = self.pace.samples();
            let has_edges = due == Due::Picture && is_adaptive(view);
            let start = Instant::now();
            let first = Batch {
                passes: passes(view, due, most),
                is_first: true,
                is_last: !has_edges,
            };
            self.submit(special, &canvas, &first, traced)?;
            if has_edges {
                let listed = match most_edge_passes(view, most) {
                    MANY_PASSES.. if self.pace.is_slow() => self.listed()?,
                    _ => view.width * view.height,
                };
                let edges = Batch {
                    passes: edge_passes(view, listed, most),
                    is_first: false,
                    is_last: true,
                };
                self.submit(special, &canvas, &edges, traced)?;
            }
            // Not the first, which waits for the compiler.
            let is_due = self.pictures % WAITED_FOR == 1;
            if traced.is_whole && !self.reports.are_timed() && is_due {
                self.time_by_waiting(traced, start)?;
            }
            self.pictures += 1;
            self.canvas = Some(canvas);
        }
        self.gpu.check()
    }

    /// How long the list of edges is: waits until it is there.
    fn listed(&self) -> Result<u32, TraceError> {
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let size = size_of::<u32>() as u64;
        let staging = create(&self.gpu, "length of the list", usage, size);
        let mut encoder = self
            .gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let at = std::mem::offset_of!(CounterRow, edge_pixels) as u64;
        encoder.copy_buffer_to_buffer(&self.reports.counters, at, &staging, 0, size);
        self.gpu.queue.submit([encoder.finish()]);
        Ok(bytemuck::pod_read_unaligned(&read(&self.gpu, &staging)?))
    }

    /// One submission a pass, so that no single one is long.
    fn submit(
        &mut self,
        special: Specialisation,
        canvas: &Canvas,
        batch: &Batch,
        traced: Traced,
    ) -> Result<(), TraceError> {
        let passes = &batch.passes;
        let kernels = [Kernel::Whitted, Kernel::Edges, Kernel::Antialias];
        let mut compiled = Vec::new();
        for kernel in kernels {
            if passes.iter().any(|pass| pass.kernel == kernel) {
                let pipelines = &mut self.pipelines;
                let pipeline = pipelines.get(&self.gpu, &self.layouts, kernel, special)?;
                pipelines.prepare_general(&self.gpu, &self.layouts, kernel, special);
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
                (_, None) if batch.is_last => Some(Ends::Edges),
                _ => None,
            };
            let mut encoder = self
                .gpu
                .device
                .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let is_first = batch.is_first && i == 0;
            if is_first {
                self.reports.begin(self.frame);
                encoder.clear_buffer(&self.reports.counters, 0, Some(COUNTERS));
            }
            {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label: Some(work.kernel.name()),
                    timestamp_writes: self.reports.writes(is_first, ends),
                });
                for (_, pipeline) in compiled.iter().filter(|(kernel, _)| *kernel == work.kernel) {
                    pass.set_pipeline(&pipeline.compute);
                }
                pass.set_bind_group(0, &self.on_device.frame, &[offset]);
                pass.set_bind_group(1, &self.on_device.scene, &[]);
                pass.set_bind_group(2, &canvas.group, &[]);
                if let Some(texels) = self.on_device.texels.bound() {
                    pass.set_bind_group(3, texels, &[]);
                }
                pass.dispatch_workgroups(work.groups[0], work.groups[1], 1);
            }
            let last = ends.filter(|_| next.is_none() && batch.is_last);
            let report = last.and_then(|last| self.reports.record(&mut encoder, last));
            self.gpu.queue.submit([encoder.finish()]);
            if let Some(slot) = report {
                self.reports.mark(slot, traced);
                self.reports.request(slot);
            }
        }
        Ok(())
    }
}
