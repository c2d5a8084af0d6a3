//! What is behind everything: `background: (0.1, 0.2, 0.4)`, or `Gradient(zenith: ..., horizon: ..., ground: ...)`.

use super::primitive::Color;
use crate::scene::reader::{Reader, Schema};
use crate::scene::syntax::{Kind, Node};
use crate::scene::writer::Writer;
use crate::world::Background;

const PARTS: [&str; 3] = ["zenith", "horizon", "ground"];

impl Schema for Background {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        match &node.kind {
            Kind::Number(_) | Kind::Tuple(None, _) => {
                Color::read(reader, node).map(|color| color.0.into())
            }
            Kind::Record(Some("Gradient"), _) => {
                let fields = reader.fields(node, &PARTS);
                let mut color = |name| fields.read(reader, name).map(|color: Color| color.0);
                let [zenith, horizon, ground] = PARTS.map(&mut color);
                let horizon = horizon.or(zenith).or(ground).unwrap_or_default();
                Some(Self {
                    zenith: zenith.unwrap_or(horizon),
                    horizon,
                    ground: ground.unwrap_or(horizon),
                })
            }
            Kind::Record(Some(name), _) | Kind::Tuple(Some(name), _) | Kind::Word(name) => {
                reader.unknown(node.at, "background", name, ["Gradient"]);
                None
            }
            _ => reader.mismatch(node, "a colour (r, g, b), a number or `Gradient(...)`"),
        }
    }

    fn write(&self, writer: &mut Writer) {
        if self.is_plain() {
            return Color(self.horizon).write(writer);
        }
        writer.record(Some("Gradient"), |writer| {
            let colors = [self.zenith, self.horizon, self.ground];
            for (name, color) in PARTS.into_iter().zip(colors) {
                writer.field(name, &Color(color));
            }
        });
    }
}
