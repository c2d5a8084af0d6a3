//! KHR_lights_punctual and cameras.
//!
//! glTF's surfaces scatter 1/pi of what comes in, ours all of it; so a light's lux or candela are divided by pi.
//! What falls off does so with the square of the distance, and towards `range` as the extension recommends. A spot's edge is
//! smooth in the cosine here, and the square of a line in the cosine there.

use std::f32::consts::PI;

use glam::Vec3;
use gltf::khr_lights_punctual::{Kind, Light};

use crate::import::Content;
use crate::world::{Camera, DirectionalLight, Fade, PointLight, Projection, SpotLight};

/// A light; none where its numbers make none.
pub fn light_of(light: &Light) -> Option<Content> {
    let color = Vec3::from(light.color());
    let intensity = light.intensity() / PI;
    let makes_light = color.is_finite() && color.min_element() >= 0.0 && intensity >= 0.0;
    if !makes_light || !intensity.is_finite() {
        return None;
    }
    let range = light.range().map(f64::from);
    let fade = Some(Fade {
        range: range.filter(|range| *range > 0.0 && range.is_finite()),
        ..Fade::exact(1.0, 2.0)
    });
    Some(match light.kind() {
        Kind::Directional => Content::Directional(DirectionalLight { color, intensity }),
        Kind::Point => Content::Point(PointLight {
            color,
            intensity,
            fade,
        }),
        Kind::Spot {
            inner_cone_angle,
            outer_cone_angle,
        } => {
            let angle = |angle: f32| f64::from(angle).clamp(0.0, std::f64::consts::FRAC_PI_2);
            Content::Spot(SpotLight {
                color,
                intensity,
                fade,
                inner_angle: angle(inner_cone_angle.min(outer_cone_angle)),
                outer_angle: angle(outer_cone_angle),
            })
        }
    })
}

/// A camera; none where its numbers make none. What it is follows from which numbers it has, whatever it calls itself.
pub fn camera_of(camera: &gltf::json::Camera) -> Option<Content> {
    let projection = match (&camera.perspective, &camera.orthographic) {
        (Some(perspective), _) => Projection::Perspective {
            vertical_fov: Some(f64::from(perspective.yfov))
                .filter(|angle| *angle > 0.0 && *angle < std::f64::consts::PI)?,
        },
        (None, Some(orthographic)) => Projection::Orthographic {
            height: Some(2.0 * f64::from(orthographic.ymag).abs())
                .filter(|height| *height > 0.0 && height.is_finite())?,
        },
        (None, None) => return None,
    };
    Some(Content::Camera(Camera {
        projection,
        ..Camera::default()
    }))
}
