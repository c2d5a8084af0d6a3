//! Finding hits: one walk over the two levels of trees that serves closest, any-hit and shadow queries.
//!
//! Twin of `shaders/shared/traverse.wgsl`.

use glam::{Vec3, Vec4};

use crate::bvh::{Child, Node4, TRAVERSAL_CAPACITY};
use crate::frame::wire::{InstanceRow, KIND_CUBOID, KIND_ELLIPSOID, KIND_MESH, KIND_SPHERE, NONE};
use crate::geom::{
    FAR_WIDENING, Shear, SlabRay, intersect_cuboid, intersect_plane, intersect_sphere,
};
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
    /// Instance row.
    pub row: u32,
    /// Triangle row, of meshes.
    pub triangle: u32,
    /// Barycentric weights of the second and third corner.
    pub uv: [f32; 2],
}

/// Nodes still to visit and the distance at which a ray enters them. Kept from ray to ray.
pub struct Stack {
    entries: [(u32, f32); TRAVERSAL_CAPACITY as usize],
    len: usize,
}

impl Default for Stack {
    fn default() -> Self {
        Self {
            entries: [(0, 0.0); TRAVERSAL_CAPACITY as usize],
            len: 0,
        }
    }
}

/// The nearest hit a probe asks for; with `ANY`, some hit.
pub fn trace<const ANY: bool>(
    scene: &PackedScene,
    probe: &Probe,
    stack: &mut Stack,
) -> Option<Found> {
    let mut search = Search::<ANY> {
        scene,
        probe,
        best: Found {
            key: probe.before,
            row: NONE,
            triangle: NONE,
            uv: [0.0; 2],
        },
    };
    let found = search.planes() || {
        stack.len = 0;
        scene.view.root != NONE && search.instances(stack)
    };
    (found || search.best.row != NONE).then_some(search.best)
}

struct Search<'a, const ANY: bool> {
    scene: &'a PackedScene,
    probe: &'a Probe,
    best: Found,
}

impl<const ANY: bool> Search<'_, ANY> {
    /// Takes a candidate if it is in range and the best so far; true: the search is over.
    #[inline]
    fn offer(&mut self, key: Key, row: u32, triangle: u32, uv: [f32; 2]) -> bool {
        if !(key > self.probe.after && key < self.best.key) {
            return false;
        }
        self.best = Found {
            key,
            row,
            triangle,
            uv,
        };
        ANY
    }

    fn planes(&mut self) -> bool {
        for index in 0..self.scene.view.plane_count {
            let row = &self.scene.instances[index as usize];
            if self.probe.start.id == row.id {
                continue;
            }
            let [x, y, z, distance] = row.local_from_world.0[0];
            let normal = Vec3::new(x, y, z);
            if let Some(t) = intersect_plane(normal, distance, self.probe.origin, self.probe.dir) {
                let key = Key {
                    t,
                    id: row.id,
                    prim: 0,
                };
                if self.offer(key, index, NONE, [0.0; 2]) {
                    return true;
                }
            }
        }
        false
    }

    fn instances(&mut self, stack: &mut Stack) -> bool {
        let nodes = &self.scene.nodes[self.scene.view.root as usize..];
        let slab = SlabRay::new(self.probe.origin, self.probe.dir);
        walk(nodes, &slab, self, stack, |search, stack, index, _| {
            search.instance(index, stack)
        })
    }

    fn instance(&mut self, index: u32, stack: &mut Stack) -> bool {
        let row = &self.scene.instances[index as usize];
        if row.kind == KIND_SPHERE {
            let [x, y, z, radius] = row.local_from_world.0[0];
            let from_center = self.probe.origin - Vec3::new(x, y, z);
            return self.sphere(index, row.id, from_center, self.probe.dir, radius);
        }
        let origin = row.local_from_world.point(self.probe.origin);
        let dir = row.local_from_world.vector(self.probe.dir);
        match row.kind {
            KIND_MESH => self.mesh(index, row, origin, dir, stack),
            KIND_ELLIPSOID => self.sphere(index, row.id, origin, dir, 1.0),
            KIND_CUBOID => self.cuboid(index, row.id, origin, dir),
            _ => false,
        }
    }

    fn sphere(&mut self, row: u32, id: u32, from_center: Vec3, dir: Vec3, radius: f32) -> bool {
        let starts_on = self.probe.start.id == id;
        let Some(roots) = intersect_sphere(from_center, dir, radius, starts_on) else {
            return false;
        };
        let key = |t| Key { t, id, prim: 0 };
        self.offer(key(roots.near), row, NONE, [0.0; 2])
            || self.offer(key(roots.far), row, NONE, [0.0; 2])
    }

    fn cuboid(&mut self, row: u32, id: u32, origin: Vec3, dir: Vec3) -> bool {
        let Some(faces) = intersect_cuboid(origin, dir) else {
            return false;
        };
        faces.into_iter().any(|(t, prim)| {
            let starts_on = self.probe.start == Start { id, prim };
            !starts_on && self.offer(Key { t, id, prim }, row, NONE, [0.0; 2])
        })
    }

    fn mesh(
        &mut self,
        index: u32,
        row: &InstanceRow,
        origin: Vec3,
        dir: Vec3,
        stack: &mut Stack,
    ) -> bool {
        let nodes = &self.scene.nodes[row.root as usize..];
        let triangles = &self.scene.triangles[row.first_triangle as usize..];
        let (slab, shear) = (SlabRay::new(origin, dir), Shear::new(dir));
        let start = self.probe.start;
        walk(nodes, &slab, self, stack, |search, _, first, count| {
            for slot in first..first + count {
                let triangle = &triangles[slot as usize];
                let corners = [triangle.a, triangle.b, triangle.c].map(Vec3::from);
                let Some(hit) = shear.intersect(origin, corners) else {
                    continue;
                };
                let key = Key {
                    t: hit.t,
                    id: row.id,
                    prim: triangle.prim,
                };
                let starts_on = start.id == row.id && start.prim == triangle.prim;
                let slot = row.first_triangle + slot;
                if !starts_on && search.offer(key, index, slot, [hit.u, hit.v]) {
                    return true;
                }
            }
            false
        })
    }
}

