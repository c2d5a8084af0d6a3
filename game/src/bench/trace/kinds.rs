//! The rays of a whole frame by kind: primary; a shadow ray and a mirrored ray from every hit; a shadow ray from every hit
//! of those; and diffuse rays from the primary hits, the least coherent of all.
//!
//! All in the order of their pixels, tile by tile of 8 x 8, as a picture's own kernel traces them.

use glam::{DVec3, UVec2};
use orrery_engine::trace::{Hit, Query, Ray, TraceError, Tracer};

use super::stage::Stage;
use crate::bench::rays::{RaySet, outward_normal, primary_rays, ray};

/// Pixels across and down that a workgroup traces.
const TILE: u32 = 8;
/// Lift of a ray's origin along the normal, in units of its distance from the eye.
const LIFT: f64 = 1e-5;

/// Traces the rays of so many pixels, kind by kind.
pub fn trace(
    stage: &Stage,
    size: UVec2,
    tracer: &mut dyn Tracer,
) -> Result<Vec<RaySet>, TraceError> {
    let rows = primary_rays(&stage.frame.view, size);
    let rays: Vec<Ray> = tiles(size).map(|pixel| rows[pixel]).collect();
    let primary = answered("primary", Query::Closest, rays, tracer)?;
    let points = Point::all(stage, &primary);
    let shadow = points.iter().map(|point| point.shadow_ray(stage.light));
    let mirrored = points.iter().map(Point::mirrored_ray);
    let diffuse = (0..).zip(&points).map(|(i, point)| point.diffuse_ray(i));
    let (shadow, mirrored, diffuse) = (shadow.collect(), mirrored.collect(), diffuse.collect());
    let shadow = answered("shadow", Query::Any, shadow, tracer)?;
    let reflect = answered("reflect", Query::Closest, mirrored, tracer)?;
    let beyond = Point::all(stage, &reflect);
    let beyond = beyond
        .iter()
        .map(|point| point.shadow_ray(stage.light))
        .collect();
    let reflect_shadow = answered("reflect_shadow", Query::Any, beyond, tracer)?;
    let diffuse = answered("diffuse", Query::Closest, diffuse, tracer)?;
    Ok(vec![primary, shadow, reflect, reflect_shadow, diffuse])
}

/// The kinds that a whole frame is made of.
pub const WHOLE_FRAME: [&str; 4] = ["primary", "shadow", "reflect", "reflect_shadow"];

fn answered(
    kind: &'static str,
    query: Query,
    rays: Vec<Ray>,
    tracer: &mut dyn Tracer,
) -> Result<RaySet, TraceError> {
    let hits = tracer.intersect(&rays, query)?;
    Ok(RaySet {
        kind,
        query,
        rays,
        hits,
    })
}

/// Numbers of pixels, tile by tile.
pub fn tiles(size: UVec2) -> impl Iterator<Item = usize> {
    let corners = (0..size.y).step_by(TILE as usize);
    let corners =
        corners.flat_map(move |y| (0..size.x).step_by(TILE as usize).map(move |x| (x, y)));
    corners.flat_map(move |(left, top)| {
        let rows = top..(top + TILE).min(size.y);
        rows.flat_map(move |y| {
            (left..(left + TILE).min(size.x)).map(move |x| (y * size.x + x) as usize)
        })
    })
}

/// Where a ray met something.
struct Point {
    dir: DVec3,
    at: DVec3,
    /// On the side the ray came from.
    normal: DVec3,
}

impl Point {
    fn all(stage: &Stage, set: &RaySet) -> Vec<Self> {
        let met = set
            .rays
            .iter()
            .zip(&set.hits)
            .filter(|(_, hit)| hit.instance != u32::MAX);
        met.map(|(ray, hit)| Self::of(stage, ray, hit)).collect()
    }

    fn of(stage: &Stage, ray: &Ray, hit: &Hit) -> Self {
        let dir = ray.dir.as_dvec3();
        let point = ray.origin.as_dvec3() + dir * hit.t;
        let outward = outward_normal(&stage.work, hit, point);
        let normal = if outward.dot(dir) > 0.0 {
            -outward
        } else {
            outward
        };
        Self {
            dir,
            at: point + normal * (LIFT * point.length()),
            normal,
        }
    }

    fn shadow_ray(&self, light: DVec3) -> Ray {
        let to_light = light - self.at;
        Ray {
            t_max: to_light.length() as f32,
            ..ray(self.at, to_light)
        }
    }

    fn mirrored_ray(&self) -> Ray {
        ray(
            self.at,
            self.dir - self.normal * (2.0 * self.dir.dot(self.normal)),
        )
    }

    /// By the cosine about the normal: a point of the unit sphere on top of it.
    fn diffuse_ray(&self, number: u64) -> Ray {
        let z = 2.0 * fraction(2 * number) - 1.0;
        let (sin, cos) = (fraction(2 * number + 1) * std::f64::consts::TAU).sin_cos();
        let around = DVec3::new(cos, sin, 0.0) * (1.0 - z * z).max(0.0).sqrt() + DVec3::Z * z;
        ray(
            self.at,
            (self.normal + around * (1.0 - 1e-6)).normalize_or(self.normal),
        )
    }
}

/// In [0, 1), well mixed (the finaliser of SplitMix64; Steele, Lea and Flood, OOPSLA 2014).
fn fraction(number: u64) -> f64 {
    let mut z = number.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_name_every_pixel_once() {
        let size = UVec2::new(21, 10);
        let mut order: Vec<usize> = tiles(size).collect();
        assert_eq!(order[..10], [0, 1, 2, 3, 4, 5, 6, 7, 21, 22]);
        order.sort_unstable();
        assert!(order.into_iter().eq(0..210));
    }
}
