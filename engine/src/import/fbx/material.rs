//! Materials of FBX to the Whitted model of [`Material`].
//!
//! Lambert and Phong, with `T` the transparency, and physical ones with `m` metalness, `r` roughness:
//!
//! | FBX | becomes |
//! |---|---|
//! | `DiffuseColor` x `DiffuseFactor`; physical: base colour x its factor | `color`, with `diffuse` 1 |
//! | `EmissiveColor` x `EmissiveFactor` | `emission`: its brightest channel over that of the colour; where it outshines the colour, the colour becomes that of what is given off |
//! | `SpecularColor` x `SpecularFactor`, `ShininessExponent` | `specular`: strength the mean of the channels, the exponent as it is |
//! | `ReflectionColor` x `ReflectionFactor` | a mirror: `reflection` Constant; the rest is scattered |
//! | `TransparentColor` x `TransparencyFactor` | what is not there passes: `transmit` T; where T has a hue, `color` is that hue and `filter` its brightest channel |
//! | physical: m, r | a mirror tinted by the base colour, the fainter the rougher: Constant(base m (1 - r)); else a highlight with the exponent 2/r^4 - 2 |
//! | physical: transmission, index of refraction | glass: `filter`, `ior`, `reflection` Fresnel |
//! | physical: opacity | `transmit` 1 - opacity |
//!
//! | texture of the diffuse or base colour | `color_map`, in place of the colour, times its factor |
//! | texture of the normal map | `normal_map` |
//!
//! Numbers are taken as linear. Pictures are looked for within the file, then beside it. Where one is missing, 0.8 grey
//! stands in for it: the number beside it is mostly black. Of layers of textures the first counts.

use glam::Vec3;
use ufbx::{Material as FbxMaterial, MaterialMap, Scene, Texture, WrapMode};

use super::number;
use crate::import::{Files, Model, Pictures, Warnings};
use crate::world::{ColorSpace, Lobe, Material, Reflection, TextureId, Wrap};

/// Stands in for textures.
const GREY: Vec3 = Vec3::splat(0.8);
/// Exponents beyond this are mirrors to the eye.
const SHARPEST: f32 = 2000.0;

/// Puts the materials of a file beside these into the model, in order, each with a name of its own.
pub fn read(scene: &Scene, files: &Files, model: &mut Model) {
    let mut pictures = Pictures::new(files);
    for (row, material) in scene.materials.into_iter().enumerate() {
        let name = material.element.name.to_string();
        let taken = model.materials.iter().any(|(other, _)| *other == name);
        let name = match (name.is_empty(), taken) {
            (true, _) => format!("material {row}"),
            (false, true) => format!("{name} ({row})"),
            (false, false) => name,
        };
        let plain = material_of(material);
        let looks = with_pictures(plain, material, &mut pictures, &mut model.warnings);
        model.materials.push((name, looks));
    }
    model.textures = pictures.textures;
}

fn with_pictures(
    mut material: Material,
    of: &FbxMaterial,
    pictures: &mut Pictures,
    warnings: &mut Warnings,
) -> Material {
    let (color, normal, share) = match of.features.pbr.enabled {
        true => (&of.pbr.base_color, &of.pbr.normal_map, &of.pbr.base_factor),
        false => (
            &of.fbx.diffuse_color,
            &of.fbx.normal_map,
            &of.fbx.diffuse_factor,
        ),
    };
    let mut picture = |map: &MaterialMap, space| {
        let texture = map.texture.as_ref().filter(|_| map.texture_enabled)?;
        picture_of(texture, space, pictures, warnings)
    };
    material.color_map = picture(color, ColorSpace::Srgb);
    material.normal_map = picture(normal, ColorSpace::Linear);
    if material.color_map.is_some() && material.filter == 0.0 && material.emission == 0.0 {
        material.color = Vec3::splat(factor(share).min(1.0));
    }
    material
}

/// The picture of a texture, within the file or beside it.
fn picture_of(
    texture: &Texture,
    space: ColorSpace,
    pictures: &mut Pictures,
    warnings: &mut Warnings,
) -> Option<TextureId> {
    let texture = texture
        .file_textures
        .iter()
        .next()
        .map_or(texture, |file| file);
    let wrap = match (texture.wrap_u, texture.wrap_v) {
        (WrapMode::Clamp, WrapMode::Clamp) => Wrap::Clamp,
        _ => Wrap::Repeat,
    };
    if texture.has_uv_transform {
        warnings.push("textures are moved or scaled over the surface; that is left out");
    }
    let names = [
        &texture.relative_filename,
        &texture.filename,
        &texture.absolute_filename,
    ];
    let name = names
        .map(|name| name.as_ref())
        .into_iter()
        .find(|name| !name.is_empty())?;
    if texture.content.is_empty() {
        return pictures.file(name, (space, wrap), warnings);
    }
    let ending = name.rsplit_once('.').map(|(_, ending)| ending);
    pictures.bytes((name, &texture.content, ending), (space, wrap), warnings)
}

