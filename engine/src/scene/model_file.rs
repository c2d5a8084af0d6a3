//! A model file by itself: the scene that shows it, so that what can be imported can be played.
//!
//! What a model lacks to be seen is added: lights where next to none reaches it, and a sky where the file has no
//! background. Its first clip plays, with those that move other things. Without a camera the picture holds all that these
//! will move (see [`super::rehearsal`]).

mod lit;

use std::collections::HashSet;
use std::ffi::OsStr;
use std::path::Path;

use glam::{DVec3, Vec3};

use super::resolve::Resolved;
use super::schema::{ClipFile, Entity, Light, MeshFile, Pose, Scene, Shape};
use crate::import::Model;
use crate::world::{Background, Clip, DirectionalLight, Framing, PointLight, Transform};

/// Behind models that say nothing of it, linear RGB.
const SKY: Background = Background {
    zenith: Vec3::new(0.07, 0.09, 0.13),
    horizon: Vec3::new(0.17, 0.20, 0.24),
    ground: Vec3::new(0.035, 0.037, 0.04),
    picture: None,
    turn: 0.0,
};
/// From where it shines on models that no light of their own reaches, and how much.
const LIGHTS: [(&str, [f64; 3], f32); 3] = [
    ("key light", [-0.6, 1.0, 0.7], 0.7),
    ("fill light", [1.0, 0.2, 0.3], 0.16),
    ("back light", [-0.5, -0.3, -0.6], 0.1),
];
/// What the eye brings along: from there no shadow is seen, so nothing that is seen is black.
const HEAD_LIGHT: f32 = 0.16;
/// Width over height of the picture that the head light stands at the eye of.
const ASPECT: f64 = 16.0 / 9.0;

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
        background: SKY.into(),
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
    let mut framing = Framing::new();
    let is_dark = models().all(|model| lit::is_dark(model, &mut framing));
    if is_dark {
        let lights = LIGHTS.map(|(id, from, intensity)| light(id, from, intensity));
        resolved.scene.entities.extend(lights);
        resolved.scene.entities.push(head_light(&framing));
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

/// A light at the eye that looks at the model.
fn head_light(framing: &Framing) -> Entity {
    let transform = Transform {
        translation: framing.pose(ASPECT).translation,
        ..Transform::IDENTITY
    };
    Entity {
        id: Some("head light".to_owned().into()),
        pose: Pose {
            transform,
            shear: None,
        },
        light: Some(Light::Point(PointLight {
            intensity: HEAD_LIGHT,
            ..PointLight::default()
        })),
        ..Entity::default()
    }
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
