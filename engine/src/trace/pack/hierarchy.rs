//! Levels of the packed trees as volumes in the world, for the display of hierarchies.
//!
//! Called where somebody looks at a level, by [`super::PackedScene::hierarchy`]; what it costs goes by the
//! volumes of the level, and for meshes that a device deforms by their triangles: the device's boxes are
//! computed here again.

use std::collections::HashMap;

use glam::Vec3;

use super::mesh::PackedMesh;
use super::{PackedScene, ViewRow};
use crate::bvh::{Bounds, Child, Node4};
use crate::frame::wire::{InstanceRow, KIND_MESH, PROJECTION_PERSPECTIVE};
use crate::geom::{Aabb, AffineRows};
use crate::trace::{Form, Hierarchy, Level, Owner, Volume};

/// Volumes of instances that are looked at, the nearest instances' first: a second's worth and no more,
/// however many instances a large mesh has.
const MOST_LOOKED_AT: usize = 1 << 20;

/// A volume in the space of its tree.
#[derive(Clone, Copy, Debug)]
struct Local {
    center: Vec3,
    half: Vec3,
    form: Form,
}

impl PackedScene {
    /// The volumes of a level of all trees, or of the tree of one instance's mesh if it shows one; see
    /// [`crate::trace::Tracer::hierarchy`].
    pub fn hierarchy(&self, level: Level, alone: Option<u32>, most: usize) -> Hierarchy {
        let mut view = InView::new(&self.view, most);
        let alone = alone.filter(|&row| self.has_tree(row));
        if alone.is_none() {
            self.add_instance_tree(level, &mut view);
        }
        let rows = match alone {
            Some(row) => vec![row],
            None => self.mesh_rows_by_size(&view),
        };
        let mut levels: HashMap<u32, Vec<Local>> = HashMap::new();
        let mut looked_at = 0;
        for row in rows {
            let instance = &self.instances()[row as usize];
            let volumes = levels
                .entry(instance.mesh)
                .or_insert_with(|| level_of_mesh(self.mesh(instance), level));
            view.count(volumes);
            looked_at += volumes.len();
            if looked_at > MOST_LOOKED_AT {
                view.found.is_cut = true;
                continue;
            }
            for local in volumes {
                view.add(local.placed(&instance.world_from_local, Owner::Mesh(row)));
            }
        }
        view.finish()
    }

    fn has_tree(&self, row: u32) -> bool {
        let row = self.instances().get(row as usize);
        row.is_some_and(|row| row.kind == KIND_MESH)
    }

    /// Its boxes are about the anchor of the packed instances.
    fn add_instance_tree(&self, level: Level, view: &mut InView) {
        let leaves;
        let volumes = if !self.instances.is_on_device() {
            level_of_nodes(self.instance_nodes(), level, Bounds::Boxes)
        } else if level == Level::Leaves {
            leaves = self.instances.boxes().iter();
            leaves.filter(|b| !b.is_empty()).map(Local::of).collect()
        } else {
            view.found.lacks = Some("the tree over instances is the device's and not among them");
            return;
        };
        let eye = self.instances.eye_from_anchor().as_vec3();
        view.count(&volumes);
        for local in volumes {
            view.add(Volume {
                center: local.center - eye,
                axes: Vec3::AXES.map(|axis| axis * local.half),
                form: local.form,
                owner: Owner::Instances,
            });
        }
    }

    /// Rows that show meshes, the largest as seen first, those out of view last.
    fn mesh_rows_by_size(&self, view: &InView) -> Vec<u32> {
        let mut rows: Vec<(f32, u32)> = (0..self.instances().len() as u32)
            .filter(|&row| self.has_tree(row))
            .map(|row| {
                (
                    view.size(&self.around(&self.instances()[row as usize])),
                    row,
                )
            })
            .collect();
        rows.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        rows.into_iter().map(|(_, row)| row).collect()
    }

    fn around(&self, row: &InstanceRow) -> Volume {
        let local = Local::of(&self.mesh(row).bounds);
        local.placed(&row.world_from_local, Owner::Instances)
    }
}

impl Local {
    fn of(bounds: &Aabb) -> Self {
        let half = (bounds.max - bounds.min) * 0.5;
        Self {
            center: bounds.min + half,
            half,
            form: Form::Box,
        }
    }

    fn of_slot(node: &Node4, slot: usize, bounds: Bounds) -> Self {
        match bounds {
            Bounds::Boxes | Bounds::Unbounded => Self::of(&node.child_box(slot)),
            Bounds::Spheres => {
                let (center, radius) = node.child_sphere(slot);
                Self {
                    center,
                    half: Vec3::splat(radius),
                    form: Form::Sphere,
                }
            }
        }
    }

