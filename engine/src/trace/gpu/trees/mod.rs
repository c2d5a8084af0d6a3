//! Trees that are kept on the device: meshes deformed and refitted there, and the tree over many instances.
//!
//! The tracer plans a frame's work ([`DeviceTrees::deform`], [`DeviceTrees::refit`],
//! [`DeviceTrees::instances`], in this order), then records it as one compute pass ahead of its picture. What
//! must be resident: the nodes (topology and leaves) and triangles of each mesh as [`crate::bvh::Tree`] lays
//! them out, and room for its vertices. Vertices never pass through the host. Boxes come out as the host's
//! refit would compute them from the same vertices, bit for bit. The report (2008) left moving objects out;
//! refitting by levels follows Wald, Boulos and Shirley 2007, "Ray Tracing Deformable Scenes using Dynamic
//! Bounding Volume Hierarchies", section 4.

mod deform;
mod instances;
mod plan;
mod refit;
mod rig;

pub use instances::{InstanceBuild, most_levels, most_nodes};
pub use plan::Plan;
pub use rig::{Rig, RigRows};

use std::sync::Arc;

use bytemuck::{Zeroable, cast_slice};

use self::deform::DeformData;
use self::instances::InstanceBuilder;
use self::plan::{Recorder, Timing};
use self::refit::JobRange;
use super::buffers::{RowBuffer, create};
use super::context::Gpu;
use super::layout::Layouts;
use super::pipelines::Pipelines;
use super::readback::Readback;
use super::shader::Kernel;
use crate::frame::wire::{JobRow, StageRow, StepRow};
use crate::trace::TraceError;
use crate::world::{Deformation, MeshData};

/// Vertices of a workgroup of `deform.wgsl` and `normals.wgsl`.
const GROUP_VERTICES: u32 = 64;
/// Trees whose costs come back at once; of more, the first ones' do.
const MOST_COSTS: usize = 256;

/// Where a mesh's rows are on the device.
#[derive(Clone, Copy, Debug)]
pub struct MeshPlace<'a> {
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
    /// [`crate::frame::wire::TriangleRow`]s.
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
    costs: wgpu::Buffer,
    readback: Readback,
    /// Trees whose costs the last plan computes.
    costed: usize,
    /// Of each answer on its way, how many costs it holds.
    asked: [usize; 8],
    builder: InstanceBuilder,
    /// Bytes written for the plan under way.
    written: u64,
}

impl DeviceTrees {
    /// Nothing on the device yet; kernels are compiled when first needed.
    pub fn new(gpu: Arc<Gpu>) -> Self {
        let storage = wgpu::BufferUsages::STORAGE;
        let rows = |label, size: usize| RowBuffer::new(&gpu, label, storage, size as u64);
        let cost_bytes = (MOST_COSTS * size_of::<f32>()) as u64;
        let costs = storage | wgpu::BufferUsages::COPY_SRC;
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
            costs: create(&gpu, "costs of trees", costs, cost_bytes),
            readback: Readback::new(&gpu, "costs on their way", cost_bytes),
            costed: 0,
            asked: [0; 8],
            builder: InstanceBuilder::new(&gpu),
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

    /// Plans new boxes from the vertices as they will be by then, and what the trees cost; call it once a
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
        let mut costs = refit.costs;
        costs.count = costs.count.min(MOST_COSTS as u32);
        costs.groups = costs.count;
        let buffers = [jobs, partials, scene.nodes, &self.costs];
        add_jobs(plan, Kernel::Cost, costs, &buffers);
        self.costed = costs.count as usize;
        Ok(())
    }

    /// Plans a tree over boxes; call it once a plan.
    ///
    /// # Errors
    /// [`TraceError::TooLarge`].
    pub fn instances(&mut self, plan: &mut Plan, tree: &InstanceBuild) -> Result<(), TraceError> {
        self.builder.plan(&self.gpu, plan, tree)
    }

    /// Records a plan as one compute pass; returns the bytes written for it. Submit before the next is
    /// planned, and call [`DeviceTrees::submitted`] with the second answer then.
    ///
    /// # Errors
    /// [`TraceError::Device`], [`TraceError::TooLarge`].
    pub fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        plan: &Plan,
        timestamps: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) -> Result<(u64, CostsAsked), TraceError> {
        self.record_timed(encoder, plan, timestamps, None)
    }

    /// [`DeviceTrees::record`], with a timestamp before each dispatch and one behind the last.
    fn record_timed(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        plan: &Plan,
        timestamps: Option<wgpu::ComputePassTimestampWrites<'_>>,
        marks: Option<&wgpu::QuerySet>,
    ) -> Result<(u64, CostsAsked), TraceError> {
        let mut written = std::mem::take(&mut self.written);
        written += self.recorder.record(
            &self.gpu,
            &self.layouts,
            &mut self.pipelines,
            encoder,
            plan,
            Timing { timestamps, marks },
        )?;
        let costed = std::mem::take(&mut self.costed);
        let slot = (costed > 0).then(|| self.readback.free()).flatten();
        if let Some(slot) = slot {
            let size = (costed * size_of::<f32>()) as u64;
            encoder.copy_buffer_to_buffer(&self.costs, 0, self.readback.buffer(slot), 0, size);
            self.asked[slot] = costed;
        }
        Ok((written, CostsAsked(slot)))
    }

    /// Asks for the costs of a recorded plan that was submitted.
    pub fn submitted(&self, asked: CostsAsked) {
        if let CostsAsked(Some(slot)) = asked {
            self.readback.request(slot);
        }
    }

    /// The costs of refitted trees that have come back since the last call, plan by plan, in the order of the
    /// plan's meshes: expected work of a ray through the root's box, by the surface area heuristic.
    pub fn costs(&self) -> Vec<Vec<f32>> {
        let mut all = Vec::new();
        self.readback.collect(|slot, bytes| {
            let costs = bytes.chunks_exact(4).take(self.asked[slot]);
            all.push(costs.map(bytemuck::pod_read_unaligned).collect());
        });
        all
    }

    /// Where [`crate::frame::wire::BuildRow`] of the last instance tree is: its number of boxes, nodes and levels.
    pub fn instance_tree(&self) -> &wgpu::Buffer {
        self.builder.build_row()
    }
}

/// Costs that a recorded plan leaves to ask for; none if too many are under way.
#[must_use = "costs come back once `DeviceTrees::submitted` was told"]
pub struct CostsAsked(Option<usize>);

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
