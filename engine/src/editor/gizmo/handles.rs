//! The handles: which there are in a mode, where each is on the screen, which one is under the mouse.

use egui::Pos2;
use glam::DVec3;

use super::{Frame, Mode, NEAR};
use crate::editor::outline::{Line, circle};
use crate::editor::sight::Sight;

/// Something to take hold of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Handle {
    /// Along, or about, the first, second or third axis.
    Axis(usize),
    /// In the plane across that axis.
    Plane(usize),
    /// In the plane of the picture; along all axes at once.
    Middle,
    /// The radius of a ball.
    Radius,
    /// The opening of a spot light.
    Cone,
}

/// A handle as it is drawn: lines in the world, and whether the area inside belongs to it.
#[derive(Debug)]
pub struct Shown {
    /// Which.
    pub handle: Handle,
    /// Its lines.
    pub line: Line,
    /// It is taken hold of inside its line, too.
    pub filled: bool,
}

/// The handles of a mode.
pub fn handles(frame: &Frame, mode: Mode, sight: &Sight) -> Vec<Shown> {
    let Frame {
        pivot, axes, reach, ..
    } = *frame;
    let mut shown = Vec::new();
    let mut add = |handle, line, filled| {
        shown.push(Shown {
            handle,
            line,
            filled,
        });
    };
    for (i, &axis) in axes.iter().enumerate() {
        let [u, v] = [axes[(i + 1) % 3], axes[(i + 2) % 3]];
        match mode {
            Mode::Rotate => add(Handle::Axis(i), circle(pivot, axis, reach), false),
            Mode::Move | Mode::Scale => {
                let from = pivot + axis * (0.14 * reach);
                add(Handle::Axis(i), vec![from, pivot + axis * reach], false);
            }
        }
        if mode == Mode::Move {
            let corner = |a: f64, b: f64| pivot + (u * a + v * b) * reach;
            let quad = [
                (0.28, 0.28),
                (0.46, 0.28),
                (0.46, 0.46),
                (0.28, 0.46),
                (0.28, 0.28),
            ];
            add(
                Handle::Plane(i),
                quad.map(|(a, b)| corner(a, b)).to_vec(),
                true,
            );
        }
    }
    if mode != Mode::Rotate {
        let line = circle(pivot, sight.view.forward, 0.1 * reach);
        add(Handle::Middle, line, true);
    }
    let dot = |at: DVec3| circle(at, sight.view.forward, sight.world_per_point(at) * 6.0);
    if frame.radius.is_some() {
        add(Handle::Radius, dot(radius_place(frame, sight)), true);
    }
    if frame.cone.is_some() {
        add(Handle::Cone, dot(cone_place(frame, sight)), true);
    }
    shown
}

/// Where the handle of a ball's radius is: on its outline, to the right and up, clear of the axes.
fn radius_place(frame: &Frame, sight: &Sight) -> DVec3 {
    let aside = sight.view.right.normalize() * 0.8 + sight.view.up.normalize() * 0.6;
    frame.pivot + aside * frame.radius.unwrap_or_default()
}

/// A unit vector across a cone's axis and across the view: the cone's rim is seen farthest out there.
pub fn across(axis: DVec3, sight: &Sight) -> DVec3 {
    sight
        .view
        .forward
        .cross(axis)
        .try_normalize()
        .unwrap_or_else(|| axis.any_orthonormal_vector())
}

fn cone_place(frame: &Frame, sight: &Sight) -> DVec3 {
    let Some((axis, angle)) = frame.cone else {
        return frame.pivot;
    };
    let (sin, cos) = angle.sin_cos();
    frame.pivot + (axis * cos + across(axis, sight) * sin) * (1.3 * frame.reach)
}

/// The handle under the mouse, those of radius and cone first, then planes and middle, then axes.
pub fn under(shown: &[Shown], sight: &Sight, at: Pos2) -> Option<Handle> {
    let rank = |handle: &Handle| match handle {
        Handle::Radius | Handle::Cone => 0,
        Handle::Plane(_) | Handle::Middle => 1,
        Handle::Axis(_) => 2,
    };
    let near = shown.iter().filter_map(|shown| {
        let places: Option<Vec<Pos2>> = shown
            .line
            .iter()
            .map(|&p| Some(sight.place(p)?.0))
            .collect();
        let places = places?;
        let distance = distance_to(&places, at);
        let is_in = shown.filled && contains(&places, at);
        (distance <= NEAR || is_in).then_some((shown.handle, if is_in { 0.0 } else { distance }))
    });
    near.min_by(|a, b| {
        let ranks = rank(&a.0).cmp(&rank(&b.0));
        ranks.then(a.1.total_cmp(&b.1))
    })
    .map(|(handle, _)| handle)
}

/// Points from a line of several corners.
fn distance_to(line: &[Pos2], at: Pos2) -> f32 {
    let part = |ends: &[Pos2]| {
        let [a, b] = [ends[0], ends[1]];
        let along = b - a;
        let share = ((at - a).dot(along) / along.length_sq().max(1e-9)).clamp(0.0, 1.0);
        at.distance(a + along * share)
    };
    line.windows(2).map(part).fold(f32::INFINITY, f32::min)
}

/// Whether a closed line goes around a point (even-odd).
fn contains(line: &[Pos2], at: Pos2) -> bool {
    let crosses = |ends: &&[Pos2]| {
        let [a, b] = [ends[0], ends[1]];
        (a.y > at.y) != (b.y > at.y) && at.x < a.x + (at.y - a.y) / (b.y - a.y) * (b.x - a.x)
    };
    line.windows(2).filter(crosses).count() % 2 == 1
}
