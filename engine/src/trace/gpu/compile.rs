//! One kernel: composed for what a scene needs, and compiled by the driver.
//!
//! Called by [`super::pipelines`], which keeps what comes of it.

use super::by_hand::HandKernel;
use super::context::Gpu;
use super::layout::Layouts;
use super::shader::{Kernel, Specialisation, shader_source};
use crate::frame::{Features, Kernels, Offset};
use crate::trace::TraceError;

/// Generations that the general kernel has room for.
const GENERAL_GENERATIONS: u32 = 16;

/// A compiled kernel.
#[derive(Clone)]
pub struct Pipeline {
    /// What a pass sets.
    pub compute: wgpu::ComputePipeline,
    /// Invocations of a workgroup.
    pub workgroup: [u32; 3],
}

/// What a kernel is compiled for; by hand: in the place of the kernel of pictures.
pub type Key = (Kernel, Specialisation, Option<HandKernel>);

/// What the kernel binds.
pub fn layout_of(gpu: &Gpu, layouts: &Layouts, (kernel, special, _): Key) -> wgpu::PipelineLayout {
    layouts.pipeline(gpu, kernel, special.features.reads_texels())
}

/// Composes and compiles.
pub fn compile(
    gpu: &Gpu,
    (kernel, special, by_hand): Key,
    layout: &wgpu::PipelineLayout,
) -> Result<Pipeline, TraceError> {
    let shader = match by_hand {
        Some(by_hand) => by_hand.shader(special),
        None => shader_source(kernel, special),
    };
    let shader = shader.map_err(|why| {
        TraceError::Device(format!(
            "the shader {} does not compose: {why}",
            kernel.name()
        ))
    })?;
    // Errors of this thread alone: another one's frame goes on.
    let filters = [wgpu::ErrorFilter::Validation, wgpu::ErrorFilter::Internal];
    let scopes = filters.map(|filter| gpu.device.push_error_scope(filter));
    let module = module_of(gpu, kernel, shader.source);
    let compute = gpu
        .device
        .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(kernel.name()),
            layout: Some(layout),
            module: &module,
            entry_point: Some(kernel.name()),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: gpu.kept_pipelines(),
        });
    let inner_first = scopes.into_iter().rev();
    let errors: Vec<_> = inner_first
        .filter_map(|scope| pollster::block_on(scope.pop()))
        .collect();
    match errors.first() {
        Some(error) => Err(TraceError::Device(format!(
            "{} refuses the shader {}: {error}",
            gpu.describe(),
            kernel.name()
        ))),
        None => Ok(Pipeline {
            compute,
            workgroup: shader.workgroup,
        }),
    }
}

/// What serves every scene of the same arithmetic.
pub fn general(special: Specialisation) -> Specialisation {
    Specialisation {
        cutoff: true,
        counts: true,
        ..Specialisation::new(Features::all(), GENERAL_GENERATIONS)
            .with(special.kernels)
            .skipping(special.skips)
    }
}

/// A kernel without the counter that wgpu puts into every loop, in case one does not end: that takes registers and about
/// 4 % of a picture's time on an NVIDIA H200. Bounds of buffers and arrays stay checked.
fn module_of(gpu: &Gpu, kernel: Kernel, source: String) -> wgpu::ShaderModule {
    let descriptor = wgpu::ShaderModuleDescriptor {
        label: Some(kernel.name()),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    };
    let checks = wgpu::ShaderRuntimeChecks {
        force_loop_bounding: false,
        ..wgpu::ShaderRuntimeChecks::checked()
    };
    // SAFETY: every loop of our kernels ends, and what comes from elsewhere promises the same (`HandKernel`). Walks visit each
    // node of a tree, and each triangle of a leaf, at most once, and builders name each node by one slot; rounds of a shadow ray
    // have ever greater keys; a path's generations and straight crossings are counted; all other loops count to a number of rows.
    #[allow(unsafe_code)]
    unsafe {
        gpu.device.create_shader_module_trusted(descriptor, checks)
    }
}

/// Drops from a specialisation what the kernel does not read, so that it is not compiled twice.
pub fn relevant(kernel: Kernel, special: Specialisation) -> Specialisation {
    let shapes = Features {
        reflection: false,
        transmission: false,
        smooth_normals: false,
        spot_lights: false,
        directional_lights: false,
        fade: false,
        absorption: false,
        curved: false,
        sky: false,
        panorama: false,
        textures: special.features.textures && special.features.cutouts,
        normal_maps: false,
        vertex_colors: special.features.vertex_colors && special.features.cutouts,
        ..special.features
    };
    let rays = Specialisation {
        stack: special.stack,
        ..Specialisation::new(shapes, 1).with(special.kernels)
    };
    match kernel {
        Kernel::Whitted | Kernel::Antialias => special,
        Kernel::Leave => rays,
        // Rays of a buffer leave no surface.
        Kernel::Intersect => rays.with(Kernels {
            offsets: Offset::default(),
            ..special.kernels
        }),
        _ => Specialisation::new(Features::default(), 1),
    }
}
