//! Renders the ground-truth set with a backend and compares it with the reference pictures.
//!
//! Prints a row a scene; exit code 1 if a target is missed, 2 for wrong usage, 3 without a device.

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, ValueEnum};
use orrery_engine::trace::Backend;
use orrery_tests::tracers;
use orrery_tests::truth::{Row, TruthRun, TruthSet};

/// Render the ground-truth set and measure it against the reference pictures.
#[derive(Debug, Parser)]
struct Args {
    /// Folder with `scenes/*.json`, `reference/*.png` and `ambiguous_pixels.json`.
    dir: PathBuf,
    /// Scenes by name, or by the beginning of it; none: all.
    scenes: Vec<String>,
    /// What traces.
    #[arg(long, value_enum, default_value_t = Traced::Cpu)]
    backend: Traced,
    /// Folder for the pictures: NAME.png, 16-bit linear RGB.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Trace every N-th pixel across and down only; odd, and the picture's sides are multiples of it.
    #[arg(long, value_name = "N", default_value_t = 1)]
    every: u32,
}

/// Words of `--backend`.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Traced {
    Gpu,
    Cpu,
    Reference,
}

fn main() -> ExitCode {
    let args = Args::parse();
    match run(&args) {
        Ok(code) => ExitCode::from(code),
        Err((code, why)) => {
            let _ = writeln!(std::io::stderr(), "ground_truth: {why}");
            ExitCode::from(code)
        }
    }
}

fn run(args: &Args) -> Result<u8, (u8, String)> {
    if args.every.is_multiple_of(2) {
        return Err((2, "--every: expected an odd number".into()));
    }
    let set = TruthSet::open(&args.dir).map_err(|why| (1, why))?;
    let names = chosen(&set, &args.scenes)?;
    let backend = match args.backend {
        Traced::Gpu => Backend::Gpu,
        Traced::Cpu => Backend::Cpu,
        Traced::Reference => Backend::Reference,
    };
    let mut tracer = tracers::open(backend).map_err(|error| (3, error.to_string()))?;
    let run = TruthRun {
        out: args.out.clone(),
        every: args.every,
    };
    let mut out = std::io::stdout();
    let _ = writeln!(out, "{backend} on {}", tracer.device());
    let _ = writeln!(out, "{}", Row::head());
    let mut missed = 0;
    for name in &names {
        let row = set.run(name, tracer.as_mut(), &run);
        let _ = writeln!(out, "{row}");
        missed += u32::from(!row.is_met());
    }
    let met = names.len() as u32 - missed;
    let _ = writeln!(out, "{met} of {} scenes met their targets", names.len());
    Ok(u8::from(missed > 0))
}

/// The scenes that were asked for.
fn chosen(set: &TruthSet, asked: &[String]) -> Result<Vec<String>, (u8, String)> {
    let all = set.names().map_err(|why| (1, why))?;
    if asked.is_empty() {
        return Ok(all);
    }
    let mut chosen = Vec::new();
    for word in asked {
        let before = chosen.len();
        chosen.extend(all.iter().filter(|name| name.starts_with(word)).cloned());
        if chosen.len() == before {
            return Err((
                1,
                format!("no scene `{word}`; there are {}", all.join(", ")),
            ));
        }
    }
    Ok(chosen)
}
