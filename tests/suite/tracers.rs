//! The tracers against each other and against brute force, on random worlds.

use glam::{DAffine3, DVec3, UVec2, Vec3};
use orrery_engine::frame::{FrameScene, Instance, Light, LightKind, Shape, TraceSettings};
use orrery_engine::trace::cpu::CpuTracer;
use orrery_engine::trace::reference::ReferenceTracer;
use orrery_engine::trace::{Hit, Picture, Query, Ray, Tracer};
use orrery_engine::world::MeshData;
use orrery_tests::metrics::compare_pictures;
use orrery_tests::random_scene::{Random, icosphere, random_scene};

fn ready(mut tracer: impl Tracer, scene: &FrameScene, size: UVec2) -> impl Tracer {
    let settings = TraceSettings {
        size,
        ..Default::default()
    };
    tracer.refit(scene).expect("refits");
    tracer.upload(scene, &settings).expect("uploads");
    tracer
}

fn picture(tracer: impl Tracer, scene: &FrameScene, size: UVec2) -> Picture {
    let mut tracer = ready(tracer, scene, size);
    tracer.render().expect("renders");
    tracer.picture().expect("has a picture")
}

fn rays(random: &mut Random, count: usize) -> Vec<Ray> {
    (0..count)
        .map(|_| Ray {
            origin: (random.cube() * 4.0 - DVec3::new(0.0, 1.0, 9.0)).as_vec3(),
            dir: (random.direction() * random.range(0.1, 3.0)).as_vec3(),
            t_min: 0.0,
            t_max: f32::MAX,
        })
        .collect()
}

fn id(hit: &Hit) -> (u32, u32) {
    (hit.instance, hit.prim)
}

#[test]
fn cpu_and_reference_find_the_same_hits() {
    let (mut tried, mut differ, mut worst) = (0, 0, 0.0_f64);
    for seed in 0..20 {
        let scene = random_scene(seed, 60);
        let rays = rays(&mut Random::new(seed + 100), 20_000);
        let mut cpu = ready(CpuTracer::new(), &scene, UVec2::ONE);
        let mut reference = ready(ReferenceTracer::new(), &scene, UVec2::ONE);
        let fast = cpu.intersect(&rays, Query::Closest).unwrap();
        let exact = reference.intersect(&rays, Query::Closest).unwrap();
        for (a, b) in fast.iter().zip(&exact) {
            tried += 1;
            if id(a) != id(b) {
                differ += 1;
            } else if b.t.is_finite() && b.t > 0.01 {
                worst = worst.max((a.t - b.t).abs() / b.t);
            }
        }
        let any = cpu.intersect(&rays, Query::Any).unwrap();
        for (closest, any) in fast.iter().zip(&any) {
            assert_eq!(
                any.instance == 1,
                closest.instance != u32::MAX,
                "any and closest disagree"
            );
        }
    }
    let ppm = f64::from(differ) * 1e6 / f64::from(tried);
    assert!(
        ppm < 40.0,
        "{differ} of {tried} rays hit something else ({ppm} ppm)"
    );
    assert!(worst < 1e-2, "t is off by {worst} of itself");
}

/// A scene in which each triangle of one mesh is an instance of its own, in the mesh's frame.
fn one_triangle_each(mesh: &MeshData) -> Vec<FrameScene> {
    (0..mesh.triangles.len())
        .map(|i| {
            let mut alone = mesh.clone();
            alone.triangles = vec![mesh.triangles[i]];
            single(alone)
        })
        .collect()
}

fn single(mesh: MeshData) -> FrameScene {
    FrameScene {
        materials: vec![Default::default()].into(),
        meshes: vec![mesh.into()].into(),
        instances: vec![Instance {
            tag: 0,
            shape: Shape::Mesh(0),
            world_from_local: DAffine3::from_rotation_y(0.3),
            material: 0,
        }]
        .into(),
        ..Default::default()
    }
}

