//! `orrery bench`: named benchmarks, their rows on the terminal and as JSON.
//!
//! A benchmark is a line in [`ALL`] and a function that returns rows. Timings are wall-clock times of
//! the work named, after a warm-up; errors against the f64 reference stand beside them.

mod accuracy;
mod bart;
mod cpu;
mod crowd;
mod dump;
mod flight;
mod frame;
mod growth;
mod hills;
mod hope;
mod import;
mod motion;
mod profile;
mod rays;
mod report;
mod skips;
mod spd;
mod stability;
mod start;
mod structures;
mod timing;
mod trace;
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
    /// Whether the program fails if the row of that name is not as it should be.
    must: fn(&str) -> bool,
    /// Options that not every benchmark has.
    takes: &'static [&'static str],
}

/// All benchmarks, in the order they are listed.
const ALL: [Benchmark; 15] = [
    Benchmark {
        name: "frame",
        about: "a whole frame of a scene: simulation, extraction, trees, upload, tracing; rays a second; error",
        run: frame::run,
        must: |_| false,
        takes: &["--dump"],
    },
    Benchmark {
        name: "trace",
        about: "rays by kind and whole frames, from a few mirrors to 10,000 instances; rays and hits for rivals",
        run: trace::run,
        must: |_| false,
        takes: &["--dump", "--files", "--suite", "--small"],
    },
    Benchmark {
        name: "cpu",
        about: "the processor alone: rays by kind on meshes of 100,000 and 1,000,000 triangles, one thread and all",
        run: cpu::run,
        must: |_| false,
        takes: &["--dump", "--suite", "--small"],
    },
    Benchmark {
        name: "hope",
        about: "what the report hoped for: 100,000 triangles in motion, half deforming, mirrors, glass; frames a second",
        run: hope::run,
        must: |_| false,
        takes: &["--frames", "--small"],
    },
    Benchmark {
        name: "growth",
        about: "frame time against triangles, instances, lights, depth and pixels: curves and their exponents",
        run: growth::run,
        must: |_| false,
        takes: &["--report", "--small"],
    },
    Benchmark {
        name: "skips",
        about: "what it saves to trace with what a scene needs alone: each feature, and kernels by hand beside it",
        run: skips::run,
        must: |_| false,
        takes: &["--small"],
    },
    Benchmark {
        name: "motion",
        about: "what change costs: nothing, one of many, the camera, everything, deformed meshes; rivals' trees",
        run: motion::run,
        must: |_| false,
        takes: &["--dump", "--rival", "--small"],
    },
    Benchmark {
        name: "accuracy",
        about: "run time against error: what each knob costs and buys, on every class of scene; fronts as charts",
        run: accuracy::run,
        must: accuracy::must_be_met,
        takes: &["--report", "--small"],
    },
    Benchmark {
        name: "structures",
        about: "the report's trees of spheres beside no structure and boxes: build, refit, nodes a ray, frame time",
        run: structures::run,
        must: |_| false,
        takes: &["--small"],
    },
    Benchmark {
        name: "spd",
        about: "the Standard Procedural Databases: rays by kind as published, pictures beside the author's, errors",
        run: spd::run,
        must: spd::must_be_met,
        takes: &["--report", "--files", "--small"],
    },
    Benchmark {
        name: "bart",
        about: "kitchen, robots and museum of BART, played to their last frame: frame rate, memory, contact sheets",
        run: bart::run,
        must: |_| false,
        takes: &["--report", "--files", "--frames", "--small"],
    },
    Benchmark {
        name: "import",
        about: "files made to trip importers up: loaded, refused with a reason, panics, worst time and memory",
        run: import::run,
        must: import::must_be_met,
        takes: &["--report", "--files"],
    },
    Benchmark {
        name: "start",
        about: "large scenes from file to ready to trace: the first start, and the second with what is in the cache",
        run: start::run,
        must: |_| false,
        takes: &["--files", "--small"],
    },
    Benchmark {
        name: "profile",
        about: "what measuring costs: spans of every system, frames kept, who changed what, the profiler's panel",
        run: profile::run,
        must: |_| false,
        takes: &["--small"],
    },
    Benchmark {
        name: "stability",
        about: "what must never go wrong, tried until it would: leaks, self-hits, boxes, far, tiny and bad input",
        run: stability::run,
        must: |_| true,
        takes: &["--suite", "--rays", "--small"],
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
    refuse_what_it_does_not_take(benchmark, request)?;
    let report = (benchmark.run)(request, common)?;
    report.print();
    if let Some(path) = &request.json {
        report.write_json(path)?;
    }
    match report.missed(benchmark.must) {
        0 => Ok(()),
        missed => Err(Failure::Missed(format!(
            "{missed} rows of `{}` are not as they must be; they are marked MISSED",
            benchmark.name
        ))),
    }
}

/// An option that would be without effect is a mistake of whoever gave it.
fn refuse_what_it_does_not_take(
    benchmark: &Benchmark,
    request: &BenchRequest,
) -> Result<(), Failure> {
    let given = [
        ("--dump", request.dump.is_some()),
        ("--rival", !request.rival.is_empty()),
        ("--report", request.report.is_some()),
        ("--suite", !request.suite.is_empty()),
        ("--rays", request.rays.is_some()),
        ("--frames", request.frames.is_some()),
        ("--files", request.files.is_some()),
        ("--small", request.small),
    ];
    let refused = given
        .into_iter()
        .find(|(option, is_given)| *is_given && !benchmark.takes.contains(option));
    let Some((option, _)) = refused else {
        return Ok(());
    };
    let takers = ALL.iter().filter(|b| b.takes.contains(&option));
    let takers: Vec<String> = takers.map(|b| format!("`bench {}`", b.name)).collect();
    Err(Failure::Usage(format!(
        "{option} is for {}; `{}` does not take it",
        takers.join(" and "),
        benchmark.name
    )))
}
