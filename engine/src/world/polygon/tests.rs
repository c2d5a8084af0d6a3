//! Cutting polygons against shoelace areas and the report's even-odd rule.

use glam::{DMat3, DVec2, DVec3};

use super::*;

mod large;

/// A linear congruential generator.
pub(super) struct Random(pub(super) u64);

impl Random {
    pub(super) fn unit(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn range(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.unit()
    }
}

/// Around the origin, each corner at its own distance.
fn star(random: &mut Random, corners: usize, least: f64) -> Vec<DVec2> {
    let turn = std::f64::consts::TAU / corners as f64;
    let angles = (0..corners).map(|i| (i as f64 + random.range(0.05, 0.95)) * turn);
    let angles: Vec<f64> = angles.collect();
    let corner = |angle: f64| DVec2::from_angle(angle) * random.range(least, 1.0);
    angles.into_iter().map(corner).collect()
}

/// Teeth as thin as 1e-9 on a bar.
fn comb(random: &mut Random, teeth: usize) -> Vec<DVec2> {
    let mut corners = vec![DVec2::new(0.0, -1.0), DVec2::new(2.0 * teeth as f64, -1.0)];
    for tooth in (0..teeth).rev() {
        let middle = 2.0 * tooth as f64 + 1.0;
        let half = 10_f64.powf(random.range(-9.0, -0.1));
        let tip = random.range(0.1, 50.0);
        corners
            .extend([(middle + half, 0.0), (middle, tip), (middle - half, 0.0)].map(DVec2::from));
    }
    corners
}

fn spiral(corners: usize, width: f64) -> Vec<DVec2> {
    let at = |i: usize, width: f64| {
        let angle = i as f64 * 0.3;
        DVec2::from_angle(angle) * (1.0 + angle + width)
    };
    let inner = (0..corners).map(|i| at(i, 0.0));
    inner
        .chain((0..corners).rev().map(|i| at(i, width)))
        .collect()
}

/// Steps with corners on straight edges, some at one place, all at whole numbers.
fn steps(random: &mut Random, columns: usize) -> Vec<DVec2> {
    let mut corners = Vec::new();
    for x in 0..columns {
        let height = (random.unit() * 8.0).floor() + 1.0;
        corners.extend([(x as f64, height), (x as f64 + 1.0, height)].map(DVec2::from));
    }
    corners.extend((0..=columns).rev().map(|x| DVec2::new(x as f64, 0.0)));
    corners
}

/// A round loop with holes in it.
fn holed(random: &mut Random) -> Vec<Vec<DVec2>> {
    let mut loops = vec![star(random, 30, 0.8)];
    for i in 0..5 {
        let place = DVec2::from_angle(f64::from(i) * 1.25) * 0.45;
        let mut hole = star(random, 9, 0.2);
        hole.iter_mut().for_each(|p| *p = *p * 0.2 + place);
        loops.push(hole);
    }
    loops
}

/// A random polygon, simple by construction.
fn polygon(random: &mut Random, kind: usize) -> Vec<Vec<DVec2>> {
    let corners = 3 + (random.unit() * 40.0) as usize;
    match kind {
        0 => vec![star(random, corners.max(5), 0.01)],
        1 => vec![comb(random, corners)],
        2 => {
            let width = random.range(0.001, 1.8);
            vec![spiral(corners, width)]
        }
        3 => vec![steps(random, corners)],
        _ => holed(random),
    }
}

/// Into space, on a plane that keeps the coordinates as they are.
fn in_space(loops: &[Vec<DVec2>], shift: DVec3) -> Polygon {
    let place = |p: &DVec2| DVec3::new(p.x, p.y, 0.0) + shift;
    Polygon {
        loops: loops
            .iter()
            .map(|l| l.iter().map(place).collect())
            .collect(),
    }
}

fn shoelace(loops: &[Vec<DVec3>]) -> f64 {
    let areas = loops.iter().map(|l| newell_normal(l).length() * 0.5);
    areas
        .enumerate()
        .map(|(i, a)| if i == 0 { a } else { -a })
        .sum()
}

/// Twice the areas with their sign along an axis.
fn signed(mesh: &MeshData, axis: DVec3) -> Vec<f64> {
    let corners = |t: &[u32; 3]| t.map(|i| mesh.vertices[i as usize]);
    let area = |t| newell_normal(&corners(t)).dot(axis);
    mesh.triangles.iter().map(area).collect()
}

#[test]
fn triangles_cover_the_shoelace_area_and_none_is_turned_over() {
    let random = &mut Random(1);
    for round in 0..3_000 {
        let loops = polygon(random, round % 5);
        let shift = if round % 2 == 0 {
            DVec3::ZERO
        } else {
            DVec3::new(4096.0, -8192.0, 1e7)
        };
        let polygon = in_space(&loops, shift);
        let mesh = triangulate(&polygon).unwrap();
        let areas = signed(&mesh, newell_normal(&polygon.loops[0]).normalize());
        assert!(
            areas.iter().all(|&a| a >= 0.0),
            "round {round}: a triangle is turned over"
        );
        let (found, expected) = (areas.iter().sum::<f64>() * 0.5, shoelace(&polygon.loops));
        let off = (found - expected).abs() / expected;
        assert!(
            off < 1e-12,
            "round {round}: area {found}, expected {expected}"
        );
        if round % 5 != 3 {
            let corners: usize = loops.iter().map(Vec::len).sum();
            let expected = corners + 2 * loops.len() - 4;
            assert_eq!(mesh.triangles.len(), expected, "round {round}");
        }
    }
}

/// The report's test of a point: how many edges are left of it, in the plane.
fn is_inside(loops: &[Vec<DVec2>], p: DVec2) -> bool {
    let mut inside = false;
    for corners in loops {
        for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            if (a.y > p.y) != (b.y > p.y) && p.x < (b.x - a.x) * (p.y - a.y) / (b.y - a.y) + a.x {
                inside = !inside;
            }
        }
    }
    inside
}

