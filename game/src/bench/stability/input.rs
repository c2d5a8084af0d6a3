//! Bad input: a world with numbers in it that are none, infinite, huge, tiny or singular.
//!
//! Such things come through the components that scenes, editors and programs write. No pixel may be other than finite,
//! and what is good must look as it does without the bad things, bit for bit: they are spawned between
//! good ones, in a second world that is alike but for them.

use bevy_ecs::prelude::{Entity, Or, With, World};
use glam::{DQuat, DVec3, UVec2};
use orrery_engine::Engine;
use orrery_engine::frame::{FrameScene, Kernels, TraceSettings};
use orrery_engine::world::{
    Background, Camera, Material, Mesh, Meshes, PointLight, Projection, Surface, Transform,
};

use super::course::Course;
use super::draw::Draw;
use super::odd::{
    BOUNDED, bad_light, bad_material, bad_shape, extreme_shape, number, odd_sky, sized, spoiled,
    spoiled_turn,
};
use super::scenes::{materials, unequal};
use super::solids::Solid;
use super::tally::{Tally, Verdict};
use crate::failure::Failure;
use crate::output::progress;

/// The suite.
pub const NAME: &str = "input";
/// Worlds.
const WORLDS: u64 = 3000;
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
    /// Shapes of finite but extreme sizes, scales and places: what can be shown is.
    Extents,
    /// Lights that cannot shine.
    Lights,
    /// A sky of any numbers, and lights that fade in extreme ways.
    Sky,
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
        ("extents", Fault::Extents),
        ("lights", Fault::Lights),
        ("sky", Fault::Sky),
        ("materials", Fault::Materials),
        ("camera", Fault::Camera),
    ] {
        let name = format!("{NAME}.{word}");
        let (finite, same) = tally(course, fault, worlds.div_ceil(6), &name)?;
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
        world.insert_resource(Background::default());
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
                camera.projection = Projection::Perspective {
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
    match draw.below(BOUNDED + 1) {
        BOUNDED => {
            thing.insert(mesh);
        }
        shape => sized(&mut thing, shape, [1.0, 1.2, 0.8]),
    }
}

fn spawn_bad(world: &mut World, fault: Fault, mesh: Mesh, draw: &mut Draw) {
    match fault {
        Fault::Shapes => bad_shape(world, mesh, draw),
        Fault::Extents => extreme_shape(world, mesh, draw),
        Fault::Lights => bad_light(world, draw),
        Fault::Sky => odd_sky(world, draw),
        Fault::Materials => bad_material(world, draw),
        Fault::Camera => {}
    }
}
