use glam::Vec3;

use super::*;
use crate::testing::Random;

/// In the cube [0, 1]^3.
fn place(random: &mut Random) -> Vec3 {
    (random.cube() * 0.5 + 0.5).as_vec3()
}

fn bounds(random: &mut Random) -> Aabb {
    let (center, half) = (place(random) * 100.0, place(random));
    Aabb {
        min: center - half,
        max: center + half,
    }
}

/// Moves, adds and removes rows at random for so many frames; checks the tree after each.
fn live_through(frames: usize, most_rows: usize, check_every: usize, seed: u64) {
    let mut random = Random::new(seed);
    let mut tree = InstanceTree::default();
    let mut boxes: Vec<Aabb> = (0..most_rows / 2).map(|_| bounds(&mut random)).collect();
    tree.update(&boxes, None);
    let mut seen = [0; 4];
    for frame in 0..frames {
        let mut changed = Vec::new();
        let count = 1 << random.below(most_rows.ilog2() as usize + 1);
        let way = random.below(8);
        for _ in 0..count.min(most_rows) {
            let row = random.below(most_rows);
            if row >= boxes.len() {
                boxes.push(bounds(&mut random));
                changed.push(boxes.len() as u32 - 1);
                continue;
            }
            let shift = (place(&mut random) - 0.5) * 4.0;
            let b = &mut boxes[row];
            match way {
                0 => *b = Aabb::EMPTY,
                1 if b.is_empty() => *b = bounds(&mut random),
                _ if b.is_empty() => continue,
                _ => (b.min, b.max) = (b.min + shift, b.max + shift),
            }
            changed.push(row as u32);
        }
        if random.below(40) == 0 {
            boxes.truncate(random.below(boxes.len() + 1));
            changed.retain(|&row| (row as usize) < boxes.len());
        }
        // Whatever the clock says: everything it could lead to happens.
        let mut price = || Price(10_f64.powi(random.below(7) as i32));
        (tree.paths, tree.refits, tree.builds) = (price(), price(), price());
        let before = tree.nodes().to_vec();
        let work = tree.update(&boxes, (random.below(16) != 0).then_some(&changed));
        seen[work.action as usize] += 1;
        assert!(
            is_told(&before, &tree),
            "frame {frame}: {work:?}, a change is not told"
        );
        if frame % check_every == 0 {
            tree.validate(&boxes)
                .unwrap_or_else(|e| panic!("seed {seed}, frame {frame}, {work:?}: {e}"));
            let cost = total_cost(tree.nodes());
            let near = (tree.cost() - cost).abs() <= 1e-3 * cost;
            assert!(near, "frame {frame}: a cost of {} for {cost}", tree.cost());
        }
    }
    assert!(seen[1..].iter().all(|&count| count > 0), "{seen:?}");
}

/// Whether all that differs lies in a dirty range.
fn is_told(before: &[Node4], tree: &InstanceTree) -> bool {
    let after = tree.nodes();
    let mut is_dirty = vec![false; after.len()];
    for range in tree.dirty() {
        is_dirty[range.start as usize..range.end as usize].fill(true);
    }
    (0..after.len()).all(|i| is_dirty[i] || before.get(i) == Some(&after[i]))
}

#[test]
fn rows_that_move_come_and_go_are_never_lost_or_kept() {
    for (seed, most_rows) in [(1, 3), (2, 10), (3, 60), (4, 400), (5, 3000)] {
        live_through(400, most_rows, 1, seed);
    }
}

/// Run it with `cargo test --release --workspace --lib hundred_thousand -- --ignored`.
#[test]
#[ignore = "takes long"]
fn every_box_holds_through_a_hundred_thousand_frames() {
    live_through(100_000, 1000, 5, 77);
}

