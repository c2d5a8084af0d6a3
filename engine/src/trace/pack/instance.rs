//! A shape in the world as a row: what depends on its pose alone, and what the eye adds.
//!
//! The two are apart so that a camera that moves costs one pass over the rows ([`Placed::place`]) and
//! gives the same bits as packing them anew.

use glam::{DAffine3, DMat3, DVec3, Vec3};

use super::mesh::PackedMesh;
use crate::frame::wire::{
    CONE_OPEN, InstanceRow, KIND_CONE, KIND_CUBOID, KIND_DISC, KIND_ELLIPSOID, KIND_MESH,
    KIND_PLANE, KIND_SPHERE, KIND_TORUS, NONE,
};
use crate::frame::{Instance, Shape};
use crate::geom::{Aabb, AffineRows, PlaneFrame, SphereFrame};
use crate::world::Cone;

/// Most unit shapes fit into it.
const UNIT_BOX: Aabb = Aabb {
    min: Vec3::NEG_ONE,
    max: Vec3::ONE,
};

/// A row that draws nothing.
pub const VACANT: InstanceRow = InstanceRow {
    local_from_world: AffineRows::ZERO,
    world_from_local: AffineRows::ZERO,
    kind: NONE,
    material: 0,
    root: 0,
    first_triangle: 0,
    parameter: 0.0,
    mesh: NONE,
    link: NONE,
    first_normal: NONE,
};

/// What is needed to place a row relative to another eye, in f64.
///
/// The instance's position and what lies between it and the row's origin are apart: only the former is
/// large far from the world's origin, and it is exact once the eye is subtracted.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    /// The instance's position in the world.
    at: DVec3,
    /// From there to the origin of the row's local space; of planes, to a point on it.
    offset: DVec3,
    /// The linear part of local_from_world; of planes, the unit normal as first column; of
    /// spheres, the radius as first number.
    inverse: DMat3,
}

/// How far a row reaches about its [`Placed`] position.
#[derive(Clone, Copy, Debug)]
pub struct PaddedBox {
    low: DVec3,
    high: DVec3,
    /// Roundings the intersector makes, in ulps of the largest coordinate; negative: in no tree.
    pad: f64,
}

/// A row but for what the eye adds, where it is and how far it reaches.
pub type Packed = (InstanceRow, Placed, PaddedBox);

/// What draws nothing.
pub const NOTHING: Packed = (VACANT, Placed::NOWHERE, PaddedBox::NONE);

impl Placed {
    const NOWHERE: Self = Self {
        at: DVec3::ZERO,
        offset: DVec3::ZERO,
        inverse: DMat3::ZERO,
    };

    /// Writes what of the row depends on the eye: positions are subtracted in f64, then rounded.
    pub fn place(&self, row: &mut InstanceRow, eye: DVec3) {
        let at = (self.at - eye) + self.offset;
        match row.kind {
            KIND_SPHERE => {
                let sphere = SphereFrame::new(at, self.inverse.x_axis.x);
                row.local_from_world = AffineRows(sphere.rows());
            }
            KIND_PLANE => {
                let normal = self.inverse.x_axis;
                let distance = normal.dot(at);
                let plane = PlaneFrame { normal, distance };
                row.local_from_world = AffineRows(plane.rows());
            }
            NONE => {}
            _ => {
                row.world_from_local.set_translation(at);
                row.local_from_world.set_translation(-(self.inverse * at));
            }
        }
    }

    /// How far it is from a point, along the axis where it is farthest.
    pub fn distance(&self, point: DVec3) -> f64 {
        ((self.at - point) + self.offset).abs().max_element()
    }
}

impl PaddedBox {
    /// Of what is in no tree.
    pub const NONE: Self = Self {
        low: DVec3::ZERO,
        high: DVec3::ZERO,
        pad: -1.0,
    };

    /// Whether there is a box at all.
    pub fn is_bounded(&self) -> bool {
        self.pad >= 0.0
    }

    /// The box about an anchor that no ray may leave out as long as the eye is within `reach` of it;
    /// empty for what is in no tree, or out of range.
    pub fn bounds(&self, placed: &Placed, anchor: DVec3, reach: f64) -> Aabb {
        if !self.is_bounded() {
            return Aabb::EMPTY;
        }
        let at = (placed.at - anchor) + placed.offset;
        let (low, high) = (at + self.low, at + self.high);
        let largest = low.abs().max(high.abs()).max_element() + reach;
        let pad = largest * f64::from(f32::EPSILON) * self.pad;
        let (min, max) = ((low - pad).as_vec3(), (high + pad).as_vec3());
        if min.is_finite() && max.is_finite() {
            Aabb { min, max }
        } else {
            Aabb::EMPTY
        }
    }
}

