//! MTL (Wavefront 1995) to the Whitted model of [`Material`].
//!
//! | MTL | becomes |
//! |---|---|
//! | `Kd` | `color`, with `diffuse` 1; absent: 0.8 grey |
//! | `Ke` | `emission`: its brightest channel over that of the colour (the model tints emission by the colour) |
//! | `Ke`, the colour black | `color` its hue, with `diffuse` 0, and `emission` its brightest channel |
//! | `Ks`, `Ns` | `specular`: strength the mean of `Ks`, exponent `Ns` (MTL's highlight is not tinted here) |
//! | `d` or `Tr` (= 1 - d) | what is not dissolved passes: `transmit` 1 - d |
//! | `Tf` | with transparency: its hue tints what passes (`filter` with that colour) |
//! | `Ni` | `ior` |
//! | `illum` 3, 5 | mirror: 3 reflects `Ks`, 5 by Fresnel where `Ni` > 1, else `Ks` |
//! | `illum` 4, 6, 7, 9 | glass: as transparent as `d` says (fully, where `d` says nothing), Fresnel where `Ni` > 1 |
//! | `map_Kd` | `color_map`, times `Kd` |
//! | `map_d` | `alpha_cutoff` 0.5: cut out where it is dark (its alpha, where it is the file of `map_Kd`) |
//! | `norm`, `map_Bump`, `bump` in colour | `normal_map`, its tilts times `-bm` |
//! | `map_Bump`, `bump` in grey | `normal_map` of these heights: white stands out over black by a fiftieth of the picture's edge, times `-bm` |
//! | `-s`, `-o` | the texture coordinates, times and plus these, of the meshes that wear the material |
//!
//! `Ka` has no counterpart (there is no ambient light). Of a map's other options `-clamp on` counts.

use glam::{DVec2, Vec3};

use super::{Pictures, Recipe, Warnings};
use crate::world::{ColorSpace, Lobe, Material, Reflection, Texture, TextureId, Wrap};

/// The material of an MTL entry. Every number comes out finite and in range.
pub fn material_of(mtl: &tobj::Material) -> Material {
    let (color, diffuse, emission) = glow(mtl, mtl.diffuse.map_or(Vec3::splat(0.8), rgb));
    let specular = mtl.specular.map_or(Vec3::ZERO, rgb);
    let illum = mtl.illumination_model.unwrap_or(2);
    let ior = mtl
        .optical_density
        .filter(|n| n.is_finite() && *n > 0.0)
        .unwrap_or(1.0);
    let glass = matches!(illum, 4 | 6 | 7 | 9);
    let opacity = opacity_of(mtl).unwrap_or(if glass { 0.0 } else { 1.0 });
    let mut material = Material {
        color,
        diffuse,
        emission,
        specular: highlight(mtl, specular),
        transmit: 1.0 - opacity,
        ior,
        ..Material::default()
    };
    let fresnel = ior > 1.0 && (glass || illum == 5);
    if fresnel {
        material.reflection = Reflection::Fresnel;
    } else if matches!(illum, 3 | 5) && specular != Vec3::ZERO {
        material.reflection = Reflection::Constant(specular.min(Vec3::ONE));
        // What is mirrored is not scattered as well, or surfaces would shine brighter than their light.
        material.diffuse *= 1.0 - specular.max_element().min(1.0);
    }
    if let Some(tint) = filter_of(mtl).filter(|tint| opacity < 1.0 && *tint != Vec3::ONE) {
        material.color = tint;
        material.filter = 1.0 - opacity;
        material.transmit = 0.0;
    }
    material
}

