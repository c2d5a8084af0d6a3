//! Shapes in f64, each with the plainest test that is right.
//!
//! A ray that starts on a primitive leaves it out by number; a sphere answers with its other root. No
//! offsets, no epsilons: in f64 a point is within 1e-16 of its surface.

use glam::{DVec2, DVec3};

use crate::world::Cone;

/// Primitives of a [`Cone`].
const CONE_SIDE: u32 = 0;
const CONE_CAP_A: u32 = 1;
const CONE_CAP_B: u32 = 2;

/// From one cap of a cone to the other: unit direction and distance.
fn cone_axis(cone: &Cone) -> (DVec3, f64) {
    let line = cone.b - cone.a;
    (line.normalize(), line.length())
}

/// Outward normal of a cone's primitive at a point of it, of any length.
pub fn cone_normal(cone: &Cone, prim: u32, point: DVec3) -> DVec3 {
    let (axis, height) = cone_axis(cone);
    match prim {
        CONE_CAP_A => -axis,
        CONE_CAP_B => axis,
        _ => {
            let out = (point - cone.a).reject_from_normalized(axis);
            out.normalize_or_zero() - axis * ((cone.radius_b - cone.radius_a) / height)
        }
    }
}

/// A hit in a shape's local space.
#[derive(Clone, Copy, Debug)]
pub struct LocalHit {
    /// In lengths of the ray's direction.
    pub t: f64,
    /// Primitive.
    pub prim: u32,
    /// Barycentric weights of a triangle's second and third corner.
    pub uv: DVec2,
}

/// A ray in a shape's local space; `start` is the primitive it leaves.
#[derive(Clone, Copy)]
pub struct LocalRay {
    /// Start.
    pub origin: DVec3,
    /// Direction of any length.
    pub dir: DVec3,
    /// The primitive it starts on, if on this shape.
    pub start: Option<u32>,
}

impl LocalHit {
    pub(super) fn on(prim: u32, t: f64) -> Self {
        Self {
            t,
            prim,
            uv: DVec2::ZERO,
        }
    }
}

/// Both roots of the sphere of `radius` about the origin, nearest first.
pub fn sphere(ray: &LocalRay, radius: f64) -> Vec<LocalHit> {
    let a = ray.dir.length_squared();
    let b = -ray.origin.dot(ray.dir);
    if ray.start.is_some() {
        return vec![LocalHit::on(0, 2.0 * b / a)];
    }
    let remainder = ray.origin + ray.dir * (b / a);
    let discriminant = radius * radius - remainder.length_squared();
    if discriminant < 0.0 {
        return Vec::new();
    }
    let q = b + (discriminant * a).sqrt().copysign(b);
    if q == 0.0 {
        return Vec::new();
    }
    let distance = ray.origin.length();
    let c = (distance - radius) * (distance + radius);
    let (first, second) = (c / q, q / a);
    vec![
        LocalHit::on(0, first.min(second)),
        LocalHit::on(0, first.max(second)),
    ]
}

/// The plane n.p = `distance`.
pub fn plane(ray: &LocalRay, normal: DVec3, distance: f64) -> Vec<LocalHit> {
    let along = normal.dot(ray.dir);
    if ray.start.is_some() || along == 0.0 {
        return Vec::new();
    }
    vec![LocalHit::on(0, (distance - normal.dot(ray.origin)) / along)]
}

/// The six faces of a box, one by one.
pub fn cuboid(ray: &LocalRay, min: DVec3, max: DVec3) -> Vec<LocalHit> {
    let mut hits = Vec::new();
    for face in 0..6_u32 {
        let axis = face as usize / 2;
        let side = if face % 2 == 1 { max } else { min };
        if ray.start == Some(face) || ray.dir[axis] == 0.0 {
            continue;
        }
        let t = (side[axis] - ray.origin[axis]) / ray.dir[axis];
        let p = ray.origin + ray.dir * t;
        let inside = (0..3).all(|i| i == axis || (p[i] >= min[i] && p[i] <= max[i]));
        if inside {
            hits.push(LocalHit::on(face, t));
        }
    }
    hits
}

