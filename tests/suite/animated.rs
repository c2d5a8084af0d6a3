//! What animates really moves: bounds in the world of what plays, against an evaluation of the files written here.

use std::path::{Path, PathBuf};

use bevy_ecs::prelude::*;
use glam::{DMat4, DQuat, DVec3, DVec4};
use orrery_engine::Engine;
use orrery_engine::time::Clock;
use orrery_engine::world::{DeformStep, GlobalTransform, Mesh, Meshes, OwnMesh};
use serde_json::Value;

/// A glTF file as JSON and bytes; understands just what the files below use.
struct Gltf {
    json: Value,
    bytes: Vec<u8>,
}

impl Gltf {
    fn open(path: &Path) -> Self {
        let whole = std::fs::read(path).expect("a file that is there");
        if !whole.starts_with(b"glTF") {
            let json: Value = serde_json::from_slice(&whole).expect("JSON");
            let uri = json["buffers"][0]["uri"]
                .as_str()
                .expect("a buffer beside the file");
            let bytes = std::fs::read(path.with_file_name(uri)).expect("a buffer");
            return Self { json, bytes };
        }
        let length = u32::from_le_bytes(whole[12..16].try_into().expect("4 bytes")) as usize;
        Self {
            json: serde_json::from_slice(&whole[20..20 + length]).expect("JSON"),
            bytes: whole[28 + length..].to_vec(),
        }
    }

    /// The elements of an accessor.
    fn rows(&self, index: &Value) -> Vec<Vec<f64>> {
        let accessor = &self.json["accessors"][size(index)];
        let view = &self.json["bufferViews"][size(&accessor["bufferView"])];
        let width = match accessor["type"].as_str() {
            Some("SCALAR") => 1,
            Some("VEC3") => 3,
            Some("VEC4") => 4,
            Some("MAT4") => 16,
            other => panic!("{other:?}"),
        };
        let kind = size(&accessor["componentType"]);
        let bytes = [(5121, 1), (5123, 2), (5125, 4), (5126, 4)];
        let bytes = bytes.iter().find(|(k, _)| *k == kind).expect("a type").1;
        let share = accessor["normalized"].as_bool() == Some(true);
        let stride = view["byteStride"]
            .as_u64()
            .map_or(bytes * width, |s| s as usize);
        let first = size(&view["byteOffset"]) + size(&accessor["byteOffset"]);
        let number = |at: usize| {
            let b = &self.bytes[at..at + bytes];
            match kind {
                5126 => f64::from(f32::from_le_bytes(b.try_into().expect("4 bytes"))),
                _ => {
                    let whole = b.iter().rev().fold(0_u64, |n, &b| n << 8 | u64::from(b)) as f64;
                    let most = (1_u64 << (8 * bytes)) as f64 - 1.0;
                    if share { whole / most } else { whole }
                }
            }
        };
        (0..size(&accessor["count"]))
            .map(|i| {
                (0..width)
                    .map(|j| number(first + i * stride + j * bytes))
                    .collect()
            })
            .collect()
    }

    /// What the first animation, or all, make of a node's value.
    fn animated(&self, node: usize, path: &str, secs: f64, all: bool) -> Option<Vec<f64>> {
        let animations = list(&self.json["animations"]);
        let length = |animation: &Value| {
            let samplers = list(&animation["samplers"]).iter();
            let ends = samplers.map(|s| self.rows(&s["input"]).last().expect("a key")[0]);
            ends.fold(0.0, f64::max)
        };
        for animation in animations.iter().take(if all { usize::MAX } else { 1 }) {
            for channel in list(&animation["channels"]) {
                let target = &channel["target"];
                if size(&target["node"]) == node && target["path"].as_str() == Some(path) {
                    let sampler = &animation["samplers"][size(&channel["sampler"])];
                    return Some(self.sampled(sampler, path, secs % length(animation)));
                }
            }
        }
        None
    }

