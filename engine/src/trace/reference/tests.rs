//! Solids: the f32 kernels against f64, and the reference's torus against a march along the ray.

use glam::{DVec2, DVec3, Vec3};

use super::shape::{LocalRay, cone, cone_normal, disc};
use super::torus::torus;
use crate::geom::{
    CONE_SIDE, cone_point, cone_radius, intersect_cone, intersect_disc, intersect_torus,
    torus_point,
};
use crate::testing::{Random, Ulps};
use crate::world::Cone;

/// Where a ray meets something, nearest first, and on which primitive.
type Hits = Vec<(f64, u32)>;

/// A solid in its own space in both precisions.
#[derive(Clone, Copy, Debug)]
enum Solid {
    Disc,
    Cone { taper: f32 },
    Torus { minor: f32 },
}

impl Solid {
    fn random(random: &mut Random, number: u32) -> Self {
        match number % 4 {
            0 => Self::Disc,
            1 => Self::Cone {
                taper: [0.0, 0.5, -0.5][number as usize / 4 % 3],
            },
            2 => Self::Cone {
                taper: random.range(-0.5, 0.5) as f32,
            },
            _ => Self::Torus {
                minor: 10_f64.powf(random.range(-2.0, -0.02)) as f32,
            },
        }
    }

    fn fast(self, origin: Vec3, dir: Vec3, start: Option<u32>) -> Hits {
        let found: Vec<(f32, u32)> = match self {
            Self::Disc => intersect_disc(origin, dir)
                .filter(|_| start.is_none())
                .map_or(vec![], |t| vec![(t, 0)]),
            Self::Cone { taper } => intersect_cone(origin, dir, taper, start)
                .into_iter()
                .flatten()
                .collect(),
            Self::Torus { minor } => intersect_torus(origin, dir, minor, start.is_some())
                .into_iter()
                .flatten()
                .map(|t| (t, 0))
                .collect(),
        };
        let found = found.into_iter().map(|(t, prim)| (f64::from(t), prim));
        ahead(found.collect(), least(dir, start))
    }

    fn exact(self, origin: Vec3, dir: Vec3, start: Option<u32>) -> Hits {
        let ray = LocalRay {
            origin: origin.as_dvec3(),
            dir: dir.as_dvec3(),
            start,
        };
        let found = match self {
            Self::Disc => disc(&ray, DVec3::ZERO, DVec3::Y, 1.0),
            Self::Cone { taper } => cone(&ray, &as_cone(taper)),
            Self::Torus { minor } => torus(&ray, 1.0, minor.into()),
        };
        let found = found.into_iter().map(|hit| (hit.t, hit.prim));
        ahead(found.collect(), least(dir, start))
    }

    /// Distance of a point from a primitive's surface, however far that extends, and the unit normal there.
    fn height(self, prim: u32, p: DVec3) -> (f64, DVec3) {
        let across = DVec2::new(p.x, p.z);
        match self {
            Self::Disc => (p.y, DVec3::Y),
            Self::Cone { taper } if prim == CONE_SIDE => {
                let taper = f64::from(taper);
                let steepness = (1.0 + taper * taper).sqrt();
                let radius = (1.0 - taper.abs()) + taper * p.y;
                let normal = cone_normal(&as_cone(taper as f32), prim, p).normalize();
                ((across.length() - radius) / steepness, normal)
            }
            Self::Cone { .. } => {
                let side = if prim == 1 { -1.0 } else { 1.0 };
                (p.y * side - 1.0, DVec3::Y * side)
            }
            Self::Torus { minor } => {
                let ring = across.normalize_or(DVec2::X);
                let out = p - DVec3::new(ring.x, 0.0, ring.y);
                (out.length() - f64::from(minor), out.normalize())
            }
        }
    }

    /// A point of the surface, of its edges more often than chance has it.
    fn point(self, random: &mut Random) -> DVec3 {
        let turn = random.range(0.0, std::f64::consts::TAU);
        let rim = |radius: f64, y: f64| DVec3::new(radius * turn.cos(), y, radius * turn.sin());
        match self {
            Self::Disc => rim(random.unit().sqrt(), 0.0),
            Self::Cone { taper } => {
                let y = [-1.0, 1.0, random.range(-1.0, 1.0)][(random.unit() * 3.0) as usize];
                let radius = f64::from(cone_radius(taper, y as f32));
                let is_inner = y.abs() == 1.0 && random.unit() < 0.5;
                rim(radius * if is_inner { random.unit() } else { 1.0 }, y)
            }
            Self::Torus { minor } => {
                let tube = random.range(0.0, std::f64::consts::TAU);
                let minor = f64::from(minor);
                rim(1.0 + minor * tube.cos(), minor * tube.sin())
            }
        }
    }

