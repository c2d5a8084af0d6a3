//! From the world to packed rows when everything moves, by the spans of the systems on the way.

use std::collections::BTreeMap;

use orrery_engine::profile::Profile;
use orrery_engine::trace::ActiveTracer;

use super::Sizes;
use crate::args::{BackendChoice, Common};
use crate::bench::crowd::{Crowd, Kind, Plan};
use crate::bench::report::Row;
use crate::bench::timing::millis_row;
use crate::failure::Failure;
use crate::{device, stage};

/// Frames before the clock counts.
const WARM_UP: usize = 5;
/// Milliseconds a thing: 0.05 for 10,000.
const TARGET_EACH: f64 = 0.05 / 10_000.0;

/// The parts of the way, and which systems they are: the names of spans begin so.
const PARTS: [(&str, &[&str]); 4] = [
    ("animate", &["move_things"]),
    ("propagate", &["propagate", "derive_own_meshes"]),
    (
        "extract",
        &["extract", "vacate_removed", "relink", "find_features"],
    ),
    ("pack", &["refit_trees", "upload_rows"]),
];

/// Every count, spheres in motion under the CPU tracer.
pub fn rows(sizes: &Sizes, samples: usize, common: &Common) -> Result<Vec<Row>, Failure> {
    let mut rows = Vec::new();
    for &count in sizes.packed {
        let mut crowd = Crowd::new(Plan {
            count,
            kind: Kind::Spheres,
            moving: true,
            profiled: true,
        });
        stage::cast(
            &mut crowd.engine,
            device::open_choice(BackendChoice::Cpu, common)?,
        );
        let mut times: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
        for frame in 0..WARM_UP + samples {
            stage::advance(&mut crowd.engine, frame as u64)?;
            if frame >= WARM_UP {
                note_frame(&crowd, &mut times);
            }
        }
        let target = TARGET_EACH * count as f64;
        let samples_of = |part: &str| times.get(part).map_or(&[][..], Vec::as_slice);
        let row = |part: &str| millis_row(format!("packed.{count}.{part}"), samples_of(part));
        rows.push(row("total").with_target(target));
        rows.extend(["propagate", "extract", "pack", "tree", "animate"].map(row));
    }
    Ok(rows)
}

/// Adds up the frame's spans. The tree over instances is updated where rows are packed, but is told apart;
/// motion components come before the way and are not in the total.
fn note_frame(crowd: &Crowd, times: &mut BTreeMap<&str, Vec<f64>>) {
    let world = &crowd.engine.world;
    let spans = &world.resource::<Profile>().spans;
    let passes = world
        .resource::<ActiveTracer>()
        .0
        .as_ref()
        .map(|tracer| tracer.pass_times());
    let tree = passes
        .iter()
        .flatten()
        .find(|pass| pass.name.starts_with("instance tree"));
    let tree = tree.map_or(0.0, |pass| pass.millis);
    let mut total = 0.0;
    for (part, systems) in PARTS {
        let of_part = |name: &str| systems.iter().any(|system| name.starts_with(system));
        let spans = spans.iter().filter(|span| of_part(&span.name));
        let mut millis = spans.map(|span| span.micros * 1e-3).sum::<f64>();
        if part == "pack" {
            millis -= tree;
        }
        if part != "animate" {
            total += millis;
        }
        times.entry(part).or_default().push(millis);
    }
    times.entry("tree").or_default().push(tree);
    times.entry("total").or_default().push(total);
}
