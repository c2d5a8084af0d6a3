//! A plain binary tree over a mesh's triangles in f64, split at medians: enough to make the oracle usable.

use glam::DVec3;

use super::explain::Recorder;
use super::shape::{LocalHit, LocalRay, triangle};
use crate::world::MeshData;

/// Triangles a leaf may hold.
const LEAF: usize = 4;

/// A box with two halves below, or a leaf's triangles.
struct Node {
    min: DVec3,
    max: DVec3,
    /// The left half follows at once; the right one is here. Leaves: none.
    right: Option<usize>,
    /// Range of the order of triangles.
    range: std::ops::Range<usize>,
}

/// A tree over one mesh.
pub struct MeshTree {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

impl MeshTree {
    /// Splits the widest axis at the median until few triangles are left.
    pub fn build(mesh: &MeshData) -> Self {
        let mut tree = Self {
            nodes: Vec::new(),
            order: (0..mesh.triangles.len() as u32).collect(),
        };
        if !tree.order.is_empty() {
            tree.split(mesh, 0..mesh.triangles.len());
        }
        tree
    }

    fn split(&mut self, mesh: &MeshData, range: std::ops::Range<usize>) -> usize {
        let corners = |&prim: &u32| {
            mesh.triangles[prim as usize].map(|corner| mesh.vertices[corner as usize])
        };
        let (min, max) = self.order[range.clone()]
            .iter()
            .flat_map(corners)
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), p| {
                (min.min(p), max.max(p))
            });
        let index = self.nodes.len();
        self.nodes.push(Node {
            min,
            max,
            right: None,
            range: range.clone(),
        });
        if range.len() > LEAF {
            let axis = (max - min).max_position();
            let center = |prim: &u32| corners(prim).iter().map(|p| p[axis]).sum::<f64>();
            let middle = range.len() / 2;
            self.order[range.clone()]
                .select_nth_unstable_by(middle, |a, b| center(a).total_cmp(&center(b)));
            let middle = range.start + middle;
            self.split(mesh, range.start..middle);
            self.nodes[index].right = Some(self.split(mesh, middle..range.end));
        }
        index
    }

    /// Calls `found` (and tells the recorder of every test) for every triangle hit whose box begins no farther than `found` last returned, and that is no hole.
    pub fn hits(
        &self,
        mesh: &MeshData,
        ray: &LocalRay,
        recorder: &mut impl Recorder,
        is_hole: impl Fn(&LocalHit) -> bool,
        mut found: impl FnMut(LocalHit) -> f64,
    ) {
        let mut limit = f64::INFINITY;
        let mut pending = if self.nodes.is_empty() {
            vec![]
        } else {
            vec![0]
        };
        while let Some(index) = pending.pop() {
            let node = &self.nodes[index];
            recorder.test_box();
            if !enters(ray, node.min, node.max, limit) {
                continue;
            }
            if let Some(right) = node.right {
                pending.extend([right, index + 1]);
                continue;
            }
            for &prim in &self.order[node.range.clone()] {
                recorder.test_shape();
                let corners = mesh.triangles[prim as usize].map(|c| mesh.vertices[c as usize]);
                if let Some(hit) = triangle(ray, corners, prim).filter(|hit| !is_hole(hit)) {
                    limit = found(hit);
                }
            }
        }
    }
}

/// Whether a ray may meet something in a box before `limit`. Generous by 1e-12 of the distances, far more
/// than f64 errs; 0/0 (a ray along a face) counts as inside.
pub fn enters(ray: &LocalRay, min: DVec3, max: DVec3, limit: f64) -> bool {
    let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in 0..3 {
        let a = (min[axis] - ray.origin[axis]) / ray.dir[axis];
        let b = (max[axis] - ray.origin[axis]) / ray.dir[axis];
        if !a.is_nan() && !b.is_nan() {
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
    }
    let slack = 1e-12 * near.abs().max(far.abs()).min(1e300);
    near <= far + slack && far >= -slack && near <= limit + slack
}
