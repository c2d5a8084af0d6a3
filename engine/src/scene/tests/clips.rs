//! Clips of a scene file: what is read and written, what is refused.

use glam::DQuat;

use super::*;
use crate::scene::schema::ClipFile;
use crate::time::Clock;
use crate::world::{ClipLayer, Loop, Transform, Wave};

fn clips_of(clip: &str) -> Vec<ClipFile> {
    let text = format!("(version: 1, entities: [(mesh: \"a.obj\", clip: {clip})])");
    let scene = parse(&text, Path::new("f.ron")).unwrap_or_else(|problems| panic!("{problems}"));
    let written = Writer::text_of(&scene);
    assert_eq!(parse(&written, Path::new("f.ron")).unwrap(), scene);
    scene.entities[0].clips.clone()
}

#[test]
fn clips_are_a_name_a_record_or_a_list() {
    let run = ClipFile {
        name: Some("Run".to_owned().into()),
        layer: ClipLayer::default(),
    };
    assert_eq!(clips_of("\"Run\""), std::slice::from_ref(&run));
    assert_eq!(clips_of("()"), [ClipFile::default()]);
    let walk = ClipFile {
        name: Some("Walk".to_owned().into()),
        layer: ClipLayer {
            start: 0.5,
            speed: -2.0,
            weight: 0.25,
            repeat: Loop::PingPong,
            paused: true,
            ..ClipLayer::default()
        },
    };
    let record =
        "(name: \"Walk\", start: 0.5, speed: -2, weight: 0.25, loop: PingPong, paused: true)";
    assert_eq!(clips_of(record), std::slice::from_ref(&walk));
    assert_eq!(clips_of(&format!("[\"Run\", {record}]")), [run, walk]);
}

#[test]
fn clips_that_make_no_sense_say_why() {
    for (fields, expected) in [
        ("sphere: (), clip: \"Run\"", "a mesh beside it"),
        ("mesh: \"a.obj\", clip: 3", "a clip's name in quotes"),
        (
            "mesh: \"a.obj\", clip: (weight: -1)",
            "clip.weight: found -1",
        ),
        ("mesh: \"a.obj\", clip: (sped: 1)", "did you mean `speed`?"),
        (
            "mesh: \"two_triangles.ron\", clip: \"Run\"",
            "cannot be used",
        ),
    ] {
        let text = format!("(version: 1, entities: [({fields})])");
        let found = check_text(&text, &assets().join("f.ron"))
            .problems
            .to_string();
        assert!(
            found.contains(expected),
            "{found}\nshould contain {expected}"
        );
    }
    let text = "(version: 1, entities: [(id: \"m\", mesh: \"../models/spot.obj\", clip: \"Run\")],
        timeline: (tracks: [(target: \"m\", field: \"clip.1.weight\", keys: [(0, 1)])]))";
    let found = check_text(text, &assets().join("f.ron"))
        .problems
        .to_string();
    assert!(
        found.contains("unknown clip `Run`; expected one that is there (no clip is)"),
        "{found}"
    );
    assert!(
        found.contains("`m` has no clip, so no field `clip.1.weight`"),
        "{found}"
    );
}

/// A model with the clip `bend`, as scenes in the folder of the assets name it.
const RIBBON: &str = "../../tests/corpus/gltf/skin.glb";

fn played(entity: &str, timeline: &str) -> Engine {
    let text = format!(
        "(version: 1, entities: [(id: \"m\", mesh: \"{RIBBON}\", {entity})], timeline: ({timeline}))"
    );
    let mut engine = Engine::new();
    load_text(&mut engine.world, &text, &assets().join("f.ron"))
        .unwrap_or_else(|problems| panic!("{problems}"));
    engine
}

/// Where a node of the model is at a frame.
fn node(engine: &mut Engine, name: &str, frame: u64) -> Transform {
    engine.world.insert_resource(Clock::Frame(frame));
    engine.frame();
    let mut query = engine.world.query::<(&Name, &Transform)>();
    let mut found = query.iter(&engine.world);
    *found.find(|(n, _)| n.as_str() == name).expect("a node").1
}

#[test]
fn an_entity_plays_the_clip_it_names_and_saves_it() {
    let mut rests = played("visible: true", "");
    let at_rest = node(&mut rests, "knee", 15);
    assert_eq!(at_rest, node(&mut rests, "knee", 30));
    let mut plays = played("clip: \"bend\"", "");
    let bent = node(&mut plays, "knee", 15);
    assert_eq!(bent.translation, at_rest.translation);
    let turn = DQuat::from_rotation_z(1.2);
    assert!(bent.rotation.dot(turn).abs() > 1.0 - 1e-6, "{bent:?}");
    // 45 frames long, over and over; then held at its half second.
    assert_eq!(node(&mut plays, "knee", 60), bent);
    let mut held = played("clip: (name: \"bend\", start: 0.5, paused: true)", "");
    assert_eq!(node(&mut held, "knee", 7), bent);
    for engine in [&mut rests, &mut plays, &mut held] {
        let saved = save(&mut engine.world);
        load_text(&mut engine.world, &saved, &assets().join("f.ron")).unwrap();
        assert_eq!(save(&mut engine.world), saved);
    }
    assert!(save(&mut plays.world).contains("clip: \"bend\""));
}

#[test]
fn the_timeline_scrubs_and_fades_clips() {
    let mut plays = played("clip: \"bend\"", "");
    let bent = node(&mut plays, "hip", 15);
    let track = |field: &str, keys: &str| {
        format!("tracks: [(target: \"m\", field: \"{field}\", keys: [{keys}])]")
    };
    let scrub = track("clip.start", "(0, 1), (1, 0)");
    let mut scrubbed = played("clip: (name: \"bend\", speed: 0)", &scrub);
    assert_eq!(node(&mut scrubbed, "hip", 15), bent);
    let fade = track("clip.1.weight", "(0, 0), (1, 1)");
    let still = "clip: [(name: \"bend\", weight: 0), (name: \"bend\", start: 0.5, paused: true, weight: 0)]";
    let mut faded = played(still, &fade);
    let rest = node(&mut faded, "hip", 0);
    let half = node(&mut faded, "hip", 15);
    let expected = rest.translation.lerp(bent.translation, 0.5);
    assert!(half.translation.abs_diff_eq(expected, 1e-12), "{half:?}");
    assert_eq!(node(&mut faded, "hip", 30).translation, bent.translation);
}

#[test]
fn the_timeline_deforms_a_part_that_is_below_its_entity() {
    let grow = "tracks: [(target: \"m\", field: \"deform.wave.length\", keys: [(0, 2), (1, 4)])]";
    let mut engine = played("deform: (wave: (length: 9))", grow);
    let mut length = |frame| {
        engine.world.insert_resource(Clock::Frame(frame));
        engine.frame();
        let mut waves = engine.world.query::<&Wave>();
        waves.single(&engine.world).expect("one wave").length
    };
    assert_eq!((length(0), length(15), length(30)), (2.0, 3.0, 4.0));
}

#[test]
fn a_name_that_the_model_has_not_is_refused() {
    let text = format!("(version: 1, entities: [(mesh: \"{RIBBON}\", clip: \"bent\")])");
    let found = check_text(&text, &assets().join("f.ron"))
        .problems
        .to_string();
    assert!(
        found.contains("unknown clip `bent`; expected one of `bend`; did you mean `bend`?"),
        "{found}"
    );
}
