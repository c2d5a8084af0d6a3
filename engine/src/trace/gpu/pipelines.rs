//! Compiled kernels, one for each set of features that was asked for.

use std::collections::HashMap;

use super::by_hand::HandKernel;
use super::context::Gpu;
use super::layout::Layouts;
use super::shader::{Kernel, Specialisation, shader_source};
use crate::frame::{Features, Kernels, Offset};
use crate::trace::TraceError;

/// A compiled kernel.
#[derive(Clone)]
pub struct Pipeline {
    /// What a pass sets.
    pub compute: wgpu::ComputePipeline,
    /// Invocations of a workgroup.
    pub workgroup: [u32; 3],
}

/// The cache. Asking waits for the compiler, so no picture depends on how long it takes.
#[derive(Default)]
pub struct Pipelines {
    compiled: HashMap<(Kernel, Specialisation, Option<HandKernel>), Pipeline>,
    /// In place of the kernel of pictures.
    pub by_hand: Option<HandKernel>,
}

impl Pipelines {
    /// The kernel for these needs.
    ///
    /// # Errors
    /// [`TraceError::Device`] if the driver refuses it.
    pub fn get(
        &mut self,
        gpu: &Gpu,
        layouts: &Layouts,
        kernel: Kernel,
        special: Specialisation,
    ) -> Result<Pipeline, TraceError> {
        let special = relevant(kernel, special);
        let by_hand = self.by_hand.filter(|_| kernel == Kernel::Whitted);
        if let Some(pipeline) = self.compiled.get(&(kernel, special, by_hand)) {
            return Ok(pipeline.clone());
        }
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
        let module = module_of(gpu, kernel, shader.source);
        let layout = layouts.pipeline(gpu, kernel, special.features.reads_texels());
        let compute = gpu
            .device
            .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(kernel.name()),
                layout: Some(&layout),
                module: &module,
                entry_point: Some(kernel.name()),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            });
        gpu.check()?;
        let pipeline = Pipeline {
            compute,
            workgroup: shader.workgroup,
        };
        self.compiled
            .insert((kernel, special, by_hand), pipeline.clone());
        Ok(pipeline)
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
    // SAFETY: every loop of our kernels ends, and what comes from elsewhere promises the same (`HandKernel`). Walks visit each node of a tree at most
    // once, and builders name each node by one slot; rounds of a shadow ray have ever greater keys;
    // a path's generations and straight crossings are counted; all other loops count to a number of rows.
    #[allow(unsafe_code)]
    unsafe {
        gpu.device.create_shader_module_trusted(descriptor, checks)
    }
}

/// Drops from a specialisation what the kernel does not read, so that it is not compiled twice.
fn relevant(kernel: Kernel, special: Specialisation) -> Specialisation {
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
    let rays = Specialisation::new(shapes, 1).with(special.kernels);
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
