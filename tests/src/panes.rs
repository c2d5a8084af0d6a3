//! A scene of coloured panes and balls before a wall: transparent shadows under every kind of light.

use glam::{DAffine3, DVec3, Vec3};
use orrery_engine::frame::{Features, FrameScene, Instance, Light, LightKind, Shape};
use orrery_engine::world::{Fade, Material};

/// A wall lit through stacked panes, seen from the front; every kind of light.
pub fn panes() -> FrameScene {
    let mut scene = FrameScene {
        max_generations: 5,
        materials: vec![Material::default()].into(),
        lights: lights().into(),
        ..Default::default()
    };
    scene.view.origin = DVec3::new(0.0, 0.0, 6.0);
    let mut add = |shape, at, material: Material| {
        scene.materials.push(material);
        scene.instances.push(Instance {
            tag: 0,
            shape,
            world_from_local: DAffine3::from_translation(at),
            material: scene.materials.len() as u32 - 1,
        });
    };
    let wall = Shape::Plane {
        normal: DVec3::Z,
        distance: 0.0,
    };
    add(wall, DVec3::ZERO, Material::default());
    let colors = [
        Vec3::new(0.9, 0.5, 0.4),
        Vec3::new(0.4, 0.9, 0.5),
        Vec3::new(0.6, 0.5, 0.9),
    ];
    for (i, color) in colors.into_iter().enumerate() {
        let half = DVec3::new(0.9 - 0.2 * i as f64, 0.8, 0.05);
        let pane = Material {
            color,
            diffuse: 0.0,
            filter: 0.8,
            transmit: 0.1,
            ..Default::default()
        };
        let shape = Shape::Cuboid {
            min: -half,
            max: half,
        };
        add(
            shape,
            DVec3::new(-0.4 + 0.3 * i as f64, 0.2, 1.0 + 0.4 * i as f64),
            pane,
        );
        let ball = Shape::Sphere { radius: 0.3 };
        add(ball, DVec3::new(-1.0 + i as f64, -0.9, 1.2), pane);
    }
    scene.features = Features::of(&scene);
    scene
}

/// A point, a direction and a spot.
fn lights() -> Vec<Light> {
    let fade = Some(Fade {
        distance: 4.0,
        power: 2.0,
        ..Fade::default()
    });
    let position = DVec3::new(0.5, 0.5, 8.0);
    let axis = (DVec3::new(0.2, -0.5, 0.0) - position).normalize();
    vec![
        Light {
            color: Vec3::splat(0.5),
            fade,
            kind: LightKind::Point { position },
        },
        Light {
            color: Vec3::new(0.3, 0.3, 0.2),
            fade: None,
            kind: LightKind::Directional {
                to_light: DVec3::new(0.3, 0.4, 1.0).normalize(),
            },
        },
        Light {
            color: Vec3::splat(0.6),
            fade: None,
            kind: LightKind::Spot {
                position,
                axis,
                cos_inner: 0.99,
                cos_outer: 0.97,
            },
        },
    ]
}
