//! World to [`FrameScene`]: changed rows only, removals first, then structure, then values.
//!
//! A system first asks the tables' summary ticks whether there is anything to look for: where nothing changed,
//! its cost does not depend on how much there is.

mod lights;
mod materials;
mod shapes;

use bevy_ecs::entity::{EntityHashMap, EntityHashSet};
use bevy_ecs::prelude::*;
use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};

use self::lights::extract_lights;
use self::materials::{BRIGHTEST, extract_materials, within};
use self::shapes::{extract_instances, relink_materials, vacate_removed};
use super::overview::overview;
use super::{Features, FrameScene, Instance, Shape, TraceSettings, View, ViewProjection};
use crate::app::Engine;
use crate::schedule::FrameSet;
use crate::world::{
    ActiveCamera, Background, Camera, Changes, Framing, GlobalTransform, GlobalVisibility,
    Material, Meshes, Projection, Textures, TraceDepth, picture_camera,
};

/// Adds extraction.
pub fn plugin(engine: &mut Engine) {
    engine.world.init_resource::<Rows>();
    engine.add_systems(
        FrameSet::Extract,
        (
            extract_materials,
            extract_meshes,
            extract_textures,
            vacate_removed,
            relink_materials,
            extract_instances,
            extract_lights,
            extract_view,
            find_features,
        )
            .chain(),
    );
}

/// Which row an entity has in [`FrameScene::instances`] and [`FrameScene::materials`].
#[derive(Resource, Default)]
struct Rows {
    instances: EntityHashMap<u32>,
    vacant: Vec<u32>,
    materials: EntityHashMap<u32>,
    vacant_materials: Vec<u32>,
    /// Materials that got or lost their row in this frame; shapes that name them are written anew.
    relinked: EntityHashSet,
    /// Entities already reported for a transform that cannot be inverted.
    singular: EntityHashSet,
    /// Materials already reported for numbers that are brought within limits.
    unusable: EntityHashSet,
    /// Something came, went, or changed its shape or material: the scene may need other features.
    restructured: bool,
}

impl Rows {
    /// The row of a material that is there; a vacant one or a new one if it has none yet.
    fn material_row(&mut self, scene: &mut FrameScene, entity: Entity) -> u32 {
        if let Some(&row) = self.materials.get(&entity) {
            return row;
        }
        let row = self
            .vacant_materials
            .pop()
            .unwrap_or_else(|| scene.materials.push(Material::default()));
        self.materials.insert(entity, row);
        self.relinked.insert(entity);
        self.restructured = true;
        row
    }

    fn vacate_material(&mut self, scene: &mut FrameScene, entity: Entity) {
        self.unusable.remove(&entity);
        if let Some(row) = self.materials.remove(&entity) {
            scene.materials.set(row, Material::default());
            self.vacant_materials.push(row);
            self.relinked.insert(entity);
        }
    }

    fn instance_row(&mut self, scene: &mut FrameScene, entity: Entity, row: Instance) {
        let known = self.instances.get(&entity).copied();
        let Some(index) = known.or_else(|| self.vacant.pop()) else {
            self.instances.insert(entity, scene.instances.push(row));
            self.restructured = true;
            return;
        };
        if known.is_none() {
            self.instances.insert(entity, index);
        }
        let old = &scene.instances[index as usize];
        self.restructured |= old.material != row.material || old.shape != row.shape;
        scene.instances.set(index, row);
    }

    fn vacate(&mut self, scene: &mut FrameScene, entity: Entity) {
        self.singular.remove(&entity);
        if let Some(index) = self.instances.remove(&entity) {
            let mut row = scene.instances[index as usize];
            row.shape = Shape::Vacant;
            scene.instances.set(index, row);
            self.vacant.push(index);
            self.restructured = true;
        }
    }
}

/// Whether something bad is to be said of an entity: once, until it is good again.
fn is_news(known: &mut EntityHashSet, entity: Entity, is_bad: bool) -> bool {
    if is_bad {
        known.insert(entity)
    } else {
        known.remove(&entity);
        false
    }
}

