//! Instance trees built on the device hold what they must, whatever the boxes.

use std::collections::HashSet;

use glam::DVec3;
use orrery_engine::bvh::{Child, Node4};
use orrery_engine::frame::wire::BoxRow;
use orrery_engine::geom::Aabb;
use orrery_engine::trace::gpu::trees::{Rig, RigRows, most_levels, most_nodes};
use orrery_tests::random_scene::Random;

use crate::device_trees::gpu;

fn box_row(bounds: &Aabb) -> BoxRow {
    BoxRow {
        min: bounds.min.to_array(),
        max: bounds.max.to_array(),
        ..BoxRow::default()
    }
}

/// Walks a tree that the device built: every box that is not vacant in one leaf, every node's box exactly
/// around its content, no level too many.
fn check_instance_tree(boxes: &[Aabb]) {
    let root = 3;
    let room = root + most_nodes(boxes.len() as u32) as usize;
    let mut rig = Rig::new(
        gpu(),
        &RigRows {
            nodes: vec![Node4::EMPTY; room + 1],
            boxes: boxes.iter().map(box_row).collect(),
            ..RigRows::default()
        },
    )
    .expect("a rig");
    rig.build(root as u32).expect("builds");
    rig.build(root as u32).expect("builds again");
    let nodes = rig.nodes().expect("nodes");
    let built = rig.built().expect("levels");
    let total: u32 = built.level_nodes.iter().sum();
    assert!(
        nodes[..root].iter().all(|node| *node == Node4::EMPTY),
        "wrote before the root"
    );
    assert_eq!(nodes[room], Node4::EMPTY, "wrote behind its room");
    let mut seen = vec![false; boxes.len()];
    let mut visited = HashSet::new();
    let mut pending = vec![(0_u32, 1_u32, None::<Aabb>)];
    while let Some((index, level, outer)) = pending.pop() {
        assert!(visited.insert(index), "node {index} has two parents");
        assert!(level <= most_levels(boxes.len() as u32), "too deep");
        assert!(index < total, "node {index} of {total}");
        let node = &nodes[root + index as usize];
        let whole = (0..4).fold(Aabb::EMPTY, |all, slot| all.union(node.child_box(slot)));
        assert!(
            outer.is_none_or(|outer| outer == whole),
            "node {index} in another box"
        );
        for slot in 0..4 {
            let bounds = node.child_box(slot);
            match Child::decode(node.children[slot]) {
                Child::None => assert!(bounds.is_empty()),
                Child::Node(child) => pending.push((child, level + 1, Some(bounds))),
                Child::Leaf { first, count } => {
                    assert_eq!(count, 1);
                    let row = first as usize;
                    assert!(!std::mem::replace(&mut seen[row], true), "row {row} twice");
                    assert_eq!(bounds, boxes[row].grown(), "row {row}");
                }
            }
        }
    }
    assert_eq!(visited.len() as u32, total);
    for (row, (seen, bounds)) in seen.iter().zip(boxes).enumerate() {
        assert_eq!(*seen, !bounds.is_empty(), "row {row} of {}", boxes.len());
    }
}

fn box_at(centre: DVec3, half: f64) -> Aabb {
    Aabb {
        min: (centre - half).as_vec3(),
        max: (centre + half).as_vec3(),
    }
}

#[test]
fn instance_trees_hold_every_box_once() {
    let mut random = Random::new(11);
    for count in [0, 1, 2, 3, 4, 5, 17, 1000, 1025, 20_000] {
        let boxes: Vec<Aabb> = (0..count)
            .map(|_| box_at(random.cube() * 50.0, random.unit()))
            .collect();
        check_instance_tree(&boxes);
    }
}

#[test]
fn vacant_rows_are_in_no_instance_tree() {
    let mut random = Random::new(12);
    for (count, live_in) in [(1, 2), (2, 2), (700, 3), (3000, 50), (64, 1000)] {
        let boxes: Vec<Aabb> = (0..count)
            .map(|i| match i % live_in {
                1 => box_at(random.cube(), 0.01),
                _ => Aabb::EMPTY,
            })
            .collect();
        check_instance_tree(&boxes);
    }
}

#[test]
fn instance_trees_stay_shallow_whatever_the_boxes() {
    let mut random = Random::new(13);
    let equal = vec![box_at(DVec3::ONE, 2.0); 5000];
    let on_a_line: Vec<Aabb> = (0..5000)
        .map(|i| box_at(DVec3::X * f64::from(i), 0.4))
        .collect();
    // Each half as far from the corner as the last: every split would cut off one.
    let crowding: Vec<Aabb> = (0..3000)
        .map(|i| box_at(DVec3::ONE * 0.5_f64.powi(i % 40) * 1000.0, 1e-3))
        .collect();
    let nested: Vec<Aabb> = (1..2000)
        .map(|i| box_at(DVec3::ZERO, f64::from(i)))
        .collect();
    let mut clusters = vec![box_at(DVec3::splat(1e9), 1.0)];
    clusters.extend((0..4000).map(|_| box_at(random.cube(), 0.01)));
    for boxes in [equal, on_a_line, crowding, nested, clusters] {
        check_instance_tree(&boxes);
    }
}
