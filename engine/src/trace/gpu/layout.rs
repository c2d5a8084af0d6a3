//! What kernels bind: group 0 the frame, group 1 the scene, group 2 what the pass works on.
//!
//! Twin of `shaders/shared/scene.wgsl` and the heads of the kernels; the table is in `shaders/README.md`.
//! Two storage buffers of group 2 and the six of group 1 are the eight that every device has.

use std::num::NonZeroU64;

use super::context::Gpu;
use super::shader::Kernel;
use crate::frame::wire::{PassRow, ViewRow};

/// Rows of group 1: binding number and name, in order.
pub const SCENE_BINDINGS: [&str; 6] = [
    "nodes",
    "triangles",
    "normals",
    "instances",
    "materials",
    "lights",
];

/// The layouts of all groups and kernels.
pub struct Layouts {
    /// Group 0: view, and the pass at a dynamic offset.
    pub frame: wgpu::BindGroupLayout,
    /// Group 1: [`SCENE_BINDINGS`], read only.
    pub scene: wgpu::BindGroupLayout,
    /// Group 2 of pictures: pixels, counters.
    pub picture: wgpu::BindGroupLayout,
    /// Group 2 of rays: rays (read only), hits.
    pub rays: wgpu::BindGroupLayout,
}

impl Layouts {
    /// Makes them.
    pub fn new(gpu: &Gpu) -> Self {
        let writable = wgpu::BufferBindingType::Storage { read_only: false };
        let readable = wgpu::BufferBindingType::Storage { read_only: true };
        let group = |label, types: &[(wgpu::BufferBindingType, bool, Option<u64>)]| {
            let entries: Vec<_> = types
                .iter()
                .zip(0_u32..)
                .map(
                    |(&(ty, has_dynamic_offset, size), binding)| wgpu::BindGroupLayoutEntry {
                        binding,
                        visibility: wgpu::ShaderStages::COMPUTE,
                        ty: wgpu::BindingType::Buffer {
                            ty,
                            has_dynamic_offset,
                            min_binding_size: size.and_then(NonZeroU64::new),
                        },
                        count: None,
                    },
                )
                .collect();
            gpu.device
                .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                    label: Some(label),
                    entries: &entries,
                })
        };
        let uniform = wgpu::BufferBindingType::Uniform;
        Self {
            frame: group(
                "frame",
                &[
                    (uniform, false, Some(size_of::<ViewRow>() as u64)),
                    (uniform, true, Some(size_of::<PassRow>() as u64)),
                ],
            ),
            scene: group("scene", &SCENE_BINDINGS.map(|_| (readable, false, None))),
            picture: group("picture", &[(writable, false, None); 2]),
            rays: group("rays", &[(readable, false, None), (writable, false, None)]),
        }
    }

    /// The layout of a kernel's pipeline.
    pub fn pipeline(&self, gpu: &Gpu, kernel: Kernel) -> wgpu::PipelineLayout {
        let work = match kernel {
            Kernel::Whitted => &self.picture,
            Kernel::Intersect => &self.rays,
        };
        gpu.device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(kernel.name()),
                bind_group_layouts: &[Some(&self.frame), Some(&self.scene), Some(work)],
                immediate_size: 0,
            })
    }
}

/// A bind group of whole buffers, bindings counted from 0.
pub fn bind(
    gpu: &Gpu,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    buffers: &[&wgpu::Buffer],
) -> wgpu::BindGroup {
    let entries: Vec<_> = buffers
        .iter()
        .zip(0_u32..)
        .map(|(buffer, binding)| wgpu::BindGroupEntry {
            binding,
            resource: buffer.as_entire_binding(),
        })
        .collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(label),
        layout,
        entries: &entries,
    })
}
