//! Files written by hand, with known values.

use std::f64::consts::FRAC_PI_2;
use std::path::Path;

use glam::{DAffine3, DVec3, Vec3};

use super::read_fbx;
use crate::import::{Content, Model};
use crate::world::{
    Channel, Fade, Lobe, Projection, Reflection, SpotLight, Track, Transform, world_from_local,
};

const MESH: &str = include_str!("../../../../tests/corpus/fbx/mesh.fbx");
const MOVING: &str = include_str!("../../../../tests/corpus/fbx/moving.fbx");
const BONES: &str = include_str!("../../../../tests/corpus/fbx/bones.fbx");

fn read(bytes: &[u8]) -> Result<Model, String> {
    read_fbx(bytes, Path::new(""))
}

fn model(text: &str) -> Model {
    let model = read(text.as_bytes()).unwrap();
    assert_eq!(model.warnings.sentences(), Vec::<String>::new());
    model
}

fn row(model: &Model, name: &str) -> usize {
    let found = model.nodes.iter().position(|node| node.name == name);
    found.unwrap_or_else(|| panic!("no node `{name}`"))
}

/// The map to the world from a node.
fn placed(model: &Model, row: usize) -> DAffine3 {
    let up = |row: &usize| model.nodes[*row].parent;
    let path = std::iter::successors(Some(row), up);
    world_from_local(path.map(|row| (&model.nodes[row].pose, None)))
}

fn parts(model: &Model, row: usize) -> Vec<(usize, Option<usize>)> {
    let contents = model.nodes[row].contents.iter();
    contents
        .filter_map(|content| match *content {
            Content::Part { part, material, .. } => Some((part, material)),
            _ => None,
        })
        .collect()
}

fn close(a: DVec3, b: impl Into<DVec3>) {
    let b = b.into();
    assert!((a - b).length() < 1e-9, "{a} is not {b}");
}

#[test]
fn a_mesh_is_shown_by_two_nodes_with_materials_of_their_own() {
    let model = model(MESH);
    assert_eq!(model.parts.len(), 2, "one a material");
    assert_eq!(model.triangles(), 3, "the quad is cut in two");
    let showing: Vec<usize> = (0..model.nodes.len())
        .filter(|&row| !parts(&model, row).is_empty())
        .collect();
    // `left` has a geometry of its own place, so a node below it shows the mesh.
    let [right, left] = showing.as_slice() else {
        panic!("{showing:?}");
    };
    assert_eq!(parts(&model, *left), [(0, Some(0)), (1, Some(1))]);
    assert_eq!(parts(&model, *right), [(0, Some(1)), (1, Some(0))]);
    assert!(model.nodes[row(&model, "right")].hidden);
    // In the file, with Z up: (corner + (0, 0, 10)) + (1, 2, 3), twice as large, then up by 5.
    let corner = model.parts[0].mesh.vertices[1];
    close(corner, [2.0, 0.0, 0.0]);
    close(
        placed(&model, *left).transform_point3(corner),
        [6.0, 31.0, -4.0],
    );
    close(
        placed(&model, *right).transform_point3(corner),
        [0.0, 5.0, -4.0],
    );
}

#[test]
fn each_line_of_the_table_holds() {
    let model = model(MESH);
    let (name, red) = &model.materials[0];
    assert_eq!(name, "red");
    assert_eq!(red.color, Vec3::new(0.25, 0.125, 0.0));
    let specular = Lobe {
        strength: 0.25,
        exponent: 30.0,
    };
    assert_eq!(red.specular, Some(specular));
    assert_eq!((red.diffuse, red.transmit, red.emission), (1.0, 0.0, 0.0));
    let (_, pane) = &model.materials[1];
    assert_eq!((pane.transmit, pane.filter), (0.75, 0.0));
    assert_eq!(pane.reflection, Reflection::Constant(Vec3::splat(0.25)));
    assert_eq!((pane.diffuse, pane.emission), (0.75, 0.5));
}

#[test]
fn the_views_of_the_editor_are_not_cameras_of_the_scene() {
    let is_camera = |content: &Content| matches!(content, Content::Camera(_));
    let cameras = |text: &str| model(text).contents().filter(|c| is_camera(c)).count();
    assert_eq!(cameras(MOVING), 1);
    let producer = MOVING.replace("Model::eye", "Model::Producer Perspective");
    assert_eq!(cameras(&producer), 0);
}

#[test]
fn cameras_and_lights_look_and_shine_where_they_do_in_the_file() {
    let model = model(MOVING);
    let standing = |wanted: fn(&Content) -> bool| {
        let row = model
            .nodes
            .iter()
            .position(|node| node.contents.iter().any(wanted));
        row.map(|row| (placed(&model, row), model.nodes[row].contents[0].clone()))
            .expect("it is there")
    };
    let (place, content) = standing(|content| matches!(content, Content::Camera(_)));
    close(place.translation, [0.0, 0.0, 9.0]);
    close(place.transform_vector3(DVec3::NEG_Z), [0.0, 0.0, -1.0]);
    let Content::Camera(camera) = content else {
        unreachable!()
    };
    let Projection::Perspective { vertical_fov } = camera.projection else {
        panic!("{:?}", camera.projection);
    };
    assert!(
        (vertical_fov.to_degrees() - 60.0).abs() < 1e-9,
        "{vertical_fov}"
    );
    let (place, content) = standing(|content| matches!(content, Content::Spot(_)));
    close(place.transform_vector3(DVec3::NEG_Z), [0.0, -1.0, 0.0]);
    let Content::Spot(SpotLight {
        color,
        intensity,
        fade,
        outer_angle,
        ..
    }) = content
    else {
        unreachable!()
    };
    assert_eq!((color, intensity), (Vec3::new(1.0, 0.5, 0.25), 2.0));
    assert!((outer_angle.to_degrees() - 30.0).abs() < 1e-9);
    let fade = fade.unwrap();
    assert_eq!(fade, Fade::exact(1.0, 2.0));
    assert!((fade.factor(30.0) * 900.0 - 1.0).abs() < 1e-12);
}

