//! What single rays walk on the CPU: a mesh's tree again, eight boxes to a node, its triangles in fours by corner, axis and
//! lane.
//!
//! Made of the 4-wide tree that devices walk ([`crate::bvh::Tree`]), which is built and refitted: a node takes in the
//! children of its largest children until it has eight, and what holds four triangles or fewer is one leaf, which costs
//! a ray no more than a leaf of one (wide trees: Wald, Benthin and Boulos 2008, "Getting Rid of Packets"). Boxes are those of
//! the tree, or unions of them, so they are found again from it when vertices have moved; triangles are read again.
//!
//! A node is 256 bytes and four triangles are 192: of hills and spheres as `bench cpu` makes them 85 bytes a triangle, beside
//! what they are made of.

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use crate::bvh::{CHILD_LEAF, Child, LEAF_COUNT_SHIFT, LEAF_FIRST_MASK, Node4};
use crate::frame::wire::{TriangleRow, VertexRow};

/// Children of a node.
pub const EIGHT: usize = 8;
/// Triangles of a block.
pub const FOUR: usize = 4;
/// Entries that a walk may have to keep, at most.
pub const STACK_MOST: u32 = 96;
/// Leaves of the tree are put together where the box around both is at most so much larger than the two are.
const MOST_WASTE: f32 = 1.0;
/// Nodes, or blocks, that a thread takes at once.
const CHUNK: usize = 1024;

/// Eight boxes, and what is in them. A slot that holds nothing has a box that no ray enters, and is a leaf of no blocks.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Node8 {
    /// Least x, y, z, then greatest, of each child's box.
    pub sides: [[f32; EIGHT]; 6],
    /// A node; or [`CHILD_LEAF`] | blocks << [`LEAF_COUNT_SHIFT`] | first block.
    pub children: [u32; EIGHT],
    /// Where the box is from: node of the 4-wide tree, and a bit for each of its slots that are in it.
    sources: [u32; EIGHT],
}

impl Node8 {
    const EMPTY: Self = Self {
        sides: [
            [f32::MAX; EIGHT],
            [f32::MAX; EIGHT],
            [f32::MAX; EIGHT],
            [f32::MIN; EIGHT],
            [f32::MIN; EIGHT],
            [f32::MIN; EIGHT],
        ],
        children: [CHILD_LEAF; EIGHT],
        sources: [0; EIGHT],
    };
}

/// The blocks of a leaf, first and end.
#[inline(always)]
pub fn blocks_of(child: u32) -> (u32, u32) {
    let first = child & LEAF_FIRST_MASK;
    (first, first + ((child & !CHILD_LEAF) >> LEAF_COUNT_SHIFT))
}

/// Four triangles; of fewer the last has points behind it. By corner: x, y and z of all four, and a row of something else.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Block {
    /// Rows by corner and axis; behind the first corner's places among the mesh's triangles, behind the second's
    /// primitives, bits.
    pub rows: [[[f32; FOUR]; 4]; 3],
}

impl Block {
    /// Place of a triangle among those of the mesh.
    #[inline(always)]
    pub fn place(&self, lane: usize) -> u32 {
        self.rows[0][3][lane & 3].to_bits()
    }

    /// Its primitive.
    #[inline(always)]
    pub fn prim(&self, lane: usize) -> u32 {
        self.rows[1][3][lane & 3].to_bits()
    }

    /// Its corners.
    #[inline(always)]
    pub fn corners(&self, lane: usize) -> [glam::Vec3; 3] {
        let at = |[x, y, z, _]: &[[f32; FOUR]; 4]| {
            glam::Vec3::new(x[lane & 3], y[lane & 3], z[lane & 3])
        };
        let [a, b, c] = &self.rows;
        [at(a), at(b), at(c)]
    }
}

/// See the module.
#[derive(Clone, Debug, Default)]
pub struct Lanes {
    /// Root first, each before those below it; none: nothing to hit, or a tree of another kind.
    pub nodes: Vec<Node8>,
    /// Triangles in the order of leaves.
    pub blocks: Vec<Block>,
}

/// Slots of a node of the 4-wide tree that go together.
#[derive(Clone, Copy)]
struct Part {
    /// Node and slots, as in [`Node8::sources`].
    source: u32,
    /// Triangles below.
    count: u32,
    /// Half the area of the box around.
    area: f32,
    /// The node that it is, if it is more than a leaf.
    inner: Option<u32>,
}

