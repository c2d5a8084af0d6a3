//! Acceleration structures: `structure: Boxes2`, `structure: Spheres(leaf: 4)`.

use crate::scene::reader::{Reader, Schema};
use crate::scene::syntax::{Kind, Node};
use crate::scene::writer::Writer;
use crate::world::Structure;

const KINDS: [&str; 4] = ["Boxes4", "Boxes2", "Spheres", "NoTree"];
/// Triangles of a leaf of spheres where the file does not say.
const LEAF: u32 = 4;

impl Schema for Structure {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        match &node.kind {
            Kind::Word("Boxes4") => Some(Self::Boxes4),
            Kind::Word("Boxes2") => Some(Self::Boxes2),
            Kind::Word("Spheres") => Some(Self::Spheres { leaf: LEAF }),
            // `None` in a file leaves a field out.
            Kind::Word("NoTree") => Some(Self::None),
            Kind::Record(Some("Spheres"), _) => {
                let fields = reader.fields(node, &["leaf"]);
                let range = |leaf: &u32| {
                    let expected = "a whole number from 1 to 8";
                    (1..=8).contains(leaf).then_some(()).ok_or(expected)
                };
                let leaf = fields.read_checked(reader, "leaf", range);
                Some(Self::Spheres {
                    leaf: leaf.unwrap_or(LEAF),
                })
            }
            Kind::Word(name) | Kind::Record(Some(name), _) | Kind::Tuple(Some(name), _) => {
                reader.unknown(node.at, "structure", name, KINDS);
                None
            }
            _ => reader.mismatch(node, "`Boxes4`, `Boxes2`, `Spheres(leaf: 4)` or `NoTree`"),
        }
    }

    fn write(&self, writer: &mut Writer) {
        match self {
            Self::Boxes4 => writer.atom("Boxes4"),
            Self::Boxes2 => writer.atom("Boxes2"),
            Self::Spheres { leaf } => {
                writer.record(Some("Spheres"), |writer| writer.field("leaf", leaf));
            }
            Self::None => writer.atom("NoTree"),
        }
    }
}
