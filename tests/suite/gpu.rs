//! The GPU tracer against the CPU's. Any adapter will do, software Vulkan too; without one these fail.

use std::sync::{Arc, OnceLock};

use glam::{DAffine3, DVec3, UVec2};
use orrery_engine::frame::{Features, FrameScene, Instance, Shape, TraceSettings, ViewProjection};
use orrery_engine::trace::cpu::CpuTracer;
use orrery_engine::trace::gpu::{AdapterChoice, Gpu, GpuTracer};
use orrery_engine::trace::{Hit, Picture, Query, Ray, TraceError, Tracer};
use orrery_engine::world::Material;
use orrery_tests::metrics::compare_pictures;
use orrery_tests::panes::panes;
use orrery_tests::random_scene::{Random, icosphere, random_scene};
use orrery_tests::tracers::picture;

/// One device for all tests.
pub fn tracer() -> GpuTracer {
    static GPU: OnceLock<Arc<Gpu>> = OnceLock::new();
    let open = || Arc::new(Gpu::open(Gpu::instance(), &AdapterChoice::Any, None).expect("a GPU"));
    GpuTracer::new(Arc::clone(GPU.get_or_init(open))).expect("a tracer")
}

fn settings(width: u32, height: u32) -> TraceSettings {
    TraceSettings {
        size: UVec2::new(width, height),
        ..Default::default()
    }
}

fn both(scene: &FrameScene, settings: &TraceSettings) -> [Picture; 2] {
    let gpu = picture(&mut tracer(), scene, settings).expect("the GPU's picture");
    let cpu = picture(&mut CpuTracer::new(), scene, settings).expect("the CPU's picture");
    [gpu, cpu]
}

fn largest_difference(a: &Picture, b: &Picture) -> f32 {
    let pairs = a.pixels.iter().zip(&b.pixels);
    pairs
        .map(|(a, b)| (a - b).abs().max_element())
        .fold(0.0, f32::max)
}

fn ask(tracer: &mut dyn Tracer, scene: &FrameScene, rays: &[Ray], query: Query) -> Vec<Hit> {
    tracer.refit(scene).expect("refits");
    tracer.upload(scene, &settings(1, 1)).expect("uploads");
    tracer.intersect(rays, query).expect("answers")
}

fn ray(origin: DVec3, dir: DVec3) -> Ray {
    Ray {
        origin: origin.as_vec3(),
        dir: dir.as_vec3(),
        t_min: 0.0,
        t_max: f32::MAX,
    }
}

#[test]
fn gpu_and_cpu_find_the_same_hits() {
    let (mut tried, mut differ) = (0_u32, 0_u32);
    let mut errors = Vec::new();
    let (mut gpu, mut cpu) = (tracer(), CpuTracer::new());
    for seed in 0..12 {
        let scene = random_scene(seed, 60);
        let mut random = Random::new(seed + 1000);
        let rays: Vec<Ray> = (0..20_000)
            .map(|_| {
                let origin = random.cube() * 4.0 - DVec3::new(0.0, 1.0, 9.0);
                ray(origin, random.direction() * random.range(0.1, 3.0))
            })
            .collect();
        let found = ask(&mut gpu, &scene, &rays, Query::Closest);
        let expected = ask(&mut cpu, &scene, &rays, Query::Closest);
        let any = gpu.intersect(&rays, Query::Any).expect("answers");
        for ((a, b), any) in found.iter().zip(&expected).zip(&any) {
            tried += 1;
            let hits = a.instance != u32::MAX;
            assert_eq!(any.instance == 1, hits, "any and closest disagree");
            if (a.instance, a.prim) != (b.instance, b.prim) {
                differ += 1;
            } else if hits {
                errors.push((a.t - b.t).abs() / b.t.max(1e-3));
            }
        }
    }
    let ppm = f64::from(differ) * 1e6 / f64::from(tried);
    assert!(
        ppm <= 20.0,
        "{differ} of {tried} rays hit something else ({ppm} ppm)"
    );
    errors.sort_by(f64::total_cmp);
    let p999 = errors[errors.len() * 999 / 1000];
    assert!(
        p999 < 5e-5,
        "t differs by {p999} of itself at the 99.9th percentile"
    );
}

