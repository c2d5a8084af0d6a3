//! Finding the hits of a ray: one walk over the two levels of trees that serves closest, any-hit and shadow queries.
//!
//! Twin of `shaders/shared/traverse.wgsl`.

use std::marker::PhantomData;

use glam::{Vec3, Vec4};

use super::eights::{Met, walk_eights};
use super::enter::{enter_bare_boxes, enter_boxes, enter_spheres};
use super::look::Cutout;
use super::query::{Found, Key, Probe, Start, Until};
use super::simd::{Instructions, Portable, Simd, Work};
use super::stack::Stack;
use crate::bvh::{CHILD_LEAF, Child, LEAF_FIRST_MASK, Node4};
use crate::frame::wire::{
    CONE_OPEN, InstanceRow, KIND_CONE, KIND_CUBOID, KIND_DISC, KIND_ELLIPSOID, KIND_MESH,
    KIND_SPHERE, KIND_TORUS, NONE, ROOT_OF_SPHERES,
};
use crate::frame::{BoxTest, TriangleTest};
use crate::geom::{
    CONE_SIDE, Shear, SlabRay, SphereFrame, TriangleHit, intersect_cone, intersect_cuboid,
    intersect_disc, intersect_torus, intersect_triangle_unshared,
};
use crate::trace::PackedScene;

/// 2^-20: what a ray's origin errs by, of its size, in the space of the instance tree's boxes (one sum) or of
/// an instance (a product with its matrix; the boxes are padded for what is worse conditioned than a turn).
pub(super) const ORIGIN_SLACK: f32 = 1.0 / 1_048_576.0;

/// The nearest hit a probe asks for, or one that ends the search.
pub fn trace<U: Until>(scene: &PackedScene, probe: &Probe, stack: &mut Stack) -> Option<Found> {
    let instructions = match is_plain(scene) {
        true => stack.instructions,
        false => Instructions::Portable,
    };
    instructions.run(Single::<U> {
        purpose: PhantomData,
        scene,
        probe,
        stack,
    })
}

/// Whether boxes and triangles are met as pictures are made, not in a way that is measured against that.
#[inline]
pub(super) fn is_plain(scene: &PackedScene) -> bool {
    scene.kernels.boxes == BoxTest::Padded && scene.kernels.triangles == TriangleTest::Watertight
}

/// [`trace`] with the instructions that there are.
struct Single<'a, U> {
    purpose: PhantomData<U>,
    scene: &'a PackedScene,
    probe: &'a Probe,
    stack: &'a mut Stack,
}

impl<U: Until> Work for Single<'_, U> {
    type Output = Option<Found>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Option<Found> {
        let mut search = Search::<U>::new(self.scene, self.probe);
        let is_over = search.planes();
        if !is_over {
            self.stack.len = 0;
            search.instances(simd, self.stack);
        }
        search.found()
    }
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

    /// Lower end, and where the best hit so far is.
    #[inline(always)]
    pub fn limits(&self) -> (f32, f32) {
        (self.probe.after.t, self.best.key.t)
    }

    /// Takes a candidate if it is in range and the best so far; true: the search is over.
    #[inline(always)]
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

    #[inline(always)]
    fn instances<S: Simd>(&mut self, simd: S, stack: &mut Stack) -> bool {
        let nodes = self.scene.instance_nodes();
        if nodes.is_empty() {
            return false;
        }
        let root = self.scene.view.root;
        if root & CHILD_LEAF != 0 {
            // All there is: its own boxes will tell.
            return self.instance(simd, root & LEAF_FIRST_MASK, stack);
        }
        let offset = Vec3::from(self.scene.view.eye_from_anchor);
        let origin = self.probe.origin + offset;
        if self.scene.kernels.boxes == BoxTest::Bare {
            return self.bare_instances(origin, stack);
        }
        let slack = (self.probe.origin.abs() + offset.abs()) * ORIGIN_SLACK;
        let slab = SlabRay::with_slack(origin, slack, self.probe.dir);
        walk(
            nodes,
            #[inline(always)]
            |node: &Node4, limits| enter_boxes(node, &slab, limits),
            self,
            stack,
            #[inline(always)]
            |search, stack, index, _| search.instance(simd, index, stack),
        )
    }

    #[inline(never)]
    fn bare_instances(&mut self, origin: Vec3, stack: &mut Stack) -> bool {
        let slab = SlabRay::bare(origin, self.probe.dir);
        walk(
            self.scene.instance_nodes(),
            |node: &Node4, limits| enter_bare_boxes(node, &slab, limits),
            self,
            stack,
            |search, stack, index, _| search.instance(Portable, index, stack),
        )
    }

    /// An instance that the ray may meet; true: the search is over.
    #[inline(always)]
    pub fn instance<S: Simd>(&mut self, simd: S, index: u32, stack: &mut Stack) -> bool {
        let row = &self.scene.instances()[index as usize];
        if row.kind == KIND_SPHERE {
            return self.sphere(index, &row.sphere(), self.probe.origin, self.probe.dir);
        }
        let origin = row.local_from_world.point(self.probe.origin);
        let dir = row.local_from_world.vector(self.probe.dir);
        match row.kind {
            KIND_MESH => {
                let mesh = self.scene.mesh(row);
                let cutout = Cutout::of(self.scene, row);
                let instance = (index, mesh, cutout.as_ref());
                if mesh.lanes.nodes.is_empty() || !is_plain(self.scene) {
                    return self.other_mesh(row, instance, (origin, dir), stack);
                }
                walk_eights(simd, self, instance, (origin, dir), stack)
            }
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

    /// A mesh under another tree, or met by other tests: what is measured against what pictures are made by.
    #[inline(never)]
    fn other_mesh(
        &mut self,
        row: &InstanceRow,
        instance: Met,
        (origin, dir): (Vec3, Vec3),
        stack: &mut Stack,
    ) -> bool {
        let mesh = instance.1;
        let shear = Shear::new(dir);
        let test = self.scene.kernels.triangles;
        let leaf = |search: &mut Self, _: &mut Stack, first: u32, count: u32| {
            (first..first + count).any(|place| {
                let triangle = &mesh.triangles[place as usize];
                let corners = mesh.corners(triangle);
                let hit = match test {
                    TriangleTest::MollerTrumbore => {
                        intersect_triangle_unshared(origin, dir, corners)
                    }
                    TriangleTest::Watertight => shear.intersect(origin, corners),
                };
                hit.is_some_and(|hit| search.triangle(instance, (place, triangle.prim), hit))
            })
        };
        self.walk_mesh(row, (origin, dir), stack, leaf)
    }

    /// Offers the hit of a triangle, if it is not where the ray starts and not a hole.
    #[inline(always)]
    pub fn triangle(
        &mut self,
        (id, mesh, cutout): Met,
        (place, prim): (u32, u32),
        hit: TriangleHit,
    ) -> bool {
        let uv = [hit.u, hit.v];
        if self.probe.start == (Start { id, prim }) || hit.t > self.best.key.t {
            return false;
        }
        if cutout.is_some_and(|cutout| {
            cutout.is_hole(self.scene, mesh, &mesh.triangles[place as usize], uv)
        }) {
            return false;
        }
        self.offer(Key { t: hit.t, id, prim }, place, uv)
    }

    /// Visits the leaves of a mesh; the ray is the mesh's own.
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
#[inline(always)]
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
