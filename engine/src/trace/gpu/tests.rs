//! What can go wrong with a device: it is lost, a scene is too large for it, it tells no times.

use std::sync::Arc;

use glam::{DAffine3, DVec3, UVec2, Vec3};

use super::{AdapterChoice, Gpu, GpuTracer};
use crate::frame::{
    Features, FrameScene, Instance, Light, LightKind, Shape, Skip, Skips, TraceSettings,
};
use crate::testing::Random;
use crate::trace::{Picture, TraceError, Tracer};
use crate::world::{DeformStep, Deformation, Material, MeshData, MeshRow, Reflection};

pub(super) fn open() -> Arc<Gpu> {
    let gpu = Gpu::open(Gpu::instance(), &AdapterChoice::Any, None);
    Arc::new(gpu.expect("a GPU, or software Vulkan, for the tests"))
}

/// A wavy strip of so many triangles.
fn strip(triangles: u32) -> MeshData {
    let vertices = (0..triangles + 2).map(|i| {
        let t = f64::from(i) / f64::from(triangles);
        DVec3::new(4.0 * t - 2.0, f64::from(i % 2) - 1.0, 0.0)
    });
    let corners = (0..triangles).map(|i| [i, i + 1, i + 2]).collect();
    MeshData::new("strip", vertices.collect(), Vec::new(), corners).expect("a mesh")
}

/// A strip, deformed on the device, behind so many small mirrors: their tree is built there where they are many.
pub(super) fn scene(triangles: u32, balls: usize) -> FrameScene {
    let mut random = Random::new(5);
    let waves = Deformation {
        steps: vec![DeformStep::Wave {
            wave: DVec3::new(3.0, 0.0, 0.0),
            amplitude: DVec3::new(0.0, 0.0, 0.3),
            phase: 0.7,
        }],
    };
    let mesh = MeshRow {
        data: Arc::new(strip(triangles)),
        deformation: Some(Arc::new(waves)),
        ..MeshRow::default()
    };
    let at = |place: DVec3| DAffine3::from_translation(place);
    let instance = |shape, world_from_local, material| Instance {
        tag: 0,
        shape,
        world_from_local,
        material,
    };
    let mut instances = vec![instance(Shape::Mesh(0), at(DVec3::NEG_Z * 4.0), 0)];
    instances.extend((0..balls).map(|_| {
        let place = random.cube() * 1.5 - DVec3::Z * 4.0;
        instance(Shape::Sphere { radius: 0.03 }, at(place), 1)
    }));
    let mirror = Material {
        reflection: Reflection::Constant(Vec3::splat(0.5)),
        ..Material::default()
    };
    let mut scene = FrameScene {
        meshes: vec![mesh].into(),
        instances: instances.into(),
        materials: vec![Material::default(), mirror].into(),
        lights: vec![Light {
            color: Vec3::ONE,
            fade: None,
            kind: LightKind::Point {
                position: DVec3::new(3.0, 5.0, 2.0),
            },
        }]
        .into(),
        max_generations: 3,
        ..FrameScene::default()
    };
    scene.features = Features::of(&scene);
    scene
}

/// So little that no buffer has to grow for it.
fn ground() -> FrameScene {
    let mut ground = scene(30, 0);
    let plane = Shape::Plane {
        normal: DVec3::Y,
        distance: -1.0,
    };
    ground.instances.edit(|instance| instance.shape = plane);
    ground.materials = vec![Material::default()].into();
    ground.meshes = Vec::new().into();
    ground.features = Features::of(&ground);
    ground
}

pub(super) fn settings(side: u32) -> TraceSettings {
    TraceSettings {
        size: UVec2::splat(side),
        refine_to: 4,
        ..TraceSettings::default()
    }
}

pub(super) fn picture(
    tracer: &mut GpuTracer,
    scene: &FrameScene,
    settings: &TraceSettings,
) -> Result<Picture, TraceError> {
    tracer.refit(scene)?;
    tracer.upload(scene, settings)?;
    tracer.render()?;
    tracer.picture()
}

/// Takes the device away; a loss is told when the device is asked.
fn lose(gpu: &Gpu) {
    gpu.device.destroy();
    let _ = gpu.device.poll(wgpu::PollType::Poll);
}

