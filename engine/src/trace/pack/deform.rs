//! Deformed vertices and their normals in f32, for both f32 tracers; called where meshes are packed.
//!
//! All is relative to the mesh's origin: the numbers of each step are shifted there in f64, once a frame, so a
//! mesh far from its own origin deforms as exactly as one near it. A vertex is a pure function of its numbers:
//! how many threads share the work changes no bit.

use glam::{Affine3A, DVec3, Vec3};
use rayon::prelude::*;

use crate::geom::{sin_cos, unit_or};
use crate::world::{DeformStep, Deformation, MeshData, SkinBinding};

/// Vertices a task of its own is worth: measured, 20 (key frames) to 45 (a twist) microseconds a step.
const PARALLEL: usize = 8192;

/// A step with its numbers relative to the mesh's origin.
enum Step<'a> {
    Keys {
        from: &'a [Vec3],
        to: &'a [Vec3],
        share: f32,
    },
    Morph {
        targets: Vec<(&'a [Vec3], f32)>,
    },
    Skin {
        binding: &'a SkinBinding,
        joints: Vec<Affine3A>,
    },
    Wave {
        wave: Vec3,
        amplitude: Vec3,
        phase: f32,
    },
    Twist {
        origin: Vec3,
        axis: Vec3,
        rate: f32,
        offset: f32,
    },
}

/// Every vertex of a mesh after its deformation, relative to the mesh's origin.
///
/// The deformation fits the mesh: sets and bindings of its count of vertices, joints that are there.
pub(super) fn deform_positions(mesh: &MeshData, deformation: &Deformation, out: &mut Vec<Vec3>) {
    out.clear();
    out.extend_from_slice(&mesh.positions);
    let steps: Vec<Step> = deformation
        .steps
        .iter()
        .map(|step| shifted(step, mesh.origin))
        .collect();
    if steps.is_empty() {
        return;
    }
    out.par_chunks_mut(PARALLEL)
        .enumerate()
        .for_each(|(chunk, positions)| {
            for step in &steps {
                step.apply(chunk * PARALLEL, positions);
            }
        });
}

/// A step as f32 tracers evaluate it.
fn shifted(step: &DeformStep, mesh_origin: DVec3) -> Step<'_> {
    let reduced = |radians: f64| {
        let turns = radians / std::f64::consts::TAU;
        ((turns - turns.round()) * std::f64::consts::TAU) as f32
    };
    match step {
        DeformStep::Keys {
            keys,
            from,
            to,
            share,
        } => Step::Keys {
            from: keys.set(*from),
            to: keys.set(*to),
            share: *share as f32,
        },
        DeformStep::Morph { targets, weights } => {
            let sets = (0..).zip(weights).filter(|(_, weight)| **weight != 0.0);
            Step::Morph {
                targets: sets
                    .map(|(set, &weight)| (targets.set(set), weight as f32))
                    .collect(),
            }
        }
        DeformStep::Skin { binding, joints } => Step::Skin {
            binding,
            joints: joints
                .iter()
                .map(|joint| {
                    let mut joint = *joint;
                    joint.translation = joint.transform_point3(mesh_origin) - mesh_origin;
                    Affine3A::from_mat3_translation(
                        joint.matrix3.as_mat3(),
                        joint.translation.as_vec3(),
                    )
                })
                .collect(),
        },
        DeformStep::Wave {
            wave,
            amplitude,
            phase,
        } => Step::Wave {
            wave: wave.as_vec3(),
            amplitude: amplitude.as_vec3(),
            phase: reduced(phase - wave.dot(mesh_origin)),
        },
        DeformStep::Twist {
            origin,
            axis,
            rate,
            offset,
        } => {
            // The point of the line beside the mesh's origin stands for any other.
            let along = (mesh_origin - *origin).dot(*axis);
            Step::Twist {
                origin: (*origin + *axis * along - mesh_origin).as_vec3(),
                axis: axis.as_vec3(),
                rate: *rate as f32,
                offset: reduced(rate * along + offset),
            }
        }
    }
}

