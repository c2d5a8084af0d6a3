//! Crowds of things made by code, in motion or still: what the benchmarks of motion count by.

use bevy_ecs::prelude::Entity;
use glam::{DVec3, UVec2};
use orrery_engine::Engine;
use orrery_engine::frame::TraceSettings;
use orrery_engine::profile;
use orrery_engine::world::{
    Camera, Mesh, MeshData, Meshes, Orbit, PointLight, Sphere, Spin, Transform,
};

/// Frame numbers a second of scene time.
const FRAMES_PER_SEC: f64 = 30.0;

/// What the things of a crowd are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Spheres, and one mesh among them.
    Spheres,
    /// Instances of one mesh.
    Meshes,
}

/// A crowd to be made.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// How many things.
    pub count: usize,
    /// Of what kind.
    pub kind: Kind,
    /// Each circles about its place, and meshes spin.
    pub moving: bool,
    /// With the profile of every system, as the program's other commands have it.
    pub profiled: bool,
}

/// An engine with a crowd, a light and a camera that sees them.
pub struct Crowd {
    /// Without a tracer.
    pub engine: Engine,
    /// The eye.
    pub camera: Entity,
    /// In order of their making.
    pub things: Vec<Entity>,
}

impl Crowd {
    /// Things of 0.1 to 0.5 in radius, one in each 8 cubic units on average.
    pub fn new(plan: Plan) -> Self {
        let mut engine = Engine::new();
        if plan.profiled {
            engine.add_plugin(profile::plugin);
        }
        let world = &mut engine.world;
        world.insert_resource(TraceSettings {
            size: UVec2::ONE,
            ..*world.resource::<TraceSettings>()
        });
        world
            .resource_mut::<orrery_engine::time::Time>()
            .frames_per_sec = FRAMES_PER_SEC;
        let side = side(plan.count);
        let mesh = Mesh(world.resource_mut::<Meshes>().add(tetrahedron()));
        let mut random = Random(1);
        let mut things = Vec::with_capacity(plan.count);
        for i in 0..plan.count {
            let mut pose = Transform::from_translation(random.cube() * (0.5 * side));
            let radius = random.between(0.1, 0.5);
            let orbit = Orbit {
                axis: random.cube(),
                period: random.between(2.0, 6.0),
                phase: random.between(0.0, 6.0),
                ..Orbit::default()
            };
            let spin = Spin {
                axis: random.cube(),
                period: random.between(1.0, 4.0),
                phase: 0.0,
            };
            let is_mesh = plan.kind == Kind::Meshes || i == plan.count / 2;
            if is_mesh {
                pose.scale = DVec3::splat(radius);
            }
            let mut thing = world.spawn(pose);
            if is_mesh {
                thing.insert(mesh);
            } else {
                thing.insert(Sphere { radius });
            }
            if plan.moving {
                thing.insert(orbit);
            }
            if plan.moving && is_mesh {
                thing.insert(spin);
            }
            things.push(thing.id());
        }
        let eye = DVec3::new(0.4, 0.7, 1.5) * side;
        let view = Transform::looking_at(eye, DVec3::ZERO, DVec3::Y);
        let camera = world.spawn((view, Camera::default())).id();
        let lamp = Transform::from_translation(DVec3::Y * (2.0 * side));
        world.spawn((lamp, PointLight::default()));
        Self {
            engine,
            camera,
            things,
        }
    }
}

/// Side of the cube that so many things are spread over.
pub fn side(count: usize) -> f64 {
    2.0 * (count.max(1) as f64).cbrt()
}

/// A regular one, with corners at distance 1.
fn tetrahedron() -> MeshData {
    let corner = |x, y, z| DVec3::new(x, y, z).normalize();
    let vertices = vec![
        corner(1.0, 1.0, 1.0),
        corner(1.0, -1.0, -1.0),
        corner(-1.0, 1.0, -1.0),
        corner(-1.0, -1.0, 1.0),
    ];
    MeshData {
        name: "tetrahedron".into(),
        extent: 2.0,
        positions: vertices.iter().map(|v| v.as_vec3()).collect(),
        vertices,
        triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]],
        ..MeshData::default()
    }
}

/// The same numbers on every run: Knuth's multiplier, the upper half of the state.
#[derive(Clone, Debug)]
pub struct Random(pub u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 32) as f64 / 4_294_967_296.0
    }

    /// Uniform in a range.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Uniform in [-1, 1]^3.
    pub fn cube(&mut self) -> DVec3 {
        DVec3::from_array([(); 3].map(|()| self.between(-1.0, 1.0)))
    }
}