    fn sampled(&self, sampler: &Value, path: &str, secs: f64) -> Vec<f64> {
        let times: Vec<f64> = self.rows(&sampler["input"]).concat();
        let numbers = self.rows(&sampler["output"]).concat();
        let cubic = sampler["interpolation"].as_str() == Some("CUBICSPLINE");
        let step = sampler["interpolation"].as_str() == Some("STEP");
        let rows = if cubic { 3 * times.len() } else { times.len() };
        let width = numbers.len() / rows;
        let row = |i: usize| &numbers[i * width..(i + 1) * width];
        let value = |key: usize| row(if cubic { 3 * key + 1 } else { key }).to_vec();
        let Some(a) = times.iter().rposition(|&time| time <= secs) else {
            return value(0);
        };
        if a + 1 == times.len() || step {
            return value(a);
        }
        let length = times[a + 1] - times[a];
        let t = (secs - times[a]) / length;
        let blend = |f: &dyn Fn(usize) -> f64| (0..width).map(f).collect::<Vec<f64>>();
        let (p, q) = (value(a), value(a + 1));
        if cubic {
            // De Casteljau's construction on the Bezier points of the Hermite curve.
            return blend(&|i| {
                let [b, c] = [
                    p[i] + row(3 * a + 2)[i] * length / 3.0,
                    q[i] - row(3 * a + 3)[i] * length / 3.0,
                ];
                let mix = |a: f64, b: f64| a * (1.0 - t) + b * t;
                let [x, y, z] = [mix(p[i], b), mix(b, c), mix(c, q[i])];
                mix(mix(x, y), mix(y, z))
            });
        }
        if path != "rotation" {
            return blend(&|i| p[i] + (q[i] - p[i]) * t);
        }
        // Shoemake's formula, with the sign of the nearer of two ends.
        let dot: f64 = p.iter().zip(&q).map(|(a, b)| a * b).sum();
        let angle = dot.abs().min(1.0).acos();
        if angle < 1e-6 {
            return p;
        }
        let [u, v] = [(1.0 - t) * angle, t * angle].map(|x| x.sin() / angle.sin());
        blend(&|i| p[i] * u + q[i] * v * dot.signum())
    }

    fn local(&self, node: usize, secs: f64, all: bool) -> DMat4 {
        let json = &self.json["nodes"][node];
        if let Some(matrix) = json["matrix"].as_array() {
            let numbers: Vec<f64> = matrix.iter().filter_map(Value::as_f64).collect();
            return DMat4::from_cols_slice(&numbers);
        }
        let value = |path: &str, rest: &[f64]| {
            let given = json[path].as_array();
            let given = given.map(|given| given.iter().filter_map(Value::as_f64).collect());
            self.animated(node, path, secs, all)
                .or(given)
                .unwrap_or(rest.to_vec())
        };
        DMat4::from_scale_rotation_translation(
            DVec3::from_slice(&value("scale", &[1.0; 3])),
            DQuat::from_slice(&value("rotation", &[0.0, 0.0, 0.0, 1.0])).normalize(),
            DVec3::from_slice(&value("translation", &[0.0; 3])),
        )
    }

    fn world_from(&self, node: usize, secs: f64, all: bool) -> DMat4 {
        let nodes = list(&self.json["nodes"]).iter();
        let parent = nodes.into_iter().position(|parent| {
            list(&parent["children"])
                .iter()
                .any(|child| size(child) == node)
        });
        let local = self.local(node, secs, all);
        parent.map_or(local, |parent| self.world_from(parent, secs, all) * local)
    }

    /// Every vertex that a triangle uses, in the world.
    fn vertices(&self, secs: f64, all: bool) -> Vec<DVec3> {
        let mut vertices = Vec::new();
        for (number, node) in list(&self.json["nodes"]).iter().enumerate() {
            if node["mesh"].is_null() {
                continue;
            }
            let mesh = &self.json["meshes"][size(&node["mesh"])];
            let weights = self.animated(number, "weights", secs, all);
            let at_rest = [&node["weights"], &mesh["weights"]].map(list).concat();
            let at_rest = at_rest.iter().filter_map(Value::as_f64).collect();
            let weights: Vec<f64> = weights.unwrap_or(at_rest);
            let skin = &self.json["skins"][node["skin"].as_u64().unwrap_or(99) as usize];
            let carriers: Vec<DMat4> = if skin.is_null() {
                vec![self.world_from(number, secs, all)]
            } else {
                let binds = self.rows(&skin["inverseBindMatrices"]);
                let joints = list(&skin["joints"]).iter().zip(binds);
                joints
                    .map(|(joint, bind)| {
                        self.world_from(size(joint), secs, all) * DMat4::from_cols_slice(&bind)
                    })
                    .collect()
            };
            for primitive in list(&mesh["primitives"]) {
                let attributes = &primitive["attributes"];
                let positions = self.rows(&attributes["POSITION"]);
                let mut used: Vec<usize> = match &primitive["indices"] {
                    Value::Null => (0..positions.len()).collect(),
                    indices => self.rows(indices).iter().map(|i| i[0] as usize).collect(),
                };
                used.sort_unstable();
                used.dedup();
                let targets: Vec<_> = list(&primitive["targets"])
                    .iter()
                    .map(|target| self.rows(&target["POSITION"]))
                    .collect();
                let held = (!skin.is_null()).then(|| {
                    (
                        self.rows(&attributes["JOINTS_0"]),
                        self.rows(&attributes["WEIGHTS_0"]),
                    )
                });
                for i in used {
                    let offsets = targets.iter().zip(&weights);
                    let offsets = offsets.map(|(t, w)| DVec3::from_slice(&t[i]) * *w);
                    let p = DVec3::from_slice(&positions[i]) + offsets.sum::<DVec3>();
                    let p = DVec4::new(p.x, p.y, p.z, 1.0);
                    let moved = match &held {
                        None => carriers[0] * p,
                        Some((joints, weights)) => {
                            let carried = joints[i].iter().zip(&weights[i]);
                            let sum: DVec4 =
                                carried.map(|(&j, &w)| carriers[j as usize] * p * w).sum();
                            sum / sum.w
                        }
                    };
                    vertices.push(moved.truncate());
                }
            }
        }
        vertices
    }
}

