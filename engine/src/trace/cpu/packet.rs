//! Rays that are much alike, sixty-four at a time: through both levels of trees as one beam, against triangles in lanes.
//!
//! After Overbeck, Ramamoorthi and Mark, "Large Ray Packets for Real-time Whitted Ray Tracing" (2008), with bounds in the
//! place of first active rays: a node costs the same for one ray and for all, and at leaves the groups of sixteen that miss
//! the box are left out. What a packet finds is, bit for bit, what [`trace`] finds for each ray (of hits that end a search,
//! which one depends on the order, but not whether there is one): boxes are only left out that no ray enters, triangles are
//! met by the same arithmetic, and hits are ordered by the same key. Where rays turn out not to be alike, they go on one by
//! one, from the best that was found.

use std::marker::PhantomData;

use glam::{Vec3, Vec4};

use super::beam::{Beam, Bounds, GROUPS};
use super::group::Group;
use super::query::{Found, Probe, Until};
use super::simd::{Floats, LANES, Mask, Simd, Work, lanes};
use super::stack::{Stack, push_nearest_last};
use super::traverse::{ORIGIN_SLACK, Search, is_plain, trace};
use super::triangles::{Fan, Local};
use crate::bvh::{CHILD_NONE, Child, Node4, TRAVERSAL_CAPACITY};
use crate::frame::wire::{InstanceRow, KIND_MESH, NONE, ROOT_OF_SPHERES};
use crate::trace::PackedScene;

/// The mask of all groups.
const ALL: u32 = (1 << GROUPS) - 1;
/// Rays of a packet, at most.
pub const PACKET: usize = GROUPS * LANES;
/// Fewer rays than these go one by one.
const LEAST_RAYS: usize = 6;
/// What a packet may cost before it is taken apart into groups, in nodes and tests of sixteen rays against a triangle.
const BUDGET: u32 = 700;
/// What a group may cost before its rays go one by one.
const GROUP_BUDGET: u32 = 220;

/// A node to visit: what it is, where the beam enters it, and the slot that it is in.
type Entry = (u32, f32, u32);

/// What packets are traced in; kept from packet to packet.
pub struct Packet {
    groups: [Group; GROUPS],
    /// Of each group, see [`Group::reach`].
    reach: Vec4,
    /// The least of lower ends.
    from: f32,
    /// What may still be spent.
    left: u32,
    entries: [Entry; TRAVERSAL_CAPACITY as usize],
    len: usize,
    /// The groups in the space of a mesh.
    local: [Local; GROUPS],
}

impl Default for Packet {
    fn default() -> Self {
        Self {
            groups: [const { Group::EMPTY }; GROUPS],
            reach: Vec4::ZERO,
            from: 0.0,
            left: 0,
            entries: [(0, 0.0, 0); TRAVERSAL_CAPACITY as usize],
            len: 0,
            local: [const { Local::EMPTY }; GROUPS],
        }
    }
}

/// [`trace`] of each of some rays, at most [`PACKET`]; their lower and upper ends must be ends of distances
/// ([`super::query::Key::after`], [`super::query::Key::before`]).
pub fn trace_all<U: Until>(
    scene: &PackedScene,
    probes: &[Probe],
    found: &mut [Option<Found>],
    (packet, stack): (&mut Packet, &mut Stack),
) {
    if probes.len() < LEAST_RAYS || !is_plain(scene) || !are_alike(probes) {
        for (probe, found) in probes.iter().zip(found) {
            *found = trace::<U>(scene, probe, stack);
        }
        return;
    }
    packet.load(probes);
    if !packet.walk::<U>(scene, stack, BUDGET) {
        let rest = packet.take_active();
        for (group, rest) in rest.into_iter().enumerate() {
            packet.groups[group].active = rest;
            if rest.count_ones() as usize >= LEAST_RAYS {
                packet.walk::<U>(scene, stack, GROUP_BUDGET);
            }
            packet.finish::<U>(scene, stack, group);
        }
    }
    for (ray, place) in found.iter_mut().enumerate() {
        let (group, lane) = (&packet.groups[ray / LANES], ray % LANES);
        *place = (group.hit & 1 << lane != 0).then(|| group.found(lane));
    }
}

/// Whether directions are near each other, and nothing is in a ray that would leave the bounds of all without meaning.
fn are_alike(probes: &[Probe]) -> bool {
    // 3.6 degrees. With 20 instead, a sixth to a quarter of the rate of shadow and mirrored rays was lost to packets that
    // were taken apart later.
    const LEAST_COSINE: f32 = 0.998;
    let first = probes[probes.len() / 2].dir;
    let limit = LEAST_COSINE * LEAST_COSINE * first.length_squared();
    probes.iter().all(|probe| {
        let is_finite = probe.origin.is_finite() && probe.dir.is_finite();
        let cosine = first.dot(probe.dir);
        is_finite && cosine > 0.0 && cosine * cosine >= limit * probe.dir.length_squared()
    })
}

