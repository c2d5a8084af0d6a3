//! What can be added to a scene: any shape, light, camera, a material, a group.

use std::path::PathBuf;

use bevy_ecs::prelude::*;
use glam::{DQuat, DVec3, Vec3};

use super::document::Asked;
use super::history::{Command, Value};
use super::{Document, EditQueue, EditorState, Wish, theme};
use crate::frame::FrameScene;
use crate::world::{
    Camera, Cone, Cuboid, Cylinder, DirectionalLight, Disc, Lobe, Material, Plane, PointLight,
    Polygon, Sphere, SpotLight, Torus, Transform, Visibility,
};

/// How far before the eye new things come to be, in world units.
const DISTANCE: f64 = 6.0;

/// A kind of thing.
pub struct Kind {
    /// What menus call it, and what its id begins with.
    pub name: &'static str,
    make: fn() -> Vec<Value>,
}

macro_rules! kind {
    ($name:literal, $($part:expr),+) => {
        Kind { name: $name, make: || vec![$(Box::new($part)),+] }
    };
}

/// All that can be added, by group.
pub const KINDS: [(&str, &[Kind]); 3] = [
    (
        "Shapes",
        &[
            kind!("sphere", Sphere::default()),
            kind!("box", Cuboid::default()),
            kind!("plane", Plane::default()),
            kind!("disc", Disc::default()),
            kind!("cylinder", Cylinder::default()),
            kind!("cone", Cone::default()),
            kind!("torus", Torus::default()),
            kind!("polygon", Polygon::default()),
        ],
    ),
    (
        "Lights",
        &[
            kind!("point light", PointLight::default()),
            kind!("spot light", SpotLight::default()),
            kind!("sun", DirectionalLight::default()),
        ],
    ),
    (
        "Others",
        &[
            kind!("camera", Camera::default()),
            kind!("group", Transform::IDENTITY, Visibility::default()),
            kind!("material", material()),
        ],
    ),
];

/// Matt with a highlight: something to begin with.
fn material() -> Material {
    Material {
        color: Vec3::splat(0.7),
        specular: Some(Lobe::default()),
        ..Material::default()
    }
}

impl Kind {
    /// The command that adds one before the eye.
    pub fn command(&self, world: &World) -> Command {
        let mut parts = (self.make)();
        if self.name != "material" {
            let pose: Value = Box::new(self.pose(world));
            parts.retain(|part| !part.as_any().is::<Transform>());
            parts.push(pose);
        }
        Command::Spawn {
            name: self.name.into(),
            parent: None,
            parts,
        }
    }

    /// Shapes and lights stand upright before the eye; a plane is level, what looks looks as the eye does.
    fn pose(&self, world: &World) -> Transform {
        let Some(scene) = world.get_resource::<FrameScene>() else {
            return Transform::IDENTITY;
        };
        let view = scene.view;
        let place = view.origin + view.forward * DISTANCE;
        match self.name {
            "plane" => Transform::IDENTITY,
            "camera" => Transform::looking_at(view.origin, place, DVec3::Y),
            "spot light" | "sun" => Transform {
                rotation: DQuat::from_rotation_x(-60_f64.to_radians()),
                ..Transform::from_translation(place)
            },
            _ => Transform::from_translation(place),
        }
    }
}

/// The wish for a model's file before the eye.
pub fn model(world: &World, file: PathBuf) -> Wish {
    let scene = world.resource::<Document>().base.join("scene.ron");
    let pose = world.get_resource::<FrameScene>().map(|scene| {
        Transform::from_translation(scene.view.origin + scene.view.forward * DISTANCE)
    });
    Wish::Do {
        command: Command::Model {
            file,
            scene,
            pose: pose.unwrap_or_default(),
        },
        name: None,
        group: None,
    }
}

/// The menu of what can be added.
pub fn menu(ui: &mut egui::Ui, world: &mut World) {
    for (group, kinds) in KINDS {
        ui.label(theme::faint(group));
        for kind in kinds {
            let name = kind.name;
            let title = name[..1].to_uppercase() + &name[1..];
            let button = egui::Button::new(title).min_size(egui::vec2(140.0, 0.0));
            if ui.add(button).clicked() {
                let command = kind.command(world);
                world.resource_mut::<EditQueue>().push(command);
                ui.close();
            }
        }
        ui.add_space(4.0);
    }
    if ui.button("Model file\u{2026}").clicked() {
        world.resource_mut::<Document>().asked = Some(Asked {
            typed: String::new(),
            adds: true,
        });
        world.resource_mut::<EditorState>().adding = false;
        ui.close();
    }
}
