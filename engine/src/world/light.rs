//! Lights: point, directional and spot. Colours are linear RGB radiant intensity, any scale.

use bevy_ecs::prelude::*;
use bevy_reflect::prelude::*;
use glam::Vec3;

use super::{Transform, Visibility};

/// A light that shines from its entity's position into all directions.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
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

/// Falloff 2 / (1 + (d / distance)^power): full at `distance`, twice that at the light (POV-Ray's `fade_*`).
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct Fade {
    /// World units at which the factor is 1.
    pub distance: f64,
    /// 2 is inverse square far away.
    pub power: f64,
}

impl Default for Fade {
    fn default() -> Self {
        Self {
            distance: 10.0,
            power: 2.0,
        }
    }
}

impl Fade {
    /// What is left at a distance.
    pub fn factor(&self, distance: f64) -> f64 {
        2.0 / (1.0 + (distance / self.distance).powf(self.power))
    }
}

/// A light infinitely far away that shines along its entity's local -Z.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
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
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
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
