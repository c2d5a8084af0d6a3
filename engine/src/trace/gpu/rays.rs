//! Rays from the host, hits back: picking, tests and benchmarks.

use bytemuck::{cast_slice, pod_read_unaligned};

use super::GpuTracer;
use super::buffers::{create, read};
use super::context::Gpu;
use super::layout::{Layouts, bind};
use super::pipelines::Pipeline;
use super::shader::Kernel;
use super::tracer::nothing_uploaded;
use crate::frame::wire::{HitRow, NONE, PassRow, QUERY_ANY, QUERY_CLOSEST, RayRow};
use crate::trace::{Hit, Query, Ray, TraceError};

/// Rays of one dispatch; more go in several.
const BATCH: usize = 1 << 18;
/// `shaders/shared/slab.wgsl`'s FARTHEST: ends beyond it are brought to it.
const FARTHEST: f32 = 1e30;

/// Room for one batch.
pub struct RayBuffers {
    rays: wgpu::Buffer,
    hits: wgpu::Buffer,
    staging: wgpu::Buffer,
    group: wgpu::BindGroup,
}

impl RayBuffers {
    fn new(gpu: &Gpu, layouts: &Layouts) -> Self {
        use wgpu::BufferUsages as Usage;
        let size = (BATCH * size_of::<RayRow>()) as u64;
        let hit_size = (BATCH * size_of::<HitRow>()) as u64;
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
        let kernel = Kernel::Intersect;
        let pipeline = self
            .pipelines
            .get(&self.gpu, &self.layouts, kernel, special)?;
        let mut hits = Vec::with_capacity(rays.len());
        for batch in rays.chunks(BATCH) {
            self.answer_batch(&pipeline, batch, query, &mut hits)?;
        }
        Ok(hits)
    }

    fn answer_batch(
        &mut self,
        pipeline: &Pipeline,
        batch: &[Ray],
        query: Query,
        hits: &mut Vec<Hit>,
    ) -> Result<(), TraceError> {
        let gpu = &self.gpu;
        let buffers = self
            .rays
            .get_or_insert_with(|| RayBuffers::new(gpu, &self.layouts));
        let rows: Vec<RayRow> = batch.iter().map(ray_row).collect();
        gpu.queue.write_buffer(&buffers.rays, 0, cast_slice(&rows));
        let pass_row = PassRow {
            count: batch.len() as u32,
            query: match query {
                Query::Closest => QUERY_CLOSEST,
                Query::Any => QUERY_ANY,
            },
            ..PassRow::default()
        };
        let offsets = self
            .on_device
            .write_passes(gpu, &self.layouts, &[pass_row])?;
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some(Kernel::Intersect.name()),
                timestamp_writes: None,
            });
            pass.set_pipeline(&pipeline.compute);
            pass.set_bind_group(0, &self.on_device.frame, &offsets);
            pass.set_bind_group(1, &self.on_device.scene, &[]);
            pass.set_bind_group(2, &buffers.group, &[]);
            pass.dispatch_workgroups(pass_row.count.div_ceil(pipeline.workgroup[0]), 1, 1);
        }
        let size = (batch.len() * size_of::<HitRow>()) as u64;
        encoder.copy_buffer_to_buffer(&buffers.hits, 0, &buffers.staging, 0, size);
        gpu.queue.submit([encoder.finish()]);
        let bytes = read(gpu, &buffers.staging)?;
        let rows = bytes.chunks_exact(size_of::<HitRow>()).take(batch.len());
        hits.extend(rows.map(|row| hit_of(&pod_read_unaligned(row), query)));
        Ok(())
    }
}

fn ray_row(ray: &Ray) -> RayRow {
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
        Query::Closest if row.instance == NONE => Hit::MISS,
        Query::Closest => Hit {
            t: f64::from(row.t),
            instance: row.instance,
            prim: row.prim,
            uv: [f64::from(row.u), f64::from(row.v)],
        },
    }
}
