//! The GPU tracer: one WGSL kernel a picture, through wgpu.
//!
//! The report (2008) wrote its tracer in CUDA for one maker's cards; here the same algorithm, with the
//! moving scenes it left out, runs on whatever wgpu reaches. [`Gpu`] is the device, [`GpuTracer`] the
//! tracer; the shaders are in `shaders/`, whose README has the table of bindings.
//!
//! What was tried on an NVIDIA H200, 1920x1080, in milliseconds: the rays of a whole frame (primary, shadow, mirrored, shadow) of
//! a terrain of 2.1 million triangles and of 10,001 instances, and those pictures' kernel. Between runs of one form lie about 1 %.
//!
//! | form | terrain: rays, picture | instances: rays, picture |
//! |---|---|---|
//! | wgpu's counter in every loop | 1.97, 2.20 | 6.12, 6.85 |
//! | **without it** ([`wgpu::ShaderRuntimeChecks`]) | 1.91, 2.10 | 5.98, 6.63 |
//! | children sorted as integers, their slots in the low bits | 1.95, 2.15 | 6.02, 6.72 |
//! | nodes in a loop of their own within the loop over leaves | 2.09, 2.07 | 6.61, 6.60 |
//! | a copy of the walk for any-hit rays | 1.93, 2.09 | 6.06, 6.59 |
//! | workgroups of 32 / 128 rays instead of 64 | 1.94 / 1.90 | 6.04 / 5.93 |
//! | slabs by fused multiply-add, planes picked by the direction's signs | 2.02, 1.95 | 6.46, 6.38 |
//! | that, the shear as rows, children pushed without a branch | 1.79, 1.85 | 5.67, 6.11 |
//! | that, leaves of two triangles at most | 1.63, 1.67 | 5.13, 5.50 |
//! | Möller and Trumbore's test, which leaks | 1.75, 1.84 | 5.34, 5.75 |
//!
//! The two rows before the last are faster and not taken yet: rows round the shear twice where it was once, and smaller leaves
//! are more nodes to refit.

mod buffers;
mod by_hand;
mod canvas;
mod compile;
mod context;
mod kept;
mod layout;
mod pace;
mod pipelines;
mod rate;
mod rays;
mod readback;
mod report;
mod shader;
mod submit;
#[cfg(test)]
mod tests;
mod texels;
mod tracer;
pub mod trees;
mod upload;

pub use by_hand::HandKernel;
pub use context::{AdapterChoice, Gpu, STORAGE_BUFFERS};
pub use layout::{Access, SCENE_BINDINGS, tree_bindings};
pub(crate) use report::{Ends, Reports};
pub use shader::{Kernel, Shader, Specialisation, TYPES_SOURCE, shader_module, shader_source};
pub use tracer::GpuTracer;

/// Where the GPU left the picture: a storage buffer of `size.x * size.y` linear RGBA f32 pixels, top row first.
#[derive(Clone, Debug)]
pub struct DevicePicture {
    /// Pixels across and down.
    pub size: glam::UVec2,
    /// 16 bytes a pixel, usable as read-only storage.
    pub pixels: wgpu::Buffer,
}
