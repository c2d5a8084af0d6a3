//! Where an entity is: translation, rotation, scale, an extra matrix; or an eye and what it looks at.

use glam::{DAffine3, DMat3, DQuat, DVec3, EulerRot};

use super::primitive::{Scale, numbers, write_numbers};
use super::{from_degrees, range, to_degrees};
use crate::scene::reader::{Reader, Schema};
use crate::scene::syntax::{Kind, Node};
use crate::scene::writer::Writer;
use crate::world::{Shear, Transform};

/// The `transform` of an entity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Translation, rotation and scale.
    pub transform: Transform,
    /// The `matrix`, applied before all of them.
    pub shear: Option<Shear>,
}

/// A rotation as it may be written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rotation {
    /// Degrees about x, then y, then z, each about the parent's axis. Keys of it interpolate angle by
    /// angle, so 0 to 360 is a full turn.
    Euler(DVec3),
    /// Any other way to write it.
    Quat(DQuat),
}

impl Rotation {
    /// The rotation as a unit quaternion.
    pub fn quat(self) -> DQuat {
        match self {
            Self::Euler(degrees) => {
                let [x, y, z] = degrees.to_array().map(from_degrees);
                DQuat::from_euler(EulerRot::ZYX, z, y, x)
            }
            Self::Quat(quat) => quat,
        }
    }

    /// Euler angles if a round triple of them is exactly this rotation, else the quaternion.
    pub fn of(quat: DQuat) -> Self {
        let (z, y, x) = quat.to_euler(EulerRot::ZYX);
        let degrees = DVec3::from_array([x, y, z].map(to_degrees));
        let euler = Self::Euler((degrees * 1e6).round() / 1e6);
        let bits = |q: DQuat| q.to_array().map(f64::to_bits);
        if degrees.is_finite() && bits(euler.quat()) == bits(quat) {
            euler
        } else {
            Self::Quat(quat)
        }
    }
}

impl Schema for Rotation {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        let expected =
            "`Euler(x, y, z)` in degrees, `Axis((x, y, z), degrees)` or `Quat(x, y, z, w)`";
        let Kind::Tuple(Some(name), items) = &node.kind else {
            return reader.mismatch(node, expected);
        };
        let tuple = Node {
            at: node.at,
            kind: Kind::Tuple(None, items.clone()),
        };
        match (*name, items.as_slice()) {
            ("Euler", _) => numbers(reader, &tuple, "three angles in degrees: `Euler(x, y, z)`")
                .map(|degrees| Self::Euler(DVec3::from_array(degrees))),
            ("Axis", [axis, degrees]) => {
                let (axis_at, axis) = (axis.at, DVec3::read(reader, axis));
                let degrees = f64::read(reader, degrees)?;
                let Some(axis) = axis?.try_normalize() else {
                    reader.expected(
                        axis_at,
                        "found an axis without a direction",
                        "not all three numbers 0",
                    );
                    return None;
                };
                Some(Self::Quat(
                    DQuat::from_axis_angle(axis, from_degrees(degrees)).normalize(),
                ))
            }
            ("Quat", _) => {
                let parts = numbers(reader, &tuple, "four numbers: `Quat(x, y, z, w)`")?;
                let quat = DQuat::from_array(parts);
                let length = quat.length();
                if !(length > 0.0 && length.is_finite()) {
                    reader.expected(
                        node.at,
                        "found a quaternion without a length",
                        "not all four numbers 0",
                    );
                    return None;
                }
                // What was saved is a unit up to rounding and comes back bit for bit.
                Some(Self::Quat(if (length - 1.0).abs() < 1e-6 {
                    quat
                } else {
                    quat / length
                }))
            }
            ("Axis", _) => reader.mismatch(node, "`Axis((x, y, z), degrees)`"),
            _ => {
                reader.unknown(node.at, "rotation", name, ["Euler", "Axis", "Quat"]);
                None
            }
        }
    }

    fn write(&self, writer: &mut Writer) {
        match self {
            Self::Euler(degrees) => write_numbers(writer, Some("Euler"), &degrees.to_array()),
            Self::Quat(quat) => write_numbers(writer, Some("Quat"), &quat.to_array()),
        }
    }
}