impl Packet {
    /// Whether all was searched within what it may cost; then no ray is active any more.
    fn walk<U: Until>(&mut self, scene: &PackedScene, stack: &mut Stack, budget: u32) -> bool {
        self.left = budget;
        self.len = 0;
        let instructions = stack.instructions;
        let is_done = instructions.run(Walk::<U> {
            purpose: PhantomData,
            scene,
            packet: self,
            stack,
        });
        if is_done {
            self.take_active();
        }
        is_done
    }

    /// Ends all searches; which lanes were active.
    fn take_active(&mut self) -> [Mask; GROUPS] {
        let mut active = [0; GROUPS];
        for (active, group) in active.iter_mut().zip(&mut self.groups) {
            *active = std::mem::take(&mut group.active);
        }
        active
    }

    /// Searches by itself for each ray of a group that is active still, from the best that it has.
    fn finish<U: Until>(&mut self, scene: &PackedScene, stack: &mut Stack, group: usize) {
        let group = &mut self.groups[group];
        for lane in lanes(std::mem::take(&mut group.active)) {
            if let Some(found) = trace::<U>(scene, &group.probe(lane), stack) {
                group.take(lane, &found);
            }
        }
    }

    fn load(&mut self, probes: &[Probe]) {
        self.from = probes
            .iter()
            .map(|p| p.after.t)
            .fold(f32::INFINITY, f32::min);
        for (i, group) in self.groups.iter_mut().enumerate() {
            group.has_starts = false;
            group.hit = 0;
            group.active = 0;
            for lane in 0..LANES {
                // Lanes without a ray repeat one, so that bounds are of rays alone.
                let ray = i * LANES + lane;
                group.set(lane, &probes[ray.min(probes.len() - 1)]);
                group.active |= Mask::from(ray < probes.len()) << lane;
            }
            group.triangle = [f32::from_bits(NONE); LANES];
            group.uv = [[0.0; LANES]; 2];
        }
    }
}

/// A packet on its way through a scene.
struct Walk<'a, U> {
    purpose: PhantomData<U>,
    scene: &'a PackedScene,
    packet: &'a mut Packet,
    stack: &'a mut Stack,
}

impl<U: Until> Work for Walk<'_, U> {
    /// Whether all was searched; else active rays are to go on by themselves.
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> bool {
        self.note_reach(simd);
        if self.scene.view.first_plane != NONE {
            self.one_by_one(ALL, |search, _| search.planes());
            self.note_reach(simd);
        }
        let nodes = self.scene.instance_nodes();
        if nodes.is_empty() {
            return true;
        }
        let offset = Vec3::from(self.scene.view.eye_from_anchor);
        let mut bounds = [Bounds::NOTHING; GROUPS];
        for (bounds, group) in bounds.iter_mut().zip(&self.packet.groups) {
            if group.active == 0 {
                continue;
            }
            let mut origin = group.origin;
            let mut slack = Vec3::ZERO;
            for axis in 0..3 {
                let here = simd.load(&origin[axis]);
                let size = here.greatest().max(-here.least());
                slack[axis] = (size + offset[axis].abs()) * ORIGIN_SLACK;
                (here + simd.splat(offset[axis])).store(&mut origin[axis]);
            }
            *bounds = Bounds::of(simd, &origin, slack, &group.dir);
        }
        let beam = Beam::new(&bounds);
        self.visit(
            simd,
            nodes,
            (&beam, ALL),
            #[inline(always)]
            |walk, index, _, groups| walk.instance(simd, index, groups),
        )
    }
}

impl<'a, U: Until> Walk<'a, U> {
    #[inline(always)]
    fn note_reach<S: Simd>(&mut self, simd: S) {
        let [a, b, c, d] = &self.packet.groups;
        self.packet.reach = Vec4::new(a.reach(simd), b.reach(simd), c.reach(simd), d.reach(simd));
    }

