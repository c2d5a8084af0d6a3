//! The rays of a frame by kind: primary, then from every primary hit the shadow, mirrored and refracted
//! rays of Whitted's model.
//!
//! They are made here from the hits of the dumped work, the tracers' own rays of the first two
//! generations in f32, except that origins are lifted by a plain 1e-5 of their size.

use glam::{DVec3, UVec2, Vec3};
use orrery_engine::frame::{FrameScene, LightKind, Shape, View, ViewProjection};
use orrery_engine::trace::{Hit, Query, Ray, TraceError, Tracer};
use orrery_engine::world::{Material, Reflection};

use super::work::Work;

/// Lift of a ray's origin along the normal, in units of its distance from the eye.
const LIFT: f64 = 1e-5;

/// Rays of one kind and what they met.
#[derive(Clone)]
pub struct RaySet {
    /// What they are for.
    pub kind: &'static str,
    /// What was asked of them.
    pub query: Query,
    /// The rays.
    pub rays: Vec<Ray>,
    /// One answer a ray.
    pub hits: Vec<Hit>,
}

/// Traces the primary rays of `size` pixels and the rays of the next generation.
pub fn trace(
    work: &Work,
    scene: &FrameScene,
    size: UVec2,
    tracer: &mut dyn Tracer,
) -> Result<Vec<RaySet>, TraceError> {
    let primary = primary_rays(&scene.view, size);
    let hits = tracer.intersect(&primary, Query::Closest)?;
    let mut next = Next::default();
    for (ray, hit) in primary.iter().zip(&hits) {
        if hit.instance != u32::MAX {
            next.spawn(work, scene, ray, hit);
        }
    }
    let mut sets = vec![RaySet {
        kind: "primary",
        query: Query::Closest,
        rays: primary,
        hits,
    }];
    for (kind, query, rays) in [
        ("shadow", Query::Any, next.shadow),
        ("reflect", Query::Closest, next.reflect),
        ("refract", Query::Closest, next.refract),
    ] {
        if !rays.is_empty() {
            let hits = tracer.intersect(&rays, query)?;
            sets.push(RaySet {
                kind,
                query,
                rays,
                hits,
            });
        }
    }
    Ok(sets)
}

/// One ray through every pixel's centre, in rows from the top.
pub fn primary_rays(view: &View, size: UVec2) -> Vec<Ray> {
    let pixels = (0..size.y).flat_map(|y| (0..size.x).map(move |x| (x, y)));
    pixels
        .map(|(x, y)| {
            let across = (f64::from(x) + 0.5) / f64::from(size.x) - 0.5;
            let up = 0.5 - (f64::from(y) + 0.5) / f64::from(size.y);
            let offset = view.right * across + view.up * up;
            match view.projection {
                ViewProjection::Perspective => ray(DVec3::ZERO, view.forward + offset),
                ViewProjection::Orthographic => ray(offset, view.forward),
            }
        })
        .collect()
}

/// A ray without an end; `dir` of any length.
pub fn ray(origin: DVec3, dir: DVec3) -> Ray {
    Ray {
        origin: origin.as_vec3(),
        dir: dir.normalize().as_vec3(),
        t_min: 0.0,
        t_max: f32::MAX,
    }
}

/// Rays of the second generation.
#[derive(Default)]
struct Next {
    shadow: Vec<Ray>,
    reflect: Vec<Ray>,
    refract: Vec<Ray>,
}

impl Next {
    fn spawn(&mut self, work: &Work, scene: &FrameScene, incoming: &Ray, hit: &Hit) {
        let dir = incoming.dir.as_dvec3();
        let point = incoming.origin.as_dvec3() + dir * hit.t;
        let outward = outward_normal(work, hit, point);
        let inside = outward.dot(dir) > 0.0;
        let normal = if inside { -outward } else { outward };
        let lift = normal * (LIFT * point.length());
        self.spawn_shadows(scene, point, normal, point + lift);
        let row = work.frame.instances[hit.instance as usize].material;
        let material = &work.frame.materials[row as usize];
        let cosine = -dir.dot(normal);
        if material.reflection != Reflection::None {
            let mirrored = dir + normal * (2.0 * cosine);
            self.reflect.push(ray(point + lift, mirrored));
        }
        if transmits(material) {
            let eta = if inside {
                material.ior
            } else {
                1.0 / material.ior
            };
            let square = 1.0 - eta * eta * (1.0 - cosine * cosine);
            if square >= 0.0 {
                let bent = dir * eta + normal * (eta * cosine - square.sqrt());
                self.refract.push(ray(point - lift, bent));
            }
        }
    }

    fn spawn_shadows(&mut self, scene: &FrameScene, point: DVec3, normal: DVec3, origin: DVec3) {
        for light in scene.lights.iter() {
            let (to_light, distance) = match light.kind {
                LightKind::Directional { to_light } => (to_light, f64::from(f32::MAX)),
                LightKind::Point { position } | LightKind::Spot { position, .. } => {
                    let to_light = position - scene.view.origin - point;
                    (to_light, to_light.length())
                }
            };
            if to_light.dot(normal) > 1e-10 {
                let shadow = ray(origin, to_light);
                self.shadow.push(Ray {
                    t_max: distance as f32,
                    ..shadow
                });
            }
        }
    }
}

fn transmits(material: &Material) -> bool {
    material.transmission() != Vec3::ZERO
}

/// Unit geometric normal at a hit, away from the inside of closed shapes.
pub fn outward_normal(work: &Work, hit: &Hit, point: DVec3) -> DVec3 {
    let instance = &work.frame.instances[hit.instance as usize];
    let normal = match instance.shape {
        Shape::Mesh(mesh) => {
            let corners = work.meshes[mesh as usize].triangles[hit.prim as usize];
            let corner = |v: Vec3| instance.world_from_local.transform_point3(v.as_dvec3());
            let [a, b, c] = corners.map(corner);
            (b - a).cross(c - a)
        }
        _ => point - instance.world_from_local.translation,
    };
    normal.normalize_or(DVec3::Y)
}
