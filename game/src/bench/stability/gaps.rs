//! Two parallel plates and the smallest gap between them at which shadow and reflection are right.
//!
//! The upper plate lets the eye through (and tints), the lower one is half a mirror under a lamp: a pixel sees the
//! lower plate through the upper, the lamp's light tinted by it, and the sky mirrored through it once more. A
//! ray that is moved too far off a plate skips the other one. The f64 tracer says what each pixel is.

use glam::{DAffine3, DVec3, UVec2, Vec3};
use orrery_engine::frame::{FrameScene, Kernels, Light, LightKind, Offset, Shape, View};
use orrery_engine::trace::reference::ReferenceTracer;
use orrery_engine::world::{Material, MeshData, Reflection};

use super::course::{Course, ready, scene_of, settings};
use super::scenes::off;
use super::tally::Tally;
use crate::failure::Failure;
use crate::stage::traced;

/// The suite.
pub const NAME: &str = "gaps";
/// Pixels of a picture.
const SIZE: UVec2 = UVec2::new(48, 36);
/// Steps for each power of ten.
const STEPS: i32 = 4;
/// Powers of ten of the gap, for plates of size 1.
const LEAST: i32 = -7;
/// The gap that must be right.
const TARGET: f64 = 1e-4;
/// What a pixel may be off by: a missed plate changes it by much more.
const MOST: f32 = 0.01;

/// Runs meshes and boxes, with the fixed offset first.
pub fn run(course: &mut Course) -> Result<(), Failure> {
    let fixed = Kernels {
        offsets: Offset::Fixed,
        ..Kernels::default()
    };
    for (word, of_boxes) in [("meshes", false), ("boxes", true)] {
        let name = format!("{NAME}.{word}");
        let (_, broken) = sweep(course, of_boxes, fixed)?;
        course.must_fail(&format!("{name}.fixed"), &broken, None);
        let (smallest, tally) = sweep(course, of_boxes, Kernels::default())?;
        course.none_may_fail(&name, &tally);
        course.at_most(
            &format!("{name}.smallest"),
            "size",
            &tally,
            smallest,
            Some(TARGET),
        );
    }
    Ok(())
}

/// The smallest gap from which on every pixel is right, and the pixels of those that must be.
fn sweep(course: &mut Course, of_boxes: bool, kernels: Kernels) -> Result<(f64, Tally), Failure> {
    let mut exact = ReferenceTracer::new();
    let mut smallest = f64::INFINITY;
    let mut is_right = true;
    let mut tally = Tally::default();
    for step in (LEAST * STEPS..=0).rev() {
        let gap = 10_f64.powf(f64::from(step) / f64::from(STEPS));
        let scene = plates(gap, of_boxes).map_err(Failure::Input)?;
        let truth = traced(&mut exact, &scene, &settings(SIZE, Kernels::default()))?;
        let found = course.picture(&scene, SIZE, kernels)?;
        let wrong = off(&found, &truth, MOST);
        is_right &= wrong == 0;
        if is_right {
            smallest = gap;
        }
        if gap >= TARGET * 0.999 {
            let pixels = found.pixels.len() as u64;
            tally = tally.with(Tally::counted(pixels, wrong));
        }
    }
    Ok((smallest, tally))
}

fn plates(gap: f64, of_boxes: bool) -> Result<FrameScene, String> {
    let shape = |thin: f64| {
        if of_boxes {
            Shape::Cuboid {
                min: DVec3::new(-1.0, -thin, -1.0),
                max: DVec3::new(1.0, 0.0, 1.0),
            }
        } else {
            Shape::Mesh(0)
        }
    };
    let upper = DAffine3::from_translation(DVec3::Y * gap);
    // A thin box over the gap would be a second plate: its underside is the plate, its top far from the eye's
    // interest, so it is turned upside down.
    let flip = DAffine3::from_scale(DVec3::new(1.0, -1.0, 1.0));
    let mut scene = scene_of([
        (shape(0.25), DAffine3::IDENTITY),
        (shape(0.25), upper * flip),
    ]);
    let half_mirror = Material {
        color: Vec3::splat(0.8),
        diffuse: 0.5,
        reflection: Reflection::Constant(Vec3::splat(0.5)),
        ..Material::default()
    };
    let tinted = Material {
        color: Vec3::new(0.9, 0.6, 0.3),
        diffuse: 0.0,
        filter: 1.0,
        ..Material::default()
    };
    scene.materials = vec![half_mirror, tinted].into();
    let mut top = scene.instances[1];
    top.material = 1;
    scene.instances.set(1, top);
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let square = corners.map(|[x, z]| DVec3::new(x, 0.0, z)).to_vec();
    let square = MeshData::new("plate", square, Vec::new(), vec![[0, 2, 1], [0, 3, 2]])?;
    scene.meshes = vec![square.into()].into();
    scene.max_generations = 4;
    scene.background = Vec3::new(0.3, 0.5, 0.7).into();
    scene.lights.push(Light {
        color: Vec3::ONE,
        fade: None,
        kind: LightKind::Point {
            position: DVec3::new(0.5, 4.0, -0.3),
        },
    });
    // It sees nothing but the plates.
    scene.view = View {
        origin: DVec3::new(0.1, 2.5, 1.4),
        forward: DVec3::new(0.0, -0.88, -0.475).normalize(),
        right: DVec3::X * 0.3,
        up: DVec3::new(0.0, 0.475, -0.88).normalize() * 0.22,
        ..View::default()
    };
    Ok(ready(scene))
}