    /// Visits the leaves that some ray of the groups that a beam is of may have a hit in, nearest box first; `leaf` gets first, count and groups, and says
    /// whether to go on. Whether all was visited.
    #[inline(always)]
    fn visit<S: Simd>(
        &mut self,
        _: S,
        nodes: &[Node4],
        (beam, of_beam): (&Beam, u32),
        leaf: impl Fn(&mut Self, u32, u32, u32) -> bool,
    ) -> bool {
        let base = self.packet.len;
        let mut next = Some((Child::Node(0).encode(), NONE));
        loop {
            let (child, at) = match next.take() {
                Some(next) => next,
                None if self.packet.len == base => break,
                None => {
                    self.packet.len -= 1;
                    let (child, near, at) = self.packet.entries[self.packet.len];
                    if near > self.packet.reach.max_element() {
                        continue;
                    }
                    (child, at)
                }
            };
            match Child::decode(child) {
                Child::None => {}
                Child::Leaf { first, count } => {
                    let (node, slot) = (&nodes[at as usize / 4], at as usize % 4);
                    let (from, reach) = (self.packet.from, self.packet.reach);
                    let groups = of_beam & beam.groups_entering(node, slot, from, reach);
                    if groups != 0 && !leaf(self, first, count, groups) {
                        return false;
                    }
                }
                Child::Node(index) => {
                    if self.packet.left == 0 {
                        return false;
                    }
                    self.packet.left -= 1;
                    let most = self.packet.reach.max_element();
                    let node = &nodes[index as usize];
                    let (near, entered) = beam.enter(node, (self.packet.from, most));
                    next = self.push(node, index, near, entered);
                }
            }
        }
        true
    }

    /// As for a single ray, see [`super::traverse`].
    #[inline(always)]
    fn push(&mut self, node: &Node4, index: u32, near: Vec4, entered: u32) -> Option<(u32, u32)> {
        let packet = &mut *self.packet;
        let children =
            (0..4).filter(|&slot| entered & (1 << slot) != 0 && node.children[slot] != CHILD_NONE);
        let entries = children.map(|slot| {
            let at = 4 * index + slot as u32;
            (node.children[slot], near[slot], at)
        });
        let base = packet.len;
        for entry in entries {
            push_nearest_last(&mut packet.entries, base, &mut packet.len, entry, |e| e.1);
        }
        (packet.len > base).then(|| {
            packet.len -= 1;
            let (child, _, at) = packet.entries[packet.len];
            (child, at)
        })
    }

    /// Searches by itself for each active lane of some groups.
    #[inline(always)]
    fn one_by_one(
        &mut self,
        groups: u32,
        mut search: impl FnMut(&mut Search<'_, U>, &mut Stack) -> bool,
    ) {
        for (number, group) in self.packet.groups.iter_mut().enumerate() {
            if groups & 1 << number == 0 {
                continue;
            }
            for lane in lanes(group.active) {
                let probe = group.probe(lane);
                let mut alone = Search::new(self.scene, &probe);
                let is_over = search(&mut alone, self.stack);
                if let Some(found) = alone.found() {
                    group.take(lane, &found);
                }
                if is_over {
                    group.active &= !(1 << lane);
                }
            }
        }
    }

    /// Whether to go on.
    #[inline(always)]
    fn instance<S: Simd>(&mut self, simd: S, index: u32, groups: u32) -> bool {
        let row = &self.scene.instances()[index as usize];
        if row.kind == KIND_MESH && row.root & ROOT_OF_SPHERES == 0 {
            return self.mesh(simd, index, row, groups);
        }
        self.one_by_one(groups, |search, stack| search.instance(simd, index, stack));
        self.note_reach(simd);
        true
    }

    /// Whether to go on.
    #[inline(always)]
    fn mesh<S: Simd>(&mut self, simd: S, id: u32, row: &InstanceRow, groups: u32) -> bool {
        let mut bounds = [Bounds::NOTHING; GROUPS];
        let mut axes = None;
        let mut are_one = true;
        for number in lanes(groups as Mask) {
            let (group, local) = (&self.packet.groups[number], &mut self.packet.local[number]);
            let of_group = local.enter(simd, group, row);
            are_one &= of_group.is_some() && (axes.is_none() || axes == of_group);
            axes = of_group;
            bounds[number] = Bounds::of(simd, &local.origin, Vec3::ZERO, &local.dir);
        }
        let beam = Beam::new(&bounds);
        let Some(axes) = axes.filter(|_| are_one && beam.is_one_way) else {
            self.one_by_one(groups, |search, stack| search.instance(simd, id, stack));
            self.note_reach(simd);
            return true;
        };
        let mesh = self.scene.mesh(row);
        let scene = self.scene;
        let fan = Fan::<U>::new(scene, mesh, id, row, axes);
        self.visit(
            simd,
            mesh.nodes(),
            (&beam, groups),
            #[inline(always)]
            |walk, first, count, groups| {
                let packet = &mut *walk.packet;
                for number in lanes(groups as Mask) {
                    let (group, local) = (&mut packet.groups[number], &packet.local[number]);
                    packet.left = packet.left.saturating_sub(count);
                    if fan.meet(simd, group, local, first..first + count) {
                        packet.reach[number] = group.reach(simd);
                    }
                }
                true
            },
        )
    }
}
