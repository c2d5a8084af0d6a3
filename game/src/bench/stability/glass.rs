//! Long chains of refractions and reflections: slabs, mirrors, and the edge of total internal reflection.
//!
//! *Slabs*: behind parallel slabs, side by side or one in another, a bright edge a million units away is seen through
//! pixels of 1e-7 radians; where it appears is the direction that rays leave in. *Mirrors*: rays that
//! leave a corridor of two mirrors after n bounces must have been weighted by exactly k^n. *Total*: a face met at angles
//! around the critical one, in steps of 1e-7 radians.

use glam::{DAffine3, DMat3, DVec3, UVec2, Vec3};
use orrery_engine::frame::{FrameScene, Kernels, Offset, Shape, View};
use orrery_engine::trace::Picture;
use orrery_engine::trace::reference::ReferenceTracer;
use orrery_engine::world::{Material, Reflection};

use super::course::{Course, ready, scene_of, settings};
use super::tally::{Tally, Verdict};
use crate::failure::Failure;
use crate::stage::traced;

/// The suite.
pub const NAME: &str = "glass";
/// Radians between pixels.
const STEP: f64 = 1e-7;
/// Largest error of a direction.
const MOST: f64 = 1e-6;
/// How much a mirror reflects.
const KEPT: f32 = 0.9;
/// Pixels on either side of one in which f64 may have its value: directions are f32.
const WINDOW: usize = 8;

/// Runs all three.
pub fn run(course: &mut Course) -> Result<(), Failure> {
    slabs(course)?;
    mirrors(course)?;
    total(course)
}

/// The picture by the tracer, and by f64.
fn both(
    course: &mut Course,
    scene: &FrameScene,
    size: UVec2,
    kernels: Kernels,
) -> Result<[Picture; 2], Failure> {
    let found = course.picture(scene, size, kernels)?;
    let mut exact = ReferenceTracer::new();
    let truth = traced(&mut exact, scene, &settings(size, Kernels::default()))?;
    Ok([found, truth])
}

fn slabs(course: &mut Course) -> Result<(), Failure> {
    let size = UVec2::new(201, 1);
    let mut always_air = Tally::default();
    for inner in 1..8 {
        let off = leaving_with_air(0.4, inner) - 0.4;
        always_air.take(Verdict::of(off.abs() <= MOST));
    }
    course.must_fail(&format!("{NAME}.slabs.always_air"), &always_air, None);
    // Each index and its reciprocal are rounded, which adds up: 62 surfaces have no target.
    for (word, counts, is_nested, target) in [
        ("stacked_16", &[1, 2, 4, 8, 16][..], false, Some(MOST)),
        ("stacked_31", &[31], false, None),
        ("nested_7", &[2, 3, 5, 7], true, Some(MOST)),
    ] {
        let mut tally = Tally::default();
        let mut worst = 0.0_f64;
        for &count in counts {
            for tilt in [0.0, 0.2, 0.5, 0.8] {
                let scene = slab_scene(count, is_nested, tilt, f64::from(size.x) * STEP);
                let pictures = both(course, &scene, size, Kernels::default())?;
                let [found, truth] = pictures.map(|picture| bright(&picture));
                let off = (found - truth).abs() * STEP;
                worst = worst.max(off);
                tally.take(Verdict::of(off <= MOST));
            }
        }
        let name = format!("{NAME}.slabs.{word}");
        course.at_most(&name, "rad", &tally, worst, target);
    }
    Ok(())
}

/// Pixels that see the bright side.
fn bright(picture: &Picture) -> f64 {
    let shares = picture.pixels.iter().map(|p| f64::from(p.x));
    shares.map(f64::round).sum()
}

/// The angle in which a ray leaves slabs in one another if every exit were into air.
fn leaving_with_air(angle: f64, inner: u32) -> f64 {
    let index = |i: u32| 1.1 + 0.1 * f64::from(i);
    let mut sine = angle.sin();
    let mut top = 1.0;
    for i in 0..=inner {
        sine *= top / index(i);
        top = index(i);
    }
    for i in (0..=inner).rev() {
        sine *= index(i);
    }
    sine.clamp(-1.0, 1.0).asin()
}

