//! `orrery`: play, edit, render, measure and check ray-traced scenes in motion.
//!
//! One file a command; `args` is the whole command line on one page. Exit codes: 0 done, 1 the input is
//! bad, 2 usage, 3 no usable device.

mod adapters;
mod args;
mod assets;
mod bench;
mod check;
mod compare;
mod contact_sheet;
mod defects;
mod device;
mod explain;
mod failure;
mod heat;
mod interrupt;
mod output;
mod pattern;
mod play;
mod preview;
mod profile_log;
mod render;
mod stage;
mod video;
mod words;

use std::process::ExitCode;

use clap::Parser;

use args::{Cli, Command};
use failure::Failure;

fn main() -> ExitCode {
    let cli = Cli::parse();
    match run(&cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            output::complain(&failure);
            ExitCode::from(failure.exit_code())
        }
    }
}

fn run(cli: &Cli) -> Result<(), Failure> {
    orrery_engine::profile::install(&cli.common.log).map_err(Failure::Usage)?;
    match &cli.command {
        Some(_) if cli.scene.is_some() => Err(Failure::Usage(
            "a scene before a command: write `orrery SCENE`, or `orrery COMMAND SCENE`".into(),
        )),
        Some(
            Command::Bench(_) | Command::Check { .. } | Command::Compare(_) | Command::Adapters,
        ) if cli.common.profile.is_some() => Err(Failure::Usage(
            "--profile is for playing and rendering; this command runs no frames to write down"
                .into(),
        )),
        None => play::run(
            cli.scene.as_deref(),
            &cli.common,
            &cli.window,
            play::Mode::Play,
        ),
        Some(Command::Edit { scene }) => {
            play::run(Some(scene), &cli.common, &cli.window, play::Mode::Edit)
        }
        Some(Command::Render(request)) => render::run(request, &cli.common),
        Some(Command::Bench(request)) => bench::run(request, &cli.common),
        Some(Command::Compare(request)) => compare::run(request),
        Some(Command::Check { file }) => check::run(file),
        Some(Command::Adapters) => adapters::run(),
    }
}
