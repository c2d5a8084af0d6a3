//! A walk through one tree that counts nodes: the tracers' order of visits, nearest child first.
//!
//! The benchmarks hold trees against one another with it: the same walk and the same leaves, so whatever
//! differs is the trees'.

use glam::{Vec3, Vec4};
use orrery_engine::bvh::{Bounds, CHILD_NONE, Child, Node4};
use orrery_engine::geom::SlabRay;
use orrery_engine::trace::Ray;
use orrery_engine::trace::cpu::{enter_boxes, enter_spheres};

/// Keeps its stack from ray to ray, and counts.
#[derive(Debug, Default)]
pub struct Walker {
    stack: Vec<(u32, f32)>,
    /// Nodes visited by all rays so far.
    pub nodes: u64,
}

impl Walker {
    /// Calls `leaf` with first and count of every leaf whose bounds the ray enters before `reach`; `leaf`
    /// returns the new reach.
    pub fn walk(
        &mut self,
        nodes: &[Node4],
        bounds: Bounds,
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
                    let (node, range) = (&nodes[node as usize], (0.0, widened(reach)));
                    let entered = match bounds {
                        Bounds::Boxes | Bounds::Unbounded => enter_boxes(node, &slab, range),
                        Bounds::Spheres => enter_spheres(node, ray.origin, ray.dir, range),
                    };
                    self.push_children(node, entered);
                }
            }
        }
    }

    /// Those children that the ray enters go on the stack, farthest first.
    #[inline]
    fn push_children(&mut self, node: &Node4, (near, entered): (Vec4, u32)) {
        let base = self.stack.len();
        for (slot, &child) in node.children.iter().enumerate() {
            if entered & (1 << slot) != 0 && child != CHILD_NONE {
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
