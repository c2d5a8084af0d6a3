//! The eye: its projection and what the picture does with light (exposure, tone curve).

use bevy_ecs::prelude::*;
use bevy_reflect::prelude::*;
use serde::{Deserialize, Serialize};

use super::{Transform, Visibility};

/// A camera at its entity's pose, looking along local -Z with +Y up.
///
/// The picture shows the first visible camera in order of entity unless [`ActiveCamera`] names one.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[reflect(Component, Default, Clone, PartialEq)]
#[component(summary_tick)]
#[require(Transform, Visibility)]
pub struct Camera {
    /// How directions become pixels.
    pub projection: Projection,
    /// Exposure in stops: the picture is multiplied by 2^exposure before the tone curve.
    pub exposure: f32,
    /// How scene light becomes display light.
    pub tone_map: ToneMap,
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            projection: Projection::default(),
            exposure: 0.0,
            tone_map: ToneMap::default(),
        }
    }
}

/// How directions become pixels.
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[reflect(Default, Clone, PartialEq)]
pub enum Projection {
    /// A pinhole.
    Perspective {
        /// Full vertical opening angle, radians, in (0, pi).
        vertical_fov: f64,
    },
    /// Parallel rays.
    Orthographic {
        /// Height of the picture in world units.
        height: f64,
    },
}

impl Default for Projection {
    fn default() -> Self {
        Self::Perspective {
            vertical_fov: 45_f64.to_radians(),
        }
    }
}

/// The tone curve applied after exposure, before sRGB encoding.
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq, Default, Hash, Serialize, Deserialize)]
#[reflect(Default, Clone, PartialEq)]
pub enum ToneMap {
    /// Clip to [0, 1]: the plain picture, as a ray tracer of 2008 would show it.
    #[default]
    Clip,
    /// x / (1 + x) on luminance (Reinhard et al. 2002, eq. 3).
    Reinhard,
    /// A filmic curve: the rational fit of the ACES reference by Narkowicz (2015).
    Filmic,
}

/// The camera the picture is taken from; none: the first visible one.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq)]
pub struct ActiveCamera(pub Option<Entity>);

/// The camera the picture is taken from: the active one, shown or not, else the first that is shown.
///
/// `cameras` are all there are, each with whether it is shown.
pub fn picture_camera(
    active: ActiveCamera,
    cameras: impl IntoIterator<Item = (Entity, bool)>,
) -> Option<Entity> {
    let is_active = |entity| active.0 == Some(entity);
    cameras
        .into_iter()
        .filter(|&(entity, shown)| shown || is_active(entity))
        .map(|(entity, _)| entity)
        .min_by_key(|&entity| (!is_active(entity), entity))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_active_camera_comes_first_then_the_first_shown() {
        let [a, b, c] = [1, 2, 3].map(|row| Entity::from_raw_u32(row).unwrap());
        let cameras = [(c, true), (b, true), (a, false)];
        let chosen = |active| picture_camera(ActiveCamera(active), cameras);
        let first_shown = if b < c { b } else { c };
        assert_eq!(chosen(None), Some(first_shown));
        assert_eq!(chosen(Some(a)), Some(a), "active, though hidden");
        assert_eq!(chosen(Some(c)), Some(c));
        let gone = Entity::from_raw_u32(9).unwrap();
        assert_eq!(chosen(Some(gone)), Some(first_shown));
        assert_eq!(picture_camera(ActiveCamera(Some(a)), []), None);
    }
}
