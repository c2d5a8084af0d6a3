//! What structures are compared on: scenes that come along, and a large mesh made by code.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy_ecs::prelude::{Entity, Or, With};
use glam::{DAffine3, DVec3, UVec2};
use orrery_engine::Engine;
use orrery_engine::frame::{FrameScene, Shape, View};
use orrery_engine::profile;
use orrery_engine::trace::Picture;
use orrery_engine::world::{
    Camera, Mesh, MeshData, Meshes, PointLight, Polygon, Structure, Transform,
};

use crate::args::{BenchRequest, Common};
use crate::bench::hills::hills;
use crate::failure::Failure;
use crate::stage;

/// Scenes of the report's kind.
const SCENES: [&str; 3] = ["spheres_36", "polygons_35", "mirrors_21"];
/// All, in the order of rows; the last two are meshes made by code.
pub const NAMES: [&str; 5] = [SCENES[0], SCENES[1], SCENES[2], "small_hills", "hills"];
/// Triangles of the small one: as many as are traced without a structure.
const FEW_TRIANGLES: usize = 1000;
/// Triangles of the large one.
const TRIANGLES: usize = 100_000;
/// The same for a look within seconds.
const SMALL_TRIANGLES: usize = 4000;
/// Size of pictures unless asked otherwise: frames of the CPU tracer take a while.
const SIZE: UVec2 = UVec2::new(512, 384);
/// The same for a look within seconds.
const SMALL_SIZE: UVec2 = UVec2::new(32, 24);
/// Frame numbers a second of scene time.
const FRAMES_PER_SEC: f64 = 30.0;

/// A scene, and what is in it at the measured frame.
pub struct Stage {
    /// As rows are called.
    pub name: &'static str,
    /// Of pictures.
    pub size: UVec2,
    /// The scene's own; each once.
    pub meshes: Vec<Arc<MeshData>>,
    /// Mesh, and world from the mesh's own space.
    pub instances: Vec<(usize, DAffine3)>,
    /// The eye.
    pub view: View,
    source: Source,
    frame: u64,
}

enum Source {
    File(PathBuf),
    Hills(usize),
}

/// All that are measured; those without meshes among them.
pub fn all(request: &BenchRequest, common: &Common) -> Result<Vec<Stage>, Failure> {
    let (triangles, size) = if request.small {
        (SMALL_TRIANGLES, SMALL_SIZE)
    } else {
        (TRIANGLES, SIZE)
    };
    let scenes = SCENES.map(|name| (name, Source::File(PathBuf::from(name))));
    let made = [
        (NAMES[3], Source::Hills(FEW_TRIANGLES)),
        (NAMES[4], Source::Hills(triangles)),
    ];
    let mut stages = Vec::new();
    for (name, source) in scenes.into_iter().chain(made) {
        let mut stage = Stage {
            name,
            size: common.size.unwrap_or(size),
            meshes: Vec::new(),
            instances: Vec::new(),
            view: View::default(),
            source,
            frame: request.frame,
        };
        stage.look(common)?;
        stages.push(stage);
    }
    Ok(stages)
}

impl Stage {
    /// An engine with the scene, every mesh and polygon of it under this structure, at the measured frame; no
    /// tracer.
    pub fn engine(&self, structure: Structure, common: &Common) -> Result<Engine, Failure> {
        let mut engine = match &self.source {
            Source::File(scene) => scene_engine(scene, common, self.size)?,
            Source::Hills(triangles) => hills_engine(*triangles, common, self.size)?,
        };
        let world = &mut engine.world;
        let mut shapes = world.query_filtered::<Entity, Or<(With<Mesh>, With<Polygon>)>>();
        let shapes: Vec<Entity> = shapes.iter(world).collect();
        for shape in shapes {
            world.entity_mut(shape).insert(structure);
        }
        stage::advance(&mut engine, self.frame)?;
        Ok(engine)
    }

    /// The picture of the measured frame, as the engine stands.
    pub fn picture(&self, engine: &mut Engine) -> Result<Picture, Failure> {
        stage::picture(engine, self.frame)
    }

    fn look(&mut self, common: &Common) -> Result<(), Failure> {
        let engine = self.engine(Structure::default(), common)?;
        let scene = engine.world.resource::<FrameScene>();
        self.view = scene.view;
        for instance in scene.instances.iter() {
            let Shape::Mesh(row) = instance.shape else {
                continue;
            };
            let data = &scene.meshes[row as usize].data;
            let known = self.meshes.iter().position(|mesh| Arc::ptr_eq(mesh, data));
            let mesh = known.unwrap_or_else(|| {
                self.meshes.push(Arc::clone(data));
                self.meshes.len() - 1
            });
            self.instances.push((mesh, instance.world_from_local));
        }
        Ok(())
    }
}

fn scene_engine(scene: &Path, common: &Common, size: UVec2) -> Result<Engine, Failure> {
    stage::set(scene, common, size, FRAMES_PER_SEC)
}

/// A field of hills before a camera, under a lamp.
fn hills_engine(triangles: usize, common: &Common, size: UVec2) -> Result<Engine, Failure> {
    let mut engine = Engine::new();
    engine.add_plugin(profile::plugin);
    let world = &mut engine.world;
    world.insert_resource(stage::settings(common, size));
    let field = hills(triangles).map_err(Failure::Input)?;
    let field = world.resource_mut::<Meshes>().add(field);
    world.spawn((Transform::IDENTITY, Mesh(field)));
    let middle = DVec3::new(0.5, 0.0, 0.5);
    let eye = Transform::looking_at(DVec3::new(0.5, 0.45, 1.5), middle, DVec3::Y);
    world.spawn((eye, Camera::default()));
    let lamp = Transform::from_translation(DVec3::new(-1.0, 1.0, 0.0));
    world.spawn((lamp, PointLight::default()));
    Ok(engine)
}
