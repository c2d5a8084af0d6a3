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
        let layout = layouts.pipeline(gpu, kernel);
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
    match kernel {
        Kernel::Whitted => special,
        Kernel::Intersect => {
            let shapes = Features {
                meshes: special.features.meshes,
                sphere_trees: special.features.sphere_trees,
                spheres: special.features.spheres,
                planes: special.features.planes,
                cuboids: special.features.cuboids,
                discs: special.features.discs,
                cones: special.features.cones,
                tori: special.features.tori,
                ..Features::default()
            };
            // Rays of a buffer leave no surface.
            Specialisation::new(shapes, 1).with(Kernels {
                offsets: Offset::default(),
                ..special.kernels
            })
        }
        _ => Specialisation::new(Features::default(), 1),
    }
}
