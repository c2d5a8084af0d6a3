//! Pictures that materials name: `color_map: "wood.png"`, or `(path: "wood.png", wrap: Clamp)`.

use super::primitive::At;
use crate::scene::reader::{Reader, Schema};
use crate::scene::syntax::{Kind, Node};
use crate::scene::writer::Writer;
use crate::world::Wrap;

/// A picture by the path of its file, relative to the scene file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TextureFile {
    /// The path, with `/` between folders.
    pub path: At<String>,
    /// Beyond the picture's edges.
    pub wrap: Wrap,
}

const WRAPS: [(&str, Wrap); 3] = [
    ("Repeat", Wrap::Repeat),
    ("Clamp", Wrap::Clamp),
    ("Mirror", Wrap::Mirror),
];

impl Schema for Wrap {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        let Kind::Word(word) = &node.kind else {
            return reader.mismatch(node, "`Repeat`, `Clamp` or `Mirror`");
        };
        let found = WRAPS.into_iter().find(|(name, _)| name == word);
        if found.is_none() {
            reader.unknown(node.at, "wrap", word, WRAPS.map(|(name, _)| name));
        }
        found.map(|(_, wrap)| wrap)
    }

    fn write(&self, writer: &mut Writer) {
        let name = WRAPS.into_iter().find(|(_, wrap)| wrap == self);
        writer.atom(name.map_or("Repeat", |(name, _)| name));
    }
}

impl Schema for TextureFile {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        if matches!(node.kind, Kind::Text(_)) {
            let path = At::read(reader, node)?;
            return Some(Self {
                path,
                wrap: Wrap::default(),
            });
        }
        let fields = reader.record(node, &["path", "wrap"], "a picture")?;
        let wrap = fields.read(reader, "wrap").unwrap_or_default();
        let Some(path) = fields.read(reader, "path") else {
            if fields.get("path").is_none() {
                reader.expected(node.at, "the picture has no path", "path: \"file.png\"");
            }
            return None;
        };
        Some(Self { path, wrap })
    }

    fn write(&self, writer: &mut Writer) {
        if self.wrap == Wrap::default() {
            self.path.write(writer);
            return;
        }
        writer.record(None, |writer| {
            writer.field("path", &self.path);
            writer.field("wrap", &self.wrap);
        });
    }
}
