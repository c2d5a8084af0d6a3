//! Surfaces that rays leave: kinds of shapes, random points of them, and random maps that place them.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use orrery_engine::frame::Shape;
use orrery_engine::world::Cone;

use super::draw::Draw;
use super::solids::Solid;

/// Radii of the torus.
const MAJOR: f64 = 0.75;
const MINOR: f64 = 0.25;

/// Kinds of surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Sphere,
    Ellipsoid,
    Cuboid,
    Plane,
    Disc,
    Cylinder,
    Cone,
    /// The outer half of its tube, which is on its convex hull.
    Torus,
    /// The inner half, which faces the axis: rays that leave it may well meet it again, but further on.
    Hole,
    /// Of [`meshes`].
    Mesh(usize),
}

/// All, with a word for each.
pub const KINDS: [(&str, Kind); 12] = [
    ("spheres", Kind::Sphere),
    ("ellipsoids", Kind::Ellipsoid),
    ("cuboids", Kind::Cuboid),
    ("planes", Kind::Plane),
    ("discs", Kind::Disc),
    ("cylinders", Kind::Cylinder),
    ("cones", Kind::Cone),
    ("tori", Kind::Torus),
    ("holes", Kind::Hole),
    ("icospheres", Kind::Mesh(0)),
    ("fans", Kind::Mesh(1)),
    ("cubes", Kind::Mesh(2)),
];

/// Convex meshes.
pub fn meshes() -> [Solid; 3] {
    let [_, fan, _] = Solid::all();
    [Solid::icosphere(3), fan, Solid::cube()]
}

impl Kind {
    /// Whether there is an inside.
    pub fn is_solid(self) -> bool {
        !matches!(self, Self::Plane | Self::Disc)
    }

    /// Of cones, and of cylinders, which are cones as well.
    fn upper_radius(self) -> f64 {
        if self == Self::Cone { 0.2 } else { 1.0 }
    }

    /// How often it is left, of how often simple shapes are, so that all take about as long: the equation of a torus is
    /// of the fourth degree, meshes have trees, and the slivers of a fan lie in boxes that overlap.
    pub fn weight(self) -> f64 {
        match self {
            Self::Torus | Self::Hole | Self::Mesh(0 | 2) => 0.5,
            Self::Mesh(_) => 0.1,
            _ => 1.0,
        }
    }

    /// The outward normal where a primitive was met, of any length.
    pub fn normal(self, solids: &[Solid; 3], prim: u32, at: DVec3) -> DVec3 {
        let side = if prim.is_multiple_of(2) { -1.0 } else { 1.0 };
        let out = at.with_y(0.0).normalize();
        match self {
            Self::Sphere | Self::Ellipsoid => at,
            Self::Cuboid => DVec3::AXES[prim as usize / 2] * side,
            Self::Plane | Self::Disc => DVec3::Y,
            Self::Cylinder | Self::Cone => match prim {
                0 => out + DVec3::Y * ((1.0 - self.upper_radius()) / 2.0),
                1 => DVec3::NEG_Y,
                _ => DVec3::Y,
            },
            Self::Torus | Self::Hole => at - out * MAJOR,
            Self::Mesh(row) => {
                let [a, b, c] =
                    solids[row].triangles[prim as usize].map(|v| solids[row].points[v as usize]);
                let normal = (b - a).cross(c - a);
                normal * normal.dot(a).signum()
            }
        }
    }

    /// Whether a point of its own space is inside.
    pub fn holds(self, solids: &[Solid; 3], at: DVec3) -> bool {
        let aside = at.x.hypot(at.z);
        match self {
            Self::Sphere | Self::Ellipsoid => at.length() < 1.0,
            Self::Cuboid => at.abs().max_element() < 0.5,
            Self::Plane | Self::Disc => false,
            Self::Cylinder | Self::Cone => {
                let upper = self.upper_radius();
                at.y.abs() < 1.0 && aside < 1.0 + (upper - 1.0) * (at.y + 1.0) / 2.0
            }
            Self::Torus | Self::Hole => (aside - MAJOR).hypot(at.y) < MINOR,
            // They are convex around their origin.
            Self::Mesh(row) => solids[row].triangles.iter().all(|triangle| {
                let [a, b, c] = triangle.map(|v| solids[row].points[v as usize]);
                let normal = (b - a).cross(c - a);
                normal.dot(at - a) * normal.dot(a) < 0.0
            }),
        }
    }

