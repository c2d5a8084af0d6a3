//! The ray-sphere test that stays accurate for far, for small and for huge spheres.
//!
//! All follows from a point's *power* (Steiner 1826): its squared distance to the centre less the squared
//! radius, which cancels where the point is near the surface. It cancels least about a well chosen base: with
//! x = point - base and y = centre - base it is x.(x - 2y) + power(base), and the base's is known from f64.
//! From within two radii of the centre the base is the eye, so that a ground of 1e6 under an eye of 2 is as
//! exact as the eye is high, not as the radius is long; from farther away it is the centre.
//!
//! The discriminant is b^2 - a power where the ray passes the centre nearer than the radius, else it is from
//! the perpendicular remainder (Haines, Günther, Akenine-Möller, "Precision Improvements for Ray/Sphere
//! Intersection", Ray Tracing Gems, 2019, ch. 7): a fused product and sum, and what of it still lies along the
//! ray is taken out, as by a second Gram-Schmidt step. Roots by the stable quadratic.
//!
//! Twin of `shaders/shared/sphere.wgsl`, where sums of products have no f64 to be taken in.

use glam::{DVec3, Vec3};

use super::gamma;

/// A sphere as rays see it whose origins are relative to the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereFrame {
    /// Relative to the eye: the eye itself, or the centre.
    pub base: Vec3,
    /// Radius.
    pub radius: f32,
    /// Centre relative to the base.
    pub center: Vec3,
    /// The base's squared distance to the centre less the squared radius.
    pub power: f32,
    /// What rounding left of the centre; less than a device's sums of products keep.
    pub rest: Vec3,
}

/// Both distances to a sphere, `near <= far`, in lengths of the ray's direction; either may be negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereRoots {
    /// Entry.
    pub near: f32,
    /// Exit.
    pub far: f32,
}

/// How a point lies to a sphere.
#[derive(Clone, Copy, Debug)]
pub struct SphereHeight {
    /// Outside it: how far, along the normal.
    pub height: f32,
    /// What the height errs by, here and where a ray comes back.
    pub error: f32,
    /// Outward, unit.
    pub normal: Vec3,
}

impl SphereFrame {
    /// The unit sphere about the origin.
    pub const UNIT: Self = Self {
        base: Vec3::ZERO,
        radius: 1.0,
        center: Vec3::ZERO,
        power: -1.0,
        rest: Vec3::ZERO,
    };

    /// The sphere whose centre is at `center` relative to the eye.
    pub fn new(center: DVec3, radius: f64) -> Self {
        let distance = center.length();
        let rounded = center.as_vec3();
        let (base, from_base, power) = if distance < 2.0 * radius {
            let of_eye = (distance - radius) * (distance + radius);
            (Vec3::ZERO, rounded, of_eye)
        } else {
            (rounded, Vec3::ZERO, -radius * radius)
        };
        Self {
            base,
            radius: radius as f32,
            center: from_base,
            power: power as f32,
            rest: (center - rounded.as_dvec3()).as_vec3(),
        }
    }

    /// As rows of four: base and radius, centre and power, the rest.
    pub fn rows(&self) -> [[f32; 4]; 3] {
        [
            self.base.extend(self.radius).to_array(),
            self.center.extend(self.power).to_array(),
            self.rest.extend(0.0).to_array(),
        ]
    }

    /// Reads [`SphereFrame::rows`].
    #[inline]
    pub fn from_rows([first, second, third]: [[f32; 4]; 3]) -> Self {
        let xyz = |[x, y, z, _]: [f32; 4]| Vec3::new(x, y, z);
        Self {
            base: xyz(first),
            radius: first[3],
            center: xyz(second),
            power: second[3],
            rest: xyz(third),
        }
    }

    /// A point relative to the base and relative to the centre.
    #[inline]
    fn place(&self, point: Vec3) -> (DVec3, DVec3) {
        let from_base = point.as_dvec3() - self.base.as_dvec3();
        let center = self.center.as_dvec3() + self.rest.as_dvec3();
        (from_base, from_base - center)
    }

    /// The power of a point, rounded once.
    #[inline]
    fn power_at(&self, (from_base, from_center): (DVec3, DVec3)) -> f32 {
        // With x - 2y as twice x - y less x.
        let power = from_base.dot(2.0 * from_center - from_base) + f64::from(self.power);
        power as f32
    }

