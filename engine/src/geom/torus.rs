//! The torus of major radius 1 about the Y axis; its size, place and turn are in its instance's transform.
//!
//! A ray meets it where a quartic is zero. With the ray moved to its closest approach to the centre the
//! quartic has no cubic term, and its coefficients are no larger than the torus. Its roots are isolated
//! between its critical points, those between the critical points of its derivative, and refined by
//! bracketed Newton steps (Yuksel, "High-Performance Polynomial Root Finding for Graphics", HPG 2022). Signs and steps of the
//! quartic itself are those of (|p_xz| - 1)^2 + y^2 - minor^2, which it is a positive multiple of: expanded
//! coefficients would cancel by the square of the major radius over the minor one.
//!
//! A ray that starts on the torus has a root at zero, known exactly: it is divided out, and a cubic is left.
//!
//! Twin of `shaders/shared/torus.wgsl`.

use glam::{Vec2, Vec3};

use super::SolidPoint;

/// Stands for zero where a division needs something.
const TINY: f32 = 1e-30;
/// Steps for a critical point: it need only part two roots.
const CRITICAL_STEPS: u32 = 12;
/// A Newton step no longer than this is the last one: it leaves about its square.
const CRITICAL_ACCURACY: f32 = 1e-3;
/// Steps for a root: as many halvings as a tangent ray has digits.
const ROOT_STEPS: u32 = 24;
/// The same for a root. Less would wait for rounding to agree with itself.
const ROOT_ACCURACY: f32 = 1e-6;
/// How far from where it starts a ray inside comes out, at least, in about: well ahead of what a root errs by.
const LEAST_EXIT: f32 = 4e-6;

/// All distances to the torus in lengths of `dir`, nearest first; one `starts_on` it leaves out where it starts.
pub fn intersect_torus(origin: Vec3, dir: Vec3, minor: f32, starts_on: bool) -> [Option<f32>; 4] {
    let inverse_length = dir.length().max(TINY).recip();
    let along = dir * inverse_length;
    if starts_on {
        let line = Line {
            from: origin,
            along,
            minor,
        };
        return line
            .onward_roots()
            .map(|root| root.map(|s| s * inverse_length));
    }
    let middle = -origin.dot(along);
    let line = Line {
        from: origin + along * middle,
        along,
        minor,
    };
    line.roots()
        .map(|root| root.map(|s| (middle + s) * inverse_length))
}

/// A point near the torus moved onto it.
pub fn torus_point(near: Vec3, minor: f32) -> SolidPoint {
    let outward = Vec2::new(near.x, near.z).normalize_or(Vec2::X);
    let ring = Vec3::new(outward.x, 0.0, outward.y);
    let normal = (near - ring).normalize_or(ring);
    let tube = normal * minor;
    SolidPoint {
        at: ring + tube,
        normal,
        roundings: (ring.abs() + tube.abs()) * 2.0,
    }
}

/// A line in units of the major radius; `along` is unit.
#[derive(Clone, Copy)]
struct Line {
    from: Vec3,
    along: Vec3,
    minor: f32,
}

impl Line {
    /// The squared distance to the ring less that of the surface, and its slope.
    fn excess(&self, s: f32) -> (f32, f32) {
        let p = self.from + self.along * s;
        let from_axis = Vec2::new(p.x, p.z).length();
        let from_ring = from_axis - 1.0;
        let outward = (p.x * self.along.x + p.z * self.along.z) / from_axis.max(TINY);
        (
            from_ring * from_ring + p.y * p.y - self.minor * self.minor,
            2.0 * (from_ring * outward + p.y * self.along.y),
        )
    }

    /// The roots of a line that is at its closest approach to the centre at s = 0.
    fn roots(&self) -> [Option<f32>; 4] {
        // A little more than the sphere around, so that the line is outside of the torus at both ends.
        let reach = (1.0 + self.minor) * (1.0 + self.minor) * 1.0001;
        let rest = reach - self.from.length_squared();
        if !(rest > 0.0) {
            return [None; 4];
        }
        let end = rest.sqrt();
        // Half the quartic's derivative: 2 s^3 + p s + q.
        let level = self.along.x * self.along.x + self.along.z * self.along.z;
        let center = self.from.length_squared() + 1.0 - self.minor * self.minor;
        let p = 2.0 * center - 4.0 * level;
        let q = -4.0 * (self.from.x * self.along.x + self.from.z * self.along.z);
        let derivative = |s: f32| ((2.0 * s * s + p) * s + q, 6.0 * s * s + p);
        let bend = (-p / 6.0).max(0.0).sqrt().min(end);
        let between = |low, high| {
            root_between(derivative, (low, high), CRITICAL_STEPS, CRITICAL_ACCURACY).unwrap_or(high)
        };
        let (first, second, third) = (
            between(-end, -bend),
            between(-bend, bend),
            between(bend, end),
        );
        let surface = |s| self.excess(s);
        [
            (-end, first),
            (first, second),
            (second, third),
            (third, end),
        ]
        .map(|span| root_between(surface, span, ROOT_STEPS, ROOT_ACCURACY))
    }

