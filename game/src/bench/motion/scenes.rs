//! Things in the leaves of a tree, and rays that look for the nearest of them.

use std::time::Instant;

use glam::{Affine3A, DVec3, Vec3};
use orrery_engine::bvh::{Bounds, Node4};
use orrery_engine::geom::{Shear, SphereFrame};
use orrery_engine::trace::Ray;

use crate::bench::crowd::{Random, side};
use crate::bench::walk::{Walker, ray};

/// A row of the tree.
#[derive(Clone, Copy, Debug)]
pub enum Thing {
    /// A sphere in the world.
    Sphere(SphereFrame),
    /// A mesh of few triangles.
    Mesh {
        /// Which one.
        mesh: u32,
        /// From the world's space into the mesh's.
        local_from_world: Affine3A,
    },
}

/// All rows.
#[derive(Clone, Debug)]
pub struct Scene {
    /// By row.
    pub things: Vec<Thing>,
    /// Corners of triangles.
    pub meshes: Vec<Vec<[Vec3; 3]>>,
}

/// Answers, and how long they took.
pub struct Traced {
    /// Of each ray: distance and row of the nearest hit.
    pub nearest: Vec<(f32, u32)>,
    /// Seconds of all.
    pub secs: f64,
}

impl Traced {
    /// Rays with another answer.
    pub fn differences(&self, other: &Self) -> u64 {
        let pairs = self.nearest.iter().zip(&other.nearest);
        pairs.filter(|(a, b)| a != b).count() as u64
    }
}

impl Scene {
    /// Rays of two kinds: anywhere in the crowd, and from one eye in order of pixels.
    pub fn rays(&self, things: usize, count: usize) -> [(&'static str, Vec<Ray>); 2] {
        let side = side(things);
        let mut random = Random(7);
        let scattered = (0..count).map(|_| {
            let origin = random.cube() * (0.5 * side);
            ray(origin.as_vec3(), random.cube().as_vec3())
        });
        let scattered = scattered.collect();
        let eye = DVec3::new(0.4, 0.7, 1.5) * side;
        let across = count.isqrt().max(1);
        let from_eye = (0..across * across).map(|i| {
            let at = |n: usize| ((n as f64 + 0.5) / across as f64 - 0.5) * side;
            let target = DVec3::new(at(i % across), -at(i / across), 0.0);
            ray(eye.as_vec3(), (target - eye).as_vec3())
        });
        [
            ("random_rays", scattered),
            ("camera_rays", from_eye.collect()),
        ]
    }

    /// Finds the nearest hit of every ray. Leaves of `nodes` name rows, or places in `prims`, which names rows.
    pub fn trace(&self, nodes: &[Node4], prims: Option<&[u32]>, rays: &[Ray]) -> Traced {
        let mut walker = Walker::default();
        let mut nearest = Vec::with_capacity(rays.len());
        let start = Instant::now();
        for ray in rays {
            let mut best = (f32::INFINITY, u32::MAX);
            walker.walk(
                nodes,
                Bounds::Boxes,
                ray,
                ray.t_max,
                |first, count, reach| {
                    for place in first..first + count {
                        let row = prims.map_or(place, |prims| prims[place as usize]);
                        if let Some(t) = self.meet(row, ray)
                            && (t, row) < best
                        {
                            best = (t, row);
                        }
                    }
                    best.0.min(reach)
                },
            );
            nearest.push(best);
        }
        Traced {
            nearest,
            secs: start.elapsed().as_secs_f64(),
        }
    }

    /// Distance of the nearest hit of a row ahead of the ray's origin.
    #[inline]
    fn meet(&self, row: u32, ray: &Ray) -> Option<f32> {
        match self.things[row as usize] {
            Thing::Sphere(sphere) => {
                let roots = sphere.intersect(ray.origin, ray.dir, false)?;
                [roots.near, roots.far].into_iter().find(|&t| t > 0.0)
            }
            Thing::Mesh {
                mesh,
                local_from_world,
            } => {
                let origin = local_from_world.transform_point3(ray.origin);
                let dir = local_from_world.transform_vector3(ray.dir);
                let shear = Shear::new(dir);
                let hits = self.meshes[mesh as usize].iter();
                let hits = hits.filter_map(|&corners| shear.intersect(origin, corners));
                hits.map(|hit| hit.t).filter(|&t| t > 0.0).reduce(f32::min)
            }
        }
    }
}
