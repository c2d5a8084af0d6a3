//! Cuts polygons into triangles; [`super::derive_own_meshes`] does so once per change of the polygon.
//!
//! The plane of a polygon is that of Newell's normal, its corners need not lie in it: it is cut as it looks along that
//! normal's largest axis (dropping a coordinate rounds nothing), and vertices are not moved. The report (2008) tested
//! polygons by the even-odd rule in that same plane; the tests compare the two.

mod clip;

use std::ops::Range;

use glam::{DVec2, DVec3};

use super::{MeshData, Polygon};

/// Name of the mesh that a polygon is cut into.
pub(super) const POLYGON: &str = "polygon";

/// Triangles that cover the polygon's inside once, with the winding of its outer loop.
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
    let (axis, u, v) = dominant_axes(normal);
    let vertices: Vec<DVec3> = polygon.loops.iter().flatten().copied().collect();
    let flat: Vec<DVec2> = vertices.iter().map(|p| DVec2::new(p[u], p[v])).collect();
    let mut start = 0;
    let ranges: Vec<Range<usize>> = polygon
        .loops
        .iter()
        .map(|corners| {
            start += corners.len();
            start - corners.len()..start
        })
        .collect();
    let mut triangles = clip::clip(&flat, &ranges);
    if normal[axis] < 0.0 {
        triangles
            .iter_mut()
            .for_each(|[_, b, c]| std::mem::swap(b, c));
    }
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

/// The axis along which the normal is longest, and the other two in the order that keeps the winding seen against it.
fn dominant_axes(normal: DVec3) -> (usize, usize, usize) {
    let axis = normal.abs().max_position();
    (axis, (axis + 1) % 3, (axis + 2) % 3)
}

#[cfg(test)]
mod tests;