    /// The roots ahead of a line that starts on the torus, but for that one.
    fn onward_roots(&self) -> [Option<f32>; 4] {
        let (o, d) = (self.from, self.along);
        let from_axis = Vec2::new(o.x, o.z).length();
        let approach = o.dot(d);
        let outward = o.x * d.x + o.z * d.z;
        let level = d.x * d.x + d.z * d.z;
        // The quartic over s: s^3 + a s^2 + b s + c, where |o|^2 + 1 - minor^2 = 2 from_axis on the torus.
        let a = 4.0 * approach;
        let b = 4.0 * (approach * approach + from_axis - level);
        let c = 8.0 * ((from_axis - 1.0) * outward + from_axis * o.y * d.y);
        // A ray that starts outside rises at first, one that starts inside falls, and comes out a little ahead at least: of a
        // grazing one, c may be rounding alone, and a rise at the start would lose the root where it comes out.
        let start = self.excess(0.0).0;
        let c = if start > 0.0 {
            c.max(0.0)
        } else if start < 0.0 {
            c.min(-LEAST_EXIT * (b.max(0.0) + LEAST_EXIT))
        } else {
            c
        };
        // Near the start the cubic is the more accurate, far from it the surface.
        let near = self.minor;
        let onward = |s: f32| {
            if s * s > near {
                self.excess(s)
            } else {
                (((s + a) * s + b) * s + c, (3.0 * s + 2.0 * a) * s + b)
            }
        };
        let end = 2.02 * (1.0 + self.minor);
        let (first, second) = bends(a, b, end);
        let [x, y, z] = [(0.0, first), (first, second), (second, end)]
            .map(|span| root_between(onward, span, ROOT_STEPS, ROOT_ACCURACY));
        [x, y, z, None]
    }
}

/// Where s^3 + a s^2 + b s + c bends, within [0, end], in order; both 0 where it does not.
fn bends(a: f32, b: f32, end: f32) -> (f32, f32) {
    let discriminant = a * a - 3.0 * b;
    if !(discriminant > 0.0) {
        return (0.0, 0.0);
    }
    let root = discriminant.sqrt();
    let q = if a >= 0.0 { -(a + root) } else { root - a };
    let (one, other) = (q / 3.0, if q == 0.0 { 0.0 } else { b / q });
    (
        one.min(other).clamp(0.0, end),
        one.max(other).clamp(0.0, end),
    )
}

/// The root of a function with its slope that is monotone between two places; none without a change of sign.
fn root_between(
    f: impl Fn(f32) -> (f32, f32),
    (mut low, mut high): (f32, f32),
    steps: u32,
    accuracy: f32,
) -> Option<f32> {
    let is_below = f(low).0 < 0.0;
    if is_below == (f(high).0 < 0.0) {
        return None;
    }
    let mut s = 0.5 * (low + high);
    for _ in 0..steps {
        let (value, slope) = f(s);
        if (value < 0.0) == is_below {
            low = s;
        } else {
            high = s;
        }
        let step = value / if slope.abs() < TINY { TINY } else { slope };
        let newton = s - step;
        if step.abs() <= accuracy {
            return Some(newton);
        }
        s = if newton > low && newton < high {
            newton
        } else {
            0.5 * (low + high)
        };
    }
    Some(s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::gamma;
    use crate::testing::Random;

    #[test]
    fn every_ray_that_enters_leaves() {
        let mut random = Random::new(31);
        let mut lost = Vec::new();
        for number in 0..1_000_000 {
            let minor = 10_f64.powf(random.range(-2.0, -0.02));
            let turn = random.range(0.0, std::f64::consts::TAU);
            let tube = random.range(0.0, std::f64::consts::TAU);
            let across = 1.0 + minor * tube.cos();
            let near =
                glam::DVec3::new(across * turn.cos(), minor * tube.sin(), across * turn.sin());
            let minor = minor as f32;
            let SolidPoint {
                at,
                normal,
                roundings,
            } = torus_point(near.as_vec3(), minor);
            // Most of them graze, by less than rounding tells.
            let flat = random.direction().as_vec3().reject_from_normalized(normal);
            let steepness = match number % 4 {
                0 => random.unit(),
                _ => 10_f64.powf(random.range(-10.0, -2.0)),
            };
            let dir = flat.normalize_or(normal) - normal * steepness as f32;
            if normal.dot(dir) >= 0.0 {
                continue;
            }
            // As far inside as tracers step.
            let error = normal.abs().dot(roundings) * gamma(5);
            let origin = at - normal * (error + normal.abs().dot(at.abs()) * gamma(1));
            let roots = intersect_torus(origin, dir, minor, true);
            if !roots.iter().flatten().any(|t| *t > 0.0) {
                lost.push((minor, origin, dir));
            }
        }
        assert!(
            lost.is_empty(),
            "{} stay inside, as {:?}",
            lost.len(),
            lost[0]
        );
    }
}
