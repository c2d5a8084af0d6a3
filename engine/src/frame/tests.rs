//! Random worlds under random edits: propagation and extraction against all computed from scratch.

use std::collections::{HashMap, HashSet};

use bevy_ecs::prelude::*;
use glam::{DAffine3, DMat3, DQuat, DVec3, UVec2, Vec3};

use super::*;
use crate::app::Engine;
use crate::testing::Random;
use crate::world::*;

fn pick(random: &mut Random, entities: &[Entity]) -> Option<Entity> {
    (!entities.is_empty()).then(|| entities[random.below(entities.len())])
}

/// An engine with a world under random edits.
struct Trial {
    engine: Engine,
    random: Random,
    entities: Vec<Entity>,
    materials: Vec<Entity>,
}

impl Trial {
    fn new(seed: u64) -> Self {
        let mut engine = Engine::new();
        engine.validate().unwrap();
        Self {
            engine,
            random: Random::new(seed),
            entities: Vec::new(),
            materials: Vec::new(),
        }
    }

    fn transform(&mut self) -> Transform {
        Transform {
            translation: self.random.cube() * 10.0,
            rotation: DQuat::from_rotation_y(self.random.range(-10.0, 10.0)),
            scale: DVec3::splat(0.5 + self.random.below(4) as f64 * 0.5),
        }
    }

    fn spawn(&mut self) {
        let transform = self.transform();
        let parent = pick(&mut self.random, &self.entities);
        let mut entity = self.engine.world.spawn((transform, Visibility::default()));
        if let Some(parent) = parent
            && self.random.below(4) != 0
        {
            entity.insert(ChildOf(parent));
        }
        let entity = entity.id();
        self.entities.push(entity);
        self.shape(entity);
    }

    /// Gives an entity another shape, or one more, or none.
    fn shape(&mut self, entity: Entity) {
        let radius = 1.0 + self.random.below(9) as f64;
        let material = pick(&mut self.random, &self.materials);
        let mut entity = self.engine.world.entity_mut(entity);
        match self.random.below(6) {
            0 => drop(entity.insert(Sphere { radius })),
            1 => drop(entity.insert(Cuboid::default())),
            2 => drop(entity.insert(Polygon::default())),
            3 => drop(entity.remove::<Sphere>()),
            4 => drop(entity.remove::<Polygon>()),
            _ => drop(entity.remove::<Cuboid>()),
        }
        match material {
            Some(material) if self.random.below(3) != 0 => drop(entity.insert(Surface(material))),
            _ => drop(entity.remove::<Surface>()),
        }
    }

    fn is_under(&self, entity: Entity, other: Entity) -> bool {
        let parent = |e: Entity| self.engine.world.get::<ChildOf>(e).map(ChildOf::parent);
        std::iter::successors(Some(entity), |&e| parent(e)).any(|e| e == other)
    }

    fn edit_material(&mut self) {
        let material = Material {
            color: Vec3::splat(self.random.below(100) as f32),
            ..Material::default()
        };
        let chosen = pick(&mut self.random, &self.materials);
        let world = &mut self.engine.world;
        match (self.random.below(5), chosen) {
            (0, Some(entity)) => drop(world.despawn(entity)),
            (1, Some(entity)) => drop(world.entity_mut(entity).remove::<Material>()),
            (2 | 3, Some(entity)) => drop(world.entity_mut(entity).insert(material)),
            _ => self.materials.push(world.spawn(material).id()),
        }
        let world = &self.engine.world;
        self.materials.retain(|&e| world.get_entity(e).is_ok());
    }