/// The row of an instance but for [`Placed::place`]. One that draws nothing is vacant.
pub fn instance_row<'a>(instance: &Instance, mesh: impl FnOnce(u32) -> &'a PackedMesh) -> Packed {
    let world = &instance.world_from_local;
    let unit = instance.shape.local_from_unit();
    let (mut row, placed, padded) = match instance.shape {
        Shape::Vacant => return NOTHING,
        Shape::Mesh(id) => mesh_row(world, id, mesh(id)),
        Shape::Sphere { radius } => sphere_row(world, radius, &unit),
        Shape::Cuboid { .. } => affine_row(KIND_CUBOID, world, &unit, UNIT_BOX),
        Shape::Plane { normal, distance } => plane_row(world, normal, distance),
        Shape::Disc { .. } => {
            let flat = Vec3::new(1.0, 0.0, 1.0);
            let bounds = Aabb {
                min: -flat,
                max: flat,
            };
            affine_row(KIND_DISC, world, &unit, bounds)
        }
        Shape::Cone(Cone {
            radius_a,
            radius_b,
            open,
            ..
        }) => {
            let taper = (radius_b - radius_a) / radius_a.max(radius_b) * 0.5;
            let mut packed = affine_row(KIND_CONE, world, &unit, UNIT_BOX);
            packed.0.root = if open { CONE_OPEN } else { 0 };
            with_parameter(packed, taper)
        }
        Shape::Torus { major, minor } => {
            let parameter = minor / major;
            let reach = Vec3::new(1.0, 0.0, 1.0) + Vec3::splat(parameter as f32);
            let bounds = Aabb {
                min: -reach,
                max: reach,
            };
            with_parameter(affine_row(KIND_TORUS, world, &unit, bounds), parameter)
        }
    };
    row.material = instance.material;
    // Extraction keeps such things out; a scene made by hand may still hold one.
    let center = placed.at + placed.offset;
    let is_finite = (center + padded.low).is_finite() && (center + padded.high).is_finite();
    if is_finite && instance.shape.is_in_range(world) {
        (row, placed, padded)
    } else {
        let mesh = row.mesh;
        (InstanceRow { mesh, ..VACANT }, NOTHING.1, NOTHING.2)
    }
}

fn with_parameter((mut row, placed, padded): Packed, parameter: f64) -> Packed {
    row.parameter = parameter as f32;
    (row, placed, padded)
}

/// A shape that is tested in a local space of its own.
fn affine_row(kind: u32, world: &DAffine3, local_from_unit: &DAffine3, local: Aabb) -> Packed {
    let m = world.matrix3 * local_from_unit.matrix3;
    let inverse = m.inverse();
    let row = InstanceRow {
        kind,
        world_from_local: AffineRows::new(DAffine3::from_mat3(m)),
        local_from_world: AffineRows::new(DAffine3::from_mat3(inverse)),
        ..VACANT
    };
    let (min, max) = (local.min.as_dvec3(), local.max.as_dvec3());
    let (center, half) = ((min + max) * 0.5, (max - min) * 0.5);
    let reach = m.abs() * half;
    let center = m * center;
    // The intersector's f32 transform errs by a few roundings of |M^-1| (|M| |p|), hence the condition.
    let condition = frobenius(&m) * frobenius(&inverse);
    let placed = Placed {
        at: world.translation,
        offset: world.matrix3 * local_from_unit.translation,
        inverse,
    };
    let padded = PaddedBox {
        low: center - reach,
        high: center + reach,
        pad: 2.0 * condition,
    };
    (row, placed, padded)
}

fn mesh_row(world: &DAffine3, id: u32, mesh: &PackedMesh) -> Packed {
    if mesh.nodes().is_empty() {
        // It still names the mesh, which may get triangles.
        return (InstanceRow { mesh: id, ..VACANT }, NOTHING.1, NOTHING.2);
    }
    let recentre = DAffine3::from_translation(mesh.source.data.origin);
    let (mut row, placed, padded) = affine_row(KIND_MESH, world, &recentre, mesh.bounds);
    row.root = mesh.place.nodes.start | mesh.root_flag();
    row.first_triangle = mesh.place.triangles.start;
    row.first_normal = mesh.first_normal();
    row.link = mesh.first_look();
    row.parameter = if mesh.source.data.curved { 1.0 } else { 0.0 };
    row.mesh = id;
    (row, placed, padded)
}

/// A sphere stays one in render space unless its transform squeezes it.
fn sphere_row(world: &DAffine3, radius: f64, unit: &DAffine3) -> Packed {
    let Some(scale) = uniform_scale(&world.matrix3) else {
        return affine_row(KIND_ELLIPSOID, world, unit, UNIT_BOX);
    };
    let radius = radius * scale;
    let row = InstanceRow {
        kind: KIND_SPHERE,
        ..VACANT
    };
    let half = DVec3::splat(radius);
    let placed = Placed {
        at: world.translation,
        inverse: DMat3::from_cols(DVec3::X * radius, DVec3::ZERO, DVec3::ZERO),
        ..Placed::NOWHERE
    };
    let padded = PaddedBox {
        low: -half,
        high: half,
        pad: 4.0,
    };
    (row, placed, padded)
}

/// Planes have no box and are in no tree.
fn plane_row(world: &DAffine3, normal: DVec3, distance: f64) -> Packed {
    let row = InstanceRow {
        kind: KIND_PLANE,
        ..VACANT
    };
    let n = (world.matrix3.inverse().transpose() * normal).normalize();
    let placed = Placed {
        at: world.translation,
        offset: world.matrix3 * (normal * (distance / normal.length_squared())),
        inverse: DMat3::from_cols(n, DVec3::ZERO, DVec3::ZERO),
    };
    (row, placed, PaddedBox::NONE)
}

/// The scale of a map that is nothing but scale and rotation, to f64 accuracy.
fn uniform_scale(m: &DMat3) -> Option<f64> {
    let scale = m.x_axis.length();
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * scale;
    let uniform = close(m.y_axis.length(), scale)
        && close(m.z_axis.length(), scale)
        && close(m.x_axis.dot(m.y_axis) / scale, 0.0)
        && close(m.y_axis.dot(m.z_axis) / scale, 0.0)
        && close(m.z_axis.dot(m.x_axis) / scale, 0.0);
    uniform.then_some(scale)
}

fn frobenius(m: &DMat3) -> f64 {
    (m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared()).sqrt()
}
