//! Finding hits: one walk over the two levels of trees that serves closest, any-hit and shadow queries.
//!
//! Twin of `shaders/shared/traverse.wgsl`.

use std::marker::PhantomData;

use glam::{Vec3, Vec4};

use super::enter::{enter_bare_boxes, enter_boxes, enter_spheres};
use super::look::Cutout;
use crate::bvh::{Child, Node4, TRAVERSAL_CAPACITY};
use crate::frame::wire::{
    CONE_OPEN, InstanceRow, KIND_CONE, KIND_CUBOID, KIND_DISC, KIND_ELLIPSOID, KIND_MESH,
    KIND_SPHERE, KIND_TORUS, MATERIAL_TRANSMITS, NONE, ROOT_OF_SPHERES,
};
use crate::frame::{BoxTest, TriangleTest};
use crate::geom::{
    CONE_SIDE, Shear, SlabRay, SphereFrame, TriangleHit, intersect_cone, intersect_cuboid,
    intersect_disc, intersect_torus, intersect_triangle_unshared,
};
use crate::trace::PackedScene;

/// 2^-20: what a ray's origin errs by, of its size, in the space of the instance tree's boxes (one sum) or of
/// an instance (a product with its matrix; the boxes are padded for what is worse conditioned than a turn).
const ORIGIN_SLACK: f32 = 1.0 / 1_048_576.0;

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

/// What a search is for: which hit ends it, though nearer ones may be left.
pub trait Until {
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
    fn ends(_: &PackedScene, _: Key) -> bool {
        false
    }
}

impl Until for AnyHit {
    fn ends(_: &PackedScene, _: Key) -> bool {
        true
    }
}

impl Until for Opaque {
    fn ends(scene: &PackedScene, hit: Key) -> bool {
        let material = scene.instances()[hit.id as usize].material;
        scene.materials[material as usize].flags & MATERIAL_TRANSMITS == 0
    }
}

/// The nearest hit a probe asks for, or one that ends the search.
pub fn trace<U: Until>(scene: &PackedScene, probe: &Probe, stack: &mut Stack) -> Option<Found> {
    let mut search = Search::<U> {
        purpose: PhantomData,
        scene,
        probe,
        best: Found {
            key: probe.before,
            triangle: NONE,
            uv: [0.0; 2],
        },
        is_hit: false,
    };
    let found = search.planes() || {
        stack.len = 0;
        search.instances(stack)
    };
    (found || search.is_hit).then_some(search.best)
}

struct Search<'a, U> {
    purpose: PhantomData<U>,
    scene: &'a PackedScene,
    probe: &'a Probe,
    /// The best hit so far, or the bound it must be before.
    best: Found,
    is_hit: bool,
}

