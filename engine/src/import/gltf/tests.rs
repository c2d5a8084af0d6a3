//! Known values on small files written here, refusals with their places, and files broken by chance.

use std::path::Path;

mod broken;
mod refused;

use glam::{DQuat, DVec3, Vec3};

use super::*;
use crate::import::Content;
use crate::world::{Channel, Interpolation, Projection, Reflection};

/// A binary file of a document without its `asset` and `buffers`, and the bytes of the one buffer.
fn glb(json: &str, bytes: &[u8]) -> Vec<u8> {
    let buffers = format!("\"buffers\":[{{\"byteLength\":{}}}]", bytes.len());
    let mut json = format!("{{\"asset\":{{\"version\":\"2.0\"}},{buffers},{json}}}").into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    container(&json, bytes)
}

fn container(json: &[u8], bytes: &[u8]) -> Vec<u8> {
    let total = 28 + json.len() + bytes.len();
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend((total as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", bytes)] {
        file.extend((chunk.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    file
}

fn read(bytes: &[u8]) -> Result<Model, String> {
    read_gltf(bytes, Path::new(""))
}

fn floats(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// A file of the corpus.
fn corpus(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/corpus/gltf");
    std::fs::read(folder.join(name)).unwrap()
}

/// One mesh of one primitive over `count` positions that begin the buffer, with more of the primitive.
fn one_mesh(count: usize, primitive: &str, accessors: &str, views: &str) -> String {
    format!(
        "\"nodes\":[{{\"mesh\":0}}],\"meshes\":[{{\"primitives\":[{{\"attributes\":{{\"POSITION\":0}}{primitive}}}]}}],
        \"accessors\":[{{\"bufferView\":0,\"componentType\":5126,\"count\":{count},\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[9,9,9]}}{accessors}],
        \"bufferViews\":[{{\"buffer\":0,\"byteLength\":{}}}{views}]",
        12 * count
    )
}

/// Corners of a zigzag.
const ZIGZAG: [f32; 15] = [
    0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 2.0, 0.0,
];

#[test]
fn triangles_strips_and_fans_face_the_same_way() {
    let bytes = floats(&ZIGZAG);
    let of_mode = |mode: u32| {
        let json = one_mesh(5, &format!(",\"mode\":{mode}"), "", "");
        let model = read(&glb(&json, &bytes)).unwrap();
        model.parts.first().map(|part| part.mesh.triangles.clone())
    };
    assert_eq!(of_mode(4), Some(vec![[0, 1, 2]]), "the rest is no triangle");
    assert_eq!(of_mode(5), Some(vec![[0, 1, 2], [1, 3, 2], [2, 3, 4]]));
    assert_eq!(of_mode(6), Some(vec![[1, 2, 0], [2, 3, 0], [3, 4, 0]]));
    assert_eq!(of_mode(1), None, "lines");
}

#[test]
fn vertices_that_no_triangle_uses_are_left_out() {
    let mut bytes = floats(&ZIGZAG);
    bytes.extend([4, 2, 3, 3, 3, 1, 0, 1, 77]);
    let indices = ",{\"bufferView\":1,\"componentType\":5121,\"count\":9,\"type\":\"SCALAR\"}";
    let view = ",{\"buffer\":0,\"byteOffset\":60,\"byteLength\":9}";
    let json = one_mesh(5, ",\"indices\":1", indices, view);
    let model = read(&glb(&json, &bytes)).unwrap();
    let part = &model.parts[0];
    assert_eq!(part.mesh.triangles, [[2, 0, 1]]);
    assert_eq!(
        part.mesh.vertices,
        [DVec3::Y, DVec3::new(1.0, 1.0, 0.0), DVec3::Y * 2.0]
    );
    assert_eq!(part.sources, [2, 3, 4]);
    let told = model.warnings.sentences();
    assert!(
        told[0].starts_with("meshes[0].primitives[0]: 1 triangles name vertices"),
        "{told:?}"
    );
}

#[test]
fn the_scene_of_the_corpus_is_read_as_it_is_written() {
    let model = read(&corpus("scene.gltf")).unwrap();
    let named = |name: &str| model.nodes.iter().find(|node| node.name == name).unwrap();
    let group = named("group");
    assert_eq!(group.pose.scale, DVec3::new(-2.0, 2.0, 2.0));
    assert_eq!(group.pose.translation, DVec3::new(1.0, 2.0, 3.0));
    assert!(group.pose.rotation.abs_diff_eq(DQuat::IDENTITY, 1e-12));
    let skewed = named("skewed");
    assert_eq!(skewed.pose.translation, -DVec3::Z);
    assert_eq!(
        skewed.shear.unwrap().0.matrix3.y_axis,
        DVec3::new(0.5, 1.0, 0.0)
    );
    assert_eq!(model.nodes.len(), 8);
    assert!(
        model
            .nodes
            .iter()
            .enumerate()
            .all(|(row, node)| node.parent.is_none_or(|p| p < row))
    );

    let pane = &model.parts[0].mesh;
    assert_eq!(
        pane.normals,
        [Vec3::Z; 4],
        "bytes that stand for shares, four apart"
    );
    assert_eq!(
        model.parts[1].mesh.triangles,
        [[1, 2, 0], [2, 3, 0]],
        "a fan without indices"
    );
    assert_eq!(
        model.parts[2].mesh.vertices[2],
        DVec3::new(2.0, 2.0, 0.0),
        "a sparse value"
    );
    assert_eq!(named("pane").contents.len(), 2);

    let material = |name: &str| model.materials.iter().find(|(n, _)| n == name).unwrap().1;
    let glass = material("glass");
    assert_eq!((glass.filter, glass.reflection), (0.9, Reflection::Fresnel));
    assert!((glass.ior - 1.4).abs() < 1e-6 && glass.diffuse == 1.0);
    assert!(glass.specular.is_some_and(|lobe| lobe.exponent == 2000.0));
    let lamp = material("lamp");
    assert_eq!((lamp.color, lamp.emission), (Vec3::new(1.0, 0.5, 0.0), 4.0));
    let plain = material("default material");
    assert_eq!(
        (plain.color, plain.diffuse),
        (Vec3::ONE, 1.0),
        "rough metal scatters"
    );

    let mut lights = (0, 0, 0);
    for content in model.contents() {
        match content {
            Content::Point(light) => {
                lights.0 += 1;
                // 20 candela, 2 m away.
                let fade = light.fade.unwrap();
                let found = f64::from(light.intensity) * fade.factor(2.0);
                let expected = 20.0 / std::f64::consts::PI / 4.0;
                assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
            }
            Content::Spot(light) => {
                lights.1 += 1;
                assert!(
                    (light.inner_angle - 0.2).abs() < 1e-6
                        && (light.outer_angle - 0.5).abs() < 1e-6
                );
            }
            Content::Directional(light) => {
                lights.2 += 1;
                assert!((light.intensity - 3.0 / std::f32::consts::PI).abs() < 1e-6);
            }
            Content::Camera(camera) => match camera.projection {
                Projection::Perspective { vertical_fov } => {
                    assert!((vertical_fov - 0.8).abs() < 1e-6)
                }
                Projection::Orthographic { height } => assert_eq!(height, 3.0),
            },
            Content::Part { .. } | Content::Solid { .. } => {}
        }
    }
    assert_eq!(lights, (1, 1, 1));

    let [clip] = model.clips.as_slice() else {
        panic!("{:?}", model.clips);
    };
    assert_eq!((clip.start, clip.end), (0.0, 1.0));
    let track = &clip.tracks[0];
    assert_eq!(
        (track.channel, track.interpolation),
        (Channel::Scale, Interpolation::Step)
    );
    assert_eq!(model.nodes[track.target].name, "pane");
    assert_eq!(model.warnings.sentences(), Vec::<String>::new());
}

#[test]
fn the_skin_of_the_corpus_is_bound_and_moves() {
    let model = read(&corpus("skin.glb")).unwrap();
    let part = &model.parts[0];
    let binding = part.binding.as_ref().unwrap();
    assert_eq!(binding.highest_joint(), 1);
    assert_eq!(binding.weights[0], [1.0, 0.0, 0.0, 0.0]);
    let [most, rest, ..] = binding.weights[2];
    assert!((most - 128.0 / 255.0).abs() < 1e-6 && (most + rest - 1.0).abs() < 1e-6);
    let morph = part.morph.as_ref().unwrap();
    assert_eq!(morph.weights, [0.5]);
    assert_eq!(morph.targets.set(0)[2], Vec3::new(0.0, 0.0, 0.5));
    let joints = &model.skins[0];
    assert_eq!(joints.joint_from_mesh[1].translation, -DVec3::Y);
    let named = |row: &usize| model.nodes[*row].name.as_str();
    assert_eq!(
        joints.nodes.iter().map(named).collect::<Vec<_>>(),
        ["hip", "knee"]
    );

    let clip = &model.clips[0];
    assert_eq!((clip.name.as_str(), clip.end), ("bend", 1.5));
    let at = |channel, secs| {
        let track = clip
            .tracks
            .iter()
            .find(|track| track.channel == channel)
            .unwrap();
        let mut out = Vec::new();
        track.sample(secs, &mut out);
        out
    };
    // The key has the other sign; the way there is the short one.
    let turn = DQuat::from_slice(&at(Channel::Rotation, 0.25));
    assert!(turn.dot(DQuat::from_rotation_z(0.6)).abs() > 1.0 - 1e-6);
    // Hermite over half a second: from 0 with velocity z to (0.5, 0, 0.25) with velocity x.
    let place = DVec3::from_slice(&at(Channel::Translation, 0.25));
    let expected = DVec3::new(0.25, 0.0, 0.125) + (DVec3::Z - DVec3::X) * 0.5 / 8.0;
    assert!(place.abs_diff_eq(expected, 1e-7), "{place} {expected}");
    assert_eq!(at(Channel::Weights, 1.0), [0.625]);
}

#[test]
fn of_many_joints_the_four_heaviest_stay() {
    let mut bytes = floats(&ZIGZAG[..9]);
    for joints in [[0_u8, 1, 2, 3], [4, 5, 0, 0]] {
        bytes.extend(joints.repeat(3));
    }
    bytes.extend(floats(&[0.1, 0.2, 0.05, 0.2].repeat(3)));
    bytes.extend(floats(&[0.3, 0.15, 0.0, 0.0].repeat(3)));
    let accessor = |view: u32, kind: u32, shape: &str, count: u32| {
        format!(
            ",{{\"bufferView\":{view},\"componentType\":{kind},\"count\":{count},\"type\":\"{shape}\"}}"
        )
    };
    let accessors: String = (1..5)
        .map(|view| accessor(view, if view < 3 { 5121 } else { 5126 }, "VEC4", 3))
        .collect();
    let views: String = [(36, 12), (48, 12), (60, 48), (108, 48)]
        .map(|(at, length)| {
            format!(",{{\"buffer\":0,\"byteOffset\":{at},\"byteLength\":{length}}}")
        })
        .concat();
    let json = one_mesh(3, "", &accessors, &views).replace(
        "\"POSITION\":0",
        "\"POSITION\":0,\"JOINTS_0\":1,\"JOINTS_1\":2,\"WEIGHTS_0\":3,\"WEIGHTS_1\":4",
    );
    let model = read(&glb(&json, &bytes)).unwrap();
    let binding = model.parts[0].binding.as_ref().unwrap();
    assert_eq!(binding.joints[1], [4, 1, 3, 5]);
    for (weight, expected) in binding.weights[1].iter().zip([0.3, 0.2, 0.2, 0.15]) {
        assert!((weight - expected / 0.85).abs() < 1e-6);
    }
    let told = model.warnings.sentences().concat();
    assert!(told.contains("without up to 15 % of the weight"), "{told}");
}

#[test]
fn circles_and_second_places_of_nodes_end() {
    let json = "\"scene\":0,\"scenes\":[{\"nodes\":[0,3]}],
        \"nodes\":[{\"children\":[1]},{\"children\":[2]},{\"children\":[0,1]},{\"children\":[2]}]";
    let model = read(&glb(json, &[])).unwrap();
    assert_eq!(model.nodes.len(), 4);
    assert_eq!(model.warnings.sentences().len(), 3);
    let chain: Vec<String> = (1..5000)
        .map(|i| format!("{{\"children\":[{i}]}}"))
        .collect();
    let json = format!("\"nodes\":[{},{{}}]", chain.join(","));
    let model = read(&glb(&json, &[])).unwrap();
    assert_eq!(model.nodes.len(), 1024);
}
