//! Cameras: `camera: (fov: 45)` is a pinhole, `camera: (orthographic_height: 10)` has parallel rays.

use super::{Angle, range};
use crate::scene::reader::{Reader, Schema};
use crate::scene::syntax::{Kind, Node};
use crate::scene::writer::Writer;
use crate::world::{Camera, Projection, ToneMap};

const TONE_MAPS: [(&str, ToneMap); 3] = [
    ("Clip", ToneMap::Clip),
    ("Reinhard", ToneMap::Reinhard),
    ("Filmic", ToneMap::Filmic),
];

impl Schema for ToneMap {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        let Kind::Word(word) = node.kind else {
            return reader.mismatch(node, "`Clip`, `Reinhard` or `Filmic`");
        };
        let found = TONE_MAPS.iter().find(|(name, _)| *name == word);
        if found.is_none() {
            reader.unknown(node.at, "tone map", word, TONE_MAPS.map(|(name, _)| name));
        }
        found.map(|&(_, tone_map)| tone_map)
    }

    fn write(&self, writer: &mut Writer) {
        let found = TONE_MAPS.iter().find(|(_, tone_map)| tone_map == self);
        writer.atom(found.map_or("Clip", |(name, _)| name));
    }
}

impl Schema for Camera {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        let names = ["fov", "orthographic_height", "exposure", "tone_map"];
        let fields = reader.record(node, &names, "a camera")?;
        let fov = fields.read_checked(reader, "fov", range::opening);
        let height = fields.read_checked(reader, "orthographic_height", range::positive);
        let default = Self::default();
        let projection = match (fov, height) {
            (Some(_), Some(_)) => {
                reader.expected(
                    node.at,
                    "found both `fov` and `orthographic_height`",
                    "one of the two",
                );
                return None;
            }
            (Some(Angle(vertical_fov)), None) => Projection::Perspective { vertical_fov },
            (None, Some(height)) => Projection::Orthographic { height },
            (None, None) => default.projection,
        };
        Some(Self {
            projection,
            exposure: fields.read(reader, "exposure").unwrap_or(default.exposure),
            tone_map: fields.read(reader, "tone_map").unwrap_or(default.tone_map),
        })
    }

    fn write(&self, writer: &mut Writer) {
        let default = Self::default();
        writer.record(None, |writer| {
            match self.projection {
                Projection::Perspective { vertical_fov } => {
                    writer.field("fov", &Angle(vertical_fov))
                }
                Projection::Orthographic { height } => writer.field("orthographic_height", &height),
            }
            writer.field_unless_default("exposure", &self.exposure, &default.exposure);
            writer.field_unless_default("tone_map", &self.tone_map, &default.tone_map);
        });
    }
}
