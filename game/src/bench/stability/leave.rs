//! Rays that leave a surface must not meet it: the test `Reintersect` of pbrt, of every kind of shape.
//!
//! Convex shapes under random affine maps (scales from 1e-3 to 1e3, sheared, mirrored) at up to 1e6 from the eye,
//! though no smaller than about 1e-4 of that distance. A ray arrives from nearby; another leaves from where it
//! arrived, to the side it came from, half of them grazing; planes are left to both sides. Meeting the same
//! instance again, another triangle of it too, is a failure.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use orrery_engine::frame::{FrameScene, Kernels, Offset, Shape};
use orrery_engine::trace::{Hit, Query, Ray};
use orrery_engine::world::Cone;

use super::course::{Course, ready, scene_of};
use super::draw::Draw;
use super::solids::Solid;
use super::stream::Stream;
use super::tally::{Tally, Verdict};
use crate::failure::Failure;

/// The suite.
pub const NAME: &str = "leave";
/// Pairs of rays of all shapes together.
const RAYS: u64 = 1_800_000;
/// Pairs of a form that must fail, a shape.
const BROKEN: u64 = 50_000;
/// Instances of a scene.
const INSTANCES: u64 = 1000;
/// Scenes of a shape.
const SCENES: u64 = 4;
/// The flattest angle of leaving, as a power of ten: what f32 frames can still tell from none.
const FLATTEST: f64 = -5.0;

/// Radii of the torus.
const MAJOR: f64 = 0.75;
const MINOR: f64 = 0.25;

/// Kinds of surfaces.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Sphere,
    Ellipsoid,
    Cuboid,
    Plane,
    Disc,
    Cylinder,
    Cone,
    /// Only its outer half is on its convex hull, and is left.
    Torus,
    /// Of [`meshes`].
    Mesh(usize),
}

const KINDS: [(&str, Kind); 10] = [
    ("spheres", Kind::Sphere),
    ("ellipsoids", Kind::Ellipsoid),
    ("cuboids", Kind::Cuboid),
    ("planes", Kind::Plane),
    ("discs", Kind::Disc),
    ("cylinders", Kind::Cylinder),
    ("cones", Kind::Cone),
    ("tori", Kind::Torus),
    ("icospheres", Kind::Mesh(0)),
    ("fans", Kind::Mesh(1)),
];

/// Convex meshes.
fn meshes() -> [Solid; 2] {
    let [_, fan, _] = Solid::all();
    [Solid::icosphere(3), fan]
}

/// Instances of a kind, and what is known of them.
struct Crowd {
    kind: Kind,
    scene: FrameScene,
    solids: [Solid; 2],
    /// Which scene of the kind.
    number: u64,
}

/// Runs every shape.
pub fn run(course: &mut Course) -> Result<(), Failure> {
    let each = KINDS.len() as u64 * SCENES;
    let rays = course.rays(RAYS).div_ceil(each);
    let broken = course.brief(BROKEN);
    let fixed = Kernels {
        offsets: Offset::Fixed,
        ..Kernels::default()
    };
    for (word, kind) in KINDS {
        let name = format!("{NAME}.{word}");
        let mut all = Tally::default();
        for number in 0..SCENES {
            let crowd = Crowd::new(kind, number)?;
            if number == 0 {
                course.upload(&crowd.scene, fixed)?;
                let tally = crowd.leave(course, &name, broken)?;
                course.must_fail(&format!("{name}.fixed"), &tally, None);
            }
            course.upload(&crowd.scene, Kernels::default())?;
            all = all.with(crowd.leave(course, &name, rays)?);
        }
        course.none_may_fail(&name, &all);
    }
    Ok(())
}

impl Crowd {
    fn new(kind: Kind, number: u64) -> Result<Self, Failure> {
        let half = DVec3::splat(0.5);
        let shape = match kind {
            Kind::Sphere | Kind::Ellipsoid => Shape::Sphere { radius: 1.0 },
            Kind::Cuboid => Shape::Cuboid {
                min: -half,
                max: half,
            },
            Kind::Plane => Shape::Plane {
                normal: DVec3::Y,
                distance: 0.0,
            },
            Kind::Disc => Shape::Disc {
                center: DVec3::ZERO,
                normal: DVec3::Y,
                radius: 1.0,
            },
            Kind::Cylinder | Kind::Cone => Shape::Cone(Cone {
                a: DVec3::NEG_Y,
                radius_a: 1.0,
                b: DVec3::Y,
                radius_b: upper_radius(kind),
                open: false,
            }),
            Kind::Torus => Shape::Torus {
                major: MAJOR,
                minor: MINOR,
            },
            Kind::Mesh(row) => Shape::Mesh(row as u32),
        };
        let count = match kind {
            // They have no boxes: every ray meets every plane.
            Kind::Plane => 12,
            _ => INSTANCES,
        };
        let place = |i| (shape, placed(kind, &mut Draw::of(400 + number, i)));
        let mut scene = scene_of((0..count).map(place));
        let solids = meshes();
        let rows: Result<Vec<_>, _> = solids.iter().map(|s| s.mesh().map(Into::into)).collect();
        scene.meshes = rows.map_err(Failure::Input)?.into();
        Ok(Self {
            kind,
            scene: ready(scene),
            solids,
            number,
        })
    }