const NAMES: [&str; 7] = [
    "translation",
    "rotation",
    "scale",
    "matrix",
    "eye",
    "target",
    "up",
];

impl Schema for Pose {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        let fields = reader.record(node, &NAMES, "a transform")?;
        let translation: Option<DVec3> = fields.read(reader, "translation");
        let rotation: Option<Rotation> = fields.read(reader, "rotation");
        let eye: Option<DVec3> = fields.read(reader, "eye");
        let target: Option<DVec3> = fields.read(reader, "target");
        let up = fields.read_checked(reader, "up", range::direction);
        for (one, other) in [("translation", "eye"), ("rotation", "target")] {
            if let (Some(_), Some(entry)) = (fields.get(one), fields.get(other)) {
                reader.expected(
                    entry.at,
                    format!("found both `{one}` and `{other}`"),
                    "one of the two",
                );
            }
        }
        if let (Some(entry), None) = (fields.get("up"), fields.get("target")) {
            reader.expected(
                entry.at,
                "found `up` without `target`",
                "a target to look at",
            );
        }
        let position = translation.or(eye).unwrap_or_default();
        let mut transform = match target {
            Some(target) => Transform::looking_at(position, target, up.unwrap_or(DVec3::Y)),
            None => Transform::from_translation(position),
        };
        if let Some(rotation) = rotation {
            transform.rotation = rotation.quat();
        }
        if let Some(scale) = fields.read::<Scale>(reader, "scale") {
            transform.scale = scale.0;
        }
        let shear = fields.with(reader, "matrix", read_matrix).map(Shear);
        Some(Self { transform, shear })
    }

    fn write(&self, writer: &mut Writer) {
        let default = Transform::IDENTITY;
        let transform = &self.transform;
        writer.record(None, |writer| {
            writer.field_unless_default(
                "translation",
                &transform.translation,
                &default.translation,
            );
            writer.field_unless_default(
                "rotation",
                &Rotation::of(transform.rotation),
                &Rotation::of(default.rotation),
            );
            writer.field_unless_default("scale", &Scale(transform.scale), &Scale(default.scale));
            if let Some(Shear(matrix)) = self.shear {
                writer.element("matrix: ", |writer| write_matrix(writer, &matrix));
            }
        });
    }
}

/// Three rows of four numbers: p' = L p + t with t in the last column.
fn read_matrix(reader: &mut Reader, node: &Node) -> Option<DAffine3> {
    let expected = "three rows of four numbers: ((a, b, c, x), (d, e, f, y), (g, h, i, z))";
    let Kind::Tuple(None, rows) = &node.kind else {
        return reader.mismatch(node, expected);
    };
    if rows.len() != 3 {
        return reader.mismatch(node, expected);
    }
    let rows: Vec<[f64; 4]> = rows
        .iter()
        .filter_map(|row| numbers(reader, row, "a row of four numbers"))
        .collect();
    let [a, b, c] = rows.try_into().ok()?;
    Some(DAffine3::from_mat3_translation(
        DMat3::from_cols_array(&[a[0], b[0], c[0], a[1], b[1], c[1], a[2], b[2], c[2]]),
        DVec3::new(a[3], b[3], c[3]),
    ))
}

fn write_matrix(writer: &mut Writer, matrix: &DAffine3) {
    let (m, t) = (matrix.matrix3, matrix.translation);
    writer.record(None, |writer| {
        for row in 0..3 {
            writer.element("", |writer| {
                write_numbers(
                    writer,
                    None,
                    &[m.x_axis[row], m.y_axis[row], m.z_axis[row], t[row]],
                );
            });
        }
    });
}
