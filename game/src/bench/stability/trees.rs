//! Trees against brute force: the same rays through every structure and through none must give the same hits, bit
//! for bit, and a crowd of instances what the nearest of each alone gives.
//!
//! Meshes have coordinates on a coarse grid, so that boxes are flat, touch and coincide; half of the rays run
//! along axes and diagonals with zeros of either sign and start on planes of boxes, the others aim at corners and
//! edges or anywhere.

use glam::{DAffine3, DQuat, DVec3, Vec3};
use orrery_engine::frame::{BoxTest, FrameScene, Instance, Kernels, Offset, Shape, TriangleTest};
use orrery_engine::trace::{Backend, Hit, Query, Ray};
use orrery_engine::world::{Cone, MeshData, MeshRow, Structure};

use super::course::{Course, ready, scene_of};
use super::draw::Draw;
use super::tally::{Tally, Verdict};
use crate::failure::Failure;
use crate::output::progress;

/// The suite.
pub const NAME: &str = "trees";
/// Rays a structure.
const RAYS: u64 = 800_000;
/// Rays of a scene.
const BATCH: u64 = 1 << 16;
/// Most triangles of a mesh.
const TRIANGLES: usize = 500;
/// 1 + 8 ulp: by less, two t are of one place.
const COINCIDING: f64 = 1.0 + 8.0 * f32::EPSILON as f64;
/// Things in a crowd.
const CROWD: usize = 12;

const STRUCTURES: [(&str, Structure); 3] = [
    ("boxes4", Structure::Boxes4),
    ("boxes2", Structure::Boxes2),
    ("spheres", Structure::Spheres { leaf: 4 }),
];

const BARE: Kernels = Kernels {
    boxes: BoxTest::Bare,
    triangles: TriangleTest::Watertight,
    offsets: Offset::Bounded,
};

/// Runs every structure, then crowds.
pub fn run(course: &mut Course) -> Result<(), Failure> {
    let rays = course.rays(RAYS);
    let mut right = [const { Vec::new() }; STRUCTURES.len()];
    let mut bare = Tally::default();
    let mut crowd = Tally::default();
    let mut bare_crowd = Tally::default();
    let step = BATCH.min(rays);
    let bar = progress(rays, NAME);
    for batch in 0..rays.div_ceil(step) {
        let mut scene = soup(batch)?;
        let rays = rays_at(&scene, batch, step);
        let brute = answers(course, &scene, Kernels::default(), &rays)?;
        for (tallies, (_, structure)) in right.iter_mut().zip(STRUCTURES) {
            with_structure(&mut scene, structure);
            let found = answers(course, &scene, Kernels::default(), &rays)?;
            tallies.push(compare(&found, &brute));
            if batch == 0 && structure == Structure::Boxes4 {
                bare = compare(&answers(course, &scene, BARE, &rays)?, &brute);
            }
        }
        // Each alone costs as many passes as there are things: every eighth batch.
        if batch % 8 == 0 {
            let scene = crowd_of(batch)?;
            let rays = rays_at(&scene, batch + 1_000_000, step);
            let alone = each_alone(course, &scene, &rays)?;
            let found = answers(course, &scene, Kernels::default(), &rays)?;
            crowd = crowd.with(compare_crowd(&found, &alone));
            if batch == 0 {
                bare_crowd = compare_crowd(&answers(course, &scene, BARE, &rays)?, &alone);
            }
        }
        bar.set_position((batch + 1) * step);
    }
    bar.finish_and_clear();
    let known = (course.tracer.backend() == Backend::Gpu).then_some(299_054.0);
    course.must_fail(&format!("{NAME}.boxes4.bare"), &bare, known);
    course.must_fail(&format!("{NAME}.crowd.bare"), &bare_crowd, None);
    for (tallies, (word, _)) in right.into_iter().zip(STRUCTURES) {
        let all = tallies.into_iter().fold(Tally::default(), Tally::with);
        course.none_may_fail(&format!("{NAME}.{word}"), &all);
    }
    course.none_may_fail(&format!("{NAME}.crowd"), &crowd);
    Ok(())
}

