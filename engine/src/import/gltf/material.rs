//! The metal-rough model of glTF to the Whitted model of [`Material`].
//!
//! With `m` metallic, `r` roughness, `g` = 1 - r, `t` transmission, `b` the base colour:
//!
//! | glTF | becomes |
//! |---|---|
//! | `b` | `color` |
//! | metal | a mirror tinted by the base colour, the fainter the rougher: `reflection` Constant(b m g) |
//! | what is not mirrored | scattered, but for what passes: `diffuse` 1 - m g |
//! | `r` of what is no metal | a highlight after Blinn: the exponent 2/r^4 - 2 (Walter et al. 2007, with alpha = r^2), the strength F0 (n + 8)/8, at most 1, with F0 of `ior` |
//! | KHR_materials_transmission, KHR_materials_ior | glass: `filter` t, tinted by the base colour (`transmit` where that is white), refracted by `ior` (1.5 where the file says nothing), `reflection` Fresnel |
//! | KHR_materials_volume | `absorption` -ln(attenuationColor) / attenuationDistance, in glass |
//! | `alphaMode` BLEND | what is not there passes unbent: `transmit` 1 - alpha |
//! | `emissiveFactor`, KHR_materials_emissive_strength | `emission`: its brightest channel over that of the colour; where it outshines the base colour, the colour becomes that of what is given off |
//! | KHR_materials_unlit | nothing but `emission` 1 |
//!
//! Glass refracts whether or not KHR_materials_volume gives it a thickness: rays find the far side themselves.
//! Of textures, that of the base colour becomes `color_map` and that of normals `normal_map`, its tilts times its `scale`;
//! of that of metal and roughness only the mean counts, times the factors. `alphaMode` MASK cuts out at its
//! `alphaCutoff`, BLEND, where the colour has a picture, at a half. A picture of what is given off is left out, and with
//! it the light, unless it is the picture of the base colour.

use glam::{Vec3, Vec4};
use std::collections::HashSet;

use gltf::material::AlphaMode;

use super::file::File;
use super::looks::Coordinates;
use super::picture::Maps;
use crate::import::{Files, Model, Warnings};
use crate::world::{ColorSpace, Lobe, Material, Reflection};

/// Index of refraction of what does not say its own.
const IOR: f32 = 1.5;
/// Exponents beyond this are mirrors to the eye.
const SHARPEST: f32 = 2000.0;

/// Which rows of [`Model::materials`] the materials of a file are.
pub struct Materials {
    default: usize,
    /// What texture coordinates each takes.
    coordinates: Vec<Option<Coordinates>>,
}

impl Materials {
    /// Puts the file's materials into the model, in order, and their pictures, which are among these.
    pub fn read(file: &File, files: &Files, model: &mut Model) -> Self {
        let mut maps = Maps::new(file, files);
        let mut coordinates = Vec::new();
        let mut names = HashSet::new();
        for material in file.document.materials() {
            let number = material.index().unwrap_or_default();
            let name = match material.name() {
                Some(name) if !name.is_empty() => name.to_owned(),
                _ => format!("material {number}"),
            };
            // Two of one name would be one to the loader.
            let name = match names.insert(name.clone()) {
                true => name,
                false => format!("{name} ({number})"),
            };
            let (mapped, wanted) = material_of(&material, &mut maps, &mut model.warnings);
            model.materials.push((name, mapped));
            coordinates.push(wanted);
        }
        model.textures = maps.into_textures();
        Self {
            default: model.materials.len(),
            coordinates,
        }
    }

    /// The texture coordinates that a primitive's material takes.
    pub fn coordinates(&self, material: &gltf::Material) -> Option<Coordinates> {
        self.coordinates.get(material.index()?).copied().flatten()
    }

    /// The row of a primitive's material; the default one joins the model when it is first asked for.
    pub fn row(&self, material: &gltf::Material, model: &mut Model) -> usize {
        match material.index() {
            Some(row) => row,
            None => {
                if model.materials.len() == self.default {
                    let name = "default material".to_owned();
                    let plain = by_factors(material, 1.0, 1.0);
                    model.materials.push((name, plain));
                }
                self.default
            }
        }
    }
}

