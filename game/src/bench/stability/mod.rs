//! The benchmark `stability`: what must never go wrong, tried until it would.
//!
//! A suite is a file and a line in [`SUITES`]. Each first runs what is known to go wrong (a textbook kernel, or
//! input that is broken on purpose) and must see it fail: a suite that cannot fail proves nothing, and counts as
//! missed. Then it runs the engine, whose failures must be as few as the target says. Suites that count rays
//! send them through [`orrery_engine::trace::Tracer::intersect`] on every backend alike.

mod course;
mod crowd;
mod draw;
mod drift;
mod far;
mod gaps;
mod glass;
mod input;
mod leaks;
mod leave;
mod lift;
mod odd;
mod ratios;
mod refit;
mod scenes;
pub mod solids;
mod stream;
mod surfaces;
mod tally;
mod trees;

use self::course::Course;
use super::frame::backends;
use super::report::Report;
use crate::args::{BenchRequest, Common};
use crate::device;
use crate::failure::Failure;
use crate::output::{note, say};

/// What this benchmark is called.
pub const NAME: &str = "stability";

/// Something that must not go wrong.
struct Suite {
    name: &'static str,
    about: &'static str,
    run: fn(&mut Course) -> Result<(), Failure>,
}

/// All, in the order they run.
const SUITES: [Suite; 11] = [
    Suite {
        name: leaks::NAME,
        about: "closed meshes seen from inside, at edges, vertices and anywhere, near the origin and at 1.5e5",
        run: leaks::run,
    },
    Suite {
        name: trees::NAME,
        about: "every structure against every triangle, and instances together against each alone: same hits",
        run: trees::run,
    },
    Suite {
        name: leave::NAME,
        about: "rays that leave a surface must not meet it, and those that enter must: every shape, affine instances",
        run: leave::run,
    },
    Suite {
        name: lift::NAME,
        about: "how far the origins of rays are off what they start on, in ULPs of the position",
        run: lift::run,
    },
    Suite {
        name: ratios::NAME,
        about: "t and hit or miss against f64 of the same numbers: far, huge and ordinary spheres, triangles",
        run: ratios::run,
    },
    Suite {
        name: gaps::NAME,
        about: "two plates and the smallest gap between them with the right shadow and reflection",
        run: gaps::run,
    },
    Suite {
        name: far::NAME,
        about: "the same picture up to 1e7 from the origin, and at any scale, bit for bit where numbers are exact",
        run: far::run,
    },
    Suite {
        name: input::NAME,
        about: "worlds with numbers in them that are none: only finite pixels, and what is good unchanged",
        run: input::run,
    },
    Suite {
        name: refit::NAME,
        about: "trees of meshes that deform: everything inside, and the hits of brute force",
        run: refit::run,
    },
    Suite {
        name: drift::NAME,
        about: "poses after a million frames, and after whole periods",
        run: drift::run,
    },
    Suite {
        name: glass::NAME,
        about: "slabs, mirrors and total reflection: directions, energy and Fresnel through long chains",
        run: glass::run,
    },
];

/// Names the suites.
pub fn list() {
    for suite in &SUITES {
        say(format_args!("{:<12}{}", suite.name, suite.about));
    }
}

/// Runs the suites that were asked for on the backends that were.
pub fn run(request: &BenchRequest, common: &Common) -> Result<Report, Failure> {
    let names = SUITES.map(|suite| suite.name);
    if let Some(unknown) = request.suite.iter().find(|s| !names.contains(&s.as_str())) {
        return Err(Failure::Usage(format!(
            "no suite `{unknown}`; there is {}",
            names.join(", ")
        )));
    }
    let asked = |suite: &&Suite| {
        request.suite.is_empty() || request.suite.iter().any(|name| name == suite.name)
    };
    let mut rows = Vec::new();
    let mut remarks = vec![
        "a row: suite.case.aim.backend; with the name of a textbook form in it, that form, which must fail".into(),
        "known ppm: what the textbook form was measured at elsewhere, on other meshes and devices".into(),
        "t's targets from the accuracy goals: ratios.far_1e0 and ratios.triangles, every percentile; other spheres p99. \
         grazed and soup have none: what t errs by grows with the angle there".into(),
    ];
    let mut devices = Vec::new();
    for choice in backends(common) {
        let mut course = Course::new(device::open_choice(choice, common)?, request);
        devices.push(course.tracer.device());
        for suite in SUITES.iter().filter(asked) {
            note(format_args!("{}: {}", course.backend(), suite.name));
            (suite.run)(&mut course)?;
        }
        rows.append(&mut course.rows);
        remarks.append(&mut course.remarks);
    }
    Ok(Report {
        rows,
        remarks,
        ..Report::new(NAME, &devices)
    })
}
