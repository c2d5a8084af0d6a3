//! What is behind everything: `background: (0.1, 0.2, 0.4)`, `Gradient(zenith: ..., horizon: ..., ground: ...)`, or
//! `Image(path: "sky.hdr", turn: 30)`.

use glam::Vec3;

use super::Angle;
use super::primitive::{At, Color};
use crate::scene::reader::{Reader, Schema};
use crate::scene::syntax::{Kind, Node};
use crate::scene::writer::Writer;
use crate::world::Background;

const PARTS: [&str; 3] = ["zenith", "horizon", "ground"];

/// A background, and the file of its panorama.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BackgroundFile {
    /// All but its picture.
    pub background: Background,
    /// The path of a panorama, with `/` between folders, from the scene file's.
    pub picture: Option<At<String>>,
}

impl From<Background> for BackgroundFile {
    fn from(background: Background) -> Self {
        Self {
            background,
            picture: None,
        }
    }
}

/// The fields of an `Image`.
fn image(reader: &mut Reader, node: &Node) -> Option<BackgroundFile> {
    let fields = reader.fields(node, &["path", "turn", "color"]);
    let color: Option<Color> = fields.read(reader, "color");
    let turn: Option<Angle> = fields.read(reader, "turn");
    let picture: Option<At<String>> = fields.read(reader, "path");
    if picture.is_none() && fields.get("path").is_none() {
        reader.expected(node.at, "the background has no path", "path: \"sky.hdr\"");
    }
    Some(BackgroundFile {
        background: Background {
            turn: turn.map_or(0.0, |turn| turn.0),
            ..color.map_or(Vec3::ONE, |color| color.0).into()
        },
        picture: Some(picture?),
    })
}

impl Schema for BackgroundFile {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        match &node.kind {
            Kind::Number(_) | Kind::Tuple(None, _) => {
                Color::read(reader, node).map(|color| Background::from(color.0).into())
            }
            Kind::Record(Some("Gradient"), _) => {
                let fields = reader.fields(node, &PARTS);
                let mut color = |name| fields.read(reader, name).map(|color: Color| color.0);
                let [zenith, horizon, ground] = PARTS.map(&mut color);
                let horizon = horizon.or(zenith).or(ground).unwrap_or_default();
                let background = Background {
                    zenith: zenith.unwrap_or(horizon),
                    horizon,
                    ground: ground.unwrap_or(horizon),
                    ..Background::default()
                };
                Some(background.into())
            }
            Kind::Record(Some("Image"), _) => image(reader, node),
            Kind::Tuple(Some("Image"), items) if items.len() == 1 => Some(Self {
                background: Vec3::ONE.into(),
                picture: Some(At::read(reader, &items[0])?),
            }),
            Kind::Record(Some(name), _) | Kind::Tuple(Some(name), _) | Kind::Word(name) => {
                reader.unknown(node.at, "background", name, ["Gradient", "Image"]);
                None
            }
            _ => reader.mismatch(
                node,
                "a colour (r, g, b), a number, `Gradient(...)` or `Image(...)`",
            ),
        }
    }

    fn write(&self, writer: &mut Writer) {
        let background = &self.background;
        if let Some(path) = &self.picture {
            return writer.record(Some("Image"), |writer| {
                writer.field("path", path);
                writer.field_unless_default("turn", &Angle(background.turn), &Angle(0.0));
                writer.field_unless_default("color", &Color(background.horizon), &Color(Vec3::ONE));
            });
        }
        if background.is_plain() {
            return Color(background.horizon).write(writer);
        }
        writer.record(Some("Gradient"), |writer| {
            let colors = [background.zenith, background.horizon, background.ground];
            for (name, color) in PARTS.into_iter().zip(colors) {
                writer.field(name, &Color(color));
            }
        });
    }
}
