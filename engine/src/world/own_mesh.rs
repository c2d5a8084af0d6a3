//! Keeps [`OwnMesh`] and its row in [`Meshes`] in step with what makes an entity's mesh its own: a [`Polygon`], a
//! deformer, a [`Structure`].
//!
//! Deformers apply in this order, whatever order they were added in: [`KeyFrames`], [`Morph`], [`Skin`], [`Wave`],
//! [`Twist`]. The row shares the triangles of the entity's mesh; only its deformation is its own. A deformation
//! that comes out equal is no change. Where nothing changed and time stands still, nothing is looked at but a
//! tick a table; joints of skins are asked one by one.

use std::sync::Arc;

use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use super::polygon::POLYGON;
use super::{
    DeformStep, Deformation, GlobalTransform, KeyFrames, Mesh, MeshData, MeshRow, Meshes, Morph,
    OwnMesh, Polygon, Skin, Structure, Twist, Wave, any_changed, triangulate,
};
use crate::time::Time;

/// All that an own mesh is made from.
type Sources<'a> = (
    Entity,
    Option<&'a OwnMesh>,
    Option<&'a Mesh>,
    Option<Ref<'a, Polygon>>,
    Option<&'a Structure>,
    Option<&'a KeyFrames>,
    Option<&'a Morph>,
    Option<&'a Skin>,
    Option<&'a Wave>,
    Option<&'a Twist>,
);

type Own = Or<(
    With<OwnMesh>,
    With<Polygon>,
    With<Structure>,
    With<KeyFrames>,
    With<Morph>,
    With<Skin>,
    With<Wave>,
    With<Twist>,
)>;

type Timed = Or<(With<KeyFrames>, With<Wave>, With<Twist>)>;

/// What tells that a source changed without looking at entities.
#[derive(SystemParam)]
pub struct Watch<'w, 's> {
    polygons: Query<'w, 's, Ref<'static, Polygon>>,
    structures: Query<'w, 's, Ref<'static, Structure>>,
    keys: Query<'w, 's, Ref<'static, KeyFrames>>,
    morphs: Query<'w, 's, Ref<'static, Morph>>,
    skins: Query<'w, 's, Ref<'static, Skin>>,
    waves: Query<'w, 's, Ref<'static, Wave>>,
    twists: Query<'w, 's, Ref<'static, Twist>>,
    meshes: Query<'w, 's, Ref<'static, Mesh>, Own>,
}

impl Watch<'_, '_> {
    fn any_changed(&self) -> bool {
        any_changed(&self.polygons)
            || any_changed(&self.structures)
            || any_changed(&self.keys)
            || any_changed(&self.morphs)
            || any_changed(&self.skins)
            || any_changed(&self.waves)
            || any_changed(&self.twists)
            || any_changed(&self.meshes)
    }
}

/// Entities that lost a source.
#[derive(SystemParam)]
pub struct Lost<'w, 's> {
    polygons: RemovedComponents<'w, 's, Polygon>,
    structures: RemovedComponents<'w, 's, Structure>,
    keys: RemovedComponents<'w, 's, KeyFrames>,
    morphs: RemovedComponents<'w, 's, Morph>,
    skins: RemovedComponents<'w, 's, Skin>,
    waves: RemovedComponents<'w, 's, Wave>,
    twists: RemovedComponents<'w, 's, Twist>,
    meshes: RemovedComponents<'w, 's, Mesh>,
}

impl Lost<'_, '_> {
    fn read(&mut self) -> impl Iterator<Item = Entity> {
        self.polygons
            .read()
            .chain(self.structures.read())
            .chain(self.keys.read())
            .chain(self.morphs.read())
            .chain(self.skins.read())
            .chain(self.waves.read())
            .chain(self.twists.read())
            .chain(self.meshes.read())
    }
}

type ChangedSource = Or<(
    Changed<Polygon>,
    Changed<Structure>,
    Changed<KeyFrames>,
    Changed<Morph>,
    Changed<Skin>,
    Changed<Wave>,
    Changed<Twist>,
    Changed<Mesh>,
)>;

/// What the system remembers.
#[derive(Default)]
pub struct Memory {
    /// Bits of the seconds that deformations were last evaluated at.
    secs: Option<u64>,
    /// Version of the meshes after the last run; another one says that somebody replaced a mesh.
    meshes: u64,
    /// Entities already reported for a source that does not fit.
    reported: EntityHashSet,
}

