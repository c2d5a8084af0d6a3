//! Rays that leave a solid, whatever its pose, do not meet it where they start.

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};

use super::surface::resolve;
use super::traverse::{Key, Probe, Stack, Start, trace};
use crate::frame::{FrameScene, Instance, Shape, TraceSettings};
use crate::geom::testing::Random;
use crate::trace::PackedScene;
use crate::world::Material;

/// A disc, a cylinder, a cone, a truncated one or a torus, of a size.
fn solid(random: &mut Random, number: usize, size: f64) -> Shape {
    let (a, b) = (random.cube() * size, random.direction() * (2.0 * size));
    let cone = |radius_a: f64, radius_b: f64| Shape::Cone {
        a,
        radius_a: radius_a * size,
        b: a + b,
        radius_b: radius_b * size,
    };
    match number % 5 {
        0 => Shape::Disc {
            center: a,
            normal: b,
            radius: size,
        },
        1 => cone(0.5, 0.5),
        2 => cone(0.7, 0.0),
        3 => cone(random.range(0.1, 0.9), random.range(0.1, 0.9)),
        _ => Shape::Torus {
            major: size,
            minor: size * random.range(0.05, 0.95),
        },
    }
}

/// Turned, sheared, mirrored, stretched and up to a hundred sizes away.
fn pose(random: &mut Random, size: f64) -> DAffine3 {
    let turn = |random: &mut Random| {
        DMat3::from_quat(DQuat::from_axis_angle(
            random.direction(),
            random.range(0.0, 6.0),
        ))
    };
    let stretch = DVec3::from([(); 3].map(|()| 10_f64.powf(random.range(-0.7, 0.7))));
    let mirror = if random.unit() < 0.5 { -1.0 } else { 1.0 };
    let linear = turn(random) * DMat3::from_diagonal(stretch * mirror) * turn(random);
    let away = random.direction() * (size * 10_f64.powf(random.range(0.0, 2.0)));
    DAffine3::from_mat3_translation(linear, away)
}

/// A point the instance reaches around, in the world.
fn target(random: &mut Random, instance: &Instance) -> DVec3 {
    let local = match instance.shape {
        Shape::Cone { a, b, .. } => a.lerp(b, random.unit()),
        Shape::Disc { center, radius, .. } => center + random.cube() * (radius * 0.5),
        Shape::Torus { major, .. } => {
            let out = random.cube() * DVec3::new(1.0, 0.0, 1.0);
            out.normalize_or(DVec3::X) * major
        }
        _ => DVec3::ZERO,
    };
    instance.world_from_local.transform_point3(local)
}

fn packed(instance: Instance) -> PackedScene {
    let scene = FrameScene {
        materials: vec![Material::default()].into(),
        instances: vec![instance].into(),
        ..FrameScene::default()
    };
    let mut packed = PackedScene::default();
    packed.refit(&scene);
    packed.pack(&scene, &TraceSettings::default());
    packed
}

fn probe(origin: Vec3, dir: Vec3, start: Start) -> Probe {
    Probe {
        origin,
        dir,
        after: Key::after(0.0),
        before: Key::before(f32::MAX),
        start,
    }
}

#[test]
fn rays_that_leave_a_posed_solid_do_not_meet_it() {
    let mut random = Random::new(41);
    let (mut left, mut met) = (0, 0);
    let mut stack = Stack::default();
    for number in 0..2_000 {
        let size = 10_f64.powf(random.range(-3.0, 3.0));
        let instance = Instance {
            tag: 0,
            shape: solid(&mut random, number, size),
            world_from_local: pose(&mut random, size),
            material: 0,
        };
        let scene = packed(instance);
        for ray in 0..100 {
            let at = target(&mut random, &instance);
            let from = at + random.direction() * (size * 20.0);
            let (origin, dir) = (from.as_vec3(), (at - from).normalize().as_vec3());
            let start = probe(origin, dir, Start::FREE);
            let Some(found) = trace::<false>(&scene, &start, &mut stack) else {
                continue;
            };
            let surface = resolve(&scene, &found, origin, dir);
            if is_hollow(&instance, surface.position) {
                continue;
            }
            // Outward, half of them grazing.
            let normal = surface.n_geom.as_dvec3();
            let steepness = if ray % 2 == 0 {
                random.unit()
            } else {
                10_f64.powf(random.range(-4.0, -1.0))
            };
            let flat = random
                .direction()
                .reject_from_normalized(normal.normalize());
            let away = (flat.normalize() + normal * steepness).as_vec3();
            let leaving = probe(surface.origin_towards(away), away, surface.start);
            left += 1;
            met += u32::from(trace::<true>(&scene, &leaving, &mut stack).is_some());
        }
    }
    assert!(left > 100_000, "only {left} rays left a surface");
    assert_eq!(met, 0, "{met} of {left} rays met the solid they left");
}

/// Whether a point is on the inner half of a torus, from where a ray may well meet it again.
fn is_hollow(instance: &Instance, point: Vec3) -> bool {
    let local = instance.world_from_local.inverse();
    let p = local.transform_point3(point.as_dvec3());
    match instance.shape {
        Shape::Torus { major, .. } => p.x.hypot(p.z) < major,
        _ => false,
    }
}
