//! Deformations on the device: what stays there, and what each frame says.
//!
//! Positions at rest, poses, targets, bindings and the faces around vertices go up once and stay while
//! somebody holds them; a frame brings parameters alone. Everything is relative to the mesh's origin, so
//! points of a step's own space are shifted in f64 before they become f32.

use std::collections::HashMap;
use std::sync::Arc;

use bytemuck::{Zeroable, cast_slice};
use glam::{DAffine3, DVec3, Vec3};

use super::DeformedMesh;
use crate::frame::wire::{STEP_KEYS, STEP_MORPH, STEP_SKIN, STEP_TWIST, STEP_WAVE, StepRow};
use crate::trace::TraceError;
use crate::trace::gpu::buffers::RowBuffer;
use crate::trace::gpu::context::Gpu;
use crate::world::{DeformStep, MeshData, SkinBinding, VertexSets};

/// What lies among the data, held so that its address stays its own.
#[derive(Clone)]
enum Source {
    /// Positions at rest.
    Rest(Arc<MeshData>),
    /// Normals at rest, ends of the corners of each vertex, pairs of corners.
    Faces(Arc<MeshData>),
    /// Poses or targets.
    Sets(Arc<VertexSets>),
    /// Joints, then weights.
    Skin(Arc<SkinBinding>),
}

impl Source {
    fn key(&self) -> (u8, usize) {
        match self {
            Self::Rest(mesh) => (0, Arc::as_ptr(mesh) as usize),
            Self::Faces(mesh) => (1, Arc::as_ptr(mesh) as usize),
            Self::Sets(sets) => (2, Arc::as_ptr(sets) as usize),
            Self::Skin(binding) => (3, Arc::as_ptr(binding) as usize),
        }
    }

    /// Whether anybody else still holds it.
    fn is_alive(&self) -> bool {
        // A mesh may be here twice: at rest and by its faces.
        match self {
            Self::Rest(mesh) | Self::Faces(mesh) => Arc::strong_count(mesh) > 2,
            Self::Sets(sets) => Arc::strong_count(sets) > 1,
            Self::Skin(binding) => Arc::strong_count(binding) > 1,
        }
    }

    fn append_to(&self, data: &mut Vec<u32>) {
        let vectors = |data: &mut Vec<u32>, all: &[Vec3]| {
            data.extend(all.iter().flat_map(|v| v.to_array().map(f32::to_bits)));
        };
        match self {
            Self::Rest(mesh) => vectors(data, &mesh.positions),
            Self::Sets(sets) => vectors(data, &sets.values),
            Self::Faces(mesh) => {
                vectors(data, &mesh.normals);
                append_faces(data, mesh);
            }
            Self::Skin(binding) => {
                data.extend(binding.joints.iter().flatten());
                data.extend(binding.weights.iter().flatten().map(|w| w.to_bits()));
            }
        }
    }
}

/// For each vertex the two other corners of its faces, in the faces' own order around.
fn append_faces(data: &mut Vec<u32>, mesh: &MeshData) {
    let vertices = mesh.positions.len();
    let mut ends = vec![0_u32; vertices + 1];
    for &corner in mesh.triangles.iter().flatten() {
        ends[corner as usize + 1] += 1;
    }
    for i in 0..vertices {
        ends[i + 1] += ends[i];
    }
    let mut pairs = vec![[0_u32; 2]; ends[vertices] as usize];
    let mut next = ends.clone();
    for &[a, b, c] in &mesh.triangles {
        for (corner, pair) in [(a, [b, c]), (b, [c, a]), (c, [a, b])] {
            let place = &mut next[corner as usize];
            pairs[*place as usize] = pair;
            *place += 1;
        }
    }
    data.extend(ends);
    data.extend(pairs.iter().flatten());
}

/// What stays on the device.
pub(super) struct DeformData {
    pub(super) buffer: RowBuffer,
    places: HashMap<(u8, usize), (Source, u32)>,
    /// Words in use.
    used: usize,
}

impl DeformData {
    pub(super) fn new(gpu: &Gpu) -> Self {
        Self {
            buffer: RowBuffer::new(gpu, "deformation data", wgpu::BufferUsages::STORAGE, 16),
            places: HashMap::new(),
            used: 0,
        }
    }

    /// Brings up what these meshes need and the device lacks; returns the bytes written.
    ///
    /// # Errors
    /// [`TraceError::TooLarge`].
    pub(super) fn bring(&mut self, gpu: &Gpu, meshes: &[DeformedMesh]) -> Result<u64, TraceError> {
        let mut lacking: Vec<Source> = Vec::new();
        for mesh in meshes {
            for source in sources(mesh) {
                let key = source.key();
                let is_new = lacking.iter().all(|other| other.key() != key);
                if is_new && !self.places.contains_key(&key) {
                    lacking.push(source);
                }
            }
        }
        if lacking.is_empty() {
            return Ok(0);
        }
        let mut words = Vec::new();
        let mut first = self.used;
        let places = place_all(&lacking, first, &mut words);
        if (first + words.len()) as u64 * 4 > self.buffer.buffer().size() {
            // A larger buffer holds nothing yet, and what nobody holds any more need not move along.
            let kept = self.places.drain().map(|(_, (source, _))| source);
            let mut all: Vec<Source> = kept.filter(Source::is_alive).collect();
            all.append(&mut lacking);
            words.clear();
            first = 0;
            let places = place_all(&all, first, &mut words);
            self.buffer.reserve(gpu, words.len() as u64 * 4)?;
            self.places = places;
        } else {
            self.places.extend(places);
        }
        self.used = first + words.len();
        Ok(self.buffer.write(gpu, first as u64 * 4, cast_slice(&words)))
    }

