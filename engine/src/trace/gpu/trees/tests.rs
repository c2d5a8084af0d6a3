//! Pictures of meshes that the device deforms: the host's vertices are poison, and the picture is right.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, UVec2, Vec3};

use crate::frame::wire::Node4;
use crate::frame::{Features, FrameScene, Instance, Light, LightKind, Shape, TraceSettings};
use crate::trace::cpu::CpuTracer;
use crate::trace::gpu::{AdapterChoice, Gpu, GpuTracer};
use crate::trace::{Picture, Query, Ray, Tracer};
use crate::world::{DeformStep, Deformation, Material, MeshData, MeshRow, Structure};

/// A smooth tube of many triangles, open at its ends.
fn tube() -> MeshData {
    let (around, along) = (48_u32, 60_u32);
    let at = |i: u32| {
        let angle = f64::from(i % around) / f64::from(around) * std::f64::consts::TAU;
        let height = f64::from(i / around) / f64::from(along - 1) * 2.0 - 1.0;
        (angle, height)
    };
    let count = around * along;
    let vertices = (0..count).map(|i| {
        let (angle, height) = at(i);
        DVec3::new(0.5 * angle.cos(), height, 0.3 * angle.sin()) + DVec3::new(100.0, 3.0, -7.0)
    });
    let normals = (0..count).map(|i| {
        let (angle, _) = at(i);
        Vec3::new(angle.cos() as f32, 0.0, angle.sin() as f32)
    });
    let triangles = (0..around * (along - 1)).flat_map(|i| {
        let next = i / around * around + (i + 1) % around;
        [[i, i + around, next], [next, i + around, next + around]]
    });
    MeshData::new(
        "tube",
        vertices.collect(),
        normals.collect(),
        triangles.collect(),
    )
    .expect("a tube is a mesh")
}

fn bent(by: f64) -> Arc<Deformation> {
    Arc::new(Deformation {
        steps: vec![
            DeformStep::Twist {
                origin: DVec3::new(100.0, 0.0, -7.0),
                axis: DVec3::Y,
                rate: by,
                offset: 0.2,
            },
            DeformStep::Wave {
                wave: DVec3::Y * 4.0,
                amplitude: DVec3::new(0.3 * by, 0.0, 0.1),
                phase: by,
            },
        ],
    })
}

fn scene(mesh: Arc<MeshData>, deformation: Option<Arc<Deformation>>) -> FrameScene {
    let at = |position, turn| {
        DAffine3::from_rotation_translation(DQuat::from_rotation_z(turn), position)
    };
    let centre = DAffine3::from_translation(-mesh.origin);
    let instance = |world_from_local, shape| Instance {
        tag: 0,
        shape,
        world_from_local,
        material: 0,
    };
    let mut scene = FrameScene {
        meshes: vec![MeshRow {
            data: mesh,
            deformation,
            ..MeshRow::default()
        }]
        .into(),
        instances: vec![
            instance(
                at(DVec3::new(-0.9, 0.0, -4.0), 0.3) * centre,
                Shape::Mesh(0),
            ),
            instance(
                at(DVec3::new(1.0, 0.0, -4.5), -0.5) * centre,
                Shape::Mesh(0),
            ),
            instance(
                at(DVec3::new(0.0, -6.5, -4.0), 0.0),
                Shape::Sphere { radius: 5.0 },
            ),
        ]
        .into(),
        materials: vec![Material::default()].into(),
        lights: vec![Light {
            color: Vec3::ONE,
            fade: None,
            kind: LightKind::Point {
                position: DVec3::new(3.0, 5.0, 2.0),
            },
        }]
        .into(),
        ..FrameScene::default()
    };
    scene.features = Features::of(&scene);
    scene
}

fn picture(tracer: &mut dyn Tracer, scene: &FrameScene) -> Picture {
    let settings = TraceSettings {
        size: UVec2::new(160, 120),
        ..TraceSettings::default()
    };
    tracer.refit(scene).expect("refits");
    tracer.upload(scene, &settings).expect("uploads");
    tracer.render().expect("renders");
    tracer.picture().expect("a picture")
}

/// Pixels that differ by more than the two tracers' rounding of the same sine.
fn differing(a: &Picture, b: &Picture) -> usize {
    let pairs = a.pixels.iter().zip(&b.pixels);
    let differs = |(a, b): &(&Vec3, &Vec3)| !((**a - **b).abs().max_element() < 2e-3);
    pairs.filter(differs).count()
}

fn open() -> GpuTracer {
    let gpu = Gpu::open(Gpu::instance(), &AdapterChoice::Any, None);
    let gpu = gpu.expect("a GPU, or software Vulkan, for the tests");
    GpuTracer::new(Arc::new(gpu)).expect("a tracer")
}

/// Nothing that the host holds of vertices and boxes may reach a picture any more.
fn poison(tracer: &mut GpuTracer) {
    for mesh in &mut tracer.packed.meshes {
        for row in &mut mesh.vertices {
            row.vector = [f32::NAN; 3];
        }
        for node in mesh.nodes_mut() {
            *node = Node4 {
                min_x: [f32::NAN; 4],
                max_y: [f32::NAN; 4],
                ..*node
            };
        }
    }
}

