//! Motion without tracks: `motion: (orbit: (...), spin: (...), sway: (...), path: (...))`.

use glam::DVec3;

use super::{Angle, range};
use crate::scene::reader::{Reader, Schema, record};
use crate::scene::syntax::Node;
use crate::scene::writer::Writer;
use crate::world::{Orbit, PathMotion, Spin, Sway};

/// The `motion` of an entity.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    /// `orbit`
    pub orbit: Option<Orbit>,
    /// `spin`
    pub spin: Option<Spin>,
    /// `sway`
    pub sway: Option<Sway>,
    /// `path`
    pub path: Option<PathMotion>,
}

impl Motion {
    /// Whether it overwrites a field of the transform in every frame.
    pub fn writes(&self, field: &str) -> bool {
        let path = self.path.as_ref();
        match field {
            "transform.translation" => {
                self.orbit.is_some() || self.sway.is_some() || path.is_some()
            }
            "transform.rotation" => self.spin.is_some() || path.is_some_and(|path| path.look_along),
            _ => false,
        }
    }
}

record!("an orbit", Orbit {
    "center" => center: DVec3;
    "axis" => axis: DVec3, range::direction;
    "radius" => radius: f64;
    "period" => period: f64;
    "phase" => phase: Angle;
});

record!("a spin", Spin {
    "axis" => axis: DVec3, range::direction;
    "period" => period: f64;
    "phase" => phase: Angle;
});

record!("a sway", Sway {
    "amplitude" => amplitude: DVec3;
    "period" => period: f64;
    "phase" => phase: Angle;
});

const PATH_FIELDS: [&str; 6] = [
    "points",
    "period",
    "start",
    "closed",
    "smooth",
    "look_along",
];

impl Schema for PathMotion {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        let fields = reader.record(node, &PATH_FIELDS, "a path")?;
        let points = fields.with(reader, "points", |reader, node| {
            let points = reader.list(node, "points", DVec3::read)?;
            if points.is_empty() {
                return reader.mismatch(node, "at least one point");
            }
            Some(points)
        });
        if fields.get("points").is_none() {
            reader.expected(
                node.at,
                "the path has no points",
                "points: [(x, y, z), ...]",
            );
        }
        let default = Self::default();
        Some(Self {
            points: points?,
            period: fields.read(reader, "period").unwrap_or(default.period),
            start: fields.read(reader, "start").unwrap_or(default.start),
            closed: fields.read(reader, "closed").unwrap_or(default.closed),
            smooth: fields.read(reader, "smooth").unwrap_or(default.smooth),
            look_along: fields
                .read(reader, "look_along")
                .unwrap_or(default.look_along),
        })
    }

    fn write(&self, writer: &mut Writer) {
        let default = Self::default();
        writer.record(None, |writer| {
            writer.element("points: ", |writer| {
                writer.list(false, |writer| {
                    for point in &self.points {
                        writer.item(point);
                    }
                });
            });
            writer.field_unless_default("period", &self.period, &default.period);
            writer.field_unless_default("start", &self.start, &default.start);
            writer.field_unless_default("closed", &self.closed, &default.closed);
            writer.field_unless_default("smooth", &self.smooth, &default.smooth);
            writer.field_unless_default("look_along", &self.look_along, &default.look_along);
        });
    }
}

impl Schema for Motion {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        let fields = reader.record(node, &["orbit", "spin", "sway", "path"], "a motion")?;
        Some(Self {
            orbit: fields.read(reader, "orbit"),
            spin: fields.read(reader, "spin"),
            sway: fields.read(reader, "sway"),
            path: fields.read(reader, "path"),
        })
    }

    fn write(&self, writer: &mut Writer) {
        writer.record(None, |writer| {
            writer.field_if("orbit", self.orbit.as_ref());
            writer.field_if("spin", self.spin.as_ref());
            writer.field_if("sway", self.sway.as_ref());
            writer.field_if("path", self.path.as_ref());
        });
    }
}