    /// A point near the surface moved onto a primitive as the tracers do, with the normal there.
    fn snapped(self, near: Vec3, prim: u32) -> (Vec3, Vec3) {
        let point = match self {
            Self::Disc => return (Vec3::new(near.x, 0.0, near.z), Vec3::Y),
            Self::Cone { taper } => cone_point(near, taper, prim),
            Self::Torus { minor } => torus_point(near, minor),
        };
        (point.at, point.normal.normalize())
    }
}

fn as_cone(taper: f32) -> Cone {
    let taper = f64::from(taper);
    Cone {
        a: DVec3::NEG_Y,
        radius_a: (1.0 - taper.abs()) - taper,
        b: DVec3::Y,
        radius_b: (1.0 - taper.abs()) + taper,
        open: false,
    }
}

/// Where two primitives meet, rounding puts a start beyond one of them: it is as good as on both.
fn least(dir: Vec3, start: Option<u32>) -> f64 {
    start.map_or(0.0, |_| 1e-5 / f64::from(dir.length()))
}

fn ahead(mut hits: Hits, least: f64) -> Hits {
    hits.retain(|hit| hit.0 > least);
    hits.sort_by(|a, b| a.0.total_cmp(&b.0));
    hits
}

/// A ray from outside, from within, along the axis, at an edge, or touching the surface.
fn ray(random: &mut Random, solid: Solid, number: u32) -> (Vec3, Vec3) {
    let outside = random.direction() * random.range(1.8, 6.0);
    let target = solid.point(random);
    let (origin, dir) = match number % 5 {
        0 => (outside, random.cube() * 1.2 - outside),
        1 => (outside, target - outside),
        2 => (random.cube() * 0.4, random.direction()),
        3 => {
            let side = if random.unit() < 0.5 { -1.0 } else { 1.0 };
            let place = random.cube() * DVec3::new(1.2, 0.0, 1.2);
            (place - DVec3::Y * side * 3.0, DVec3::Y * side)
        }
        _ => {
            let (_, normal) = solid.height(0, target);
            let along = random.direction().reject_from_normalized(normal);
            (target - along * random.range(1.0, 4.0), along)
        }
    };
    let length = 10_f64.powf(random.range(-3.0, 3.0));
    (origin.as_vec3(), (dir * length).as_vec3())
}

#[test]
fn solids_are_hit_where_f64_hits_them() {
    let mut random = Random::new(17);
    let (mut ulps, mut worst, mut tried, mut differ) = (Ulps::default(), 0.0_f64, 0, 0);
    for number in 0..400_000 {
        let solid = Solid::random(&mut random, number);
        let (origin, dir) = ray(&mut random, solid, number / 4);
        let (fast, exact) = (
            solid.fast(origin, dir, None),
            solid.exact(origin, dir, None),
        );
        let line = |t: f64| origin.as_dvec3() + dir.as_dvec3() * t;
        for &(t, prim) in &fast {
            let (height, _) = solid.height(prim, line(t));
            // Of what the origin itself may round by.
            let eps = f64::from(f32::EPSILON) * f64::from(origin.length().max(1.0));
            worst = worst.max(height.abs() / eps);
        }
        tried += 1;
        if fast.len() != exact.len() {
            // Only rays that touch may differ, or that pass an edge.
            differ += u32::from(number / 4 % 5 == 0);
            continue;
        }
        for (&(found, prim), &(t, on)) in fast.iter().zip(&exact) {
            let (_, normal) = solid.height(prim, line(t));
            let cosine = normal.dot(dir.as_dvec3().normalize()).abs();
            if prim == on && cosine > 0.2 && t * f64::from(dir.length()) > 0.5 {
                ulps.add(found as f32, t);
            }
        }
    }
    let [p50, p99, p999, max] = ulps.quantiles();
    let story = format!(
        "t errs by {p50:.2}, {p99:.2}, {p999:.2}, at most {max:.1} ulps; points are off by at most \
         {worst:.2} ulps of the origin; {differ} of {tried} random rays hit or miss otherwise"
    );
    assert!(p50 <= 1.0 && p99 <= 6.0 && p999 <= 12.0, "{story}");
    assert!(worst <= 16.0, "{story}");
    assert!(differ <= 4, "{story}");
}