/// What one level of trees leaves out when a scene is one mesh, and only then: the picture is the general kernel's.
#[test]
fn a_mesh_alone_is_walked_without_a_tree_over_instances() {
    let mut tracer = GpuTracer::new(open()).expect("a tracer");
    let mut general = GpuTracer::new(open()).expect("a tracer");
    let all = TraceSettings {
        skips: Skips::ALL.without(Skip::Kernels),
        ..settings(64)
    };
    let mut scene = scene(300, 3);
    let turned = DAffine3::from_rotation_z(0.4) * DAffine3::from_scale(DVec3::new(1.0, 0.5, 2.0));
    scene.instances.edit(|instance| {
        if matches!(instance.shape, Shape::Mesh(_)) {
            instance.world_from_local *= turned;
        }
    });
    let ball = Shape::Sphere { radius: 0.3 };
    let ground = Shape::Plane {
        normal: DVec3::Y,
        distance: -1.0,
    };
    let beside = [
        (Shape::Vacant, false),
        (ball, true),
        (Shape::Vacant, false),
        (ground, false),
        (Shape::Mesh(0), true),
        (Shape::Vacant, false),
    ];
    for (shape, is_more) in beside {
        scene.instances.edit(|instance| {
            if instance.material == 1 {
                instance.shape = shape;
            }
        });
        scene.features = Features::of(&scene);
        assert_eq!(scene.features.instances, is_more, "{shape:?}");
        let seen = picture(&mut tracer, &scene, &settings(64)).expect("a picture");
        let missing = Features::NAMED.len() - scene.features.count();
        assert_eq!(
            tracer.counters().missing_features,
            missing as u64,
            "{shape:?}"
        );
        let right = picture(&mut general, &scene, &all).expect("a picture");
        let pixels = seen.pixels.iter().zip(&right.pixels);
        let off = pixels.filter(|(a, b)| (**a - **b).abs().max_element() > 1.5e-5);
        assert_eq!(off.count(), 0, "beside {shape:?}");
        assert!(seen.pixels.iter().any(|pixel| *pixel != seen.pixels[0]));
    }
}

#[test]
fn after_a_loss_the_picture_is_the_one_before_bit_for_bit() {
    for scene in [scene(300, 20), scene(300, 9000), ground()] {
        let gpu = open();
        let mut tracer = GpuTracer::new(Arc::clone(&gpu)).expect("a tracer");
        let before = picture(&mut tracer, &scene, &settings(96)).expect("a picture");
        assert!(before.pixels.iter().any(|pixel| *pixel != before.pixels[0]));
        lose(&gpu);
        for _ in 0..3 {
            let lost = picture(&mut tracer, &scene, &settings(96));
            assert!(matches!(lost, Err(TraceError::DeviceLost(_))), "{lost:?}");
        }
        tracer.recover(None).expect("another device");
        let after = picture(&mut tracer, &scene, &settings(96)).expect("a picture again");
        let size = scene.size_in_words();
        assert!(before == after, "{size}: the picture is another one");
        assert_eq!(tracer.samples(), 1, "it is traced from its start");
        // What the device lost is there again: nothing more is to be brought.
        picture(&mut tracer, &scene, &settings(96)).expect("refines");
        assert_eq!(tracer.counters().bytes_uploaded, 0);
        assert_eq!(tracer.samples(), 2);
    }
}

#[test]
fn a_device_that_is_given_takes_the_lost_ones_place_and_may_be_lost_too() {
    let scene = scene(30, 20);
    let mut gpu = open();
    let mut tracer = GpuTracer::new(Arc::clone(&gpu)).expect("a tracer");
    let before = picture(&mut tracer, &scene, &settings(32)).expect("a picture");
    for _ in 0..3 {
        lose(&gpu);
        assert!(matches!(gpu.check(), Err(TraceError::DeviceLost(_))));
        gpu = Arc::new(gpu.reopened().expect("another device"));
        tracer.recover(Some(Arc::clone(&gpu))).expect("a tracer");
        let after = picture(&mut tracer, &scene, &settings(32)).expect("a picture");
        assert!(before == after);
    }
}

