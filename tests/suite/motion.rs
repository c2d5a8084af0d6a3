//! Trees and rows that follow change: no answer depends on the frames before, and nothing is done for nothing.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, UVec2};
use orrery_engine::Engine;
use orrery_engine::frame::{FrameScene, Instance, Shape, TraceSettings};
use orrery_engine::trace::cpu::{CpuTracer, Instructions};
use orrery_engine::trace::{ActiveTracer, Backend, BackendChoice, Counters, Query, Ray, Tracer};
use orrery_engine::trace::{Hit, open_tracer};
use orrery_engine::world::{
    Camera, DeformStep, Deformation, MeshRow, PointLight, Sphere, Structure, Transform,
};
use orrery_tests::random_scene::{Random, random_scene};
use orrery_tests::tracers::picture;

const SIZE: UVec2 = UVec2::new(72, 54);

fn settings() -> TraceSettings {
    TraceSettings {
        size: SIZE,
        ..Default::default()
    }
}

fn rays(random: &mut Random, count: usize) -> Vec<Ray> {
    (0..count)
        .map(|_| Ray {
            origin: (random.cube() * 5.0).as_vec3(),
            dir: random.direction().as_vec3(),
            t_min: 0.0,
            t_max: f32::MAX,
        })
        .collect()
}

fn answers(tracer: &mut CpuTracer, scene: &FrameScene, rays: &[Ray]) -> Vec<Hit> {
    tracer.refit(scene).expect("refits");
    tracer.upload(scene, &settings()).expect("uploads");
    tracer.intersect(rays, Query::Closest).expect("answers")
}

/// A wave through all deforming meshes; phase is the frame.
fn deform(scene: &mut FrameScene, frame: u32) {
    for index in 0..scene.meshes.len() as u32 {
        let step = DeformStep::Wave {
            wave: DVec3::new(3.0, 1.0, 2.0 + f64::from(index)),
            amplitude: DVec3::new(0.3, 0.2, 0.1) * f64::from(frame % 7),
            phase: f64::from(frame) * 0.7,
        };
        let row = MeshRow {
            deformation: Some(Arc::new(Deformation { steps: vec![step] })),
            ..scene.meshes[index as usize].clone()
        };
        scene.meshes.replace(index, row);
    }
}

/// Moves, hides, shows, changes and adds a few things, and the eye.
fn change(scene: &mut FrameScene, random: &mut Random, frame: u32) {
    for _ in 0..random.below(12) {
        let index = random.below(scene.instances.len()) as u32;
        let mut row = scene.instances[index as usize];
        match random.below(5) {
            0 => row.shape = Shape::Vacant,
            1 => row.shape = Shape::Sphere { radius: 0.4 },
            2 => row.shape = Shape::Mesh(random.below(2) as u32),
            3 => row.material = random.below(scene.materials.len()) as u32,
            _ => {
                let turn = DQuat::from_axis_angle(random.direction(), random.range(0.0, 6.0));
                let scale = DVec3::splat(random.range(0.2, 0.8));
                let place = random.cube() * 3.0;
                row.world_from_local =
                    DAffine3::from_scale_rotation_translation(scale, turn, place);
            }
        }
        if random.below(10) == 0 {
            scene.instances.push(row);
        } else {
            scene.instances.set(index, row);
        }
    }
    if frame.is_multiple_of(3) {
        deform(scene, frame);
    }
    // Steps within the anchor's reach, and now and then far beyond it.
    let step = if frame.is_multiple_of(11) { 40.0 } else { 0.5 };
    if frame.is_multiple_of(2) {
        scene.view.origin = DVec3::new(0.0, 1.0, 9.0) + random.cube() * step;
    }
    scene.features = orrery_engine::frame::Features::of(scene);
}