/// Outward normal of a box's face.
pub fn cuboid_normal(face: u32) -> DVec3 {
    DVec3::AXES[face as usize / 2] * if face % 2 == 1 { 1.0 } else { -1.0 }
}

/// A disc: its plane, and how far from the centre.
pub fn disc(ray: &LocalRay, center: DVec3, normal: DVec3, radius: f64) -> Vec<LocalHit> {
    let from_center = LocalRay {
        origin: ray.origin - center,
        ..*ray
    };
    let mut hits = plane(&from_center, normal, 0.0);
    hits.retain(|hit| (from_center.origin + ray.dir * hit.t).length() <= radius);
    hits
}

/// A cone: the roots of its side that lie between the caps, and the caps as discs unless it is open.
pub fn cone(ray: &LocalRay, cone: &Cone) -> Vec<LocalHit> {
    let (axis, height) = cone_axis(cone);
    let growth = (cone.radius_b - cone.radius_a) / height;
    let origin = ray.origin - cone.a;
    // Heights and radii along the ray, and what is left across the axis.
    let (y, dy) = (origin.dot(axis), ray.dir.dot(axis));
    let (w, dw) = (cone.radius_a + growth * y, growth * dy);
    let (p, d) = (origin - axis * y, ray.dir - axis * dy);
    let (a, b, c) = (d.dot(d) - dw * dw, w * dw - p.dot(d), p.dot(p) - w * w);
    let roots = if ray.start == Some(CONE_SIDE) {
        vec![2.0 * b / a]
    } else {
        let across = [p.cross(d).length(), (p * dw - d * w).length()];
        let discriminant = (across[1] - across[0]) * (across[1] + across[0]);
        let q = b + discriminant.sqrt().copysign(b);
        vec![q / a, c / q]
    };
    // Not-a-number fails every comparison, and so is no hit.
    let is_between = |t: &f64| (0.0..=height).contains(&(y + dy * t)) && w + dw * t >= 0.0;
    let sides = roots.into_iter().filter(is_between);
    let mut hits: Vec<_> = sides.map(|t| LocalHit::on(CONE_SIDE, t)).collect();
    if cone.open {
        return hits;
    }
    for (prim, center, radius) in [
        (CONE_CAP_A, cone.a, cone.radius_a),
        (CONE_CAP_B, cone.b, cone.radius_b),
    ] {
        let cap = LocalRay {
            start: ray.start.filter(|&start| start == prim),
            ..*ray
        };
        let hit = disc(&cap, center, axis, radius);
        hits.extend(hit.into_iter().map(|hit| LocalHit::on(prim, hit.t)));
    }
    hits
}

/// A triangle, by the watertight test of Woop, Benthin and Wald (2013) in f64.
pub fn triangle(ray: &LocalRay, corners: [DVec3; 3], prim: u32) -> Option<LocalHit> {
    if ray.start == Some(prim) {
        return None;
    }
    let kz = ray.dir.abs().max_position();
    let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
    let [a, b, c] = corners.map(|corner| {
        let p = corner - ray.origin;
        let depth = p[kz] / ray.dir[kz];
        DVec3::new(
            p[kx] - ray.dir[kx] * depth,
            p[ky] - ray.dir[ky] * depth,
            depth,
        )
    });
    let edge = |p: DVec3, q: DVec3| q.x * p.y - q.y * p.x;
    let weights = DVec3::new(edge(b, c), edge(c, a), edge(a, b));
    let det = weights.element_sum();
    let mixed = weights.min_element() < 0.0 && weights.max_element() > 0.0;
    if mixed || det == 0.0 {
        return None;
    }
    let weights = weights / det;
    Some(LocalHit {
        t: weights.dot(DVec3::new(a.z, b.z, c.z)),
        prim,
        uv: DVec2::new(weights.y, weights.z),
    })
}