    /// Where a mesh's positions at rest begin.
    pub(super) fn rest(&self, mesh: &Arc<MeshData>) -> u32 {
        self.place(&Source::Rest(Arc::clone(mesh)))
    }

    /// Where a smooth mesh's normals at rest begin; ends and pairs of corners follow.
    pub(super) fn faces(&self, mesh: &Arc<MeshData>) -> u32 {
        self.place(&Source::Faces(Arc::clone(mesh)))
    }

    fn place(&self, source: &Source) -> u32 {
        self.places[&source.key()].1
    }

    /// Appends the steps of a deformation, and their parameters.
    pub(super) fn append_steps(
        &self,
        mesh: &DeformedMesh,
        steps: &mut Vec<StepRow>,
        params: &mut Vec<[f32; 4]>,
    ) {
        let origin = mesh.data.origin;
        for step in &mesh.deformation.steps {
            let mut row = StepRow {
                params: params.len() as u32,
                ..StepRow::zeroed()
            };
            match step {
                DeformStep::Keys {
                    keys,
                    from,
                    to,
                    share,
                } => {
                    let place = self.place(&Source::Sets(Arc::clone(keys)));
                    row.kind = STEP_KEYS;
                    row.from_set = set_place(place, keys, *from);
                    row.to_set = set_place(place, keys, *to);
                    params.push([*share as f32, 0.0, 0.0, 0.0]);
                }
                DeformStep::Morph { targets, weights } => {
                    let place = self.place(&Source::Sets(Arc::clone(targets)));
                    row.kind = STEP_MORPH;
                    for (target, &weight) in (0..).zip(weights) {
                        if weight != 0.0 {
                            let set = f32::from_bits(set_place(place, targets, target));
                            params.push([weight as f32, set, 0.0, 0.0]);
                            row.count += 1;
                        }
                    }
                }
                DeformStep::Skin { binding, joints } => {
                    row.kind = STEP_SKIN;
                    row.from_set = self.place(&Source::Skin(Arc::clone(binding)));
                    row.to_set = row.from_set + binding.joints.len() as u32 * 4;
                    params.extend(joints.iter().flat_map(|joint| joint_rows(joint, origin)));
                }
                DeformStep::Wave {
                    wave,
                    amplitude,
                    phase,
                } => {
                    row.kind = STEP_WAVE;
                    let phase = within_a_turn(phase - wave.dot(origin));
                    params.push(wave.as_vec3().extend(phase).to_array());
                    params.push(amplitude.as_vec3().extend(0.0).to_array());
                }
                DeformStep::Twist {
                    origin: point,
                    axis,
                    rate,
                    offset,
                } => {
                    row.kind = STEP_TWIST;
                    // The point of the line beside the mesh's origin stands for any other.
                    let along = (origin - *point).dot(*axis);
                    let point = (*point + *axis * along - origin).as_vec3();
                    let offset = within_a_turn(rate * along + offset);
                    params.push(point.extend(*rate as f32).to_array());
                    params.push(axis.as_vec3().extend(offset).to_array());
                }
            }
            steps.push(row);
        }
    }
}

/// Everything that a mesh reads from the data.
fn sources(mesh: &DeformedMesh) -> Vec<Source> {
    let mut all = vec![Source::Rest(Arc::clone(mesh.data))];
    if !mesh.data.normals.is_empty() {
        all.push(Source::Faces(Arc::clone(mesh.data)));
    }
    for step in &mesh.deformation.steps {
        match step {
            DeformStep::Keys { keys: sets, .. } | DeformStep::Morph { targets: sets, .. } => {
                all.push(Source::Sets(Arc::clone(sets)));
            }
            DeformStep::Skin { binding, .. } => all.push(Source::Skin(Arc::clone(binding))),
            DeformStep::Wave { .. } | DeformStep::Twist { .. } => {}
        }
    }
    all
}

/// Appends sources one after the other; where each begins, counted from `first`.
fn place_all(
    sources: &[Source],
    first: usize,
    words: &mut Vec<u32>,
) -> HashMap<(u8, usize), (Source, u32)> {
    let place = |source: &Source| {
        let place = (first + words.len()) as u32;
        source.append_to(words);
        (source.key(), (source.clone(), place))
    };
    sources.iter().map(place).collect()
}

/// Where a set begins.
fn set_place(place: u32, sets: &VertexSets, set: u32) -> u32 {
    place + set * sets.vertices as u32 * 3
}

/// An angle less whole turns.
fn within_a_turn(radians: f64) -> f32 {
    let turns = radians / std::f64::consts::TAU;
    ((turns - turns.round()) * std::f64::consts::TAU) as f32
}

/// A joint's rows, in the space whose origin is the mesh's.
fn joint_rows(joint: &DAffine3, origin: DVec3) -> [[f32; 4]; 3] {
    let shift = joint.transform_point3(origin) - origin;
    let linear = joint.matrix3;
    [0, 1, 2].map(|i| {
        let row = linear.row(i).as_vec3();
        row.extend(shift[i] as f32).to_array()
    })
}