#[test]
fn a_million_points_are_inside_where_the_even_odd_rule_says_so() {
    let random = &mut Random(2);
    let mut tried = 0;
    for round in 0..1_000 {
        let loops = polygon(random, round % 5);
        let polygon = in_space(&loops, DVec3::ZERO);
        let mesh = triangulate(&polygon).unwrap();
        let winding = newell_normal(&polygon.loops[0]).z.signum();
        let flat: Vec<DVec2> = mesh.vertices.iter().map(|v| v.truncate()).collect();
        let low = flat.iter().copied().reduce(DVec2::min).unwrap();
        let high = flat.iter().copied().reduce(DVec2::max).unwrap();
        for _ in 0..1_000 {
            let p = DVec2::new(random.range(low.x, high.x), random.range(low.y, high.y));
            let covers = |t: &&[u32; 3]| {
                let [a, b, c] = t.map(|i| flat[i as usize]);
                let edges = [(a, b), (b, c), (c, a)];
                edges
                    .iter()
                    .all(|&(a, b)| (b - a).perp_dot(p - a) * winding > 0.0)
            };
            let covered = mesh.triangles.iter().filter(covers).count();
            assert_eq!(
                covered,
                usize::from(is_inside(&loops, p)),
                "round {round} at {p}"
            );
            tried += 1;
        }
    }
    assert_eq!(tried, 1_000_000);
}

#[test]
fn corners_on_a_straight_edge_stay_corners() {
    let square = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)].map(DVec2::from);
    let mesh = triangulate(&in_space(&[square.to_vec()], DVec3::ZERO)).unwrap();
    assert_eq!(mesh.triangles.len(), 3);
    assert!(mesh.triangles.iter().flatten().any(|&i| i == 1));
}

#[test]
fn the_winding_is_the_polygons_own_in_every_plane() {
    let random = &mut Random(3);
    for _ in 0..200 {
        let axis = DVec3::new(
            random.range(-1.0, 1.0),
            random.range(-1.0, 1.0),
            random.range(-1.0, 1.0),
        );
        let turn = DMat3::from_axis_angle(axis.normalize(), random.range(0.0, 6.0));
        let flat = in_space(&holed(random), DVec3::new(0.0, 0.0, 3.0));
        let turned = |l: &Vec<DVec3>| l.iter().map(|&p| turn * p).collect();
        let polygon = Polygon {
            loops: flat.loops.iter().map(turned).collect(),
        };
        let mesh = triangulate(&polygon).unwrap();
        let normal = newell_normal(&polygon.loops[0]).normalize();
        assert!(signed(&mesh, normal).iter().all(|&a| a > -1e-12));
    }
}

#[test]
fn a_quad_that_warps_keeps_its_triangles_and_moves_no_corner() {
    let quad = |lift: f64| vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, lift), DVec3::Y];
    let flat = triangulate(&Polygon {
        loops: vec![quad(0.0)],
    })
    .unwrap();
    for step in -100..=100 {
        let corners = quad(f64::from(step) * 0.01);
        let mesh = triangulate(&Polygon {
            loops: vec![corners.clone()],
        })
        .unwrap();
        assert_eq!(mesh.triangles, flat.triangles);
        assert_eq!(mesh.vertices, corners);
    }
}

#[test]
fn whatever_crosses_itself_is_cut_somehow() {
    let random = &mut Random(4);
    for _ in 0..500 {
        let corners = 3 + (random.unit() * 20.0) as usize;
        let mut point = || (random.unit() * 5.0).floor();
        let tangle = |point: &mut dyn FnMut() -> f64| {
            (0..corners)
                .map(|_| DVec2::new(point(), point()))
                .collect::<Vec<_>>()
        };
        let loops = [tangle(&mut point), tangle(&mut point)];
        if let Ok(mesh) = triangulate(&in_space(&loops, DVec3::ZERO)) {
            assert!(mesh.triangles.len() <= 2 * corners);
        }
    }
}

#[test]
fn the_normal_of_a_square_far_away_is_twice_its_area_long() {
    let far = DVec3::new(1e7, -2e7, 3e7);
    let square = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)];
    let square = square.map(|(x, y)| far + DVec3::new(x, y, 0.0));
    assert_eq!(newell_normal(&square), DVec3::Z * 8.0);
    assert_eq!(newell_normal(&[]), DVec3::ZERO);
}

#[test]
fn a_polygon_without_area_is_refused() {
    let line = vec![DVec3::ZERO, DVec3::X, DVec3::X * 2.0];
    assert!(triangulate(&Polygon { loops: vec![line] }).is_err());
    assert!(triangulate(&Polygon { loops: vec![] }).is_err());
    let nan = vec![DVec3::ZERO, DVec3::X, DVec3::NAN];
    assert!(triangulate(&Polygon { loops: vec![nan] }).is_err());
    let square = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
    let hole = vec![DVec3::NAN; 3];
    assert!(
        triangulate(&Polygon {
            loops: vec![square, hole]
        })
        .is_err()
    );
}
