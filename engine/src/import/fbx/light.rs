//! Lights and cameras.
//!
//! FBX has no unit of light. Its `Intensity` is 100 times what the programs show that write it; that is ours. With
//! `DecayType` n a light of intensity I gives I / d^n at a distance of d units. Area and volume lights shine from a point.
//!
//! Blender writes watts as intensity, and means metres: there a light of W watts gives W / (4 pi d^2), d in metres
//! (and 1/pi of that is scattered by a white surface). Before 2.80 it had no watts: there light with inverse square has its
//! full strength at the light and half of it at its `DecayStart`, which is POV-Ray's falloff.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec3, Vec3};
use ufbx::{Camera as FbxCamera, Exporter, Light, LightDecay, LightType, ProjectionMode, Scene};

use super::number;
use crate::import::Content;
use crate::world::{Camera, DirectionalLight, Fade, PointLight, Projection, SpotLight, Transform};

/// The version of Blender that has watts, as ufbx numbers versions.
const WATTS_SINCE: u32 = 2_080_000;

/// A light and its pose at its node; none: it gives no light.
pub fn light_of(light: &Light, scene: &Scene) -> Option<(Transform, Content)> {
    let color = number::color(light.color);
    let shines = light.cast_light && light.intensity > 0.0 && light.intensity.is_finite();
    if !shines || color == Vec3::ZERO {
        return None;
    }
    let mut intensity = light.intensity.min(1e30) as f32;
    let mut unit = 1.0;
    let is_blender = matches!(
        scene.metadata.exporter,
        Exporter::BlenderBinary | Exporter::BlenderAscii
    );
    let watts = is_blender && scene.metadata.exporter_version >= WATTS_SINCE;
    if watts && light.type_ != LightType::Directional {
        let metre = 1.0 / scene.settings.unit_meters;
        unit = if metre.is_normal() { metre } else { 1.0 };
        intensity *= (1.0 / (4.0 * PI * PI)) as f32;
    }
    let power = match light.decay {
        LightDecay::None => None,
        LightDecay::Linear => Some(1.0),
        LightDecay::Quadratic => Some(2.0),
        LightDecay::Cubic => Some(3.0),
    };
    let mut fade = power.map(|power: f64| Fade::exact(unit, power));
    if is_blender && !watts && light.type_ != LightType::Directional {
        fade = power.map(|power| Fade {
            distance: decay_start(light),
            power,
            ..Fade::default()
        });
        intensity *= if fade.is_some() { 0.5 } else { 1.0 };
    }
    let content = match light.type_ {
        LightType::Directional => Content::Directional(DirectionalLight { color, intensity }),
        LightType::Spot => {
            let half = |degrees: f64| (0.5 * degrees.to_radians()).clamp(0.0, FRAC_PI_2);
            Content::Spot(SpotLight {
                color,
                intensity,
                fade,
                inner_angle: half(light.inner_angle.min(light.outer_angle)),
                outer_angle: half(light.outer_angle),
            })
        }
        LightType::Point | LightType::Area | LightType::Volume => Content::Point(PointLight {
            color,
            intensity,
            fade,
        }),
    };
    let along = number::vector(light.local_direction);
    let along = along.try_normalize().unwrap_or(DVec3::NEG_Y);
    Some((Transform::looking_at(DVec3::ZERO, along, DVec3::Y), content))
}

/// The distance at which light of old Blender files has half its strength.
fn decay_start(light: &Light) -> f64 {
    let props = &light.element.props;
    let start = props
        .props
        .as_ref()
        .iter()
        .find(|prop| prop.name.as_ref() == "DecayStart");
    let start = start.map(|prop| prop.value_vec4.x);
    start
        .filter(|start| start.is_normal() && *start > 0.0)
        .unwrap_or(1.0)
}

/// A camera and its pose at its node: FBX's look along +X.
pub fn camera_of(camera: &FbxCamera) -> Option<(Transform, Content)> {
    let projection = match camera.projection_mode {
        ProjectionMode::Perspective => Projection::Perspective {
            vertical_fov: Some(camera.field_of_view_deg.y.to_radians())
                .filter(|angle| *angle > 0.0 && *angle < PI)?,
        },
        ProjectionMode::Orthographic => Projection::Orthographic {
            height: Some(camera.orthographic_size.y)
                .filter(|height| *height > 0.0 && height.is_finite())?,
        },
    };
    let content = Content::Camera(Camera {
        projection,
        ..Camera::default()
    });
    Some((
        Transform::looking_at(DVec3::ZERO, DVec3::X, DVec3::Y),
        content,
    ))
}
