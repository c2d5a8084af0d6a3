//! What kernels bind: group 0 the frame, group 1 the scene, group 2 what the pass works on, group 3 texels, where there are
//! textures.
//!
//! Kernels that work on trees have one group of their own. Twin of `shaders/shared/scene.wgsl` and the heads of the kernels; the table is in `shaders/README.md`.
//! Two storage buffers of group 2 and the six of group 1 are the eight that every device has.

use std::collections::HashMap;
use std::num::NonZeroU64;

use super::context::Gpu;
use super::shader::Kernel;
use crate::frame::wire::{PassRow, StageRow, ViewRow};

/// Rows of group 1: binding number and name, in order.
pub const SCENE_BINDINGS: [&str; 6] = [
    "nodes",
    "triangles",
    "vertices",
    "instances",
    "materials",
    "lights",
];

/// How a kernel uses a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// It reads.
    Read,
    /// It reads and writes.
    Write,
}

/// What a kernel that works on trees binds in its only group, behind the uniform `stage`: names and uses in
/// order. Empty for the kernels that trace.
pub fn tree_bindings(kernel: Kernel) -> &'static [(&'static str, Access)] {
    use Access::{Read, Write};
    match kernel {
        Kernel::Whitted | Kernel::Edges | Kernel::Antialias | Kernel::Intersect | Kernel::Leave => {
            &[]
        }
        Kernel::Deform => &[
            ("jobs", Read),
            ("vertices", Write),
            ("data", Read),
            ("steps", Read),
            ("params", Read),
        ],
        Kernel::Normals => &[("jobs", Read), ("vertices", Write), ("data", Read)],
        Kernel::Refit => &[
            ("jobs", Read),
            ("triangles", Write),
            ("nodes", Write),
            ("vertices", Read),
            ("partials", Write),
        ],
        Kernel::Cost => &[
            ("jobs", Read),
            ("partials", Read),
            ("nodes", Write),
            ("costs", Write),
        ],
        Kernel::Span => &[("boxes", Read), ("build", Write)],
        Kernel::Morton => &[("boxes", Read), ("build", Write), ("pairs", Write)],
        Kernel::SortCount => &[("pairs", Read), ("counts", Write)],
        Kernel::SortScan => &[("counts", Write), ("totals", Write)],
        Kernel::SortScatter => &[
            ("pairs", Read),
            ("counts", Read),
            ("totals", Read),
            ("sorted", Write),
        ],
        Kernel::Split => &[
            ("pairs", Read),
            ("build", Write),
            ("nodes", Write),
            ("ranges", Write),
        ],
        Kernel::Fit => &[("boxes", Read), ("build", Write), ("nodes", Write)],
    }
}

/// The layouts of all groups and kernels.
pub struct Layouts {
    /// Group 0: view, and the pass at a dynamic offset.
    pub frame: wgpu::BindGroupLayout,
    /// Group 1: [`SCENE_BINDINGS`], read only.
    pub scene: wgpu::BindGroupLayout,
    /// Group 2 of pictures: pixels, report.
    pub picture: wgpu::BindGroupLayout,
    /// Group 2 of rays: rays (read only), hits.
    pub rays: wgpu::BindGroupLayout,
    /// Group 3: the memory of texels.
    pub texels: wgpu::BindGroupLayout,
    /// The only group of each kernel of [`tree_bindings`].
    trees: HashMap<Kernel, wgpu::BindGroupLayout>,
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
        let tree = |kernel: Kernel| {
            let bindings = tree_bindings(kernel)
                .iter()
                .map(|(_, access)| match access {
                    Access::Read => (readable, false, None),
                    Access::Write => (writable, false, None),
                });
            let stage = (uniform, true, Some(size_of::<StageRow>() as u64));
            let all: Vec<_> = std::iter::once(stage).chain(bindings).collect();
            (kernel, group(kernel.name(), &all))
        };
        let on_trees = |kernel: &Kernel| !tree_bindings(*kernel).is_empty();
        Self {
            trees: Kernel::ALL.into_iter().filter(on_trees).map(tree).collect(),
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
            texels: texels_layout(gpu),
        }
    }

    /// The layout of the only group of a kernel that works on trees.
    pub fn tree(&self, kernel: Kernel) -> &wgpu::BindGroupLayout {
        &self.trees[&kernel]
    }

    /// The layout of a kernel's pipeline; one that reads textures has a group more.
    pub fn pipeline(&self, gpu: &Gpu, kernel: Kernel, textures: bool) -> wgpu::PipelineLayout {
        let mut groups = match kernel {
            Kernel::Whitted | Kernel::Edges | Kernel::Antialias => {
                vec![Some(&self.frame), Some(&self.scene), Some(&self.picture)]
            }
            Kernel::Intersect | Kernel::Leave => {
                vec![Some(&self.frame), Some(&self.scene), Some(&self.rays)]
            }
            _ => vec![Some(self.tree(kernel))],
        };
        if textures {
            groups.push(Some(&self.texels));
        }
        gpu.device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(kernel.name()),
                bind_group_layouts: &groups,
                immediate_size: 0,
            })
    }
}

fn texels_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    gpu.device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("texels"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Uint,
                    view_dimension: wgpu::TextureViewDimension::D2Array,
                    multisampled: false,
                },
                count: None,
            }],
        })
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