/// The material. Every number comes out finite and in range.
fn material_of(material: &FbxMaterial) -> Material {
    let mut result = match material.features.pbr.enabled {
        true => physical(material),
        false => classic(material),
    };
    let maps = &material.fbx;
    let pbr = &material.pbr;
    let given = match material.features.pbr.enabled {
        true => color(&pbr.emission_color) * factor(&pbr.emission_factor),
        false => color(&maps.emission_color) * factor(&maps.emission_factor),
    };
    glow(&mut result, given);
    result
}

fn classic(material: &FbxMaterial) -> Material {
    let maps = &material.fbx;
    let mirrored = color(&maps.reflection_color) * factor(&maps.reflection_factor);
    let mirrored = mirrored.min(Vec3::ONE);
    let mut result = Material {
        color: base(&maps.diffuse_color) * factor(&maps.diffuse_factor),
        diffuse: 1.0,
        specular: highlight(
            color(&maps.specular_color) * factor(&maps.specular_factor),
            number_of(&maps.specular_exponent) as f32,
        ),
        ..Material::default()
    };
    if mirrored != Vec3::ZERO {
        result.reflection = Reflection::Constant(mirrored);
        // What is mirrored is not scattered as well, or surfaces would shine brighter than their light.
        result.diffuse = 1.0 - mirrored.max_element();
    }
    let passed = color(&maps.transparency_color) * factor(&maps.transparency_factor);
    let passed = passed.min(Vec3::ONE);
    let most = passed.max_element();
    if most - passed.min_element() > 1e-3 {
        result.color = passed / most;
        result.filter = most;
    } else {
        result.transmit = most;
    }
    result
}

fn physical(material: &FbxMaterial) -> Material {
    let maps = &material.pbr;
    let base = (base(&maps.base_color) * factor(&maps.base_factor)).min(Vec3::ONE);
    let metal = share(number_of(&maps.metalness));
    let rough = match material.features.roughness_as_glossiness.enabled {
        true => 1.0 - share(number_of(&maps.roughness)),
        false => share(number_of(&maps.roughness)),
    };
    let mirrored = metal * (1.0 - rough);
    let passed = share(number_of(&maps.transmission_factor));
    let ior = number_of(&maps.specular_ior);
    let ior = if (1.0..=10.0).contains(&ior) {
        ior
    } else {
        1.5
    };
    let exponent = (2.0 / rough.powi(4) - 2.0).min(SHARPEST);
    let normal = ((ior - 1.0) / (ior + 1.0)).powi(2) as f32;
    let strength = (normal * (1.0 - metal) * (exponent + 8.0) / 8.0).min(1.0);
    let specular = color(&maps.specular_color) * factor(&maps.specular_factor);
    let mut result = Material {
        color: base,
        // The tracers scatter no more of it than does not pass.
        diffuse: 1.0 - mirrored,
        specular: highlight(specular.min(Vec3::ONE) * strength, exponent),
        ..Material::default()
    };
    if mirrored > 0.0 {
        result.reflection = Reflection::Constant(base * mirrored);
    }
    if passed > 0.0 {
        result.reflection = Reflection::Fresnel;
        result.ior = ior;
        result.filter = passed;
    } else if maps.opacity.has_value {
        result.transmit = 1.0 - color(&maps.opacity).max_element().min(1.0);
    }
    result
}

fn highlight(color: Vec3, exponent: f32) -> Option<Lobe> {
    let strength = color.element_sum() / 3.0;
    (strength > 0.0 && exponent > 0.0).then_some(Lobe { strength, exponent })
}

/// Adds what the material gives off.
fn glow(result: &mut Material, given: Vec3) {
    let brightest = given.max_element();
    if !(brightest > 0.0) {
        return;
    }
    if brightest >= result.color.max_element() {
        result.color = given / brightest;
        result.emission = brightest;
    } else {
        result.emission = brightest / result.color.max_element();
    }
}

fn share(number: f64) -> f32 {
    if number.is_finite() {
        number.clamp(0.0, 1.0) as f32
    } else {
        0.0
    }
}

/// Finite.
fn number_of(map: &MaterialMap) -> f64 {
    let number = map.value_vec4.x;
    if number.is_finite() {
        number.clamp(-1e6, 1e6)
    } else {
        0.0
    }
}

/// 1 where the file says nothing.
fn factor(map: &MaterialMap) -> f32 {
    match map.has_value {
        true => number_of(map).max(0.0) as f32,
        false => 1.0,
    }
}

/// Black where the file says nothing.
fn color(map: &MaterialMap) -> Vec3 {
    let ufbx::Vec4 { x, y, z, .. } = map.value_vec4;
    number::color(match map.value_components {
        1 => ufbx::Vec3 { x, y: x, z: x },
        _ => ufbx::Vec3 { x, y, z },
    })
}

/// The colour of a surface.
fn base(map: &MaterialMap) -> Vec3 {
    let textured = map.texture.is_some() && map.texture_enabled;
    match (textured, map.has_value) {
        (true, _) | (_, false) => GREY,
        (false, true) => color(map).min(Vec3::ONE),
    }
}
