//! Trees to compare with: two children a node, the bounding spheres of the 2008 report, and no culling at
//! all. All are [`Node4`]s, so that one walk serves them; [`Bounds`] says how to read a slot.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::binary::by_medians;
use super::build::{MESH_LEAF, balanced};
use super::collapse::collapse;
use super::{CHILD_NONE, Child, Extent, Node4, Tree};
use crate::geom::Aabb;

/// What the slots of a tree's nodes hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Bounds {
    /// Boxes.
    #[default]
    Boxes,
    /// Spheres: the centre in `min_x`, `min_y`, `min_z`, the radius in `max_x` (below 0: no child), 0 in
    /// `max_y` and `max_z`. The radius covers the rounding of the centre, not that of a test against it.
    Spheres,
    /// Boxes so large that every ray enters.
    Unbounded,
}

/// Half a side of a box that every ray enters, short of overflow in the slab test of most rays.
const BOUNDLESS: f32 = 1e30;

impl Tree {
    /// A tree of boxes with two children a node; otherwise as [`Tree::build`].
    pub fn build_binary(boxes: &[Aabb]) -> Self {
        Self::of_width(boxes, MESH_LEAF, 2)
    }

    /// The tree of the 2008 report: primitives split evenly in halves along the widest axis of their box
    /// until at most `leaf` (1 to 8) are left, and around each part the sphere over the diagonal of its box.
    pub fn build_spheres(boxes: &[Aabb], leaf: u32) -> Self {
        if boxes.is_empty() {
            return Self {
                bounds: Bounds::Spheres,
                ..Self::default()
            };
        }
        let (binary, prims) = by_medians(boxes, leaf.clamp(1, Child::MAX_LEAF));
        let mut tree = collapse(&binary, prims, 1, 2);
        tree.bounds = Bounds::Spheres;
        let prims = std::mem::take(&mut tree.prims);
        tree.refit(|place| boxes[prims[place] as usize].into());
        tree.prims = prims;
        tree
    }

    /// A tree over so many primitives that culls none, in their order.
    pub fn unculled(count: u32) -> Self {
        if count == 0 {
            return Self {
                bounds: Bounds::Unbounded,
                ..Self::default()
            };
        }
        let point = Aabb {
            min: glam::Vec3::ZERO,
            max: glam::Vec3::ZERO,
        };
        let mut tree = balanced(&vec![point; count as usize], Child::MAX_LEAF, 4);
        tree.bounds = Bounds::Unbounded;
        let boundless = Aabb {
            min: glam::Vec3::splat(-BOUNDLESS),
            max: glam::Vec3::splat(BOUNDLESS),
        };
        for node in &mut tree.nodes {
            for slot in 0..4 {
                if node.children[slot] != CHILD_NONE {
                    node.set_child(slot, &boundless, Child::decode(node.children[slot]));
                }
            }
        }
        tree
    }

    /// [`Tree::refit`] of spheres, each over the box of all that is below it.
    pub(super) fn refit_spheres(&mut self, slot_box: impl Fn(usize) -> Extent) -> f32 {
        let mut contents = vec![Extent::EMPTY; self.nodes.len()];
        for index in (0..self.nodes.len()).rev() {
            for slot in 0..4 {
                let content = match Child::decode(self.nodes[index].children[slot]) {
                    Child::None => Extent::EMPTY,
                    Child::Node(child) => contents[child as usize],
                    Child::Leaf { first, count } => (first as usize..(first + count) as usize)
                        .fold(Extent::EMPTY, |all, place| all.union(slot_box(place))),
                };
                self.nodes[index].set_sphere(slot, content.into());
                contents[index] = contents[index].union(content);
            }
        }
        self.cost_of_spheres()
    }

    /// [`Tree::cost`] of spheres: their areas go by the squares of their radii. The root's is that over the
    /// box around its children's.
    pub(super) fn cost_of_spheres(&self) -> f32 {
        let Some(root) = self.nodes.first() else {
            return 0.0;
        };
        let children = (0..4)
            .map(|slot| root.child_sphere(slot))
            .filter(|(_, radius)| *radius >= 0.0);
        let around = children.fold(Aabb::EMPTY, |all, (center, radius)| {
            all.union(Aabb {
                min: center - radius,
                max: center + radius,
            })
        });
        let (_, radius) = sphere_over(around);
        let mut sum = 0.0;
        for node in &self.nodes {
            for (slot, &child) in node.children.iter().enumerate() {
                sum += f64::from(node.max_x[slot].max(0.0)).powi(2) * weight(child);
            }
        }
        (sum / f64::from(radius).powi(2)) as f32
    }

    /// [`Tree::cost`] when everything is visited.
    pub(super) fn cost_of_everything(&self) -> f32 {
        let slots = self.nodes.iter().flat_map(|node| node.children);
        slots.map(weight).sum::<f64>() as f32
    }
}

/// What is visited in a slot that a ray enters.
fn weight(child: u32) -> f64 {
    match Child::decode(child) {
        Child::None => 0.0,
        Child::Node(_) => 1.0,
        Child::Leaf { count, .. } => f64::from(count),
    }
}

impl Node4 {
    /// The sphere of a slot: centre and radius.
    pub fn child_sphere(&self, slot: usize) -> (glam::Vec3, f32) {
        let center = glam::Vec3::new(self.min_x[slot], self.min_y[slot], self.min_z[slot]);
        (center, self.max_x[slot])
    }

    /// Puts the sphere over a box into a slot.
    fn set_sphere(&mut self, slot: usize, content: Aabb) {
        let (center, radius) = sphere_over(content);
        [self.min_x[slot], self.min_y[slot], self.min_z[slot]] = center.to_array();
        (self.max_x[slot], self.max_y[slot], self.max_z[slot]) = (radius, 0.0, 0.0);
    }
}

