//! Trees that are kept on the device: meshes deformed and refitted there, and the tree over many instances.
//!
//! The tracer plans a frame's work ([`DeviceTrees::deform`], [`DeviceTrees::refit`],
//! [`DeviceTrees::instances`], in this order), then submits it as one compute pass ahead of its picture. What
//! must be resident: the nodes (topology and leaves) and triangles (but for positions) of each mesh as
//! [`crate::bvh::Tree`] lays them out, and room for its vertices. Vertices never pass through the host. Boxes come out as the host's
//! refit would compute them from the same vertices, bit for bit. The report (2008) left moving objects out;
//! refitting by levels follows Wald, Boulos and Shirley 2007, "Ray Tracing Deformable Scenes using Dynamic
//! Bounding Volume Hierarchies", section 4.

mod deform;
mod frame;
mod instances;
mod plan;
mod refit;
mod report;
mod rig;

pub use instances::{InstanceBuild, most_levels, most_nodes};
pub use plan::Plan;
pub use report::TreesReport;
pub use rig::{Rig, RigRows};

use std::sync::Arc;
use std::time::Instant;

use bytemuck::{Zeroable, cast_slice};

use self::deform::DeformData;
use self::instances::{InstanceBoxes, InstanceBuilder};
use self::plan::{Recorder, Timing};
use self::refit::JobRange;
use self::report::{MOST_COSTS, TreesReports};
use super::buffers::RowBuffer;
use super::context::Gpu;
use super::layout::Layouts;
use super::pipelines::Pipelines;
use super::report::Submission;
use super::shader::Kernel;
use crate::frame::wire::{JobRow, StageRow, StepRow};
use crate::trace::TraceError;
use crate::world::{Deformation, MeshData};

#[cfg(test)]
mod tests;

/// Vertices of a workgroup of `deform.wgsl` and `normals.wgsl`.
const GROUP_VERTICES: u32 = 64;

/// Where a mesh's rows are on the device.
#[derive(Clone, Copy, Debug)]
pub struct MeshPlace<'a> {
    /// What [`TreesReport::costs`] calls it.
    pub key: u32,
    /// First of its nodes.
    pub root: u32,
    /// [`crate::bvh::Tree::levels`].
    pub levels: &'a [u32],
    /// First of its triangles.
    pub first_triangle: u32,
    /// First of its vertices.
    pub first_vertex: u32,
}

/// A mesh whose vertices the device computes.
#[derive(Clone, Copy, Debug)]
pub struct DeformedMesh<'a> {
    /// First of its vertices.
    pub first_vertex: u32,
    /// First of its normals, if it is smooth.
    pub first_normal: u32,
    /// At rest.
    pub data: &'a Arc<MeshData>,
    /// What is done to it.
    pub deformation: &'a Deformation,
}

/// The buffers that kernels of trees share with the tracer's.
#[derive(Clone, Copy)]
pub struct SceneBuffers<'a> {
    /// [`crate::frame::wire::Node4`]s.
    pub nodes: &'a wgpu::Buffer,
    /// [`crate::frame::wire::PlacedTriangleRow`]s.
    pub triangles: &'a wgpu::Buffer,
    /// Positions and normals, 16 bytes each.
    pub vertices: &'a wgpu::Buffer,
}

/// The kernels, what they need, and what stays on the device for them.
pub struct DeviceTrees {
    gpu: Arc<Gpu>,
    layouts: Layouts,
    pipelines: Pipelines,
    recorder: Recorder,
    data: DeformData,
    deform_jobs: RowBuffer,
    steps: RowBuffer,
    params: RowBuffer,
    refit_jobs: RowBuffer,
    partials: RowBuffer,
    reports: TreesReports,
    builder: InstanceBuilder,
    boxes: InstanceBoxes,
    /// Bytes written for the plan under way.
    written: u64,
}

impl DeviceTrees {
    /// Nothing on the device yet; kernels are compiled when first needed.
    pub fn new(gpu: Arc<Gpu>) -> Self {
        let storage = wgpu::BufferUsages::STORAGE;
        let rows = |label, size: usize| RowBuffer::new(&gpu, label, storage, size as u64);
        Self {
            layouts: Layouts::new(&gpu),
            pipelines: Pipelines::default(),
            recorder: Recorder::new(&gpu),
            data: DeformData::new(&gpu),
            deform_jobs: rows("deformations", size_of::<JobRow>()),
            steps: rows("deformation steps", size_of::<StepRow>()),
            params: rows("deformation parameters", 16),
            refit_jobs: rows("refits", size_of::<JobRow>()),
            partials: rows("costs of nodes", 4),
            reports: TreesReports::new(&gpu),
            builder: InstanceBuilder::new(&gpu),
            boxes: InstanceBoxes::new(&gpu),
            written: 0,
            gpu,
        }
    }

