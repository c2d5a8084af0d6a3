//! Shapes: the solids by their numbers, polygon, mesh file.

use glam::DVec3;

use super::primitive::At;
use super::range;
use crate::scene::reader::{Fields, Reader, Schema, record};
use crate::scene::syntax::Node;
use crate::scene::writer::Writer;
use crate::world::{
    Cone, Cuboid, Cylinder, Disc, Plane, Polygon, Sphere, Torus, newell_normal, triangulate,
};

/// The one shape an entity has. In the file the key says which: `sphere: (radius: 2)`.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// `sphere`
    Sphere(Sphere),
    /// `plane`
    Plane(Plane),
    /// `box`
    Box(Cuboid),
    /// `disc`
    Disc(Disc),
    /// `cylinder`
    Cylinder(Cylinder),
    /// `cone`
    Cone(Cone),
    /// `torus`
    Torus(Torus),
    /// `polygon`
    Polygon(Polygon),
    /// `mesh`
    Mesh(MeshFile),
}

impl Shape {
    /// All names there are.
    pub const NAMES: [&str; 9] = [
        "sphere", "plane", "box", "disc", "cylinder", "cone", "torus", "polygon", "mesh",
    ];

    /// The key it has in the file.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Sphere(_) => "sphere",
            Self::Plane(_) => "plane",
            Self::Box(_) => "box",
            Self::Disc(_) => "disc",
            Self::Cylinder(_) => "cylinder",
            Self::Cone(_) => "cone",
            Self::Torus(_) => "torus",
            Self::Polygon(_) => "polygon",
            Self::Mesh(_) => "mesh",
        }
    }

    /// The first shape among the fields of an entity. Every shape is read, so that the problems of each are seen.
    pub fn read_first(reader: &mut Reader, fields: &Fields) -> Option<Self> {
        let shapes = [
            fields.read(reader, "sphere").map(Self::Sphere),
            fields.read(reader, "plane").map(Self::Plane),
            fields.read(reader, "box").map(Self::Box),
            fields.read(reader, "disc").map(Self::Disc),
            fields.read(reader, "cylinder").map(Self::Cylinder),
            fields.read(reader, "cone").map(Self::Cone),
            fields.read(reader, "torus").map(Self::Torus),
            fields.read(reader, "polygon").map(Self::Polygon),
            fields.read(reader, "mesh").map(Self::Mesh),
        ];
        shapes.into_iter().flatten().next()
    }

    /// Writes it under its name.
    pub fn write_field(&self, writer: &mut Writer) {
        let name = self.name();
        match self {
            Self::Sphere(shape) => writer.field(name, shape),
            Self::Plane(shape) => writer.field(name, shape),
            Self::Box(shape) => writer.field(name, shape),
            Self::Disc(shape) => writer.field(name, shape),
            Self::Cylinder(shape) => writer.field(name, shape),
            Self::Cone(shape) => writer.field(name, shape),
            Self::Torus(shape) => writer.field(name, shape),
            Self::Polygon(shape) => writer.field(name, shape),
            Self::Mesh(shape) => writer.field(name, shape),
        }
    }
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

record!("a disc", Disc {
    "center" => center: DVec3;
    "normal" => normal: DVec3, range::direction;
    "radius" => radius: f64, range::positive;
});

record!("a cylinder", Cylinder {
    "a" => a: DVec3;
    "b" => b: DVec3;
    "radius" => radius: f64, range::positive;
    "open" => open: bool;
}, is_a_cylinder);

record!("a cone", Cone {
    "a" => a: DVec3;
    "radius_a" => radius_a: f64, range::radius;
    "b" => b: DVec3;
    "radius_b" => radius_b: f64, range::radius;
    "open" => open: bool;
}, is_a_cone);

record!("a torus", Torus {
    "major" => major: f64, range::positive;
    "minor" => minor: f64, range::positive;
}, is_a_torus);

fn is_a_cylinder(reader: &mut Reader, fields: &Fields, cylinder: &Cylinder) -> Option<()> {
    ends_differ(reader, fields, cylinder.a, cylinder.b)
}

fn is_a_cone(reader: &mut Reader, fields: &Fields, cone: &Cone) -> Option<()> {
    if cone.radius_a.max(cone.radius_b) <= 0.0 {
        let what = "found both radii 0";
        let expected = "`radius_a` or `radius_b` greater than 0";
        return wrong_as_a_whole(reader, fields, ["radius_b", "radius_a"], what, expected);
    }
    ends_differ(reader, fields, cone.a, cone.b)
}

fn ends_differ(reader: &mut Reader, fields: &Fields, a: DVec3, b: DVec3) -> Option<()> {
    if a != b {
        return Some(());
    }
    let what = format!("found a and b both at {}", Writer::text_of(&a));
    wrong_as_a_whole(reader, fields, ["b", "a"], &what, "two different points")
}

fn is_a_torus(reader: &mut Reader, fields: &Fields, torus: &Torus) -> Option<()> {
    if torus.minor < torus.major {
        return Some(());
    }
    let Torus { major, minor } = torus;
    let what = format!("found minor {minor} for major {major}");
    let expected = "minor less than major, so that the ring does not meet itself";
    wrong_as_a_whole(reader, fields, ["minor", "major"], &what, expected)
}

/// Reports what two fields say together, at the first of them that was written.
fn wrong_as_a_whole(
    reader: &mut Reader,
    fields: &Fields,
    names: [&str; 2],
    what: &str,
    expected: &str,
) -> Option<()> {
    let mut written = names.into_iter().filter_map(|name| {
        let entry = fields.get(name)?;
        Some((format!(".{name}"), entry.value.at))
    });
    let (step, at) = written.next().unwrap_or((String::new(), fields.at));
    reader.within(&step, |reader| reader.expected(at, what, expected));
    None
}

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
