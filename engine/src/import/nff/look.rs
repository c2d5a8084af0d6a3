//! Fills of NFF and AFF as the Whitted model of [`Material`], and the light they are seen by.
//!
//! | NFF `f R G B Kd Ks Shine T ior` | AFF `fm` ambient diffuse specular Shine T ior | becomes |
//! |---|---|---|
//! | `R G B` | diffuse colour | `color` |
//! | `Kd` | 1 | `diffuse`, over 1 - T: what the model lets through it does not scatter |
//! | | `am`, else 1, times the ambient colour | `emission`, over 1 - T; of a black fill also `color` |
//! | `Ks`, `Shine` | specular colour (its mean), `Shine` | `phong`: strength, exponent of the cosine to the mirrored eye ray |
//! | `Ks` > 0 | specular colour > 0 | `reflection`, constant |
//! | `T` > 0 and `ior` > 1, but no `Ks` | likewise | `reflection` by Fresnel: what transmits reflects, as the databases' rules have it |
//! | `T`: tinted | `T`: not tinted | `filter`; `transmit` |
//! | `ior` > 0 | `ior` > 0 | `ior`; else 1 |
//!
//! Colours and weights are what displays of the files' time were fed with (the pictures that come with the Standard
//! Procedural Databases hold the background's numbers as they are in the file, and weights scaled such numbers), so they are
//! decoded from sRGB. Lights add up, so they are not. A light without a colour has the intensity sqrt(1 / lights), which gives
//! pictures as bright as those.

use glam::Vec3;

use crate::world::{Lobe, Material, Reflection, linear_from_srgb};

/// A fill before it is known what light there is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fill {
    /// Display values.
    pub color: Vec3,
    /// Share scattered, of display values like the other weights.
    pub diffuse: f32,
    /// Display values; none: there is no ambient light, and what passes is tinted.
    pub ambient: Option<Vec3>,
    /// Weight of mirrored rays and of the highlight.
    pub specular: Vec3,
    /// Exponent of the highlight.
    pub shine: f32,
    /// Weight of refracted rays.
    pub transmittance: f32,
    /// Index of refraction.
    pub ior: f64,
}

impl Default for Fill {
    /// What is not said to look otherwise.
    fn default() -> Self {
        Self {
            color: Vec3::splat(0.8),
            diffuse: 1.0,
            ambient: None,
            specular: Vec3::ZERO,
            shine: 1.0,
            transmittance: 0.0,
            ior: 1.0,
        }
    }
}

impl Fill {
    /// As tracers see it in the ambient light of AFF.
    pub fn material(&self, ambient: Vec3) -> Material {
        let transmittance = linear_from_srgb(self.transmittance.clamp(0.0, 1.0));
        let opaque = 1.0 - transmittance;
        let over_opaque = |share: f32| if opaque > 0.0 { share / opaque } else { 0.0 };
        let glow = self
            .ambient
            .map_or(Vec3::ZERO, |own| linear((own * ambient).min(Vec3::ONE)));
        // What is black to lights, such as a lit picture on a wall, may glow all the same.
        let (color, diffuse) = match self.color == Vec3::ZERO {
            true => (glow, 0.0),
            false => (linear(self.color), linear_from_srgb(self.diffuse)),
        };
        let specular = linear(self.specular.min(Vec3::ONE));
        let strength = specular.element_sum() / 3.0;
        let is_tinted = self.ambient.is_none();
        Material {
            color,
            diffuse: over_opaque(diffuse),
            emission: over_opaque(share_of(glow, color)),
            phong: (strength > 0.0 && self.shine > 0.0).then_some(Lobe {
                strength,
                exponent: self.shine,
            }),
            reflection: if specular != Vec3::ZERO {
                Reflection::Constant(specular)
            } else if transmittance > 0.0 && self.ior > 1.0 {
                Reflection::Fresnel
            } else {
                Reflection::None
            },
            filter: if is_tinted { transmittance } else { 0.0 },
            transmit: if is_tinted { 0.0 } else { transmittance },
            ior: if self.ior > 0.0 { self.ior } else { 1.0 },
            ..Material::default()
        }
    }
}

/// Of a light whose file does not say.
pub fn light_without_color(lights: usize) -> Vec3 {
    Vec3::splat(1.0 / (lights.max(1) as f32).sqrt())
}

/// The factor that makes a colour as bright as another.
fn share_of(glow: Vec3, color: Vec3) -> f32 {
    let brightest = color.max_element();
    if brightest > 0.0 {
        glow.max_element() / brightest
    } else {
        0.0
    }
}

/// Linear light of a display's values.
pub fn linear(display: Vec3) -> Vec3 {
    Vec3::from_array(display.to_array().map(linear_from_srgb))
}