/// The material, and the texture coordinates it takes. Every number comes out finite and in range.
fn material_of(
    material: &gltf::Material,
    maps: &mut Maps,
    warnings: &mut Warnings,
) -> (Material, Option<Coordinates>) {
    let metal_rough = material.pbr_metallic_roughness();
    let mean = metal_rough.metallic_roughness_texture();
    let [_, rough, metal, _] = mean
        .and_then(|texture| maps.mean(&texture.texture(), warnings))
        .unwrap_or([1.0; 4]);
    let mut result = by_factors(material, rough, metal);
    let mut wanted = None;
    if let Some(texture) = metal_rough.base_color_texture() {
        result.color_map = maps.texture(&texture.texture(), ColorSpace::Srgb, warnings);
        wanted = Some(Coordinates::of(&texture));
    }
    if let Some(texture) = material.normal_texture() {
        let plain = Coordinates::of_set(texture.tex_coord());
        if *wanted.get_or_insert(plain) == plain {
            let map = maps.texture(&texture.texture(), ColorSpace::Linear, warnings);
            result.normal_map = map.and_then(|map| maps.steeper(map, texture.scale(), warnings));
        } else {
            let name = material.name().unwrap_or_default();
            warnings.push(format!(
                "the normal map of `{name}` is left out: it lies otherwise than the colours"
            ));
        }
    }
    let opaque = share(metal_rough.base_color_factor()[3]);
    result.alpha_cutoff = match material.alpha_mode() {
        AlphaMode::Opaque => None,
        AlphaMode::Mask => {
            let cutoff = material.alpha_cutoff().unwrap_or(0.5);
            Some(share(cutoff / opaque.max(1e-6)))
        }
        AlphaMode::Blend => result.color_map.map(|_| 0.5),
    };
    (result, wanted)
}

/// The material by its factors; those of roughness and metal are multiplied by these.
fn by_factors(material: &gltf::Material, rougher: f32, more_metal: f32) -> Material {
    let metal_rough = material.pbr_metallic_roughness();
    let base = Vec4::from(metal_rough.base_color_factor().map(share));
    let metal = share(metal_rough.metallic_factor()) * more_metal;
    let rough = share(metal_rough.roughness_factor()) * rougher;
    let passed = material
        .transmission()
        .map_or(0.0, |glass| share(glass.transmission_factor()));
    let ior = material.ior().unwrap_or(IOR);
    let ior = if (1.0..=10.0).contains(&ior) {
        ior
    } else {
        IOR
    };
    let mirrored = metal * (1.0 - rough);
    let mut result = Material {
        color: base.truncate(),
        // The tracers scatter no more of it than does not pass.
        diffuse: 1.0 - mirrored,
        specular: highlight(rough, ior, metal),
        ..Material::default()
    };
    if mirrored > 0.0 {
        result.reflection = Reflection::Constant(result.color * mirrored);
    }
    if passed > 0.0 {
        result.ior = f64::from(ior);
        result.reflection = Reflection::Fresnel;
        result.absorption = absorption(material);
        match result.color == Vec3::ONE {
            true => result.transmit = passed,
            false => result.filter = passed,
        }
    } else if material.alpha_mode() == AlphaMode::Blend {
        result.transmit = 1.0 - base.w;
    }
    if material.unlit() {
        return Material {
            color: result.color,
            diffuse: 0.0,
            emission: 1.0,
            transmit: result.transmit,
            ..Material::default()
        };
    }
    glow(&mut result, material);
    result
}

fn share(number: f32) -> f32 {
    if number.is_finite() {
        number.clamp(0.0, 1.0)
    } else {
        0.0
    }
}

/// What glass takes from light by the length gone, a unit.
fn absorption(material: &gltf::Material) -> Vec3 {
    let Some(volume) = material.volume() else {
        return Vec3::ZERO;
    };
    // Black would be endless.
    let left = volume.attenuation_color().map(|c| share(c).max(1e-4));
    let lost = Vec3::from(left.map(|left| -left.ln())) / volume.attenuation_distance();
    if lost.is_finite() {
        lost.max(Vec3::ZERO)
    } else {
        Vec3::ZERO
    }
}

