//! The memory of texels on the device: a texture of integers that is read by number, in a group of its own.
//!
//! A texture rather than a buffer: all storage buffers that every device offers are in use. Bound by kernels that read
//! textures alone. Its layout is that of `engine/src/trace/pack/texels.rs`.

use bytemuck::cast_slice;

use super::context::Gpu;
use super::layout::Layouts;
use crate::frame::wire::TEXELS_SHIFT;
use crate::trace::TraceError;
use crate::trace::pack::{Texel, Texels};

/// Texels of a row, and rows of a layer.
const EDGE: usize = 1 << TEXELS_SHIFT;

/// Group 3; none where there are no texels.
#[derive(Default)]
pub struct TexelMemory {
    /// The scene's.
    pub group: Option<wgpu::BindGroup>,
    /// For kernels that can read textures, of scenes that have none.
    empty: Option<wgpu::BindGroup>,
}

impl TexelMemory {
    /// What kernels bind.
    pub fn bound(&self) -> Option<&wgpu::BindGroup> {
        self.group.as_ref().or(self.empty.as_ref())
    }

    /// From now on there is something to bind whether the scene has textures or not.
    ///
    /// # Errors
    /// [`TraceError::TooLarge`].
    pub fn bind_always(&mut self, gpu: &Gpu, layouts: &Layouts) -> Result<(), TraceError> {
        self.empty = Some(self.fill(gpu, layouts, &[Texel::default()])?);
        Ok(())
    }

    /// Brings the device up to the packed textures; returns the bytes written.
    ///
    /// # Errors
    /// [`TraceError::TooLarge`].
    pub fn upload(
        &mut self,
        gpu: &Gpu,
        layouts: &Layouts,
        texels: &mut Texels,
    ) -> Result<u64, TraceError> {
        if !texels.is_stale {
            return Ok(0);
        }
        self.group = None;
        let memory = &texels.memory[..];
        if !memory.is_empty() {
            self.group = Some(self.fill(gpu, layouts, memory)?);
        }
        texels.is_stale = false;
        Ok(size_of_val(memory) as u64)
    }

    fn fill(
        &self,
        gpu: &Gpu,
        layouts: &Layouts,
        memory: &[Texel],
    ) -> Result<wgpu::BindGroup, TraceError> {
        let layers = memory.len().div_ceil(EDGE * EDGE) as u32;
        let most = gpu.device.limits().max_texture_array_layers;
        if layers > most {
            return Err(TraceError::TooLarge(format!(
                "the scene's textures take {layers} layers of {EDGE} x {EDGE} texels; {} has at most {most} (max_texture_array_layers)",
                gpu.describe()
            )));
        }
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("texels"),
            size: wgpu::Extent3d {
                width: EDGE as u32,
                height: memory.len().div_ceil(EDGE).min(EDGE) as u32,
                depth_or_array_layers: layers,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rg32Uint,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        for (layer, texels) in memory.chunks(EDGE * EDGE).enumerate() {
            let (whole, rest) = texels.split_at(texels.len() / EDGE * EDGE);
            write(gpu, &texture, [0, layer], whole);
            write(gpu, &texture, [whole.len() / EDGE, layer], rest);
        }
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..wgpu::TextureViewDescriptor::default()
        });
        Ok(gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("texels"),
            layout: &layouts.texels,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(&view),
            }],
        }))
    }
}

/// Writes whole rows, or a part of one, from a row of a layer on.
fn write(gpu: &Gpu, texture: &wgpu::Texture, [row, layer]: [usize; 2], texels: &[Texel]) {
    if texels.is_empty() {
        return;
    }
    let width = texels.len().min(EDGE);
    gpu.queue.write_texture(
        wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: 0,
            origin: wgpu::Origin3d {
                x: 0,
                y: row as u32,
                z: layer as u32,
            },
            aspect: wgpu::TextureAspect::All,
        },
        cast_slice(texels),
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some((width * size_of::<Texel>()) as u32),
            rows_per_image: None,
        },
        wgpu::Extent3d {
            width: width as u32,
            height: (texels.len() / width) as u32,
            depth_or_array_layers: 1,
        },
    );
}
