//! The rows of all instances, kept from frame to frame, and the tree over them.
//!
//! What changed is packed anew. A camera that moves costs one pass over the rows, for they are relative to
//! the eye; the tree's boxes are about an anchor, an older eye, and are padded for every eye within reach
//! of it, so no tree is touched (rays are moved into the anchor's space instead, and given some slack).

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::dirty::DirtyRows;
use super::instance::{NOTHING, Packed, PaddedBox, Placed, instance_row};
use super::mesh::PackedMesh;
use super::users::Users;
use crate::bvh::{CHILD_NONE, InstanceTree, Node4, TreeAction, TreeWork};
use crate::frame::wire::{InstanceRow, KIND_PLANE, NONE};
use crate::frame::{FrameScene, Instance};
use crate::geom::Aabb;
use crate::world::Changes;

/// Rows that are worth a task of their own.
const ROWS_PER_TASK: usize = 2048;

/// One row in so many moving is most of them: fewer are followed along their paths.
const BUSY_SHARE: usize = 8;

/// Nodes that rays may have to keep of a tree that a device builds: it has at most 15 levels.
const DEVICE_STACK: u32 = 46;

/// Nodes that a tree over so many boxes may take, whoever builds it: all but one of the boxes need a node.
pub fn most_nodes(boxes: u32) -> u32 {
    boxes.saturating_sub(1).max(1)
}

/// See the module.
#[derive(Default)]
pub struct PackedInstances {
    /// Row for row those of the frame.
    pub rows: DirtyRows<InstanceRow>,
    placed: Vec<Placed>,
    padded: Vec<PaddedBox>,
    /// About the anchor; empty for what is in no tree.
    boxes: Vec<Aabb>,
    /// Rows of planes, ascending.
    planes: Vec<u32>,
    users: Users,
    /// Rows that name each material.
    material_uses: Vec<u32>,
    eye: DVec3,
    anchor: DVec3,
    /// How far the eye may be from the anchor.
    reach: f64,
    seen: u64,
    /// The tree over the boxes.
    tree: InstanceTree,
    /// What the last update did to it.
    work: TreeWork,
    /// Nodes that a device's copy of the tree lacks.
    stale_nodes: Vec<Range<u32>>,
    /// Rows from which a device builds the tree while most of them move.
    pub device_from: Option<usize>,
    /// The device's tree is one that it built; the one here is of an earlier frame.
    on_device: bool,
    /// The device is to build a tree over the boxes as they are.
    is_build_due: bool,
    /// Frames in a row in which most rows moved.
    busy_frames: u32,
}

impl PackedInstances {
    /// Brings rows and tree up to the frame, given the meshes that were built, refitted or moved.
    pub fn update(&mut self, scene: &FrameScene, meshes: &[PackedMesh], changed: &[u32]) {
        let eye = scene.view.origin;
        let rows = scene.instances.changes_since(self.seen);
        self.seen = scene.instances.version();
        let uses = scene.materials.len().max(self.material_uses.len());
        self.material_uses.resize(uses, 0);
        let is_other = rows == Changes::All;
        let touched = match rows {
            Changes::All => None,
            Changes::Rows(rows) => Some(self.with_users(rows, changed)),
            Changes::None => Some(self.with_users(&[], changed)),
        };
        // To pack all in order is cheaper than half of them by number.
        let touched = touched.filter(|touched| touched.len() * 2 <= scene.instances.len());
        match &touched {
            None => self.pack_all(scene, meshes),
            Some(touched) => self.pack_some(scene, meshes, touched),
        }
        if self.eye != eye {
            self.eye = eye;
            self.follow_eye();
        }
        // Not-a-number is far, too.
        let is_near = (eye - self.anchor).abs().max_element() <= self.reach;
        let moved = match touched {
            Some(touched) if is_near => Some(self.rebox(&touched)),
            None if is_near && !is_other => {
                self.rebox_all();
                None
            }
            _ => {
                self.drop_anchor();
                None
            }
        };
        self.work = self.follow(moved.as_deref());
    }

    /// Brings the tree up to the boxes, of which these changed, or any. Where most of many move, frame after
    /// frame, and a device keeps the tree, the device builds it, for which the boxes go over instead of nodes.
    fn follow(&mut self, moved: Option<&[u32]>) -> TreeWork {
        if self.on_device && moved.is_some_and(<[u32]>::is_empty) {
            return TreeWork::default();
        }
        let rows = self.boxes.len();
        let most_move = moved.is_none_or(|moved| moved.len() * BUSY_SHARE >= rows);
        self.busy_frames = if most_move {
            self.busy_frames.saturating_add(1)
        } else {
            0
        };
        let is_large = self.device_from.is_some_and(|from| rows >= from);
        if is_large && self.busy_frames > 1 {
            self.on_device = true;
            self.is_build_due = true;
            self.stale_nodes.clear();
            return TreeWork {
                action: TreeAction::Rebuild,
                rows: rows as u32,
                nodes: self.node_room(),
                ..TreeWork::default()
            };
        }
        let was_on_device = std::mem::take(&mut self.on_device);
        self.is_build_due = false;
        let moved = if was_on_device { None } else { moved };
        let work = self.tree.update(&self.boxes, moved);
        if was_on_device || work.action == TreeAction::Rebuild {
            self.lose_nodes();
        } else {
            self.stale_nodes.extend_from_slice(self.tree.dirty());
        }
        work
    }