#[test]
fn rays_end_where_they_are_told_to() {
    let mut scene = FrameScene {
        materials: vec![Material::default()].into(),
        instances: vec![Instance {
            tag: 0,
            shape: Shape::Sphere { radius: 1.0 },
            world_from_local: DAffine3::from_translation(DVec3::NEG_Z * 5.0),
            material: 0,
        }]
        .into(),
        ..Default::default()
    };
    scene.features = Features::of(&scene);
    let towards = |t_min, t_max| Ray {
        t_min,
        t_max,
        ..ray(DVec3::ZERO, DVec3::NEG_Z)
    };
    let rays = [
        towards(0.0, 10.0),
        towards(4.5, 10.0),
        towards(0.0, 3.5),
        towards(6.5, f32::INFINITY),
    ];
    let mut tracer = tracer();
    let closest = ask(&mut tracer, &scene, &rays, Query::Closest);
    assert!((closest[0].t - 4.0).abs() < 1e-5 && closest[0].instance == 0);
    assert!((closest[1].t - 6.0).abs() < 1e-5, "the far side");
    assert_eq!(closest[2..], [Hit::MISS, Hit::MISS]);
    let any = tracer.intersect(&rays, Query::Any).unwrap();
    assert_eq!(
        any.iter().map(|h| h.instance).collect::<Vec<_>>(),
        [1, 1, 0, 0]
    );
    assert!(tracer.intersect(&[], Query::Any).unwrap().is_empty());
}

#[test]
fn a_closed_mesh_does_not_leak_on_the_gpu() {
    let mesh = icosphere(3);
    let mut random = Random::new(9);
    let rays: Vec<Ray> = (0..1_000_000)
        .map(|k| {
            let [a, b, _] = mesh.triangles[random.below(mesh.triangles.len())]
                .map(|i| mesh.vertices[i as usize]);
            let weight = if k % 2 == 0 { random.unit() } else { 1.0 };
            let target = (a * weight + b * (1.0 - weight)).as_vec3();
            let origin = (random.cube() * 0.5).as_vec3();
            ray(origin.as_dvec3(), (target - origin).as_dvec3())
        })
        .collect();
    let mut scene = FrameScene {
        materials: vec![Material::default()].into(),
        meshes: vec![mesh.into()].into(),
        instances: vec![Instance {
            tag: 0,
            shape: Shape::Mesh(0),
            world_from_local: DAffine3::IDENTITY,
            material: 0,
        }]
        .into(),
        ..Default::default()
    };
    scene.features = Features::of(&scene);
    let hits = ask(&mut tracer(), &scene, &rays, Query::Closest);
    let leaks = hits.iter().filter(|hit| hit.instance == u32::MAX).count();
    assert_eq!(leaks, 0, "{leaks} edge- and vertex-aimed rays got out");
}

#[test]
fn gpu_pictures_match_the_cpu() {
    let settings = settings(160, 120);
    let (mut gpu, mut cpu) = (tracer(), CpuTracer::new());
    let (mut off, mut pixels) = (0.0, 0.0);
    for seed in 0..10 {
        let scene = random_scene(seed, 40);
        let a = picture(&mut gpu, &scene, &settings).expect("the GPU's picture");
        let b = picture(&mut cpu, &scene, &settings).expect("the CPU's picture");
        let metrics = compare_pictures(&a, &b);
        assert_eq!(metrics.non_finite, 0, "seed {seed}");
        let count = f64::from(settings.size.element_product());
        off += metrics.mismatch_ppm * count;
        pixels += count;
        let (a, b) = (gpu.counters(), cpu.counters());
        assert_eq!(a.primary_rays, b.primary_rays);
        for (a, b) in [
            (a.reflected_rays, b.reflected_rays),
            (a.refracted_rays, b.refracted_rays),
            (a.shadow_rays, b.shadow_rays),
        ] {
            assert!(
                a.abs_diff(b) <= b / 200 + 10,
                "rays, GPU and CPU: {a} and {b}"
            );
        }
    }
    let ppm = off / pixels;
    assert!(
        ppm < 500.0,
        "{ppm} ppm of the pixels are off by more than 1/255"
    );
}

#[test]
fn transparent_shadows_are_tinted_as_on_the_cpu() {
    let scene = panes();
    let mut opaque = scene.clone();
    opaque.materials.edit(|material| {
        (material.filter, material.transmit) = (0.0, 0.0);
    });
    opaque.features = Features::of(&opaque);
    let settings = settings(120, 90);
    let [gpu, cpu] = both(&scene, &settings);
    let metrics = compare_pictures(&gpu, &cpu);
    assert!(metrics.mismatch_ppm < 300.0, "{metrics:?}");
    let [gpu_opaque, cpu_opaque] = both(&opaque, &settings);
    let metrics = compare_pictures(&gpu_opaque, &cpu_opaque);
    assert!(metrics.mismatch_ppm < 300.0, "opaque: {metrics:?}");
    assert!(
        largest_difference(&gpu, &gpu_opaque) > 0.05,
        "the panes let no light through"
    );
}

#[test]
fn samples_and_parallel_rays_match_the_cpu() {
    let mut scene = random_scene(4, 30);
    scene.view.projection = ViewProjection::Orthographic;
    scene.view.right *= 5.0;
    scene.view.up *= 5.0;
    let settings = TraceSettings {
        samples: 9,
        ..settings(64, 48)
    };
    let [gpu, cpu] = both(&scene, &settings);
    let metrics = compare_pictures(&gpu, &cpu);
    assert!(metrics.mismatch_ppm < 1500.0, "{metrics:?}");
    assert!(
        gpu.pixels.iter().any(|p| *p != gpu.pixels[0]),
        "nothing in view"
    );
}

