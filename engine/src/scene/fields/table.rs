//! The table of fields: path, kind, range, getter, setter. A new component adds its rows here.

use bevy_ecs::prelude::*;

use super::{Field, FieldKind, Value};
use crate::scene::schema::{Angle, from_degrees, range, to_degrees};
use crate::scene::writer::Writer;
use crate::world::{
    Camera, ClipLayer, ClipPlayer, Cone, Cuboid, Cylinder, DirectionalLight, Disc, Fade, KeyFrames,
    Lobe, Material, Morph, Plane, PointLight, Projection, Reflection, Sphere, SpotLight, ToneMap,
    Torus, Transform, Twist, Visibility, Wave,
};

/// `field!(path: Kind in [Components], getter to an option, setter, range)`. The setter works on a copy; the
/// component is written, and counts as changed, only if the copy differs.
macro_rules! field {
    ($path:literal: $kind:ident in [$($component:ty),+], $get:expr, $set:expr) => {
        field!($path: $kind in [$($component),+], $get, $set, |_| Ok(()))
    };
    ($path:literal: $kind:ident in [$($component:ty),+], $get:expr, $set:expr, $range:expr) => {
        Field {
            path: $path,
            kind: FieldKind::$kind,
            range: |value| match value {
                Value::$kind(value) => typed($range, value),
                _ => Err("another kind of value"),
            },
            is_on: |entity| false $(|| entity.contains::<$component>())+,
            get: |entity| {
                $(if let Some(component) = entity.get::<$component>() {
                    return read(component, $get).map(Value::$kind);
                })+
                None
            },
            set: |entity, value| {
                let Value::$kind(value) = value else { return None };
                $(if let Some(mut component) = entity.get_mut::<$component>() {
                    let mut next = Clone::clone(&*component);
                    write(&mut next, value.clone(), $set);
                    return Some(component.set_if_neq(next));
                })+
                None
            },
        }
    };
}

/// These three give the closures of [`field`] their argument types.
fn typed<T>(range: fn(&T) -> range::Check, value: &T) -> range::Check {
    range(value)
}
fn read<C, T>(component: &C, get: fn(&C) -> Option<T>) -> Option<T> {
    get(component)
}
fn write<C, T>(component: &mut C, value: T, set: fn(&mut C, T)) {
    set(component, value);
}

fn not_negative(value: &f64) -> range::Check {
    range::not_negative(&(*value as f32))
}
fn share(value: &f64) -> range::Check {
    range::share(&(*value as f32))
}
fn color(value: &glam::DVec3) -> range::Check {
    if value.min_element() >= 0.0 {
        Ok(())
    } else {
        Err("numbers of at least 0")
    }
}
fn opening(degrees: &f64) -> range::Check {
    range::opening(&Angle(from_degrees(*degrees)))
}
fn half_angle(degrees: &f64) -> range::Check {
    range::half_angle(&Angle(from_degrees(*degrees)))
}
fn unit(value: &glam::DQuat) -> range::Check {
    if (value.length() - 1.0).abs() < 1e-6 {
        Ok(())
    } else {
        Err("a unit quaternion")
    }
}

fn within_million(weight: &f64) -> range::Check {
    if weight.abs() <= 1e6 {
        Ok(())
    } else {
        Err("a number within 1e6")
    }
}
fn weight(morph: &Morph, target: usize) -> Option<f64> {
    morph.weights.get(target).copied()
}
fn set_weight(morph: &mut Morph, target: usize, value: f64) {
    if let Some(weight) = morph.weights.get_mut(target) {
        *weight = value;
    }
}

fn layer<T>(player: &ClipPlayer, row: usize, get: fn(&ClipLayer) -> T) -> Option<T> {
    player.layers.get(row).map(get)
}
fn set_layer(player: &mut ClipPlayer, row: usize, set: impl FnOnce(&mut ClipLayer)) {
    player.layers.get_mut(row).map(set);
}
/// The name of the first clip that is played.
fn clip_name(player: &ClipPlayer) -> Option<String> {
    let row = player.layers.first()?.clip;
    player.clips.clips().get(row).map(|clip| clip.name.clone())
}
/// Plays another clip in place of the first; a name that the model does not have changes nothing.
fn set_clip(player: &mut ClipPlayer, name: &str) {
    let row = player
        .clips
        .clips()
        .iter()
        .position(|clip| clip.name == name);
    if let (Some(row), Some(layer)) = (row, player.layers.first_mut()) {
        layer.clip = row;
    }
}