    /// Nodes that a device needs room for; 0: there is no tree.
    pub fn node_room(&self) -> u32 {
        if self.on_device {
            most_nodes(self.boxes.len() as u32)
        } else {
            self.tree.nodes().len() as u32
        }
    }

    /// Nodes that a traversal of the tree may have to keep at once, at most.
    pub fn stack_bound(&self) -> u32 {
        if self.on_device {
            DEVICE_STACK
        } else {
            self.tree.stack_bound()
        }
    }

    /// Whether the device's tree is one that it built.
    pub fn is_on_device(&self) -> bool {
        self.on_device
    }

    /// The boxes of all rows if the device is to build a tree over them; from now on it has.
    pub fn take_boxes_to_build(&mut self) -> Option<&[Aabb]> {
        std::mem::take(&mut self.is_build_due).then_some(&self.boxes[..])
    }

    /// Boxes of all rows, about the anchor; empty for what is in no tree.
    pub fn boxes(&self) -> &[Aabb] {
        &self.boxes
    }

    /// Nodes of the tree over everything but planes, root first.
    #[inline]
    pub fn nodes(&self) -> &[Node4] {
        self.tree.nodes()
    }

    /// The leaf of the tree, if it has but one: a ray may begin there, and need not ask for its box.
    pub fn alone(&self) -> Option<u32> {
        match self.tree.nodes() {
            [root] if !self.on_device => {
                let mut children = root.children.into_iter().filter(|&slot| slot != CHILD_NONE);
                children.next().filter(|_| children.next().is_none())
            }
            _ => None,
        }
    }

    /// What the last update did to the tree.
    pub fn tree_work(&self) -> &TreeWork {
        &self.work
    }

    /// Tells the tree what tracing through it takes, against which it weighs its own upkeep.
    pub fn note_trace_time(&mut self, nanos: f64) {
        self.tree.trace_nanos = Some(nanos);
    }

    /// The nodes that a device's copy of the tree lacks; from now on it has them.
    pub fn take_stale_nodes(&mut self) -> Vec<Range<u32>> {
        std::mem::take(&mut self.stale_nodes)
    }

    /// A device has no copy of the tree any more.
    pub fn lose_nodes(&mut self) {
        self.stale_nodes.clear();
        if self.on_device {
            self.is_build_due = true;
            return;
        }
        self.stale_nodes.push(0..self.tree.nodes().len() as u32);
    }

    /// First row of the planes; the others follow by their links.
    pub fn first_plane(&self) -> u32 {
        self.planes.first().copied().unwrap_or(NONE)
    }

    /// The eye relative to the anchor.
    pub fn eye_from_anchor(&self) -> DVec3 {
        self.eye - self.anchor
    }

    fn with_users(&self, rows: &[u32], meshes: &[u32]) -> Vec<u32> {
        let users = meshes.iter().flat_map(|&mesh| {
            let shows = move |&&row: &&u32| {
                let row = self.rows.get(row as usize);
                row.is_some_and(|row| row.mesh == mesh)
            };
            self.users.of(mesh).iter().filter(shows)
        });
        rows.iter().chain(users).copied().collect()
    }

    /// Whether some row names a material for which this holds.
    pub fn any_material(&self, mut holds: impl FnMut(usize) -> bool) -> bool {
        let mut used = self.material_uses.iter().enumerate();
        used.any(|(material, &uses)| uses > 0 && holds(material))
    }

    fn resize(&mut self, count: usize) {
        let (vacant, nowhere, none) = NOTHING;
        self.rows.resize(count, vacant);
        self.placed.resize(count, nowhere);
        self.padded.resize(count, none);
        self.boxes.resize(count, Aabb::EMPTY);
    }

