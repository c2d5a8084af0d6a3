//! Deformed meshes in f64, each step as its formula is written; shares nothing with the f32 evaluation.

use glam::DVec3;

use crate::world::{DeformStep, Deformation, MeshData};

/// The vertices of a mesh after its deformation, in the mesh's own space.
pub fn vertices(mesh: &MeshData, deformation: Option<&Deformation>) -> Vec<DVec3> {
    let steps = deformation.map_or(&[][..], |deformation| &deformation.steps);
    let vertex = |(index, &at_rest): (usize, &DVec3)| {
        steps
            .iter()
            .fold(at_rest, |p, step| moved(step, mesh.origin, index, p))
    };
    mesh.vertices.iter().enumerate().map(vertex).collect()
}

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

/// Where a step takes a vertex.
fn moved(step: &DeformStep, origin: DVec3, index: usize, p: DVec3) -> DVec3 {
    match step {
        DeformStep::Keys {
            keys,
            from,
            to,
            share,
        } => {
            let from = keys.set(*from)[index].as_dvec3();
            let to = keys.set(*to)[index].as_dvec3();
            origin + from * (1.0 - share) + to * *share
        }
        DeformStep::Morph { targets, weights } => {
            let offsets = (0..).zip(weights);
            let offsets = offsets.map(|(set, weight)| targets.set(set)[index].as_dvec3() * *weight);
            p + offsets.sum::<DVec3>()
        }
        DeformStep::Skin { binding, joints } => {
            let weights = binding.weights[index].map(f64::from);
            let carried = binding.joints[index]
                .iter()
                .zip(weights)
                .map(|(&joint, weight)| joints[joint as usize].transform_point3(p) * weight);
            // Weights are f32: their sum is 1 but for their last bits.
            carried.sum::<DVec3>() / weights.iter().sum::<f64>()
        }
        DeformStep::Wave {
            wave,
            amplitude,
            phase,
        } => p + *amplitude * (wave.dot(p) - phase).sin(),
        DeformStep::Twist {
            origin,
            axis,
            rate,
            offset,
        } => {
            let angle = rate * (p - *origin).dot(*axis) + offset;
            *origin + glam::DQuat::from_axis_angle(*axis, angle) * (p - *origin)
        }
    }
}