/// The material with the pictures that its entry names, and how they lie on surfaces.
pub fn with_pictures(
    material: Material,
    mtl: &tobj::Material,
    pictures: &mut Pictures,
    warnings: &mut Warnings,
) -> (Material, Lie) {
    let mut material = material;
    let unknown = |name: &str| mtl.unknown_param.get(name).map(String::as_str);
    let color = mtl.diffuse_texture.as_deref().and_then(map_of);
    let dissolve = mtl.dissolve_texture.as_deref().and_then(map_of);
    let normals = unknown("norm").or(mtl.normal_texture.as_deref());
    let normals = normals.or(unknown("bump")).and_then(map_of);
    let maps = [&color, &dissolve, &normals].map(Option::as_ref);
    let lie = maps
        .iter()
        .flatten()
        .next()
        .map_or(Lie::default(), |map| map.lie);
    if maps.iter().flatten().any(|map| map.lie != lie) {
        warnings.push(format!(
            "the pictures of `{}` lie otherwise one from the other; all lie as the first",
            mtl.name
        ));
    }
    let mut picture = |map: &Option<Map>, space| {
        let map = map.as_ref()?;
        pictures.file(&map.file, (space, map.wrap), warnings)
    };
    material.color_map = picture(&color, ColorSpace::Srgb);
    let mask = picture(&dissolve, ColorSpace::Linear);
    let normal_map = picture(&normals, ColorSpace::Linear);
    if let Some(mask) = mask {
        let file = |map: &Option<Map>| map.as_ref().map(|map| map.file.clone());
        material.alpha_cutoff = Some(0.5);
        if file(&color) != file(&dissolve) {
            cut_out(&mut material, mask, pictures, warnings);
        }
    }
    let times = normals.map_or(1.0, |map| map.times);
    material.normal_map = normal_map.and_then(|row| {
        if !is_grey(pictures.textures.get(row.0 as usize)?) {
            return pictures.steeper(row, times, warnings);
        }
        let heights = |textures: &[Texture]| Ok(textures[row.0 as usize].of_heights(times));
        pictures.made(Recipe::Heights(row, times.to_bits()), heights, warnings)
    });
    (material, lie)
}

/// Gives the colour map, or a white one, the brightness of a mask as its alpha.
fn cut_out(
    material: &mut Material,
    mask: TextureId,
    pictures: &mut Pictures,
    warnings: &mut Warnings,
) {
    let make = |textures: &[Texture]| {
        let color = material.color_map.map(|row| &textures[row.0 as usize]);
        masked(color, &textures[mask.0 as usize])
            .ok_or_else(|| "a `map_d` is left out: it has not the size of its `map_Kd`".to_owned())
    };
    match pictures.made(Recipe::CutOut(material.color_map, mask), make, warnings) {
        Some(row) => material.color_map = Some(row),
        None => material.alpha_cutoff = None,
    }
}

/// The colours with the mask's red as alpha; none where their sizes differ.
fn masked(color: Option<&Texture>, mask: &Texture) -> Option<Texture> {
    let sizes = |texture: &Texture| -> Vec<[u32; 2]> {
        let levels = texture.levels.iter();
        levels.map(|level| [level.width, level.height]).collect()
    };
    if color.is_some_and(|color| sizes(color) != sizes(mask)) {
        return None;
    }
    let mut texture = mask.clone();
    for (i, level) in texture.levels.iter_mut().enumerate() {
        for (j, texel) in level.texels.iter_mut().enumerate() {
            let [r, g, b] = color.map_or([u16::MAX; 3], |color| {
                let [r, g, b, _] = color.levels[i].texels[j];
                [r, g, b]
            });
            *texel = [r, g, b, texel[0]];
        }
    }
    Some(texture)
}

/// Whether red, green and blue are alike everywhere.
fn is_grey(texture: &Texture) -> bool {
    let texels = texture
        .levels
        .first()
        .map_or(&[][..], |level| &level.texels);
    texels.iter().all(|[r, g, b, _]| r == g && g == b)
}

/// How pictures lie on a surface: a texture coordinate becomes its product with `scale`, plus `offset`; v counts from the
/// lower edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lie {
    scale: DVec2,
    offset: DVec2,
}

impl Default for Lie {
    fn default() -> Self {
        Self {
            scale: DVec2::ONE,
            offset: DVec2::ZERO,
        }
    }
}

impl Lie {
    /// Where a texture coordinate comes to lie.
    pub fn moved(&self, uv: DVec2) -> DVec2 {
        uv * self.scale + self.offset
    }
}

