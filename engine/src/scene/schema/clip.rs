//! Clips that an entity's model plays: `clip: "Run"`, `clip: (name: "Run", ...)`, or a list of these.

use super::primitive::At;
use crate::scene::reader::{Fields, Reader, Schema};
use crate::scene::syntax::{Kind, Node};
use crate::scene::writer::Writer;
use crate::world::ClipLayer;

/// A clip that is played.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClipFile {
    /// Its name in the model file; none: the first.
    pub name: Option<At<String>>,
    /// How it is played; [`ClipLayer::clip`] is for the loader to fill.
    pub layer: ClipLayer,
}

const FIELDS: [&str; 6] = ["name", "start", "speed", "weight", "loop", "paused"];

impl Schema for ClipFile {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        let mut clip = Self::default();
        if let Kind::Text(_) = node.kind {
            clip.name = At::read(reader, node);
            return Some(clip);
        }
        let fields = reader.record(node, &FIELDS, "a clip's name in quotes, or a clip")?;
        let layer = &mut clip.layer;
        read_into(reader, &fields, "start", &mut layer.start);
        read_into(reader, &fields, "speed", &mut layer.speed);
        if let Some(weight) = fields.read_checked(reader, "weight", super::range::radius) {
            layer.weight = weight;
        }
        read_into(reader, &fields, "loop", &mut layer.repeat);
        read_into(reader, &fields, "paused", &mut layer.paused);
        clip.name = fields.read(reader, "name");
        Some(clip)
    }

    fn write(&self, writer: &mut Writer) {
        let (layer, default) = (&self.layer, ClipLayer::default());
        if let Some(name) = &self.name
            && (ClipLayer { clip: 0, ..*layer }) == default
        {
            return name.write(writer);
        }
        writer.record(None, |writer| {
            writer.field_if("name", self.name.as_ref());
            writer.field_unless_default("start", &layer.start, &default.start);
            writer.field_unless_default("speed", &layer.speed, &default.speed);
            writer.field_unless_default("weight", &layer.weight, &default.weight);
            writer.field_unless_default("loop", &layer.repeat, &default.repeat);
            writer.field_unless_default("paused", &layer.paused, &default.paused);
        });
    }
}

fn read_into<T: Schema>(reader: &mut Reader, fields: &Fields, name: &str, value: &mut T) {
    if let Some(read) = fields.read(reader, name) {
        *value = read;
    }
}

/// One clip, or a list of clips that are blended.
pub fn read_clips(reader: &mut Reader, node: &Node) -> Option<Vec<ClipFile>> {
    match node.kind {
        Kind::List(_) => reader.list(node, "clips", ClipFile::read),
        _ => ClipFile::read(reader, node).map(|clip| vec![clip]),
    }
}

/// [`read_clips`]'s text.
pub fn write_clips(writer: &mut Writer, clips: &[ClipFile]) {
    match clips {
        [] => {}
        [clip] => writer.field("clip", clip),
        clips => super::timeline::write_all(writer, "clip: ", clips),
    }
}
