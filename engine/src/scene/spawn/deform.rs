//! Deformations of spawned meshes: poses of files to vertex sets, shared by all who name the same files.

use std::collections::HashMap;
use std::sync::Arc;

use bevy_ecs::prelude::*;
use bevy_reflect::prelude::*;
use glam::{DVec3, Vec3};

use super::Spawner;
use crate::scene::resolve::{MeshKey, PoseKey, mesh_key};
use crate::scene::schema::{At, Deform, MeshFile};
use crate::world::{KeyFrames, MeshId, Meshes, Morph, VertexSets};

/// The files that an entity's [`KeyFrames`] and [`Morph`] came from, as the scene file has them.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct PoseFiles {
    /// Poses of the key frames.
    pub keys: Vec<String>,
    /// Morph targets.
    pub morph: Vec<String>,
}

/// Vertex sets of a part by the mesh, its part, the files, and whether they are offsets.
type SetsKey = (MeshKey, usize, Vec<String>, bool);

/// Poses that were read, and the sets made of them.
#[derive(Default)]
pub struct Poses {
    pub read: HashMap<PoseKey, Vec<Vec<DVec3>>>,
    pub made: HashMap<SetsKey, Arc<VertexSets>>,
}

fn paths(files: &[At<String>]) -> Vec<String> {
    files.iter().map(|file| file.value.clone()).collect()
}

/// The files of a deformation, if it names any.
pub fn files_of(deform: &Deform) -> Option<PoseFiles> {
    let files = PoseFiles {
        keys: deform
            .keys
            .as_ref()
            .map_or(Vec::new(), |keys| paths(&keys.poses)),
        morph: deform
            .morph
            .as_ref()
            .map_or(Vec::new(), |morph| paths(&morph.targets)),
    };
    (files != PoseFiles::default()).then_some(files)
}

impl Spawner {
    /// Deforms part number `part` of a mesh file, which `target` shows as `id`.
    pub(super) fn deform(
        &mut self,
        world: &mut World,
        target: Entity,
        deform: &Deform,
        (file, part, id): (&MeshFile, usize, MeshId),
    ) {
        if let Some(keys) = &deform.keys {
            let keys = KeyFrames {
                keys: self.sets(world, file, part, id, (&keys.poses, false)),
                times: keys.times.clone(),
                start: keys.start,
                speed: keys.speed,
                repeat: keys.repeat,
            };
            world.entity_mut(target).insert(keys);
        }
        if let Some(morph) = &deform.morph {
            let morph = Morph {
                targets: self.sets(world, file, part, id, (&morph.targets, true)),
                weights: morph.weights.clone(),
            };
            world.entity_mut(target).insert(morph);
        }
        deform_by_formula(world, target, deform);
    }

    /// The poses of files, relative to the mesh's origin or as offsets from its rest.
    fn sets(
        &mut self,
        world: &World,
        file: &MeshFile,
        part: usize,
        id: MeshId,
        (files, are_offsets): (&[At<String>], bool),
    ) -> Arc<VertexSets> {
        let mesh_key = mesh_key(&file.path.value, file.smooth_angle);
        let key = (mesh_key.clone(), part, paths(files), are_offsets);
        if let Some(made) = self.poses.made.get(&key) {
            return Arc::clone(made);
        }
        let Some(mesh) = world
            .get_resource::<Meshes>()
            .and_then(|meshes| meshes.get(id))
        else {
            return Arc::default();
        };
        let mut values: Vec<Vec3> = Vec::new();
        for path in &key.2 {
            let pose = self.poses.read.get(&(mesh_key.clone(), path.clone()));
            let Some(pose) = pose.and_then(|parts| parts.get(part)) else {
                continue;
            };
            values.extend(pose.iter().zip(&mesh.vertices).map(|(place, rest)| {
                let from = if are_offsets { *rest } else { mesh.origin };
                (*place - from).as_vec3()
            }));
        }
        let sets = Arc::new(VertexSets {
            vertices: mesh.vertices.len(),
            values,
        });
        self.poses.made.insert(key, Arc::clone(&sets));
        sets
    }
}

/// The deformers that need no file.
pub(super) fn deform_by_formula(world: &mut World, target: Entity, deform: &Deform) {
    let mut entity = world.entity_mut(target);
    if let Some(wave) = deform.wave {
        entity.insert(wave);
    }
    if let Some(twist) = deform.twist {
        entity.insert(twist);
    }
}