/// Derives own meshes; runs after propagation, which it reads joints from.
#[allow(clippy::too_many_arguments)] // change, removal, time and joints are each told in their own way
pub fn derive_own_meshes(
    mut commands: Commands,
    mut memory: Local<Memory>,
    mut meshes: ResMut<Meshes>,
    time: Res<Time>,
    watch: Watch,
    mut lost: Lost,
    changed: Query<Entity, (Own, ChangedSource)>,
    timed: Query<Entity, Timed>,
    skinned: Query<(Entity, &Skin)>,
    poses: Query<Ref<GlobalTransform>>,
    sources: Query<Sources, Own>,
) {
    let secs = time.secs;
    let mut touched: Vec<Entity> = lost.read().collect();
    if meshes.rows().version() != memory.meshes {
        touched.extend(sources.iter().map(|source| source.0));
    } else if watch.any_changed() {
        touched.extend(&changed);
    }
    if memory.secs.replace(secs.to_bits()) != Some(secs.to_bits()) {
        touched.extend(&timed);
    }
    for (entity, skin) in &skinned {
        let moved = |&e: &Entity| poses.get(e).map_or(true, |pose| pose.is_changed());
        if moved(&entity) || skin.joints.iter().any(moved) {
            touched.push(entity);
        }
    }
    if touched.is_empty() {
        return;
    }
    touched.sort_unstable();
    touched.dedup();
    for entity in touched {
        let Ok(source) = sources.get(entity) else {
            memory.reported.remove(&entity);
            continue;
        };
        let own = source.1.copied();
        let pose = |e: Entity| poses.get(e).ok().map(|pose| pose.0);
        match row_of(&source, &meshes, secs, pose, &mut memory.reported) {
            Some(row) => write(&mut commands, &mut meshes, entity, own, row),
            None if own.is_some() => drop(commands.entity(entity).remove::<OwnMesh>()),
            None => {}
        }
    }
    memory.meshes = meshes.rows().version();
}

/// The row that an entity's sources make, if they make one.
fn row_of(
    source: &<Sources<'_> as bevy_ecs::query::QueryData>::Item<'_, '_>,
    meshes: &Meshes,
    secs: f64,
    pose: impl Fn(Entity) -> Option<glam::DAffine3>,
    reported: &mut EntityHashSet,
) -> Option<MeshRow> {
    let (entity, own, mesh, polygon, structure, keys, morph, skin, wave, twist) = source;
    let mut problems: Vec<String> = Vec::new();
    let data = match (mesh, polygon) {
        (Some(mesh), _) => Arc::clone(meshes.get(mesh.0)?),
        (None, Some(polygon)) => match own {
            // Unless the row may be that of a mesh the entity had: those come from a file, or have a name.
            Some(own) if !polygon.is_changed() && was_cut(meshes.get(own.0)?) => {
                Arc::clone(meshes.get(own.0)?)
            }
            _ => Arc::new(triangulate(polygon).unwrap_or_else(|why| {
                problems.push(why);
                MeshData::default()
            })),
        },
        (None, None) => return None,
    };
    let (vertices, extent) = (data.vertices.len(), data.extent);
    let steps = [
        keys.map(|keys| keys.step(secs, vertices)),
        morph.map(|morph| morph.step(vertices)),
        skin.map(|skin| skin.step(vertices, pose(*entity).unwrap_or_default(), &pose)),
        wave.map(|wave| wave.step(secs, extent)),
        twist.map(|twist| twist.step(secs, extent)),
    ];
    let is_own = polygon.is_some() || structure.is_some() || steps.iter().any(Option::is_some);
    let steps: Vec<DeformStep> = steps
        .into_iter()
        .flatten()
        .filter_map(|step| step.map_err(|why| problems.push(why)).ok())
        .collect();
    if problems.is_empty() {
        reported.remove(entity);
    } else if reported.insert(*entity) {
        let why = problems.join("; ");
        tracing::warn!("part of the mesh of {entity} is left out: {why}");
    }
    is_own.then(|| MeshRow {
        data,
        deformation: (!steps.is_empty()).then(|| Arc::new(Deformation { steps })),
        structure: structure.copied().unwrap_or_default(),
    })
}

/// Whether a mesh is a polygon's triangles.
fn was_cut(mesh: &MeshData) -> bool {
    mesh.name == POLYGON && mesh.path.is_empty()
}

/// Puts a row into the store, unless it is there already.
fn write(
    commands: &mut Commands,
    meshes: &mut ResMut<Meshes>,
    entity: Entity,
    own: Option<OwnMesh>,
    row: MeshRow,
) {
    let Some(OwnMesh(id)) = own else {
        let id = meshes.add(row);
        commands.entity(entity).insert(OwnMesh(id));
        return;
    };
    let is_there = meshes.rows().get(id.0 as usize).is_some_and(|old| {
        Arc::ptr_eq(&old.data, &row.data)
            && old.deformation == row.deformation
            && old.structure == row.structure
    });
    if !is_there {
        meshes.replace(id, row);
    }
}

#[cfg(test)]
mod tests;
