//! `orrery adapters`: what wgpu sees, and what `--backend auto` would take.

use orrery_engine::trace::gpu::{AdapterChoice, Gpu};

use crate::failure::Failure;
use crate::output::say;

/// Lists the adapters. That there is none is an answer, not a failure.
pub fn run() -> Result<(), Failure> {
    let adapters = Gpu::adapters(&Gpu::instance());
    for (number, info) in adapters.iter().enumerate() {
        say(format_args!(
            "{number}  {}  ({:?}, {:?}, {} {})",
            info.name, info.device_type, info.backend, info.driver, info.driver_info
        ));
    }
    if adapters.is_empty() {
        say("no adapter; a driver for Vulkan, Metal or DirectX 12 would bring one");
    }
    match Gpu::open(Gpu::instance(), &AdapterChoice::Hardware, None) {
        Ok(gpu) => say(format_args!("auto: gpu, on {}", gpu.describe())),
        Err(why) => say(format_args!("auto: cpu, because {why}")),
    }
    Ok(())
}
