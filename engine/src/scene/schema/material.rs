//! Materials: the model of [`Material`], with `reflection` as a number, a colour or `Fresnel`, and pictures as files.

use super::primitive::Color;
use super::range;
use super::texture::TextureFile;
use crate::scene::reader::{Fields, Reader, Schema, record};
use crate::scene::syntax::{Kind, Node};
use crate::scene::writer::Writer;
use crate::world::{Lobe, Material, Reflection};

record!("a highlight", Lobe {
    "strength" => strength: f32, range::not_negative;
    "exponent" => exponent: f32, range::not_negative;
});

/// A material, and the files of its pictures.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MaterialFile {
    /// All but its pictures.
    pub material: Material,
    /// `color_map`
    pub color_map: Option<TextureFile>,
    /// `normal_map`
    pub normal_map: Option<TextureFile>,
}

impl From<Material> for MaterialFile {
    fn from(material: Material) -> Self {
        Self {
            material,
            ..Self::default()
        }
    }
}

record!("a material", MaterialFile {
    "color" => material.color: Color;
    "diffuse" => material.diffuse: f32, range::not_negative;
    "emission" => material.emission: f32, range::not_negative;
    "phong" => material.phong: Option<Lobe>;
    "specular" => material.specular: Option<Lobe>;
    "reflection" => material.reflection: Reflection;
    "transmit" => material.transmit: f32, range::share;
    "filter" => material.filter: f32, range::share;
    "ior" => material.ior: f64, range::positive;
    "absorption" => material.absorption: Color;
    "color_map" => color_map: Option<TextureFile>;
    "normal_map" => normal_map: Option<TextureFile>;
    "alpha_cutoff" => material.alpha_cutoff: Option<f32>, range::least_alpha;
}, shares);

/// What is let through is a share of the light: the two parts are no more than all of it.
fn shares(reader: &mut Reader, fields: &Fields, material: &MaterialFile) -> Option<()> {
    let Material {
        transmit, filter, ..
    } = material.material;
    // Tenths in f32 may add up to a rounding error more than 1.
    if transmit + filter <= 1.0 + 1e-6 {
        return Some(());
    }
    let (step, entry) = match (fields.get("filter"), fields.get("transmit")) {
        (Some(filter), _) => (".filter", filter.value.at),
        (None, transmit) => (".transmit", transmit.map_or(fields.at, |t| t.value.at)),
    };
    reader.within(step, |reader| {
        let found = format!("found transmit {transmit} and filter {filter}");
        reader.expected(entry, found, "a sum of at most 1");
    });
    None
}

impl Schema for Reflection {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        match &node.kind {
            Kind::Word("None") => Some(Self::None),
            Kind::Word("Fresnel") => Some(Self::Fresnel),
            Kind::Word(word) => {
                reader.unknown(node.at, "reflection", word, ["None", "Fresnel"]);
                None
            }
            Kind::Number(_) | Kind::Tuple(None, _) => {
                Color::read(reader, node).map(|color| Self::Constant(color.0))
            }
            _ => reader.mismatch(node, "a number, a colour (r, g, b), `Fresnel` or `None`"),
        }
    }

    fn write(&self, writer: &mut Writer) {
        match self {
            Self::None => writer.atom("None"),
            Self::Fresnel => writer.atom("Fresnel"),
            Self::Constant(color)
                if color.x.to_bits() == color.y.to_bits()
                    && color.y.to_bits() == color.z.to_bits() =>
            {
                color.x.write(writer);
            }
            Self::Constant(color) => Color(*color).write(writer),
        }
    }
}
