//! How far the origins of rays are lifted off what they start on: as little as is safe, for what is nearer is not seen.
//!
//! A ray that goes straight into a sphere, box, tube or cylinder travels its thickness, less what it was lifted by. The
//! shapes are a tenth to a thousandth of their distance, so that the hit's own rounding is a fraction of what is
//! measured. In ULPs of the position p: f32's spacing at its largest coordinate, relative to the eye.

use glam::DVec3;
use orrery_engine::frame::{Kernels, Offset};
use orrery_engine::trace::Hit;

use super::course::Course;
use super::crowd::{Arrival, Crowd};
use super::surfaces::{KINDS, similar};
use super::tally::{Tally, Verdict};
use crate::failure::Failure;

/// The suite.
pub const NAME: &str = "lift";
/// Pairs of rays a shape.
const RAYS: u64 = 100_000;
/// What half of all may be lifted by, and more.
const TARGET: f64 = 16.0;
/// See the module.
const UNIT: &str = "ULP of p";

/// Runs every shape whose thickness is known, with the fixed offset first.
pub fn run(course: &mut Course) -> Result<(), Failure> {
    let rays = course.rays(RAYS);
    let fixed = Kernels {
        offsets: Offset::Fixed,
        ..Kernels::default()
    };
    for (word, kind) in KINDS {
        let Some(thickness) = kind.thickness() else {
            continue;
        };
        let name = &format!("{NAME}.{word}");
        let crowd = Crowd::new(kind, 0, |draw| {
            let distance = draw.power(-2.0, 6.0);
            let size = distance * draw.power(-3.0, -1.0);
            similar(draw, distance, size)
        })?;
        let mut lifts = |kernels, count| {
            let judge = |arrival: &Arrival, hits: &[Hit]| {
                let through = hits[1].instance == hits[0].instance;
                let size = arrival.map.matrix3.x_axis.length();
                let lift = (thickness * size - hits[1].t).abs() / arrival.ulp();
                if through {
                    Verdict::Off(lift)
                } else {
                    Verdict::Void
                }
            };
            crowd.send(course, (name, kernels), count, |_| DVec3::NEG_Z, judge)
        };
        let broken = lifts(fixed, rays.min(RAYS))?;
        let lifts = lifts(Kernels::default(), rays)?;
        let beyond = u64::from(broken.percentile(0.5) > TARGET);
        course.must_fail(&format!("{name}.fixed"), &Tally::counted(1, beyond), None);
        let median = lifts.percentile(0.5);
        course.at_most(&format!("{name}.p50"), UNIT, &lifts, median, Some(TARGET));
    }
    Ok(())
}
