//! Deformation of a mesh: `deform: (keys: (...), morph: (...), wave: (...), twist: (...))`.

use glam::DVec3;

use super::primitive::At;
use super::{Angle, Loop, range};
use crate::scene::reader::{Fields, Reader, Schema, record};
use crate::scene::syntax::Node;
use crate::scene::writer::Writer;
use crate::world::{Twist, Wave};

/// The `deform` of an entity; applied in this order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Deform {
    /// `keys`
    pub keys: Option<KeysFile>,
    /// `morph`
    pub morph: Option<MorphFile>,
    /// `wave`
    pub wave: Option<Wave>,
    /// `twist`
    pub twist: Option<Twist>,
}

/// Poses by the paths of their files, relative to the scene file, and how they are played.
#[derive(Clone, Debug, PartialEq)]
pub struct KeysFile {
    /// At least one.
    pub poses: Vec<At<String>>,
    /// Seconds of play, rising, one a pose.
    pub times: Vec<f64>,
    /// Seconds of play at time 0.
    pub start: f64,
    /// Seconds of play a second.
    pub speed: f64,
    /// What follows the last pose.
    pub repeat: Loop,
}

/// Morph targets by the paths of their files, relative to the scene file.
#[derive(Clone, Debug, PartialEq)]
pub struct MorphFile {
    /// At least one.
    pub targets: Vec<At<String>>,
    /// One a target.
    pub weights: Vec<f64>,
}

record!("a wave", Wave {
    "direction" => direction: DVec3, range::direction;
    "length" => length: f64, range::positive;
    "amplitude" => amplitude: DVec3;
    "period" => period: f64;
    "phase" => phase: Angle;
});

record!("a twist", Twist {
    "origin" => origin: DVec3;
    "axis" => axis: DVec3, range::direction;
    "rate" => rate: Angle;
    "swing" => swing: Angle;
    "period" => period: f64;
    "angle" => angle: Angle;
});

/// The files of a list that must be there.
fn read_files(
    reader: &mut Reader,
    fields: &Fields,
    name: &str,
    what: &str,
) -> Option<Vec<At<String>>> {
    if fields.get(name).is_none() {
        let expected = format!("{name}: [\"file.obj\", ...]");
        reader.expected(fields.at, format!("there are no {what}"), expected);
        return None;
    }
    fields.with(reader, name, |reader, node| {
        let files = reader.list(node, what, At::<String>::read)?;
        if files.is_empty() {
            return reader.mismatch(node, "at least one file");
        }
        Some(files)
    })
}

/// Numbers, one a file; `default` where there are none.
fn read_numbers(
    reader: &mut Reader,
    fields: &Fields,
    name: &str,
    default: Vec<f64>,
    check: fn(&[f64]) -> Result<(), &'static str>,
) -> Option<Vec<f64>> {
    if fields.get(name).is_none() {
        return Some(default);
    }
    fields.with(reader, name, |reader, node| {
        let numbers = reader.list(node, "numbers", f64::read)?;
        if numbers.len() != default.len() {
            let found = format!("found {} numbers", numbers.len());
            reader.expected(node.at, found, format!("{}, one a file", default.len()));
            return None;
        }
        if let Err(expected) = check(&numbers) {
            reader.expected(node.at, "found numbers that do not fit", expected);
            return None;
        }
        Some(numbers)
    })
}

fn write_list<T: Schema>(writer: &mut Writer, name: &str, items: &[T]) {
    writer.element(&format!("{name}: "), |writer| {
        writer.list(false, |writer| {
            items.iter().for_each(|item| writer.item(item))
        });
    });
}

/// Times of poses that name none: a second apart.
fn seconds_apart(count: usize) -> Vec<f64> {
    (0..count).map(|i| i as f64).collect()
}

impl Schema for KeysFile {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        let valid = ["poses", "times", "start", "speed", "loop"];
        let fields = reader.record(node, &valid, "key frames")?;
        let poses = read_files(reader, &fields, "poses", "poses");
        let start = fields.read(reader, "start").unwrap_or(0.0);
        let speed = fields.read(reader, "speed").unwrap_or(1.0);
        let repeat = fields.read(reader, "loop").unwrap_or_default();
        let poses = poses?;
        let rising = |times: &[f64]| match times.is_sorted_by(|a, b| a < b) {
            true => Ok(()),
            false => Err("rising numbers of seconds"),
        };
        let default = seconds_apart(poses.len());
        Some(Self {
            times: read_numbers(reader, &fields, "times", default, rising)?,
            poses,
            start,
            speed,
            repeat,
        })
    }

    fn write(&self, writer: &mut Writer) {
        writer.record(None, |writer| {
            write_list(writer, "poses", &self.poses);
            if self.times != seconds_apart(self.poses.len()) {
                write_list(writer, "times", &self.times);
            }
            writer.field_unless_default("start", &self.start, &0.0);
            writer.field_unless_default("speed", &self.speed, &1.0);
            writer.field_unless_default("loop", &self.repeat, &Loop::Once);
        });
    }
}

impl Schema for MorphFile {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        let fields = reader.record(node, &["targets", "weights"], "morph targets")?;
        let targets = read_files(reader, &fields, "targets", "morph targets")?;
        let default = vec![0.0; targets.len()];
        let within = |weights: &[f64]| match weights.iter().all(|weight| weight.abs() <= 1e6) {
            true => Ok(()),
            false => Err("numbers within 1e6"),
        };
        Some(Self {
            weights: read_numbers(reader, &fields, "weights", default, within)?,
            targets,
        })
    }

    fn write(&self, writer: &mut Writer) {
        writer.record(None, |writer| {
            write_list(writer, "targets", &self.targets);
            if self.weights.iter().any(|weight| weight.to_bits() != 0) {
                write_list(writer, "weights", &self.weights);
            }
        });
    }
}

impl Schema for Deform {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        let valid = ["keys", "morph", "wave", "twist"];
        let fields = reader.record(node, &valid, "a deformation")?;
        Some(Self {
            keys: fields.read(reader, "keys"),
            morph: fields.read(reader, "morph"),
            wave: fields.read(reader, "wave"),
            twist: fields.read(reader, "twist"),
        })
    }

    fn write(&self, writer: &mut Writer) {
        writer.record(None, |writer| {
            writer.field_if("keys", self.keys.as_ref());
            writer.field_if("morph", self.morph.as_ref());
            writer.field_if("wave", self.wave.as_ref());
            writer.field_if("twist", self.twist.as_ref());
        });
    }
}
