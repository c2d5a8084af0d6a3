//! Shapes: sphere, plane, box, polygon, mesh file.

use glam::DVec3;

use super::primitive::At;
use super::range;
use crate::scene::reader::{Reader, Schema, record};
use crate::scene::syntax::Node;
use crate::scene::writer::Writer;
use crate::world::{Cuboid, Plane, Polygon, Sphere, newell_normal, triangulate};

/// The one shape an entity has. In the file the key says which: `sphere: (radius: 2)`.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// `sphere`
    Sphere(Sphere),
    /// `plane`
    Plane(Plane),
    /// `box`
    Box(Cuboid),
    /// `polygon`
    Polygon(Polygon),
    /// `mesh`
    Mesh(MeshFile),
}

/// A mesh by the path of its file, relative to the scene file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshFile {
    /// The path, with `/` between folders.
    pub path: At<String>,
    /// Smooth shading across edges whose faces meet at no more than this; none: as the file says.
    pub smooth_angle: Option<f64>,
}

record!("a sphere", Sphere { "radius" => radius: f64, range::positive; });

record!("a plane", Plane {
    "normal" => normal: DVec3, range::direction;
    "distance" => distance: f64;
});

impl Schema for Cuboid {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        let fields = reader.record(node, &["min", "max"], "a box")?;
        let default = Self::default();
        let min = fields.read(reader, "min").unwrap_or(default.min);
        let max = fields.read(reader, "max").unwrap_or(default.max);
        if !min.cmplt(max).all() {
            let at = fields
                .get("max")
                .or(fields.get("min"))
                .map_or(node.at, |entry| entry.value.at);
            reader.expected(
                at,
                format!(
                    "found max {} for min {}",
                    Writer::text_of(&max),
                    Writer::text_of(&min)
                ),
                "max greater than min on every axis",
            );
            return None;
        }
        Some(Self { min, max })
    }

    fn write(&self, writer: &mut Writer) {
        let default = Self::default();
        writer.record(None, |writer| {
            writer.field_unless_default("min", &self.min, &default.min);
            writer.field_unless_default("max", &self.max, &default.max);
        });
    }
}

impl Schema for Polygon {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        let fields = reader.record(node, &["corners", "loops"], "a polygon")?;
        let corners = fields.with(reader, "corners", |reader, node| {
            reader.list(node, "corners", DVec3::read)
        });
        let loops = fields.with(reader, "loops", |reader, node| {
            reader.list(node, "loops of corners", |reader, node| {
                reader.list(node, "corners", DVec3::read)
            })
        });
        let loops = match (corners, loops) {
            (Some(corners), None) => vec![corners],
            (None, Some(loops)) => loops,
            (None, None) if fields.get("corners").is_none() && fields.get("loops").is_none() => {
                return Some(Self::default());
            }
            (Some(_), Some(_)) => {
                reader.expected(
                    node.at,
                    "found both `corners` and `loops`",
                    "one of the two",
                );
                return None;
            }
            (None, None) => return None,
        };
        let polygon = Self { loops };
        match flat_polygon(&polygon) {
            Ok(()) => Some(polygon),
            Err(why) => {
                reader.expected(node.at, why, "a flat polygon of at least three corners");
                None
            }
        }
    }

    fn write(&self, writer: &mut Writer) {
        writer.record(None, |writer| {
            if let [corners] = self.loops.as_slice() {
                writer.element("corners: ", |writer| write_corners(writer, corners));
            } else {
                writer.element("loops: ", |writer| {
                    writer.list(true, |writer| {
                        for corners in &self.loops {
                            writer.element("", |writer| write_corners(writer, corners));
                        }
                    });
                });
            }
        });
    }
}

fn write_corners(writer: &mut Writer, corners: &[DVec3]) {
    writer.list(false, |writer| {
        for corner in corners {
            writer.item(corner);
        }
    });
}

/// Whether a polygon lies in a plane and has an area.
///
/// # Errors
/// A sentence that says what is wrong with it.
pub fn flat_polygon(polygon: &Polygon) -> Result<(), String> {
    let corners: Vec<DVec3> = polygon.loops.iter().flatten().copied().collect();
    triangulate(polygon)?;
    let outer = &polygon.loops[0];
    let first = outer[0];
    let size = corners
        .iter()
        .map(|&c| (c - first).length())
        .fold(0.0, f64::max);
    // Hand-written coordinates have a few digits; a millionth of the size is below any of them.
    let Some(normal) = newell_normal(outer).try_normalize() else {
        return Err("the polygon has no area".into());
    };
    let off = corners
        .iter()
        .map(|&c| (c - first).dot(normal).abs())
        .fold(0.0, f64::max);
    if off > 1e-6 * size {
        let worst = corners
            .iter()
            .position(|&c| (c - first).dot(normal).abs() >= off);
        return Err(format!(
            "the polygon is not flat: corner {} lies {off:.3e} outside its plane",
            worst.unwrap_or_default()
        ));
    }
    Ok(())
}

impl Schema for MeshFile {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        if matches!(node.kind, crate::scene::syntax::Kind::Text(_)) {
            let path = At::read(reader, node)?;
            return Some(Self {
                path,
                smooth_angle: None,
            });
        }
        let fields = reader.record(node, &["path", "smooth_angle"], "a mesh")?;
        let smooth_angle = fields.read_checked(reader, "smooth_angle", |angle: &f64| {
            if (0.0..=180.0).contains(angle) {
                Ok(())
            } else {
                Err("degrees from 0 to 180")
            }
        });
        let Some(path) = fields.read(reader, "path") else {
            if fields.get("path").is_none() {
                reader.expected(node.at, "the mesh has no path", "path: \"file.obj\"");
            }
            return None;
        };
        Some(Self { path, smooth_angle })
    }

    fn write(&self, writer: &mut Writer) {
        writer.record(None, |writer| {
            writer.field("path", &self.path);
            writer.field_if("smooth_angle", self.smooth_angle.as_ref());
        });
    }
}