/// The sphere over the diagonal of a box, its radius such that the box is inside for the centre as rounded;
/// a radius of -1 for an empty box.
fn sphere_over(content: Aabb) -> (glam::Vec3, f32) {
    if content.is_empty() {
        return (glam::Vec3::ZERO, -1.0);
    }
    let center = content.min + (content.max - content.min) * 0.5;
    (center, (farthest(center, content) as f32).next_up())
}

/// How far the farthest corner of a box is from a point. The error of f64 is far below the ulp of f32 that
/// is added to it.
fn farthest(from: glam::Vec3, content: Aabb) -> f64 {
    let from = from.as_dvec3();
    let reach = (content.max.as_dvec3() - from).max(from - content.min.as_dvec3());
    reach.max(DVec3::ZERO).length()
}

/// Whether a slot of a node bounds what is in it, all of it (exact compare).
pub(super) fn bounds_content(node: &Node4, slot: usize, content: &Aabb, bounds: Bounds) -> bool {
    match bounds {
        Bounds::Boxes | Bounds::Unbounded => node.child_box(slot).contains(content),
        Bounds::Spheres => {
            let (center, radius) = node.child_sphere(slot);
            farthest(center, *content) <= f64::from(radius)
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::bvh::build::STACK_SHARE;
    use crate::testing::boxes;

    fn children(node: &Node4) -> usize {
        node.children
            .iter()
            .filter(|&&child| child != CHILD_NONE)
            .count()
    }

    #[test]
    fn every_structure_holds_its_invariants_before_and_after_refits() {
        for count in [0, 1, 2, 3, 9, 64, 1000, 5000] {
            for shift in [0.0, -1e-12, 1e6] {
                let before = boxes(count, 50.0, shift, 1);
                let after = boxes(count, 50.0, shift, 2);
                let trees = [
                    Tree::build(&before),
                    Tree::build_binary(&before),
                    Tree::build_spheres(&before, 1),
                    Tree::build_spheres(&before, 8),
                    Tree::unculled(count as u32),
                ];
                for mut tree in trees {
                    let kind = tree.bounds;
                    tree.validate(&before)
                        .unwrap_or_else(|e| panic!("{count} {kind:?}: {e}"));
                    assert!(tree.stack_need() <= STACK_SHARE, "{}", tree.stack_need());
                    let prims = tree.prims.clone();
                    let cost = tree.refit(|place| after[prims[place] as usize].into());
                    tree.validate(&after)
                        .unwrap_or_else(|e| panic!("{count} {kind:?}: {e}"));
                    assert!(
                        (cost - tree.cost()).abs() <= 1e-5 * cost,
                        "{cost} for {}",
                        tree.cost()
                    );
                }
            }
        }
    }

    /// Deforms a strip of triangles at random for so many frames, under every structure.
    fn deform(frames: u32) {
        let corner = |i: u32, seed: u32| {
            let hash = (i ^ seed << 8).wrapping_mul(0x9e37_79b9);
            let part = |shift: u32| (hash.rotate_left(shift) >> 8) as f32 / 16_777_216.0 - 0.5;
            Vec3::new(i as f32 * 0.1 + part(0), part(9), part(20)) * 3.0
        };
        let boxes = |seed: u32| -> Vec<Aabb> {
            let triangle = |i: u32| Aabb::of((i..i + 3).map(|i| corner(i, seed)));
            (0..70).map(triangle).collect()
        };
        let start = boxes(0);
        let mut trees = [
            Tree::build(&start),
            Tree::build_binary(&start),
            Tree::build_spheres(&start, 3),
            Tree::unculled(70),
        ];
        for frame in 0..frames {
            let boxes = boxes(frame);
            for tree in &mut trees {
                let prims = std::mem::take(&mut tree.prims);
                tree.refit(|place| boxes[prims[place] as usize].into());
                tree.prims = prims;
                let valid = tree.validate(&boxes);
                valid.unwrap_or_else(|e| panic!("frame {frame}, {:?}: {e}", tree.bounds));
            }
        }
    }

    #[test]
    fn every_primitive_stays_inside_through_deformations() {
        deform(3000);
    }

    /// Run it with `cargo test --release --workspace --lib hundred_thousand -- --ignored`.
    #[test]
    #[ignore = "takes long"]
    fn every_primitive_stays_inside_through_a_hundred_thousand_deformations() {
        deform(100_000);
    }

    #[test]
    fn two_children_a_node_are_two() {
        let boxes = boxes(1000, 50.0, 0.0, 3);
        for tree in [Tree::build_binary(&boxes), Tree::build_spheres(&boxes, 4)] {
            assert!(tree.nodes.iter().all(|node| children(node) == 2));
        }
    }

    #[test]
    fn the_tree_of_the_report_is_balanced_and_keeps_its_threshold() {
        let tree = Tree::build_spheres(&boxes(1000, 50.0, 0.0, 4), 5);
        for slot in tree.nodes.iter().flat_map(|node| node.children) {
            if let Child::Leaf { count, .. } = Child::decode(slot) {
                assert!((3..=5).contains(&count), "{count}");
            }
        }
        assert_eq!(tree.depth(), 8);
    }

    #[test]
    fn a_sphere_that_is_too_small_is_found() {
        let boxes = boxes(100, 50.0, 0.0, 5);
        let mut tree = Tree::build_spheres(&boxes, 2);
        tree.nodes[0].max_x[1] *= 0.999;
        assert!(tree.validate(&boxes).is_err());
    }
}
