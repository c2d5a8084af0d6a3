//! The present pass: one triangle that reads the picture's buffer and writes display light.
//!
//! Twin of `tone.rs` on the device (`shaders/present.wgsl`). The picture comes either from where the GPU
//! tracer left it, without a copy, or from the host, uploaded into a buffer kept here.

use bytemuck::{Pod, Zeroable};
use glam::UVec2;

use crate::trace::Picture;
use crate::trace::gpu::DevicePicture;
use crate::world::ToneMap;

/// `Present` of `shaders/present.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Present {
    picture_size: [u32; 2],
    target_size: [u32; 2],
    gain: f32,
    tone: u32,
    stride: u32,
    encode: u32,
}

/// The shader's text.
const SHADER: &str = include_str!("../../../shaders/present.wgsl");

/// How a picture becomes display light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Stops.
    pub exposure: f32,
    /// Tone curve.
    pub tone: ToneMap,
}

/// A picture in a buffer, as the pass reads it.
struct Source {
    pixels: wgpu::Buffer,
    size: UVec2,
    stride: u32,
}

/// The pipeline, and the buffers it reads.
pub struct PresentPass {
    pipeline: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
    uniform: wgpu::Buffer,
    uploaded: Option<wgpu::Buffer>,
    source: Option<Source>,
    encode: bool,
}

impl PresentPass {
    /// A pass that writes to targets of a format; nothing to show yet.
    pub fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Self {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("present"),
            source: wgpu::ShaderSource::Wgsl(SHADER.into()),
        });
        let layout = bind_group_layout(device);
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("present.uniform"),
            size: size_of::<Present>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self {
            pipeline: pipeline(device, &layout, &module, format),
            layout,
            uniform,
            uploaded: None,
            source: None,
            encode: !format.is_srgb(),
        }
    }

    /// Shows the picture where the GPU tracer left it. The buffer must be of the same device.
    pub fn show_device(&mut self, picture: &DevicePicture) {
        self.uploaded = None;
        self.source = Some(Source {
            pixels: picture.pixels.clone(),
            size: picture.size,
            stride: 4,
        });
    }

    /// Uploads and shows a picture of the host; an empty one shows nothing.
    pub fn show_host(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, picture: &Picture) {
        let bytes: &[u8] = bytemuck::cast_slice(&picture.pixels);
        if bytes.is_empty() {
            self.source = None;
            return;
        }
        let size = bytes.len() as u64;
        let fits = |buffer: &wgpu::Buffer| buffer.size() == size;
        let buffer = self.uploaded.take().filter(fits).unwrap_or_else(|| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("present.picture"),
                size,
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        });
        queue.write_buffer(&buffer, 0, bytes);
        self.uploaded = Some(buffer.clone());
        self.source = Some(Source {
            pixels: buffer,
            size: picture.size,
            stride: 3,
        });
    }

    /// Draws the picture over the whole target; black where there is none.
    pub fn draw(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        pass: &mut wgpu::RenderPass,
        target_size: UVec2,
        look: Look,
    ) {
        let Some(source) = &self.source else {
            return;
        };
        let uniform = Present {
            picture_size: source.size.to_array(),
            target_size: target_size.to_array(),
            gain: look.exposure.exp2(),
            tone: look.tone as u32,
            stride: source.stride,
            encode: u32::from(self.encode),
        };
        queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&uniform));
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("present"),
            layout: &self.layout,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: self.uniform.as_entire_binding(),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: source.pixels.as_entire_binding(),
                },
            ],
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
    }
}

fn bind_group_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("present"),
        entries: &[
            entry(0, wgpu::BufferBindingType::Uniform),
            entry(1, wgpu::BufferBindingType::Storage { read_only: true }),
        ],
    })
}

fn pipeline(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    module: &wgpu::ShaderModule,
    format: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("present"),
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("present"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("vertex"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some("fragment"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The uniform as the shader declares it, read by naga.
    #[test]
    fn the_uniform_has_the_layout_of_the_shader() {
        let module = naga::front::wgsl::parse_str(SHADER).expect("present.wgsl parses");
        let (_, declared) = module
            .types
            .iter()
            .find(|(_, ty)| ty.name.as_deref() == Some("Present"))
            .expect("present.wgsl declares Present");
        let naga::TypeInner::Struct { members, span } = &declared.inner else {
            panic!("Present is no struct");
        };
        let here = [
            ("picture_size", std::mem::offset_of!(Present, picture_size)),
            ("target_size", std::mem::offset_of!(Present, target_size)),
            ("gain", std::mem::offset_of!(Present, gain)),
            ("tone", std::mem::offset_of!(Present, tone)),
            ("stride", std::mem::offset_of!(Present, stride)),
            ("encode", std::mem::offset_of!(Present, encode)),
        ];
        assert_eq!(*span as usize, size_of::<Present>());
        assert_eq!(members.len(), here.len());
        for (member, (name, offset)) in members.iter().zip(here) {
            assert_eq!(member.name.as_deref(), Some(name));
            assert_eq!(member.offset as usize, offset, "{name}");
        }
    }

    #[test]
    fn tone_curves_have_the_numbers_of_the_shader() {
        let numbers = [ToneMap::Clip, ToneMap::Reinhard, ToneMap::Filmic].map(|tone| tone as u32);
        assert_eq!(numbers, [0, 1, 2]);
        assert!(SHADER.contains("TONE_REINHARD = 1u") && SHADER.contains("TONE_FILMIC = 2u"));
    }
}
