//! Pictures that must be equal bit for bit: of a scene moved by what f64 holds exactly, and of one scaled by powers of two.
//!
//! Both in two ways: by the poses of instances, and by the numbers of their shapes (vertices, corners, distances).

use std::sync::Arc;

use glam::{DAffine3, DVec3, UVec2};
use orrery_engine::frame::{FrameScene, Instance, LightKind, Shape, TraceSettings};
use orrery_engine::trace::Backend;
use orrery_engine::world::{Cone, MeshData, MeshRow};
use orrery_tests::random_scene::random_scene;
use orrery_tests::tracers;

/// What a change of the whole world does to its places and lengths, by poses or by shapes.
#[derive(Clone, Copy, Debug)]
struct Change {
    factor: f64,
    shift: DVec3,
    by_shape: bool,
}

impl Change {
    fn place(self, p: DVec3) -> DVec3 {
        p * self.factor + self.shift
    }

    fn mesh(self, mesh: &MeshData) -> MeshData {
        let vertices = mesh.vertices.iter().map(|&v| self.place(v)).collect();
        let (name, normals) = (mesh.name.clone(), mesh.normals.clone());
        MeshData::new(name, vertices, normals, mesh.triangles.clone()).expect("a mesh")
    }

    /// The shape of an unposed instance, if its numbers can say where it is.
    fn shape(self, shape: Shape) -> Option<Shape> {
        match shape {
            Shape::Mesh(_) => Some(shape),
            Shape::Cuboid { min, max } => Some(Shape::Cuboid {
                min: self.place(min),
                max: self.place(max),
            }),
            Shape::Plane { normal, distance } => Some(Shape::Plane {
                normal,
                distance: distance * self.factor + normal.dot(self.shift),
            }),
            Shape::Disc {
                center,
                normal,
                radius,
            } => Some(Shape::Disc {
                center: self.place(center),
                normal,
                radius: radius * self.factor,
            }),
            Shape::Cone(Cone {
                a,
                radius_a,
                b,
                radius_b,
                open,
            }) => Some(Shape::Cone(Cone {
                a: self.place(a),
                radius_a: radius_a * self.factor,
                b: self.place(b),
                radius_b: radius_b * self.factor,
                open,
            })),
            _ => None,
        }
    }

    fn instance(self, instance: &mut Instance) {
        if self.by_shape
            && instance.world_from_local == DAffine3::IDENTITY
            && let Some(shape) = self.shape(instance.shape)
        {
            instance.shape = shape;
            return;
        }
        let pose = &mut instance.world_from_local;
        pose.translation = self.place(pose.translation);
        pose.matrix3 *= self.factor;
    }

    fn apply(self, scene: &FrameScene) -> FrameScene {
        let mut changed = scene.clone();
        changed.view.origin = self.place(changed.view.origin);
        changed.lights.edit(|light| {
            if let LightKind::Point { position } = &mut light.kind {
                *position = self.place(*position);
            }
            if let Some(fade) = &mut light.fade {
                fade.distance *= self.factor;
            }
        });
        changed.instances.edit(|row| self.instance(row));
        if self.by_shape {
            let moved = |row: &MeshRow| MeshRow {
                data: Arc::new(self.mesh(&row.data)),
                ..row.clone()
            };
            changed.meshes = changed.meshes.iter().map(moved).collect::<Vec<_>>().into();
        }
        changed
    }
}

