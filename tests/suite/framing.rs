//! Model files without a camera: what they do stays in the picture, and fills it.

use std::path::Path;

use glam::{DMat3, UVec2};
use orrery_engine::Engine;
use orrery_engine::frame::{FrameScene, TraceSettings};
use orrery_engine::time::Clock;

use crate::animated::vertices_of;

/// How far out in the picture a model reaches while it plays: 1 at the edge.
fn reach(path: &Path, size: UVec2) -> f64 {
    let mut engine = Engine::new();
    orrery_engine::scene::load(&mut engine.world, path)
        .unwrap_or_else(|problems| panic!("{problems}"));
    engine.world.insert_resource(TraceSettings {
        size,
        ..TraceSettings::default()
    });
    let mut farthest = 0.0_f64;
    let mut origin = None;
    for frame in (0..150).step_by(5) {
        engine.world.insert_resource(Clock::Frame(frame));
        engine.frame();
        let view = engine.world.resource::<FrameScene>().view;
        let stands = *origin.get_or_insert(view.origin);
        assert_eq!(stands, view.origin, "the eye stands still");
        let picture_from_world = DMat3::from_cols(view.right, view.up, view.forward).inverse();
        for vertex in vertices_of(&mut engine.world) {
            let seen = picture_from_world * (vertex - view.origin);
            assert!(seen.z > 0.0, "{vertex} is behind the eye");
            farthest = farthest.max(2.0 * (seen / seen.z).truncate().abs().max_element());
        }
    }
    farthest
}

fn fills(path: &Path) {
    for size in [UVec2::new(160, 90), UVec2::new(90, 120)] {
        let out = reach(path, size);
        let name = path.display();
        assert!(out < 1.0, "{name} leaves the picture of {size}: {out}");
        assert!(out > 0.8, "{name} is small in the picture of {size}: {out}");
    }
}

#[test]
fn the_corpus_fills_the_picture_while_it_plays() {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/gltf");
    fills(&corpus.join("skin.glb"));
}

#[test]
fn models_of_others_fill_the_picture_while_they_play() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes");
    for file in [
        "gltf-ccby/Fox.glb",
        "gltf-ccby/RiggedFigure/RiggedFigure.gltf",
        "gltf-cc0/AnimatedMorphCube/AnimatedMorphCube.gltf",
        "ufbx-fbx/maya_game_sausage_7500_binary_wiggle.fbx",
    ] {
        let path = scenes.join(file);
        if path.is_file() {
            fills(&path);
        } else {
            eprintln!("skipped: there is no {file} in {}", scenes.display());
        }
    }
}
