//! Rays that leave a surface must not meet it: the test `Reintersect` of pbrt, of every kind of shape. And rays that go
//! on into a solid must meet its other side.
//!
//! Shapes under random affine maps (scales from 1e-3 to 1e3, sheared, mirrored) at up to 1e6 from the eye, though no
//! smaller than about 1e-4 of that distance. A ray arrives from outside; another goes on from where it arrived.
//! *Leaving* to the side it came from, half of them grazing, planes to both sides: meeting the same instance again,
//! another triangle of it too, is a failure; in the hole of a torus, only right at its start. *Entering* to the other
//! side: not meeting the same instance again is a failure, a way out that was not found, unless the ray but grazes an
//! edge and is never deeper inside than its origin is rounded.

use glam::{DAffine3, DVec3};
use orrery_engine::frame::{Kernels, Offset};
use orrery_engine::trace::Hit;

use super::course::Course;
use super::crowd::{Arrival, Crowd};
use super::draw::Draw;
use super::surfaces::{KINDS, Kind, placed};
use super::tally::{Tally, Verdict};
use crate::failure::Failure;

/// The suite.
pub const NAME: &str = "leave";
/// Pairs of rays that leave, of all shapes together.
const RAYS: u64 = 1_800_000;
/// One of so many enters.
const ENTERING: u64 = 8;
/// Pairs of a form that must fail, a shape.
const BROKEN: u64 = 50_000;
/// Scenes of a shape.
const SCENES: u64 = 16;
/// What the fixed offset must pass through is smaller by this.
const TINY: f64 = 1e-6;
/// The flattest angle of leaving, as a power of ten: what f32 frames can still tell from none.
const FLATTEST: f64 = -5.0;
/// The flattest angle of entering, and of leaving in a hole: the way to the other side is well above all roundings.
const STEEP: f64 = -1.0;
/// What a ray travels at least from one side of a hole to another at that angle, in sizes of the torus, and more than
/// a ray that starts too low does until it is out.
const ACROSS_HOLE: f64 = 0.02;

/// Runs every shape.
pub fn run(course: &mut Course) -> Result<(), Failure> {
    let weights: f64 = KINDS.iter().map(|(_, kind)| kind.weight()).sum();
    let rays = course.rays(RAYS) as f64 / (weights * SCENES as f64);
    let broken = course.brief(BROKEN);
    let fixed = Kernels {
        offsets: Offset::Fixed,
        ..Kernels::default()
    };
    for (word, kind) in KINDS {
        let name = &format!("{NAME}.{word}");
        let entered = &format!("{name}.entered");
        let rays = (rays * kind.weight()).ceil() as u64;
        let mut left = Tally::default();
        let mut through = Tally::default();
        for number in 0..SCENES {
            let crowd = Crowd::new(kind, number, |draw| placed(kind, draw))?;
            if number == 0 {
                let tally = leave(&crowd, course, (name, fixed), broken)?;
                course.must_fail(&format!("{name}.fixed"), &tally, None);
            }
            let kernels = Kernels::default();
            left = left.with(leave(&crowd, course, (name, kernels), rays)?);
            if kind.is_solid() {
                let rays = rays.div_ceil(ENTERING);
                through = through.with(enter(&crowd, course, (entered, kernels), rays)?);
                if number == 0 {
                    let tiny = DAffine3::from_scale(DVec3::splat(TINY));
                    let crowd = Crowd::new(kind, number, |draw| tiny * placed(kind, draw))?;
                    let tally = enter(&crowd, course, (entered, fixed), broken)?;
                    course.must_fail(&format!("{entered}.fixed"), &tally, None);
                }
            }
        }
        course.none_may_fail(name, &left);
        if kind.is_solid() {
            course.none_may_fail(entered, &through);
        }
    }
    Ok(())
}

/// Rays that go back to the side they came from, and must not meet what they start on.
fn leave(
    crowd: &Crowd,
    course: &mut Course,
    as_what: (&str, Kernels),
    count: u64,
) -> Result<Tally, Failure> {
    let kind = crowd.kind;
    let judge = |arrival: &Arrival, hits: &[Hit]| {
        let again = hits[1].instance == hits[0].instance;
        let size = arrival.map.matrix3.x_axis.length();
        let is_across = kind == Kind::Hole && hits[1].t > ACROSS_HOLE * size;
        Verdict::of(!again || is_across)
    };
    crowd.send(course, as_what, count, |i| outwards(kind, i), judge)
}

/// Rays that go on into what they arrived at, and must meet its other side.
fn enter(
    crowd: &Crowd,
    course: &mut Course,
    as_what: (&str, Kernels),
    count: u64,
) -> Result<Tally, Failure> {
    let judge = |arrival: &Arrival, hits: &[Hit]| {
        if hits[1].instance == hits[0].instance {
            return Verdict::Right;
        }
        // Something else is in there, or it is not in there at all but for roundings.
        let is_void = hits[1] != Hit::MISS || !crowd.goes_deep(arrival, inwards(arrival.index));
        if is_void {
            Verdict::Void
        } else {
            Verdict::Wrong
        }
    };
    crowd.send(course, as_what, count, inwards, judge)
}

fn outwards(kind: Kind, index: u64) -> DVec3 {
    let mut draw = Draw::of(550, index);
    let steep = draw.unit();
    let flattest = if kind == Kind::Hole { STEEP } else { FLATTEST };
    let up = match draw.below(2) {
        0 => draw.power(flattest, STEEP.max(flattest + 0.5)),
        _ => steep.max(10_f64.powf(flattest)),
    };
    let side = match kind {
        Kind::Plane | Kind::Disc if draw.below(2) == 0 => -1.0,
        _ => 1.0,
    };
    at_angle(&mut draw, up * side)
}

fn inwards(index: u64) -> DVec3 {
    let mut draw = Draw::of(560, index);
    let down = draw.power(STEEP, 0.0);
    at_angle(&mut draw, -down)
}

/// A unit vector, so high over the surface.
fn at_angle(draw: &mut Draw, up: f64) -> DVec3 {
    let (sin, cos) = draw.range(0.0, std::f64::consts::TAU).sin_cos();
    let across = (1.0 - up * up).max(0.0).sqrt();
    DVec3::new(across * cos, across * sin, up)
}
