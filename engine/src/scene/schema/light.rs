//! Lights: `light: Point(color: (1, 1, 1), intensity: 2)`, `Directional(...)` or `Spot(...)`.

use super::primitive::Color;
use super::{Angle, range};
use crate::scene::reader::{Reader, Schema, record};
use crate::scene::syntax::{Kind, Node};
use crate::scene::writer::Writer;
use crate::world::{DirectionalLight, Fade, PointLight, SpotLight};

/// The one light an entity is.
#[derive(Clone, Debug, PartialEq)]
pub enum Light {
    /// `Point`
    Point(PointLight),
    /// `Directional`
    Directional(DirectionalLight),
    /// `Spot`
    Spot(SpotLight),
}

record!("a falloff", Fade {
    "distance" => distance: f64, range::positive;
    "power" => power: f64, range::positive;
    "exact" => exact: bool;
    "range" => range: Option<f64>, range::end;
});

record!("a point light", PointLight {
    "color" => color: Color;
    "intensity" => intensity: f32, range::not_negative;
    "fade" => fade: Option<Fade>;
});

record!("a directional light", DirectionalLight {
    "color" => color: Color;
    "intensity" => intensity: f32, range::not_negative;
});

record!("a spot light", SpotLight {
    "color" => color: Color;
    "intensity" => intensity: f32, range::not_negative;
    "fade" => fade: Option<Fade>;
    "inner_angle" => inner_angle: Angle, range::half_angle;
    "outer_angle" => outer_angle: Angle, range::half_angle;
});

const KINDS: [&str; 3] = ["Point", "Directional", "Spot"];

impl Schema for Light {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        let (name, record) = match &node.kind {
            Kind::Word(name) => (*name, Kind::Tuple(None, Vec::new())),
            Kind::Tuple(Some(name), items) => (*name, Kind::Tuple(None, items.clone())),
            Kind::Record(Some(name), entries) => (*name, Kind::Record(None, entries.clone())),
            _ => return reader.mismatch(node, "`Point(...)`, `Directional(...)` or `Spot(...)`"),
        };
        let node = Node {
            at: node.at,
            kind: record,
        };
        match name {
            "Point" => PointLight::read(reader, &node).map(Self::Point),
            "Directional" => DirectionalLight::read(reader, &node).map(Self::Directional),
            "Spot" => {
                let spot = SpotLight::read(reader, &node)?;
                if spot.inner_angle > spot.outer_angle {
                    reader.expected(
                        node.at,
                        "found an inner_angle greater than the outer_angle",
                        "inner_angle up to outer_angle",
                    );
                    return None;
                }
                Some(Self::Spot(spot))
            }
            _ => {
                reader.unknown(node.at, "light", name, KINDS);
                None
            }
        }
    }

    fn write(&self, writer: &mut Writer) {
        let (name, record) = match self {
            Self::Point(light) => (KINDS[0], Writer::text_of(light)),
            Self::Directional(light) => (KINDS[1], Writer::text_of(light)),
            Self::Spot(light) => (KINDS[2], Writer::text_of(light)),
        };
        writer.atom(name);
        writer.atom(&record);
    }
}