/// The highlight of what is no metal.
fn highlight(rough: f32, ior: f32, metal: f32) -> Option<Lobe> {
    let exponent = (2.0 / rough.powi(4) - 2.0).min(SHARPEST);
    let normal = ((ior - 1.0) / (ior + 1.0)).powi(2);
    let strength = (normal * (1.0 - metal) * (exponent + 8.0) / 8.0).min(1.0);
    (strength > 0.0 && exponent >= 1.0).then_some(Lobe { strength, exponent })
}

/// Adds what the material gives off.
fn glow(result: &mut Material, material: &gltf::Material) {
    let of_colour = material.pbr_metallic_roughness().base_color_texture();
    let of_colour = of_colour.map(|texture| texture.texture().index());
    let of_light = material
        .emissive_texture()
        .map(|texture| texture.texture().index());
    if of_light.is_some() && of_light != of_colour {
        return;
    }
    let factor = Vec3::from(material.emissive_factor().map(share));
    let strength = material.emissive_strength().unwrap_or(1.0);
    let strength = if strength.is_finite() {
        strength.max(0.0)
    } else {
        1.0
    };
    let given = factor * strength;
    let brightest = given.max_element();
    if !(brightest > 0.0 && brightest.is_finite()) {
        return;
    }
    if brightest >= result.color.max_element() {
        result.color = given / brightest;
        result.emission = brightest;
    } else {
        result.emission = brightest / result.color.max_element();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn material(json: &str) -> Material {
        let text = format!("{{\"asset\":{{\"version\":\"2.0\"}},\"materials\":[{{{json}}}]}}");
        let gltf = gltf::Gltf::from_slice(text.as_bytes()).unwrap();
        by_factors(&gltf.materials().next().unwrap(), 1.0, 1.0)
    }

    fn metal_rough(metal: f32, rough: f32, color: &str) -> Material {
        material(&format!(
            "\"pbrMetallicRoughness\":{{\"metallicFactor\":{metal},\"roughnessFactor\":{rough},\"baseColorFactor\":{color}}}"
        ))
    }

    #[test]
    fn each_line_of_the_table_holds() {
        let plain = material("");
        assert_eq!((plain.color, plain.diffuse), (Vec3::ONE, 1.0));
        assert_eq!((plain.reflection, plain.specular), (Reflection::None, None));
        let gold = metal_rough(1.0, 0.25, "[1,0.5,0.25,1]");
        let mirrored = Vec3::new(0.75, 0.375, 0.1875);
        assert_eq!(gold.reflection, Reflection::Constant(mirrored));
        assert_eq!((gold.diffuse, gold.specular), (0.25, None));
        let plastic = metal_rough(0.0, 0.5, "[1,0,0,1]");
        let lobe = plastic.specular.unwrap();
        assert_eq!((plastic.diffuse, lobe.exponent), (1.0, 30.0));
        assert!((lobe.strength - 0.04 * 38.0 / 8.0).abs() < 1e-6);
        let pane =
            "\"alphaMode\":\"BLEND\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,1,0.25]}";
        assert_eq!(material(pane).transmit, 0.75);
        let unlit = material("\"extensions\":{\"KHR_materials_unlit\":{}}");
        assert_eq!((unlit.diffuse, unlit.emission), (0.0, 1.0));
        let glass = material(
            "\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":1},
            \"KHR_materials_volume\":{\"attenuationDistance\":2,\"attenuationColor\":[0.5,1,0]}}",
        );
        assert_eq!((glass.transmit, glass.diffuse, glass.ior), (1.0, 1.0, 1.5));
        assert_eq!(glass.reflection, Reflection::Fresnel);
        let half = std::f32::consts::LN_2 / 2.0;
        assert!((glass.absorption.x - half).abs() < 1e-6 && glass.absorption.y == 0.0);
        assert!(glass.absorption.is_finite());
        let dark = material(
            "\"emissiveFactor\":[0.5,0.25,0],\"pbrMetallicRoughness\":{\"baseColorFactor\":[0,0,0,1]}",
        );
        assert_eq!((dark.color, dark.emission), (Vec3::new(1.0, 0.5, 0.0), 0.5));
        let dim = material("\"emissiveFactor\":[0.5,0.5,0.5]");
        assert_eq!((dim.color, dim.emission), (Vec3::ONE, 0.5));
    }
}
