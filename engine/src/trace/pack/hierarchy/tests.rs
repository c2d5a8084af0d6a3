//! Levels of every structure against what is below them and against the triangles themselves.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3};

use super::*;
use crate::frame::{FrameScene, Instance, Shape, TraceSettings};
use crate::world::{DeformStep, Deformation, MeshData, MeshRow, Structure, VertexSets};

const TRIANGLES: usize = 400;
const STRUCTURES: [Structure; 4] = [
    Structure::Boxes4,
    Structure::Boxes2,
    Structure::Spheres { leaf: 3 },
    Structure::None,
];

/// Small triangles in a cube, the same in every run.
fn soup() -> MeshData {
    let mut state = 7_u32;
    let mut number = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / 16_777_216.0 - 0.5
    };
    let mut vector = || DVec3::new(number(), number(), number());
    let positions = (0..TRIANGLES).flat_map(|_| {
        let corner = vector() * 2.0;
        [corner, corner + vector() * 0.1, corner + vector() * 0.1]
    });
    let positions = positions.collect();
    let triangles = (0..TRIANGLES as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    MeshData::new("soup", positions, Vec::new(), triangles.collect()).unwrap()
}

/// Two meshes of a structure and a sphere, all ahead.
fn scene(structure: Structure, deformation: Option<Arc<Deformation>>) -> FrameScene {
    let place = |x: f64, turn: f64, shape| Instance {
        tag: 0,
        shape,
        world_from_local: DAffine3::from_rotation_translation(
            DQuat::from_rotation_y(turn),
            DVec3::new(x, 0.0, -9.0),
        ),
        material: 0,
    };
    FrameScene {
        meshes: vec![MeshRow {
            data: Arc::new(soup()),
            structure,
            deformation,
        }]
        .into(),
        instances: vec![
            place(-2.0, 0.0, Shape::Mesh(0)),
            place(0.0, 0.0, Shape::Sphere { radius: 0.7 }),
            place(2.0, 0.4, Shape::Mesh(0)),
        ]
        .into(),
        materials: vec![crate::world::Material::default()].into(),
        ..FrameScene::default()
    }
}

fn packed(scene: &FrameScene, mut packed: PackedScene) -> PackedScene {
    packed.refit(scene);
    packed.pack(scene, &TraceSettings::default());
    packed
}

/// Whether points lie in a volume, but for rounding.
fn holds(volume: &Local, points: &[Vec3]) -> bool {
    points.iter().all(|&point| {
        let offset = (point - volume.center).abs();
        match volume.form {
            Form::Box => offset.cmple(volume.half + 1e-5).all(),
            Form::Sphere => offset.length() <= volume.half.x + 1e-5,
        }
    })
}

#[test]
fn every_box_of_a_level_is_inside_one_of_the_level_above() {
    for structure in [Structure::Boxes4, Structure::Boxes2] {
        let packed = packed(&scene(structure, None), PackedScene::default());
        let mesh = &packed.meshes[0];
        let mut above = level_of_mesh(mesh, Level::Depth(1));
        assert!((2..=4).contains(&above.len()), "{structure:?}");
        for depth in 2..=Level::DEEPEST {
            let level = level_of_mesh(mesh, Level::Depth(depth));
            assert!(level.len() <= 4 * above.len());
            for volume in &level {
                let corners = [volume.center - volume.half, volume.center + volume.half];
                let is_inside = above.iter().any(|parent| holds(parent, &corners));
                assert!(is_inside, "{structure:?}, level {depth}: {volume:?}");
            }
            above = level;
        }
    }
}

#[test]
fn leaves_of_every_structure_hold_every_triangle() {
    for structure in STRUCTURES {
        let packed = packed(&scene(structure, None), PackedScene::default());
        let mesh = &packed.meshes[0];
        let leaves = level_of_mesh(mesh, Level::Leaves);
        for triangle in &mesh.triangles {
            let corners = mesh.corners(triangle);
            let is_held = leaves.iter().any(|leaf| holds(leaf, &corners));
            assert!(is_held, "{structure:?}: {triangle:?}");
        }
        let forms = [Form::Box, Form::Sphere];
        let [boxes, spheres] = forms.map(|f| leaves.iter().filter(|l| l.form == f).count());
        match structure {
            Structure::Boxes4 | Structure::Boxes2 => assert!(boxes > 100 && spheres == 0),
            Structure::Spheres { .. } => assert!(spheres > 100 && boxes == 0),
            Structure::None => assert_eq!((boxes, spheres), (TRIANGLES, 0)),
        }
    }
}

