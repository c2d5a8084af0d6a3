//! Things whose numbers are trouble: none, infinite, huge, tiny or singular. Called by the suite `input`.

use bevy_ecs::prelude::{EntityWorldMut, World};
use glam::{DQuat, DVec3, Vec3};
use orrery_engine::world::{
    Background, Cone, Cuboid, Cylinder, DirectionalLight, Disc, Fade, Lobe, Mesh, MeshData, Meshes,
    Plane, PointLight, Polygon, Reflection, Sphere, SpotLight, Surface, Torus, Transform,
};

use super::draw::Draw;
use super::scenes::materials;

/// Shapes that [`sized`] makes.
pub const SHAPES: usize = 8;
/// Those with an end, which come first.
pub const BOUNDED: usize = 7;
/// Finite, but where f32 or squares of it end.
const EXTREMES: [f64; 12] = [
    1e-300, 1e-42, 1e-38, 1e-30, 1e-20, 1e-17, 1e-9, 1e9, 1e17, 1e20, 1e38, 1e300,
];

/// Gives an entity one of [`SHAPES`], of these sizes: across, along, and a second one across.
pub fn sized(thing: &mut EntityWorldMut, shape: usize, [x, y, z]: [f64; 3]) {
    let (a, b) = (DVec3::NEG_Y * (0.5 * y), DVec3::Y * (0.5 * y));
    match shape {
        0 => thing.insert(Sphere { radius: x }),
        1 => thing.insert(Cuboid {
            min: DVec3::new(x, y, z) * -0.5,
            max: DVec3::new(x, y, z) * 0.5,
        }),
        2 => thing.insert(Disc {
            radius: x,
            normal: DVec3::new(0.0, y, z),
            ..Disc::default()
        }),
        3 => thing.insert(Cylinder {
            a,
            b,
            radius: x,
            open: false,
        }),
        4 => thing.insert(Cone {
            a,
            radius_a: x,
            b,
            radius_b: 0.3 * z,
            open: false,
        }),
        5 => thing.insert(Torus {
            major: x,
            minor: 0.3 * y,
        }),
        6 => thing.insert(Polygon {
            loops: vec![vec![
                DVec3::ZERO,
                DVec3::X * x,
                DVec3::new(x, y, 0.2 * z),
                DVec3::Y * y,
            ]],
        }),
        _ => thing.insert(Plane {
            normal: DVec3::new(0.0, y, z),
            distance: -3.0 * x,
        }),
    };
}

/// A shape that cannot be shown, by its pose or its size.
pub fn bad_shape(world: &mut World, mesh: Mesh, draw: &mut Draw) {
    let mut pose = Transform::from_translation(draw.cube() * 2.0);
    let mut size = [1.0; 3];
    let shape = draw.below(SHAPES + 1);
    match draw.below(5) {
        0 => pose.translation = spoiled(pose.translation, draw),
        1 => pose.rotation = spoiled_turn(draw),
        2 => pose.scale = spoiled(pose.scale, draw),
        3 => pose.scale = DVec3::new(1.0, 0.0, 1.0),
        // A mesh has no size of its own; what its vertices may be is tried here too.
        _ if shape == SHAPES => {
            bad_mesh(world, pose, draw);
            return;
        }
        _ => size = [(); 3].map(|()| worthless(draw)),
    }
    let mut thing = world.spawn(pose);
    if shape < SHAPES {
        sized(&mut thing, shape, size);
    } else {
        thing.insert(mesh);
    }
}

