//! Cuts polygons into triangles; [`super::derive_own_meshes`] does so once per change of the polygon.
//!
//! The plane of a polygon is that of Newell's normal, its corners need not lie in it: it is cut as it looks along that
//! normal's largest axis (dropping a coordinate rounds nothing), and vertices are not moved. The report (2008) tested
//! polygons by the even-odd rule in that same plane; the tests compare the two.

mod clip;
mod ears;
mod edges;
mod near;

use std::ops::Range;

use glam::{DVec2, DVec3};

use super::{MeshData, Polygon};
use ears::Cut;

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
    let vertices: Vec<DVec3> = polygon.loops.iter().flatten().copied().collect();
    let mut start = 0;
    let ranges: Vec<Range<usize>> = polygon
        .loops
        .iter()
        .map(|corners| {
            start += corners.len();
            start - corners.len()..start
        })
        .collect();
    let triangles = cut(&vertices, &ranges, normal).triangles;
    if triangles.is_empty() {
        return Err("no triangle came out of cutting it".into());
    }
    MeshData::new(POLYGON, vertices, Vec::new(), triangles)
}

/// What a face of a file is cut into.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceCut {
    /// By number of the corner, with the face's winding.
    pub triangles: Vec<[u32; 3]>,
    /// The face crosses itself, as it looks along its normal: its triangles fold over one another.
    pub is_twisted: bool,
}

/// Triangles between all corners of a face, also of one that crosses itself: no edge of it is left without a triangle,
/// so that meshes have no holes.
///
/// # Errors
/// A sentence: fewer than three corners, no area, or a corner that is not finite.
pub fn triangulate_face(corners: &[DVec3]) -> Result<FaceCut, String> {
    if corners.len() < 3 {
        return Err("it has fewer than three corners".into());
    }
    if !corners.iter().all(|corner| corner.is_finite()) {
        return Err("a corner is not finite".into());
    }
    let normal = newell_normal(corners);
    let flat = match normal.length_squared() > 0.0 {
        true => cut(corners, std::slice::from_ref(&(0..corners.len())), normal),
        false => Cut {
            is_knot: true,
            rest: (0..corners.len() as u32).collect(),
            ..Cut::default()
        },
    };
    let mut triangles = flat.triangles;
    match (flat.is_knot, corners) {
        (true, &[a, b, c, d]) => triangles = quad(&[a, b, c, d]),
        _ => triangles.extend(fan(&flat.rest)),
    }
    let has_area = |t: &[u32; 3]| newell_normal(&t.map(|i| corners[i as usize])) != DVec3::ZERO;
    if !triangles.iter().any(has_area) {
        return Err("it has no area".into());
    }
    Ok(FaceCut {
        triangles,
        is_twisted: flat.is_knot,
    })
}

/// Two triangles that meet at the shorter diagonal.
fn quad([a, b, c, d]: &[DVec3; 4]) -> Vec<[u32; 3]> {
    match a.distance_squared(*c) <= b.distance_squared(*d) {
        true => vec![[0, 1, 2], [0, 2, 3]],
        false => vec![[0, 1, 3], [1, 2, 3]],
    }
}

/// Triangles from the first of these corners to all others.
fn fan(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    let first = corners.first().copied().unwrap_or_default();
    let rest = corners.get(1..).unwrap_or_default();
    rest.windows(2).map(move |pair| [first, pair[0], pair[1]])
}

/// Cuts loops as they look along the largest axis of a normal, with the winding of the first.
fn cut(vertices: &[DVec3], loops: &[Range<usize>], normal: DVec3) -> Cut {
    let (axis, u, v) = dominant_axes(normal);
    let flat: Vec<DVec2> = vertices.iter().map(|p| DVec2::new(p[u], p[v])).collect();
    let mut cut = clip::clip(&flat, loops);
    if normal[axis] < 0.0 {
        for [_, b, c] in &mut cut.triangles {
            std::mem::swap(b, c);
        }
        cut.rest.reverse();
    }
    cut
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
