//! Saving and loading again changes no bit.

use glam::{DAffine3, DMat3, DVec3};

use super::components::{
    camera, color, deform, light, material, motion, rotation, shape, size, structure, vector,
};
use super::*;
use crate::scene::schema::{self as s, Ease, Key, KeyValue, LookAt, Loop, Pose, Scene, Track};
use crate::world::*;

fn entity(chance: &mut Chance, ids: &mut Vec<String>, materials: usize, depth: usize) -> s::Entity {
    let id = format!("thing \"{}\"\n", ids.len());
    ids.push(id.clone());
    let children = if depth == 0 { 0 } else { chance.below(3) };
    let shape = chance.one_in(2).then(|| shape(chance));
    let has_triangles = matches!(shape, Some(s::Shape::Polygon(_)));
    s::Entity {
        id: Some(id.into()),
        name: chance.one_in(3).then(|| "a name \\ \u{7}".to_owned()),
        hidden: chance.one_in(5),
        pose: Pose {
            transform: Transform {
                translation: vector(chance),
                rotation: rotation(chance).quat(),
                scale: vector(chance),
            },
            shear: chance.one_in(3).then(|| {
                let m = DMat3::from_cols(vector(chance), vector(chance), vector(chance));
                Shear(DAffine3::from_mat3_translation(m, vector(chance)))
            }),
        },
        shape,
        deform: if has_triangles {
            deform(chance)
        } else {
            s::Deform::default()
        },
        clips: Vec::new(),
        structure: (has_triangles && chance.one_in(2)).then(|| structure(chance)),
        motion: motion(chance),
        material: chance
            .one_in(2)
            .then(|| format!("m{}", chance.below(materials)).into()),
        light: chance.one_in(3).then(|| light(chance)),
        camera: chance.one_in(4).then(|| camera(chance)),
        children: (0..children)
            .map(|_| entity(chance, ids, materials, depth - 1))
            .collect(),
    }
}

fn keys(chance: &mut Chance, value: impl Fn(&mut Chance) -> KeyValue) -> Vec<Key> {
    let mut time = 0.0;
    (0..1 + chance.below(4))
        .map(|_| {
            time += size(chance);
            let ease = [
                Ease::Step,
                Ease::Linear,
                Ease::In,
                Ease::Out,
                Ease::InOut,
                Ease::Smooth,
            ];
            Key {
                time,
                value: value(chance),
                ease: ease[chance.below(6)],
            }
        })
        .collect()
}

fn timeline(chance: &mut Chance, ids: &[String]) -> s::Timeline {
    let repeat = |chance: &mut Chance| [Loop::Once, Loop::Repeat, Loop::PingPong][chance.below(3)];
    let mut tracks = Vec::new();
    for id in ids {
        if chance.one_in(2) {
            tracks.push(Track {
                target: id.clone().into(),
                field: "transform.rotation".to_owned().into(),
                keys: keys(chance, |chance| KeyValue::Rotation(rotation(chance))),
                repeat: repeat(chance),
            });
        }
        if chance.one_in(2) {
            tracks.push(Track {
                target: id.clone().into(),
                field: "visible".to_owned().into(),
                keys: keys(chance, |chance| KeyValue::Bool(chance.one_in(2))),
                repeat: repeat(chance),
            });
        }
    }
    // A look and a track of the rotation would both turn the entity.
    let turned = |id: &String| {
        let mut tracks = tracks.iter();
        tracks.any(|track| track.target.value == *id && track.field.value == "transform.rotation")
    };
    let paths = ids.iter().take(chance.below(2)).map(|id| s::Path {
        target: id.clone().into(),
        keys: keys(chance, |chance| KeyValue::Vec3(vector(chance))),
        look_at: (!turned(id) && chance.one_in(2)).then(|| LookAt::Point(vector(chance))),
        up: vector(chance) + DVec3::splat(0.5e8),
        repeat: repeat(chance),
    });
    let paths = paths.collect::<Vec<_>>();
    s::Timeline {
        length: chance.one_in(2).then(|| size(chance)),
        tracks,
        paths,
    }
}

