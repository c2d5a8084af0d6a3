//! How a surface answers light: Whitted's model as POV-Ray 3.7 states it (diffuse, Phong, Blinn-Phong,
//! emission, constant or Fresnel reflection, filtered transmission with an index of refraction).

use bevy_ecs::prelude::*;
use bevy_reflect::prelude::*;
use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::TextureId;

/// A material, on an entity of its own; shapes name it by [`super::Surface`].
///
/// With a = 1 - filter - transmit, V to the eye, N towards the eye, per light of colour Lc:
/// `color*diffuse*a*(N.L)*Lc + phong.strength*(R.L)^n*Lc + specular.strength*(N.H)^n*Lc`,
/// plus `color*emission*a`, plus reflection, plus transmission times `color*filter + transmit`.
/// On meshes `color` stands for its product with the colour map and the vertex colours.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[reflect(Component, Default, Clone, PartialEq)]
#[component(summary_tick)]
pub struct Material {
    /// Linear RGB.
    pub color: Vec3,
    /// Share of light scattered evenly.
    pub diffuse: f32,
    /// Light given off, times colour.
    pub emission: f32,
    /// Phong highlight about the mirrored eye ray; not tinted.
    pub phong: Option<Lobe>,
    /// Blinn-Phong highlight about the half vector; not tinted.
    pub specular: Option<Lobe>,
    /// Mirror reflection.
    pub reflection: Reflection,
    /// Share of light passed on untinted.
    pub transmit: f32,
    /// Share of light passed on tinted by the colour.
    pub filter: f32,
    /// Index of refraction, > 0; 1 is air.
    pub ior: f64,
    /// Share of light lost within it, by the length gone (Beer and Lambert): exp(-absorption * length) is left, a channel.
    /// For closed shapes that let light through.
    pub absorption: Vec3,
    /// Times the colour, where a mesh has texture coordinates.
    pub color_map: Option<TextureId>,
    /// Tilts the normal, where a mesh has texture coordinates: red to the right of the picture, green up it, blue
    /// outward, a half is none (linear numbers).
    pub normal_map: Option<TextureId>,
    /// Meshes are not there where the product of the colour map's alpha and the vertices' is below this; none: everywhere.
    pub alpha_cutoff: Option<f32>,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            color: Vec3::splat(0.8),
            diffuse: 0.8,
            emission: 0.0,
            phong: None,
            specular: None,
            reflection: Reflection::None,
            transmit: 0.0,
            filter: 0.0,
            ior: 1.0,
            absorption: Vec3::ZERO,
            color_map: None,
            normal_map: None,
            alpha_cutoff: None,
        }
    }
}

/// A highlight.
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[reflect(Default, Clone, PartialEq)]
pub struct Lobe {
    /// Value at the centre.
    pub strength: f32,
    /// Exponent of the cosine; higher is tighter.
    pub exponent: f32,
}

impl Default for Lobe {
    fn default() -> Self {
        Self {
            strength: 0.5,
            exponent: 40.0,
        }
    }
}

/// Weight of the mirrored ray.
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[reflect(Default, Clone, PartialEq)]
pub enum Reflection {
    /// No mirrored ray.
    #[default]
    None,
    /// The same at every angle, linear RGB.
    Constant(Vec3),
    /// Unpolarised Fresnel of the indices on both sides; transmission gets the rest.
    Fresnel,
}

impl Material {
    /// Weight of light that passes straight through: color * filter + transmit.
    pub fn transmission(&self) -> Vec3 {
        self.color * self.filter + self.transmit
    }
}
