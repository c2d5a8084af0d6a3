//! Rays from the host, hits back: picking, tests and benchmarks.
//!
//! Two batches are on their way at a time: while the device traces one, the host reads the hits of the one before.

use std::sync::mpsc;
use std::time::Duration;

use bytemuck::{cast_slice, pod_read_unaligned};
use rayon::prelude::*;

use super::GpuTracer;
use super::buffers::create;
use super::compile::Pipeline;
use super::context::Gpu;
use super::layout::{Layouts, bind};
use super::shader::Kernel;
use super::tracer::nothing_uploaded;
use crate::frame::wire::{HitRow, NONE, PassRow, QUERY_ANY, QUERY_CLOSEST, RayRow};
use crate::trace::{Hit, Query, Ray, TraceError};

/// Most rays of a dispatch; more go in several. Even, so that no pair is parted.
const MOST: usize = 1 << 20;
/// Least room of a buffer, in rays.
const LEAST: usize = 1 << 10;
/// Rays that one task of the host converts.
const CHUNK: usize = 1 << 14;
/// How long an answer may take to be handed over once the device has it.
const PATIENCE: Duration = Duration::from_secs(10);
/// `shaders/shared/slab.wgsl`'s FARTHEST: ends beyond it are brought to it.
const FARTHEST: f32 = 1e30;

/// Room for two batches.
pub struct RayBuffers {
    slots: [Slot; 2],
    /// In rays.
    room: usize,
}

/// Rays and their hits on the device, and where hits come back to.
pub struct Slot {
    /// Rows of rays.
    pub rays: wgpu::Buffer,
    hits: wgpu::Buffer,
    staging: wgpu::Buffer,
    /// What a kernel is given of them.
    pub group: wgpu::BindGroup,
}

/// A batch on the device.
struct Sent {
    slot: usize,
    count: usize,
    submission: wgpu::SubmissionIndex,
    answered: mpsc::Receiver<Result<(), wgpu::BufferAsyncError>>,
}

impl RayBuffers {
    fn new(gpu: &Gpu, layouts: &Layouts, room: usize) -> Self {
        let slot = || Slot::new(gpu, layouts, room);
        Self {
            slots: [slot(), slot()],
            room,
        }
    }
}

impl Slot {
    /// Room for so many rays.
    pub fn new(gpu: &Gpu, layouts: &Layouts, room: usize) -> Self {
        use wgpu::BufferUsages as Usage;
        let size = (room * size_of::<RayRow>()) as u64;
        let hit_size = (room * size_of::<HitRow>()) as u64;
        let rays = create(gpu, "rays", Usage::STORAGE | Usage::COPY_DST, size);
        let hits = create(gpu, "hits", Usage::STORAGE | Usage::COPY_SRC, hit_size);
        let waiting = Usage::MAP_READ | Usage::COPY_DST;
        Self {
            staging: create(gpu, "hits on their way", waiting, hit_size),
            group: bind(gpu, "rays", &layouts.rays, &[&rays, &hits]),
            rays,
            hits,
        }
    }
}

impl GpuTracer {
    /// [`crate::trace::Tracer::intersect`], batch by batch.
    pub(super) fn answer_rays(
        &mut self,
        rays: &[Ray],
        query: Query,
    ) -> Result<Vec<Hit>, TraceError> {
        let special = self.special.ok_or_else(nothing_uploaded)?;
        let kernel = kernel_of(query);
        let pipeline = self
            .pipelines
            .get(&self.gpu, &self.layouts, kernel, special)?;
        let need = rays.len().next_power_of_two().clamp(LEAST, MOST);
        if self.rays.as_ref().is_none_or(|buffers| buffers.room < need) {
            self.rays = Some(RayBuffers::new(&self.gpu, &self.layouts, need));
        }
        let answers = self.exchange(&pipeline, rays, query);
        if answers.is_err() {
            // A batch may still be on its way in them.
            self.rays = None;
        }
        answers
    }

    fn exchange(
        &mut self,
        pipeline: &Pipeline,
        rays: &[Ray],
        query: Query,
    ) -> Result<Vec<Hit>, TraceError> {
        let mut hits = Vec::with_capacity(rays.len());
        let mut sent: Option<Sent> = None;
        for (i, batch) in rays.chunks(MOST).enumerate() {
            let next = self.send(pipeline, batch, query, i % 2)?;
            if let Some(before) = sent.replace(next) {
                self.receive(before, query, &mut hits)?;
            }
        }
        if let Some(last) = sent {
            self.receive(last, query, &mut hits)?;
        }
        if query == Query::Leave
            && rays.len() % 2 == 1
            && let Some(alone) = hits.last_mut()
        {
            // No invocation answers it: what came back is of an earlier batch.
            *alone = Hit::MISS;
        }
        Ok(hits)
    }

