//! What is left out, one by one: the picture is the same without it, and counts say what it saved.

use std::path::Path;

use glam::{DVec3, UVec2, Vec3};
use orrery_engine::Engine;
use orrery_engine::frame::{Features, FrameScene, Light, LightKind, Skip, Skips, TraceSettings};
use orrery_engine::time::Clock;
use orrery_engine::trace::cpu::CpuTracer;
use orrery_engine::trace::{Backend, Counters, Picture, Tracer};
use orrery_engine::world::Reflection;
use orrery_tests::random_scene::{Random, random_scene};
use orrery_tests::tracers::picture;

/// What two kernels of one source may round apart.
const ROUNDINGS: f32 = 1.5e-5;

fn settings(width: u32, height: u32) -> TraceSettings {
    TraceSettings {
        size: UVec2::new(width, height),
        ..Default::default()
    }
}

fn largest_difference(a: &Picture, b: &Picture) -> f32 {
    let pairs = a.pixels.iter().zip(&b.pixels);
    pairs
        .map(|(a, b)| (a - b).abs().max_element())
        .fold(0.0, f32::max)
}

#[test]
fn a_device_that_counts_no_rays_traces_the_same() {
    let counting = settings(80, 60);
    let not_counting = TraceSettings {
        count_rays: false,
        ..counting
    };
    let mut tracer = crate::gpu::tracer();
    for seed in 0..3 {
        let scene = random_scene(seed, 40);
        let counted = picture(&mut tracer, &scene, &counting).expect("a picture");
        let counters = tracer.counters();
        assert_eq!(counters.primary_rays, 80 * 60);
        assert!(counters.rays() > 2 * 80 * 60, "{counters:?}");
        // Nobody is made to wait for a picture because somebody reads counts, or no longer does.
        picture(&mut tracer, &scene, &not_counting).expect("a picture");
        assert_eq!(tracer.counters().rays(), 0, "the picture is there");
        let mut other = crate::gpu::tracer();
        let uncounted = picture(&mut other, &scene, &not_counting).expect("a picture");
        assert_eq!(other.counters().rays(), 0);
        let off = largest_difference(&counted, &uncounted);
        assert!(off <= ROUNDINGS, "seed {seed}: {off}");
    }
}

/// Both f32 tracers.
fn tracers() -> [Box<dyn Tracer>; 2] {
    [Box::new(CpuTracer::new()), Box::new(crate::gpu::tracer())]
}

fn demo() -> FrameScene {
    let mut engine = Engine::new();
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/scenes/demo.ron");
    orrery_engine::scene::load(&mut engine.world, &file).expect("the demo loads");
    *engine.world.resource_mut::<Clock>() = Clock::Frame(30);
    engine.frame();
    engine.world.resource::<FrameScene>().clone()
}

/// Mirrors and glass of which one takes what the other leaves, so that weights become 0; a spot light; a black thing.
fn red_and_blue(seed: u64) -> FrameScene {
    let mut scene = random_scene(seed, 40);
    let (mut row, pure) = (0, [Vec3::X, Vec3::Z]);
    scene.materials.edit(|material| {
        row += 1;
        if row == 5 {
            material.diffuse = 0.0;
        } else {
            material.reflection = Reflection::Constant(pure[row % 2]);
        }
    });
    scene.lights.push(Light {
        color: Vec3::splat(0.5),
        fade: None,
        kind: LightKind::Spot {
            position: DVec3::new(0.0, 6.0, 3.0),
            axis: DVec3::NEG_Y,
            cos_inner: 0.95,
            cos_outer: 0.9,
        },
    });
    scene.features = Features::of(&scene);
    scene
}

/// Shadow rays that Whitted's model asks for, traced or left out.
fn asked(counters: &Counters) -> u64 {
    let of = |skip| counters.saved(skip);
    counters.shadow_rays + of(Skip::Away) + of(Skip::Black) + of(Skip::FaintLights)
}