fn track(model: &Model, target: usize, channel: Channel) -> &Track {
    let [clip] = model.clips.as_slice() else {
        panic!("{:?}", model.clips);
    };
    let mut tracks = clip.tracks.iter();
    let found = tracks.find(|track| track.target == target && track.channel == channel);
    found.unwrap_or_else(|| panic!("no {channel:?} of {target} in {clip:?}"))
}

fn at(track: &Track, secs: f64) -> Vec<f64> {
    track.check().unwrap();
    let mut numbers = Vec::new();
    track.sample(secs, &mut numbers);
    numbers
}

#[test]
fn keys_are_where_the_file_has_them() {
    let model = model(MOVING);
    assert_eq!((model.clips[0].start, model.clips[0].end), (0.0, 2.0));
    assert_eq!(model.clips[0].name, "wave");
    let flag = row(&model, "flag");
    let moves = track(&model, flag, Channel::Translation);
    for (secs, x) in [(0.0, 0.0), (0.25, 2.5), (1.0, 10.0), (1.5, 5.0), (9.0, 0.0)] {
        assert!(
            (at(moves, secs)[0] - x).abs() < 1e-9,
            "{secs}: {:?}",
            at(moves, secs)
        );
    }
    assert!(
        moves.times.len() <= 4,
        "straight ways need no samples: {}",
        moves.times.len()
    );
    let shown = track(&model, flag, Channel::Shown);
    assert!(
        at(shown, 0.999)[0] > 0.5 && at(shown, 1.001)[0] < 0.5,
        "{shown:?}"
    );
    let camera = model.nodes.iter().position(|node| {
        node.contents
            .iter()
            .any(|content| matches!(content, Content::Camera(_)))
    });
    let opens = track(&model, camera.unwrap(), Channel::VerticalFov);
    assert!((at(opens, 0.0)[0].to_degrees() - 60.0).abs() < 1e-6);
    assert!((at(opens, 2.0)[0] - FRAC_PI_2).abs() < 1e-6);
}

#[test]
fn bones_hold_vertices_and_shapes_move_them() {
    let model = model(BONES);
    let [part] = model.parts.as_slice() else {
        panic!()
    };
    let binding = part.binding.as_ref().unwrap();
    let of = |vertex: u32| {
        part.sources
            .iter()
            .position(|&source| source == vertex)
            .unwrap()
    };
    assert_eq!(binding.weights[of(2)][..2], [0.75, 0.25]);
    assert_eq!(binding.joints[of(2)][..2], [1, 0]);
    let skin = &model.skins[0];
    let arm = row(&model, "arm");
    assert_eq!(skin.nodes, [row(&model, "low"), row(&model, "high"), arm]);
    assert_eq!(
        binding.joints[of(4)][0],
        2,
        "what no bone holds follows the mesh"
    );
    // At rest every joint leaves vertices where the mesh's node puts them.
    for (&node, &held) in skin.nodes.iter().zip(&skin.joint_from_mesh) {
        let place = (placed(&model, node) * held).transform_point3(DVec3::X);
        close(place, placed(&model, arm).transform_point3(DVec3::X));
    }
    let morph = part.morph.as_ref().unwrap();
    assert_eq!(
        morph.weights,
        [0.5, 0.0],
        "25 % is half of the first of two keys"
    );
    assert_eq!(morph.targets.set(0)[of(1)], Vec3::Z);
    assert_eq!(morph.targets.set(1)[of(1)], Vec3::new(0.0, 0.0, 4.0));
    assert_eq!(morph.targets.set(1)[of(0)], Vec3::ZERO);
    let weights = track(&model, arm, Channel::Weights);
    for (secs, expected) in [(0.25, [0.5, 0.0]), (0.5, [1.0, 0.0]), (0.75, [0.5, 0.5])] {
        let found = at(weights, secs);
        let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f64::max) < 1e-6, "{secs}: {found:?}");
    }
    let turns = at(track(&model, row(&model, "high"), Channel::Rotation), 0.5);
    let turned = Transform {
        rotation: glam::DQuat::from_slice(&turns),
        ..Transform::IDENTITY
    };
    let half = std::f64::consts::FRAC_1_SQRT_2;
    close(
        turned.affine().transform_vector3(DVec3::X),
        [half, half, 0.0],
    );
}

#[test]
fn what_is_no_fbx_is_refused_with_a_reason() {
    for (bytes, reason) in [
        (&b""[..], "it is not a valid FBX file"),
        (b"v 0 0 0\nf 1 1 1\n", "it is not a valid FBX file"),
        (b"; FBX 7.4.0 project file\n", "Truncated file"),
        (
            b"Kaydara FBX Binary  \0\x1a\0\xe8\x1c\0\0",
            "it is not a valid FBX file",
        ),
    ] {
        let why = read(bytes).unwrap_err();
        assert!(why.contains(reason), "{bytes:?}: {why}");
    }
    // An array that says it has more numbers than a machine has memory.
    let huge = MESH.replace("*15", "*4000000000");
    if let Ok(model) = read(huge.as_bytes()) {
        assert_eq!(model.triangles(), 3);
    }
    let flat = MESH.replace("2,0,0,2,1,0", "nan,0,0,2,1,0");
    let why = read(flat.as_bytes()).unwrap_err();
    assert!(
        why.contains("nothing to show") && why.contains("not finite"),
        "{why}"
    );
}