    fn send(
        &mut self,
        pipeline: &Pipeline,
        batch: &[Ray],
        query: Query,
        slot: usize,
    ) -> Result<Sent, TraceError> {
        let (gpu, layouts) = (&self.gpu, &self.layouts);
        let buffers = self
            .rays
            .get_or_insert_with(|| RayBuffers::new(gpu, layouts, MOST));
        let Slot {
            rays,
            hits,
            staging,
            group,
        } = &buffers.slots[slot];
        let rows = batch.par_iter().with_min_len(CHUNK).map(ray_row);
        let rows: Vec<RayRow> = rows.collect();
        gpu.queue.write_buffer(rays, 0, cast_slice(&rows));
        let pass_row = pass_row(batch.len(), query);
        let offsets = self.on_device.write_passes(gpu, layouts, &[pass_row])?;
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some("rays"),
                timestamp_writes: None,
            });
            pass.set_pipeline(&pipeline.compute);
            pass.set_bind_group(0, &self.on_device.frame, &offsets);
            pass.set_bind_group(1, &self.on_device.scene, &[]);
            pass.set_bind_group(2, group, &[]);
            if let Some(texels) = self.on_device.texels.bound() {
                pass.set_bind_group(3, texels, &[]);
            }
            pass.dispatch_workgroups(pass_row.count.div_ceil(pipeline.workgroup[0]), 1, 1);
        }
        let size = (batch.len() * size_of::<HitRow>()) as u64;
        encoder.copy_buffer_to_buffer(hits, 0, staging, 0, size);
        let submission = gpu.queue.submit([encoder.finish()]);
        let (answer, answered) = mpsc::channel();
        staging.map_async(wgpu::MapMode::Read, ..size, move |result| {
            // The receiver is only gone if the wait for it failed, which says so itself.
            let _ = answer.send(result);
        });
        Ok(Sent {
            slot,
            count: batch.len(),
            submission,
            answered,
        })
    }

    fn receive(&self, sent: Sent, query: Query, hits: &mut Vec<Hit>) -> Result<(), TraceError> {
        let lost = |why: String| TraceError::Device(format!("the GPU's hits did not come: {why}"));
        let Some(buffers) = &self.rays else {
            return Err(lost("there is no buffer for them".into()));
        };
        let wait = wgpu::PollType::Wait {
            submission_index: Some(sent.submission),
            timeout: None,
        };
        let waited = self.gpu.device.poll(wait);
        self.gpu.check()?;
        waited.map_err(|error| lost(error.to_string()))?;
        // The work is done, but another thread's poll may have taken our callback and be about to run it.
        match sent.answered.recv_timeout(PATIENCE) {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(lost(error.to_string())),
            Err(error) => return Err(lost(error.to_string())),
        }
        let staging = &buffers.slots[sent.slot].staging;
        let size = (sent.count * size_of::<HitRow>()) as u64;
        {
            let bytes = staging
                .get_mapped_range(..size)
                .map_err(|error| lost(error.to_string()))?;
            let rows = bytes.par_chunks_exact(size_of::<HitRow>());
            let rows = rows.with_min_len(CHUNK);
            hits.par_extend(rows.map(|row| hit_of(&pod_read_unaligned(row), query)));
        }
        staging.unmap();
        Ok(())
    }
}

/// What answers a query.
pub fn kernel_of(query: Query) -> Kernel {
    match query {
        Query::Closest | Query::Any => Kernel::Intersect,
        Query::Leave => Kernel::Leave,
    }
}

/// So many rays in one dispatch.
pub fn pass_row(rays: usize, query: Query) -> PassRow {
    let (count, query) = match query {
        Query::Closest => (rays, QUERY_CLOSEST),
        Query::Any => (rays, QUERY_ANY),
        Query::Leave => (rays / 2, QUERY_CLOSEST),
    };
    PassRow {
        count: count as u32,
        query,
        ..PassRow::default()
    }
}

/// A ray as the kernels read it.
pub fn ray_row(ray: &Ray) -> RayRow {
    RayRow {
        origin: ray.origin.to_array(),
        t_min: ray.t_min.max(-FARTHEST),
        dir: ray.dir.to_array(),
        t_max: ray.t_max.min(FARTHEST),
    }
}

fn hit_of(row: &HitRow, query: Query) -> Hit {
    match query {
        Query::Any => Hit::any(row.instance == 1),
        Query::Closest | Query::Leave if row.instance == NONE => Hit::MISS,
        Query::Closest | Query::Leave => Hit {
            t: f64::from(row.t),
            instance: row.instance,
            prim: row.prim,
            uv: [f64::from(row.u), f64::from(row.v)],
        },
    }
}