#[test]
fn a_tree_answers_as_brute_force_does() {
    let mesh = icosphere(1);
    let rays: Vec<Ray> = {
        let mut random = Random::new(5);
        let aim = |r: &mut Random| r.cube() * 1.5;
        (0..20_000)
            .map(|_| {
                let origin = aim(&mut random) * 2.0;
                Ray {
                    origin: origin.as_vec3(),
                    dir: (aim(&mut random) - origin).as_vec3(),
                    t_min: 0.0,
                    t_max: f32::MAX,
                }
            })
            .collect()
    };
    let mut brute = vec![Hit::MISS; rays.len()];
    for (prim, scene) in one_triangle_each(&mesh).iter().enumerate() {
        let mut tracer = ready(CpuTracer::new(), scene, UVec2::ONE);
        for (best, hit) in brute
            .iter_mut()
            .zip(tracer.intersect(&rays, Query::Closest).unwrap())
        {
            if hit.t < best.t {
                *best = Hit {
                    prim: prim as u32,
                    ..hit
                };
            }
        }
    }
    let fast = ready(CpuTracer::new(), &single(mesh), UVec2::ONE)
        .intersect(&rays, Query::Closest)
        .unwrap();
    for ((ray, a), b) in rays.iter().zip(&fast).zip(&brute) {
        assert_eq!(
            (id(a), a.t),
            (id(b), b.t),
            "tree and brute force disagree on {ray:?}"
        );
    }
}

#[test]
fn a_closed_mesh_does_not_leak() {
    let mesh = icosphere(3);
    let mut random = Random::new(9);
    let mut rays = Vec::new();
    for k in 0..600_000 {
        let triangle = mesh.triangles[random.below(mesh.triangles.len())];
        let [a, b, _] = triangle.map(|i| mesh.vertices[i as usize]);
        let weight = if k % 2 == 0 { random.unit() } else { 1.0 };
        let target = (a * weight + b * (1.0 - weight)).as_vec3();
        let origin = (random.cube() * 0.5).as_vec3();
        rays.push(Ray {
            origin,
            dir: target - origin,
            t_min: 0.0,
            t_max: f32::MAX,
        });
    }
    let mut scene = single(mesh);
    scene
        .instances
        .edit(|instance| instance.world_from_local = DAffine3::IDENTITY);
    let hits = ready(CpuTracer::new(), &scene, UVec2::ONE)
        .intersect(&rays, Query::Closest)
        .unwrap();
    let leaks = hits.iter().filter(|hit| hit.instance == u32::MAX).count();
    assert_eq!(
        leaks,
        0,
        "{leaks} of {} edge- and vertex-aimed rays got out",
        rays.len()
    );
}

#[test]
fn cpu_pictures_match_the_reference() {
    let size = UVec2::new(160, 120);
    let (mut wrong, mut pixels) = (0.0, 0.0);
    for seed in 0..12 {
        let scene = random_scene(seed, 40);
        let fast = picture(CpuTracer::new(), &scene, size);
        let exact = picture(ReferenceTracer::new(), &scene, size);
        let metrics = compare_pictures(&fast, &exact);
        assert_eq!(metrics.non_finite, 0, "seed {seed}");
        let count = f64::from(size.element_product());
        wrong += metrics.mismatch_ppm * count;
        pixels += count;
    }
    let ppm = wrong / pixels;
    assert!(
        ppm < 500.0,
        "{ppm} ppm of the pixels are off by more than 1/255"
    );
}

#[test]
fn slivers_do_not_shadow_themselves() {
    let spokes = 20_000_u32;
    let rim = (0..spokes).map(|i| {
        let angle = f64::from(i) / f64::from(spokes) * std::f64::consts::TAU;
        DVec3::new(angle.cos(), angle.sin(), 0.0)
    });
    let vertices = std::iter::once(DVec3::ZERO).chain(rim).collect();
    let triangles = (0..spokes)
        .map(|i| [0, 1 + i, 1 + (i + 1) % spokes])
        .collect();
    let fan = MeshData::new("fan", vertices, Vec::new(), triangles).expect("a fan is a mesh");
    let mut scene = single(fan);
    let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -0.7, 0.2);
    let pose = DAffine3::from_rotation_translation(turn, DVec3::new(0.1, 0.2, -3.0));
    scene
        .instances
        .edit(|instance| instance.world_from_local = pose);
    scene.lights.push(Light {
        color: Vec3::ONE,
        fade: None,
        kind: LightKind::Point {
            position: DVec3::new(-2.0, 1.0, 1.0),
        },
    });
    scene.max_generations = 1;
    let size = UVec2::new(256, 192);
    let fast = picture(CpuTracer::new(), &scene, size);
    let exact = picture(ReferenceTracer::new(), &scene, size);
    let lit = exact
        .pixels
        .iter()
        .filter(|p| p.max_element() > 0.1)
        .count();
    assert!(lit > 5_000, "only {lit} pixels are lit");
    let dark = fast.pixels.iter().zip(&exact.pixels);
    let dark = dark
        .filter(|(a, b)| a.max_element() < 0.5 * b.max_element())
        .count();
    assert_eq!(
        dark, 0,
        "{dark} of {lit} lit pixels lie in their own shadow"
    );
}
