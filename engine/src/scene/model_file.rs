//! A model file by itself: the scene that shows it, so that what can be imported can be played.
//!
//! What a model lacks to be seen is added: two lights where nothing shines, and a background that is not black
//! where the file has none. Its first clip plays, with those that move other things. Without a camera the picture shows all there is (see `frame`'s overview).

use std::collections::HashSet;
use std::ffi::OsStr;
use std::path::Path;

use glam::{DVec3, Vec3};

use super::resolve::Resolved;
use super::schema::{ClipFile, Entity, Light, MeshFile, Pose, Scene, Shape};
use crate::import::{Content, Model};
use crate::world::{Background, Clip, DirectionalLight, Transform};

/// Behind models that say nothing of it, linear RGB.
const BACKGROUND: Vec3 = Vec3::new(0.10, 0.11, 0.13);

/// A scene of one entity that shows the model file.
pub fn scene_of(path: &Path) -> Scene {
    let text = |part: Option<&OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    let mesh = MeshFile {
        path: text(path.file_name()).into(),
        smooth_angle: None,
    };
    let entity = Entity {
        id: Some(text(path.file_stem()).into()),
        shape: Some(Shape::Mesh(mesh)),
        ..Entity::default()
    };
    Scene {
        background: Background::from(BACKGROUND).into(),
        entities: vec![entity],
        ..Scene::default()
    }
}

/// Gives the scene of a model what the model says or lacks.
pub fn complete(resolved: &mut Resolved) {
    let models = || resolved.models.values();
    if let Some(background) = models().find_map(|model| model.background) {
        resolved.scene.background = Background::from(background).into();
    }
    let clips = models().flat_map(played).collect();
    if let [entity, ..] = resolved.scene.entities.as_mut_slice() {
        entity.clips = clips;
    }
    if !models().any(shines) {
        let lights = [
            light("key light", [-0.5, 0.9, 0.8], 0.75),
            light("fill light", [0.8, 0.25, 0.6], 0.35),
        ];
        resolved.scene.entities.extend(lights);
    }
}

/// The first clip, and each that moves nothing that those before it move.
fn played(model: &Model) -> Vec<ClipFile> {
    let mut moved = HashSet::new();
    let mut free = |clip: &&Clip| {
        let keys = || {
            clip.tracks
                .iter()
                .map(|track| (track.target, track.channel))
        };
        let free = !keys().any(|key| moved.contains(&key));
        if free {
            moved.extend(keys());
        }
        free
    };
    let clips = model.clips.iter().filter(|clip| free(clip));
    let file = |clip: &Clip| ClipFile {
        name: Some(clip.name.clone().into()),
        ..ClipFile::default()
    };
    clips.map(file).collect()
}

/// Whether there is anything to see by.
pub fn shines(model: &Model) -> bool {
    let worn = |content: &Content| model.materials.get(content.material()?);
    let glows = |content: &Content| worn(content).is_some_and(|(_, m)| m.emission > 0.0);
    model
        .contents()
        .any(|content| content.is_light() || glows(content))
}

/// A light that shines from a direction.
fn light(id: &str, from: [f64; 3], intensity: f32) -> Entity {
    let pose = Transform::looking_at(from.into(), DVec3::ZERO, DVec3::Y);
    Entity {
        id: Some(id.to_owned().into()),
        pose: Pose {
            transform: Transform {
                translation: DVec3::ZERO,
                ..pose
            },
            shear: None,
        },
        light: Some(Light::Directional(DirectionalLight {
            intensity,
            ..DirectionalLight::default()
        })),
        ..Entity::default()
    }
}