    /// Meets the sphere.
    ///
    /// A ray that `starts_on` the sphere has one root at zero, known exactly, and from the outside no other;
    /// from the inside the other one, 2b/a, is returned as both.
    #[inline]
    pub fn intersect(&self, origin: Vec3, dir: Vec3, starts_on: bool) -> Option<SphereRoots> {
        let at = self.place(origin);
        let from_center = at.1;
        let a = dir.dot(dir);
        let b = -from_center.dot(dir.as_dvec3()) as f32;
        if starts_on {
            let other = 2.0 * b / a;
            return (self.power_at(at) <= 0.0).then_some(SphereRoots {
                near: other,
                far: other,
            });
        }
        let squared = self.radius * self.radius;
        let discriminant = if b * b <= a * squared {
            b * b - a * self.power_at(at)
        } else {
            let along_ray = dir.as_dvec3() * f64::from(b / a);
            let remainder = (from_center + along_ray).as_vec3();
            let along = remainder.dot(dir);
            (squared - remainder.dot(remainder)) * a + along * along
        };
        if !(discriminant >= 0.0) {
            return None;
        }
        let root = discriminant.sqrt();
        let q = if b >= 0.0 { b + root } else { b - root };
        if q == 0.0 {
            return None;
        }
        let (first, second) = (self.power_at(at) / q, q / a);
        let (near, far) = if b >= 0.0 {
            (first, second)
        } else {
            (second, first)
        };
        Some(SphereRoots { near, far })
    }