#[test]
fn a_ray_that_leaves_a_solid_does_not_meet_where_it_starts() {
    let mut random = Random::new(23);
    let (mut inward, mut worst, mut differ) = (0, 0.0_f64, 0);
    for number in 0..400_000 {
        let solid = Solid::random(&mut random, number);
        let near = solid.point(&mut random).as_vec3();
        let prim = match solid {
            Solid::Cone { .. } if near.y.abs() == 1.0 => 1 + u32::from(near.y > 0.0),
            _ => 0,
        };
        let (at, normal) = solid.snapped(near, prim);
        // Half of them graze.
        let flat = random
            .direction()
            .reject_from_normalized(normal.as_dvec3())
            .normalize();
        let steepness = match number / 4 % 2 {
            0 => random.unit(),
            _ => 10_f64.powf(random.range(-5.0, -1.0)),
        };
        let side = if number / 8 % 2 == 0 { 1.0 } else { -1.0 };
        let dir = (flat + normal.as_dvec3() * (side * steepness)).as_vec3();
        // Tracers step off the surface to the side the ray leaves by.
        let at = at + normal * (side as f32 * 1e-6);
        let (fast, exact) = (
            solid.fast(at, dir, Some(prim)),
            solid.exact(at, dir, Some(prim)),
        );
        let is_convex = matches!(solid, Solid::Cone { .. } | Solid::Disc);
        if is_convex && side > 0.0 {
            // At an edge two primitives meet, and rounding puts the point beyond one of them.
            let self_hit = fast
                .iter()
                .find(|hit| hit.0 * f64::from(dir.length()) > 1e-6);
            assert_eq!(self_hit, None, "{solid:?} from {at} along {dir}");
        }
        if fast.len() != exact.len() {
            differ += 1;
            continue;
        }
        inward += fast.len();
        for &(found, prim) in &fast {
            // Where a ray leaves along a line of a cone's side, how far it gets is anybody's guess.
            if steepness > 0.2 {
                let (height, _) = solid.height(prim, at.as_dvec3() + dir.as_dvec3() * found);
                worst = worst.max(height.abs() / f64::from(f32::EPSILON));
            }
        }
    }
    let story = format!(
        "{inward} hits elsewhere, off by at most {worst:.2} ulps of the solid; \
         {differ} of 400,000 rays have another number of them"
    );
    assert!(
        inward > 100_000 && worst <= 64.0 && differ <= 400,
        "{story}"
    );
}

#[test]
fn the_reference_finds_every_root_of_a_torus() {
    let mut random = Random::new(31);
    let mut roots = [0; 5];
    for number in 0..1_500 {
        let major = 10_f64.powf(random.range(-2.0, 2.0));
        let minor = major * random.range(0.02, 0.98);
        let origin = random.direction() * (major * random.range(0.1, 4.0));
        let target = random.cube() * DVec3::new(1.2, 0.2, 1.2) * major;
        let dir = (target - origin) * random.range(0.1, 3.0);
        let ray = LocalRay {
            origin,
            dir,
            start: None,
        };
        let found = torus(&ray, major, minor);
        let excess = |t: f64| {
            let p = origin + dir * t;
            let from_ring = DVec2::new(p.x, p.z).length() - major;
            (from_ring.hypot(p.y) - minor) / major
        };
        for hit in &found {
            let off = excess(hit.t).abs();
            assert!(off < 1e-11, "ray {number}: a root is {off:e} off");
        }
        let (low, high) = (-8.0 * major / dir.length(), 8.0 * major / dir.length());
        let place = |step: u32| low + (high - low) * f64::from(step) / 20_000.0;
        let changes: Vec<_> = (0..20_000)
            .map(|step| (place(step), place(step + 1)))
            .filter(|&(from, to)| (excess(from) < 0.0) != (excess(to) < 0.0))
            .collect();
        for &(from, to) in &changes {
            let within = found.iter().filter(|hit| hit.t >= from && hit.t <= to);
            assert_eq!(within.count(), 1, "ray {number} between {from} and {to}");
        }
        // A march steps over two roots that are closer than its steps; the reference must not invent any.
        assert!(
            found.len() >= changes.len() && found.len().is_multiple_of(2),
            "ray {number}"
        );
        roots[found.len()] += 1;
    }
    assert!(roots[0] > 50 && roots[2] > 50 && roots[4] > 50, "{roots:?}");
}