    fn edit(&mut self) {
        let kind = self.random.below(12);
        let chosen = pick(&mut self.random, &self.entities);
        let (Some(entity), 3..) = (chosen, kind) else {
            return self.spawn();
        };
        let transform = self.transform();
        let other = pick(&mut self.random, &self.entities).unwrap_or(entity);
        let hangs_below = self.is_under(other, entity);
        let world = &mut self.engine.world;
        match kind {
            3 => drop(world.despawn(entity)),
            4 if !hangs_below => drop(world.entity_mut(entity).insert(ChildOf(other))),
            4 => drop(world.entity_mut(entity).remove::<ChildOf>()),
            5 => {
                let mut visibility = world.get_mut::<Visibility>(entity).unwrap();
                visibility.shown = !visibility.shown;
            }
            6 => {
                let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.5, 1.0, 0.0), DVec3::Z);
                let shear = Shear(DAffine3::from_mat3(shear));
                world.entity_mut(entity).insert(shear);
            }
            7 => drop(world.entity_mut(entity).remove::<Shear>()),
            8 => drop(world.entity_mut(entity).insert(transform)),
            9 => self.edit_material(),
            _ => self.shape(entity),
        }
        let world = &self.engine.world;
        self.entities.retain(|&e| world.get_entity(e).is_ok());
    }

    /// World pose and visibility, computed from the root down.
    fn recomputed(&self, entity: Entity) -> (DAffine3, bool) {
        let world = &self.engine.world;
        let mut own = world.get::<Transform>(entity).unwrap().affine();
        if let Some(Shear(shear)) = world.get::<Shear>(entity) {
            own *= *shear;
        }
        let shown = world.get::<Visibility>(entity).unwrap().shown;
        match world.get::<ChildOf>(entity).map(ChildOf::parent) {
            Some(parent) => {
                let (above, all_shown) = self.recomputed(parent);
                (above * own, all_shown && shown)
            }
            None => (own, shown),
        }
    }

    /// The shape a tracer must see.
    fn expected_shape(&self, entity: Entity) -> Option<Shape> {
        let world = &self.engine.world;
        let polygon = || {
            world.get::<Polygon>(entity)?;
            let OwnMesh(id) = world.get::<OwnMesh>(entity)?;
            Some(Shape::Mesh(id.0))
        };
        let sphere = || {
            let radius = world.get::<Sphere>(entity)?.radius;
            Some(Shape::Sphere { radius })
        };
        let cuboid = || {
            let Cuboid { min, max } = *world.get::<Cuboid>(entity)?;
            Some(Shape::Cuboid { min, max })
        };
        polygon().or_else(sphere).or_else(cuboid)
    }

    /// Compares derived components and the frame with what comes out from scratch.
    fn compare(&self, context: &str) {
        let world = &self.engine.world;
        let scene = world.resource::<FrameScene>();
        let filled = scene.instances.iter().filter(|i| i.shape != Shape::Vacant);
        let mut rows: HashMap<u64, &Instance> = HashMap::new();
        for instance in filled {
            let twin = rows.insert(instance.tag, instance);
            assert!(twin.is_none(), "{context}: two rows of one entity");
        }
        for &entity in &self.entities {
            let (pose, shown) = self.recomputed(entity);
            assert_eq!(
                world.get::<GlobalTransform>(entity).unwrap().0,
                pose,
                "{context}"
            );
            assert_eq!(
                world.get::<GlobalVisibility>(entity).unwrap().0,
                shown,
                "{context}"
            );
            let row = rows.remove(&entity.to_bits());
            let expected = self.expected_shape(entity).filter(|_| shown);
            assert_eq!(row.map(|row| row.shape), expected, "{context}: {entity}");
            let Some(row) = row else { continue };
            assert_eq!(row.world_from_local, pose, "{context}");
            let surface = world.get::<Surface>(entity);
            let material = surface.and_then(|surface| world.get::<Material>(surface.0));
            assert_eq!(
                scene.materials[row.material as usize],
                material.copied().unwrap_or_default(),
                "{context}: material of {entity}"
            );
        }
        assert!(rows.is_empty(), "{context}: rows of no entity: {rows:?}");
        let polygons = self
            .entities
            .iter()
            .filter_map(|&e| world.get::<OwnMesh>(e));
        let own: HashSet<u32> = polygons.map(|mesh| mesh.0.0).collect();
        for (row, mesh) in scene.meshes.iter().enumerate() {
            let is_used = own.contains(&(row as u32));
            assert_eq!(
                !mesh.data.triangles.is_empty(),
                is_used,
                "{context}: mesh row {row}"
            );
        }
    }
}