#[test]
fn paths_leave_what_a_refit_of_all_boxes_leaves() {
    let mut random = Random::new(9);
    let mut boxes: Vec<Aabb> = (0..2000).map(|_| bounds(&mut random)).collect();
    let mut tree = InstanceTree::default();
    tree.update(&boxes, None);
    for _ in 0..200 {
        let rows: Vec<u32> = (0..3).map(|_| random.below(2000) as u32).collect();
        rows.iter()
            .for_each(|&row| boxes[row as usize] = bounds(&mut random));
        let (mut all, mut single) = (tree.clone(), tree.clone());
        single.paths = Price(0.0);
        single.refits = Price(1e9);
        single.builds = Price(1e12);
        single.cost_when_built = f32::MAX;
        assert_eq!(single.update(&boxes, Some(&rows)).action, TreeAction::Paths);
        all.refit(&boxes);
        assert!(single.nodes() == all.nodes());
        tree = single;
    }
}

#[test]
fn nothing_changed_is_no_work() {
    let mut random = Random::new(10);
    let boxes: Vec<Aabb> = (0..100).map(|_| bounds(&mut random)).collect();
    let mut tree = InstanceTree::default();
    assert_eq!(tree.update(&boxes, None).action, TreeAction::Rebuild);
    let work = tree.update(&boxes, Some(&[]));
    assert_eq!((work.action, work.nodes), (TreeAction::None, 0));
    assert!(tree.dirty().is_empty());
    // Told to look at a row that is as it was, it finds nothing to write.
    assert_eq!(tree.update(&boxes, Some(&[7])).nodes, 0);
}

#[test]
fn one_row_of_many_touches_one_path() {
    let mut random = Random::new(11);
    let mut boxes: Vec<Aabb> = (0..20_000).map(|_| bounds(&mut random)).collect();
    let mut tree = InstanceTree::default();
    tree.update(&boxes, None);
    boxes[77] = bounds(&mut random);
    let work = tree.update(&boxes, Some(&[77]));
    assert_eq!(work.action, TreeAction::Paths);
    assert!(work.nodes < 200, "{work:?}");
}

#[test]
fn a_tree_that_has_become_bad_is_built_anew() {
    let mut random = Random::new(12);
    let mut boxes: Vec<Aabb> = (0..1000).map(|_| bounds(&mut random)).collect();
    let mut tree = InstanceTree::default();
    tree.update(&boxes, None);
    boxes.iter_mut().for_each(|b| *b = bounds(&mut random));
    let work = tree.update(&boxes, None);
    assert_eq!(work.action, TreeAction::Rebuild);
    assert!(tree.cost() < 2.0 * work.cost_before, "{work:?}");
    tree.validate(&boxes).unwrap();
}

#[test]
fn strange_boxes_make_a_tree() {
    let mut random = Random::new(13);
    let point = |p: Vec3| Aabb { min: p, max: p };
    let nested = |i: i32| Vec3::splat(1.004_f32.powi(i));
    let scenes: [Vec<Aabb>; 7] = [
        vec![point(Vec3::ZERO); 5000],
        (0..3000)
            .map(|i| Aabb {
                min: -nested(i),
                max: nested(i),
            })
            .collect(),
        (0..3000).map(|i| point(Vec3::X * i as f32)).collect(),
        (0..3000)
            .map(|i| point(Vec3::splat(1.5_f32.powi(i % 200 - 100))))
            .collect(),
        (0..500)
            .map(|_| Aabb {
                min: Vec3::splat(-1e38),
                max: Vec3::splat(1e38),
            })
            .collect(),
        vec![
            Aabb {
                min: Vec3::NAN,
                max: Vec3::NAN,
            },
            bounds(&mut random),
            Aabb::EMPTY,
        ],
        (0..9000)
            .map(|i| point(place(&mut random) * if i < 9 { 1e9 } else { 1.0 }))
            .collect(),
    ];
    for boxes in &scenes {
        let mut tree = InstanceTree::default();
        tree.update(boxes, None);
        tree.validate(boxes).unwrap();
    }
}

#[test]
fn the_tree_does_not_depend_on_threads() {
    let mut random = Random::new(14);
    let boxes: Vec<Aabb> = (0..50_000).map(|_| bounds(&mut random)).collect();
    let build = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let mut tree = InstanceTree::default();
        pool.install(|| tree.update(&boxes, None));
        tree
    };
    let (one, three) = (build(1), build(3));
    assert!(one.nodes() == three.nodes());
    one.validate(&boxes).unwrap();
}
