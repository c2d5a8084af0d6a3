//! Leaks: rays from inside a closed mesh that get out.
//!
//! Rays aim anywhere, at points of edges as f32 has them, and at vertices. At 1.5e5 in two ways that keep what
//! the engine does about large coordinates (it centres meshes, and subtracts the eye in f64) from hiding the
//! kernel: vertices that are that large, and rounded, in the mesh's own space; and rays that start that far from
//! the eye, at a mesh that is placed there.

use glam::{DAffine3, Vec3};
use orrery_engine::frame::{FrameScene, Kernels, Shape, TriangleTest};
use orrery_engine::trace::{Backend, Hit, Query, Ray};

use super::course::{Course, ready, scene_of};
use super::draw::Draw;
use super::solids::Solid;
use super::stream::Stream;
use super::tally::{Tally, Verdict};
use crate::failure::Failure;

/// The suite.
pub const NAME: &str = "leaks";
/// Rays of each aim, in all solids and places together.
const RAYS: u64 = 1_800_000;
/// Rays of a form that must fail.
const BROKEN: u64 = 100_000;
/// Where far meshes are: each coordinate is a multiple of 1/64, the spacing of f32 there.
const FAR: Vec3 = Vec3::new(150_000.0, -120_000.0, 90_000.0);

/// What rays aim at.
#[derive(Clone, Copy, PartialEq)]
enum Aim {
    Anywhere,
    Edges,
    Vertices,
}

/// Where the mesh is.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    /// At the eye.
    Near,
    /// At 1.5e5 in its own space.
    InMesh,
    /// At 1.5e5 in the world.
    InWorld,
}

const AIMS: [(&str, Aim); 3] = [
    ("anywhere", Aim::Anywhere),
    ("edges", Aim::Edges),
    ("vertices", Aim::Vertices),
];
const PLACES: [(&str, Place); 3] = [
    ("near", Place::Near),
    ("far_vertices", Place::InMesh),
    ("far_rays", Place::InWorld),
];

/// A mesh around an eye.
struct Room {
    scene: FrameScene,
    /// Of the solid, in the mesh's space.
    corners: Vec<[Vec3; 3]>,
    /// The middle, and how far around it rays start, in that space.
    middle: Vec3,
    core: f64,
    /// From that space to where rays are asked.
    moved: Vec3,
}

/// Runs every solid, place and aim.
pub fn run(course: &mut Course) -> Result<(), Failure> {
    let rays = course.rays(RAYS) as f64 / PLACES.len() as f64;
    let broken = course.brief(BROKEN);
    let leaky = Kernels {
        triangles: TriangleTest::MollerTrumbore,
        ..Kernels::default()
    };
    for solid in Solid::all() {
        let rays = (rays * solid.share).ceil() as u64;
        for (place_word, place) in PLACES {
            let room = Room::new(&solid, place).map_err(Failure::Input)?;
            for (aim_word, aim) in AIMS {
                let name = format!("{NAME}.{}.{place_word}.{aim_word}", solid.name);
                if aim != Aim::Anywhere {
                    course.upload(&room.scene, leaky)?;
                    let tally = room.shoot(course, &name, aim, broken)?;
                    let known = known_ppm(course, solid.name, place, aim);
                    course.must_fail(&format!("{name}.moller_trumbore"), &tally, known);
                }
                course.upload(&room.scene, Kernels::default())?;
                let tally = room.shoot(course, &name, aim, rays)?;
                course.none_may_fail(&name, &tally);
            }
        }
    }
    Ok(())
}

impl Room {
    fn new(solid: &Solid, place: Place) -> Result<Self, String> {
        let (mesh, middle, scale) = match place {
            Place::InMesh => {
                let mesh = solid.mesh_at(FAR, solid.far_scale)?;
                (mesh, FAR, solid.far_scale)
            }
            Place::Near | Place::InWorld => (solid.mesh()?, Vec3::ZERO, 1.0),
        };
        let corner = |v: u32| mesh.positions[v as usize];
        let corners = solid.triangles.iter().map(|t| t.map(corner)).collect();
        let moved = match place {
            Place::InWorld => FAR,
            Place::Near | Place::InMesh => Vec3::ZERO,
        };
        let at = DAffine3::from_translation(moved.as_dvec3());
        let mut scene = scene_of([(Shape::Mesh(0), at)]);
        scene.meshes = vec![mesh.into()].into();
        Ok(Self {
            scene: ready(scene),
            corners,
            middle,
            core: solid.core * scale * 0.9,
            moved,
        })
    }

    fn shoot(
        &self,
        course: &mut Course,
        name: &str,
        aim: Aim,
        count: u64,
    ) -> Result<Tally, Failure> {
        let stream = Stream {
            label: name,
            count,
            query: Query::Closest,
            make: |index, rays: &mut [Ray]| rays[0] = self.ray(aim, index),
            judge: |_, _: &[Ray], hits: &[Hit]| Verdict::of(hits[0] != Hit::MISS),
        };
        stream.run(course.tracer.as_mut())
    }

    fn ray(&self, aim: Aim, index: u64) -> Ray {
        let mut draw = Draw::of(17 + aim as u64, index);
        let mut origin = self.middle + (draw.ball() * self.core).as_vec3();
        if self.moved != Vec3::ZERO {
            // Only such an origin is the same seen from the eye and from the mesh.
            origin = (origin * 64.0).round() / 64.0;
        }
        let mut corners = self.corners[draw.below(self.corners.len())];
        corners.rotate_left(draw.below(3));
        let [a, b, _] = corners;
        let weight = draw.unit() as f32;
        let dir = match aim {
            Aim::Anywhere => draw.direction_f32(),
            Aim::Edges => a * weight + b * (1.0 - weight) - origin,
            Aim::Vertices => a - origin,
        };
        Ray {
            origin: origin + self.moved,
            dir,
            t_min: 0.0,
            t_max: f32::MAX,
        }
    }
}

/// Möller and Trumbore's test on an icosphere and a fan of the same kind, measured before: on an x86 processor,
/// an NVIDIA H200, and at 1.5e5 there.
///
/// None for edges of meshes whose vertices are far off: the meshes differ, and these leak about a hundredth as often.
fn known_ppm(course: &Course, solid: &str, place: Place, aim: Aim) -> Option<f64> {
    let on_gpu = course.tracer.backend() == Backend::Gpu;
    match (on_gpu, solid, place, aim) {
        (false, "icosphere", Place::Near, Aim::Edges) => Some(103_500.0),
        (true, "icosphere", Place::Near, Aim::Edges) => Some(151_637.0),
        (true, "icosphere", Place::Near, Aim::Vertices) => Some(243_825.0),
        (true, "icosphere", Place::InMesh, Aim::Vertices) => Some(201_073.0),
        (true, "fan", Place::Near, Aim::Edges) => Some(189_794.0),
        (true, "fan", Place::Near, Aim::Vertices) => Some(298_951.0),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn rays_start_inside() {
        for solid in Solid::all() {
            for (word, place) in PLACES {
                let room = Room::new(&solid, place).unwrap();
                for index in 0..200 {
                    let ray = room.ray(Aim::Edges, index);
                    let local = (ray.origin - room.moved - room.middle).as_dvec3();
                    assert!(local.length() <= room.core * 1.1 + 0.02, "{word}: {local}");
                    assert!(ray.dir.as_dvec3() != DVec3::ZERO);
                }
            }
        }
    }
}
