//! Bad input: a world with numbers in it that are none, infinite, huge, tiny or singular.
//!
//! Such things come through the components that scenes, editors and programs write. No pixel may be other than finite,
//! and what is good must look as it does without the bad things, bit for bit: they are spawned between
//! good ones, in a second world that is alike but for them.

use bevy_ecs::prelude::{Entity, Or, With, World};
use glam::{DQuat, DVec3, UVec2, Vec3};
use orrery_engine::Engine;
use orrery_engine::frame::{FrameScene, Kernels, TraceSettings};
use orrery_engine::world::{
    Camera, Cuboid, DirectionalLight, Fade, Lobe, Material, Mesh, MeshData, Meshes, Plane,
    PointLight, Reflection, Sphere, SpotLight, Surface, Transform,
};

use super::course::Course;
use super::draw::Draw;
use super::scenes::{materials, unequal};
use super::solids::Solid;
use super::tally::{Tally, Verdict};
use crate::failure::Failure;
use crate::output::progress;

/// The suite.
pub const NAME: &str = "input";
/// Worlds.
const WORLDS: u64 = 2000;
/// Worlds where rays without end are asked for.
const LONG: u64 = 100_000;
/// Pixels of a picture.
const SIZE: UVec2 = UVec2::new(16, 12);
/// Good things of a world.
const GOOD: usize = 6;
/// Bad things between them.
const BAD: usize = 3;

/// What is wrong with a world.
#[derive(Clone, Copy, PartialEq)]
enum Fault {
    /// Shapes that cannot be shown.
    Shapes,
    /// Lights that cannot shine.
    Lights,
    /// Materials, shown by what is in front: no picture to compare with.
    Materials,
    /// The eye.
    Camera,
}

/// Runs every fault, after a world whose bad numbers are put behind the checks.
pub fn run(course: &mut Course) -> Result<(), Failure> {
    let worlds = course.scenes(WORLDS, LONG);
    let unchecked = unchecked(course, 20)?;
    course.must_fail(&format!("{NAME}.unchecked"), &unchecked, None);
    for (word, fault) in [
        ("shapes", Fault::Shapes),
        ("lights", Fault::Lights),
        ("materials", Fault::Materials),
        ("camera", Fault::Camera),
    ] {
        let name = format!("{NAME}.{word}");
        let (finite, same) = tally(course, fault, worlds.div_ceil(4), &name)?;
        course.none_may_fail(&format!("{name}.non_finite"), &finite);
        if let Some(same) = same {
            course.none_may_fail(&format!("{name}.changed"), &same);
        }
    }
    Ok(())
}