/// A map of an entry.
#[derive(Debug, PartialEq)]
struct Map {
    file: String,
    wrap: Wrap,
    lie: Lie,
    /// What heights and tilts are multiplied with.
    times: f64,
}

/// Whether a word belongs to an option that has so many arguments already: as MTL's manual says, or exporters do. After an
/// option that neither knows, all numbers and switches do.
fn is_argument(word: &str, option: &str, arguments: usize) -> bool {
    let is_number = word.parse::<f64>().is_ok();
    let is_switch = matches!(word, "on" | "off");
    match option {
        "" => false,
        "-s" | "-o" | "-t" => arguments < 3 && is_number,
        "-mm" => arguments < 2 && is_number,
        "-bm" | "-boost" | "-texres" => arguments < 1 && is_number,
        "-blendu" | "-blendv" | "-cc" | "-clamp" => arguments < 1 && is_switch,
        "-imfchan" | "-type" | "-colorspace" => arguments < 1,
        _ => is_number || is_switch,
    }
}

/// A map's file behind its options.
fn map_of(text: &str) -> Option<Map> {
    let mut map = Map {
        file: String::new(),
        wrap: Wrap::Repeat,
        lie: Lie::default(),
        times: 1.0,
    };
    let mut rest = text.trim();
    let (mut option, mut arguments) = ("", 0);
    while let Some((word, behind)) = rest.split_once(char::is_whitespace) {
        let number = word
            .parse::<f64>()
            .ok()
            .filter(|number| number.abs() <= 1e6);
        if word.starts_with('-') && word.parse::<f64>().is_err() {
            (option, arguments) = (word, 0);
        } else if !is_argument(word, option, arguments) {
            break;
        } else {
            match (option, arguments, number) {
                ("-clamp", ..) if word == "on" => map.wrap = Wrap::Clamp,
                ("-s", 0, Some(number)) => map.lie.scale.x = number,
                ("-s", 1, Some(number)) => map.lie.scale.y = number,
                ("-o", 0, Some(number)) => map.lie.offset.x = number,
                ("-o", 1, Some(number)) => map.lie.offset.y = number,
                ("-bm", _, Some(number)) => map.times = number,
                _ => {}
            }
            arguments += 1;
        }
        rest = behind.trim_start();
    }
    rest.clone_into(&mut map.file);
    (!rest.is_empty()).then_some(map)
}

fn rgb(color: [f64; 3]) -> Vec3 {
    Vec3::from_array(color.map(|c| {
        if c.is_finite() {
            c.max(0.0) as f32
        } else {
            0.0
        }
    }))
}

/// Colour, `diffuse` and `emission` of an entry that scatters light of this colour.
fn glow(mtl: &tobj::Material, color: Vec3) -> (Vec3, f32, f32) {
    let light = parameter(mtl, "Ke")
        .or(mtl.emissive)
        .map_or(Vec3::ZERO, rgb);
    let (emission, brightest) = (light.max_element(), color.max_element());
    if brightest > 0.0 {
        (color, 1.0, emission / brightest)
    } else if emission > 0.0 {
        (light / emission, 0.0, emission)
    } else {
        (color, 1.0, 0.0)
    }
}

fn highlight(mtl: &tobj::Material, specular: Vec3) -> Option<Lobe> {
    let strength = specular.element_sum() / 3.0;
    let exponent = mtl.shininess.filter(|n| n.is_finite() && *n > 0.0)? as f32;
    (strength > 0.0).then_some(Lobe { strength, exponent })
}

/// `d`, or 1 - `Tr`.
fn opacity_of(mtl: &tobj::Material) -> Option<f32> {
    let transparency = || {
        mtl.unknown_param
            .get("Tr")?
            .split_whitespace()
            .next()?
            .parse::<f64>()
            .ok()
    };
    let opacity = mtl.dissolve.or_else(|| transparency().map(|tr| 1.0 - tr))?;
    opacity
        .is_finite()
        .then_some(opacity.clamp(0.0, 1.0) as f32)
}