impl Step<'_> {
    /// Deforms the vertices from number `first` on.
    fn apply(&self, first: usize, positions: &mut [Vec3]) {
        let range = first..first + positions.len();
        match self {
            Self::Keys { from, to, share } => {
                let sets = from[range.clone()].iter().zip(&to[range]);
                for (p, (&from, &to)) in positions.iter_mut().zip(sets) {
                    *p = from * (1.0 - share) + to * *share;
                }
            }
            Self::Morph { targets } => {
                for (target, weight) in targets {
                    for (p, &offset) in positions.iter_mut().zip(&target[range.clone()]) {
                        *p += offset * *weight;
                    }
                }
            }
            Self::Skin { binding, joints } => {
                let bound = binding.joints[range.clone()]
                    .iter()
                    .zip(&binding.weights[range]);
                for (p, (numbers, weights)) in positions.iter_mut().zip(bound) {
                    let mut sum = Vec3::ZERO;
                    for (&joint, &weight) in numbers.iter().zip(weights) {
                        sum += joints[joint as usize].transform_point3(*p) * weight;
                    }
                    *p = sum;
                }
            }
            Self::Wave {
                wave,
                amplitude,
                phase,
            } => {
                for p in positions {
                    *p += *amplitude * sin_cos(wave.dot(*p) - phase).0;
                }
            }
            Self::Twist {
                origin,
                axis,
                rate,
                offset,
            } => {
                for p in positions {
                    let out = *p - *origin;
                    let along = out.dot(*axis);
                    let (sin, cos) = sin_cos(rate * along + offset);
                    // Rodrigues' formula.
                    let turned = out * cos + axis.cross(out) * sin + *axis * (along * (1.0 - cos));
                    *p = *origin + turned;
                }
            }
        }
    }
}

/// The triangles around each vertex, in order of their number.
pub(super) struct Adjacency {
    /// Triangles of vertex v are `triangles[starts[v]..starts[v + 1]]`.
    starts: Vec<u32>,
    triangles: Vec<u32>,
}

impl Adjacency {
    /// Of a mesh; stays true while its triangles do, whatever its vertices do.
    pub(super) fn of(mesh: &MeshData) -> Self {
        let mut starts = vec![0_u32; mesh.vertices.len() + 1];
        for &corner in mesh.triangles.iter().flatten() {
            starts[corner as usize + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut next = starts.clone();
        let mut triangles = vec![0; mesh.triangles.len() * 3];
        for (number, triangle) in (0..).zip(&mesh.triangles) {
            for &corner in triangle {
                let place = &mut next[corner as usize];
                triangles[*place as usize] = number;
                *place += 1;
            }
        }
        Self { starts, triangles }
    }
}

/// Unit normals of a smooth mesh's vertices: the mean of the triangles around each, weighted by their area.
///
/// Where they cancel out, the normal at rest stands. A flat mesh gives none.
pub(super) fn vertex_normals(
    mesh: &MeshData,
    adjacency: &Adjacency,
    positions: &[Vec3],
    out: &mut Vec<Vec3>,
) {
    let normal = |vertex: usize| {
        let range = adjacency.starts[vertex] as usize..adjacency.starts[vertex + 1] as usize;
        let mut sum = Vec3::ZERO;
        for &triangle in &adjacency.triangles[range] {
            let [a, b, c] = mesh.triangles[triangle as usize].map(|i| positions[i as usize]);
            sum += (b - a).cross(c - a);
        }
        unit_or(sum, mesh.normals[vertex])
    };
    (0..mesh.normals.len())
        .into_par_iter()
        .with_min_len(PARALLEL / 4)
        .map(normal)
        .collect_into_vec(out);
}

#[cfg(test)]
mod tests;