impl Lanes {
    /// Of a tree of boxes over some triangles.
    pub fn build(nodes: &[Node4], triangles: &[TriangleRow], vertices: &[VertexRow]) -> Self {
        if nodes.is_empty() {
            return Self::default();
        }
        let counts = count_all(nodes);
        let mut lanes = Builder::run(nodes, &counts, EIGHT);
        if lanes.stack_need() > STACK_MOST {
            // Trees like lists. One node here for each there, none opened, needs no more than they do.
            lanes = Builder::run(nodes, &counts, 0);
        }
        lanes.refresh(nodes, triangles, vertices);
        lanes
    }

    /// Brings boxes and corners up to a tree that was refitted and vertices that moved.
    pub fn refresh(&mut self, nodes: &[Node4], triangles: &[TriangleRow], vertices: &[VertexRow]) {
        let fit = |node: &mut Node8| {
            for slot in 0..EIGHT {
                let around = around(nodes, node.sources[slot]);
                for (side, value) in node.sides.iter_mut().zip(around) {
                    side[slot] = value;
                }
            }
        };
        self.nodes
            .par_chunks_mut(CHUNK)
            .for_each(|nodes| nodes.iter_mut().for_each(fit));
        let fill = |block: &mut Block| {
            for lane in 0..FOUR {
                let triangle = &triangles[block.place(lane) as usize];
                let mut corners = triangle.corners;
                if lane > 0 && block.place(lane) == block.place(lane - 1) {
                    // A point, which no ray meets.
                    corners = [corners[0]; 3];
                }
                block.rows[1][3][lane] = f32::from_bits(triangle.prim);
                for (rows, corner) in block.rows.iter_mut().zip(corners) {
                    let at = vertices[corner as usize].vector;
                    for (row, x) in rows.iter_mut().zip(at) {
                        row[lane] = x;
                    }
                }
            }
        };
        self.blocks
            .par_chunks_mut(CHUNK)
            .for_each(|blocks| blocks.iter_mut().for_each(fill));
    }

    /// Entries that a walk may have to keep at once.
    fn stack_need(&self) -> u32 {
        let mut need = vec![0; self.nodes.len()];
        for (index, node) in self.nodes.iter().enumerate().rev() {
            let count = node.children.iter().filter(|&&c| c != CHILD_LEAF).count() as u32;
            let inner = node.children.iter().filter(|&&c| c & CHILD_LEAF == 0);
            let deepest = inner.map(|&c| need[c as usize]).max().unwrap_or(0);
            need[index] = count.max(count.saturating_sub(1) + deepest);
        }
        need.first().copied().unwrap_or(0)
    }
}

/// Triangles below each node of a tree.
fn count_all(nodes: &[Node4]) -> Vec<u32> {
    let mut counts = vec![0; nodes.len()];
    for (index, node) in nodes.iter().enumerate().rev() {
        let of = |&child: &u32| match Child::decode(child) {
            Child::None => 0,
            Child::Node(below) => counts[below as usize],
            Child::Leaf { count, .. } => count,
        };
        counts[index] = node.children.iter().map(of).sum();
    }
    counts
}

/// Least and greatest sides of the box around some slots; inverted around none.
fn around(nodes: &[Node4], source: u32) -> [f32; 6] {
    let node = &nodes[(source >> 4) as usize];
    let mut sides = [f32::MAX, f32::MAX, f32::MAX, f32::MIN, f32::MIN, f32::MIN];
    let rows: &[[f32; 4]; 7] = bytemuck::cast_ref(node);
    for slot in (0..4).filter(|slot| source & 1 << slot != 0) {
        for axis in 0..3 {
            sides[axis] = sides[axis].min(rows[axis][slot]);
            sides[3 + axis] = sides[3 + axis].max(rows[3 + axis][slot]);
        }
    }
    sides
}

fn half_area([a, b, c, d, e, f]: [f32; 6]) -> f32 {
    let (x, y, z) = (d - a, e - b, f - c);
    x * y + y * z + z * x
}

struct Builder<'a> {
    from: &'a [Node4],
    counts: &'a [u32],
    /// How many parts are in each node.
    sizes: Vec<u8>,
    lanes: Lanes,
    /// Places of the triangles of a leaf.
    places: Vec<u32>,
}