/// Up to [`TRIANGLES`] triangles on a grid, without a structure.
fn soup(batch: u64) -> Result<FrameScene, Failure> {
    let mut draw = Draw::of(101, batch);
    let mesh = grid_mesh(&mut draw).map_err(Failure::Input)?;
    let mut scene = scene_of([(Shape::Mesh(0), DAffine3::IDENTITY)]);
    scene.meshes = vec![mesh.into()].into();
    with_structure(&mut scene, Structure::None);
    Ok(scene)
}

fn with_structure(scene: &mut FrameScene, structure: Structure) {
    let row = MeshRow {
        structure,
        ..scene.meshes[0].clone()
    };
    scene.meshes.replace(0, row);
    *scene = ready(std::mem::take(scene));
    // Kernels compiled for other features may round otherwise: all structures are traced by the same.
    scene.features.sphere_trees = true;
}

/// A soup whose vertices are eighths in [-1, 1]^3; a quarter of the triangles lie flat in a plane of the grid.
fn grid_mesh(draw: &mut Draw) -> Result<MeshData, String> {
    let count = 1 + draw.below(TRIANGLES);
    // Both ends of the range, so that the mesh's middle is its origin.
    let mut vertices = vec![DVec3::NEG_ONE, DVec3::ONE];
    let mut triangles = Vec::new();
    for _ in 0..count {
        let middle = draw.cube();
        let flat = draw.below(8);
        let first = vertices.len() as u32;
        for _ in 0..3 {
            let mut corner = middle + draw.cube() * 0.4;
            if flat < 3 {
                corner[flat] = middle[flat];
            }
            vertices.push(
                (corner * 8.0)
                    .round()
                    .clamp(DVec3::splat(-8.0), DVec3::splat(8.0))
                    / 8.0,
            );
        }
        triangles.push([first, first + 1, first + 2]);
    }
    MeshData::new("soup", vertices, Vec::new(), triangles)
}

/// Things of every shape that has a box, on a grid, some of them turned.
fn crowd_of(batch: u64) -> Result<FrameScene, Failure> {
    let mut draw = Draw::of(202, batch);
    let mesh = grid_mesh(&mut draw).map_err(Failure::Input)?;
    let mut shapes = Vec::new();
    for i in 0..CROWD {
        let half = DVec3::splat(0.5);
        let shape = match i % 10 {
            1 => Shape::Sphere { radius: 0.5 },
            3 => Shape::Cuboid {
                min: -half,
                max: half,
            },
            5 => Shape::Disc {
                center: DVec3::ZERO,
                normal: DVec3::Y,
                radius: 0.5,
            },
            7 => Shape::Cone(Cone {
                a: half * DVec3::NEG_Y,
                radius_a: 0.5,
                b: half * DVec3::Y,
                radius_b: 0.25,
                open: false,
            }),
            9 => Shape::Torus {
                major: 0.5,
                minor: 0.25,
            },
            _ => Shape::Mesh(0),
        };
        let turn = match draw.below(3) {
            0 => DQuat::from_axis_angle(draw.direction(), draw.range(0.0, 6.0)),
            _ => DQuat::IDENTITY,
        };
        let at = (draw.cube() * 16.0).round() / 8.0;
        let scale = DVec3::splat([0.5, 0.25, 1.0][draw.below(3)]);
        shapes.push((
            shape,
            DAffine3::from_scale_rotation_translation(scale, turn, at),
        ));
    }
    let mut scene = scene_of(shapes);
    scene.meshes = vec![mesh.into()].into();
    Ok(ready(scene))
}

