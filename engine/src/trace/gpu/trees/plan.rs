//! [`Plan`]: the dispatches of a frame's work on trees, and their way into one compute pass.
//!
//! Work is planned mesh by mesh and tree by tree, then recorded once: each dispatch has its uniform at a
//! dynamic offset, and groups are kept from frame to frame while the buffers stay the same ones. The next
//! dispatch of a pass sees what the last one wrote; wgpu puts the barriers.

use std::num::NonZeroU64;

use bytemuck::bytes_of;

use crate::frame::wire::StageRow;
use crate::trace::TraceError;
use crate::trace::gpu::buffers::RowBuffer;
use crate::trace::gpu::context::Gpu;
use crate::trace::gpu::layout::Layouts;
use crate::trace::gpu::pipelines::Pipelines;
use crate::trace::gpu::shader::{Kernel, Specialisation};

/// Workgroups of a row of a dispatch; more go on in the second dimension (see `group_index` in `stage.wgsl`).
const ROW_GROUPS: u32 = 32_768;
/// Bytes of the uniform.
const STAGE: u64 = size_of::<StageRow>() as u64;

/// Dispatches in order.
#[derive(Default)]
pub struct Plan {
    dispatches: Vec<Dispatch>,
    /// Cleared before the first dispatch.
    cleared: Vec<wgpu::Buffer>,
}

/// One kernel over some buffers.
struct Dispatch {
    kernel: Kernel,
    stage: StageRow,
    groups: u32,
    buffers: Vec<wgpu::Buffer>,
}

impl Plan {
    /// Whether there is nothing to do.
    pub fn is_empty(&self) -> bool {
        self.dispatches.is_empty()
    }

    /// Number of dispatches.
    pub fn len(&self) -> usize {
        self.dispatches.len()
    }

    /// The kernel of each dispatch.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.dispatches.iter().map(|d| d.kernel.name())
    }

    /// Adds a dispatch; `buffers` in the order of [`crate::trace::gpu::tree_bindings`].
    pub(super) fn add(
        &mut self,
        kernel: Kernel,
        stage: StageRow,
        groups: u32,
        buffers: &[&wgpu::Buffer],
    ) {
        self.dispatches.push(Dispatch {
            kernel,
            stage,
            groups,
            buffers: buffers.iter().map(|&buffer| buffer.clone()).collect(),
        });
    }

    /// Makes a buffer zero before all dispatches.
    pub(super) fn clear(&mut self, buffer: &wgpu::Buffer) {
        self.cleared.push(buffer.clone());
    }
}

/// Where timestamps go.
pub(super) struct Timing<'a> {
    /// Of the whole pass.
    pub(super) timestamps: Option<wgpu::ComputePassTimestampWrites<'a>>,
    /// One before each dispatch and one behind the last.
    pub(super) marks: Option<&'a wgpu::QuerySet>,
}

/// Uniforms and groups of plans.
pub(super) struct Recorder {
    stages: RowBuffer,
    stride: u64,
    groups: Vec<Group>,
}

/// A group that the next plan may need again.
struct Group {
    kernel: Kernel,
    buffers: Vec<wgpu::Buffer>,
    group: wgpu::BindGroup,
}

impl Recorder {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let alignment = gpu.device.limits().min_uniform_buffer_offset_alignment;
        Self {
            stages: RowBuffer::new(gpu, "stages", wgpu::BufferUsages::UNIFORM, STAGE),
            stride: u64::from(alignment).max(STAGE),
            groups: Vec::new(),
        }
    }

    /// Records a plan as one compute pass; returns the bytes written. Uniforms are written ahead of
    /// everything that is submitted later, so only one plan may be recorded between two submissions.
    ///
    /// # Errors
    /// [`TraceError::Device`] if the driver refuses a kernel, [`TraceError::TooLarge`].
    pub(super) fn record(
        &mut self,
        gpu: &Gpu,
        layouts: &Layouts,
        pipelines: &mut Pipelines,
        encoder: &mut wgpu::CommandEncoder,
        plan: &Plan,
        timing: Timing<'_>,
    ) -> Result<u64, TraceError> {
        let written = self.write_stages(gpu, plan)?;
        let mut groups = Vec::with_capacity(plan.len());
        let mut compiled = Vec::with_capacity(plan.len());
        for dispatch in &plan.dispatches {
            groups.push(self.group(gpu, layouts, dispatch));
            let special = Specialisation::new(Default::default(), 1);
            compiled.push(pipelines.get(gpu, layouts, dispatch.kernel, special)?);
        }
        for buffer in &plan.cleared {
            encoder.clear_buffer(buffer, 0, None);
        }
        let Timing { timestamps, marks } = timing;
        let mark = |pass: &mut wgpu::ComputePass, index: usize| {
            if let Some(marks) = marks {
                pass.write_timestamp(marks, index as u32);
            }
        };
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("trees"),
            timestamp_writes: timestamps,
        });
        for (index, dispatch) in plan.dispatches.iter().enumerate() {
            let (group, pipeline) = (&groups[index], &compiled[index]);
            let offset = index * self.stride as usize;
            mark(&mut pass, index);
            pass.set_pipeline(&pipeline.compute);
            pass.set_bind_group(0, group, &[offset as u32]);
            let row = dispatch.groups.clamp(1, ROW_GROUPS);
            pass.dispatch_workgroups(row, dispatch.groups.div_ceil(row), 1);
        }
        mark(&mut pass, plan.len());
        drop(pass);
        let used = |group: &Group| groups.contains(&group.group);
        self.groups.retain(used);
        Ok(written)
    }

    fn write_stages(&mut self, gpu: &Gpu, plan: &Plan) -> Result<u64, TraceError> {
        let stride = self.stride as usize;
        let mut bytes = vec![0; plan.len() * stride];
        for (dispatch, place) in plan.dispatches.iter().zip(bytes.chunks_exact_mut(stride)) {
            place[..STAGE as usize].copy_from_slice(bytes_of(&dispatch.stage));
        }
        if self.stages.reserve(gpu, bytes.len() as u64)? {
            self.groups.clear();
        }
        Ok(self.stages.write_changed(gpu, 0, &bytes))
    }

    fn group(&mut self, gpu: &Gpu, layouts: &Layouts, dispatch: &Dispatch) -> wgpu::BindGroup {
        let same = |g: &&Group| g.kernel == dispatch.kernel && g.buffers == dispatch.buffers;
        if let Some(group) = self.groups.iter().find(same) {
            return group.group.clone();
        }
        let stage = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: self.stages.buffer(),
            offset: 0,
            size: NonZeroU64::new(STAGE),
        });
        let buffers = dispatch.buffers.iter().map(|b| b.as_entire_binding());
        let entries: Vec<_> = std::iter::once(stage)
            .chain(buffers)
            .zip(0_u32..)
            .map(|(resource, binding)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(dispatch.kernel.name()),
            layout: layouts.tree(dispatch.kernel),
            entries: &entries,
        });
        self.groups.push(Group {
            kernel: dispatch.kernel,
            buffers: dispatch.buffers.clone(),
            group: group.clone(),
        });
        group
    }
}
