//! The timeline as written: tracks of keyed values, and paths that look at something.

use glam::DVec3;

use super::primitive::{At, Scale};
use super::{Rotation, range};
use crate::scene::fields::{self, Field, FieldKind, Value};
use crate::scene::reader::{Reader, Schema};
use crate::scene::syntax::{Kind, Node};
use crate::scene::writer::Writer;
use crate::world::Loop;

/// All that moves by itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Timeline {
    /// Seconds after which all starts again; none: never.
    pub length: Option<f64>,
    /// Fields that change over time.
    pub tracks: Vec<Track>,
    /// Entities that travel, and what they look at.
    pub paths: Vec<Path>,
}

/// A field of an entity (or material) over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Id of the entity; of the material where the field begins with `material.`.
    pub target: At<String>,
    /// Path of the field.
    pub field: At<String>,
    /// At least one, in order of time.
    pub keys: Vec<Key>,
    /// What follows the last key.
    pub repeat: Loop,
}

/// An entity's position over time, and what it looks at.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// Id of the entity, usually a camera.
    pub target: At<String>,
    /// Positions in the parent's space, at least one, in order of time.
    pub keys: Vec<Key>,
    /// Where its -Z axis points; none: its rotation is left alone.
    pub look_at: Option<LookAt>,
    /// Its +Y axis is as near to this as can be, in world space.
    pub up: DVec3,
    /// What follows the last key.
    pub repeat: Loop,
}

/// A value at a time.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// Seconds.
    pub time: f64,
    /// The value at that time.
    pub value: KeyValue,
    /// How the value comes here from the key before.
    pub ease: Ease,
}

/// What a key holds, as written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KeyValue {
    /// For switches; steps.
    Bool(bool),
    /// For numbers; angles in degrees.
    Number(f64),
    /// For positions, scales and colours.
    Vec3(DVec3),
    /// For rotations.
    Rotation(Rotation),
}

/// How a value comes to a key from the one before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ease {
    /// The old value until the key's time.
    Step,
    /// At constant speed.
    #[default]
    Linear,
    /// From rest: t^3.
    In,
    /// To rest: 1 - (1-t)^3.
    Out,
    /// From rest to rest: 3t^2 - 2t^3.
    InOut,
    /// On the Catmull-Rom curve through the keys around.
    Smooth,
}

/// What a path looks at.
#[derive(Clone, Debug, PartialEq)]
pub enum LookAt {
    /// A point of the world.
    Point(DVec3),
    /// An entity by its id, wherever it goes.
    Entity(At<String>),
}

macro_rules! words {
    ($type:ident, $what:literal, $($word:ident),*) => {
        impl Schema for $type {
            fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
                match node.kind {
                    $(Kind::Word(stringify!($word)) => Some(Self::$word),)*
                    Kind::Word(word) => {
                        reader.unknown(node.at, $what, word, [$(stringify!($word)),*]);
                        None
                    }
                    _ => reader.mismatch(node, concat!("one of", $(" ", stringify!($word)),*)),
                }
            }

            fn write(&self, writer: &mut Writer) {
                writer.atom(match self {
                    $(Self::$word => stringify!($word),)*
                });
            }
        }
    };
}
words!(Ease, "ease", Step, Linear, In, Out, InOut, Smooth);
words!(Loop, "loop", Once, Repeat, PingPong);

impl Schema for LookAt {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        match node.kind {
            Kind::Text(_) => At::read(reader, node).map(Self::Entity),
            Kind::Tuple(None, _) => DVec3::read(reader, node).map(Self::Point),
            _ => reader.mismatch(node, "a point (x, y, z) or the id of an entity in quotes"),
        }
    }

    fn write(&self, writer: &mut Writer) {
        match self {
            Self::Point(point) => point.write(writer),
            Self::Entity(id) => id.write(writer),
        }
    }
}

impl KeyValue {
    fn read(reader: &mut Reader, node: &Node, kind: FieldKind) -> Option<Self> {
        match kind {
            FieldKind::Bool => bool::read(reader, node).map(Self::Bool),
            FieldKind::Number => f64::read(reader, node).map(Self::Number),
            FieldKind::Vec3 => Scale::read(reader, node).map(|v| Self::Vec3(v.0)),
            FieldKind::Rotation => Rotation::read(reader, node).map(Self::Rotation),
            FieldKind::Text => reader.mismatch(node, "a field that can be keyed"),
        }
    }

    /// The value as fields know it.
    pub fn value(self) -> Value {
        match self {
            Self::Bool(value) => Value::Bool(value),
            Self::Number(value) => Value::Number(value),
            Self::Vec3(value) => Value::Vec3(value),
            Self::Rotation(rotation) => Value::Rotation(rotation.quat()),
        }
    }

    fn write(self, writer: &mut Writer) {
        match self {
            Self::Bool(value) => value.write(writer),
            Self::Number(value) => value.write(writer),
            Self::Vec3(value) => value.write(writer),
            Self::Rotation(value) => value.write(writer),
        }
    }
}

/// `(time, value)` or `(time, value, Ease)`.
fn read_key(reader: &mut Reader, node: &Node, field: &Field, ease: Ease) -> Option<Key> {
    let Kind::Tuple(None, items) = &node.kind else {
        return reader.mismatch(node, "a key `(secs, value)` or `(secs, value, Ease)`");
    };
    let (time, value, eased) = match items.as_slice() {
        [time, value] => (time, value, None),
        [time, value, eased] => (time, value, Some(eased)),
        _ => return reader.mismatch(node, "a key `(secs, value)` or `(secs, value, Ease)`"),
    };
    let seconds = f64::read(reader, time);
    let value_read = KeyValue::read(reader, value, field.kind);
    let ease = match eased {
        Some(eased) => Ease::read(reader, eased),
        None => Some(ease),
    };
    if let Some(read) = value_read
        && let Err(expected) = field.check(&read.value())
    {
        reader.expected(
            value.at,
            format!("found {}", value.kind.describe()),
            expected,
        );
        return None;
    }
    let seconds = seconds?;
    if let Err(expected) = range::secs(&seconds) {
        reader.expected(time.at, format!("found {seconds}"), expected);
        return None;
    }
    Some(Key {
        time: seconds,
        value: value_read?,
        ease: ease?,
    })
}

