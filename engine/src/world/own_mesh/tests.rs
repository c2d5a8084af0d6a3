//! Own meshes under random edits against what they must be.

use std::collections::HashSet;
use std::f64::consts::TAU;

use glam::{DAffine3, DVec3, Vec3};

use super::*;
use crate::app::Engine;
use crate::testing::Random;
use crate::time::Clock;
use crate::world::{Loop, MeshId, SkinBinding, Transform, VertexSets, turn};

const VERTICES: usize = 4;

fn quad() -> MeshData {
    let corner = |i: usize| DVec3::new((i & 1) as f64, (i >> 1) as f64, 0.0);
    let vertices = (0..VERTICES).map(corner).collect();
    MeshData::new("quad", vertices, Vec::new(), vec![[0, 1, 3], [0, 3, 2]]).unwrap()
}

fn sets(count: usize) -> Arc<VertexSets> {
    Arc::new(VertexSets {
        vertices: VERTICES,
        values: vec![Vec3::ONE; VERTICES * count],
    })
}

struct Trial {
    engine: Engine,
    random: Random,
    base: MeshId,
    joints: Vec<Entity>,
    entities: Vec<Entity>,
}

impl Trial {
    fn new(seed: u64) -> Self {
        let mut engine = Engine::new();
        let base = engine.world.resource_mut::<Meshes>().add(quad());
        let joint = || Transform::from_translation(DVec3::X);
        let joints = vec![
            engine.world.spawn(joint()).id(),
            engine.world.spawn(joint()).id(),
        ];
        Self {
            engine,
            random: Random::new(seed),
            base,
            joints,
            entities: Vec::new(),
        }
    }

    /// Adds or takes away a source of an own mesh.
    fn source(&mut self, entity: Entity) {
        let random = &mut self.random;
        let remove = random.below(3) == 0;
        let binding = SkinBinding::new(vec![[0, 1, 0, 0]; VERTICES], vec![[1.0; 4]; VERTICES]);
        let mut entity = self.engine.world.entity_mut(entity);
        match (random.below(8), remove) {
            (0, true) => drop(entity.remove::<KeyFrames>()),
            (0, false) => drop(entity.insert(KeyFrames {
                keys: sets(2),
                times: vec![0.0, 1.0],
                speed: random.range(-10.0, 10.0),
                repeat: [Loop::Once, Loop::Repeat, Loop::PingPong][random.below(3)],
                ..KeyFrames::default()
            })),
            (1, true) => drop(entity.remove::<Morph>()),
            // Sometimes one weight too many.
            (1, false) => drop(entity.insert(Morph {
                targets: sets(2),
                weights: vec![0.5; 2 + random.below(2)],
            })),
            (2, true) => drop(entity.remove::<Skin>()),
            (2, false) => drop(entity.insert(Skin {
                binding: Arc::new(binding.unwrap()),
                joints: self.joints.clone(),
                joint_from_mesh: vec![DAffine3::IDENTITY; 2],
            })),
            (3, true) => drop(entity.remove::<Wave>()),
            (3, false) => drop(entity.insert(Wave {
                amplitude: random.cube() * 10.0,
                ..Wave::default()
            })),
            (4, true) => drop(entity.remove::<Twist>()),
            (4, false) => drop(entity.insert(Twist {
                swing: random.range(-10.0, 10.0),
                ..Twist::default()
            })),
            (5, true) => drop(entity.remove::<Structure>()),
            (5, false) => drop(entity.insert(Structure::None)),
            (6, true) => drop(entity.remove::<Mesh>()),
            (6, false) => drop(entity.remove::<Polygon>().insert(Mesh(self.base))),
            (_, true) => drop(entity.remove::<Polygon>()),
            (_, false) => drop(entity.remove::<Mesh>().insert(Polygon::default())),
        }
    }

    fn edit(&mut self) {
        let kind = self.random.below(8);
        let pick = self.random.below(self.entities.len().max(1));
        let Some(&entity) = self.entities.get(pick).filter(|_| kind > 0) else {
            let spawned = self.engine.world.spawn(Mesh(self.base)).id();
            return self.entities.push(spawned);
        };
        match kind {
            1 => {
                self.entities.swap_remove(pick);
                self.engine.world.despawn(entity);
            }
            2 => {
                let pose = Transform::from_translation(self.random.cube() * 10.0);
                let target = if self.random.below(2) == 0 {
                    entity
                } else {
                    self.joints[0]
                };
                self.engine.world.entity_mut(target).insert(pose);
            }
            3 => {
                let frame = self.random.below(100) as u64;
                self.engine.world.insert_resource(Clock::Frame(frame));
            }
            _ => self.source(entity),
        }
    }