    fn leave(&self, course: &mut Course, name: &str, count: u64) -> Result<Tally, Failure> {
        let stream = Stream {
            label: name,
            count,
            query: Query::Leave,
            make: |index, rays: &mut [Ray]| self.pair(index, rays),
            judge: |index, _: &[Ray], hits: &[Hit]| {
                if hits[0].instance != self.draw(index).1 {
                    // Something else was in the way.
                    return Verdict::Void;
                }
                Verdict::of(hits[1].instance != hits[0].instance)
            },
        };
        stream.run(course.tracer.as_mut())
    }

    /// The numbers of a pair, and the instance it is for.
    fn draw(&self, index: u64) -> (Draw, u32) {
        let mut draw = Draw::of(500 + self.number, index);
        let instance = draw.below(self.scene.instances.len()) as u32;
        (draw, instance)
    }

    fn pair(&self, index: u64, rays: &mut [Ray]) {
        let (mut draw, instance) = self.draw(index);
        let map = self.scene.instances[instance as usize].world_from_local;
        let (local, local_normal) = self.point(&mut draw);
        let point = map.transform_point3(local);
        let normal = (map.matrix3.inverse().transpose() * local_normal).normalize();
        let size = map.matrix3.x_axis.length();
        let aside = draw.direction();
        let towards =
            (aside - normal * aside.dot(normal).min(0.0) * 2.0 + normal * 0.05).normalize();
        let origin = (point + towards * size * draw.power(-2.0, 0.3)).as_vec3();
        rays[0].origin = origin;
        rays[0].dir = (point - origin.as_dvec3()).as_vec3();
        let steep = draw.unit();
        let up = match draw.below(2) {
            0 => draw.power(FLATTEST, -1.0),
            _ => steep,
        };
        let side = match self.kind {
            Kind::Plane | Kind::Disc if draw.below(2) == 0 => -1.0,
            _ => 1.0,
        };
        let (sin, cos) = draw.range(0.0, std::f64::consts::TAU).sin_cos();
        let across = (1.0 - up * up).max(0.0).sqrt();
        rays[1].dir = DVec3::new(across * cos, across * sin, up * side).as_vec3();
    }

    /// A point of the shape and the normal there, in its own space.
    fn point(&self, draw: &mut Draw) -> (DVec3, DVec3) {
        match self.kind {
            Kind::Sphere | Kind::Ellipsoid => {
                let normal = draw.direction();
                (normal, normal)
            }
            Kind::Cuboid => {
                let mut point = draw.cube() * 0.5;
                let axis = draw.below(3);
                let side = [-0.5, 0.5][draw.below(2)];
                point[axis] = side;
                (point, DVec3::AXES[axis] * side * 2.0)
            }
            Kind::Plane => {
                let point = draw.cube() * 2.0;
                (DVec3::new(point.x, 0.0, point.z), DVec3::Y)
            }
            Kind::Disc => {
                let point = on_circle(draw) * draw.unit().sqrt();
                (point, DVec3::Y)
            }
            Kind::Cylinder | Kind::Cone => on_cone(upper_radius(self.kind), draw),
            Kind::Torus => {
                let (out, (sin, cos)) = (on_circle(draw), draw.range(-1.5, 1.5).sin_cos());
                let normal = out * cos + DVec3::Y * sin;
                (out * MAJOR + normal * MINOR, normal)
            }
            Kind::Mesh(row) => {
                let solid = &self.solids[row];
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

fn upper_radius(kind: Kind) -> f64 {
    if kind == Kind::Cone { 0.2 } else { 1.0 }
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

/// A random affine map; a similarity for spheres.
fn placed(kind: Kind, draw: &mut Draw) -> DAffine3 {
    let distance = draw.power(-2.0, 6.0);
    let smallest = (distance.log10() - 3.5).max(-3.0);
    let size = draw.power(smallest, 3.0);
    let turn = DMat3::from_quat(DQuat::from_axis_angle(
        draw.direction(),
        draw.range(0.0, 6.3),
    ));
    let mirror = [-1.0, 1.0][draw.below(2)];
    let mut axis = || draw.power(-0.5, 0.5);
    let scale = DVec3::new(axis() * mirror, axis(), axis());
    let shear = DMat3::from_cols(
        DVec3::X,
        DVec3::new(draw.range(-0.5, 0.5), 1.0, 0.0),
        DVec3::new(draw.range(-0.5, 0.5), draw.range(-0.5, 0.5), 1.0),
    );
    let matrix = match kind {
        Kind::Sphere => turn * (size * mirror),
        _ => turn * shear * DMat3::from_diagonal(scale * size),
    };
    DAffine3::from_mat3_translation(matrix, draw.direction() * distance)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_lie_on_convex_shapes_with_outward_normals() {
        for (word, kind) in KINDS {
            let crowd = Crowd::new(kind, 0).unwrap();
            for index in 0..500 {
                let (point, normal) = crowd.point(&mut Draw::of(1, index));
                assert!((normal.length() - 1.0).abs() < 1e-9, "{word}");
                assert!(normal.dot(point) > -1e-12, "{word}: {point} {normal}");
            }
        }
    }
}
