//! Cuts polygons into triangles; [`super::derive_own_meshes`] does so once per change of the polygon.
//!
//! Ear clipping (the `earcutr` crate) in the dominant plane of Newell's normal; vertices are not moved.
//! The report (2008) tested polygons by even-odd rule in that same plane; the tests compare the two.

use glam::DVec3;

use super::{MeshData, Polygon};

/// Name of the mesh that a polygon is cut into.
pub(super) const POLYGON: &str = "polygon";

/// Triangles that cover the polygon's inside once.
///
/// # Errors
/// A sentence: fewer than three corners, no area, or a corner that is not finite.
pub fn triangulate(polygon: &Polygon) -> Result<MeshData, String> {
    let outer = polygon.loops.first().ok_or("it has no loop")?;
    if let Some(short) = polygon.loops.iter().position(|l| l.len() < 3) {
        return Err(format!("loop {short} has fewer than 3 corners"));
    }
    let normal = newell_normal(outer);
    if !(normal.length_squared() > 0.0) {
        return Err("its outer loop has no area, or a corner is not finite".into());
    }
    let (u, v) = dominant_axes(normal);
    let vertices: Vec<DVec3> = polygon.loops.iter().flatten().copied().collect();
    let flat: Vec<f64> = vertices.iter().flat_map(|p| [p[u], p[v]]).collect();
    let holes: Vec<usize> = polygon
        .loops
        .iter()
        .scan(0, |start, l| {
            *start += l.len();
            Some(*start)
        })
        .take(polygon.loops.len() - 1)
        .collect();
    let corners =
        earcutr::earcut(&flat, &holes, 2).map_err(|e| format!("it cannot be cut: {e:?}"))?;
    let triangles: Vec<[u32; 3]> = corners
        .chunks_exact(3)
        .map(|c| [c[0] as u32, c[1] as u32, c[2] as u32])
        .collect();
    if triangles.is_empty() {
        return Err("no triangle came out of cutting it".into());
    }
    MeshData::new(POLYGON, vertices, Vec::new(), triangles)
}

/// Twice the area times the unit normal of a loop (Newell's method: robust for concave loops).
///
/// Relative to the first corner, so that loops far from the origin keep their digits; zero for no corner.
pub fn newell_normal(corners: &[DVec3]) -> DVec3 {
    let shift = corners.first().copied().unwrap_or_default();
    corners
        .iter()
        .zip(corners.iter().cycle().skip(1))
        .map(|(&a, &b)| (a - shift).cross(b - shift))
        .sum()
}

/// The two axes that keep the most area when the third is dropped.
fn dominant_axes(normal: DVec3) -> (usize, usize) {
    let n = normal.abs();
    if n.x >= n.y && n.x >= n.z {
        (1, 2)
    } else if n.y >= n.z {
        (2, 0)
    } else {
        (0, 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(mesh: &MeshData) -> f64 {
        mesh.triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| mesh.vertices[i as usize]);
                (b - a).cross(c - a).length() * 0.5
            })
            .sum()
    }

    fn star(points: usize) -> Vec<DVec3> {
        (0..2 * points)
            .map(|i| {
                let radius = if i % 2 == 0 { 1.0 } else { 0.4 };
                let angle = i as f64 * std::f64::consts::PI / points as f64;
                DVec3::new(radius * angle.cos(), 0.3, radius * angle.sin())
            })
            .collect()
    }

    #[test]
    fn triangles_of_a_star_cover_its_shoelace_area() {
        let corners = star(7);
        let expected = newell_normal(&corners).length() * 0.5;
        let mesh = triangulate(&Polygon {
            loops: vec![corners],
        })
        .unwrap();
        assert!(
            (area(&mesh) - expected).abs() < 1e-12,
            "{} != {expected}",
            area(&mesh)
        );
    }

    #[test]
    fn the_normal_of_a_square_far_away_is_twice_its_area_long() {
        let far = DVec3::new(1e7, -2e7, 3e7);
        let square = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)]
            .map(|(x, y)| far + DVec3::new(x, y, 0.0));
        assert_eq!(newell_normal(&square), DVec3::Z * 8.0);
        assert_eq!(newell_normal(&[]), DVec3::ZERO);
    }

    #[test]
    fn a_hole_is_left_open() {
        let square = |half: f64| {
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                .map(|(x, y)| DVec3::new(x * half, y * half, 0.0))
                .to_vec()
        };
        let mesh = triangulate(&Polygon {
            loops: vec![square(2.0), square(1.0)],
        })
        .unwrap();
        assert!((area(&mesh) - 12.0).abs() < 1e-12, "{}", area(&mesh));
    }

    #[test]
    fn a_polygon_without_area_is_refused() {
        let line = vec![DVec3::ZERO, DVec3::X, DVec3::X * 2.0];
        assert!(triangulate(&Polygon { loops: vec![line] }).is_err());
        assert!(triangulate(&Polygon { loops: vec![] }).is_err());
        let nan = vec![DVec3::ZERO, DVec3::X, DVec3::NAN];
        assert!(triangulate(&Polygon { loops: vec![nan] }).is_err());
    }
}