#[test]
fn a_specialised_picture_is_the_general_one() {
    let scene = random_scene(2, 25);
    let lean = {
        let mut scene = scene.clone();
        scene.instances.edit(|instance| {
            if !matches!(instance.shape, Shape::Sphere { .. }) {
                instance.shape = Shape::Vacant;
            }
            instance.material = 0;
        });
        scene.features = Features::of(&scene);
        scene
    };
    assert!(!lean.features.meshes && !lean.features.reflection);
    let mut general = lean.clone();
    general.features = Features::all();
    let settings = settings(96, 72);
    let mut tracer = tracer();
    let a = picture(&mut tracer, &lean, &settings).unwrap();
    let b = picture(&mut tracer, &general, &settings).unwrap();
    let metrics = compare_pictures(&a, &b);
    assert!(metrics.p999 <= 1.5e-5, "{metrics:?}");
}

#[test]
fn the_same_frame_gives_the_same_bits_and_moves_no_bytes() {
    let scene = random_scene(6, 40);
    let one = settings(96, 72);
    let mut tracer = tracer();
    let first = picture(&mut tracer, &scene, &one).unwrap();
    let all_bytes = tracer.counters().bytes_uploaded;
    let again = picture(&mut tracer, &scene, &one).unwrap();
    assert!(first == again, "the second picture differs");
    assert_eq!(tracer.counters().bytes_uploaded, 0);
    let mut moved = scene.clone();
    let mut first_row = moved.instances[0];
    first_row.world_from_local.translation += DVec3::X * 0.1;
    moved.instances.set(0, first_row);
    picture(&mut tracer, &moved, &one).unwrap();
    let bytes = tracer.counters().bytes_uploaded;
    assert!(
        bytes > 0 && bytes < all_bytes / 2,
        "{bytes} of {all_bytes} bytes"
    );
    // More samples than one band holds: the bands' seams must not show.
    let many = TraceSettings {
        samples: 4,
        ..settings(2048, 160)
    };
    let [gpu, cpu] = [
        picture(&mut tracer, &scene, &many).unwrap(),
        picture(&mut CpuTracer::new(), &scene, &many).unwrap(),
    ];
    let metrics = compare_pictures(&gpu, &cpu);
    assert!(metrics.mismatch_ppm < 500.0, "{metrics:?}");
}

#[test]
fn what_cannot_be_done_is_an_error() {
    let mut tracer = tracer();
    assert!(matches!(tracer.picture(), Err(TraceError::Device(_))));
    assert!(matches!(tracer.render(), Err(TraceError::Device(_))));
    assert!(matches!(
        tracer.intersect(&[], Query::Any),
        Err(TraceError::Device(_))
    ));
    let scene = random_scene(1, 5);
    let huge = settings(60_000, 60_000);
    let answer = picture(&mut tracer, &scene, &huge);
    assert!(matches!(&answer, Err(TraceError::TooLarge(why)) if why.contains("60000")));
    assert!(
        picture(&mut tracer, &scene, &settings(8, 8)).is_ok(),
        "it works again after that"
    );
}

#[test]
fn passes_are_timed_by_the_device() {
    let mut tracer = tracer();
    picture(&mut tracer, &random_scene(1, 20), &settings(64, 64)).unwrap();
    let times = tracer.pass_times();
    let whitted = times.iter().find(|pass| pass.name == "whitted");
    assert!(whitted.is_some_and(|pass| pass.millis > 0.0), "{times:?}");
}

#[test]
fn a_ray_without_a_second_is_a_miss() {
    let scene = random_scene(3, 60);
    let mut random = Random::new(9);
    let rays: Vec<Ray> = (0..5)
        .map(|_| ray(DVec3::ZERO, -DVec3::Z + random.cube() * 0.1))
        .collect();
    let mut gpu = tracer();
    // What an earlier batch has left behind must not show.
    let earlier = ask(&mut gpu, &scene, &rays, Query::Closest);
    assert!(earlier[4].instance != u32::MAX, "the last ray hits");
    for count in [1, 3, 5] {
        let found = gpu
            .intersect(&rays[..count], Query::Leave)
            .expect("answers");
        let expected = ask(&mut CpuTracer::new(), &scene, &rays[..count], Query::Leave);
        let who = |hits: &[Hit]| hits.iter().map(|hit| hit.instance).collect::<Vec<_>>();
        assert_eq!(who(&found), who(&expected), "of {count}");
        assert_eq!(found.last(), Some(&Hit::MISS), "of {count}");
    }
}