    /// The height of a point near the sphere.
    pub fn height(&self, point: Vec3) -> SphereHeight {
        let at = self.place(point);
        let (from_base, from_center) = (at.0.as_vec3(), at.1.as_vec3());
        let length = from_center.length().max(f32::MIN_POSITIVE);
        let normal = from_center / length;
        let span = length + self.radius;
        // Of the power's sums, and of the point itself, which is moved from here.
        let products = from_base.abs().dot(from_center.abs() + self.center.abs());
        let one_way = gamma(6) * products / span + gamma(1) * normal.abs().dot(point.abs());
        SphereHeight {
            height: self.power_at(at) / span,
            error: 2.0 * one_way,
            normal,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{offset_origin, step_off};
    use crate::testing::{Random, Ulps};

    /// The first root ahead, in f64, of the same sphere before it was rounded.
    fn exact(center: DVec3, radius: f64, origin: Vec3, dir: Vec3) -> Option<f64> {
        let (dir, from_center) = (dir.as_dvec3(), origin.as_dvec3() - center);
        let (a, b) = (dir.dot(dir), -from_center.dot(dir));
        let distance = from_center.length();
        let power = (distance - radius) * (distance + radius);
        let discriminant = if b * b <= a * radius * radius {
            b * b - a * power
        } else {
            radius * radius * a - from_center.cross(dir).length_squared()
        };
        if discriminant < 0.0 {
            return None;
        }
        let q = b + discriminant.sqrt().copysign(b);
        let roots = [power / q, q / a].map(|t| if t > 0.0 { t } else { f64::INFINITY });
        Some(roots[0].min(roots[1])).filter(|t| t.is_finite())
    }

    /// Rays from the eye at a sphere: errors in t, and how many hit where f64 misses or the other way round.
    fn sweep(seed: u64, mut ray: impl FnMut(&mut Random) -> (DVec3, f64, Vec3)) -> (Ulps, u32) {
        let (mut ulps, mut wrong) = (Ulps::default(), 0);
        let mut random = Random::new(seed);
        for _ in 0..100_000 {
            let (center, radius, dir) = ray(&mut random);
            let roots = SphereFrame::new(center, radius).intersect(Vec3::ZERO, dir, false);
            let found = roots.and_then(|r| [r.near, r.far].into_iter().find(|&t| t > 0.0));
            match (found, exact(center, radius, Vec3::ZERO, dir)) {
                (Some(t), Some(exact)) => ulps.add(t, exact),
                (None, None) => {}
                _ => wrong += 1,
            }
        }
        (ulps, wrong)
    }

    #[test]
    fn roots_of_a_known_ray() {
        let sphere = SphereFrame::new(DVec3::new(0.0, 0.0, -5.0), 1.0);
        let roots = sphere
            .intersect(Vec3::ZERO, Vec3::NEG_Z * 2.0, false)
            .unwrap();
        assert_eq!((roots.near, roots.far), (2.0, 3.0));
        let beside = sphere.intersect(Vec3::X * 1.5, Vec3::NEG_Z, false);
        assert!(beside.is_none());
        let within = SphereFrame::new(DVec3::ZERO, 2.0).intersect(Vec3::ZERO, Vec3::X, false);
        let within = within.unwrap();
        assert_eq!((within.near, within.far), (-2.0, 2.0));
    }

    #[test]
    fn a_far_sphere_is_hit_where_f64_hits_it() {
        // The textbook's b^2 - 4ac has 25,000 wrong in a million at 1e3 and half of them at 1e4.
        for exponent in 0..=6 {
            let distance = 10_f64.powi(exponent) + 1.0;
            let (mut ulps, wrong) = sweep(exponent as u64, |random| {
                let center = random.direction() * distance;
                let target = center + random.cube() * 1.5;
                let length = random.range(0.1, 3.0);
                (center, 1.0, (target * (length / distance)).as_vec3())
            });
            assert_eq!(wrong, 0, "hits and misses at 1e{exponent} radii");
            let [p50, p99, p999, _] = ulps.quantiles();
            assert!(
                p50 <= 0.5 && p99 <= 2.5 && p999 <= 5.0,
                "t at 1e{exponent} radii is off by {p50} {p99} {p999} ulps"
            );
        }
    }

    #[test]
    fn a_huge_sphere_is_as_exact_as_the_eye_is_high() {
        // With the power from centre and radius alone, t is off by a million ulps (p99) at 1e6.
        for (exponent, is_turned) in (1..=6).flat_map(|e| [(e, false), (e, true)]) {
            let radius = 10_f64.powi(exponent);
            let (mut ulps, wrong) = sweep(exponent as u64, |random| {
                let turned = random.direction();
                let up = if is_turned { turned } else { DVec3::Y };
                let across = up.cross(random.direction()).normalize();
                let pitch = random.range(-5.0, 65.0_f64).to_radians();
                let dir = across * pitch.cos() - up * pitch.sin();
                let center = up * -(radius + random.range(0.5, 2.0));
                (center, radius, (dir * random.range(0.3, 2.0)).as_vec3())
            });
            assert_eq!(wrong, 0, "hits and misses at a radius of 1e{exponent}");
            let [_, p99, ..] = ulps.quantiles();
            assert!(
                p99 <= 4.0,
                "t at a radius of 1e{exponent} is off by {p99} ulps"
            );
        }
    }

    #[test]
    fn a_point_moved_onto_a_sphere_is_within_its_bound() {
        let mut random = Random::new(5);
        let mut lifts = Vec::new();
        for _ in 0..200_000 {
            let (up, toward) = (random.direction(), random.direction());
            let radius = 10_f64.powf(random.range(-2.0, 2.0));
            let height = radius * 10_f64.powf(random.range(-4.0, 4.0));
            let center = -up * (radius + height);
            let on = center + radius * toward;
            let near = (on * (1.0 + 1e-7 * random.range(-1.0, 1.0))).as_vec3();
            let SphereHeight {
                height: above,
                error,
                normal,
            } = SphereFrame::new(center, radius).height(near);
            let dir = -random.direction().as_vec3();
            let position = near - step_off(above, normal, dir);
            let lift = error + normal.abs().dot(position.abs()) * gamma(1);
            let off = (position.as_dvec3() - center).length() - radius;
            // The row's own rounding moves the sphere by an ulp of the eye's height.
            let slack = height * f64::from(f32::EPSILON);
            assert!(
                off.abs() <= f64::from(lift) + slack,
                "{off} beyond {lift} at {near} of {center}, {radius}"
            );
            lifts.push(lift / (position.length() * f32::EPSILON));
        }
        lifts.sort_by(f32::total_cmp);
        let median = lifts[lifts.len() / 2];
        assert!(median <= 16.0, "a ray starts {median} ulps off");
    }

    #[test]
    fn a_ray_that_leaves_outward_never_returns() {
        let sphere = SphereFrame::new(DVec3::new(0.3, -1e4, -2.0), 1e4 - 1.0);
        let mut random = Random::new(6);
        for _ in 0..100_000 {
            let aim = (random.cube() - DVec3::Y).as_vec3();
            let Some(roots) = sphere.intersect(Vec3::ZERO, aim, false) else {
                continue;
            };
            let near = aim * roots.near;
            let SphereHeight {
                height,
                error,
                normal,
            } = sphere.height(near);
            let along = random.direction().as_vec3();
            let across = along - normal * normal.dot(along);
            let dir = across + normal * 10_f32.powf(random.range(-9.0, 0.0) as f32);
            let dir = dir.normalize();
            if normal.dot(dir) < 0.0 {
                continue;
            }
            let position = near - step_off(height, normal, aim);
            let origin = offset_origin(position, normal, error, dir);
            let again = sphere.intersect(origin, dir, true);
            assert!(
                again.is_none_or(|r| r.far <= 0.0),
                "{dir} from {origin} comes back"
            );
        }
    }
}