fn traced(
    tracer: &mut dyn Tracer,
    scene: &FrameScene,
    settings: &TraceSettings,
) -> (Picture, Counters) {
    let picture = picture(tracer, scene, settings).expect("a picture");
    (picture, tracer.counters())
}

#[test]
fn rays_that_bring_nothing_are_left_out_and_no_pixel_shows_it() {
    let whole = settings(60, 45);
    let mut cpu = CpuTracer::new();
    let scenes = [
        demo(),
        red_and_blue(1),
        red_and_blue(2),
        random_scene(3, 30),
    ];
    let mut saved = [0; Skip::ALL.len()];
    for scene in &scenes {
        let (usual, counters) = traced(&mut cpu, scene, &whole);
        for skip in [Skip::Away, Skip::Black, Skip::Weightless] {
            let all = TraceSettings {
                skips: Skips::ALL.without(skip),
                ..whole
            };
            let (without, more) = traced(&mut cpu, scene, &all);
            assert!(without == usual, "{skip} shows");
            assert_eq!(more.saved(skip), 0);
            let left_out = counters.saved(skip);
            saved[skip as usize] += left_out;
            if skip == Skip::Weightless {
                let followed = more.reflected_rays + more.refracted_rays;
                let fewer = counters.reflected_rays + counters.refracted_rays;
                assert!(followed >= fewer + left_out);
            } else {
                assert_eq!(asked(&more), asked(&counters), "{skip}");
                assert_eq!(more.shadow_rays > counters.shadow_rays, left_out > 0);
            }
        }
    }
    for skip in [Skip::Away, Skip::Black, Skip::Weightless] {
        assert!(saved[skip as usize] > 100, "{skip}: {saved:?}");
    }
}

#[test]
fn a_device_leaves_out_what_the_processor_does() {
    let whole = settings(60, 45);
    let all = TraceSettings {
        skips: Skips::NONE,
        ..whole
    };
    let mut scene = red_and_blue(1);
    // Software Vulkan ends an invocation's loops after 65,535 rounds in all, and here every ray there could be is followed.
    scene.max_generations = 3;
    let [mut cpu, mut gpu] = tracers();
    let (usual, counters) = traced(gpu.as_mut(), &scene, &whole);
    let (_, host) = traced(cpu.as_mut(), &scene, &whole);
    for skip in [Skip::Away, Skip::Black, Skip::Weightless] {
        let (here, there) = (counters.saved(skip), host.saved(skip));
        assert!(here > 100, "{skip}: {here}");
        assert!(
            here.abs_diff(there) <= there / 100 + 10,
            "{skip}: {here} and {there}"
        );
    }
    assert!(counters.saved(Skip::Kernels) > 5);
    let (without, more) = traced(gpu.as_mut(), &scene, &all);
    let off = largest_difference(&without, &usual);
    assert!(off <= ROUNDINGS, "{off}");
    for skip in [Skip::Away, Skip::Black, Skip::Weightless, Skip::Kernels] {
        assert_eq!(more.saved(skip), 0, "{skip}");
    }
    assert!(more.shadow_rays > counters.shadow_rays + counters.saved(Skip::Away));
}

/// As many lights as count for nothing each, and together for much.
fn many_lights() -> FrameScene {
    let mut scene = random_scene(1, 20);
    let mut random = Random::new(7);
    for _ in 0..60 {
        let place = random.direction() * 8.0 + DVec3::Y * 8.0;
        scene.lights.push(Light {
            color: Vec3::splat(random.range(0.0, 0.01) as f32),
            fade: None,
            kind: LightKind::Point { position: place },
        });
    }
    scene
}