    /// Plans new vertices; call it once a plan. Meshes that are smooth get normals too.
    ///
    /// # Errors
    /// [`TraceError::TooLarge`].
    pub fn deform(
        &mut self,
        plan: &mut Plan,
        scene: SceneBuffers,
        meshes: &[DeformedMesh],
    ) -> Result<(), TraceError> {
        if meshes.is_empty() {
            return Ok(());
        }
        let gpu = &self.gpu;
        self.written += self.data.bring(gpu, meshes)?;
        let (mut jobs, mut steps, mut params) = (Vec::new(), Vec::new(), Vec::new());
        for mesh in meshes {
            let first = steps.len() as u32;
            self.data.append_steps(mesh, &mut steps, &mut params);
            jobs.push(JobRow {
                count: mesh.data.positions.len() as u32,
                first,
                first_vertex: mesh.first_vertex,
                rest: self.data.rest(mesh.data),
                step_count: steps.len() as u32 - first,
                ..JobRow::zeroed()
            });
        }
        let positions = number_groups(&mut jobs, 0);
        let smooth = meshes.iter().filter(|m| !m.data.normals.is_empty());
        jobs.extend(smooth.map(|mesh| {
            let count = mesh.data.positions.len() as u32;
            let rest = self.data.faces(mesh.data);
            JobRow {
                count,
                first: rest + count * 4 + 1,
                first_vertex: mesh.first_vertex,
                first_normal: mesh.first_normal,
                rest,
                ..JobRow::zeroed()
            }
        }));
        let normals = number_groups(&mut jobs, positions.count as usize);
        self.written += put(gpu, &mut self.deform_jobs, cast_slice(&jobs))?;
        self.written += put(gpu, &mut self.steps, cast_slice(&steps))?;
        self.written += put(gpu, &mut self.params, cast_slice(&params))?;
        let jobs = self.deform_jobs.buffer();
        let data = self.data.buffer.buffer();
        let (steps, params) = (self.steps.buffer(), self.params.buffer());
        let buffers = [jobs, scene.vertices, data, steps, params];
        add_jobs(plan, Kernel::Deform, positions, &buffers);
        add_jobs(plan, Kernel::Normals, normals, &buffers[..3]);
        Ok(())
    }

    /// Plans new boxes, and new positions in triangles, from the vertices as they will be by then, and what the trees cost; call it once a
    /// plan.
    ///
    /// # Errors
    /// [`TraceError::TooLarge`].
    pub fn refit(
        &mut self,
        plan: &mut Plan,
        scene: SceneBuffers,
        meshes: &[MeshPlace],
    ) -> Result<(), TraceError> {
        let mut jobs = Vec::new();
        let refit = refit::append_jobs(meshes, &mut jobs);
        self.written += put(&self.gpu, &mut self.refit_jobs, cast_slice(&jobs))?;
        self.partials
            .reserve(&self.gpu, u64::from(refit.partials) * 4)?;
        let jobs = self.refit_jobs.buffer();
        let partials = self.partials.buffer();
        for level in refit.levels {
            let buffers = [jobs, scene.triangles, scene.nodes, scene.vertices, partials];
            add_jobs(plan, Kernel::Refit, level, &buffers);
        }
        self.reports.keys = meshes
            .iter()
            .map(|mesh| mesh.key)
            .take(MOST_COSTS)
            .collect();
        let mut costs = refit.costs;
        costs.count = self.reports.keys.len() as u32;
        costs.groups = costs.count;
        let buffers = [jobs, partials, scene.nodes, &self.reports.costs];
        add_jobs(plan, Kernel::Cost, costs, &buffers);
        Ok(())
    }

    /// Plans a tree over boxes; call it once a plan.
    ///
    /// # Errors
    /// [`TraceError::TooLarge`].
    pub fn instances(&mut self, plan: &mut Plan, tree: &InstanceBuild) -> Result<(), TraceError> {
        self.builder.plan(&self.gpu, plan, tree)
    }

    /// Submits a plan of a frame as one compute pass; returns the bytes written for it.
    ///
    /// # Errors
    /// [`TraceError::Device`], [`TraceError::TooLarge`].
    pub fn submit(&mut self, plan: &Plan, frame: u64) -> Result<u64, TraceError> {
        if plan.is_empty() {
            return Ok(std::mem::take(&mut self.written));
        }
        let mut encoder = self
            .gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let written = self.record(&mut encoder, plan, None)?;
        let slot = self.reports.record(&mut encoder);
        let at = Instant::now();
        self.gpu.queue.submit([encoder.finish()]);
        if let Some(slot) = slot {
            self.reports.request(slot, Some(Submission { frame, at }));
        }
        Ok(written)
    }

    /// What the newest plan took and found whose answer has come back since the last call.
    pub fn collect(&mut self) -> Option<TreesReport> {
        self.reports.collect(&self.gpu)
    }

    /// Records a plan, with a timestamp before each dispatch and one behind the last if asked; returns the
    /// bytes written.
    fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        plan: &Plan,
        marks: Option<&wgpu::QuerySet>,
    ) -> Result<u64, TraceError> {
        let written = std::mem::take(&mut self.written);
        let timing = Timing {
            timestamps: self.reports.writes(),
            marks,
        };
        let stages = self.recorder.record(
            &self.gpu,
            &self.layouts,
            &mut self.pipelines,
            encoder,
            plan,
            timing,
        )?;
        Ok(written + stages)
    }

    /// Where [`crate::frame::wire::BuildRow`] of the last instance tree is: its number of boxes, nodes and levels.
    pub fn instance_tree(&self) -> &wgpu::Buffer {
        self.builder.build_row()
    }
}

/// Numbers the workgroups of jobs from `first` on.
fn number_groups(jobs: &mut [JobRow], first: usize) -> JobRange {
    let mut groups = 0;
    for job in &mut jobs[first..] {
        job.first_group = groups;
        groups += job.count.div_ceil(GROUP_VERTICES);
    }
    JobRange {
        first: first as u32,
        count: (jobs.len() - first) as u32,
        groups,
    }
}

fn add_jobs(plan: &mut Plan, kernel: Kernel, range: JobRange, buffers: &[&wgpu::Buffer]) {
    if range.groups > 0 {
        let stage = StageRow {
            first: range.first,
            count: range.count,
            ..StageRow::default()
        };
        plan.add(kernel, stage, range.groups, buffers);
    }
}

fn put(gpu: &Gpu, buffer: &mut RowBuffer, bytes: &[u8]) -> Result<u64, TraceError> {
    buffer.reserve(gpu, bytes.len() as u64)?;
    Ok(buffer.write_changed(gpu, 0, bytes))
}
