//! Which tracer runs where: a real GPU if there is one, else all cores.

use std::sync::Arc;

use super::cpu::{CpuTracer, Instructions};
use super::gpu::{AdapterChoice, Gpu, GpuTracer};
use super::reference::ReferenceTracer;
use super::{Backend, TraceError, Tracer};

/// What the user asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum BackendChoice {
    /// A hardware GPU, else the CPU.
    #[default]
    Auto,
    /// This one. `gpu` takes a software adapter where there is no other.
    Backend(Backend),
}

/// Opens the tracer of a choice, and says in a sentence if it is not what one would expect.
///
/// `adapter` is a number or part of a name as `orrery adapters` lists them; naming one asks for it, software
/// or not. `gpu` is a device that is already open (the window's): it is shared, and its adapter stands.
///
/// # Errors
/// [`TraceError::NoDevice`] if the one asked for is not there; [`BackendChoice::Auto`] without an adapter's
/// name always finds the CPU.
pub fn open_tracer(
    choice: BackendChoice,
    adapter: Option<&str>,
    gpu: Option<Arc<Gpu>>,
) -> Result<(Box<dyn Tracer>, Option<String>), TraceError> {
    let named = adapter.map(|name| AdapterChoice::Named(name.to_owned()));
    let on_gpu = |gpu: Option<Arc<Gpu>>, which: AdapterChoice| -> Result<Box<dyn Tracer>, _> {
        let gpu = match gpu {
            Some(gpu) => gpu,
            None => Arc::new(Gpu::open(Gpu::instance(), &which, None)?),
        };
        Ok(Box::new(GpuTracer::new(gpu)?))
    };
    match choice {
        BackendChoice::Backend(Backend::Cpu) => Ok((on_processor()?, None)),
        BackendChoice::Backend(Backend::Reference) => Ok((Box::new(ReferenceTracer::new()), None)),
        BackendChoice::Backend(Backend::Gpu) => {
            let which = named.unwrap_or(AdapterChoice::Any);
            Ok((on_gpu(gpu, which)?, None))
        }
        BackendChoice::Auto => {
            if let Some(which) = named {
                return Ok((on_gpu(gpu, which)?, None));
            }
            let software = gpu.as_ref().is_some_and(|gpu| gpu.is_software());
            // A software adapter may present the window; the CPU tracer is the faster one all the same.
            let shared = gpu.filter(|_| !software);
            match on_gpu(shared, AdapterChoice::Hardware) {
                Ok(tracer) => Ok((tracer, None)),
                Err(why) => {
                    let note = format!("tracing on the CPU: {why}");
                    Ok((on_processor()?, Some(note)))
                }
            }
        }
    }
}

/// The processor's tracer, unless instructions are asked for that nobody knows.
fn on_processor() -> Result<Box<dyn Tracer>, TraceError> {
    Instructions::check_named().map_err(TraceError::NoDevice)?;
    Ok(Box::new(CpuTracer::new()))
}
