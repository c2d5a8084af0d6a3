//! Boxes to tree: a binary tree by `obvhs` (or by medians), collapsed to four children a node.

use glam::Vec3A;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

use super::{Child, Node4, TRAVERSAL_CAPACITY, Tree};
use crate::geom::Aabb;

/// Nodes that one tree may ask of a traversal's stack: half of it, for there are two levels of trees.
pub(super) const STACK_SHARE: u32 = TRAVERSAL_CAPACITY / 2;

/// Most primitives in a leaf of a mesh's tree.
pub(super) const MESH_LEAF: u32 = 4;
/// What visiting a binary node costs, in tests of a triangle, when leaves are formed. Of 1 instead of 3, rays on an NVIDIA H200 take
/// 8 % less, and there are more nodes to refit.
const NODE_COST: f32 = 1.0;

/// A node of the binary tree on its way to four children.
#[derive(Clone, Copy)]
pub(super) struct Binary {
    bounds: Aabb,
    /// Leaves: first of the primitives. Inner nodes: first of two neighbouring children.
    first: u32,
    /// 0: inner.
    count: u32,
}

impl Tree {
    /// A tree of good quality for what is built once and traced often; boxes must be finite.
    pub fn build(boxes: &[Aabb]) -> Self {
        Self::of_good_quality(boxes, 4)
    }

    /// A tree of full quality with one primitive a leaf: what a tree over instances is held against.
    pub fn build_single(boxes: &[Aabb]) -> Self {
        Self::with_leaves(boxes, 1, 0.02, 4)
    }

    /// A tree built quickly, one primitive a leaf: for the instances of a frame.
    pub fn build_fast(boxes: &[Aabb]) -> Self {
        Self::with_leaves(boxes, 1, 0.0, 4)
    }

    /// [`Tree::build`] with 2 to 4 children a node.
    pub(super) fn of_good_quality(boxes: &[Aabb], width: usize) -> Self {
        Self::with_leaves(boxes, MESH_LEAF, 0.02, width)
    }

    fn with_leaves(boxes: &[Aabb], max_leaf: u32, reinsertion: f32, width: usize) -> Self {
        if boxes.is_empty() {
            return Self::default();
        }
        let (binary, prims) = ploc(boxes, max_leaf, reinsertion);
        let tree = widen(&binary, prims, width);
        if tree.stack_need() <= STACK_SHARE {
            return tree;
        }
        // Pathological input (nested boxes, say) can make PLOC's tree a list. Medians cannot:
        // 2^28 primitives need 14 levels of 4, 43 entries.
        balanced(boxes, max_leaf, width)
    }
}

/// The tree by medians.
pub(super) fn balanced(boxes: &[Aabb], max_leaf: u32, width: usize) -> Tree {
    let (binary, prims) = medians(boxes, max_leaf);
    widen(&binary, prims, width)
}

/// Parallel locally-ordered clustering, with some reinsertion and leaves collapsed by cost.
fn ploc(boxes: &[Aabb], max_leaf: u32, reinsertion: f32) -> (Vec<Binary>, Vec<u32>) {
    let bounds: Vec<obvhs::aabb::Aabb> = boxes
        .iter()
        .map(|b| obvhs::aabb::Aabb::new(Vec3A::from(b.min), Vec3A::from(b.max)))
        .collect();
    let indices = (0..boxes.len() as u32).collect();
    let mut tree: Bvh2 = PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::Low,
        &bounds,
        indices,
        SortPrecision::U64,
        0,
    );
    if reinsertion > 0.0 {
        ReinsertionOptimizer::default().run(&mut tree, reinsertion, None);
    }
    if max_leaf > 1 {
        collapse(&mut tree, max_leaf, NODE_COST);
    }
    let nodes = tree.nodes.iter().map(|n| Binary {
        bounds: Aabb {
            min: n.aabb.min.into(),
            max: n.aabb.max.into(),
        },
        first: n.first_index,
        count: n.prim_count,
    });
    (nodes.collect(), tree.primitive_indices)
}

/// Splits at the median of the widest axis: balanced whatever the input.
pub(super) fn medians(boxes: &[Aabb], max_leaf: u32) -> (Vec<Binary>, Vec<u32>) {
    let mut prims: Vec<u32> = (0..boxes.len() as u32).collect();
    let whole = |prims: &[u32]| {
        prims
            .iter()
            .fold(Aabb::EMPTY, |b, &p| b.union(boxes[p as usize]))
    };
    let mut nodes = vec![Binary {
        bounds: whole(&prims),
        first: 0,
        count: boxes.len() as u32,
    }];
    let mut next = 0;
    while next < nodes.len() {
        let Binary { first, count, .. } = nodes[next];
        if count > max_leaf {
            let size = nodes[next].bounds.max - nodes[next].bounds.min;
            let axis = size.max_position();
            let range = &mut prims[first as usize..(first + count) as usize];
            let middle = count / 2;
            range.select_nth_unstable_by(middle as usize, |&a, &b| {
                let center = |p: u32| boxes[p as usize].min[axis] + boxes[p as usize].max[axis];
                center(a).total_cmp(&center(b)).then(a.cmp(&b))
            });
            let (left, right) = range.split_at(middle as usize);
            let (left, right) = (whole(left), whole(right));
            let children = nodes.len() as u32;
            nodes.push(Binary {
                bounds: left,
                first,
                count: middle,
            });
            nodes.push(Binary {
                bounds: right,
                first: first + middle,
                count: count - middle,
            });
            nodes[next].first = children;
            nodes[next].count = 0;
        }
        next += 1;
    }
    (nodes, prims)
}