/// A random scene of numbers with few digits. `unposed`: all but spheres and tori stand where their numbers say.
fn base(unposed: bool) -> FrameScene {
    let snap = |v: DVec3| (v * 1024.0).round() / 1024.0;
    let mut scene = random_scene(3, 40);
    scene.view.origin = snap(scene.view.origin);
    scene.lights.edit(|light| {
        if let LightKind::Point { position } = &mut light.kind {
            *position = snap(*position);
        }
    });
    let snapped = |row: &MeshRow| {
        let mesh = &row.data;
        let vertices = mesh.vertices.iter().map(|&v| snap(v)).collect();
        let (name, normals) = (mesh.name.clone(), mesh.normals.clone());
        MeshRow::from(
            MeshData::new(name, vertices, normals, mesh.triangles.clone()).expect("a mesh"),
        )
    };
    scene.meshes = scene.meshes.iter().map(snapped).collect::<Vec<_>>().into();
    let mut meshes_left = scene.meshes.len();
    scene.instances.edit(|row| {
        let pose = &mut row.world_from_local;
        pose.translation = snap(pose.translation);
        if !unposed {
            return;
        }
        match &mut row.shape {
            // One instance a mesh: its vertices say where it is.
            Shape::Mesh(mesh) if meshes_left > 0 => {
                meshes_left -= 1;
                *mesh = meshes_left as u32;
                *pose = DAffine3::IDENTITY;
            }
            Shape::Mesh(_) => row.shape = Shape::Vacant,
            Shape::Cuboid { min, max } => {
                let at = pose.translation;
                (*min, *max) = (snap(*min) + at, snap(*max) + at);
                *pose = DAffine3::IDENTITY;
            }
            Shape::Disc { center, .. } => {
                *center = snap(*center) + pose.translation;
                *pose = DAffine3::IDENTITY;
            }
            Shape::Cone(Cone { a, b, .. }) => {
                let at = pose.translation;
                (*a, *b) = (snap(*a) + at, snap(*b) + at);
                *pose = DAffine3::IDENTITY;
            }
            Shape::Plane { normal, distance } => {
                (*normal, *distance) = (DVec3::Y, -3.0);
                *pose = DAffine3::IDENTITY;
            }
            _ => {}
        }
    });
    scene
}

fn hold(backend: Backend, changes: &[Change]) {
    let settings = TraceSettings {
        size: UVec2::new(96, 72),
        ..TraceSettings::default()
    };
    let mut tracer = tracers::open(backend).expect("a device; tests need one");
    for change in changes {
        let scene = base(change.by_shape);
        let a = tracers::picture(tracer.as_mut(), &scene, &settings).expect("a picture");
        let changed = change.apply(&scene);
        let b = tracers::picture(tracer.as_mut(), &changed, &settings).expect("a picture");
        let off = a.pixels.iter().zip(&b.pixels).filter(|(a, b)| a != b);
        assert_eq!(
            off.count(),
            0,
            "{backend}: pixels that differ after {change:?}"
        );
        let sky = scene.background.horizon;
        let shown = a.pixels.iter().filter(|p| **p != sky).count();
        assert!(
            shown > 2_000,
            "{backend}: only {shown} pixels show something"
        );
    }
}

const SHIFTS: [DVec3; 3] = [
    DVec3::new(1e4, -2e4, 3e4),
    DVec3::new(1e6, -2e6, 3e6),
    DVec3::new(-1e7, 1e7, 2e7),
];

fn shifts() -> Vec<Change> {
    let change = |by_shape| {
        SHIFTS.map(|shift| Change {
            factor: 1.0,
            shift,
            by_shape,
        })
    };
    [change(false), change(true)].concat()
}

fn scales() -> Vec<Change> {
    let change = |by_shape| {
        [-20, -7, 7, 20].map(|power: i32| Change {
            factor: f64::from(power).exp2(),
            shift: DVec3::ZERO,
            by_shape,
        })
    };
    [change(false), change(true)].concat()
}

#[test]
fn the_cpu_gives_the_same_bits_far_away() {
    hold(Backend::Cpu, &shifts());
}

#[test]
fn the_gpu_gives_the_same_bits_far_away() {
    hold(Backend::Gpu, &shifts());
}

#[test]
fn the_reference_gives_the_same_bits_far_away() {
    hold(Backend::Reference, &shifts());
}

#[test]
fn the_cpu_gives_the_same_bits_at_every_scale() {
    hold(Backend::Cpu, &scales());
}

#[test]
fn the_gpu_gives_the_same_bits_at_every_scale() {
    hold(Backend::Gpu, &scales());
}

#[test]
fn the_reference_gives_the_same_bits_at_every_scale() {
    hold(Backend::Reference, &scales());
}