    fn placed(&self, world_from_local: &AffineRows, owner: Owner) -> Volume {
        Volume {
            center: world_from_local.point(self.center),
            axes: Vec3::AXES.map(|axis| world_from_local.vector(axis * self.half)),
            form: self.form,
            owner,
        }
    }
}

/// A level of a mesh's tree as rays meet it. Without a tree every ray meets every triangle: those are its
/// leaves, and there are no levels.
fn level_of_mesh(mesh: &PackedMesh, level: Level) -> Vec<Local> {
    let tree = mesh.tree_as_traced();
    match (tree.bounds, level) {
        (Bounds::Unbounded, Level::Depth(_)) => Vec::new(),
        (Bounds::Unbounded, Level::Leaves) => {
            let triangles = mesh.triangles.iter();
            let boxes = triangles.map(|triangle| Aabb::of(mesh.corners(triangle)));
            boxes.map(|bounds| Local::of(&bounds)).collect()
        }
        (bounds, level) => level_of_nodes(&tree.nodes, level, bounds),
    }
}

/// Slots of a level, node by node from the root down.
fn level_of_nodes(nodes: &[Node4], level: Level, bounds: Bounds) -> Vec<Local> {
    let mut found = Vec::new();
    let mut parents: Vec<u32> = (0..nodes.len().min(1) as u32).collect();
    let mut depth = 1;
    while !parents.is_empty() && !matches!(level, Level::Depth(wanted) if depth > wanted) {
        let mut children = Vec::new();
        for &parent in &parents {
            let node = &nodes[parent as usize];
            for (slot, &child) in node.children.iter().enumerate() {
                let child = Child::decode(child);
                let is_leaf = matches!(child, Child::Leaf { .. });
                if let Child::Node(child) = child {
                    children.push(child);
                }
                let is_wanted = match level {
                    Level::Depth(wanted) => depth == wanted && child != Child::None,
                    Level::Leaves => is_leaf,
                };
                if is_wanted {
                    found.push(Local::of_slot(node, slot, bounds));
                }
            }
        }
        parents = children;
        depth += 1;
    }
    found
}

/// What of the volumes is seen, as long as there are not too many.
struct InView {
    forward: Vec3,
    /// Spans of half the picture, at distance 1 if in perspective.
    halves: [Vec3; 2],
    is_perspective: bool,
    most: usize,
    sized: Vec<(f32, Volume)>,
    found: Hierarchy,
}

impl InView {
    fn new(view: &ViewRow, most: usize) -> Self {
        let right = Vec3::from(view.right_step) * view.width as f32;
        let up = Vec3::from(view.up_step) * view.height as f32;
        Self {
            forward: view.forward.into(),
            halves: [right, up],
            is_perspective: view.projection == PROJECTION_PERSPECTIVE,
            most,
            sized: Vec::new(),
            found: Hierarchy::default(),
        }
    }

    /// How large a volume looks; 0: it is out of view.
    fn size(&self, volume: &Volume) -> f32 {
        let (center, radius) = (volume.center, volume.radius());
        let depth = center.dot(self.forward);
        let is_aside = |half: Vec3| {
            let length = half.length();
            let across = (center.dot(half) / length).abs();
            // Distance from the plane through the picture's edge, and the eye if in perspective.
            if self.is_perspective {
                across - depth * length > radius * (1.0 + length * length).sqrt()
            } else {
                across - length > radius
            }
        };
        if depth + radius <= 0.0 || self.halves.into_iter().any(is_aside) {
            0.0
        } else if self.is_perspective {
            radius / center.length().max(radius)
        } else {
            radius
        }
    }

    fn count(&mut self, volumes: &[Local]) {
        let spheres = volumes.iter().filter(|v| v.form == Form::Sphere).count();
        self.found.spheres += spheres;
        self.found.boxes += volumes.len() - spheres;
    }

    /// Keeps a volume if it is in view, for as long as there are no larger ones.
    fn add(&mut self, volume: Volume) {
        let size = self.size(&volume);
        if size > 0.0 {
            self.sized.push((size, volume));
            // Twice as many before the smaller half goes: a constant price each.
            if self.sized.len() > 2 * self.most {
                self.cut();
            }
        }
    }

    fn cut(&mut self) {
        if self.sized.len() > self.most {
            self.sized
                .select_nth_unstable_by(self.most, |a, b| b.0.total_cmp(&a.0));
            self.sized.truncate(self.most);
            self.found.is_cut = true;
        }
    }

    fn finish(mut self) -> Hierarchy {
        self.cut();
        self.found.volumes = self.sized.into_iter().map(|(_, volume)| volume).collect();
        self.found
    }
}

#[cfg(test)]
mod tests;
