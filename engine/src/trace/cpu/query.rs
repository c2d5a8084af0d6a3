//! What is asked of a ray, and what is answered.
//!
//! Twin of the head of `shaders/shared/traverse.wgsl`.

use glam::Vec3;

use crate::frame::wire::{MATERIAL_TRANSMITS, NONE};
use crate::trace::PackedScene;

/// Orders hits: by t, then instance id, then primitive. What makes every answer independent of trees.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Key {
    /// Distance in lengths of the ray's direction.
    pub t: f32,
    /// Instance id.
    pub id: u32,
    /// Primitive.
    pub prim: u32,
}

impl Key {
    /// Just after every hit at `t`.
    pub fn after(t: f32) -> Self {
        Self {
            t,
            id: NONE,
            prim: NONE,
        }
    }

    /// Just before every hit at `t`.
    pub fn before(t: f32) -> Self {
        Self { t, id: 0, prim: 0 }
    }
}

/// The primitive a ray starts on; it cannot be hit (a sphere answers with its other root).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Start {
    /// Instance id.
    pub id: u32,
    /// Primitive.
    pub prim: u32,
}

impl Start {
    /// A ray from free space.
    pub const FREE: Self = Self {
        id: NONE,
        prim: NONE,
    };
}

/// A ray and the hits it asks for: those with `after < key < before`.
#[derive(Clone, Copy, Debug)]
pub struct Probe {
    /// Start, relative to the eye.
    pub origin: Vec3,
    /// Direction of any length.
    pub dir: Vec3,
    /// Lower end.
    pub after: Key,
    /// Upper end.
    pub before: Key,
    /// What it starts on.
    pub start: Start,
}

/// A hit, not yet resolved to a surface.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// Its place in the order of hits.
    pub key: Key,
    /// Place among the triangles of its mesh in the order of leaves.
    pub triangle: u32,
    /// Barycentric weights of the second and third corner.
    pub uv: [f32; 2],
}

/// What a search is for: which hit ends it, though nearer ones may be left.
pub trait Until {
    /// Whether it is the nearest hit that is sought, so that what is near is best looked at first.
    const IS_NEAREST: bool;

    /// Whether this hit, the best so far, ends the search.
    fn ends(scene: &PackedScene, hit: Key) -> bool;
}

/// No hit ends the search: the nearest is found.
pub struct Nearest;
/// Any hit ends it.
pub struct AnyHit;
/// A hit that lets no light through ends it, however much glass is before it: of what a shadow ray meets, that decides.
pub struct Opaque;

impl Until for Nearest {
    const IS_NEAREST: bool = true;

    fn ends(_: &PackedScene, _: Key) -> bool {
        false
    }
}

impl Until for AnyHit {
    const IS_NEAREST: bool = false;

    fn ends(_: &PackedScene, _: Key) -> bool {
        true
    }
}

impl Until for Opaque {
    const IS_NEAREST: bool = false;

    fn ends(scene: &PackedScene, hit: Key) -> bool {
        let material = scene.instances()[hit.id as usize].material;
        scene.materials[material as usize].flags & MATERIAL_TRANSMITS == 0
    }
}
