//! The GPU tracer: one WGSL kernel a picture, through wgpu.
//!
//! The report (2008) wrote its tracer in CUDA for one maker's cards; here the same algorithm, with the
//! moving scenes it left out, runs on whatever wgpu reaches. [`Gpu`] is the device, [`GpuTracer`] the
//! tracer; the shaders are in `shaders/`, whose README has the table of bindings.

mod buffers;
mod canvas;
mod context;
mod layout;
mod pipelines;
mod rate;
mod rays;
mod readback;
mod report;
mod shader;
mod texels;
mod tracer;
pub mod trees;
mod upload;

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