    /// Packs every row in place.
    fn pack_all(&mut self, scene: &FrameScene, meshes: &[PackedMesh]) {
        let is_longer_or_shorter = self.rows.len() != scene.instances.len();
        self.resize(scene.instances.len());
        let eye = self.eye;
        let pack = |(((row, placed), padded), instance): (
            ((&mut InstanceRow, &mut Placed), &mut PaddedBox),
            &Instance,
        )| {
            let old = *row;
            (*row, *placed, *padded) = pack(instance, meshes, eye);
            keep_link(row, &old);
            (old.kind, old.mesh, old.material) != (row.kind, row.mesh, row.material)
        };
        let is_restructured = self
            .rows
            .all_mut()
            .par_iter_mut()
            .with_min_len(ROWS_PER_TASK)
            .zip(&mut self.placed)
            .zip(&mut self.padded)
            .zip(&scene.instances[..])
            .map(pack)
            .reduce(|| false, |a, b| a | b);
        if is_restructured || is_longer_or_shorter {
            self.users.count(&self.rows);
            self.material_uses.fill(0);
            for row in self.rows.iter().filter(|row| row.kind != NONE) {
                self.material_uses[row.material as usize] += 1;
            }
            self.link_planes();
        }
    }

    fn pack_some(&mut self, scene: &FrameScene, meshes: &[PackedMesh], touched: &[u32]) {
        if touched.is_empty() {
            return;
        }
        self.resize(scene.instances.len());
        let eye = self.eye;
        let pack = |&row: &u32| pack(&scene.instances[row as usize], meshes, eye);
        // A pool takes longer to wake than a few rows to pack.
        let packed: Vec<Packed> = if touched.len() < ROWS_PER_TASK {
            touched.iter().map(pack).collect()
        } else {
            let rows = touched.par_iter().with_min_len(ROWS_PER_TASK);
            rows.map(pack).collect()
        };
        let mut planes_changed = false;
        for (&index, (mut row, placed, padded)) in touched.iter().zip(packed) {
            let i = index as usize;
            let old = self.rows[i];
            keep_link(&mut row, &old);
            planes_changed |= (old.kind == KIND_PLANE) != (row.kind == KIND_PLANE);
            if old.kind != NONE {
                self.material_uses[old.material as usize] -= 1;
            }
            if row.kind != NONE {
                self.material_uses[row.material as usize] += 1;
            }
            self.rows.set(i, row);
            if old.mesh != row.mesh {
                self.users.note(index, &self.rows);
            }
            self.placed[i] = placed;
            self.padded[i] = padded;
        }
        if planes_changed {
            self.link_planes();
        }
    }

    fn link_planes(&mut self) {
        let is_plane = |(row, packed): (usize, &InstanceRow)| {
            (packed.kind == KIND_PLANE).then_some(row as u32)
        };
        self.planes = self.rows.iter().enumerate().filter_map(is_plane).collect();
        for (i, &plane) in self.planes.iter().enumerate() {
            let link = self.planes.get(i + 1).copied().unwrap_or(NONE);
            let row = self.rows[plane as usize];
            self.rows.set(plane as usize, InstanceRow { link, ..row });
        }
    }

    /// One pass over the rows: what is relative to the eye.
    fn follow_eye(&mut self) {
        let eye = self.eye;
        self.rows
            .all_mut()
            .par_iter_mut()
            .with_min_len(ROWS_PER_TASK)
            .zip(&self.placed)
            .for_each(|(row, placed)| placed.place(row, eye));
    }

    /// Makes the eye the anchor. The eye may go as far from it as things are on average: boxes are padded
    /// for that reach, which so stays in proportion to what they hold.
    fn drop_anchor(&mut self) {
        let anchor = self.eye;
        let (sum, count) = self
            .placed
            .iter()
            .zip(&self.padded)
            .filter(|(_, padded)| padded.is_bounded())
            .fold((0.0, 0_u32), |(sum, count), (placed, _)| {
                (sum + placed.distance(anchor), count + 1)
            });
        let reach = sum / f64::from(count.max(1));
        (self.anchor, self.reach) = (anchor, reach);
        self.rebox_all();
    }

    fn rebox_all(&mut self) {
        let (anchor, reach) = (self.anchor, self.reach);
        self.boxes
            .par_iter_mut()
            .with_min_len(ROWS_PER_TASK)
            .zip(&self.placed)
            .zip(&self.padded)
            .for_each(|((bounds, placed), padded)| *bounds = padded.bounds(placed, anchor, reach));
    }

    /// Boxes of rows that changed; those whose box is another.
    fn rebox(&mut self, touched: &[u32]) -> Vec<u32> {
        let mut moved = Vec::new();
        for &row in touched {
            let i = row as usize;
            let bounds = self.padded[i].bounds(&self.placed[i], self.anchor, self.reach);
            if bounds != self.boxes[i] {
                self.boxes[i] = bounds;
                moved.push(row);
            }
        }
        moved
    }
}

fn pack(instance: &Instance, meshes: &[PackedMesh], eye: DVec3) -> Packed {
    let (mut row, placed, padded) = instance_row(instance, |mesh| &meshes[mesh as usize]);
    placed.place(&mut row, eye);
    (row, placed, padded)
}

/// Planes keep their place in the list; whoever comes or goes has it made anew.
fn keep_link(row: &mut InstanceRow, old: &InstanceRow) {
    if row.kind == KIND_PLANE {
        row.link = old.link;
    }
}