/// At least one key, times rising.
fn read_keys(reader: &mut Reader, node: &Node, field: &Field, ease: Ease) -> Option<Vec<Key>> {
    let mut before: Option<f64> = None;
    let keys = reader.list(node, "keys", |reader, node| {
        let key = read_key(reader, node, field, ease)?;
        if before.is_some_and(|before| key.time <= before) {
            reader.expected(
                node.at,
                format!(
                    "the key at {} s comes after the one at {} s",
                    key.time,
                    before.unwrap_or_default()
                ),
                "keys in order of time, no two at the same",
            );
            return None;
        }
        before = Some(key.time);
        Some(key)
    })?;
    if keys.is_empty() {
        if matches!(&node.kind, Kind::List(items) if items.is_empty()) {
            reader.expected(node.at, "found no keys", "at least one");
        }
        return None;
    }
    Some(keys)
}

fn write_keys(writer: &mut Writer, keys: &[Key], default: Ease) {
    writer.element("keys: ", |writer| {
        writer.list(false, |writer| {
            for key in keys {
                writer.element("", |writer| {
                    writer.record(None, |writer| {
                        writer.item(&key.time);
                        writer.element("", |writer| key.value.write(writer));
                        if key.ease != default {
                            writer.item(&key.ease);
                        }
                    });
                });
            }
        });
    });
}

/// Reports fields that must be there.
fn require(reader: &mut Reader, fields: &crate::scene::reader::Fields, names: &[&str]) {
    for name in names {
        if fields.get(name).is_none() {
            reader.expected(
                fields.at,
                format!("`{name}` is missing"),
                format!("`{name}: ...`"),
            );
        }
    }
}

impl Schema for Track {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        let fields = reader.record(node, &["target", "field", "keys", "loop"], "a track")?;
        require(reader, &fields, &["target", "field", "keys"]);
        let target = fields.read(reader, "target");
        let path: Option<At<String>> = fields.read(reader, "field");
        let repeat = fields.read(reader, "loop").unwrap_or_default();
        let path = path?;
        let keyable = || {
            fields::all()
                .iter()
                .filter(|field| field.kind != FieldKind::Text)
        };
        let Some(field) = keyable().find(|field| field.path == path.value) else {
            let at = path.place.at;
            reader.within(".field", |reader| {
                reader.unknown(at, "field", &path.value, keyable().map(|field| field.path));
            });
            return None;
        };
        let keys = fields.with(reader, "keys", |reader, node| {
            read_keys(reader, node, field, Ease::Linear)
        })?;
        Some(Self {
            target: target?,
            field: path,
            keys,
            repeat,
        })
    }

    fn write(&self, writer: &mut Writer) {
        writer.record(None, |writer| {
            writer.field("target", &self.target);
            writer.field("field", &self.field);
            writer.field_unless_default("loop", &self.repeat, &Loop::Once);
            write_keys(writer, &self.keys, Ease::Linear);
        });
    }
}

impl Schema for Path {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        let names = ["target", "keys", "look_at", "up", "loop"];
        let fields = reader.record(node, &names, "a path")?;
        require(reader, &fields, &["target", "keys"]);
        let target = fields.read(reader, "target");
        let look_at = fields.read(reader, "look_at");
        let up = fields.read_checked(reader, "up", range::direction);
        let repeat = fields.read(reader, "loop").unwrap_or_default();
        let keys = fields.with(reader, "keys", |reader, node| {
            read_keys(reader, node, fields::position(), Ease::Smooth)
        });
        Some(Self {
            target: target?,
            keys: keys?,
            look_at,
            up: up.unwrap_or(DVec3::Y),
            repeat,
        })
    }

    fn write(&self, writer: &mut Writer) {
        writer.record(None, |writer| {
            writer.field("target", &self.target);
            writer.field_if("look_at", self.look_at.as_ref());
            writer.field_unless_default("up", &self.up, &DVec3::Y);
            writer.field_unless_default("loop", &self.repeat, &Loop::Once);
            write_keys(writer, &self.keys, Ease::Smooth);
        });
    }
}

impl Schema for Timeline {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        let fields = reader.record(node, &["length", "tracks", "paths"], "a timeline")?;
        let length = fields.read_checked(reader, "length", range::positive);
        let tracks = fields.with(reader, "tracks", |reader, node| {
            reader.list(node, "tracks", Track::read)
        });
        let paths = fields.with(reader, "paths", |reader, node| {
            reader.list(node, "paths", Path::read)
        });
        Some(Self {
            length,
            tracks: tracks.unwrap_or_default(),
            paths: paths.unwrap_or_default(),
        })
    }

    fn write(&self, writer: &mut Writer) {
        writer.record(None, |writer| {
            writer.field_if("length", self.length.as_ref());
            write_all(writer, "tracks: ", &self.tracks);
            write_all(writer, "paths: ", &self.paths);
        });
    }
}

/// A list, a line an element, unless it is empty.
pub(super) fn write_all<T: Schema>(writer: &mut Writer, prefix: &str, values: &[T]) {
    if !values.is_empty() {
        writer.element(prefix, |writer| {
            writer.list(true, |writer| {
                for value in values {
                    writer.item(value);
                }
            });
        });
    }
}
