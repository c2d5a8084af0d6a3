//! A walk through one tree that counts nodes: the tracers' order of visits, nearest child first.
//!
//! The benchmarks hold trees against one another with it: the same walk and the same leaves, so whatever
//! differs is the trees'.

use glam::{Vec3, Vec4};
use orrery_engine::bvh::{CHILD_NONE, Child, Node4};
use orrery_engine::geom::{FAR_WIDENING, SlabRay};
use orrery_engine::trace::Ray;

/// Keeps its stack from ray to ray, and counts.
#[derive(Debug, Default)]
pub struct Walker {
    stack: Vec<(u32, f32)>,
    /// Nodes visited by all rays so far.
    pub nodes: u64,
}

impl Walker {
    /// Calls `leaf` with first and count of every leaf whose box the ray enters before `reach`; `leaf`
    /// returns the new reach.
    pub fn walk(
        &mut self,
        nodes: &[Node4],
        ray: &Ray,
        mut reach: f32,
        mut leaf: impl FnMut(u32, u32, f32) -> f32,
    ) {
        if nodes.is_empty() {
            return;
        }
        let slab = SlabRay::new(ray.origin, ray.dir);
        self.stack.clear();
        self.stack.push((Child::Node(0).encode(), 0.0));
        while let Some((slot, near)) = self.stack.pop() {
            if near > widened(reach) {
                continue;
            }
            match Child::decode(slot) {
                Child::None => {}
                Child::Leaf { first, count } => reach = leaf(first, count, reach),
                Child::Node(node) => {
                    self.nodes += 1;
                    self.push_children(&nodes[node as usize], &slab, widened(reach));
                }
            }
        }
    }

    /// Slab test of four children; those entered go on the stack, farthest first.
    #[inline]
    fn push_children(&mut self, node: &Node4, slab: &SlabRay, reach: f32) {
        let axis = |min: &[f32; 4], max: &[f32; 4], axis: usize| {
            let inverse = slab.inverse[axis];
            let least = (Vec4::from(*min) - slab.from_least[axis]) * inverse;
            let greatest = (Vec4::from(*max) - slab.from_greatest[axis]) * inverse;
            (least.min(greatest), least.max(greatest))
        };
        let (near_x, far_x) = axis(&node.min_x, &node.max_x, 0);
        let (near_y, far_y) = axis(&node.min_y, &node.max_y, 1);
        let (near_z, far_z) = axis(&node.min_z, &node.max_z, 2);
        let near = near_x.max(near_y).max(near_z.max(Vec4::ZERO));
        let far = far_x.min(far_y).min(far_z) * FAR_WIDENING;
        let base = self.stack.len();
        for slot in 0..4 {
            let child = node.children[slot];
            if child != CHILD_NONE && near[slot] <= far[slot].min(reach) {
                let place = self.stack[base..].partition_point(|entry| entry.1 >= near[slot]);
                self.stack.insert(base + place, (child, near[slot]));
            }
        }
    }
}

/// How far a box may begin and still hold a hit at `reach`, ties included.
fn widened(reach: f32) -> f32 {
    reach * (1.0 + 8.0 * f32::EPSILON)
}

/// A ray without an end.
pub fn ray(origin: Vec3, dir: Vec3) -> Ray {
    Ray {
        origin,
        dir: dir.normalize(),
        t_min: 0.0,
        t_max: f32::MAX,
    }
}