/// The limit by its name, what would not fit into it, the size of the scene and a way out.
#[test]
fn what_is_too_large_says_which_limit_and_how_large_it_is() {
    let most = 1 << 18;
    let gpu = Arc::new(Gpu::limited(most).expect("a GPU"));
    let mut tracer = GpuTracer::new(gpu).expect("a tracer");
    let small = scene(30, 20);
    let fine = picture(&mut tracer, &small, &settings(32)).expect("fits");
    let mut lamps = small.clone();
    lamps.lights = vec![small.lights[0]; 9_000].into();
    let cases = [
        (scene(5_000, 0), "triangles", "5000 triangles"),
        (scene(30, 3_000), "instances", "3001 instances"),
        (lamps, "lights", "9000 lights"),
    ];
    for (large, rows, size) in cases {
        let answer = picture(&mut tracer, &large, &settings(32));
        let Err(TraceError::TooLarge(why)) = answer else {
            panic!("{rows}: {answer:?}");
        };
        let bytes = most.to_string();
        for part in [rows, &bytes, "max_", "_size", size, "--backend cpu"] {
            assert!(why.contains(part), "{part:?} is not in: {why}");
        }
        let again = picture(&mut tracer, &small, &settings(32));
        assert!(again.is_ok_and(|again| again == fine), "after {rows}");
    }
    let huge = picture(&mut tracer, &small, &settings(200));
    assert!(
        matches!(&huge, Err(TraceError::TooLarge(why)) if why.contains("200 x 200") && why.contains("max_")),
        "{huge:?}"
    );
}

#[test]
fn a_device_without_timestamps_is_timed_by_waiting() {
    let gpu = Arc::new(Gpu::untimed().expect("a GPU"));
    let mut tracer = GpuTracer::new(gpu).expect("a tracer");
    let mut scene = scene(30, 20);
    let timed = [(); 10].map(|()| {
        scene.view.origin.x += 0.01;
        picture(&mut tracer, &scene, &settings(32)).expect("a picture");
        tracer.timed_picture().is_some_and(|time| time.rays > 0.0)
    });
    assert_eq!(timed, [0, 1, 2, 3, 4, 5, 6, 7, 8, 9].map(|i| i % 8 == 1));
}

#[test]
fn a_slow_device_is_asked_how_many_edges_there_are() {
    let adaptive = TraceSettings {
        samples: 16,
        adaptive: Some(0.05),
        refine_to: 0,
        ..settings(96)
    };
    let scene = scene(30, 20);
    let mut tracer = GpuTracer::new(open()).expect("a tracer");
    let usual = picture(&mut tracer, &scene, &adaptive).expect("a picture");
    let edges = tracer.counters().edge_pixels;
    assert!(edges > 100, "{edges}");
    let mut slow = GpuTracer::new(open()).expect("a tracer");
    // After its first frame, whose kernel is another one than none.
    picture(&mut slow, &ground(), &adaptive).expect("a picture");
    picture(&mut slow, &scene, &adaptive).expect("a picture");
    slow.pace.note(slow.pace.epoch(), 1, 1e6);
    let mut elsewhere = scene.clone();
    elsewhere.view.origin.x += 1.0;
    picture(&mut slow, &elsewhere, &adaptive).expect("a picture");
    slow.pace.note(slow.pace.epoch(), 1, 1e6);
    let in_parts = picture(&mut slow, &scene, &adaptive).expect("a picture");
    assert!(in_parts == usual);
    assert_eq!(slow.counters().edge_pixels, edges);
    assert!(slow.device_millis.is_some());
}

/// Deformed on the device, whose trees and rows are all made anew in every other frame.
#[test]
fn what_a_device_keeps_is_what_it_would_make_anew() {
    let mut scene = scene(300, 20);
    let usual = settings(64);
    let anew = TraceSettings {
        skips: Skips::ALL.without(Skip::Trees).without(Skip::Uploads),
        ..usual
    };
    let mut tracer = GpuTracer::new(open()).expect("a tracer");
    let mut other = GpuTracer::new(open()).expect("a tracer");
    for frame in 0..4 {
        let expected = picture(&mut tracer, &scene, &usual).expect("a picture");
        // One frame later it holds: a frame is packed by the switches of the one before.
        picture(&mut other, &scene, &anew).expect("a picture");
        let made = picture(&mut other, &scene, &anew).expect("a picture");
        assert!(made == expected, "frame {frame}");
        scene.view.origin.x += 0.1;
    }
}