#[test]
fn no_answer_depends_on_the_frames_before() {
    for seed in 0..3 {
        let mut random = Random::new(seed);
        let mut scene = random_scene(seed, 60);
        let mut walked = CpuTracer::new();
        for frame in 0..60 {
            change(&mut scene, &mut random, frame);
            let rays = rays(&mut random, 400);
            let through_history = answers(&mut walked, &scene, &rays);
            let afresh = answers(&mut CpuTracer::new(), &scene.clone(), &rays);
            assert_eq!(through_history, afresh, "seed {seed}, frame {frame}");
        }
        let settings = settings();
        let a = picture(&mut walked, &scene, &settings).expect("a picture");
        let b = picture(&mut CpuTracer::new(), &scene, &settings).expect("a picture");
        assert!(a == b, "seed {seed}: the pictures differ");
    }
}

/// The answers without any tree: every instance alone, every triangle tried.
fn brute_force(scene: &FrameScene, rays: &[Ray]) -> Vec<Hit> {
    let mut alone = scene.clone();
    for index in 0..alone.meshes.len() as u32 {
        let row = MeshRow {
            structure: Structure::None,
            ..alone.meshes[index as usize].clone()
        };
        alone.meshes.replace(index, row);
    }
    let rows = alone.instances.to_vec();
    alone.instances.edit(|row| row.shape = Shape::Vacant);
    let mut tracer = CpuTracer::new();
    let mut best = vec![Hit::MISS; rays.len()];
    for (index, row) in (0..).zip(rows) {
        alone.instances.set(index, row);
        for (best, hit) in best.iter_mut().zip(answers(&mut tracer, &alone, rays)) {
            if hit.t < best.t {
                *best = hit;
            }
        }
        let hidden = Instance {
            shape: Shape::Vacant,
            ..row
        };
        alone.instances.set(index, hidden);
    }
    best
}

/// Random motion and deformation for so many frames; every so many, the trees against brute force.
fn hold_against_brute_force(frames: u32, every: u32, rays_each: usize) {
    let mut random = Random::new(17);
    let mut scene = random_scene(17, 24);
    let all = Instructions::all();
    let mut walked: Vec<CpuTracer> = all.iter().map(|&one| CpuTracer::with(one)).collect();
    for frame in 1..=frames {
        change(&mut scene, &mut random, frame);
        if scene.instances.len() > 40 {
            let fewer = scene.instances[..24].to_vec();
            scene.instances.assign(fewer);
        }
        if !frame.is_multiple_of(every) {
            for walked in &mut walked {
                answers(walked, &scene, &[]);
            }
            continue;
        }
        let rays = rays(&mut random, rays_each);
        let right = brute_force(&scene, &rays);
        for (walked, one) in walked.iter_mut().zip(&all) {
            let found = answers(walked, &scene, &rays);
            assert_eq!(found, right, "frame {frame}, {}", one.name());
        }
    }
}

#[test]
fn trees_that_followed_change_answer_as_brute_force_does() {
    hold_against_brute_force(300, 60, 2_000);
}

/// `cargo test --release --workspace --test suite hundred_thousand -- --ignored`
#[test]
#[ignore = "minutes"]
fn trees_answer_as_brute_force_does_for_a_hundred_thousand_frames() {
    hold_against_brute_force(100_000, 1_000, 10_000);
}

#[test]
fn every_structure_gives_the_same_answers() {
    let scene = random_scene(11, 50);
    let rays = rays(&mut Random::new(4), 20_000);
    let expected = answers(&mut CpuTracer::new(), &scene, &rays);
    let hits = expected.iter().filter(|hit| hit.instance != u32::MAX);
    assert!(hits.count() > 5_000);
    let (mut gpu, _) =
        open_tracer(BackendChoice::Backend(Backend::Gpu), None, None).expect("a GPU");
    for structure in [
        Structure::Boxes2,
        Structure::Spheres { leaf: 1 },
        Structure::Spheres { leaf: 8 },
        Structure::None,
    ] {
        let mut other = scene.clone();
        for deformed in [false, true] {
            if deformed {
                deform(&mut other, 3);
            }
            for index in 0..other.meshes.len() as u32 {
                let row = MeshRow {
                    structure,
                    ..other.meshes[index as usize].clone()
                };
                other.meshes.replace(index, row);
            }
            other.features = orrery_engine::frame::Features::of(&other);
            let mut plain = other.clone();
            for index in 0..plain.meshes.len() as u32 {
                let row = MeshRow {
                    structure: Structure::Boxes4,
                    ..plain.meshes[index as usize].clone()
                };
                plain.meshes.replace(index, row);
            }
            let expected = answers(&mut CpuTracer::new(), &plain, &rays);
            let found = answers(&mut CpuTracer::new(), &other, &rays);
            assert_eq!(found, expected, "{structure:?}, deformed: {deformed}");
            gpu.refit(&other).expect("refits");
            gpu.upload(&other, &settings()).expect("uploads");
            let on_gpu = gpu.intersect(&rays, Query::Closest).expect("answers");
            let id = |hit: &Hit| (hit.instance, hit.prim);
            let pairs = on_gpu.iter().zip(&expected);
            let differ = pairs.filter(|(a, b)| id(a) != id(b)).count();
            assert!(differ <= 4, "{structure:?} on the GPU: {differ} differ");
        }
    }
}

