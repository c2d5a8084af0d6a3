//! The search for ears against a plain one, polygons of many corners, and faces that cross themselves.

use std::collections::HashMap;

use super::super::clip::clip;
use super::super::ears::{Cut, is_between, take_ears};
use super::super::near::{encloses, turn};
use super::*;

/// Looks for the first ear from the start each time.
fn plainly(points: &[DVec2], ring: &[usize]) -> Cut {
    let mut ring = ring.to_vec();
    let mut cut = Cut::default();
    while ring.len() >= 3 {
        let count = ring.len();
        let three = |i: usize| {
            [
                ring[(i + count - 1) % count],
                ring[i],
                ring[(i + 1) % count],
            ]
        };
        let places = |i: usize| three(i).map(|corner| points[corner]);
        let is_spent = |&i: &usize| {
            let [a, b, c] = places(i);
            b == c || (turn(a, b, c) == 0.0 && a != b && !is_between(a, c, b))
        };
        if let Some(i) = (0..count).find(is_spent) {
            ring.remove(i);
            continue;
        }
        let turns = |&i: &usize| {
            let [a, b, c] = places(i);
            turn(a, b, c) > 0.0
        };
        let is_empty = |&i: &usize| !ring.iter().any(|&p| encloses(places(i), points[p]));
        let ear = (0..count).find(|i| turns(i) && is_empty(i));
        cut.is_knot |= ear.is_none();
        let Some(i) = ear.or_else(|| (0..count).find(turns)) else {
            cut.rest = ring.iter().map(|&corner| corner as u32).collect();
            break;
        };
        cut.triangles.push(three(i).map(|corner| corner as u32));
        ring.remove(i);
    }
    cut
}

#[test]
fn ears_are_those_of_a_plain_search() {
    let random = &mut Random(11);
    for round in 0..2_000 {
        let points = match round % 6 {
            4 => holed(random).remove(0),
            // Crosses itself, at whole numbers and elsewhere.
            5 => {
                let coarse = if round % 4 == 1 { 4.0 } else { 1e6 };
                let count = 3 + (random.unit() * 30.0) as usize;
                let mut point = || (DVec2::new(random.unit(), random.unit()) * coarse).floor();
                (0..count).map(|_| point()).collect()
            }
            kind => polygon(random, kind).remove(0),
        };
        let mut ring: Vec<usize> = (0..points.len()).collect();
        if round % 2 == 0 {
            ring.reverse();
        }
        let (found, expected) = (take_ears(&points, &ring), plainly(&points, &ring));
        assert_eq!(found, expected, "round {round}: {points:?}");
    }
}

/// The way around a random tree over a square of cells: four corners a cell.
fn maze(random: &mut Random, side: usize) -> Vec<DVec2> {
    // Which neighbours a cell is joined to: right, up, left, down.
    let mut joined = vec![[false; 4]; side * side];
    let mut seen = vec![false; side * side];
    let mut path = vec![0_usize];
    seen[0] = true;
    while let Some(&cell) = path.last() {
        let (x, y) = (cell % side, cell / side);
        let steps = [
            (x + 1 < side, cell + 1),
            (y + 1 < side, cell + side),
            (x > 0, cell.wrapping_sub(1)),
            (y > 0, cell.wrapping_sub(side)),
        ];
        let free: Vec<usize> = (0..4)
            .filter(|&way| steps[way].0 && !seen[steps[way].1])
            .collect();
        let Some(&way) = free.get((random.unit() * free.len() as f64) as usize) else {
            path.pop();
            continue;
        };
        let next = steps[way].1;
        joined[cell][way] = true;
        joined[next][(way + 2) % 4] = true;
        seen[next] = true;
        path.push(next);
    }
    // With the wall at the right hand, from quarter to quarter of the cells.
    let quarters = [[1, 0], [1, 1], [0, 1], [0, 0]];
    let mut corners = Vec::new();
    let (mut cell, mut quarter) = (0, 3);
    loop {
        let [dx, dy] = quarters[quarter];
        let whole = [2 * (cell % side) + dx, 2 * (cell / side) + dy];
        corners.push(DVec2::new(whole[0] as f64, whole[1] as f64));
        // Which side of the cell this quarter comes to as one goes around it counter-clockwise.
        let way = quarter;
        if joined[cell][way] {
            cell = match way {
                0 => cell + 1,
                1 => cell + side,
                2 => cell - 1,
                _ => cell - side,
            };
            quarter = (quarter + 3) % 4;
        } else {
            quarter = (quarter + 1) % 4;
        }
        if (cell, quarter) == (0, 3) {
            return corners;
        }
    }
}

