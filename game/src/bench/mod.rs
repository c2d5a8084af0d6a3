//! `orrery bench`: named benchmarks, their rows on the terminal and as JSON.
//!
//! A benchmark is a line in [`ALL`] and a function that returns rows. Timings are wall-clock times of
//! the work named, after a warm-up; errors against the f64 reference stand beside them.

mod crowd;
mod dump;
mod error;
mod frame;
mod hills;
mod motion;
mod rays;
mod report;
mod timing;
mod walk;
mod work;

use crate::args::{BenchRequest, Common};
use crate::failure::Failure;
use crate::output::say;

use report::Report;

/// A named measurement.
struct Benchmark {
    name: &'static str,
    about: &'static str,
    run: fn(&BenchRequest, &Common) -> Result<Report, Failure>,
    /// Measures a scene, whose work `--dump` then writes.
    of_scene: bool,
}

/// All benchmarks, in the order they are listed.
const ALL: [Benchmark; 2] = [
    Benchmark {
        name: "frame",
        about: "a whole frame of a scene: simulation, extraction, trees, upload, tracing; rays a second; error",
        run: frame::run,
        of_scene: true,
    },
    Benchmark {
        name: "motion",
        about: "what change costs: nothing, one of many, the camera, everything, deformed meshes; rivals' trees",
        run: motion::run,
        of_scene: false,
    },
];

/// Runs what was asked for.
pub fn run(request: &BenchRequest, common: &Common) -> Result<(), Failure> {
    if request.list {
        for benchmark in &ALL {
            say(format_args!("{:<12}{}", benchmark.name, benchmark.about));
        }
        return Ok(());
    }
    let Some(benchmark) = ALL.iter().find(|b| b.name == request.name) else {
        let names: Vec<&str> = ALL.iter().map(|b| b.name).collect();
        return Err(Failure::Usage(format!(
            "no benchmark `{}`; there is {}",
            request.name,
            names.join(", ")
        )));
    };
    if request.frame.checked_add(request.repeat).is_none() {
        return Err(Failure::Usage(format!(
            "--frame {}: the {} frames from there on have no numbers; expected at most {}",
            request.frame,
            request.repeat,
            u64::MAX - request.repeat
        )));
    }
    let report = (benchmark.run)(request, common)?;
    report.print();
    if let Some(path) = &request.json {
        report.write_json(path)?;
    }
    if let (Some(folder), true) = (&request.dump, benchmark.of_scene) {
        dump::run(folder, request, common)?;
    }
    Ok(())
}
