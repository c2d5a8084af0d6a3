//! The ray-sphere test that stays accurate for far and for small spheres.
//!
//! Haines, Günther, Akenine-Möller, "Precision Improvements for Ray/Sphere Intersection" (Ray Tracing
//! Gems, 2019, ch. 7): discriminant from the perpendicular remainder, roots by the stable quadratic.

use glam::Vec3;

/// Both distances to a sphere, `near <= far`, in lengths of the ray's direction; either may be negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereRoots {
    /// Entry.
    pub near: f32,
    /// Exit.
    pub far: f32,
}

/// Meets a sphere of `radius` whose centre is at `origin - from_center`.
///
/// A ray that `starts_on` the sphere has one root at zero, known exactly: the other one, 2b/a, is
/// returned as both.
pub fn intersect_sphere(
    from_center: Vec3,
    dir: Vec3,
    radius: f32,
    starts_on: bool,
) -> Option<SphereRoots> {
    let a = dir.dot(dir);
    let b = -from_center.dot(dir);
    if starts_on {
        let other = 2.0 * b / a;
        return Some(SphereRoots {
            near: other,
            far: other,
        });
    }
    let remainder = from_center + dir * (b / a);
    let discriminant = radius * radius - remainder.dot(remainder);
    if !(discriminant >= 0.0) {
        return None;
    }
    let distance = from_center.length();
    let c = (distance - radius) * (distance + radius);
    let root = (discriminant * a).sqrt();
    let q = if b >= 0.0 { b + root } else { b - root };
    if q == 0.0 {
        return None;
    }
    let (first, second) = (c / q, q / a);
    Some(if b >= 0.0 {
        SphereRoots {
            near: first,
            far: second,
        }
    } else {
        SphereRoots {
            near: second,
            far: first,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_of_a_known_ray() {
        let roots = intersect_sphere(Vec3::new(0.0, 0.0, 5.0), Vec3::NEG_Z * 2.0, 1.0, false);
        let roots = roots.unwrap();
        assert_eq!((roots.near, roots.far), (2.0, 3.0));
        assert!(intersect_sphere(Vec3::new(0.0, 1.5, 5.0), Vec3::NEG_Z, 1.0, false).is_none());
    }

    #[test]
    fn a_far_small_sphere_is_hit_where_f64_hits_it() {
        let mut state = 3_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 16_777_216.0
        };
        let mut wrong = 0;
        for _ in 0..100_000 {
            let distance = 1_000.0_f32;
            let dir = Vec3::new(random() * 0.002 - 0.001, random() * 0.002 - 0.001, -1.0);
            let from_center = Vec3::new(0.0, 0.0, distance);
            let exact = {
                let (f, d) = (from_center.as_dvec3(), dir.as_dvec3());
                let b = -f.dot(d);
                let rem = f + d * (b / d.dot(d));
                1.0 - rem.dot(rem) >= 0.0
            };
            let found = intersect_sphere(from_center, dir, 1.0, false).is_some();
            wrong += u32::from(found != exact);
        }
        assert!(
            wrong <= 10,
            "{wrong} wrong of 100,000 (the textbook form: about 2,000)"
        );
    }
}