/// Visits the leaves a ray may have a hit in, nearest box first; `leaf` gets first and count and says
/// whether the search is over.
fn walk<const ANY: bool>(
    nodes: &[Node4],
    slab: &SlabRay,
    search: &mut Search<'_, ANY>,
    stack: &mut Stack,
    leaf: impl Fn(&mut Search<'_, ANY>, &mut Stack, u32, u32) -> bool,
) -> bool {
    let base = stack.len;
    let mut next = Some(Child::Node(0).encode());
    let done = loop {
        let slot = match next.take() {
            Some(slot) => slot,
            None if stack.len == base => break false,
            None => {
                stack.len -= 1;
                let (slot, near) = stack.entries[stack.len];
                if near > reach(search.best.key.t) {
                    continue;
                }
                slot
            }
        };
        match Child::decode(slot) {
            Child::None => {}
            Child::Leaf { first, count } => {
                if leaf(search, stack, first, count) {
                    break true;
                }
            }
            Child::Node(node) => {
                let limits = (search.probe.after.t, reach(search.best.key.t));
                next = push_children(&nodes[node as usize], slab, limits, stack);
            }
        }
    };
    stack.len = base;
    done
}

/// How far a box may begin and still hold a hit as near as `t`: eight ulps more, so that a tie at `t` is
/// found whichever of its boxes comes first.
#[inline]
fn reach(t: f32) -> f32 {
    t * (1.0 + 8.0 * f32::EPSILON)
}

/// Slab test of four children; the nearest is returned, the others go on the stack, farthest first.
#[inline]
fn push_children(
    node: &Node4,
    slab: &SlabRay,
    (from, to): (f32, f32),
    stack: &mut Stack,
) -> Option<u32> {
    let axis = |min: &[f32; 4], max: &[f32; 4], origin: f32, inverse: f32| {
        let (near, far) = if inverse > 0.0 {
            (min, max)
        } else {
            (max, min)
        };
        let t = |side: &[f32; 4]| (Vec4::from(*side) - origin) * inverse;
        (t(near), t(far))
    };
    let (near_x, far_x) = axis(&node.min_x, &node.max_x, slab.origin.x, slab.inverse.x);
    let (near_y, far_y) = axis(&node.min_y, &node.max_y, slab.origin.y, slab.inverse.y);
    let (near_z, far_z) = axis(&node.min_z, &node.max_z, slab.origin.z, slab.inverse.z);
    let near = near_x.max(near_y).max(near_z.max(Vec4::splat(from)));
    let far = far_x.min(far_y).min(far_z) * FAR_WIDENING;
    let entered = near.cmple(far.min(Vec4::splat(to))).bitmask();
    let base = stack.len;
    for (slot, &child) in node.children.iter().enumerate() {
        if entered & (1 << slot) != 0 && child != crate::bvh::CHILD_NONE {
            // Insertion sort, nearest on top.
            let mut place = stack.len;
            while place > base && stack.entries[place - 1].1 < near[slot] {
                stack.entries[place] = stack.entries[place - 1];
                place -= 1;
            }
            stack.entries[place] = (child, near[slot]);
            stack.len += 1;
        }
    }
    (stack.len > base).then(|| {
        stack.len -= 1;
        stack.entries[stack.len].0
    })
}