/// Collapses a binary tree level by level: each node takes in grandchildren, largest area first, until it
/// has `width` children.
pub(super) fn widen(binary: &[Binary], prims: Vec<u32>, width: usize) -> Tree {
    let mut tree = Tree {
        prims: Vec::with_capacity(prims.len()),
        ..Tree::default()
    };
    // The binary node that each node stands for, in breadth-first order.
    let mut sources = vec![0_u32];
    tree.levels.push(0);
    while tree.nodes.len() < sources.len() {
        let level = tree.nodes.len()..sources.len();
        tree.levels.push(level.end as u32);
        for index in level {
            let mut node = Node4::EMPTY;
            let (group, size) = children_of(binary, sources[index], width);
            for (slot, &child) in group[..size].iter().enumerate() {
                let Binary {
                    bounds,
                    first,
                    count,
                } = binary[child as usize];
                let kind = if count == 0 {
                    sources.push(child);
                    Child::Node(sources.len() as u32 - 1)
                } else {
                    Child::Leaf { first, count }
                };
                node.set_child(slot, &bounds.grown(), kind);
            }
            tree.nodes.push(node);
        }
    }
    order_leaves(&mut tree, &prims);
    tree
}

/// Puts primitives in the order in which a walk that goes deep first meets them, be it a ray's or a
/// refit's: what lies close together is read together.
fn order_leaves(tree: &mut Tree, prims: &[u32]) {
    let mut path = vec![(0, 0)];
    while let Some((node, slot)) = path.pop() {
        if slot == 4 {
            continue;
        }
        path.push((node, slot + 1));
        let child = &mut tree.nodes[node].children[slot];
        match Child::decode(*child) {
            Child::None => {}
            Child::Node(below) => path.push((below as usize, 0)),
            Child::Leaf { first, count } => {
                let place = tree.prims.len() as u32;
                let range = first as usize..(first + count) as usize;
                tree.prims.extend_from_slice(&prims[range]);
                *child = Child::Leaf {
                    first: place,
                    count,
                }
                .encode();
            }
        }
    }
}

/// The binary nodes, at most `width`, that become the children of a node, and how many they are.
fn children_of(binary: &[Binary], from: u32, width: usize) -> ([u32; 4], usize) {
    let mut group = [from; 4];
    let mut size = 1;
    while size < width {
        let inner = (0..size).filter(|&i| binary[group[i] as usize].count == 0);
        let area = |i: &usize| binary[group[*i] as usize].bounds.half_area();
        let Some(open) = inner.max_by(|a, b| area(a).total_cmp(&area(b))) else {
            break;
        };
        let children = binary[group[open] as usize].first;
        group[open] = children;
        group[size] = children + 1;
        size += 1;
    }
    // Inner nodes first: a refit then branches more predictably.
    group[..size].sort_unstable_by_key(|&i| binary[i as usize].count);
    (group, size)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::testing::boxes;

    #[test]
    fn every_tree_holds_its_invariants() {
        for count in [0, 1, 2, 3, 4, 5, 7, 8, 9, 64, 1000, 20_000] {
            for spread in [0.0, 1.0, 1e6] {
                let boxes = boxes(count, spread, 0.0, count as u32 + 1);
                for tree in [
                    Tree::build(&boxes),
                    Tree::build_single(&boxes),
                    Tree::build_fast(&boxes),
                ] {
                    tree.validate(&boxes).unwrap();
                    assert!(tree.stack_need() <= STACK_SHARE, "{}", tree.stack_need());
                }
            }
        }
    }

    #[test]
    fn boxes_nested_like_onions_do_not_overflow_the_stack() {
        let boxes: Vec<Aabb> = (0..3000)
            .map(|i| {
                let half = Vec3::splat(1.004_f32.powi(i));
                Aabb {
                    min: -half,
                    max: half,
                }
            })
            .collect();
        let tree = Tree::build_fast(&boxes);
        tree.validate(&boxes).unwrap();
        assert!(tree.stack_need() <= STACK_SHARE, "{}", tree.stack_need());
        balanced(&boxes, 1, 4).validate(&boxes).unwrap();
    }

    #[test]
    fn equal_boxes_make_a_tree() {
        let boxes = vec![boxes(1, 1.0, 0.0, 5)[0]; 500];
        Tree::build(&boxes).validate(&boxes).unwrap();
    }
}