#[test]
fn lights_left_out_add_up_to_no_more_than_the_cutoff() {
    let scene = many_lights();
    let whole = settings(60, 45);
    for mut tracer in tracers() {
        let name = tracer.backend();
        let (usual, all) = traced(tracer.as_mut(), &scene, &whole);
        assert_eq!(all.saved(Skip::FaintLights), 0);
        // Half a step of 8 bits, and a tenth of that.
        for cutoff in [0.5 / 255.0, 0.05 / 255.0] {
            let cut = TraceSettings { cutoff, ..whole };
            let (picture, counters) = traced(tracer.as_mut(), &scene, &cut);
            let off = largest_difference(&picture, &usual);
            assert!(off <= cutoff * 1.01 + 2e-6, "{name}: {off} for {cutoff}");
            let left_out = counters.saved(Skip::FaintLights);
            assert!(left_out > 500, "{name}: {left_out} for {cutoff}");
            assert!(counters.shadow_rays < all.shadow_rays, "{name}");
        }
        if name == Backend::Cpu {
            let faint = Skips::ALL
                .without(Skip::FaintLights)
                .without(Skip::FaintRays);
            let kept = TraceSettings {
                cutoff: 0.5 / 255.0,
                skips: faint,
                ..whole
            };
            let (picture, counters) = traced(tracer.as_mut(), &scene, &kept);
            assert!(
                picture == usual,
                "nothing is left out, and the cut-off shows"
            );
            assert_eq!(counters.rays(), all.rays());
        }
    }
}

#[test]
fn what_rests_and_what_a_device_keeps_is_what_would_be_traced_and_brought_again() {
    let scene = random_scene(5, 20);
    let refined = TraceSettings {
        refine_to: 4,
        ..settings(40, 30)
    };
    let adaptive = TraceSettings {
        samples: 3,
        adaptive: Some(0.1),
        refine_to: 6,
        ..refined
    };
    for usual in [settings(40, 30), refined, adaptive] {
        for mut tracer in tracers() {
            let name = tracer.backend();
            let mut show = |settings: &TraceSettings| traced(tracer.as_mut(), &scene, settings);
            let (kept, counters) = (0..7).map(|_| show(&usual)).last().expect("seven");
            assert_eq!(counters.rays(), 0, "{name}");
            let samples = u64::from(usual.refine_to.max(1)) * 40 * 30;
            assert_eq!(counters.saved(Skip::Still), samples, "{name}");
            let anew = TraceSettings {
                skips: Skips::ALL.without(Skip::Still).without(Skip::Uploads),
                ..usual
            };
            // The first of them starts over, since the settings are others.
            for _ in 0..7 {
                show(&anew);
            }
            for _ in 0..2 {
                let (again, counters) = show(&anew);
                assert!(again == kept, "{name}");
                assert!(counters.rays() > 0, "{name}");
                assert_eq!(counters.saved(Skip::Still), 0, "{name}");
                let is_device = name == Backend::Gpu;
                assert_eq!(counters.bytes_uploaded > 1000, is_device, "{name}");
            }
            if name == Backend::Gpu {
                show(&usual);
                assert!(show(&usual).1.saved(Skip::Uploads) > 1000);
            }
        }
    }
}

#[test]
fn trees_that_follow_what_moves_show_what_trees_made_anew_do() {
    let whole = settings(40, 30);
    let anew = TraceSettings {
        skips: Skips::ALL.without(Skip::Trees),
        ..whole
    };
    for (tracer, other) in tracers().into_iter().zip(tracers()) {
        let mut both = [(tracer, whole), (other, anew)];
        let mut scene = random_scene(4, 20);
        for frame in 0..4 {
            let [(usual, kept), (other, none)] = both
                .each_mut()
                .map(|(tracer, settings)| traced(tracer.as_mut(), &scene, settings));
            assert!(usual == other, "frame {frame}: how trees are made shows");
            if frame > 0 {
                assert!(kept.saved(Skip::Trees) >= 2, "{kept:?}");
                assert_eq!(none.saved(Skip::Trees), 0);
            }
            let step = DVec3::new(0.05, 0.02, 0.0);
            scene.instances.edit(|instance| {
                instance.world_from_local.translation += step * f64::from(instance.material);
            });
        }
    }
}
