//! Normals of deformed meshes in f64; shares nothing with the f32 evaluation.

use glam::DVec3;

use crate::world::MeshData;

/// Unit normals of a smooth mesh's vertices; none for a flat one.
///
/// At rest those of the mesh; deformed, the mean of the deformed triangles around each vertex by their area.
pub fn normals(mesh: &MeshData, is_deformed: bool, vertices: &[DVec3]) -> Vec<DVec3> {
    let at_rest = mesh.normals.iter().map(|normal| normal.as_dvec3());
    if !is_deformed || mesh.normals.is_empty() {
        return at_rest.collect();
    }
    let mut sums = vec![DVec3::ZERO; vertices.len()];
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|corner| vertices[corner as usize]);
        for corner in triangle {
            sums[*corner as usize] += (b - a).cross(c - a);
        }
    }
    let unit = |(sum, at_rest): (DVec3, DVec3)| sum.try_normalize().unwrap_or(at_rest);
    sums.into_iter().zip(at_rest).map(unit).collect()
}