/// Plain or not.
fn background(chance: &mut Chance) -> Background {
    if chance.one_in(2) {
        return color(chance).into();
    }
    Background {
        zenith: color(chance),
        horizon: color(chance),
        ground: color(chance),
        ..Background::default()
    }
}

fn random_scene(chance: &mut Chance) -> Scene {
    let materials: Vec<_> = (0..1 + chance.below(4))
        .map(|i| (format!("m{i}").into(), material(chance).into()))
        .collect();
    let mut ids = Vec::new();
    let entities: Vec<_> = (0..chance.below(5))
        .map(|_| entity(chance, &mut ids, materials.len(), 3))
        .collect();
    let mut timeline = timeline(chance, &ids);
    let mut pending: Vec<&s::Entity> = entities.iter().collect();
    while let Some(entity) = pending.pop() {
        // What motion writes, the timeline must not.
        let moves = |target: &s::At<String>, field: &str| {
            Some(target) == entity.id.as_ref() && entity.motion.writes(field)
        };
        let tracks = &mut timeline.tracks;
        tracks.retain(|track| !moves(&track.target, &track.field.value));
        let fields = ["transform.translation", "transform.rotation"];
        let paths = &mut timeline.paths;
        paths.retain(|path| !fields.iter().any(|field| moves(&path.target, field)));
        pending.extend(&entity.children);
    }
    Scene {
        background: background(chance).into(),
        max_generations: 1 + chance.below(64) as u32,
        active_camera: ids
            .first()
            .filter(|_| chance.one_in(2))
            .map(|id| id.clone().into()),
        timeline,
        materials,
        entities,
    }
}

fn text_of(scene: &Scene) -> String {
    let mut writer = Writer::pretty();
    scene.write(&mut writer);
    writer.finish() + "\n"
}

#[test]
fn random_scenes_come_back_bit_for_bit() {
    for seed in 1..=300 {
        let scene = random_scene(&mut Chance(seed * 0x9E37_79B9));
        let text = text_of(&scene);
        let mut world = World::new();
        load_text(&mut world, &text, Path::new("f.ron"))
            .unwrap_or_else(|problems| panic!("seed {seed}: {problems}\n{text}"));
        let again = describe(&mut world);
        assert_eq!(again, scene, "seed {seed}\n{text}");
        // The text holds the shortest digits of every number, so equal text is equal bits.
        assert_eq!(save(&mut world), text, "seed {seed}");
    }
}

#[test]
fn the_ron_crate_reads_what_is_saved() {
    let options = ron::Options::default();
    for seed in 1..=50 {
        let text = text_of(&random_scene(&mut Chance(seed * 0x9E37_79B9)));
        let value: Result<ron::Value, _> = options.from_str(&text);
        assert!(value.is_ok(), "seed {seed}: {value:?}\n{text}");
    }
}

#[test]
fn loading_replaces_what_was_there() {
    let mut world = World::new();
    let text = "(version: 1, background: 0.5, materials: {\"a\": ()},
        entities: [(id: \"x\", material: \"a\", polygon: (), children: [(sphere: ())])],
        timeline: (tracks: [(target: \"x\", field: \"visible\", keys: [(0, true)])]))";
    load_text(&mut world, text, Path::new("f.ron")).unwrap();
    let first = save(&mut world);
    load_text(&mut world, &first, Path::new("f.ron")).unwrap();
    assert_eq!(
        save(&mut world),
        first,
        "the text is stable after the first save"
    );
    load_text(&mut world, "(version: 1)", Path::new("f.ron")).unwrap();
    assert_eq!(save(&mut world), "(version: 1)\n");
    assert_eq!(world.query::<&SceneId>().iter(&world).count(), 0);
}

#[test]
fn a_scene_with_problems_leaves_the_world_alone() {
    let mut world = World::new();
    let path = Path::new("f.ron");
    load_text(&mut world, "(version: 1, entities: [(id: \"x\")])", path).unwrap();
    assert!(load_text(&mut world, "(version: 1, entities: [(id: 3)])", path).is_err());
    assert!(save(&mut world).contains("\"x\""));
}
