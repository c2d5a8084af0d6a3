//! Lights: point, directional and spot. Colours are linear RGB radiant intensity, any scale.

use bevy_ecs::prelude::*;
use bevy_reflect::prelude::*;
use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::{Transform, Visibility};

/// A light that shines from its entity's position into all directions.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[reflect(Component, Default, Clone, PartialEq)]
#[component(summary_tick)]
#[require(Transform, Visibility)]
pub struct PointLight {
    /// Linear RGB.
    pub color: Vec3,
    /// A factor on the colour, for editing.
    pub intensity: f32,
    /// Falloff with distance; none: none.
    pub fade: Option<Fade>,
}

impl Default for PointLight {
    fn default() -> Self {
        Self {
            color: Vec3::ONE,
            intensity: 1.0,
            fade: None,
        }
    }
}

/// How light falls off with the distance d: by default as POV-Ray's `fade_*`, 2 / (1 + (d / distance)^power), full at
/// `distance` and twice that at the light.
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[reflect(Default, Clone, PartialEq)]
pub struct Fade {
    /// World units at which the factor is 1.
    pub distance: f64,
    /// 2 is inverse square far away.
    pub power: f64,
    /// (distance / d)^power instead, as light does: near the light without bound, but for one of 1e8.
    pub exact: bool,
    /// World units from which on there is no light: the factor is multiplied by 1 - (d / range)^4 (KHR_lights_punctual).
    pub range: Option<f64>,
}

impl Default for Fade {
    fn default() -> Self {
        Self {
            distance: 10.0,
            power: 2.0,
            exact: false,
            range: None,
        }
    }
}

impl Fade {
    /// Least (d / distance)^power of an exact falloff.
    pub const NEAREST: f32 = 1e-8;

    /// Intensity / d^power, d in units of this length.
    pub fn exact(distance: f64, power: f64) -> Self {
        Self {
            distance,
            power,
            exact: true,
            range: None,
        }
    }

    /// What is left at a distance.
    pub fn factor(&self, distance: f64) -> f64 {
        let gone = (distance / self.distance).powf(self.power);
        let left = match self.exact {
            true => gone.max(Self::NEAREST.into()).recip(),
            false => 2.0 / (1.0 + gone),
        };
        let within = self.range.map_or(0.0, |range| (distance / range).powi(4));
        left * (1.0 - within).max(0.0)
    }

    /// Upper bound of the factor.
    pub fn most(&self) -> f64 {
        match self.exact {
            true => f64::from(Self::NEAREST).recip(),
            false => 2.0,
        }
    }
}

/// A light infinitely far away that shines along its entity's local -Z.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[reflect(Component, Default, Clone, PartialEq)]
#[component(summary_tick)]
#[require(Transform, Visibility)]
pub struct DirectionalLight {
    /// Linear RGB.
    pub color: Vec3,
    /// A factor on the colour.
    pub intensity: f32,
}

impl Default for DirectionalLight {
    fn default() -> Self {
        Self {
            color: Vec3::ONE,
            intensity: 1.0,
        }
    }
}

/// A point light limited to a cone about its entity's local -Z.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[reflect(Component, Default, Clone, PartialEq)]
#[component(summary_tick)]
#[require(Transform, Visibility)]
pub struct SpotLight {
    /// Linear RGB.
    pub color: Vec3,
    /// A factor on the colour.
    pub intensity: f32,
    /// Falloff with distance; none: none.
    pub fade: Option<Fade>,
    /// Half angle of full light, radians.
    pub inner_angle: f64,
    /// Half angle of no light, radians; smoothstep in the cosine between the two.
    pub outer_angle: f64,
}

impl Default for SpotLight {
    fn default() -> Self {
        Self {
            color: Vec3::ONE,
            intensity: 1.0,
            fade: None,
            inner_angle: 20_f64.to_radians(),
            outer_angle: 30_f64.to_radians(),
        }
    }
}
