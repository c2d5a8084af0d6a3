//! Materials: the model of [`Material`], with `reflection` as a number, a colour or `Fresnel`.

use super::primitive::Color;
use super::range;
use crate::scene::reader::{Fields, Reader, Schema, record};
use crate::scene::syntax::{Kind, Node};
use crate::scene::writer::Writer;
use crate::world::{Lobe, Material, Reflection};

record!("a highlight", Lobe {
    "strength" => strength: f32, range::not_negative;
    "exponent" => exponent: f32, range::not_negative;
});

record!("a material", Material {
    "color" => color: Color;
    "diffuse" => diffuse: f32, range::not_negative;
    "emission" => emission: f32, range::not_negative;
    "phong" => phong: Option<Lobe>;
    "specular" => specular: Option<Lobe>;
    "reflection" => reflection: Reflection;
    "transmit" => transmit: f32, range::share;
    "filter" => filter: f32, range::share;
    "ior" => ior: f64, range::positive;
}, shares);

/// What is let through is a share of the light: the two parts are no more than all of it.
fn shares(reader: &mut Reader, fields: &Fields, material: &Material) -> Option<()> {
    let Material {
        transmit, filter, ..
    } = *material;
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