impl<U: Until> Search<'_, U> {
    /// Takes a candidate if it is in range and the best so far; true: the search is over.
    #[inline]
    fn offer(&mut self, key: Key, triangle: u32, uv: [f32; 2]) -> bool {
        if !(key > self.probe.after && key < self.best.key) {
            return false;
        }
        self.best = Found { key, triangle, uv };
        self.is_hit = true;
        U::ends(self.scene, key)
    }

    fn planes(&mut self) -> bool {
        let mut next = self.scene.view.first_plane;
        while next != NONE {
            let id = next;
            let row = &self.scene.instances()[id as usize];
            next = row.link;
            if self.probe.start.id == id {
                continue;
            }
            if let Some(t) = row.plane().intersect(self.probe.origin, self.probe.dir)
                && self.offer(Key { t, id, prim: 0 }, NONE, [0.0; 2])
            {
                return true;
            }
        }
        false
    }

    fn instances(&mut self, stack: &mut Stack) -> bool {
        let nodes = self.scene.instance_nodes();
        if nodes.is_empty() {
            return false;
        }
        let offset = Vec3::from(self.scene.view.eye_from_anchor);
        let origin = self.probe.origin + offset;
        let slack = (self.probe.origin.abs() + offset.abs()) * ORIGIN_SLACK;
        let leaf = |search: &mut Self, stack: &mut Stack, index, _| search.instance(index, stack);
        if self.scene.kernels.boxes == BoxTest::Bare {
            let slab = SlabRay::bare(origin, self.probe.dir);
            let enter = |node: &Node4, limits| enter_bare_boxes(node, &slab, limits);
            return walk(nodes, enter, self, stack, leaf);
        }
        let slab = SlabRay::with_slack(origin, slack, self.probe.dir);
        let enter = |node: &Node4, limits| enter_boxes(node, &slab, limits);
        walk(nodes, enter, self, stack, leaf)
    }

    fn instance(&mut self, index: u32, stack: &mut Stack) -> bool {
        let row = &self.scene.instances()[index as usize];
        if row.kind == KIND_SPHERE {
            return self.sphere(index, &row.sphere(), self.probe.origin, self.probe.dir);
        }
        let origin = row.local_from_world.point(self.probe.origin);
        let dir = row.local_from_world.vector(self.probe.dir);
        match row.kind {
            KIND_MESH => self.mesh(index, row, origin, dir, stack),
            KIND_ELLIPSOID => self.sphere(index, &SphereFrame::UNIT, origin, dir),
            KIND_CUBOID => self.cuboid(index, origin, dir),
            KIND_DISC => self.disc(index, origin, dir),
            KIND_CONE => self.cone(index, row, origin, dir),
            KIND_TORUS => self.torus(index, origin, dir, row.parameter),
            _ => false,
        }
    }

    fn sphere(&mut self, id: u32, sphere: &SphereFrame, origin: Vec3, dir: Vec3) -> bool {
        let starts_on = self.probe.start.id == id;
        let Some(roots) = sphere.intersect(origin, dir, starts_on) else {
            return false;
        };
        let key = |t| Key { t, id, prim: 0 };
        self.offer(key(roots.near), NONE, [0.0; 2]) || self.offer(key(roots.far), NONE, [0.0; 2])
    }

    fn cuboid(&mut self, id: u32, origin: Vec3, dir: Vec3) -> bool {
        let Some(faces) = intersect_cuboid(origin, dir) else {
            return false;
        };
        faces.into_iter().any(|(t, prim)| {
            let starts_on = self.probe.start == Start { id, prim };
            !starts_on && self.offer(Key { t, id, prim }, NONE, [0.0; 2])
        })
    }

    fn disc(&mut self, id: u32, origin: Vec3, dir: Vec3) -> bool {
        let starts_on = self.probe.start.id == id;
        let t = intersect_disc(origin, dir).filter(|_| !starts_on);
        t.is_some_and(|t| self.offer(Key { t, id, prim: 0 }, NONE, [0.0; 2]))
    }

    /// An open one is the side of the closed one: what enters or leaves that by a cap misses it there.
    fn cone(&mut self, id: u32, row: &InstanceRow, origin: Vec3, dir: Vec3) -> bool {
        let start = self.probe.start;
        let start = (start.id == id).then_some(start.prim);
        let is_open = row.root == CONE_OPEN;
        let hits = intersect_cone(origin, dir, row.parameter, start);
        let hits = hits.into_iter().flatten();
        let mut hits = hits.filter(|&(_, prim)| !is_open || prim == CONE_SIDE);
        hits.any(|(t, prim)| self.offer(Key { t, id, prim }, NONE, [0.0; 2]))
    }

    fn torus(&mut self, id: u32, origin: Vec3, dir: Vec3, minor: f32) -> bool {
        let starts_on = self.probe.start.id == id;
        let roots = intersect_torus(origin, dir, minor, starts_on);
        let mut roots = roots.into_iter().flatten();
        roots.any(|t| self.offer(Key { t, id, prim: 0 }, NONE, [0.0; 2]))
    }

    fn mesh(
        &mut self,
        id: u32,
        row: &InstanceRow,
        origin: Vec3,
        dir: Vec3,
        stack: &mut Stack,
    ) -> bool {
        if self.scene.kernels.triangles == TriangleTest::MollerTrumbore {
            let hit = |corners| intersect_triangle_unshared(origin, dir, corners);
            return self.mesh_by(hit, id, row, (origin, dir), stack);
        }
        let shear = Shear::new(dir);
        let hit = |corners| shear.intersect(origin, corners);
        self.mesh_by(hit, id, row, (origin, dir), stack)
    }

    /// A mesh, its triangles tested by `intersect`; the ray is the mesh's own.
    #[inline]
    fn mesh_by(
        &mut self,
        intersect: impl Fn([Vec3; 3]) -> Option<TriangleHit>,
        id: u32,
        row: &InstanceRow,
        (origin, dir): (Vec3, Vec3),
        stack: &mut Stack,
    ) -> bool {
        let mesh = self.scene.mesh(row);
        let nodes = mesh.nodes();
        let start = self.probe.start;
        let cutout = Cutout::of(self.scene, row);
        let leaf = |search: &mut Self, _: &mut Stack, first, count| {
            for slot in first..first + count {
                let triangle = &mesh.triangles[slot as usize];
                let corners = mesh.corners(triangle);
                let Some(hit) = intersect(corners) else {
                    continue;
                };
                let key = Key {
                    t: hit.t,
                    id,
                    prim: triangle.prim,
                };
                let starts_on = start.id == id && start.prim == triangle.prim;
                if let Some(cutout) = cutout
                    && hit.t <= search.best.key.t
                    && cutout.is_hole(search.scene, mesh, triangle, [hit.u, hit.v])
                {
                    continue;
                }
                if !starts_on && search.offer(key, slot, [hit.u, hit.v]) {
                    return true;
                }
            }
            false
        };
        if row.root & ROOT_OF_SPHERES != 0 {
            let enter = |node: &Node4, limits| enter_spheres(node, origin, dir, limits);
            return walk(nodes, enter, self, stack, leaf);
        }
        if self.scene.kernels.boxes == BoxTest::Bare {
            let slab = SlabRay::bare(origin, dir);
            let enter = |node: &Node4, limits| enter_bare_boxes(node, &slab, limits);
            return walk(nodes, enter, self, stack, leaf);
        }
        let slab = SlabRay::new(origin, dir);
        let enter = |node: &Node4, limits| enter_boxes(node, &slab, limits);
        walk(nodes, enter, self, stack, leaf)
    }
}

/// Visits the leaves a ray may have a hit in, nearest box first; `leaf` gets first and count and says
/// whether the search is over.
fn walk<'s, U: Until>(
    nodes: &[Node4],
    enter: impl Fn(&Node4, (f32, f32)) -> (Vec4, u32),
    search: &mut Search<'s, U>,
    stack: &mut Stack,
    leaf: impl Fn(&mut Search<'s, U>, &mut Stack, u32, u32) -> bool,
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
                let node = &nodes[node as usize];
                let (near, entered) = enter(node, limits);
                next = push_children(node, near, entered, stack);
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

/// Pushes the children a ray enters at `near`, farthest first, but for the nearest, which is returned.
#[inline]
fn push_children(node: &Node4, near: Vec4, entered: u32, stack: &mut Stack) -> Option<u32> {
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
