//! Compiled kernels, one for each set of features that was asked for.

use std::collections::HashMap;

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
    compiled: HashMap<(Kernel, Specialisation), Pipeline>,
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
        if let Some(pipeline) = self.compiled.get(&(kernel, special)) {
            return Ok(pipeline.clone());
        }
        let shader = shader_source(kernel, special).map_err(|why| {
            TraceError::Device(format!(
                "the shader {} does not compose: {why}",
                kernel.name()
            ))
        })?;
        let module = gpu
            .device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(kernel.name()),
                source: wgpu::ShaderSource::Wgsl(shader.source.into()),
            });
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
        self.compiled.insert((kernel, special), pipeline.clone());
        Ok(pipeline)
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