fn size(value: &Value) -> usize {
    value.as_u64().unwrap_or(0) as usize
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

/// Every vertex of the engine's frame, in the world: the steps that its tracers get, as they are defined.
pub fn vertices_of(world: &mut World) -> Vec<DVec3> {
    let mut query = world.query::<(&Mesh, Option<&OwnMesh>, &GlobalTransform)>();
    let meshes = world.resource::<Meshes>();
    let mut vertices = Vec::new();
    for (mesh, own, place) in query.iter(world) {
        let row = &meshes.rows()[own.map_or(mesh.0, |own| own.0).0 as usize];
        let steps = row
            .deformation
            .as_ref()
            .map_or(&[][..], |deformation| &deformation.steps);
        for (i, &at_rest) in row.data.vertices.iter().enumerate() {
            let moved = steps.iter().fold(at_rest, |p, step| match step {
                DeformStep::Morph { targets, weights } => {
                    let offsets = (0..).zip(weights);
                    p + offsets
                        .map(|(set, w)| targets.set(set)[i].as_dvec3() * *w)
                        .sum::<DVec3>()
                }
                DeformStep::Skin { binding, joints } => (0..4)
                    .map(|k| {
                        let carried = joints[binding.joints[i][k] as usize].transform_point3(p);
                        carried * f64::from(binding.weights[i][k])
                    })
                    .sum(),
                other => panic!("{other:?}"),
            });
            vertices.push(place.0.transform_point3(moved));
        }
    }
    vertices
}

fn bounds(vertices: &[DVec3]) -> [DVec3; 2] {
    let min = vertices.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    [
        min,
        vertices
            .iter()
            .copied()
            .fold(DVec3::NEG_INFINITY, DVec3::max),
    ]
}

/// Plays a file and holds its vertices against those computed here; says how far it moves, relative to its size.
fn play(path: &Path, all: bool) -> f64 {
    let name = path.display();
    let gltf = Gltf::open(path);
    let mut engine = Engine::new();
    orrery_engine::scene::load(&mut engine.world, path)
        .unwrap_or_else(|problems| panic!("{problems}"));
    let mut seen: Vec<[DVec3; 2]> = Vec::new();
    let mut extent = 0.0_f64;
    for frame in [0, 7, 30, 41, 100, 7] {
        engine.world.insert_resource(Clock::Frame(frame));
        engine.frame();
        let found = vertices_of(&mut engine.world);
        let expected = gltf.vertices(frame as f64 / 30.0, all);
        assert_eq!(found.len(), expected.len(), "{name}");
        let ([a, b], [c, d]) = (bounds(&found), bounds(&expected));
        extent = extent.max((d - c).length());
        for (found, expected) in [(a, c), (b, d)] {
            let apart = found.distance(expected);
            assert!(
                apart <= 1e-5 * extent,
                "{name}, frame {frame}: {found} where {expected} should be"
            );
        }
        seen.push([a, b]);
    }
    assert_eq!(
        seen[1], seen[5],
        "{name}: the same frame is the same to the last bit"
    );
    let moved = seen
        .iter()
        .flat_map(|[a, b]| [a.distance(seen[0][0]), b.distance(seen[0][1])]);
    moved.fold(0.0, f64::max) / extent
}

#[test]
fn the_corpus_plays() {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/gltf");
    assert!(play(&corpus.join("skin.glb"), false) > 0.1);
}

#[test]
fn models_of_others_play() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes");
    for (file, all, moves) in [
        ("gltf-ccby/Fox.glb", false, 0.02),
        ("gltf-ccby/RiggedFigure/RiggedFigure.gltf", false, 0.02),
        ("gltf-cc0/AnimatedCube/glTF/AnimatedCube.gltf", false, 0.02),
        (
            "gltf-cc0/AnimatedMorphCube/AnimatedMorphCube.gltf",
            false,
            0.02,
        ),
        (
            "gltf-cc0/InterpolationTest/glTF/InterpolationTest.gltf",
            true,
            0.001,
        ),
    ] {
        let path: PathBuf = scenes.join(file);
        if path.is_file() {
            let moved = play(&path, all);
            assert!(moved > moves, "{file} moves by {moved} of its size");
        } else {
            eprintln!("skipped: there is no {file} in {}", scenes.display());
        }
    }
}