#[test]
fn random_edits_come_out_as_from_scratch() {
    for seed in 1..=40 {
        let mut trial = Trial::new(seed);
        for frame in 0..40 {
            for _ in 0..trial.random.below(8) {
                trial.edit();
            }
            trial.engine.frame();
            trial.compare(&format!("seed {seed}, frame {frame}"));
        }
    }
}

#[test]
fn rows_are_used_again() {
    let mut engine = Engine::new();
    let mut rows = Vec::new();
    for _ in 0..10 {
        let material = engine.world.spawn(Material::default()).id();
        let shapes = [0; 5].map(|_| {
            let shape = (Polygon::default(), Surface(material));
            engine.world.spawn(shape).id()
        });
        engine.frame();
        let scene = engine.world.resource::<FrameScene>();
        rows.push((
            scene.instances.len(),
            scene.materials.len(),
            scene.meshes.len(),
        ));
        for entity in shapes.into_iter().chain([material]) {
            engine.world.despawn(entity);
        }
    }
    // The new shapes of a frame are written after the old ones' rows are free.
    assert_eq!(rows[0], (5, 2, 5));
    assert_eq!(rows[9], rows[0], "{rows:?}");
}

#[test]
fn an_unchanged_subtree_is_not_marked_changed() {
    let mut trial = Trial::new(7);
    for _ in 0..300 {
        trial.edit();
    }
    trial.engine.frame();
    for _ in 0..50 {
        let Some(moved) = pick(&mut trial.random, &trial.entities) else {
            continue;
        };
        let transform = trial.transform();
        let ticks = |trial: &Trial| -> Vec<_> {
            let entities = trial.entities.iter();
            let entity = entities.map(|&e| trial.engine.world.entity(e));
            entity
                .map(|e| {
                    let pose = e.get_change_ticks::<GlobalTransform>().unwrap().changed;
                    let shown = e.get_change_ticks::<GlobalVisibility>().unwrap().changed;
                    (pose, shown)
                })
                .collect()
        };
        let before = ticks(&trial);
        trial.engine.world.entity_mut(moved).insert(transform);
        trial.engine.frame();
        let after = ticks(&trial);
        for (i, &entity) in trial.entities.iter().enumerate() {
            let is_below = trial.is_under(entity, moved);
            assert_eq!(before[i].0 != after[i].0, is_below, "pose of {entity}");
            assert_eq!(before[i].1, after[i].1, "visibility of {entity}");
        }
    }
}

#[test]
fn without_a_camera_the_whole_scene_is_in_the_picture_undistorted() {
    for size in [UVec2::new(400, 100), UVec2::new(100, 400)] {
        let mut engine = Engine::new();
        engine.world.resource_mut::<TraceSettings>().size = size;
        let places = [DVec3::new(30.0, 2.0, 5.0), DVec3::new(-4.0, 80.0, 1.0)];
        for place in places {
            let shape = (Sphere { radius: 2.0 }, Transform::from_translation(place));
            engine.world.spawn(shape);
        }
        engine.frame();
        let view = engine.world.resource::<FrameScene>().view;
        let aspect = f64::from(size.x) / f64::from(size.y);
        let stretch = view.right.length() / view.up.length();
        assert!(
            (stretch - aspect).abs() < 1e-12,
            "{stretch} is not {aspect}"
        );
        for place in places {
            let way = place - view.origin;
            let depth = way.dot(view.forward);
            let x = way.dot(view.right) / view.right.length_squared() / depth;
            let y = way.dot(view.up) / view.up.length_squared() / depth;
            assert!(
                depth > 0.0 && x.abs() < 0.5 && y.abs() < 0.5,
                "{place}: {x} {y}"
            );
        }
    }
}