/// A finite shape of extreme sizes, scale or place, which may be shown.
pub fn extreme_shape(world: &mut World, mesh: Mesh, draw: &mut Draw) {
    let material = world.spawn(materials()[draw.below(4)]).id();
    let mut pose = Transform::from_translation(draw.cube());
    pose.rotation = DQuat::from_axis_angle(draw.direction(), draw.range(0.0, 6.0));
    let mut size = [1.0; 3];
    let changed = if draw.below(2) == 0 {
        pose.scale.as_mut()
    } else {
        &mut size
    };
    for length in changed {
        if draw.below(2) == 0 {
            *length = EXTREMES[draw.below(EXTREMES.len())];
        }
    }
    match draw.below(6) {
        // As if the whole of it were in other units.
        0 => {
            let factor = EXTREMES[draw.below(EXTREMES.len())];
            pose.scale = DVec3::splat(factor);
            size = [1.0; 3];
        }
        1 => pose.translation[draw.below(3)] = EXTREMES[draw.below(EXTREMES.len())],
        _ => {}
    }
    let shape = draw.below(SHAPES + 1);
    let mut thing = world.spawn((pose, Surface(material)));
    if shape < SHAPES {
        sized(&mut thing, shape, size);
    } else {
        thing.insert(mesh);
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

/// A light that cannot shine.
pub fn bad_light(world: &mut World, draw: &mut Draw) {
    let pose = Transform::from_translation(DVec3::new(-4.0, 5.0, 3.0));
    let color = Vec3::new(1.0, non_finite(draw) as f32, 0.5);
    let intensity = 1.0;
    let fade = |distance, power| PointLight {
        fade: Some(Fade {
            distance,
            power,
            ..Fade::default()
        }),
        ..PointLight::default()
    };
    match draw.below(6) {
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
        3 => world.spawn((pose, fade(non_finite(draw), 2.0))),
        4 => world.spawn((pose, fade(1.0, non_finite(draw)))),
        _ => world.spawn((
            pose,
            SpotLight {
                inner_angle: non_finite(draw),
                intensity: 1e38,
                ..SpotLight::default()
            },
        )),
    };
}

/// A light that fades in a finite but extreme way, and a sky of any numbers.
pub fn odd_sky(world: &mut World, draw: &mut Draw) {
    let mut extreme = || {
        let sign = [1.0, 1.0, -1.0][draw.below(3)];
        sign * [0.0, 1e-300, 1e-42, 1e-20, 1.0, 1e20, 1e38, 1e300][draw.below(8)]
    };
    let fade = Some(Fade {
        distance: extreme(),
        power: extreme(),
        ..Fade::default()
    });
    let (intensity, spread) = (extreme() as f32, extreme());
    let pose = Transform::from_translation(draw.cube() * 2.0);
    world.spawn((
        pose,
        PointLight {
            fade,
            intensity,
            ..PointLight::default()
        },
    ));
    world.spawn((
        pose,
        SpotLight {
            fade,
            inner_angle: spread,
            outer_angle: draw.unit(),
            ..SpotLight::default()
        },
    ));
    let mut sky = Vec3::splat(0.1);
    sky[draw.below(3)] = number(draw) as f32;
    world.insert_resource(Background::from(sky));
}

/// A sphere in front of a material with a bad number.
pub fn bad_material(world: &mut World, draw: &mut Draw) {
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
pub fn number(draw: &mut Draw) -> f64 {
    match draw.below(8) {
        0..=2 => non_finite(draw),
        3 => 1e38,
        4 => -1e38,
        5 => 1e-42,
        6 => 0.0,
        _ => -1.0,
    }
}

/// No size of anything, be it across, along or a length that is divided by.
fn worthless(draw: &mut Draw) -> f64 {
    match draw.below(5) {
        0..=2 => non_finite(draw),
        3 => 0.0,
        _ => 1e200,
    }
}

fn non_finite(draw: &mut Draw) -> f64 {
    [f64::NAN, f64::INFINITY, f64::NEG_INFINITY][draw.below(3)]
}

/// One coordinate beyond use.
pub fn spoiled(mut v: DVec3, draw: &mut Draw) -> DVec3 {
    v[draw.below(3)] = non_finite(draw);
    v
}

/// A turn with a number that is none.
pub fn spoiled_turn(draw: &mut Draw) -> DQuat {
    let x = non_finite(draw);
    DQuat::from_xyzw(x, 0.0, 0.0, 1.0)
}