/// Pixels that are not finite, and pixels of the good that changed.
fn tally(
    course: &mut Course,
    fault: Fault,
    worlds: u64,
    name: &str,
) -> Result<(Tally, Option<Tally>), Failure> {
    let mut finite = Tally::default();
    let mut same = Tally::default();
    let bar = progress(worlds, name);
    let mut makers = [Maker::new()?, Maker::new()?];
    for index in 0..worlds {
        let [mixed, plain] = &mut makers;
        let scene = mixed.frame_of(fault, index, true);
        let found = course.picture(&scene, SIZE, Kernels::default())?;
        for pixel in &found.pixels {
            finite.take(Verdict::of(pixel.is_finite()));
        }
        if matches!(fault, Fault::Shapes | Fault::Lights) {
            let scene = plain.frame_of(fault, index, false);
            let expected = course.picture(&scene, SIZE, Kernels::default())?;
            let pixels = found.pixels.len() as u64;
            same = same.with(Tally::counted(pixels, unequal(&found, &expected)));
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok((finite, (same.tried > 0).then_some(same)))
}

/// Pixels that are not finite where a light that is none reaches the tracer: they must show.
fn unchecked(course: &mut Course, worlds: u64) -> Result<Tally, Failure> {
    let mut tally = Tally::default();
    let mut maker = Maker::new()?;
    for index in 0..worlds {
        let mut scene = maker.frame_of(Fault::Lights, index, false);
        let mut light = scene.lights[0];
        light.color.y = f32::NAN;
        scene.lights.set(0, light);
        let picture = course.picture(&scene, SIZE, Kernels::default())?;
        for pixel in &picture.pixels {
            tally.take(Verdict::of(pixel.is_finite()));
        }
    }
    Ok(tally)
}

/// An engine that is given one world after the other.
struct Maker {
    engine: Engine,
    /// What good things may be.
    mesh: Mesh,
}

impl Maker {
    fn new() -> Result<Self, Failure> {
        let mut engine = Engine::new();
        engine.world.insert_resource(TraceSettings {
            size: SIZE,
            ..TraceSettings::default()
        });
        let mesh = Solid::icosphere(1).mesh().map_err(Failure::Input)?;
        let mesh = Mesh(engine.world.resource_mut::<Meshes>().add(mesh));
        Ok(Self { engine, mesh })
    }

    /// The frame of a world, with its bad things or without.
    fn frame_of(&mut self, fault: Fault, index: u64, bad: bool) -> FrameScene {
        let (world, mesh) = (&mut self.engine.world, self.mesh);
        let mut known = world.query_filtered::<Entity, Or<(With<Transform>, With<Material>)>>();
        let known: Vec<Entity> = known.iter(world).collect();
        for entity in known {
            world.despawn(entity);
        }
        let mut good = Draw::of(1100 + fault as u64, index);
        let mut evil = Draw::of(1200 + fault as u64, index);
        spawn_camera(world, fault, &mut evil);
        for i in 0..GOOD.max(BAD) {
            if i < GOOD {
                spawn_good(world, mesh, &mut good);
            }
            if bad && i < BAD {
                spawn_bad(world, fault, mesh, &mut evil);
            }
        }
        let lamp = Transform::from_translation(DVec3::new(3.0, 6.0, 5.0));
        world.spawn((lamp, PointLight::default()));
        self.engine.frame();
        self.engine.world.resource::<FrameScene>().clone()
    }
}

fn spawn_camera(world: &mut World, fault: Fault, evil: &mut Draw) {
    let mut pose = Transform::from_translation(DVec3::new(0.0, 0.5, 6.0));
    let mut camera = Camera::default();
    if fault == Fault::Camera {
        match evil.below(4) {
            0 => pose.translation = spoiled(pose.translation, evil),
            1 => pose.rotation = spoiled_turn(evil),
            2 => pose.scale = spoiled(pose.scale, evil),
            _ => {
                camera.projection = orrery_engine::world::Projection::Perspective {
                    vertical_fov: number(evil),
                };
            }
        }
    }
    world.spawn((pose, camera));
}

fn spawn_good(world: &mut World, mesh: Mesh, draw: &mut Draw) {
    let material = world.spawn(materials()[draw.below(4)]).id();
    let pose = Transform {
        translation: draw.cube() * 2.0,
        rotation: DQuat::from_axis_angle(draw.direction(), draw.range(0.0, 6.0)),
        scale: DVec3::splat(draw.range(0.3, 1.0)),
    };
    let mut thing = world.spawn((pose, Surface(material)));
    match draw.below(3) {
        0 => thing.insert(Sphere::default()),
        1 => thing.insert(Cuboid::default()),
        _ => thing.insert(mesh),
    };
}

fn spawn_bad(world: &mut World, fault: Fault, mesh: Mesh, draw: &mut Draw) {
    match fault {
        Fault::Shapes => bad_shape(world, mesh, draw),
        Fault::Lights => bad_light(world, draw),
        Fault::Materials => bad_material(world, draw),
        Fault::Camera => {}
    }
}

fn bad_shape(world: &mut World, mesh: Mesh, draw: &mut Draw) {
    let mut pose = Transform::from_translation(draw.cube() * 2.0);
    let spoil_pose = draw.below(2) == 0;
    if spoil_pose {
        match draw.below(4) {
            0 => pose.translation = spoiled(pose.translation, draw),
            1 => pose.rotation = spoiled_turn(draw),
            2 => pose.scale = spoiled(pose.scale, draw),
            _ => pose.scale = DVec3::new(1.0, 0.0, 1.0),
        }
    }
    let kind = draw.below(if spoil_pose { 4 } else { 3 });
    let mut size = |good: f64| if spoil_pose { good } else { number(draw) };
    match kind {
        0 => {
            let radius = size(1.0);
            world.spawn((pose, Sphere { radius }));
        }
        1 => {
            let max = DVec3::new(size(0.5), 0.5, 0.5);
            let min = DVec3::splat(-0.5);
            // Turned inside out, whatever the number is.
            let (min, max) = if spoil_pose { (min, max) } else { (max, min) };
            world.spawn((pose, Cuboid { min, max }));
        }
        2 if spoil_pose => {
            world.spawn((pose, mesh));
        }
        2 => bad_mesh(world, pose, draw),
        _ => {
            // A plane has no size that a pose could spoil but its place.
            pose = Transform::from_translation(DVec3::splat(f64::NAN));
            world.spawn((pose, Plane::default()));
        }
    }
}

/// Most bad vertices never become a mesh; what does is shown.
fn bad_mesh(world: &mut World, pose: Transform, draw: &mut Draw) {
    let corner = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e38, -1e300][draw.below(5)];
    let vertices = vec![DVec3::X, DVec3::Y, DVec3::splat(corner)];
    if let Ok(mesh) = MeshData::new("bad", vertices, Vec::new(), vec![[0, 1, 2]]) {
        let mesh = Mesh(world.resource_mut::<Meshes>().add(mesh));
        world.spawn((pose, mesh));
    }
}

fn bad_light(world: &mut World, draw: &mut Draw) {
    let pose = Transform::from_translation(DVec3::new(-4.0, 5.0, 3.0));
    let color = Vec3::new(1.0, non_finite(draw) as f32, 0.5);
    let intensity = 1.0;
    match draw.below(6) {
        4 => world.spawn((
            pose,
            PointLight {
                fade: Some(Fade {
                    distance: 1.0,
                    power: non_finite(draw),
                }),
                ..PointLight::default()
            },
        )),
        5 => world.spawn((
            pose,
            SpotLight {
                inner_angle: non_finite(draw),
                intensity: 1e38,
                ..SpotLight::default()
            },
        )),
        0 => world.spawn((
            pose,
            PointLight {
                color,
                ..PointLight::default()
            },
        )),
        1 => world.spawn((pose, DirectionalLight { color, intensity })),
        2 => world.spawn((
            pose,
            SpotLight {
                color,
                ..SpotLight::default()
            },
        )),
        _ => world.spawn((
            pose,
            PointLight {
                fade: Some(Fade {
                    distance: non_finite(draw),
                    power: 2.0,
                }),
                ..PointLight::default()
            },
        )),
    };
}

fn bad_material(world: &mut World, draw: &mut Draw) {
    let mut material = materials()[draw.below(4)];
    let x = number(draw) as f32;
    match draw.below(8) {
        0 => material.color.y = x,
        1 => material.diffuse = x,
        2 => material.emission = x,
        3 => {
            material.phong = Some(Lobe {
                strength: x,
                exponent: number(draw) as f32,
            });
        }
        4 => material.reflection = Reflection::Constant(Vec3::new(0.5, x, 0.5)),
        5 => material.transmit = x,
        6 => material.filter = x,
        _ => material.ior = number(draw),
    }
    let material = world.spawn(material).id();
    let at = Transform::from_translation(draw.cube() * 1.5);
    world.spawn((at, Sphere::default(), Surface(material)));
}

/// Numbers that are trouble.
fn number(draw: &mut Draw) -> f64 {
    match draw.below(8) {
        0..=2 => non_finite(draw),
        3 => 1e38,
        4 => -1e38,
        5 => 1e-42,
        6 => 0.0,
        _ => -1.0,
    }
}

fn non_finite(draw: &mut Draw) -> f64 {
    [f64::NAN, f64::INFINITY, f64::NEG_INFINITY][draw.below(3)]
}

/// One coordinate beyond use.
fn spoiled(mut v: DVec3, draw: &mut Draw) -> DVec3 {
    v[draw.below(3)] = non_finite(draw);
    v
}

fn spoiled_turn(draw: &mut Draw) -> DQuat {
    let x = non_finite(draw);
    DQuat::from_xyzw(x, 0.0, 0.0, 1.0)
}
