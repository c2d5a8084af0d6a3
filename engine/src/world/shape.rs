//! What can be hit. An entity has at most one of these; its material is named by [`Surface`].
//!
//! All are in the entity's local space and two-sided. A sphere under a general transform is an ellipsoid.

use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use bevy_reflect::prelude::*;
use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::{MeshId, Meshes, Transform, Visibility};

/// The material of a shape: an entity that carries a [`super::Material`].
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, Clone, PartialEq)]
#[component(summary_tick)]
pub struct Surface(pub Entity);

/// A triangle mesh out of [`super::Meshes`].
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, Clone, PartialEq)]
#[require(Transform, Visibility)]
#[component(summary_tick)]
pub struct Mesh(pub MeshId);

/// A sphere about the local origin.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Transform, Visibility)]
#[component(summary_tick)]
pub struct Sphere {
    /// Local units, > 0.
    pub radius: f64,
}

impl Default for Sphere {
    fn default() -> Self {
        Self { radius: 1.0 }
    }
}

/// The infinite plane n.p = distance.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Transform, Visibility)]
#[component(summary_tick)]
pub struct Plane {
    /// Any length but zero.
    pub normal: DVec3,
    /// In units of the normal's length.
    pub distance: f64,
}

impl Default for Plane {
    fn default() -> Self {
        Self {
            normal: DVec3::Y,
            distance: 0.0,
        }
    }
}

/// A box along the local axes (the scene file calls it `Box`; Rust has taken that word).
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Transform, Visibility)]
#[component(summary_tick)]
pub struct Cuboid {
    /// Least corner.
    pub min: DVec3,
    /// Greatest corner; greater than `min` on every axis.
    pub max: DVec3,
}

impl Default for Cuboid {
    fn default() -> Self {
        Self {
            min: DVec3::splat(-0.5),
            max: DVec3::splat(0.5),
        }
    }
}

/// A flat round plate.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Transform, Visibility)]
#[component(summary_tick)]
pub struct Disc {
    /// Its middle.
    pub center: DVec3,
    /// What it lies across; any length but zero.
    pub normal: DVec3,
    /// Local units, > 0.
    pub radius: f64,
}

impl Default for Disc {
    fn default() -> Self {
        Self {
            center: DVec3::ZERO,
            normal: DVec3::Y,
            radius: 1.0,
        }
    }
}

/// A cylinder between two points, closed with flat caps or open: a tube.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Transform, Visibility)]
#[component(summary_tick)]
pub struct Cylinder {
    /// Middle of one cap.
    pub a: DVec3,
    /// Middle of the other; elsewhere than `a`.
    pub b: DVec3,
    /// Local units, > 0.
    pub radius: f64,
    /// Without caps: the side alone, seen from within as well.
    pub open: bool,
}

impl Default for Cylinder {
    fn default() -> Self {
        Self {
            a: DVec3::ZERO,
            b: DVec3::Y,
            radius: 0.5,
            open: false,
        }
    }
}

/// A cone between two points, closed with flat caps or open; truncated where neither radius is 0.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Transform, Visibility)]
#[component(summary_tick)]
pub struct Cone {
    /// Middle of one cap.
    pub a: DVec3,
    /// Radius there, in local units: >= 0, and one of the two > 0.
    pub radius_a: f64,
    /// Middle of the other cap; elsewhere than `a`.
    pub b: DVec3,
    /// Radius there.
    pub radius_b: f64,
    /// Without caps: the side alone, seen from within as well.
    pub open: bool,
}

impl Default for Cone {
    fn default() -> Self {
        Self {
            a: DVec3::ZERO,
            radius_a: 0.5,
            b: DVec3::Y,
            radius_b: 0.0,
            open: false,
        }
    }
}

impl Cone {
    /// A box around it, not the tightest: least and greatest corner.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let (a, b) = (self.a, self.b);
        (
            (a - self.radius_a).min(b - self.radius_b),
            (a + self.radius_a).max(b + self.radius_b),
        )
    }
}

impl From<Cylinder> for Cone {
    fn from(cylinder: Cylinder) -> Self {
        Self {
            a: cylinder.a,
            radius_a: cylinder.radius,
            b: cylinder.b,
            radius_b: cylinder.radius,
            open: cylinder.open,
        }
    }
}

/// A ring about the local Y axis around the local origin.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Transform, Visibility)]
#[component(summary_tick)]
pub struct Torus {
    /// From the origin to the middle of the tube.
    pub major: f64,
    /// Of the tube; > 0 and less than `major`, so that the ring does not meet itself.
    pub minor: f64,
}

impl Default for Torus {
    fn default() -> Self {
        Self {
            major: 1.0,
            minor: 0.25,
        }
    }
}

/// A planar polygon of any number of corners, concave or with holes (even-odd over its loops).
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Transform, Visibility)]
#[component(summary_tick)]
pub struct Polygon {
    /// Outer loop first, then holes; corners in order, either winding, not repeated at the end.
    pub loops: Vec<Vec<DVec3>>,
}

impl Default for Polygon {
    fn default() -> Self {
        let corner = |x, y| DVec3::new(x, y, 0.0);
        Self {
            loops: vec![vec![
                corner(-0.5, -0.5),
                corner(0.5, -0.5),
                corner(0.5, 0.5),
                corner(-0.5, 0.5),
            ]],
        }
    }
}

/// A row of [`Meshes`] that no other entity shows: the triangles its [`Polygon`] was cut into, or its
/// [`Mesh`] as its own deformation or structure makes it. Derived; tracers see it in place of [`Mesh`].
///
/// When it goes, by removal or with its entity, the row is free.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, Clone, PartialEq)]
#[component(summary_tick, on_discard = free_row)]
pub struct OwnMesh(pub MeshId);

fn free_row(mut world: DeferredWorld, context: HookContext) {
    let mesh = world.get::<OwnMesh>(context.entity).copied();
    if let (Some(OwnMesh(id)), Some(mut meshes)) = (mesh, world.get_resource_mut::<Meshes>()) {
        meshes.remove(id);
    }
}
