//! Finding the hits of a ray: one walk over the two levels of trees that serves closest, any-hit and shadow queries.
//!
//! Twin of `shaders/shared/traverse.wgsl`.

use std::marker::PhantomData;

use glam::{Vec3, Vec4};

use super::enter::{enter_bare_boxes, enter_boxes, enter_spheres};
use super::leaf::{FOUR, Prepared};
use super::look::Cutout;
use super::query::{Found, Key, Probe, Start, Until};
use super::stack::Stack;
use crate::bvh::{Child, Node4};
use crate::frame::wire::{
    CONE_OPEN, InstanceRow, KIND_CONE, KIND_CUBOID, KIND_DISC, KIND_ELLIPSOID, KIND_MESH,
    KIND_SPHERE, KIND_TORUS, NONE, ROOT_OF_SPHERES,
};
use crate::frame::{BoxTest, TriangleTest};
use crate::geom::{
    CONE_SIDE, SlabRay, SphereFrame, TriangleHit, intersect_cone, intersect_cuboid, intersect_disc,
    intersect_torus, intersect_triangle_unshared,
};
use crate::trace::PackedScene;
use crate::trace::pack::PackedMesh;

/// 2^-20: what a ray's origin errs by, of its size, in the space of the instance tree's boxes (one sum) or of
/// an instance (a product with its matrix; the boxes are padded for what is worse conditioned than a turn).
pub(super) const ORIGIN_SLACK: f32 = 1.0 / 1_048_576.0;

/// The nearest hit a probe asks for, or one that ends the search.
pub fn trace<U: Until>(scene: &PackedScene, probe: &Probe, stack: &mut Stack) -> Option<Found> {
    let mut search = Search::<U>::new(scene, probe);
    let is_over = search.planes();
    if !is_over {
        stack.len = 0;
        search.instances(stack);
    }
    search.found()
}

/// A search under way.
pub(super) struct Search<'a, U> {
    purpose: PhantomData<U>,
    scene: &'a PackedScene,
    probe: &'a Probe,
    /// The best hit so far, or the bound it must be before.
    best: Found,
    is_hit: bool,
}

impl<'a, U: Until> Search<'a, U> {
    /// One that has found nothing yet.
    pub fn new(scene: &'a PackedScene, probe: &'a Probe) -> Self {
        Self {
            purpose: PhantomData,
            scene,
            probe,
            best: Found {
                key: probe.before,
                triangle: NONE,
                uv: [0.0; 2],
            },
            is_hit: false,
        }
    }

    /// What it has found.
    pub fn found(&self) -> Option<Found> {
        self.is_hit.then_some(self.best)
    }

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

    /// Planes, which are in no tree; true: the search is over.
    pub fn planes(&mut self) -> bool {
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

    /// An instance that the ray may meet; true: the search is over.
    pub fn instance(&mut self, index: u32, stack: &mut Stack) -> bool {
        let row = &self.scene.instances()[index as usize];
        if row.kind == KIND_SPHERE {
            return self.sphere(index, &row.sphere(), self.probe.origin, self.probe.dir);
        }
        let origin = row.local_from_world.point(self.probe.origin);
        let dir = row.local_from_world.vector(self.probe.dir);
        match row.kind {
            KIND_MESH => self.mesh(index, row, (origin, dir), stack),
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
        (origin, dir): (Vec3, Vec3),
        stack: &mut Stack,
    ) -> bool {
        let mesh = self.scene.mesh(row);
        let cutout = Cutout::of(self.scene, row);
        let instance = (id, mesh, cutout.as_ref());
        if self.scene.kernels.triangles == TriangleTest::MollerTrumbore {
            let leaf = |search: &mut Self, _: &mut Stack, first: u32, count: u32| {
                (first..first + count).any(|place| {
                    let corners = mesh.corners(&mesh.triangles[place as usize]);
                    let hit = intersect_triangle_unshared(origin, dir, corners);
                    hit.is_some_and(|hit| search.triangle(instance, place, hit))
                })
            };
            return self.walk_mesh(row, (origin, dir), stack, leaf);
        }
        let ray = Prepared::new(origin, dir);
        let leaf = |search: &mut Self, _: &mut Stack, first: u32, count: u32| {
            let (mut first, end) = (first, first + count);
            while first < end {
                let range = first..end.min(first + FOUR as u32);
                let limits = (search.probe.after.t, search.best.key.t);
                let four = ray.meet(mesh, range, limits);
                let mut rest = four.mask;
                while rest != 0 {
                    let which = rest.trailing_zeros();
                    rest &= rest - 1;
                    let place = first + which;
                    let corners = mesh.corners(&mesh.triangles[place as usize]);
                    let hit = ray.hit(&four, which as usize, corners);
                    if search.triangle(instance, place, hit) {
                        return true;
                    }
                }
                first += FOUR as u32;
            }
            false
        };
        self.walk_mesh(row, (origin, dir), stack, leaf)
    }

    /// Offers the hit of a triangle, if it is not where the ray starts and not a hole.
    #[inline]
    fn triangle(
        &mut self,
        (id, mesh, cutout): (u32, &PackedMesh, Option<&Cutout>),
        place: u32,
        hit: TriangleHit,
    ) -> bool {
        let triangle = &mesh.triangles[place as usize];
        let prim = triangle.prim;
        let uv = [hit.u, hit.v];
        if self.probe.start == (Start { id, prim }) || hit.t > self.best.key.t {
            return false;
        }
        if cutout.is_some_and(|cutout| cutout.is_hole(self.scene, mesh, triangle, uv)) {
            return false;
        }
        self.offer(Key { t: hit.t, id, prim }, place, uv)
    }

    /// Visits the leaves of a mesh; the ray is the mesh's own.
    #[inline]
    fn walk_mesh(
        &mut self,
        row: &InstanceRow,
        (origin, dir): (Vec3, Vec3),
        stack: &mut Stack,
        leaf: impl Fn(&mut Self, &mut Stack, u32, u32) -> bool,
    ) -> bool {
        let nodes = self.scene.mesh(row).nodes();
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
    let mut next = Child::Node(0).encode();
    loop {
        match Child::decode(next) {
            Child::None => {}
            Child::Leaf { first, count } => {
                if leaf(search, stack, first, count) {
                    stack.len = base;
                    return true;
                }
            }
            Child::Node(node) => {
                let limits = (search.probe.after.t, reach(search.best.key.t));
                let node = &nodes[node as usize];
                let (near, entered) = enter(node, limits);
                let below = stack.len;
                if let Some(nearest) = stack.push_entered(node, near, entered) {
                    stack.ask_for(below, nodes);
                    next = nearest;
                    continue;
                }
            }
        }
        loop {
            if stack.len == base {
                return false;
            }
            let (child, near) = stack.pop();
            if near <= reach(search.best.key.t) {
                next = child;
                break;
            }
        }
    }
}

/// How far a box may begin and still hold a hit as near as `t`: eight ulps more, so that a tie at `t` is
/// found whichever of its boxes comes first.
#[inline]
pub(super) fn reach(t: f32) -> f32 {
    t * (1.0 + 8.0 * f32::EPSILON)
}