#[test]
fn tens_of_thousands_of_corners_are_cut_whole() {
    let random = &mut Random(12);
    let teeth = 10_000;
    let turned = |p: &DVec2| DVec2::from_angle(0.7).rotate(*p);
    let shapes = [
        maze(random, 100),
        star(random, 40_000, 0.01),
        spiral(20_000, 1.5),
        comb(random, teeth).iter().map(turned).collect(),
    ];
    for (i, points) in shapes.iter().enumerate() {
        let cut = clip(points, std::slice::from_ref(&(0..points.len())));
        assert_eq!(cut.triangles.len(), points.len() - 2, "shape {i}");
        let area = |&[a, b, c]: &[u32; 3]| {
            let [a, b, c] = [a, b, c].map(|i| points[i as usize]);
            assert!(turn(a, b, c) > 0.0);
            (b - a).perp_dot(c - a) * 0.5
        };
        let found: f64 = cut.triangles.iter().map(area).sum();
        let expected = shoelace(&in_space(std::slice::from_ref(points), DVec3::ZERO).loops);
        assert!(
            (found / expected - 1.0).abs() < 1e-9,
            "shape {i}: {found} {expected}"
        );
    }
}

#[test]
fn a_ring_that_goes_around_and_around_is_cut() {
    let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(DVec2::from);
    let cut = clip(&square.repeat(10_000), std::slice::from_ref(&(0..40_000)));
    assert!(cut.triangles.len() + cut.rest.len() <= 40_000);
}

#[test]
fn thousands_of_holes_are_left_open() {
    let random = &mut Random(13);
    let side = 50;
    let mut loops = vec![
        [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
            .map(|corner| DVec2::from(corner) * f64::from(side))
            .to_vec(),
    ];
    for cell in 0..side * side {
        let place = DVec2::new(f64::from(cell % side), f64::from(cell / side)) + 0.5;
        let corners = star(random, 5, 0.2).into_iter();
        loops.push(corners.map(|p| p * 0.49 + place).collect());
    }
    let polygon = in_space(&loops, DVec3::ZERO);
    let mesh = triangulate(&polygon).unwrap();
    let corners: usize = loops.iter().map(Vec::len).sum();
    assert_eq!(mesh.triangles.len(), corners + 2 * loops.len() - 4);
    let areas = signed(&mesh, DVec3::Z);
    assert!(areas.iter().all(|&area| area >= 0.0));
    let (found, expected) = (areas.iter().sum::<f64>() * 0.5, shoelace(&polygon.loops));
    assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
}

/// How often the triangles go along an edge, ways back taken off.
fn outline(triangles: &[[u32; 3]]) -> HashMap<(u32, u32), i32> {
    let mut edges = HashMap::new();
    for &[a, b, c] in triangles {
        for (a, b) in [(a, b), (b, c), (c, a)] {
            *edges.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { 1 } else { -1 };
        }
    }
    edges.retain(|_, count| *count != 0);
    edges
}

#[test]
fn every_edge_of_a_face_has_a_triangle_even_if_it_crosses_itself() {
    let random = &mut Random(14);
    let mut twisted = 0;
    for round in 0..2_000 {
        let count = 3 + round as u32 % 9;
        let mut point = || DVec3::new(random.unit(), random.unit(), random.unit());
        let corners: Vec<DVec3> = (0..count).map(|_| point()).collect();
        let cut = triangulate_face(&corners).unwrap();
        assert_eq!(cut.triangles.len(), corners.len() - 2);
        let edges = (0..count).map(|i| match i + 1 < count {
            true => ((i, i + 1), 1),
            false => ((0, i), -1),
        });
        assert_eq!(outline(&cut.triangles), edges.collect(), "{corners:?}");
        twisted += usize::from(cut.is_twisted);
    }
    assert!(twisted > 200, "{twisted}");
}

#[test]
fn a_bow_tie_is_split_along_its_shorter_diagonal() {
    let bow = [(0.0, 0.0), (2.0, 1.0), (2.0, 0.0), (0.0, 1.0)];
    let bow = bow.map(|(x, y)| DVec3::new(x, y, 0.0));
    let cut = triangulate_face(&bow).unwrap();
    assert!(cut.is_twisted);
    assert_eq!(cut.triangles, [[0, 1, 2], [0, 2, 3]]);
    let square = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
    assert!(!triangulate_face(&square).unwrap().is_twisted);
    assert!(triangulate_face(&[DVec3::ZERO, DVec3::X, DVec3::X * 2.0, DVec3::X]).is_err());
    assert!(triangulate_face(&[DVec3::ZERO, DVec3::X, DVec3::NAN, DVec3::Y]).is_err());
}
