//! How exact the f32 tracers are: distances in ulps of the reference's, rays along the planes of boxes, things in
//! one place.

use glam::{DAffine3, DMat3, DQuat, DVec3, UVec2, Vec3};
use orrery_engine::frame::{Features, FrameScene, Instance, Shape, TraceSettings};
use orrery_engine::trace::cpu::CpuTracer;
use orrery_engine::trace::reference::ReferenceTracer;
use orrery_engine::trace::{Hit, Query, Ray, Tracer};
use orrery_engine::world::{Material, MeshData};
use orrery_tests::random_scene::{Random, icosphere};

use crate::gpu;

pub const BOX: Shape = Shape::Cuboid {
    min: DVec3::NEG_ONE,
    max: DVec3::ONE,
};

pub fn scene_of(shapes: &[(Shape, DAffine3)], meshes: Vec<MeshData>) -> FrameScene {
    let instance = |&(shape, world_from_local): &(Shape, DAffine3)| Instance {
        tag: 0,
        shape,
        world_from_local,
        material: 0,
    };
    let meshes: Vec<_> = meshes.into_iter().map(Into::into).collect();
    let instances: Vec<_> = shapes.iter().map(instance).collect();
    let mut scene = FrameScene {
        materials: vec![Material::default()].into(),
        meshes: meshes.into(),
        instances: instances.into(),
        ..Default::default()
    };
    scene.features = Features::of(&scene);
    scene
}

pub fn settings(size: UVec2) -> TraceSettings {
    TraceSettings {
        size,
        ..Default::default()
    }
}

fn hits(tracer: &mut dyn Tracer, scene: &FrameScene, rays: &[Ray]) -> Vec<Hit> {
    tracer.refit(scene).expect("refits");
    tracer
        .upload(scene, &settings(UVec2::ONE))
        .expect("uploads");
    tracer.intersect(rays, Query::Closest).expect("answers")
}

pub fn ray(origin: Vec3, dir: Vec3) -> Ray {
    Ray {
        origin,
        dir,
        t_min: 0.0,
        t_max: f32::MAX,
    }
}

/// Errors in t in ulps, and rays that hit something else.
#[derive(Default)]
struct Errors {
    ulps: Vec<f64>,
    other: u32,
}

impl Errors {
    fn add(&mut self, tracer: &mut dyn Tracer, scene: &FrameScene, rays: &[Ray]) {
        let fast = hits(tracer, scene, rays);
        let exact = hits(&mut ReferenceTracer::new(), scene, rays);
        for (a, b) in fast.iter().zip(&exact) {
            if (a.instance, a.prim) != (b.instance, b.prim) {
                self.other += 1;
            } else if b.t.is_finite() {
                let size = b.t as f32;
                let ulp = f64::from(size.next_up() - size);
                self.ulps.push((a.t - b.t).abs() / ulp);
            }
        }
        assert!(self.ulps.len() * 10 > rays.len(), "hardly a ray hits");
    }

    /// Median, 99th and 99.9th percentile.
    fn quantiles(&mut self) -> [f64; 3] {
        self.ulps.sort_by(f64::total_cmp);
        let last = (self.ulps.len() - 1) as f64;
        [0.5, 0.99, 0.999].map(|share| self.ulps[(last * share) as usize])
    }
}

/// Every corner is a number of f32, so that all tracers see the same triangles.
fn rounded(mut mesh: MeshData) -> MeshData {
    for vertex in &mut mesh.vertices {
        *vertex = vertex.as_vec3().as_dvec3();
    }
    mesh
}

/// Triangles that are no needles, all about the origin.
fn loose_triangles(random: &mut Random, count: usize) -> MeshData {
    let mut vertices = Vec::new();
    while vertices.len() < 3 * count {
        let at = random.cube() * 3.0;
        let [a, b, c] = [(); 3].map(|()| at + random.cube() * 0.5);
        let longest = [a - b, b - c, c - a].map(DVec3::length_squared);
        let longest = longest.into_iter().fold(0.0, f64::max);
        if (b - a).cross(c - a).length() > 0.2 * longest {
            vertices.extend([a, b, c]);
        }
    }
    let triangles = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    let mesh = MeshData::new("loose", vertices, Vec::new(), triangles.collect());
    rounded(mesh.expect("triangles are a mesh"))
}

fn toward(random: &mut Random, count: usize, from: f64, spread: f64) -> Vec<Ray> {
    let one = |_| {
        let origin = random.direction() * random.range(0.5 * from, from);
        let dir = (random.cube() * spread - origin).normalize() * random.range(0.5, 2.0);
        ray(origin.as_vec3(), dir.as_vec3())
    };
    (0..count).map(one).collect()
}

#[test]
fn distances_to_triangles_are_exact() {
    let mut random = Random::new(1);
    let mesh = loose_triangles(&mut random, 300);
    for mesh in [mesh, rounded(icosphere(3))] {
        let scene = scene_of(&[(Shape::Mesh(0), DAffine3::IDENTITY)], vec![mesh]);
        let rays = toward(&mut random, 100_000, 8.0, 1.5);
        let mut errors = Errors::default();
        errors.add(&mut CpuTracer::new(), &scene, &rays);
        let [p50, p99, p999] = errors.quantiles();
        // Weighted by the edges' values alone: 0.6, 2.6 and 5.8 ulps.
        assert!(
            p50 <= 0.5 && p99 <= 2.5 && p999 <= 5.0 && errors.other == 0,
            "cpu: {p50} {p99} {p999} ulps, {} hit another",
            errors.other
        );
        let mut errors = Errors::default();
        errors.add(&mut gpu::tracer(), &scene, &rays[..20_000]);
        let [p50, p99, p999] = errors.quantiles();
        assert!(
            p50 <= 1.5 && p99 <= 5.0 && p999 <= 10.0,
            "gpu: {p50} {p99} {p999} ulps"
        );
    }
}