    /// The way straight through, from a point of it against the normal there, in its own space; none where that differs
    /// from point to point.
    pub fn thickness(self) -> Option<f64> {
        match self {
            Self::Sphere | Self::Cylinder => Some(2.0),
            Self::Cuboid | Self::Mesh(2) => Some(1.0),
            Self::Torus | Self::Hole => Some(2.0 * MINOR),
            Self::Ellipsoid | Self::Plane | Self::Disc | Self::Cone | Self::Mesh(_) => None,
        }
    }

    /// It, in its own space.
    pub fn shape(self) -> Shape {
        let half = DVec3::splat(0.5);
        match self {
            Self::Sphere | Self::Ellipsoid => Shape::Sphere { radius: 1.0 },
            Self::Cuboid => Shape::Cuboid {
                min: -half,
                max: half,
            },
            Self::Plane => Shape::Plane {
                normal: DVec3::Y,
                distance: 0.0,
            },
            Self::Disc => Shape::Disc {
                center: DVec3::ZERO,
                normal: DVec3::Y,
                radius: 1.0,
            },
            Self::Cylinder | Self::Cone => Shape::Cone(Cone {
                a: DVec3::NEG_Y,
                radius_a: 1.0,
                b: DVec3::Y,
                radius_b: self.upper_radius(),
                open: false,
            }),
            Self::Torus | Self::Hole => Shape::Torus {
                major: MAJOR,
                minor: MINOR,
            },
            Self::Mesh(row) => Shape::Mesh(row as u32),
        }
    }

    /// A point of the shape and the normal there, in its own space.
    pub fn point(self, solids: &[Solid; 3], draw: &mut Draw) -> (DVec3, DVec3) {
        match self {
            Self::Sphere | Self::Ellipsoid => {
                let normal = draw.direction();
                (normal, normal)
            }
            Self::Cuboid => {
                let mut point = draw.cube() * 0.5;
                let axis = draw.below(3);
                let side = [-0.5, 0.5][draw.below(2)];
                point[axis] = side;
                (point, DVec3::AXES[axis] * side * 2.0)
            }
            Self::Plane => {
                let point = draw.cube() * 2.0;
                (DVec3::new(point.x, 0.0, point.z), DVec3::Y)
            }
            Self::Disc => {
                let point = on_circle(draw) * draw.unit().sqrt();
                (point, DVec3::Y)
            }
            Self::Cylinder | Self::Cone => on_cone(self.upper_radius(), draw),
            Self::Torus | Self::Hole => {
                let (out, (sin, cos)) = (on_circle(draw), draw.range(-1.5, 1.5).sin_cos());
                let cos = if self == Self::Hole { -cos } else { cos };
                let normal = out * cos + DVec3::Y * sin;
                (out * MAJOR + normal * MINOR, normal)
            }
            Self::Mesh(row) => {
                let solid = &solids[row];
                let triangle = solid.triangles[draw.below(solid.triangles.len())];
                let [a, b, c] = triangle.map(|v| solid.points[v as usize]);
                let (mut u, mut v) = (draw.unit(), draw.unit());
                if u + v > 1.0 {
                    (u, v) = (1.0 - u, 1.0 - v);
                }
                let point = a + (b - a) * u + (c - a) * v;
                let normal = (b - a).cross(c - a).normalize();
                (point, if normal.dot(a) < 0.0 { -normal } else { normal })
            }
        }
    }
}

/// A point of the unit circle across Y.
fn on_circle(draw: &mut Draw) -> DVec3 {
    let (sin, cos) = draw.range(0.0, std::f64::consts::TAU).sin_cos();
    DVec3::new(cos, 0.0, sin)
}

