//! Binary nodes to nodes of up to four children, at the least expected cost of all ways to do so.
//!
//! Which nodes stay, which are opened into their parents and which become leaves is found from the bottom up: the best way to
//! stand for a subtree by one child, or by up to two, three, four (Ylitie, Karras and Laine 2017, "Efficient incoherent ray
//! traversal on GPUs through compressed wide BVHs", 3.1). Beside opening the largest child first, over the same binary
//! trees, there are 12 % fewer nodes, and rays of a hall and of 1,001 instances take 2 and 3 % less on an NVIDIA H200.

use super::binary::Binary;
use super::{Child, Node4, Tree};

/// What entering a node costs, in tests of a triangle. Half and twice as much were tried on an NVIDIA H200: half makes
/// no difference to rays but more nodes to refit, twice takes rays 1 to 2 % longer.
const NODE_COST: f32 = 1.0;

/// Children of a node, at most.
const WIDTH: usize = 4;

/// The best ways to stand for a binary node.
#[derive(Clone, Copy, Default)]
struct Ways {
    /// Least cost by at most 1, 2, 3, 4 children.
    cost: [f32; WIDTH],
    /// Of so many children (from 2 on), how many stand for the left half; 0: one fewer do as well.
    to_left: [u8; WIDTH],
    /// Of a node's own children, if it is one: how many stand for the left half.
    own_left: u8,
    /// As one child, it is a leaf.
    is_leaf: bool,
    /// Its primitives, in the order of leaves.
    first: u32,
    count: u32,
}

/// The tree of 2 to 4 children a node over the leaves of a binary one. Leaves that lie together may become one of up to `leaf`
/// primitives.
pub fn collapse(binary: &[Binary], prims: Vec<u32>, leaf: u32, width: usize) -> Tree {
    let ways = ways(binary, leaf, width);
    let mut tree = Tree {
        prims: Vec::with_capacity(prims.len()),
        ..Tree::default()
    };
    // The binary node that each node stands for, in breadth-first order.
    let mut sources = vec![0_usize];
    tree.levels.push(0);
    while tree.nodes.len() < sources.len() {
        let level = tree.nodes.len()..sources.len();
        tree.levels.push(level.end as u32);
        for index in level {
            let mut node = Node4::EMPTY;
            let mut group = Group::default();
            group.open(binary, &ways, sources[index], width);
            // Inner nodes first: a refit then branches more predictably.
            group
                .members_mut()
                .sort_by_key(|&child| ways[child].is_leaf);
            for (slot, &child) in group.members_mut().iter().enumerate() {
                let Ways { first, count, .. } = ways[child];
                let kind = if ways[child].is_leaf {
                    Child::Leaf { first, count }
                } else {
                    sources.push(child);
                    Child::Node(sources.len() as u32 - 1)
                };
                node.set_child(slot, &binary[child].bounds.grown(), kind);
            }
            tree.nodes.push(node);
        }
    }
    order_leaves(&mut tree, &prims);
    tree
}

/// Of every binary node. Children come after their parents, and the primitives of a subtree lie together.
fn ways(binary: &[Binary], leaf: u32, width: usize) -> Vec<Ways> {
    let mut ways = vec![Ways::default(); binary.len()];
    let root = binary.first().map_or(0.0, area);
    let unit = if root > 0.0 { 1.0 / root } else { 0.0 };
    for (index, node) in binary.iter().enumerate().rev() {
        let area = (area(node) * unit) as f32;
        if node.count > 0 {
            ways[index] = Ways {
                cost: [area * node.count as f32; WIDTH],
                is_leaf: true,
                first: node.first,
                count: node.count,
                ..Ways::default()
            };
            continue;
        }
        let left = ways[node.first as usize];
        let right = ways[node.first as usize + 1];
        ways[index] = join(&left, &right, area, leaf, width);
    }
    ways
}

/// Half a box's surface.
fn area(node: &Binary) -> f64 {
    let sides = node.bounds.max.as_dvec3() - node.bounds.min.as_dvec3();
    sides.x * sides.y + sides.y * sides.z + sides.z * sides.x
}

fn join(left: &Ways, right: &Ways, area: f32, leaf: u32, width: usize) -> Ways {
    // The cost of both halves by so many children, and how many of them are the left half's.
    let shared = |children: usize| {
        let mut best = (left.cost[0] + right.cost[children - 2], 1);
        for to_left in 2..children {
            let cost = left.cost[to_left - 1] + right.cost[children - to_left - 1];
            if cost < best.0 {
                best = (cost, to_left);
            }
        }
        best
    };
    let (below, own_left) = shared(width);
    let count = left.count + right.count;
    let as_leaf = area * count as f32;
    let as_node = below + area * NODE_COST;
    let is_leaf = count <= leaf && as_leaf <= as_node;
    let mut ways = Ways {
        cost: [if is_leaf { as_leaf } else { as_node }; WIDTH],
        own_left: own_left as u8,
        is_leaf,
        first: left.first,
        count,
        ..Ways::default()
    };
    for children in 2..=width {
        let fewer = ways.cost[children - 2];
        let (cost, to_left) = shared(children);
        // Where it is all the same, nodes are full.
        let is_better = cost < fewer || cost == fewer && !is_leaf;
        ways.cost[children - 1] = if is_better { cost } else { fewer };
        ways.to_left[children - 1] = if is_better { to_left as u8 } else { 0 };
    }
    ways
}

