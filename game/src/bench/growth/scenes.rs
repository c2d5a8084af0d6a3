//! What grows: scenes made by code, in which something moves in every frame.

use bevy_ecs::prelude::Entity;
use glam::{DVec3, UVec2, Vec3};
use orrery_engine::Engine;
use orrery_engine::frame::TraceSettings;
use orrery_engine::time::Time;
use orrery_engine::world::{
    Camera, Material, Mesh, Meshes, Plane, PointLight, Reflection, Surface, Transform, Wave,
};

use crate::bench::crowd::{Crowd, Kind, Plan, Random, side};
use crate::bench::frame::FRAMES_PER_SEC;
use crate::bench::hills::hills;
use crate::failure::Failure;

/// Things of the scenes in which something else grows.
const THINGS: usize = 100;
/// What the walls of the room reflect.
const MIRRORED: f32 = 0.9;
/// Generations where depth does not grow.
const GENERATIONS: u32 = 4;

/// A quantity that frame time is measured against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Of one mesh, all of which deforms.
    Triangles,
    /// Of one small mesh, all of which move.
    Instances,
    /// Point lights over a crowd.
    Lights,
    /// Generations of rays in a room of mirrors.
    Depth,
    /// Of the picture of a crowd.
    Pixels,
}

impl Quantity {
    /// All, in the order of the report.
    pub const ALL: [Self; 5] = [
        Self::Triangles,
        Self::Instances,
        Self::Lights,
        Self::Depth,
        Self::Pixels,
    ];

    /// In rows and charts.
    pub fn name(self) -> &'static str {
        match self {
            Self::Triangles => "triangles",
            Self::Instances => "instances",
            Self::Lights => "lights",
            Self::Depth => "depth",
            Self::Pixels => "pixels",
        }
    }

    /// The scene of a curve.
    pub fn about(self) -> &'static str {
        match self {
            Self::Triangles => "a field of hills, deformed in every frame, a light",
            Self::Instances => {
                "tetrahedra, all of which move, a light; the more, the more pixels they cover"
            }
            Self::Lights => "100 moving tetrahedra on a floor, point lights above",
            Self::Depth => "100 moving tetrahedra in a room of mirrors, a light",
            Self::Pixels => "1,000 moving tetrahedra, a light",
        }
    }

    /// How many there are at each point of the curve.
    pub fn steps(self, small: bool) -> &'static [usize] {
        match (self, small) {
            (Self::Triangles, false) => &[1000, 10_000, 100_000, 1_000_000, 10_000_000],
            (Self::Triangles, true) => &[100, 1000, 10_000],
            (Self::Instances, false) => &[1, 10, 100, 1000, 10_000, 100_000],
            (Self::Instances, true) => &[1, 10, 100, 1000],
            (Self::Lights, false) => &[1, 2, 4, 8, 16, 32, 64, 128, 256],
            (Self::Lights, true) => &[1, 4, 16],
            (Self::Depth, false) => &[1, 2, 3, 4, 6, 8, 12, 16],
            (Self::Depth, true) => &[1, 2, 4, 16],
            (Self::Pixels, false) => &[160, 320, 640, 1280, 2560],
            (Self::Pixels, true) => &[16, 32, 64],
        }
    }

    /// What the step counts: pixels are told by the width of a picture of 4 to 3.
    pub fn count(self, step: usize) -> usize {
        match self {
            Self::Pixels => step * (step * 3 / 4),
            _ => step,
        }
    }

    /// The scene of a step, without a tracer.
    ///
    /// # Errors
    /// [`Failure::Input`] if the mesh cannot be made.
    pub fn scene(self, step: usize, size: UVec2) -> Result<Engine, Failure> {
        let (mut engine, size) = match self {
            Self::Triangles => (field(step)?, size),
            Self::Instances => (crowd(step), size),
            Self::Lights => (lit(step), size),
            Self::Depth => (room(), size),
            Self::Pixels => {
                let width = step as u32;
                (crowd(10 * THINGS), UVec2::new(width, width * 3 / 4))
            }
        };
        let generations = match self {
            Self::Depth => step as u32,
            _ => GENERATIONS,
        };
        engine.world.insert_resource(TraceSettings {
            size,
            max_generations: Some(generations),
            count_rays: false,
            ..TraceSettings::default()
        });
        Ok(engine)
    }
}

