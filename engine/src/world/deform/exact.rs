//! Deformed vertices in f64, each step as its formula is written: what the reference traces, and what is framed. Shares
//! nothing with the f32 evaluation.

use glam::DVec3;
use rayon::prelude::*;

use super::{DeformStep, Deformation};
use crate::world::MeshData;

/// The vertices of a mesh after its deformation, in the mesh's own space.
pub fn deformed_vertices(mesh: &MeshData, deformation: Option<&Deformation>) -> Vec<DVec3> {
    let steps = deformation.map_or(&[][..], |deformation| &deformation.steps);
    let vertex = |(index, &at_rest): (usize, &DVec3)| {
        steps
            .iter()
            .fold(at_rest, |p, step| moved(step, mesh.origin, index, p))
    };
    mesh.vertices.par_iter().enumerate().map(vertex).collect()
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