impl<'a> Builder<'a> {
    /// All but boxes and corners; nodes are opened while there are no more than so many children.
    fn run(from: &'a [Node4], counts: &'a [u32], width: usize) -> Lanes {
        let mut builder = Self {
            from,
            counts,
            sizes: Vec::new(),
            lanes: Lanes::default(),
            places: Vec::new(),
        };
        let size = |node| builder.parts(node).len() as u8;
        let sizes = (0..from.len() as u32).into_par_iter().map(size).collect();
        builder.sizes = sizes;
        builder.lanes.nodes.push(Node8::EMPTY);
        let mut left = vec![(0, 0)];
        while let Some((source, index)) = left.pop() {
            let mut parts = builder.parts(source);
            while let Some(open) = builder.largest(&parts, width) {
                let inner = parts.swap_remove(open).inner;
                parts.extend(inner.into_iter().flat_map(|node| builder.parts(node)));
            }
            for (slot, part) in parts.into_iter().enumerate() {
                let child = match part.inner {
                    Some(node) => {
                        let child = builder.lanes.nodes.len();
                        builder.lanes.nodes.push(Node8::EMPTY);
                        left.push((node, child));
                        child as u32
                    }
                    None => builder.leaf(part.source),
                };
                let node: &mut Node8 = &mut builder.lanes.nodes[index];
                node.children[slot] = child;
                node.sources[slot] = part.source;
            }
        }
        builder.lanes
    }

    /// Which inner part to open: the largest of those that leave no more than `width`.
    fn largest(&self, parts: &[Part], width: usize) -> Option<usize> {
        let fits = |part: &Part| {
            let inside = part.inner.map(|node| self.sizes[node as usize]);
            inside.is_some_and(|inside| parts.len() - 1 + usize::from(inside) <= width)
        };
        let open = (0..parts.len()).filter(|&i| fits(&parts[i]));
        open.max_by(|&a, &b| parts[a].area.total_cmp(&parts[b].area))
    }

    /// What is in a node of the 4-wide tree.
    fn parts(&self, index: u32) -> Vec<Part> {
        let mut parts: Vec<Part> = Vec::with_capacity(EIGHT);
        for slot in 0..4 {
            let source = index << 4 | 1 << slot;
            let (count, inner) = match Child::decode(self.from[index as usize].children[slot]) {
                Child::None => continue,
                Child::Node(node) => {
                    let count = self.counts[node as usize];
                    (count, Some(node).filter(|_| count > FOUR as u32))
                }
                Child::Leaf { count, .. } => (count, None),
            };
            let part = Part {
                source,
                count,
                area: half_area(around(self.from, source)),
                inner,
            };
            match parts
                .iter_mut()
                .find_map(|other| self.both(other, &part).map(|both| (other, both)))
            {
                Some((other, both)) => *other = both,
                None => parts.push(part),
            }
        }
        parts
    }

    /// Two leaves as one, if that is better.
    fn both(&self, a: &Part, b: &Part) -> Option<Part> {
        let count = a.count + b.count;
        if a.inner.is_some() || b.inner.is_some() || count > FOUR as u32 {
            return None;
        }
        let source = a.source | b.source;
        let area = half_area(around(self.from, source));
        (area <= MOST_WASTE * (a.area + b.area)).then_some(Part {
            source,
            count,
            area,
            inner: None,
        })
    }

    /// The blocks of what is below some slots.
    fn leaf(&mut self, source: u32) -> u32 {
        self.places.clear();
        let node = &self.from[(source >> 4) as usize];
        let mut left: Vec<u32> = (0..4)
            .filter(|slot| source & 1 << slot != 0)
            .map(|slot| node.children[slot])
            .collect();
        while let Some(child) = left.pop() {
            match Child::decode(child) {
                Child::None => {}
                Child::Node(node) => left.extend(self.from[node as usize].children),
                Child::Leaf { first, count } => self.places.extend(first..first + count),
            }
        }
        let first = self.lanes.blocks.len() as u32;
        for places in self.places.chunks(FOUR) {
            let mut block = Block::zeroed();
            for lane in 0..FOUR {
                let place = places[lane.min(places.len() - 1)];
                block.rows[0][3][lane] = f32::from_bits(place);
            }
            self.lanes.blocks.push(block);
        }
        let count = self.lanes.blocks.len() as u32 - first;
        CHILD_LEAF | count << LEAF_COUNT_SHIFT | first
    }
}

#[cfg(test)]
mod tests;