/// Rays that find what is weak about boxes.
fn rays_at(scene: &FrameScene, batch: u64, count: u64) -> Vec<Ray> {
    let mesh = &scene.meshes[0].data;
    let corner = |draw: &mut Draw| mesh.positions[draw.below(mesh.positions.len())];
    let ray = |index: u64| {
        let mut draw = Draw::of(303 + batch, index);
        let target = corner(&mut draw);
        let (origin, dir) = match draw.below(4) {
            // Along an axis or a diagonal, through a corner, from a plane of the grid.
            0 | 1 => {
                let mut step = Vec3::ZERO;
                while step == Vec3::ZERO {
                    step = Vec3::from([0; 3].map(|_| [-1.0, -0.0, 0.0, 1.0][draw.below(4)]));
                }
                let back = [0.5, 1.0, 2.0, 4.0][draw.below(4)];
                (target - step * back, step)
            }
            // At corners and at edges between two of them.
            2 => {
                let origin = (draw.cube() * 2.5).as_vec3();
                let weight = [0.0, draw.unit() as f32][draw.below(2)];
                let point = target * (1.0 - weight) + corner(&mut draw) * weight;
                (origin, point - origin)
            }
            _ => ((draw.cube() * 2.5).as_vec3(), draw.direction_f32()),
        };
        Ray {
            origin,
            dir,
            t_min: 0.0,
            t_max: f32::MAX,
        }
    };
    (0..count).map(ray).collect()
}

fn answers(
    course: &mut Course,
    scene: &FrameScene,
    kernels: Kernels,
    rays: &[Ray],
) -> Result<Vec<Hit>, Failure> {
    course.upload(scene, kernels)?;
    Ok(course.tracer.intersect(rays, Query::Closest)?)
}

/// The hits of each instance without the others, instance by instance.
fn each_alone(
    course: &mut Course,
    scene: &FrameScene,
    rays: &[Ray],
) -> Result<Vec<Vec<Hit>>, Failure> {
    (0..scene.instances.len())
        .map(|row| answers(course, &alone(scene, row), Kernels::default(), rays))
        .collect()
}

/// One instance of a scene, in its row. It keeps the features of all: with its own alone, a device would be given
/// another kernel, which may round otherwise.
fn alone(scene: &FrameScene, row: usize) -> FrameScene {
    let mut alone = scene.clone();
    for other in (0..scene.instances.len()).filter(|&other| other != row) {
        let vacant = Instance {
            shape: Shape::Vacant,
            ..scene.instances[other]
        };
        alone.instances.set(other as u32, vacant);
    }
    alone
}

/// A crowd's hit is that of its instance alone, bit for bit, and no instance is nearer. A device chooses by t as it
/// finds it and answers with t refined, so that of surfaces that coincide (in a crowd on a grid, many) the one whose
/// refined t is greater by a rounding may be met.
fn compare_crowd(found: &[Hit], alone: &[Vec<Hit>]) -> Tally {
    let mut tally = Tally::default();
    for (ray, found) in found.iter().enumerate() {
        let met = || {
            alone
                .iter()
                .map(|hits| hits[ray])
                .filter(|&hit| hit != Hit::MISS)
        };
        let nearest = met().map(|hit| hit.t).fold(f64::INFINITY, f64::min);
        let is_own = match alone.get(found.instance as usize) {
            Some(hits) => hits[ray] == *found && found.t <= nearest * COINCIDING,
            None => *found == Hit::MISS && met().next().is_none(),
        };
        tally.take(Verdict::of(is_own));
    }
    tally
}

fn compare(found: &[Hit], expected: &[Hit]) -> Tally {
    let mut tally = Tally::default();
    for (found, expected) in found.iter().zip(expected) {
        tally.take(Verdict::of(found == expected));
    }
    tally
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_compared_is_traced_by_the_same_kernels() {
        let crowd = crowd_of(0).unwrap();
        for row in 0..CROWD {
            let one = alone(&crowd, row);
            assert_eq!(one.features, crowd.features);
            let filled = one.instances.iter().map(|i| i.shape != Shape::Vacant);
            let expected = (0..CROWD).map(|i| i == row);
            assert!(filled.eq(expected), "{row}");
        }
        let mut soup = soup(0).unwrap();
        let bare = soup.features;
        for (word, structure) in STRUCTURES {
            with_structure(&mut soup, structure);
            assert_eq!(soup.features, bare, "{word}");
        }
    }
}
