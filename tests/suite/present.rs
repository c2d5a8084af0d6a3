//! The tone curve on the device against its twin on the CPU. Any adapter will do; without one this fails.

use glam::{UVec2, Vec3};
use orrery_engine::present::{Look, PresentPass, display_rgb8};
use orrery_engine::trace::Picture;
use orrery_engine::trace::gpu::{AdapterChoice, DevicePicture, Gpu};
use orrery_engine::world::ToneMap;

const TONES: [ToneMap; 3] = [ToneMap::Clip, ToneMap::Reinhard, ToneMap::Filmic];

/// Wide enough that a row of the target needs no padding: 64 * 4 = 256 bytes.
const SIZE: UVec2 = UVec2::new(64, 48);

/// Light from far below black to far above white, in every channel.
fn picture() -> Picture {
    let mut picture = Picture::new(SIZE);
    for (i, pixel) in picture.pixels.iter_mut().enumerate() {
        let t = i as f32 / (SIZE.x * SIZE.y) as f32;
        *pixel = Vec3::new((t * 12.0 - 8.0).exp2(), t * 1.1 - 0.05, (1.0 - t) * 40.0);
    }
    picture
}

fn gpu() -> Gpu {
    Gpu::open(Gpu::instance(), &AdapterChoice::Any, None).expect("a GPU, software will do")
}

/// What the pass writes into a target of a size.
fn presented(gpu: &Gpu, pass: &PresentPass, size: UVec2, look: Look) -> Vec<[u8; 4]> {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width: size.x,
            height: size.y,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    let bytes = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(size.x * size.y * 4),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let begin = wgpu::CommandEncoderDescriptor::default();
    let mut encoder = gpu.device.create_command_encoder(&begin);
    {
        let mut render = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.draw(&gpu.device, &gpu.queue, &mut render, size, look);
    }
    let target = wgpu::TexelCopyBufferInfo {
        buffer: &bytes,
        layout: wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(size.x * 4),
            rows_per_image: None,
        },
    };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), target, texture.size());
    gpu.queue.submit([encoder.finish()]);
    let slice = bytes.slice(..);
    slice.map_async(wgpu::MapMode::Read, |mapped| {
        mapped.expect("the target can be read")
    });
    gpu.device
        .poll(wgpu::PollType::wait_indefinitely())
        .expect("the device works");
    gpu.check().expect("the pass is valid");
    let mapped = slice.get_mapped_range().expect("the target was mapped");
    bytemuck::cast_slice(&mapped).to_vec()
}

fn assert_twins(shown: &[[u8; 4]], picture: &Picture, look: Look) {
    for (i, (shown, &pixel)) in shown.iter().zip(&picture.pixels).enumerate() {
        let expected = display_rgb8(pixel, look.exposure, look.tone);
        for c in 0..3 {
            let difference = shown[c].abs_diff(expected[c]);
            assert!(
                difference <= 1,
                "{look:?}, pixel {i} of light {pixel}: {shown:?} on the device, {expected:?} here"
            );
        }
    }
}

#[test]
fn the_present_shader_equals_its_twin_on_the_cpu() {
    let gpu = gpu();
    let picture = picture();
    let mut pass = PresentPass::new(&gpu.device, wgpu::TextureFormat::Rgba8Unorm);
    pass.show_host(&gpu.device, &gpu.queue, &picture);
    for tone in TONES {
        for exposure in [-2.0, 0.0, 1.5] {
            let look = Look { exposure, tone };
            assert_twins(&presented(&gpu, &pass, SIZE, look), &picture, look);
        }
    }
}

#[test]
fn a_picture_left_on_the_device_is_shown_like_one_from_the_host() {
    let gpu = gpu();
    let picture = picture();
    let rgba: Vec<[f32; 4]> = picture
        .pixels
        .iter()
        .map(|p| [p.x, p.y, p.z, 1.0])
        .collect();
    let pixels = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: size_of_val(rgba.as_slice()) as u64,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    gpu.queue
        .write_buffer(&pixels, 0, bytemuck::cast_slice(&rgba));
    let mut pass = PresentPass::new(&gpu.device, wgpu::TextureFormat::Rgba8Unorm);
    pass.show_device(&DevicePicture { size: SIZE, pixels });
    let look = Look {
        exposure: 0.0,
        tone: ToneMap::Filmic,
    };
    assert_twins(&presented(&gpu, &pass, SIZE, look), &picture, look);
}

#[test]
fn a_smaller_picture_fills_the_window_smoothly() {
    let gpu = gpu();
    let mut pass = PresentPass::new(&gpu.device, wgpu::TextureFormat::Rgba8Unorm);
    let mut ramp = Picture::new(UVec2::new(16, 4));
    for (i, pixel) in ramp.pixels.iter_mut().enumerate() {
        *pixel = Vec3::splat((i % 16) as f32 / 15.0);
    }
    pass.show_host(&gpu.device, &gpu.queue, &ramp);
    let look = Look {
        exposure: 0.0,
        tone: ToneMap::Clip,
    };
    let shown = presented(&gpu, &pass, SIZE, look);
    let row: Vec<u8> = shown[..64].iter().map(|pixel| pixel[0]).collect();
    assert!(row.is_sorted(), "a ramp that grew came out uneven: {row:?}");
    assert_eq!((row[0], row[63]), (0, 255));
}