#[test]
fn all_trees_are_shown_in_place_or_one_alone() {
    let packed = packed(
        &scene(Structure::Spheres { leaf: 2 }, None),
        PackedScene::default(),
    );
    let all = packed.hierarchy(Level::Depth(1), None, 100);
    assert_eq!((all.boxes, all.spheres, all.is_cut), (3, 4, false));
    assert_eq!(all.volumes.len(), 7);
    let alone = packed.hierarchy(Level::Depth(1), Some(2), 100);
    assert_eq!((alone.boxes, alone.spheres), (0, 2));
    assert!(
        alone
            .volumes
            .iter()
            .all(|v| v.owner == Owner::Mesh(2) && v.center.x > 0.0)
    );
    // What has no tree of its own is shown among all.
    assert_eq!(packed.hierarchy(Level::Depth(1), Some(1), 100), all);
}

#[test]
fn too_many_are_cut_to_those_that_look_largest() {
    let packed = packed(&scene(Structure::Boxes4, None), PackedScene::default());
    let all = packed.hierarchy(Level::Leaves, None, 10_000);
    let few = packed.hierarchy(Level::Leaves, None, 20);
    assert!(!all.is_cut && few.is_cut);
    assert_eq!(all.boxes, few.boxes);
    let sizes = |shown: &Hierarchy| {
        let sizes = shown.volumes.iter();
        let mut sizes: Vec<f32> = sizes.map(|v| v.radius() / v.center.length()).collect();
        sizes.sort_by(|a, b| b.total_cmp(a));
        sizes
    };
    assert_eq!(sizes(&few), sizes(&all)[..20]);
}

#[test]
fn volumes_are_relative_to_the_eye_and_those_behind_it_are_left_out() {
    let mut scene = scene(Structure::Boxes2, None);
    let mut here = packed(&scene, PackedScene::default());
    let before = here.hierarchy(Level::Depth(2), None, 100);
    let step = DVec3::new(0.5, -0.25, 1.0);
    scene.view.origin += step;
    here.pack(&scene, &TraceSettings::default());
    let after = here.hierarchy(Level::Depth(2), None, 100);
    assert_eq!(before.volumes.len(), after.volumes.len());
    for owner in [Owner::Instances, Owner::Mesh(0), Owner::Mesh(2)] {
        let [a, b] = [&before, &after].map(|shown| {
            let volumes = shown.volumes.iter();
            volumes.filter(move |v| v.owner == owner).map(|v| v.center)
        });
        for (a, b) in a.zip(b) {
            assert!(((a - b) - step.as_vec3()).length() < 1e-4, "{owner:?}");
        }
    }
    scene.view.forward = DVec3::Z;
    here.pack(&scene, &TraceSettings::default());
    let behind = here.hierarchy(Level::Depth(2), None, 100);
    assert_eq!(behind.boxes, before.boxes);
    assert_eq!(behind.volumes, []);
}

#[test]
fn what_a_device_deforms_is_shown_deformed() {
    let keys = |values: Vec<Vec3>| {
        Arc::new(VertexSets {
            vertices: 3 * TRIANGLES,
            values,
        })
    };
    let rest = soup().positions;
    let bent = rest
        .iter()
        .map(|p| Vec3::new(p.x, p.y + p.x * p.x, 0.5 * p.z));
    let deformation = Arc::new(Deformation {
        steps: vec![DeformStep::Keys {
            keys: keys(bent.collect()),
            from: 0,
            to: 0,
            share: 0.0,
        }],
    });
    for structure in STRUCTURES {
        let mut both = [PackedScene::default(), PackedScene::for_device()];
        let mut frame = scene(structure, None);
        for packed in &mut both {
            packed.refit(&frame);
            packed.pack(&frame, &TraceSettings::default());
        }
        let mut mesh = frame.meshes[0].clone();
        mesh.deformation = Some(Arc::clone(&deformation));
        frame.meshes.replace(0, mesh);
        let [host, device] = both.map(|scene| packed(&frame, scene));
        for level in [Level::Depth(3), Level::Leaves] {
            let [host, device] = [&host, &device].map(|p| level_of_mesh(&p.meshes[0], level));
            assert_eq!(host.len(), device.len());
            for (a, b) in host.iter().zip(&device) {
                let off = (a.center - b.center).length() + (a.half - b.half).length();
                assert!(off < 1e-5, "{structure:?}, {level}: {a:?} for {b:?}");
            }
        }
    }
}
