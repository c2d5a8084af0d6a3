//! The editor as people use it: its panels, and a session from opening a scene to comparing the files it saved.

mod panels;
mod session;

use std::path::Path;

use bevy_ecs::prelude::*;

use crate::scene;

fn load(world: &mut World, text: &str) {
    scene::load_text(world, text, Path::new("test.ron"))
        .unwrap_or_else(|problems| panic!("{problems}"));
}
