//! Scenes of one kind each, and the kernels written by hand for them.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use orrery_engine::Engine;
use orrery_engine::frame::{FrameScene, TraceSettings};
use orrery_engine::trace::gpu::HandKernel;
use orrery_engine::world::{
    Camera, ColorSpace, Material, Mesh, Meshes, PointLight, Reflection, Sphere, Surface, Texture,
    Transform, Wrap,
};

use crate::bench::crowd::Random;
use crate::bench::hills::hills;
use crate::failure::Failure;

/// Generations where there are mirrors.
const GENERATIONS: u32 = 5;
/// Of the mirrors, all channels.
const MIRRORED: f32 = 0.7;

// SAFETY: its loops walk trees, whose nodes each have one parent, or count to the number of generations.
#[allow(unsafe_code)]
const SPHERES: HandKernel =
    unsafe { HandKernel::new("spheres by hand", include_str!("spheres.wgsl")) };
// SAFETY: its loops walk trees, whose nodes each have one parent, or count a leaf's triangles.
#[allow(unsafe_code)]
const TRIANGLES: HandKernel =
    unsafe { HandKernel::new("triangles by hand", include_str!("triangles.wgsl")) };

/// What a scene is made of, and of nothing else.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Opaque flat triangles.
    Triangles,
    /// Opaque spheres.
    Spheres,
    /// Spheres that mirror.
    Mirrors,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Triangles, Self::Spheres, Self::Mirrors];

    /// In rows.
    pub fn name(self) -> &'static str {
        match self {
            Self::Triangles => "triangles",
            Self::Spheres => "spheres",
            Self::Mirrors => "mirrors",
        }
    }

    /// The kernel by hand.
    pub fn by_hand(self) -> HandKernel {
        match self {
            Self::Triangles => TRIANGLES,
            Self::Spheres | Self::Mirrors => SPHERES,
        }
    }

    /// The scene under one point light. It has a texture that nothing shows: a general pipeline binds one.
    ///
    /// # Errors
    /// [`Failure::Input`] if its mesh or texture cannot be made.
    pub fn scene(self, settings: &TraceSettings, small: bool) -> Result<FrameScene, Failure> {
        let mut engine = Engine::new();
        engine.world.insert_resource(*settings);
        match (self, small) {
            (Self::Triangles, true) => spawn_hills(&mut engine, 2000)?,
            (Self::Triangles, false) => spawn_hills(&mut engine, 200_000)?,
            (Self::Spheres | Self::Mirrors, true) => spawn_spheres(&mut engine, self, 10),
            (Self::Spheres | Self::Mirrors, false) => spawn_spheres(&mut engine, self, 40),
        }
        let eye = DVec3::new(0.5, 0.5, 1.15);
        let view = Transform::looking_at(eye, DVec3::new(0.5, 0.0, 0.6), DVec3::Y);
        engine.world.spawn((view, Camera::default()));
        let lamp = Transform::from_translation(DVec3::new(-0.6, 1.1, 0.9));
        engine.world.spawn((lamp, PointLight::default()));
        engine.frame();
        let mut scene = engine.world.resource::<FrameScene>().clone();
        let unseen = Texture::new("unseen", [1, 1], &[255; 4], ColorSpace::Linear, Wrap::Clamp);
        scene
            .textures
            .push(Arc::new(unseen.map_err(Failure::Input)?));
        if self == Self::Mirrors {
            scene.max_generations = GENERATIONS;
        }
        Ok(scene)
    }
}

fn spawn_hills(engine: &mut Engine, triangles: usize) -> Result<(), Failure> {
    let mesh = hills(triangles).map_err(Failure::Input)?;
    let mesh = engine.world.resource_mut::<Meshes>().add(mesh);
    engine.world.spawn((Mesh(mesh), Transform::default()));
    Ok(())
}

/// A carpet of balls, so many along each edge.
fn spawn_spheres(engine: &mut Engine, kind: Kind, along: u32) {
    let mirrored = match kind {
        Kind::Mirrors => Reflection::Constant(Vec3::splat(MIRRORED)),
        _ => Reflection::None,
    };
    let material = engine.world.spawn(Material {
        reflection: mirrored,
        ..Material::default()
    });
    let material = Surface(material.id());
    let mut random = Random(9);
    let wide = 1.0 / f64::from(along);
    for i in 0..along * along {
        let place = DVec3::new(
            wide * (f64::from(i % along) + 0.5),
            wide * random.between(-1.0, 1.0),
            wide * (f64::from(i / along) + 0.5),
        );
        let ball = Sphere {
            radius: wide * random.between(0.4, 0.6),
        };
        let at = Transform::from_translation(place);
        engine.world.spawn((at, ball, material));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use orrery_engine::frame::Features;
    use orrery_engine::trace::gpu::Specialisation;

    #[test]
    fn scenes_are_of_one_kind_and_their_kernels_compose() {
        for kind in Kind::ALL {
            let scene = kind
                .scene(&TraceSettings::default(), true)
                .expect("a scene");
            let expected = Features {
                meshes: kind == Kind::Triangles,
                spheres: kind != Kind::Triangles,
                instances: kind != Kind::Triangles,
                reflection: kind == Kind::Mirrors,
                ..Features::default()
            };
            assert_eq!(scene.features, expected, "{kind:?}");
            let special = Specialisation::new(scene.features, 5);
            if let Err(why) = kind.by_hand().shader(special) {
                panic!("{kind:?}: {why}");
            }
        }
    }
}