/// The binary nodes that become the children of a node.
#[derive(Default)]
struct Group {
    members: [usize; WIDTH],
    size: usize,
}

impl Group {
    fn members_mut(&mut self) -> &mut [usize] {
        &mut self.members[..self.size]
    }

    /// Takes in the children of a node; of a leaf, which only a root can be, itself.
    fn open(&mut self, binary: &[Binary], ways: &[Ways], node: usize, width: usize) {
        if ways[node].is_leaf {
            return self.stand_for(binary, ways, node, 1);
        }
        let left = binary[node].first as usize;
        let to_left = usize::from(ways[node].own_left);
        self.stand_for(binary, ways, left, to_left);
        self.stand_for(binary, ways, left + 1, width - to_left);
    }

    /// Takes in what stands for a binary node by at most so many children.
    fn stand_for(&mut self, binary: &[Binary], ways: &[Ways], node: usize, children: usize) {
        let to_left = usize::from(ways[node].to_left[children - 1]);
        if children == 1 {
            self.members[self.size] = node;
            self.size += 1;
        } else if to_left == 0 {
            self.stand_for(binary, ways, node, children - 1);
        } else {
            let left = binary[node].first as usize;
            self.stand_for(binary, ways, left, to_left);
            self.stand_for(binary, ways, left + 1, children - to_left);
        }
    }
}

/// Puts primitives in the order in which a walk that goes deep first meets them, be it a ray's or a
/// refit's: what lies close together is read together.
fn order_leaves(tree: &mut Tree, prims: &[u32]) {
    let mut path = vec![(0, 0)];
    while let Some((node, slot)) = path.pop() {
        if slot == WIDTH {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::binary::{by_area, by_medians};
    use crate::testing::boxes;

    /// The least cost of all collapsed trees below a node, by trying them all.
    fn least(binary: &[Binary], node: usize, leaf: u32, width: usize) -> f64 {
        let own = binary[node];
        let area = f64::from(own.bounds.half_area());
        let as_leaf = area * f64::from(count(binary, node));
        if own.count > 0 {
            return as_leaf;
        }
        let sets = openings(binary, node, width);
        let sums = sets.iter().map(|set| {
            let below = set.iter().map(|&child| least(binary, child, leaf, width));
            below.sum::<f64>()
        });
        let as_node = area * f64::from(NODE_COST) + sums.fold(f64::MAX, f64::min);
        if count(binary, node) <= leaf {
            as_leaf.min(as_node)
        } else {
            as_node
        }
    }

    fn count(binary: &[Binary], node: usize) -> u32 {
        let Binary {
            first, count: own, ..
        } = binary[node];
        match own {
            0 => count(binary, first as usize) + count(binary, first as usize + 1),
            own => own,
        }
    }

    /// All sets of up to `width` nodes that together are what is below a node.
    fn openings(binary: &[Binary], node: usize, width: usize) -> Vec<Vec<usize>> {
        let first = binary[node].first as usize;
        let mut sets = vec![vec![first, first + 1]];
        let mut next = 0;
        while next < sets.len() {
            let set = sets[next].clone();
            for (place, &member) in set.iter().enumerate() {
                if binary[member].count == 0 && set.len() < width {
                    let mut opened = set.clone();
                    let first = binary[member].first as usize;
                    opened[place] = first;
                    opened.push(first + 1);
                    sets.push(opened);
                }
            }
            next += 1;
        }
        sets
    }

    fn cost_of(tree: &Tree) -> f64 {
        let slots = tree.nodes.iter().flat_map(|node| {
            (0..WIDTH).map(|slot| {
                let area = f64::from(node.child_box(slot).half_area());
                match Child::decode(node.children[slot]) {
                    Child::None => 0.0,
                    Child::Node(_) => area * f64::from(NODE_COST),
                    Child::Leaf { count, .. } => area * f64::from(count),
                }
            })
        });
        slots.sum()
    }

    #[test]
    fn no_other_way_costs_less() {
        for seed in 1..40 {
            let boxes = boxes(5 + seed as usize % 6, 3.0, 0.0, seed);
            for (width, leaf) in [(2, 4), (3, 2), (4, 1), (4, 4)] {
                let (binary, prims) = by_area(&boxes, 60);
                let tree = collapse(&binary, prims, leaf, width);
                tree.validate(&boxes).unwrap();
                let root = f64::from(binary[0].bounds.half_area()) * f64::from(NODE_COST);
                let (least, cost) = (least(&binary, 0, leaf, width), root + cost_of(&tree));
                assert!((cost - least).abs() < 1e-4 * least, "{cost} for {least}");
            }
        }
    }

    #[test]
    fn leaves_of_the_binary_tree_stay_together() {
        let boxes = boxes(100, 10.0, 0.0, 9);
        let (binary, prims) = by_medians(&boxes, 7);
        let leaves = binary.iter().filter(|node| node.count > 0).count();
        let tree = collapse(&binary, prims, 1, 4);
        tree.validate(&boxes).unwrap();
        let slots = tree.nodes.iter().flat_map(|node| node.children);
        let found = slots.filter(|&slot| matches!(Child::decode(slot), Child::Leaf { .. }));
        assert_eq!(found.count(), leaves);
    }
}
