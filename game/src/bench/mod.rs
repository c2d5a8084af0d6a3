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
mod stability;
mod structures;
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
    dumps: Dumps,
}

/// What `--dump` writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Dumps {
    /// The work of the scene that was measured.
    Scene,
    /// The benchmark's own work, which `--rival` is timed on.
    Own,
    /// Nothing.
    Nothing,
}

/// All benchmarks, in the order they are listed.
const ALL: [Benchmark; 4] = [
    Benchmark {
        name: "frame",
        about: "a whole frame of a scene: simulation, extraction, trees, upload, tracing; rays a second; error",
        run: frame::run,
        dumps: Dumps::Scene,
    },
    Benchmark {
        name: "motion",
        about: "what change costs: nothing, one of many, the camera, everything, deformed meshes; rivals' trees",
        run: motion::run,
        dumps: Dumps::Own,
    },
    Benchmark {
        name: "structures",
        about: "the report's trees of spheres beside no structure and boxes: build, refit, nodes a ray, frame time",
        run: structures::run,
        dumps: Dumps::Nothing,
    },
    Benchmark {
        name: "stability",
        about: "what must never go wrong, tried until it would: leaks, self-hits, boxes, far, tiny and bad input",
        run: stability::run,
        dumps: Dumps::Nothing,
    },
];

/// Runs what was asked for.
pub fn run(request: &BenchRequest, common: &Common) -> Result<(), Failure> {
    if request.list && request.name == stability::NAME {
        stability::list();
        return Ok(());
    }
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
    let (name, dumps) = (benchmark.name, benchmark.dumps);
    if !request.rival.is_empty() && dumps != Dumps::Own {
        return Err(Failure::Usage(format!(
            "--rival is for `bench motion`; `{name}` has no work for one"
        )));
    }
    if request.dump.is_some() && dumps == Dumps::Nothing {
        return Err(Failure::Usage(format!(
            "--dump is for `bench frame` and `bench motion`; `{name}` writes none"
        )));
    }
    let asks_for_stability = !request.suite.is_empty() || request.rays.is_some();
    if asks_for_stability && name != stability::NAME {
        return Err(Failure::Usage(format!(
            "--suite and --rays are for `bench stability`; `{name}` has no suites"
        )));
    }
    let report = (benchmark.run)(request, common)?;
    report.print();
    if let Some(path) = &request.json {
        report.write_json(path)?;
    }
    if let (Some(folder), Dumps::Scene) = (&request.dump, dumps) {
        dump::run(folder, request, common)?;
    }
    match report.missed() {
        missed if missed > 0 && name == stability::NAME => Err(Failure::Missed(format!(
            "{missed} rows of `{name}` are not as they must be; they are marked MISSED"
        ))),
        _ => Ok(()),
    }
}