/// Slabs across the view, and half a world of light far behind them.
fn slab_scene(count: u32, is_nested: bool, tilt: f64, wide: f64) -> FrameScene {
    let turn = DMat3::from_rotation_y(tilt);
    let slab = |i: u32| {
        let (middle, half) = if is_nested {
            (-3.0, 1.0 / f64::from(i + 1))
        } else {
            (-3.0 - 0.05 * f64::from(i), 0.02)
        };
        let shape = Shape::Cuboid {
            min: DVec3::new(-20.0, -20.0, -half),
            max: DVec3::new(20.0, 20.0, half),
        };
        let at = DVec3::Z * -3.0 + turn * DVec3::Z * (middle + 3.0);
        (shape, DAffine3::from_mat3_translation(turn, at))
    };
    let light = Shape::Cuboid {
        min: DVec3::new(0.0, -1.0, -0.1),
        max: DVec3::ONE,
    };
    let far = DAffine3::from_scale(DVec3::splat(1e5));
    let far = DAffine3::from_translation(DVec3::Z * -1e6) * far;
    let mut scene = scene_of((0..count).map(slab).chain([(light, far)]));
    let mut materials: Vec<Material> = (0..count)
        .map(|i| glass(1.3 + 0.05 * f64::from(i % 5)))
        .collect();
    materials.push(Material {
        color: Vec3::ONE,
        diffuse: 0.0,
        emission: 1.0,
        ..Material::default()
    });
    scene.materials = materials.into();
    for row in 0..=count {
        let mut instance = scene.instances[row as usize];
        instance.material = row;
        scene.instances.set(row, instance);
    }
    scene.max_generations = 64;
    scene.view = View {
        right: DVec3::X * wide,
        up: DVec3::Y * STEP,
        ..View::default()
    };
    ready(scene)
}

/// It lets everything through.
fn glass(ior: f64) -> Material {
    Material {
        color: Vec3::ONE,
        diffuse: 0.0,
        transmit: 1.0,
        ior,
        ..Material::default()
    }
}

fn mirrors(course: &mut Course) -> Result<(), Failure> {
    let fixed = Kernels {
        offsets: Offset::Fixed,
        ..Kernels::default()
    };
    let narrow = corridor(course, 1e-4, fixed)?;
    course.must_fail(&format!("{NAME}.mirrors.fixed"), &narrow, None);
    let tally = corridor(course, 1.0, Kernels::default())?;
    let tally = tally.with(corridor(course, 1e-4, Kernels::default())?);
    course.none_may_fail(&format!("{NAME}.mirrors"), &tally);
    Ok(())
}

/// Pixels whose rays bounced n times and do not have weight k^n, where f64 is sure of n.
fn corridor(course: &mut Course, scale: f64, kernels: Kernels) -> Result<Tally, Failure> {
    let size = UVec2::new(2, 1500);
    let wall = |y: f64, thick: f64| {
        let (low, high) = (y.min(y + thick), y.max(y + thick));
        let shape = Shape::Cuboid {
            min: DVec3::new(-1.0, low, -5.0) * scale,
            max: DVec3::new(30.0, high, 5.0) * scale,
        };
        (shape, DAffine3::IDENTITY)
    };
    let mut scene = scene_of([wall(-0.5, -0.2), wall(0.5, 0.2)]);
    let mirror = Material {
        color: Vec3::ONE,
        diffuse: 0.0,
        reflection: Reflection::Constant(Vec3::splat(KEPT)),
        ..Material::default()
    };
    scene.materials = vec![mirror].into();
    scene.background = Vec3::ONE.into();
    scene.max_generations = 64;
    scene.view = View {
        forward: DVec3::X,
        right: DVec3::Z * 0.01,
        up: DVec3::Y * 4.0,
        ..View::default()
    };
    let [found, truth] = both(course, &ready(scene), size, kernels)?;
    let bounces = |p: &Vec3| {
        let weight = f64::from(p.x);
        (weight > 0.0).then(|| (weight.ln() / f64::from(KEPT).ln()).round() as usize)
    };
    let known: Vec<Option<usize>> = truth.pixels.iter().map(bounces).collect();
    let wide = size.x as usize;
    let mut tally = Tally::default();
    for i in 2 * wide..known.len() - 2 * wide {
        let around = [i - 2 * wide, i - wide, i + wide, i + 2 * wide];
        if around.iter().any(|&j| known[j] != known[i]) {
            continue;
        }
        let weight = known[i].map_or(0.0, |n| (0..n).fold(1.0, |weight, _| weight * KEPT));
        tally.take(Verdict::of(found.pixels[i] == Vec3::splat(weight)));
    }
    Ok(tally)
}

