//! How long rays take on the device: the kernel that answers them, alone, by the device's own timestamps.
//!
//! [`super::rays`] answers rays from the host and is timed with their way there and back; here they lie on the device.

use std::time::{Duration, Instant};

use bytemuck::{cast_slice, pod_read_unaligned};

use super::buffers::{create, read};
use super::compile::Pipeline;
use super::rays::{Slot, kernel_of, pass_row, ray_row};
use super::tracer::nothing_uploaded;
use super::{Gpu, GpuTracer};
use crate::frame::wire::{PassRow, RayRow};
use crate::trace::{Query, Ray, TraceError};

/// A device's clocks fall while rays are on their way to it; this long they may rise again before times are taken.
const SETTLING: Duration = Duration::from_millis(600);
/// Runs submitted together: a slow device must not take the whole for one that hangs.
const TOGETHER: usize = 8;

impl GpuTracer {
    /// [`crate::trace::Tracer::time_rays`].
    pub(super) fn time_on_device(
        &mut self,
        rays: &[Ray],
        query: Query,
        runs: usize,
    ) -> Result<Vec<f64>, TraceError> {
        let special = self.special.ok_or_else(nothing_uploaded)?;
        let pipeline = self
            .pipelines
            .get(&self.gpu, &self.layouts, kernel_of(query), special)?;
        let row = pass_row(rays.len(), query);
        let limits = self.gpu.device.limits();
        let most = limits.max_compute_workgroups_per_dimension;
        if row.count.div_ceil(pipeline.workgroup[0]) > most {
            return Err(TraceError::TooLarge(format!(
                "{} rays at once are more than the {} that this device takes in a dispatch",
                rays.len(),
                u64::from(most) * u64::from(pipeline.workgroup[0])
            )));
        }
        let slot = Slot::new(&self.gpu, &self.layouts, rays.len().max(1));
        let rows: Vec<RayRow> = rays.iter().map(ray_row).collect();
        self.gpu
            .queue
            .write_buffer(&slot.rays, 0, cast_slice(&rows));
        let clock = Clock::new(&self.gpu);
        let begun = Instant::now();
        while runs > TOGETHER && begun.elapsed() < SETTLING {
            let encoder = self.record_runs(&pipeline, &slot, row, &clock, TOGETHER)?;
            clock.read(&self.gpu, encoder, TOGETHER)?;
        }
        let mut millis = Vec::with_capacity(runs);
        while millis.len() < runs {
            let count = TOGETHER.min(runs - millis.len());
            let encoder = self.record_runs(&pipeline, &slot, row, &clock, count)?;
            millis.extend(clock.read(&self.gpu, encoder, count)?);
        }
        Ok(millis)
    }

    fn record_runs(
        &mut self,
        pipeline: &Pipeline,
        slot: &Slot,
        row: PassRow,
        clock: &Clock,
        runs: usize,
    ) -> Result<wgpu::CommandEncoder, TraceError> {
        let gpu = &self.gpu;
        let offsets = self.on_device.write_passes(gpu, &self.layouts, &[row])?;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        for run in 0..runs {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some("rays on the device"),
                timestamp_writes: clock.writes(run as u32),
            });
            pass.set_pipeline(&pipeline.compute);
            pass.set_bind_group(0, &self.on_device.frame, &offsets);
            pass.set_bind_group(1, &self.on_device.scene, &[]);
            pass.set_bind_group(2, &slot.group, &[]);
            if let Some(texels) = self.on_device.texels.bound() {
                pass.set_bind_group(3, texels, &[]);
            }
            pass.dispatch_workgroups(row.count.div_ceil(pipeline.workgroup[0]), 1, 1);
        }
        Ok(encoder)
    }
}

/// Timestamps of runs; the host's clock around them all where the device has none.
struct Clock {
    device: Option<(wgpu::QuerySet, wgpu::Buffer, wgpu::Buffer)>,
}

impl Clock {
    fn new(gpu: &Gpu) -> Self {
        use wgpu::BufferUsages as Usage;
        let count = 2 * TOGETHER as u32;
        let size = u64::from(count) * size_of::<u64>() as u64;
        let features = gpu.device.features();
        let device = features.contains(wgpu::Features::TIMESTAMP_QUERY).then(|| {
            let queries = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("rays on the device"),
                ty: wgpu::QueryType::Timestamp,
                count,
            });
            let resolved = create(
                gpu,
                "timestamps of rays",
                Usage::QUERY_RESOLVE | Usage::COPY_SRC,
                size,
            );
            let staging = create(
                gpu,
                "timestamps of rays on their way",
                Usage::MAP_READ | Usage::COPY_DST,
                size,
            );
            (queries, resolved, staging)
        });
        Self { device }
    }

    fn writes(&self, run: u32) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let (query_set, ..) = self.device.as_ref()?;
        Some(wgpu::ComputePassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: Some(2 * run),
            end_of_pass_write_index: Some(2 * run + 1),
        })
    }

    /// Submits, waits, and says what each run took.
    fn read(
        &self,
        gpu: &Gpu,
        mut encoder: wgpu::CommandEncoder,
        runs: usize,
    ) -> Result<Vec<f64>, TraceError> {
        let Some((queries, resolved, staging)) = &self.device else {
            let start = Instant::now();
            gpu.queue.submit([encoder.finish()]);
            let waited = gpu.device.poll(wgpu::PollType::wait_indefinitely());
            waited.map_err(|error| TraceError::Device(error.to_string()))?;
            gpu.check()?;
            return Ok(vec![
                start.elapsed().as_secs_f64() * 1e3 / runs as f64;
                runs
            ]);
        };
        encoder.resolve_query_set(queries, 0..2 * runs as u32, resolved, 0);
        encoder.copy_buffer_to_buffer(
            resolved,
            0,
            staging,
            0,
            (2 * runs * size_of::<u64>()) as u64,
        );
        gpu.queue.submit([encoder.finish()]);
        let bytes = read(gpu, staging)?;
        let tick = f64::from(gpu.queue.get_timestamp_period()) * 1e-6;
        let pairs = bytes.chunks_exact(2 * size_of::<u64>()).take(runs);
        Ok(pairs
            .map(|pair| {
                let [begin, end]: [u64; 2] = pod_read_unaligned(pair);
                end.saturating_sub(begin) as f64 * tick
            })
            .collect())
    }
}