#[test]
fn pictures_of_deformed_meshes_need_no_vertex_of_the_host() {
    let mesh = Arc::new(tube());
    let mut gpu = open();
    let mut cpu = CpuTracer::new();
    let mut frame = scene(Arc::clone(&mesh), Some(bent(0.5)));
    let most = 160 * 120 / 200;
    let mut last: Option<Picture> = None;
    for by in [0.5, 1.5, -0.75, 1.0] {
        let row = MeshRow {
            deformation: Some(bent(by)),
            ..frame.meshes[0].clone()
        };
        frame.meshes.replace(0, row);
        let (found, expected) = (picture(&mut gpu, &frame), picture(&mut cpu, &frame));
        assert!(
            found.pixels.iter().any(|p| *p != found.pixels[0]),
            "nothing to see"
        );
        let wrong = differing(&found, &expected);
        assert!(wrong <= most, "{wrong} pixels differ at {by}");
        if let Some(last) = last {
            assert!(
                differing(&found, &last) > 10 * most,
                "nothing moved at {by}"
            );
        }
        last = Some(found);
        poison(&mut gpu);
    }
    let ray = Ray {
        origin: Vec3::ZERO,
        dir: Vec3::new(-0.9, 0.0, -4.0),
        t_min: 0.0,
        t_max: f32::MAX,
    };
    let found = gpu.intersect(&[ray], Query::Closest).expect("answers");
    let expected = cpu.intersect(&[ray], Query::Closest).expect("answers");
    assert_eq!(found[0].instance, expected[0].instance);
    assert!((found[0].t - expected[0].t).abs() < 1e-4);
}

#[test]
fn pictures_of_meshes_that_the_host_deforms_follow_it() {
    let mesh = Arc::new(tube());
    let (mut gpu, mut cpu) = (open(), CpuTracer::new());
    let mut frame = scene(mesh, None);
    let most = 160 * 120 / 200;
    for by in [0.5, 1.5] {
        let row = MeshRow {
            deformation: Some(bent(by)),
            structure: Structure::Spheres { leaf: 4 },
            ..frame.meshes[0].clone()
        };
        frame.meshes.replace(0, row);
        frame.features = Features::of(&frame);
        let (found, expected) = (picture(&mut gpu, &frame), picture(&mut cpu, &frame));
        assert!(!gpu.packed.meshes[0].is_left_to_device());
        let wrong = differing(&found, &expected);
        assert!(wrong <= most, "{wrong} pixels differ at {by}");
    }
}

#[test]
fn a_mesh_that_comes_to_rest_is_the_one_it_was() {
    let mesh = Arc::new(tube());
    let mut gpu = open();
    let mut frame = scene(mesh, None);
    let at_rest = picture(&mut gpu, &frame);
    for deformation in [Some(bent(1.0)), None] {
        let row = MeshRow {
            deformation,
            ..frame.meshes[0].clone()
        };
        frame.meshes.replace(0, row);
        let now = picture(&mut gpu, &frame);
        let is_at_rest = now.pixels == at_rest.pixels;
        assert_eq!(is_at_rest, frame.meshes[0].deformation.is_none());
    }
}

/// Spheres at random places about the view; a few rows are vacant.
fn crowd(count: u32, moved_by: f64) -> Vec<Instance> {
    let mut state = 9_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / 16_777_216.0 - 0.5
    };
    (0..count)
        .map(|row| {
            let place = DVec3::new(random() * 9.0, random() * 7.0, random() * 8.0 - 9.0);
            let by = DVec3::new(random(), random(), random()) * moved_by;
            let radius = 0.1;
            let shape = match row % 50 {
                7 => Shape::Vacant,
                _ => Shape::Sphere { radius },
            };
            Instance {
                tag: 0,
                shape,
                world_from_local: DAffine3::from_translation(place + by),
                material: 0,
            }
        })
        .collect()
}

#[test]
fn who_builds_the_tree_over_instances_changes_no_bit() {
    let (mut here, mut there) = (open(), open());
    here.packed.instances.device_from = None;
    there.packed.instances.device_from = Some(1000);
    let mut frame = scene(Arc::new(tube()), None);
    let mut built_there = 0;
    for step in 0..8_u32 {
        // All move, then none, then one, then all again.
        let by = [0.0, 1.0, 2.0, 3.0, 3.0, 3.0, 4.0, 5.0][step as usize];
        let mut instances = crowd(2000, by);
        if step >= 5 {
            instances[3].world_from_local.translation.y += 0.5;
        }
        frame.instances.assign(instances);
        frame.features = Features::of(&frame);
        let (a, b) = (picture(&mut here, &frame), picture(&mut there, &frame));
        assert!(a.pixels.iter().any(|p| *p != a.pixels[0]), "nothing to see");
        assert!(a.pixels == b.pixels, "another picture in step {step}");
        built_there += u32::from(there.packed.instances.is_on_device());
    }
    assert_eq!(built_there, 5, "1, 2, 3, 4 and 7");
}