fn extract_meshes(
    mut scene: ResMut<FrameScene>,
    meshes: Res<Meshes>,
    mut rows: ResMut<Rows>,
    mut seen: Local<u64>,
) {
    match meshes.rows().changes_since(*seen) {
        Changes::None => return,
        Changes::Rows(changed) if meshes.rows().len() == scene.meshes.len() => {
            for &row in changed {
                let (old, new) = (&scene.meshes[row as usize], &meshes.rows()[row as usize]);
                let is_alike = Arc::ptr_eq(&old.data, &new.data) && old.structure == new.structure;
                rows.restructured |= !is_alike;
                scene.meshes.replace(row, new.clone());
            }
        }
        Changes::Rows(_) | Changes::All => {
            scene.meshes.clone_from(meshes.rows());
            rows.restructured = true;
        }
    }
    *seen = meshes.rows().version();
}

fn extract_textures(
    mut scene: ResMut<FrameScene>,
    textures: Res<Textures>,
    mut rows: ResMut<Rows>,
    mut seen: Local<u64>,
) {
    let version = textures.rows().version();
    if std::mem::replace(&mut *seen, version) != version {
        scene.textures.clone_from(textures.rows());
        rows.restructured = true;
    }
}

fn extract_view(
    mut scene: ResMut<FrameScene>,
    active: Res<ActiveCamera>,
    (background, depth, settings): (Res<Background>, Res<TraceDepth>, Res<TraceSettings>),
    cameras: Query<(Entity, &Camera, &GlobalTransform, &GlobalVisibility)>,
    (rows, framing): (Res<Rows>, Option<Res<Framing>>),
    mut last: Local<Option<(u64, f64)>>,
) {
    let usable = |x: f32| within(x, 0.0, 0.0, BRIGHTEST);
    let background = background.map(|color| Vec3::from(color.to_array().map(usable)));
    if scene.background != background {
        scene.background = background;
        let mut features = scene.features;
        features.find_sky(&scene);
        scene.features = features;
    }
    scene.max_generations = settings.max_generations.unwrap_or(depth.0);
    let aspect = f64::from(settings.size.x) / f64::from(settings.size.y);
    let shown = cameras
        .iter()
        .map(|(entity, .., visible)| (entity, visible.0));
    let chosen = picture_camera(*active, shown).and_then(|entity| cameras.get(entity).ok());
    if let Some((_, camera, transform, _)) = chosen {
        *last = None;
        scene.view = view_of(camera, transform.0, aspect);
        return;
    }
    let of = (scene.instances.version(), aspect);
    if last.replace(of) != Some(of) || rows.restructured {
        scene.view = overview(&scene, framing.as_deref(), aspect);
    }
}

/// The spanned view of a camera at a pose; scale and shear of the pose do not count.
pub(super) fn view_of(camera: &Camera, world_from_local: DAffine3, aspect: f64) -> View {
    let (_, rotation, origin) = world_from_local.to_scale_rotation_translation();
    let (height, projection) = match camera.projection {
        Projection::Perspective { vertical_fov } => (
            2.0 * (0.5 * vertical_fov).tan(),
            ViewProjection::Perspective,
        ),
        Projection::Orthographic { height } => (height, ViewProjection::Orthographic),
    };
    View {
        origin,
        forward: rotation * DVec3::NEG_Z,
        right: rotation * DVec3::X * (height * aspect),
        up: rotation * DVec3::Y * height,
        projection,
        exposure: camera.exposure,
        tone_map: camera.tone_map,
    }
}

fn find_features(mut scene: ResMut<FrameScene>, rows: Res<Rows>, mut lights: Local<u64>) {
    let version = scene.lights.version();
    if rows.restructured || std::mem::replace(&mut *lights, version) != version {
        scene.features = Features::of(&scene);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stays_bad_is_said_once_and_again_after_it_was_good() {
        let (mut known, entity) = (EntityHashSet::default(), Entity::PLACEHOLDER);
        let states = [false, true, true, false, true, true];
        let said = states.map(|is_bad| is_news(&mut known, entity, is_bad));
        assert_eq!(said, [false, true, false, false, true, false]);
    }
}