#[test]
fn distances_to_solids_are_exact() {
    let mut random = Random::new(2);
    let plane = Shape::Plane {
        normal: DVec3::new(0.3, 1.0, -0.2),
        distance: -1.0,
    };
    for (name, shape, scale) in [
        ("sphere", Shape::Sphere { radius: 0.8 }, DVec3::ONE),
        (
            "ellipsoid",
            Shape::Sphere { radius: 1.0 },
            DVec3::new(0.5, 1.0, 2.0),
        ),
        ("box", BOX, DVec3::new(1.0, 0.7, 0.4)),
        ("plane", plane, DVec3::ONE),
    ] {
        let mut errors = Errors::default();
        for _ in 0..20 {
            let turn = DQuat::from_axis_angle(random.direction(), random.range(0.0, 6.0));
            let place = random.cube() * 0.5;
            let pose = DAffine3::from_scale_rotation_translation(scale, turn, place);
            let scene = scene_of(&[(shape, pose)], Vec::new());
            let rays = toward(&mut random, 10_000, 6.0, 0.7);
            errors.add(&mut CpuTracer::new(), &scene, &rays);
        }
        let [p50, p99, p999] = errors.quantiles();
        let other = errors.other;
        assert!(
            p50 <= 1.0 && p99 <= 4.0 && other <= 4,
            "{name}: {p50} {p99} {p999} ulps, {other} hit another"
        );
    }
}

/// A box whose sides are squares of two triangles each, so that neighbours lie in one plane.
pub fn grid_box(cells: u32) -> MeshData {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    let n = cells + 1;
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let first = vertices.len() as u32;
            let at = |i: u32| f64::from(i) * 2.0 / f64::from(cells) - 1.0;
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let mut v = [at(i), at(j), 0.0];
                v[2] = side;
                v.rotate_right(axis);
                vertices.push(DVec3::from(v));
            }
            for (i, j) in (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j))) {
                let a = first + i * n + j;
                triangles.extend([[a, a + 1, a + n], [a + 1, a + n + 1, a + n]]);
            }
        }
    }
    MeshData::new("grid", vertices, Vec::new(), triangles).expect("a box is a mesh")
}

#[test]
fn rays_in_the_planes_of_boxes_are_answered_as_by_brute_force() {
    let mut random = Random::new(11);
    let near_zero = [0.0_f32, -0.0, 1e-38, -1e-30, 1e-20, 1.0, -1.0];
    let cells: Vec<_> = (0..27)
        .map(|i| DVec3::new((i % 3) as f64, (i / 3 % 3) as f64, (i / 9) as f64) * 2.0)
        .collect();
    let shapes: Vec<_> = cells
        .iter()
        .enumerate()
        .map(|(i, &at)| {
            let shape = if i % 2 == 0 { BOX } else { Shape::Mesh(0) };
            (shape, DAffine3::from_translation(at))
        })
        .collect();
    let mesh = grid_box(1);
    let mut rays = Vec::new();
    while rays.len() < 30_000 {
        let dir = Vec3::from([(); 3].map(|()| near_zero[random.below(near_zero.len())]));
        // On planes of boxes, and a little beside some.
        let origin = [(); 3].map(|()| random.below(9) as f32 - 2.0);
        if dir.abs().max_element() == 1.0 {
            rays.push(ray(Vec3::from(origin), dir));
        }
    }
    let mut brute = vec![Hit::MISS; rays.len()];
    for (row, &shape) in shapes.iter().enumerate() {
        let alone = scene_of(&[shape], vec![mesh.clone()]);
        let found = hits(&mut CpuTracer::new(), &alone, &rays);
        for (best, hit) in brute.iter_mut().zip(found) {
            if hit.t < best.t {
                *best = Hit {
                    instance: row as u32,
                    ..hit
                };
            }
        }
    }
    let scene = scene_of(&shapes, vec![mesh]);
    let cpu = hits(&mut CpuTracer::new(), &scene, &rays);
    for ((ray, a), b) in rays.iter().zip(&cpu).zip(&brute) {
        assert_eq!(
            (a.instance, a.prim, a.t),
            (b.instance, b.prim, b.t),
            "{ray:?}"
        );
    }
}

#[test]
fn of_things_in_one_place_the_first_is_hit_however_they_move() {
    let mut random = Random::new(13);
    let shapes = [Shape::Sphere { radius: 1.0 }, BOX, Shape::Mesh(0)];
    let mut pose = DAffine3::IDENTITY;
    let rays = toward(&mut random, 300, 5.0, 1.0);
    let mut tracer = CpuTracer::new();
    for frame in 0..600 {
        let turn = DQuat::from_axis_angle(random.direction(), 0.1);
        pose = DAffine3::from_rotation_translation(turn, random.cube() * 0.1) * pose;
        pose.matrix3 = DMat3::from_quat(DQuat::from_mat3(&pose.matrix3).normalize());
        pose.translation *= 0.9;
        let shape = shapes[frame % shapes.len()];
        let scene = scene_of(&[(shape, pose); 3], vec![icosphere(2)]);
        for hit in hits(&mut tracer, &scene, &rays) {
            assert!(
                hit.instance == 0 || hit.instance == u32::MAX,
                "frame {frame}: {hit:?}"
            );
        }
    }
}
