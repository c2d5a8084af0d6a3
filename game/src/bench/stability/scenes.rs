//! Small scenes with something of everything, moved and scaled.

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};
use orrery_engine::frame::{FrameScene, Instance, Light, LightKind, Shape, View};
use orrery_engine::trace::Picture;
use orrery_engine::world::{Cone, Fade, Lobe, Material, Reflection};

use super::course::ready;
use super::draw::Draw;
use super::solids::Solid;
use crate::failure::Failure;

/// Shapes in a scene beside its floor.
const SHAPES: usize = 14;

/// Random shapes of every kind and material over a floor, under lights of every kind. Positions are multiples
/// of 2^-16, so that they stay exact in f64 wherever whole numbers move them.
pub fn mixed(seed: u64) -> Result<FrameScene, Failure> {
    let mut draw = Draw::of(1000, seed);
    let mesh = Solid::icosphere(2).mesh().map_err(Failure::Input)?;
    let mut scene = FrameScene {
        background: Vec3::new(0.2, 0.3, 0.4).into(),
        max_generations: 6,
        materials: materials().to_vec().into(),
        meshes: vec![mesh.into()].into(),
        view: View {
            origin: DVec3::new(0.0, 1.0, 9.0),
            right: DVec3::X * 1.2,
            up: DVec3::Y * 0.9,
            ..View::default()
        },
        ..FrameScene::default()
    };
    let floor = Shape::Plane {
        normal: DVec3::Y,
        distance: 0.0,
    };
    let below = DAffine3::from_translation(DVec3::NEG_Y * 4.0);
    let material = draw.below(materials().len()) as u32;
    scene.instances.push(instance(floor, below, material));
    for _ in 0..SHAPES {
        let shape = shape(&mut draw);
        let pose = pose(&mut draw);
        let material = draw.below(materials().len()) as u32;
        scene.instances.push(instance(shape, pose, material));
    }
    for light in lights() {
        scene.lights.push(light);
    }
    Ok(ready(scene))
}

fn shape(draw: &mut Draw) -> Shape {
    match draw.below(6) {
        3 => Shape::Disc {
            center: DVec3::ZERO,
            normal: DVec3::new(0.0, 0.8, 0.6),
            radius: 0.75,
        },
        4 => Shape::Cone(Cone {
            a: DVec3::NEG_Y,
            radius_a: 0.75,
            b: DVec3::Y,
            radius_b: [0.75, 0.25, 0.0][draw.below(3)],
            open: false,
        }),
        5 => Shape::Torus {
            major: 0.75,
            minor: 0.25,
        },
        0 => Shape::Sphere { radius: 0.75 },
        1 => Shape::Cuboid {
            min: DVec3::splat(-0.5),
            max: DVec3::new(0.5, 0.625, 0.375),
        },
        _ => Shape::Mesh(0),
    }
}

fn pose(draw: &mut Draw) -> DAffine3 {
    let at = on_grid(draw.cube() * 3.0);
    let turn = DQuat::from_axis_angle(draw.direction(), draw.range(0.0, 6.3));
    let even = draw.range(0.3, 1.0);
    let scale = match draw.below(2) {
        0 => DVec3::splat(even),
        _ => DVec3::new(-even, draw.range(0.3, 1.0), draw.range(0.3, 1.0)),
    };
    DAffine3::from_scale_rotation_translation(scale, turn, at)
}

fn on_grid(p: DVec3) -> DVec3 {
    (p * 65_536.0).round() / 65_536.0
}

fn instance(shape: Shape, world_from_local: DAffine3, material: u32) -> Instance {
    Instance {
        tag: 0,
        shape,
        world_from_local,
        material,
    }
}

/// Matte, mirror, glass and tinted.
pub fn materials() -> [Material; 4] {
    let plain = Material::default();
    [
        Material {
            color: Vec3::new(0.7, 0.4, 0.3),
            specular: Some(Lobe::default()),
            ..plain
        },
        Material {
            color: Vec3::splat(0.2),
            reflection: Reflection::Constant(Vec3::new(0.7, 0.75, 0.8)),
            ..plain
        },
        Material {
            color: Vec3::ONE,
            diffuse: 0.0,
            reflection: Reflection::Fresnel,
            transmit: 1.0,
            ior: 1.5,
            ..plain
        },
        Material {
            color: Vec3::new(0.3, 0.8, 0.5),
            diffuse: 0.5,
            filter: 0.7,
            transmit: 0.1,
            ..plain
        },
    ]
}

fn lights() -> [Light; 3] {
    let color = Vec3::splat(0.6);
    let fade = Some(Fade {
        distance: 8.0,
        power: 2.0,
        ..Fade::default()
    });
    [
        Light {
            color,
            fade,
            kind: LightKind::Point {
                position: DVec3::new(4.0, 7.0, 6.0),
            },
        },
        Light {
            color: color * 0.5,
            fade: None,
            kind: LightKind::Directional {
                to_light: DVec3::new(-0.48, 0.6, 0.64),
            },
        },
        Light {
            color,
            fade: None,
            kind: LightKind::Spot {
                position: DVec3::new(-6.0, 3.0, 5.0),
                axis: DVec3::new(0.768, -0.28, -0.576),
                cos_inner: 0.9,
                cos_outer: 0.7,
            },
        },
    ]
}

/// The same scene elsewhere.
pub fn moved(scene: &FrameScene, by: DVec3) -> FrameScene {
    changed(scene, |p| p + by, 1.0)
}

/// The same scene larger or smaller, its eye too.
pub fn scaled(scene: &FrameScene, factor: f64) -> FrameScene {
    changed(scene, |p| p * factor, factor)
}

/// The same scene with its positions in f32, as where there is no f64.
pub fn rounded(scene: &FrameScene) -> FrameScene {
    changed(scene, |p| p.as_vec3().as_dvec3(), 1.0)
}

fn changed(scene: &FrameScene, place: impl Fn(DVec3) -> DVec3, scale: f64) -> FrameScene {
    let mut other = scene.clone();
    let enlarge = DMat3::from_diagonal(DVec3::splat(scale));
    for (row, instance) in scene.instances.iter().enumerate() {
        let map = instance.world_from_local;
        let map = DAffine3::from_mat3_translation(enlarge * map.matrix3, place(map.translation));
        let instance = Instance {
            world_from_local: map,
            ..*instance
        };
        other.instances.set(row as u32, instance);
    }
    let lights = scene.lights.iter().map(|light| {
        let mut light = *light;
        match &mut light.kind {
            LightKind::Point { position } | LightKind::Spot { position, .. } => {
                *position = place(*position);
            }
            LightKind::Directional { .. } => {}
        }
        light.fade = light.fade.map(|fade| Fade {
            distance: fade.distance * scale,
            ..fade
        });
        light
    });
    other.lights.assign(lights);
    other.view.origin = place(scene.view.origin);
    other
}

/// Pixels that are not the same bit for bit.
pub fn unequal(a: &Picture, b: &Picture) -> u64 {
    let bits = |p: &Vec3| p.to_array().map(f32::to_bits);
    let pairs = a.pixels.iter().zip(&b.pixels);
    pairs.filter(|(a, b)| bits(a) != bits(b)).count() as u64
}

/// Pixels that are off by more than `most` in a channel, or not a number.
pub fn off(a: &Picture, b: &Picture, most: f32) -> u64 {
    let is_near = |a: &Vec3, b: &Vec3| (*a - *b).abs().cmple(Vec3::splat(most)).all();
    let pairs = a.pixels.iter().zip(&b.pixels);
    pairs.filter(|(a, b)| !is_near(a, b)).count() as u64
}