fn total(course: &mut Course) -> Result<(), Failure> {
    const INDEX: f64 = 1.2;
    let mut textbook = Tally::default();
    let critical = (1.0 / INDEX).asin();
    for i in -1000..1000 {
        let cosine = (critical + f64::from(i) * STEP).cos() as f32;
        let share = unclamped_fresnel(INDEX as f32, cosine);
        textbook.take(Verdict::of((0.0..=1.0).contains(&share)));
    }
    course.must_fail(&format!("{NAME}.total.unclamped"), &textbook, None);
    let size = UVec2::new(4001, 1);
    let scene = prism(INDEX, f64::from(size.x) * STEP);
    let [found, truth] = both(course, &scene, size, Kernels::default())?;
    let mut tally = Tally::default();
    for (i, pixel) in found.pixels.iter().enumerate() {
        let first = i.saturating_sub(WINDOW);
        let last = (i + WINDOW).min(truth.pixels.len() - 1);
        let near = truth.pixels[first..=last].iter().map(|p| p.x);
        let (low, high) = near.fold((f32::MAX, f32::MIN), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        let is_right = pixel.is_finite() && (low - 2e-6..=high + 2e-6).contains(&pixel.x);
        tally.take(Verdict::of(is_right && (0.0..=1.0).contains(&pixel.x)));
    }
    course.none_may_fail(&format!("{NAME}.total"), &tally);
    Ok(())
}

/// Fresnel's formulas with Snell's law as they stand, in f32: beyond the critical angle they are no number.
fn unclamped_fresnel(index: f32, cosine: f32) -> f32 {
    let sine = index * (1.0 - cosine * cosine).sqrt();
    let beyond = (1.0 - sine * sine).sqrt();
    let s = (index * cosine - beyond) / (index * cosine + beyond);
    let p = (index * beyond - cosine) / (index * beyond + cosine);
    0.5 * (s * s + p * p)
}

/// A block of glass, looked into so that its side is met at the critical angle; what it reflects there is lost
/// in the generation after the last.
fn prism(index: f64, wide: f64) -> FrameScene {
    let block = Shape::Cuboid {
        min: DVec3::new(-10.0, -10.0, -5.0),
        max: DVec3::new(0.0, 0.0, 5.0),
    };
    let mut scene = scene_of([(block, DAffine3::IDENTITY)]);
    scene.materials = vec![Material {
        reflection: Reflection::Fresnel,
        ..glass(index)
    }]
    .into();
    scene.background = Vec3::ONE.into();
    scene.max_generations = 3;
    let sine = (index * index - 1.0).sqrt();
    let cosine = (1.0 - sine * sine).sqrt();
    let forward = DVec3::new(sine, -cosine, 0.0);
    scene.view = View {
        origin: DVec3::new(-0.1, 0.0, 0.0) - forward * 2.0,
        forward,
        right: DVec3::new(cosine, sine, 0.0) * wide,
        up: DVec3::Z * STEP,
        ..View::default()
    };
    ready(scene)
}
