//! Clips of a scene file: what is read and written, what is refused.

use super::*;
use crate::scene::schema::ClipFile;
use crate::world::{ClipLayer, Loop};

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
