//! [`FrameScene`]: flat arrays of one frame, in f64 where geometry is concerned.
//!
//! Written by extraction alone, read by tracers alone. Row numbers are stable while an entity lives, so a
//! hit's `instance` names the same entity from frame to frame; freed rows hold [`Shape::Vacant`].

use std::sync::Arc;

use bevy_ecs::prelude::*;
use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};

use super::Features;
use crate::world::{Background, Cone, FARTHEST, Fade, Material, MeshRow, Table, Texture, ToneMap};

/// Everything a tracer needs to know of a frame.
#[derive(Resource, Clone, Debug, Default)]
pub struct FrameScene {
    /// The eye. Its origin is the render origin: f32 tracers subtract it in f64 before they round.
    pub view: View,
    /// What a ray that hits nothing sees.
    pub background: Background,
    /// Generations followed; the camera's ray is the first. A ray past the last is black.
    pub max_generations: u32,
    /// Lights that shine.
    pub lights: Table<Light>,
    /// Material rows; row 0 is the default one, for shapes that name none.
    pub materials: Table<Material>,
    /// Texture rows, which materials name.
    pub textures: Table<Arc<Texture>>,
    /// Mesh rows. A changed mesh is another `Arc` in the same row, a deformed one another deformation.
    pub meshes: Table<MeshRow>,
    /// Shapes in the world.
    pub instances: Table<Instance>,
    /// What the rows above make necessary.
    pub features: Features,
}

/// The eye, spanned for B.2 of the ground truth: a ray through picture coordinates
/// sx in [-1/2, 1/2] (to the right) and sy (up) has direction forward + sx*right + sy*up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Position in the world.
    pub origin: DVec3,
    /// Unit view direction.
    pub forward: DVec3,
    /// Spans the picture's full width (perspective: at distance 1).
    pub right: DVec3,
    /// Spans the picture's full height.
    pub up: DVec3,
    /// Perspective: rays start at the origin. Orthographic: at origin + sx*right + sy*up, along forward.
    pub projection: ViewProjection,
    /// Stops, for the present pass.
    pub exposure: f32,
    /// Tone curve, for the present pass.
    pub tone_map: ToneMap,
}

impl Default for View {
    fn default() -> Self {
        Self {
            origin: DVec3::ZERO,
            forward: DVec3::NEG_Z,
            right: DVec3::X,
            up: DVec3::Y,
            projection: ViewProjection::Perspective,
            exposure: 0.0,
            tone_map: ToneMap::Clip,
        }
    }
}

/// Kind of [`View`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum ViewProjection {
    /// A pinhole.
    #[default]
    Perspective,
    /// Parallel rays.
    Orthographic,
}

impl FrameScene {
    /// How much there is of it, for errors.
    pub fn size_in_words(&self) -> String {
        let triangles: usize = self.meshes.iter().map(|row| row.data.triangles.len()).sum();
        let vertices: usize = self.meshes.iter().map(|row| row.data.positions.len()).sum();
        format!(
            "{} instances, {} meshes of {triangles} triangles and {vertices} vertices in all, {} lights, {} textures",
            self.instances.len(),
            self.meshes.len(),
            self.lights.len(),
            self.textures.len()
        )
    }
}

/// A light in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Linear RGB, intensity multiplied in.
    pub color: Vec3,
    /// Falloff with distance.
    pub fade: Option<Fade>,
    /// Where and whither it shines.
    pub kind: LightKind,
}

/// Where and whither a light shines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// From a point, all around.
    Point {
        /// World position.
        position: DVec3,
    },
    /// From infinitely far away.
    Directional {
        /// Unit direction towards the light.
        to_light: DVec3,
    },
    /// From a point, into a cone.
    Spot {
        /// World position.
        position: DVec3,
        /// Unit axis of the cone, away from the light.
        axis: DVec3,
        /// Cosine of the half angle of full light.
        cos_inner: f64,
        /// Cosine of the half angle of no light; smoothstep between.
        cos_outer: f64,
    },
}

/// A shape in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// Opaque tag of the owner (an entity's bits), for picking; tracers hand it on unread.
    pub tag: u64,
    /// What it is, in local space.
    pub shape: Shape,
    /// Finite and invertible (extraction leaves others out as [`Shape::Vacant`]).
    pub world_from_local: DAffine3,
    /// Row of [`FrameScene::materials`].
    pub material: u32,
}

/// Geometry of an [`Instance`] in its local space. All are two-sided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// Nothing: a free, hidden or singular row.
    Vacant,
    /// Row of [`FrameScene::meshes`]; primitive ids are triangle numbers.
    Mesh(u32),
    /// About the local origin; primitive 0.
    Sphere {
        /// Local units.
        radius: f64,
    },
    /// n.p = distance; primitive 0.
    Plane {
        /// Any length but zero.
        normal: DVec3,
        /// In units of the normal's length.
        distance: f64,
    },
    /// Along the local axes; primitives 0..6 are the faces -x +x -y +y -z +z.
    Cuboid {
        /// Least corner.
        min: DVec3,
        /// Greatest corner.
        max: DVec3,
    },
    /// Flat and round; primitive 0.
    Disc {
        /// Its middle.
        center: DVec3,
        /// Any length but zero.
        normal: DVec3,
        /// Local units.
        radius: f64,
    },
    /// A cylinder or a cone between two points; primitives: side 0, the cap at `a` 1, the cap at `b` 2.
    Cone(Cone),
    /// A ring about the local Y axis around the local origin; primitive 0.
    Torus {
        /// From the origin to the middle of the tube.
        major: f64,
        /// Of the tube; less than `major`.
        minor: f64,
    },
}

impl Shape {
    /// Takes the shape's own space, in which it is of about the size 1, to its local one; the identity where it has none.
    pub fn local_from_unit(&self) -> DAffine3 {
        match *self {
            Self::Vacant | Self::Mesh(_) | Self::Plane { .. } => DAffine3::IDENTITY,
            Self::Sphere { radius } => DAffine3::from_scale(DVec3::splat(radius)),
            Self::Cuboid { min, max } => {
                let (half, center) = ((max - min) * 0.5, (max + min) * 0.5);
                DAffine3::from_scale_rotation_translation(half, DQuat::IDENTITY, center)
            }
            Self::Disc {
                center,
                normal,
                radius,
            } => upright(normal.normalize() * radius, radius, center),
            Self::Cone(Cone {
                a,
                radius_a,
                b,
                radius_b,
                ..
            }) => upright((b - a) * 0.5, radius_a.max(radius_b), (a + b) * 0.5),
            Self::Torus { major, .. } => DAffine3::from_scale(DVec3::splat(major)),
        }
    }

    /// Whether f32 can square what takes the world to the shape's own space, and back: where not, infinities and what
    /// comes of them reach pixels.
    pub fn is_in_range(&self, world_from_local: &DAffine3) -> bool {
        let there = world_from_local.matrix3 * self.local_from_unit().matrix3;
        let is_small = |m: DMat3| m.to_cols_array().iter().all(|x| x.abs() <= FARTHEST);
        is_small(there) && is_small(there.inverse())
    }
}

/// Takes +Y to `axis`, and what is across it to vectors of length `radius`.
fn upright(axis: DVec3, radius: f64, center: DVec3) -> DAffine3 {
    let (x, z) = axis.normalize().any_orthonormal_pair();
    let linear = DMat3::from_cols(x * radius, axis, z * radius);
    DAffine3::from_mat3_translation(linear, center)
}