    /// The row an entity must have, by the documented formulas.
    fn expected(&self, entity: Entity) -> Option<(usize, Vec<DeformStep>, Structure)> {
        let world = &self.engine.world;
        let secs = world.resource::<Time>().secs;
        let entity = world.entity(entity);
        let mut steps = Vec::new();
        if let Some(keys) = entity.get::<KeyFrames>() {
            steps.push(DeformStep::Keys {
                keys: Arc::clone(&keys.keys),
                from: 0,
                to: 1,
                share: keys.repeat.wrap(keys.speed * secs, 0.0, 1.0),
            });
        }
        if let Some(morph) = entity
            .get::<Morph>()
            .filter(|morph| morph.weights.len() == 2)
        {
            steps.push(DeformStep::Morph {
                targets: Arc::clone(&morph.targets),
                weights: morph.weights.clone(),
            });
        }
        if let Some(skin) = entity.get::<Skin>() {
            let pose = |e: Entity| world.get::<GlobalTransform>(e).unwrap().0;
            let own = entity.get::<GlobalTransform>().unwrap().0.inverse();
            steps.push(DeformStep::Skin {
                binding: Arc::clone(&skin.binding),
                joints: self.joints.iter().map(|&joint| own * pose(joint)).collect(),
            });
        }
        if let Some(wave) = entity.get::<Wave>() {
            steps.push(DeformStep::Wave {
                wave: DVec3::X * TAU,
                amplitude: wave.amplitude,
                phase: TAU * turn(secs, 1.0),
            });
        }
        if let Some(twist) = entity.get::<Twist>() {
            steps.push(DeformStep::Twist {
                origin: DVec3::ZERO,
                axis: DVec3::Y,
                rate: 1.0 + twist.swing * (TAU * turn(secs, 1.0)).sin(),
                offset: 0.0,
            });
        }
        let structure = entity.get::<Structure>().copied();
        let deforms = !steps.is_empty() || entity.contains::<Morph>();
        let is_polygon = entity.contains::<Polygon>();
        if is_polygon {
            // The default polygon is four corners too, so that what fits a mesh fits it.
            return Some((0, steps, structure.unwrap_or_default()));
        }
        let is_own = entity.contains::<Mesh>() && (deforms || structure.is_some());
        is_own.then(|| (1, steps, structure.unwrap_or_default()))
    }

    fn compare(&self, context: &str) {
        let world = &self.engine.world;
        let meshes = world.resource::<Meshes>();
        let mut used = HashSet::from([self.base.0]);
        for &entity in &self.entities {
            let own = world.get::<OwnMesh>(entity).copied();
            let Some((kind, steps, structure)) = self.expected(entity) else {
                assert_eq!(own, None, "{context}: {entity}");
                continue;
            };
            let OwnMesh(id) = own.unwrap_or_else(|| panic!("{context}: {entity} has no mesh"));
            assert!(used.insert(id.0), "{context}: row {id:?} is shared");
            let row = &meshes.rows()[id.0 as usize];
            let is_base = Arc::ptr_eq(&row.data, meshes.get(self.base).unwrap());
            assert_eq!(is_base, kind == 1, "{context}: {entity}");
            let found = row.deformation.as_ref().map_or(&[][..], |d| &d.steps);
            assert_eq!(found, steps, "{context}: {entity}");
            assert_eq!(row.structure, structure, "{context}: {entity}");
        }
        for (row, mesh) in meshes.rows().iter().enumerate() {
            let is_used = used.contains(&(row as u32));
            assert_eq!(
                !mesh.data.triangles.is_empty(),
                is_used,
                "{context}: row {row}"
            );
        }
    }
}

#[test]
fn random_deformers_leave_no_stale_row() {
    for seed in 1..=40 {
        let mut trial = Trial::new(seed);
        for frame in 0..60 {
            for _ in 0..trial.random.below(6) {
                trial.edit();
            }
            trial.engine.frame();
            trial.compare(&format!("seed {seed}, frame {frame}"));
        }
    }
}

#[test]
fn an_equal_deformation_is_no_change() {
    let mut trial = Trial::new(5);
    for _ in 0..200 {
        trial.edit();
    }
    trial.engine.frame();
    let before = trial.engine.world.resource::<Meshes>().rows().version();
    for entity in trial.entities.clone() {
        let mut entity = trial.engine.world.entity_mut(entity);
        // Touched, but as it was.
        if let Some(mut wave) = entity.get_mut::<Wave>() {
            wave.set_changed();
        }
        if let Some(mut keys) = entity.get_mut::<KeyFrames>() {
            keys.set_changed();
        }
    }
    trial.engine.frame();
    let after = trial.engine.world.resource::<Meshes>().rows().version();
    assert_eq!(before, after);
}

#[test]
fn a_replaced_mesh_reaches_those_who_deform_it() {
    let mut engine = Engine::new();
    let base = engine.world.resource_mut::<Meshes>().add(quad());
    let entity = engine.world.spawn((Mesh(base), Wave::default())).id();
    engine.frame();
    let mut meshes = engine.world.resource_mut::<Meshes>();
    meshes.replace(base, quad());
    engine.frame();
    let meshes = engine.world.resource::<Meshes>();
    let OwnMesh(own) = *engine.world.get::<OwnMesh>(entity).unwrap();
    let same = Arc::ptr_eq(meshes.get(own).unwrap(), meshes.get(base).unwrap());
    assert!(same, "the row still holds the old mesh");
}

#[test]
fn what_never_fits_is_told_and_left_out() {
    let mut engine = Engine::new();
    let base = engine.world.resource_mut::<Meshes>().add(quad());
    let wave = Wave {
        length: f64::NAN,
        ..Wave::default()
    };
    let wrong = KeyFrames {
        keys: Arc::new(VertexSets {
            vertices: 3,
            values: vec![Vec3::ZERO; 3],
        }),
        times: vec![0.0],
        ..KeyFrames::default()
    };
    let entity = engine.world.spawn((Mesh(base), wave, wrong)).id();
    engine.frame();
    let OwnMesh(own) = *engine.world.get::<OwnMesh>(entity).unwrap();
    let row = engine.world.resource::<Meshes>().rows()[own.0 as usize].clone();
    assert_eq!(row.deformation, None);
    assert_eq!(row.data.triangles.len(), 2);
}