fn filter_of(mtl: &tobj::Material) -> Option<Vec3> {
    parameter(mtl, "Tf").map(|tint| rgb(tint).min(Vec3::ONE))
}

/// A colour that tobj keeps as text.
fn parameter(mtl: &tobj::Material, name: &str) -> Option<[f64; 3]> {
    let numbers: Vec<f64> = mtl
        .unknown_param
        .get(name)?
        .split_whitespace()
        .map_while(|word| word.parse().ok())
        .collect();
    match numbers.as_slice() {
        [r, g, b, ..] => Some([*r, *g, *b]),
        [grey] => Some([*grey; 3]),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mtl(text: &str) -> Material {
        let text = format!("newmtl a\n{text}");
        let (materials, _) = tobj::load_mtl_buf(&mut text.as_bytes()).unwrap();
        material_of(&materials[0])
    }

    #[test]
    fn each_line_of_the_table_holds() {
        let plain = mtl("Kd 0.1 0.2 0.3\nKs 0.5 0.5 0.5\nNs 80");
        assert_eq!(plain.color, Vec3::new(0.1, 0.2, 0.3));
        assert_eq!(
            plain.specular,
            Some(Lobe {
                strength: 0.5,
                exponent: 80.0
            })
        );
        assert_eq!((plain.transmit, plain.reflection), (0.0, Reflection::None));
        let mirror = mtl("Kd 0 0 0\nKs 0.9 0.9 0.9\nillum 3");
        assert_eq!(mirror.reflection, Reflection::Constant(Vec3::splat(0.9)));
        let glass = mtl("Kd 1 1 1\nNi 1.5\nillum 7");
        assert_eq!((glass.transmit, glass.ior), (1.0, 1.5));
        assert_eq!(glass.reflection, Reflection::Fresnel);
        let tinted = mtl("Kd 1 1 1\nTr 0.75\nTf 1 0 0");
        assert_eq!((tinted.filter, tinted.transmit), (0.75, 0.0));
        assert_eq!(tinted.color, Vec3::X);
        assert_eq!(mtl("Kd 0.5 0.5 0.5\nKe 1 1 1").emission, 2.0);
        let lamp = mtl("Kd 0 0 0\nKe 4 2 0");
        assert_eq!((lamp.emission, lamp.diffuse), (4.0, 0.0));
        assert_eq!(lamp.color, Vec3::new(1.0, 0.5, 0.0));
    }

    #[test]
    fn a_map_is_what_is_behind_its_options() {
        let map = |text| map_of(text).map(|map| (map.file, map.wrap));
        for (text, file, wrap) in [
            ("wood.png", "wood.png", Wrap::Repeat),
            ("-s 1 2 3 -clamp on a b.png", "a b.png", Wrap::Clamp),
            ("-bm 0.5 C:\\maps\\x.bmp", "C:\\maps\\x.bmp", Wrap::Repeat),
            ("-imfchan r -o -1 0 2.tga", "2.tga", Wrap::Repeat),
            ("-colorspace sRGB -o 0.1 x.jpg", "x.jpg", Wrap::Repeat),
            ("-bm 3 2 x.png", "2 x.png", Wrap::Repeat),
            ("-s 1 1 1 7 -o x.png", "7 -o x.png", Wrap::Repeat),
            ("-newer 1 on 2 x.png", "x.png", Wrap::Repeat),
        ] {
            assert_eq!(map(text), Some((file.to_owned(), wrap)), "{text}");
        }
        assert_eq!(map("  "), None);
        let moved = map_of("-s 2 3 -o 0.5 -bm 4 wood.png").unwrap();
        assert_eq!((moved.file.as_str(), moved.times), ("wood.png", 4.0));
        assert_eq!(moved.lie.moved(DVec2::ONE), DVec2::new(2.5, 3.0));
    }

    #[test]
    fn nonsense_comes_out_finite() {
        let odd = mtl("Kd NaN inf -1\nKs inf 0 0\nNs -3\nNi 0\nd NaN\nillum 5");
        assert!(odd.color.is_finite() && odd.transmit.is_finite() && odd.ior == 1.0);
    }
}
