//! Angles: degrees in the file, radians in the world, without losing a bit on the way back.

use crate::scene::reader::{Reader, Schema};
use crate::scene::syntax::{Kind, Node};
use crate::scene::writer::Writer;

/// An angle in radians; `60` in the file is degrees, `Radians(1.0471975511965976)` what it says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Angle(pub f64);

impl From<f64> for Angle {
    fn from(radians: f64) -> Self {
        Self(radians)
    }
}

impl From<Angle> for f64 {
    fn from(angle: Angle) -> Self {
        angle.0
    }
}

impl Schema for Angle {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        match &node.kind {
            Kind::Tuple(Some("Radians"), inner) if inner.len() == 1 => {
                f64::read(reader, &inner[0]).map(Self)
            }
            Kind::Number(_) | Kind::Word("inf" | "NaN") => {
                f64::read(reader, node).map(|degrees| Self(from_degrees(degrees)))
            }
            _ => reader.mismatch(node, "an angle in degrees"),
        }
    }

    fn write(&self, writer: &mut Writer) {
        let degrees = to_degrees(self.0);
        if from_degrees(degrees).to_bits() == self.0.to_bits() {
            degrees.write(writer);
        } else {
            writer.record(Some("Radians"), |writer| writer.item(&self.0));
        }
    }
}

/// Radians of an angle in degrees.
pub fn from_degrees(degrees: f64) -> f64 {
    degrees.to_radians()
}

/// Degrees whose radians are exactly `radians`, the roundest such number; else the nearest.
///
/// Rounding makes a few radians unreachable: no f64 of degrees maps to them.
pub fn to_degrees(radians: f64) -> f64 {
    let degrees = radians.to_degrees();
    let rounded = (degrees * 1e9).round() / 1e9;
    [rounded, degrees, degrees.next_up(), degrees.next_down()]
        .into_iter()
        .find(|&d| from_degrees(d).to_bits() == radians.to_bits())
        .unwrap_or(degrees)
}