/// A world of so many spheres, some of them glass, and its frame.
fn world(count: u32, backend: Backend) -> Engine {
    let mut engine = Engine::new();
    let (tracer, _) = open_tracer(BackendChoice::Backend(backend), None, None).expect("a tracer");
    engine.world.resource_mut::<ActiveTracer>().0 = Some(tracer);
    *engine.world.resource_mut::<TraceSettings>() = settings();
    let at = |x: f64, z: f64| Transform::from_translation(DVec3::new(x, 0.0, z));
    engine.world.spawn((Camera::default(), at(0.0, 9.0)));
    engine.world.spawn((PointLight::default(), at(3.0, 9.0)));
    for i in 0..count {
        let place = at(f64::from(i % 100) * 0.3 - 15.0, -f64::from(i / 100) * 0.3);
        engine.world.spawn((Sphere { radius: 0.1 }, place));
    }
    engine
}

fn counters(engine: &Engine) -> Counters {
    let tracer = &engine.world.resource::<ActiveTracer>().0;
    tracer.as_ref().expect("a tracer").counters()
}

#[test]
fn where_nothing_changes_nothing_is_done() {
    let pixels = u64::from(settings().size.element_product());
    for backend in [Backend::Cpu, Backend::Gpu] {
        let mut engine = world(2_000, backend);
        for _ in 0..3 {
            engine.frame();
            // Its report comes back with it.
            let tracer = &mut engine.world.resource_mut::<ActiveTracer>().0;
            tracer.as_mut().expect("a tracer").picture().expect("one");
        }
        for frame in 0..5 {
            engine.frame();
            let counted = counters(&engine);
            assert_eq!(counted.kept_samples, pixels, "{backend}, {frame}");
            let nothing = Counters {
                kept_samples: pixels,
                bytes_kept: counted.bytes_kept,
                trees_kept: 1,
                missing_features: counted.missing_features,
                ..Counters::default()
            };
            assert_eq!(counted, nothing, "{backend}, {frame}");
        }
        // A tree may be found due for a new one, by how long tracing took: not in most of these frames.
        let mut bytes = [700; 8].map(|place| {
            let mut spheres = engine.world.query::<(&Sphere, &mut Transform)>();
            let moved = spheres.iter_mut(&mut engine.world).nth(place);
            moved.expect("there are more").1.translation.y += 0.01;
            engine.frame();
            let one = counters(&engine);
            assert_eq!(one.trees_updated, 1, "{backend}");
            one.bytes_uploaded
        });
        bytes.sort_unstable();
        let median = bytes[bytes.len() / 2];
        if backend == Backend::Gpu {
            assert!(
                (128..4096).contains(&median),
                "{median} bytes for one of 2,000"
            );
        }
    }
}

#[test]
fn a_camera_that_moves_touches_no_tree() {
    let mut engine = world(2_000, Backend::Cpu);
    engine.frame();
    for step in 1..20 {
        let mut cameras = engine.world.query::<(&Camera, &mut Transform)>();
        let (_, mut pose) = cameras.single_mut(&mut engine.world).expect("a camera");
        pose.translation.x += 0.05 * f64::from(step);
        engine.frame();
        let counters = counters(&engine);
        assert_eq!(counters.trees_updated, 0, "step {step}");
        assert!(counters.primary_rays > 0, "step {step}");
    }
}
