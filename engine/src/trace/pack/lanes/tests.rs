//! Lanes against the trees and triangles that they are of.

use glam::Vec3;

use super::*;
use crate::bvh::{Extent, Tree};
use crate::geom::Aabb;
use crate::testing::Random;

/// Triangles that share no vertex: many, few, some in one place, some without area.
struct Soup {
    vertices: Vec<VertexRow>,
    tree: Tree,
    triangles: Vec<TriangleRow>,
}

fn rows(count: usize, random: &mut Random) -> Vec<VertexRow> {
    let mut vertices = Vec::new();
    for triangle in 0..count {
        let place = match triangle % 7 {
            0 => Vec3::ZERO,
            _ => (random.cube() * 9.0).as_vec3(),
        };
        let size = [1.0, 0.1, 0.0][triangle % 3];
        vertices.extend((0..3).map(|_| VertexRow {
            vector: (place + random.cube().as_vec3() * size).to_array(),
            further: 0,
        }));
    }
    vertices
}

fn corners(vertices: &[VertexRow], prim: u32) -> [Vec3; 3] {
    [0, 1, 2].map(|corner| vertices[3 * prim as usize + corner].vector.into())
}

fn boxes(vertices: &[VertexRow]) -> Vec<Aabb> {
    let prims = 0..(vertices.len() / 3) as u32;
    prims
        .map(|prim| Aabb::of(corners(vertices, prim)))
        .collect()
}

impl Soup {
    fn new(vertices: Vec<VertexRow>) -> Self {
        let tree = Tree::build(&boxes(&vertices));
        let triangle = |&prim: &u32| TriangleRow {
            corners: [3 * prim, 3 * prim + 1, 3 * prim + 2],
            prim,
        };
        Self {
            triangles: tree.prims.iter().map(triangle).collect(),
            vertices,
            tree,
        }
    }

    fn lanes(&self) -> Lanes {
        Lanes::build(&self.tree.nodes, &self.triangles, &self.vertices)
    }

    /// The box around what is below a child; notes which primitives are.
    fn check(&self, lanes: &Lanes, child: u32, seen: &mut Vec<u32>) -> Aabb {
        if child & CHILD_LEAF != 0 {
            let (first, end) = blocks_of(child);
            let blocks = &lanes.blocks[first as usize..end as usize];
            return blocks.iter().fold(Aabb::EMPTY, |all, block| {
                all.union(self.check_block(block, seen))
            });
        }
        let node = &lanes.nodes[child as usize];
        let mut all = Aabb::EMPTY;
        for slot in 0..EIGHT {
            assert!(node.children[slot] & CHILD_LEAF != 0 || node.children[slot] > child);
            let inside = self.check(lanes, node.children[slot], seen);
            let [a, b, c, d, e, f] = node.sides.map(|side| side[slot]);
            let around = Aabb {
                min: Vec3::new(a, b, c),
                max: Vec3::new(d, e, f),
            };
            let is_around = inside == Aabb::EMPTY
                || (around.min.cmple(inside.min) & around.max.cmpge(inside.max)).all();
            assert!(is_around, "slot {slot} of node {child}");
            all = all.union(inside);
        }
        all
    }

    fn check_block(&self, block: &Block, seen: &mut Vec<u32>) -> Aabb {
        let mut all = Aabb::EMPTY;
        for lane in 0..FOUR {
            let is_again = lane > 0 && block.place(lane) == block.place(lane - 1);
            let [a, b, c] = block.corners(lane);
            if is_again {
                assert!(a == b && b == c, "a triangle is there again");
                continue;
            }
            let prim = block.prim(lane);
            assert_eq!(prim, self.triangles[block.place(lane) as usize].prim);
            assert_eq!([a, b, c], corners(&self.vertices, prim));
            seen.push(prim);
            all = all.union(Aabb::of([a, b, c]));
        }
        all
    }

    fn check_all(&self, lanes: &Lanes) {
        let mut seen = Vec::new();
        if !lanes.nodes.is_empty() {
            self.check(lanes, 0, &mut seen);
        }
        seen.sort_unstable();
        assert!(seen.into_iter().eq(0..self.triangles.len() as u32));
        assert!(lanes.stack_need() <= STACK_MOST);
    }
}

#[test]
fn every_triangle_is_in_one_lane_and_every_box_around_what_is_below_it() {
    let mut random = Random::new(5);
    for count in [0, 1, 2, 3, 4, 5, 8, 9, 33, 257, 5000] {
        let soup = Soup::new(rows(count, &mut random));
        soup.check_all(&soup.lanes());
    }
}

#[test]
fn lanes_that_follow_are_lanes_made_anew() {
    let mut random = Random::new(6);
    for count in [1, 5, 64, 3000] {
        let mut soup = Soup::new(rows(count, &mut random));
        let mut lanes = soup.lanes();
        for _ in 0..3 {
            soup.vertices = rows(count, &mut random);
            let (vertices, triangles) = (&soup.vertices, &soup.triangles);
            let box_of = |place: usize| Aabb::of(corners(vertices, triangles[place].prim));
            soup.tree.refit(|place| Extent::from(box_of(place)));
            lanes.refresh(&soup.tree.nodes, &soup.triangles, &soup.vertices);
            soup.check_all(&lanes);
        }
    }
}

#[test]
fn trees_like_lists_do_not_ask_for_more_room_than_there_is() {
    // Each around all before it.
    let vertices = (0..2000).flat_map(|i| {
        let size = 1.01_f32.powi(i);
        [[-size; 3], [size, -size, size], [size; 3]].map(|vector| VertexRow { vector, further: 0 })
    });
    let soup = Soup::new(vertices.collect());
    soup.check_all(&soup.lanes());
    let counts = count_all(&soup.tree.nodes);
    let mut plain = Builder::run(&soup.tree.nodes, &counts, 0);
    plain.refresh(&soup.tree.nodes, &soup.triangles, &soup.vertices);
    soup.check_all(&plain);
}