const TONE_MAPS: [ToneMap; 3] = [ToneMap::Clip, ToneMap::Reinhard, ToneMap::Filmic];

fn tone_map(word: &str) -> Option<ToneMap> {
    TONE_MAPS
        .into_iter()
        .find(|tone_map| Writer::text_of(tone_map) == word)
}

/// Every field there is; `transform.translation` is the first.
pub fn all() -> &'static [Field] {
    FIELDS
}

static FIELDS: &[Field] = &[
    field!("transform.translation": Vec3 in [Transform],
        |c| Some(c.translation), |c, v| c.translation = v),
    field!("transform.rotation": Rotation in [Transform],
        |c| Some(c.rotation), |c, v| c.rotation = v, unit),
    field!("transform.scale": Vec3 in [Transform], |c| Some(c.scale), |c, v| c.scale = v),
    field!("visible": Bool in [Visibility], |c| Some(c.shown), |c, v| c.shown = v),
    field!("sphere.radius": Number in [Sphere],
        |c| Some(c.radius), |c, v| c.radius = v, range::positive),
    field!("plane.normal": Vec3 in [Plane],
        |c| Some(c.normal), |c, v| c.normal = v, range::direction),
    field!("plane.distance": Number in [Plane], |c| Some(c.distance), |c, v| c.distance = v),
    field!("box.min": Vec3 in [Cuboid], |c| Some(c.min), |c, v| c.min = v),
    field!("box.max": Vec3 in [Cuboid], |c| Some(c.max), |c, v| c.max = v),
    field!("disc.center": Vec3 in [Disc], |c| Some(c.center), |c, v| c.center = v),
    field!("disc.normal": Vec3 in [Disc],
        |c| Some(c.normal), |c, v| c.normal = v, range::direction),
    field!("disc.radius": Number in [Disc],
        |c| Some(c.radius), |c, v| c.radius = v, range::positive),
    field!("cylinder.a": Vec3 in [Cylinder], |c| Some(c.a), |c, v| c.a = v),
    field!("cylinder.b": Vec3 in [Cylinder], |c| Some(c.b), |c, v| c.b = v),
    field!("cylinder.radius": Number in [Cylinder],
        |c| Some(c.radius), |c, v| c.radius = v, range::positive),
    field!("cylinder.open": Bool in [Cylinder], |c| Some(c.open), |c, v| c.open = v),
    field!("cone.a": Vec3 in [Cone], |c| Some(c.a), |c, v| c.a = v),
    field!("cone.radius_a": Number in [Cone],
        |c| Some(c.radius_a), |c, v| c.radius_a = v, range::radius),
    field!("cone.b": Vec3 in [Cone], |c| Some(c.b), |c, v| c.b = v),
    field!("cone.radius_b": Number in [Cone],
        |c| Some(c.radius_b), |c, v| c.radius_b = v, range::radius),
    field!("cone.open": Bool in [Cone], |c| Some(c.open), |c, v| c.open = v),
    field!("torus.major": Number in [Torus],
        |c| Some(c.major), |c, v| c.major = v, range::positive),
    field!("torus.minor": Number in [Torus],
        |c| Some(c.minor), |c, v| c.minor = v, range::positive),
    field!("deform.keys.start": Number in [KeyFrames], |c| Some(c.start), |c, v| c.start = v),
    field!("deform.morph.weights.0": Number in [Morph],
        |c| weight(c, 0), |c, v| set_weight(c, 0, v), within_million),
    field!("deform.morph.weights.1": Number in [Morph],
        |c| weight(c, 1), |c, v| set_weight(c, 1, v), within_million),
    field!("deform.morph.weights.2": Number in [Morph],
        |c| weight(c, 2), |c, v| set_weight(c, 2, v), within_million),
    field!("deform.morph.weights.3": Number in [Morph],
        |c| weight(c, 3), |c, v| set_weight(c, 3, v), within_million),
    field!("deform.wave.length": Number in [Wave],
        |c| Some(c.length), |c, v| c.length = v, range::positive),
    field!("deform.wave.amplitude": Vec3 in [Wave],
        |c| Some(c.amplitude), |c, v| c.amplitude = v),
    field!("deform.wave.phase": Number in [Wave],
        |c| Some(to_degrees(c.phase)), |c, v| c.phase = from_degrees(v)),
    field!("deform.twist.rate": Number in [Twist],
        |c| Some(to_degrees(c.rate)), |c, v| c.rate = from_degrees(v)),
    field!("deform.twist.swing": Number in [Twist],
        |c| Some(to_degrees(c.swing)), |c, v| c.swing = from_degrees(v)),
    field!("deform.twist.angle": Number in [Twist],
        |c| Some(to_degrees(c.angle)), |c, v| c.angle = from_degrees(v)),
    field!("clip.name": Text in [ClipPlayer],
        clip_name, |c, v| set_clip(c, &v)),
    field!("clip.start": Number in [ClipPlayer],
        |c| layer(c, 0, |l| l.start), |c, v| set_layer(c, 0, |l| l.start = v)),
    field!("clip.speed": Number in [ClipPlayer],
        |c| layer(c, 0, |l| l.speed), |c, v| set_layer(c, 0, |l| l.speed = v)),
    field!("clip.weight": Number in [ClipPlayer],
        |c| layer(c, 0, |l| l.weight), |c, v| set_layer(c, 0, |l| l.weight = v), range::radius),
    field!("clip.paused": Bool in [ClipPlayer],
        |c| layer(c, 0, |l| l.paused), |c, v| set_layer(c, 0, |l| l.paused = v)),
    field!("clip.1.start": Number in [ClipPlayer],
        |c| layer(c, 1, |l| l.start), |c, v| set_layer(c, 1, |l| l.start = v)),
    field!("clip.1.speed": Number in [ClipPlayer],
        |c| layer(c, 1, |l| l.speed), |c, v| set_layer(c, 1, |l| l.speed = v)),
    field!("clip.1.weight": Number in [ClipPlayer],
        |c| layer(c, 1, |l| l.weight), |c, v| set_layer(c, 1, |l| l.weight = v), range::radius),
    field!("clip.1.paused": Bool in [ClipPlayer],
        |c| layer(c, 1, |l| l.paused), |c, v| set_layer(c, 1, |l| l.paused = v)),
    field!("clip.2.start": Number in [ClipPlayer],
        |c| layer(c, 2, |l| l.start), |c, v| set_layer(c, 2, |l| l.start = v)),
    field!("clip.2.speed": Number in [ClipPlayer],
        |c| layer(c, 2, |l| l.speed), |c, v| set_layer(c, 2, |l| l.speed = v)),
    field!("clip.2.weight": Number in [ClipPlayer],
        |c| layer(c, 2, |l| l.weight), |c, v| set_layer(c, 2, |l| l.weight = v), range::radius),
    field!("clip.2.paused": Bool in [ClipPlayer],
        |c| layer(c, 2, |l| l.paused), |c, v| set_layer(c, 2, |l| l.paused = v)),
    field!("clip.3.start": Number in [ClipPlayer],
        |c| layer(c, 3, |l| l.start), |c, v| set_layer(c, 3, |l| l.start = v)),
    field!("clip.3.speed": Number in [ClipPlayer],
        |c| layer(c, 3, |l| l.speed), |c, v| set_layer(c, 3, |l| l.speed = v)),
    field!("clip.3.weight": Number in [ClipPlayer],
        |c| layer(c, 3, |l| l.weight), |c, v| set_layer(c, 3, |l| l.weight = v), range::radius),
    field!("clip.3.paused": Bool in [ClipPlayer],
        |c| layer(c, 3, |l| l.paused), |c, v| set_layer(c, 3, |l| l.paused = v)),
    field!("light.color": Vec3 in [PointLight, DirectionalLight, SpotLight],
        |c| Some(c.color.as_dvec3()), |c, v| c.color = v.as_vec3(), color),
    field!("light.intensity": Number in [PointLight, DirectionalLight, SpotLight],
        |c| Some(f64::from(c.intensity)), |c, v| c.intensity = v as f32, not_negative),
    field!("light.fade.distance": Number in [PointLight, SpotLight],
        |c| c.fade.map(|fade| fade.distance),
        |c, v| c.fade.get_or_insert(Fade::default()).distance = v, range::positive),
    field!("light.fade.power": Number in [PointLight, SpotLight],
        |c| c.fade.map(|fade| fade.power),
        |c, v| c.fade.get_or_insert(Fade::default()).power = v, range::positive),
    field!("light.fade.exact": Bool in [PointLight, SpotLight],
        |c| c.fade.map(|fade| fade.exact),
        |c, v| c.fade.get_or_insert(Fade::default()).exact = v),
    field!("light.fade.range": Number in [PointLight, SpotLight],
        |c| c.fade?.range,
        |c, v| c.fade.get_or_insert(Fade::default()).range = Some(v), range::positive),
    field!("light.inner_angle": Number in [SpotLight],
        |c| Some(to_degrees(c.inner_angle)), |c, v| c.inner_angle = from_degrees(v), half_angle),
    field!("light.outer_angle": Number in [SpotLight],
        |c| Some(to_degrees(c.outer_angle)), |c, v| c.outer_angle = from_degrees(v), half_angle),
    field!("camera.fov": Number in [Camera],
        |c| match c.projection {
            Projection::Perspective { vertical_fov } => Some(to_degrees(vertical_fov)),
            Projection::Orthographic { .. } => None,
        },
        |c, v| c.projection = Projection::Perspective { vertical_fov: from_degrees(v) }, opening),
    field!("camera.orthographic_height": Number in [Camera],
        |c| match c.projection {
            Projection::Orthographic { height } => Some(height),
            Projection::Perspective { .. } => None,
        },
        |c, v| c.projection = Projection::Orthographic { height: v }, range::positive),
    field!("camera.exposure": Number in [Camera],
        |c| Some(f64::from(c.exposure)), |c, v| c.exposure = v as f32),
    field!("camera.tone_map": Text in [Camera],
        |c| Some(Writer::text_of(&c.tone_map)),
        |c, v| c.tone_map = tone_map(&v).unwrap_or(c.tone_map),
        |word| tone_map(word).map(|_| ()).ok_or("Clip, Reinhard or Filmic")),
    field!("material.color": Vec3 in [Material],
        |c| Some(c.color.as_dvec3()), |c, v| c.color = v.as_vec3(), color),
    field!("material.diffuse": Number in [Material],
        |c| Some(f64::from(c.diffuse)), |c, v| c.diffuse = v as f32, not_negative),
    field!("material.emission": Number in [Material],
        |c| Some(f64::from(c.emission)), |c, v| c.emission = v as f32, not_negative),
    field!("material.phong.strength": Number in [Material],
        |c| c.phong.map(|lobe| f64::from(lobe.strength)),
        |c, v| c.phong.get_or_insert(Lobe::default()).strength = v as f32, not_negative),
    field!("material.phong.exponent": Number in [Material],
        |c| c.phong.map(|lobe| f64::from(lobe.exponent)),
        |c, v| c.phong.get_or_insert(Lobe::default()).exponent = v as f32, not_negative),
    field!("material.specular.strength": Number in [Material],
        |c| c.specular.map(|lobe| f64::from(lobe.strength)),
        |c, v| c.specular.get_or_insert(Lobe::default()).strength = v as f32, not_negative),
    field!("material.specular.exponent": Number in [Material],
        |c| c.specular.map(|lobe| f64::from(lobe.exponent)),
        |c, v| c.specular.get_or_insert(Lobe::default()).exponent = v as f32, not_negative),
    field!("material.reflection": Vec3 in [Material],
        |c| match c.reflection {
            Reflection::None => Some(glam::DVec3::ZERO),
            Reflection::Constant(color) => Some(color.as_dvec3()),
            Reflection::Fresnel => None,
        },
        |c, v| c.reflection = Reflection::Constant(v.as_vec3()), color),
    field!("material.transmit": Number in [Material],
        |c| Some(f64::from(c.transmit)), |c, v| c.transmit = v as f32, share),
    field!("material.filter": Number in [Material],
        |c| Some(f64::from(c.filter)), |c, v| c.filter = v as f32, share),
    field!("material.ior": Number in [Material],
        |c| Some(c.ior), |c, v| c.ior = v, range::positive),
    field!("material.absorption": Vec3 in [Material],
        |c| Some(c.absorption.as_dvec3()), |c, v| c.absorption = v.as_vec3(), color),
];