fn crowd(count: usize) -> Engine {
    let plan = Plan {
        count,
        kind: Kind::Meshes,
        moving: true,
        profiled: false,
    };
    Crowd::new(plan).engine
}

/// Hills through which a wave runs.
fn field(triangles: usize) -> Result<Engine, Failure> {
    let mut engine = Engine::new();
    let world = &mut engine.world;
    world.resource_mut::<Time>().frames_per_sec = FRAMES_PER_SEC;
    let mesh = hills(triangles).map_err(Failure::Input)?;
    let mesh = Mesh(world.resource_mut::<Meshes>().add(mesh));
    world.spawn((
        mesh,
        Wave {
            length: 0.3,
            amplitude: DVec3::Y * 0.02,
            ..Wave::default()
        },
        Transform::default(),
    ));
    let eye = DVec3::new(0.5, 0.55, 1.35);
    let view = Transform::looking_at(eye, DVec3::new(0.5, 0.0, 0.5), DVec3::Y);
    world.spawn((view, Camera::default()));
    let lamp = Transform::from_translation(DVec3::new(-1.0, 1.5, 1.0));
    world.spawn((lamp, PointLight::default()));
    Ok(engine)
}

/// A crowd over a floor under so many lights, each as much dimmer as they are more.
fn lit(lights: usize) -> Engine {
    let mut engine = crowd(THINGS);
    let (world, wide) = (&mut engine.world, side(THINGS));
    let lamps: Vec<Entity> = {
        let mut lamps = world.query_filtered::<Entity, bevy_ecs::prelude::With<PointLight>>();
        lamps.iter(world).collect()
    };
    for lamp in lamps {
        world.despawn(lamp);
    }
    world.spawn(Plane {
        distance: -0.6 * wide,
        ..Plane::default()
    });
    let mut random = Random(5);
    for _ in 0..lights {
        let place = random.cube() * DVec3::new(1.0, 0.3, 1.0) + DVec3::Y;
        let light = PointLight {
            intensity: 1.0 / lights as f32,
            ..PointLight::default()
        };
        world.spawn((Transform::from_translation(place * wide), light));
    }
    engine
}

/// A crowd between six mirrors, the camera among them.
fn room() -> Engine {
    let mut engine = crowd(THINGS);
    let (world, wide) = (&mut engine.world, side(THINGS));
    let mirror = world.spawn(Material {
        reflection: Reflection::Constant(Vec3::splat(MIRRORED)),
        diffuse: 1.0 - MIRRORED,
        ..Material::default()
    });
    let mirror = Surface(mirror.id());
    for axis in DVec3::AXES {
        for normal in [axis, -axis] {
            let distance = -2.5 * wide;
            world.spawn((Plane { normal, distance }, mirror));
        }
    }
    engine
}

#[cfg(test)]
mod tests {
    use super::*;
    use orrery_engine::frame::FrameScene;

    #[test]
    fn scenes_have_what_their_steps_say() {
        let size = UVec2::new(8, 6);
        for quantity in Quantity::ALL {
            let step = 4;
            let mut engine = quantity.scene(step, size).expect("a scene");
            engine.frame();
            let scene = engine.world.resource::<FrameScene>();
            let settings = engine.world.resource::<TraceSettings>();
            let counted = match quantity {
                Quantity::Triangles => scene.meshes[0].data.triangles.len(),
                Quantity::Instances => scene.instances.len(),
                Quantity::Lights => scene.lights.len(),
                Quantity::Depth => settings.max_generations.map_or(0, |depth| depth as usize),
                Quantity::Pixels => (settings.size.x * settings.size.y) as usize,
            };
            let expected = match quantity {
                // The largest even square below.
                Quantity::Triangles => 2,
                _ => quantity.count(step),
            };
            assert_eq!(counted, expected, "{quantity:?}");
        }
    }
}
