//! Random components as scene files name them: what a random scene is put together from.

use glam::{DQuat, DVec3, Vec3};

use super::Chance;
use crate::scene::schema::{self as s, Rotation};
use crate::world::*;

pub(super) fn vector(chance: &mut Chance) -> DVec3 {
    DVec3::new(chance.number(), chance.number(), chance.number())
}

pub(super) fn color(chance: &mut Chance) -> Vec3 {
    vector(chance).abs().as_vec3()
}

pub(super) fn size(chance: &mut Chance) -> f64 {
    chance.number().abs() + 1e-3
}

pub(super) fn share(chance: &mut Chance) -> f32 {
    chance.number().abs().fract() as f32
}

pub(super) fn angle(chance: &mut Chance) -> f64 {
    chance.number().abs().fract() * 1.5 + 0.01
}

pub(super) fn rotation(chance: &mut Chance) -> Rotation {
    if chance.one_in(2) {
        Rotation::Euler(vector(chance))
    } else {
        let [x, y] = [vector(chance), vector(chance)];
        let quat = DQuat::from_xyzw(x.x, x.y, x.z, y.x);
        Rotation::Quat(if quat.length() > 0.0 {
            quat.normalize()
        } else {
            DQuat::IDENTITY
        })
    }
}

pub(super) fn lobe(chance: &mut Chance) -> Option<Lobe> {
    chance.one_in(2).then(|| Lobe {
        strength: share(chance),
        exponent: size(chance) as f32,
    })
}

pub(super) fn material(chance: &mut Chance) -> Material {
    let transmit = share(chance);
    Material {
        color: color(chance),
        diffuse: share(chance),
        emission: share(chance),
        phong: lobe(chance),
        specular: lobe(chance),
        reflection: match chance.below(4) {
            0 => Reflection::None,
            1 => Reflection::Fresnel,
            2 => Reflection::Constant(Vec3::splat(share(chance))),
            _ => Reflection::Constant(color(chance)),
        },
        transmit,
        filter: share(chance) * (1.0 - transmit),
        ior: size(chance),
        absorption: color(chance),
        alpha_cutoff: chance.one_in(2).then(|| share(chance)),
        ..Material::default()
    }
}

pub(super) fn fade(chance: &mut Chance) -> Option<Fade> {
    chance.one_in(2).then(|| Fade {
        distance: size(chance),
        power: size(chance),
        exact: chance.one_in(2),
        range: chance.one_in(2).then(|| size(chance)),
    })
}

pub(super) fn light(chance: &mut Chance) -> s::Light {
    let (color, intensity) = (color(chance), share(chance));
    match chance.below(3) {
        0 => s::Light::Point(PointLight {
            color,
            intensity,
            fade: fade(chance),
        }),
        1 => s::Light::Directional(DirectionalLight { color, intensity }),
        _ => {
            let inner_angle = angle(chance);
            let outer_angle = inner_angle + angle(chance);
            s::Light::Spot(SpotLight {
                color,
                intensity,
                fade: fade(chance),
                inner_angle,
                outer_angle,
            })
        }
    }
}

pub(super) fn shape(chance: &mut Chance) -> s::Shape {
    match chance.below(8) {
        0 => s::Shape::Sphere(Sphere {
            radius: size(chance),
        }),
        1 => s::Shape::Plane(Plane {
            normal: vector(chance) + DVec3::splat(0.5e8),
            distance: chance.number(),
        }),
        2 => {
            let min = vector(chance);
            s::Shape::Box(Cuboid {
                min,
                max: min + vector(chance).abs() + DVec3::splat(0.1),
            })
        }
        3 => s::Shape::Disc(Disc {
            center: vector(chance),
            normal: vector(chance) + DVec3::splat(0.5e8),
            radius: size(chance),
        }),
        4 => s::Shape::Cylinder(Cylinder {
            a: vector(chance),
            b: vector(chance) + DVec3::splat(0.5e8),
            radius: size(chance),
            open: chance.one_in(2),
        }),
        5 => s::Shape::Cone(Cone {
            a: vector(chance),
            radius_a: if chance.one_in(2) { 0.0 } else { size(chance) },
            b: vector(chance) + DVec3::splat(0.5e8),
            radius_b: size(chance),
            open: chance.one_in(2),
        }),
        6 => {
            let minor = size(chance);
            let major = minor * 2.0 + size(chance);
            s::Shape::Torus(Torus { major, minor })
        }
        _ => {
            let corners = [(0.0, 0.0), (3.0, 0.0), (2.0, 1.0), (0.0, 2.0)];
            let height = chance.number();
            s::Shape::Polygon(Polygon {
                loops: vec![corners.map(|(x, z)| DVec3::new(x, height, z)).to_vec()],
            })
        }
    }
}

pub(super) fn camera(chance: &mut Chance) -> Camera {
    Camera {
        projection: if chance.one_in(2) {
            Projection::Perspective {
                vertical_fov: angle(chance),
            }
        } else {
            Projection::Orthographic {
                height: size(chance),
            }
        },
        exposure: chance.number() as f32,
        tone_map: [ToneMap::Clip, ToneMap::Reinhard, ToneMap::Filmic][chance.below(3)],
    }
}

pub(super) fn period(chance: &mut Chance) -> f64 {
    [0.0, -2.5, chance.number()][chance.below(3)]
}

pub(super) fn motion(chance: &mut Chance) -> s::Motion {
    s::Motion {
        orbit: chance.one_in(3).then(|| Orbit {
            center: vector(chance),
            axis: vector(chance) + DVec3::splat(0.5e8),
            radius: chance.number(),
            period: period(chance),
            phase: angle(chance),
        }),
        spin: chance.one_in(3).then(|| Spin {
            axis: vector(chance) + DVec3::splat(0.5e8),
            period: period(chance),
            phase: angle(chance),
        }),
        sway: chance.one_in(3).then(|| Sway {
            amplitude: vector(chance),
            period: period(chance),
            phase: angle(chance),
        }),
        path: chance.one_in(3).then(|| PathMotion {
            points: (0..1 + chance.below(4)).map(|_| vector(chance)).collect(),
            period: period(chance),
            start: chance.number(),
            closed: chance.one_in(2),
            smooth: chance.one_in(2),
            look_along: chance.one_in(2),
        }),
    }
}

pub(super) fn deform(chance: &mut Chance) -> s::Deform {
    s::Deform {
        wave: chance.one_in(2).then(|| Wave {
            direction: vector(chance) + DVec3::splat(0.5e8),
            length: size(chance),
            amplitude: vector(chance),
            period: period(chance),
            phase: angle(chance),
        }),
        twist: chance.one_in(2).then(|| Twist {
            origin: vector(chance),
            axis: vector(chance) + DVec3::splat(0.5e8),
            rate: angle(chance),
            swing: angle(chance),
            period: period(chance),
            angle: angle(chance),
        }),
        ..s::Deform::default()
    }
}

pub(super) fn structure(chance: &mut Chance) -> Structure {
    let leaf = 1 + chance.below(8) as u32;
    let structures = [
        Structure::Boxes4,
        Structure::Boxes2,
        Structure::Spheres { leaf },
        Structure::None,
    ];
    structures[chance.below(4)]
}
