//! From `--backend` and `--adapter` to an open tracer.

use orrery_engine::trace::{Backend, BackendChoice as Choice, Tracer, open_tracer};

use crate::args::{BackendChoice, Common};
use crate::failure::Failure;
use crate::output::note;

/// Opens the tracer that was asked for; says in a line if `auto` had to make do without a GPU.
pub fn open(common: &Common) -> Result<Box<dyn Tracer>, Failure> {
    open_choice(common.backend, common)
}

/// Opens one backend, whatever `--backend` says, on the adapter that was asked for.
pub fn open_choice(choice: BackendChoice, common: &Common) -> Result<Box<dyn Tracer>, Failure> {
    let (tracer, remark) = open_tracer(wanted(choice), common.adapter.as_deref(), None)?;
    if let Some(remark) = remark {
        note(remark);
    }
    Ok(tracer)
}

/// What a word of `--backend` means to the engine.
pub fn wanted(choice: BackendChoice) -> Choice {
    match choice {
        BackendChoice::Auto => Choice::Auto,
        BackendChoice::Gpu => Choice::Backend(Backend::Gpu),
        BackendChoice::Cpu => Choice::Backend(Backend::Cpu),
        BackendChoice::Reference => Choice::Backend(Backend::Reference),
    }
}
