//! Kernels written by hand for one kind of scene, in the place of the one that traces pictures: what specialised pipelines
//! are measured against. Benchmarks alone bring any.

use super::GpuTracer;
use super::shader::{Kernel, Shader, Specialisation, stand_in_source};

/// WGSL with the entry point and the bindings of `whitted.wgsl`; it may import what `shaders/shared` has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct HandKernel {
    name: &'static str,
    source: &'static str,
}

impl HandKernel {
    /// A kernel of that name.
    ///
    /// # Safety
    /// Each loop of the source ends, whatever the scene: as all kernels, it is compiled without wgpu's counters in loops.
    #[allow(unsafe_code)]
    pub const unsafe fn new(name: &'static str, source: &'static str) -> Self {
        Self { name, source }
    }

    /// The kernel as plain WGSL.
    ///
    /// # Errors
    /// Where it is wrong, in naga's words.
    pub fn shader(self, special: Specialisation) -> Result<Shader, String> {
        stand_in_source(Kernel::Whitted, (self.name, self.source), special)
    }
}

impl GpuTracer {
    /// Traces pictures with this kernel from now on, whether the scene is of its kind or not; none: with our own.
    pub fn trace_by_hand(&mut self, kernel: Option<HandKernel>) {
        self.pipelines.by_hand = kernel;
    }
}