/// A point of a cone of height 2 whose lower radius is 1, and its normal.
fn on_cone(upper: f64, draw: &mut Draw) -> (DVec3, DVec3) {
    let out = on_circle(draw);
    match draw.below(4) {
        0 => (DVec3::Y + out * upper * draw.unit().sqrt(), DVec3::Y),
        1 => (DVec3::NEG_Y + out * draw.unit().sqrt(), DVec3::NEG_Y),
        _ => {
            let y = draw.range(-1.0, 1.0);
            let slope = (1.0 - upper) / 2.0;
            let point = out * (1.0 - (y + 1.0) * slope) + DVec3::Y * y;
            (point, (out + DVec3::Y * slope).normalize())
        }
    }
}

/// A random affine map; one that keeps angles where `kind` needs them.
pub fn placed(kind: Kind, draw: &mut Draw) -> DAffine3 {
    let distance = draw.power(-2.0, 6.0);
    let smallest = (distance.log10() - 3.5).max(-3.0);
    let size = draw.power(smallest, 3.0);
    if matches!(kind, Kind::Sphere | Kind::Hole) {
        return similar(draw, distance, size);
    }
    let mut axis = || draw.power(-0.5, 0.5);
    let scale = DMat3::from_diagonal(DVec3::new(axis(), axis(), axis()));
    let shear = DMat3::from_cols(
        DVec3::X,
        DVec3::new(draw.range(-0.5, 0.5), 1.0, 0.0),
        DVec3::new(draw.range(-0.5, 0.5), draw.range(-0.5, 0.5), 1.0),
    );
    similar(draw, distance, size) * DAffine3::from_mat3(shear * scale)
}

/// A random turn, or a mirrored one, times `size`, so far off.
pub fn similar(draw: &mut Draw, distance: f64, size: f64) -> DAffine3 {
    let turn = DQuat::from_axis_angle(draw.direction(), draw.range(0.0, 6.3));
    let mirror = [-1.0, 1.0][draw.below(2)];
    let matrix = DMat3::from_quat(turn) * (size * mirror);
    DAffine3::from_mat3_translation(matrix, draw.direction() * distance)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_lie_on_their_surfaces_with_outward_normals() {
        let solids = meshes();
        for (word, kind) in KINDS {
            for index in 0..500 {
                let (point, normal) = kind.point(&solids, &mut Draw::of(1, index));
                assert!((normal.length() - 1.0).abs() < 1e-9, "{word}");
                let outwards = normal.dot(point);
                let is_outward = if kind == Kind::Hole {
                    point.with_y(0.0).length() < MAJOR && outwards < MINOR
                } else {
                    outwards > -1e-12
                };
                assert!(is_outward, "{word}: {point} {normal}");
            }
        }
    }

    #[test]
    fn solids_hold_what_is_under_their_surface() {
        let solids = meshes();
        for (word, kind) in KINDS.into_iter().filter(|(_, kind)| kind.is_solid()) {
            for index in 0..200 {
                let (point, normal) = kind.point(&solids, &mut Draw::of(3, index));
                assert!(!kind.holds(&solids, point + normal * 1e-9), "{word}");
                let through = kind.thickness().unwrap_or(1e-8);
                let [top, bottom] = [1e-9, through - 1e-9].map(|depth| point - normal * depth);
                let both = kind.holds(&solids, top) && kind.holds(&solids, bottom);
                assert!(both, "{word}: {point} {normal}");
                let beyond = point - normal * (through + 1e-9);
                assert!(kind.thickness().is_none() || !kind.holds(&solids, beyond));
            }
        }
    }

    #[test]
    fn maps_of_spheres_and_holes_keep_angles() {
        for kind in [Kind::Sphere, Kind::Hole] {
            for index in 0..20 {
                let matrix = placed(kind, &mut Draw::of(2, index)).matrix3;
                let size = matrix.x_axis.length();
                let gram = matrix.transpose() * matrix;
                let square = DMat3::from_diagonal(DVec3::splat(size * size));
                assert!(gram.abs_diff_eq(square, 1e-9 * size * size));
            }
        }
    }
}
