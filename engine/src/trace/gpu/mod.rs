//! The GPU tracer: one WGSL kernel through wgpu.

mod context;
mod shader;

pub use context::{AdapterChoice, Gpu, STORAGE_BUFFERS};
pub use shader::{Kernel, Specialisation, TYPES_SOURCE, shader_module, shader_source};

/// Where the GPU left the picture: a storage buffer of `size.x * size.y` linear RGBA f32 pixels, top row first.
#[derive(Clone, Debug)]
pub struct DevicePicture {
    /// Pixels across and down.
    pub size: glam::UVec2,
    /// 16 bytes a pixel, usable as read-only storage.
    pub pixels: wgpu::Buffer,
}
