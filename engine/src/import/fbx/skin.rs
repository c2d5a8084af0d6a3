//! Skins: which bones hold which vertex.
//!
//! A vertex that no bone holds follows the mesh's own node, which is the last joint. More than four bones at a vertex
//! are cut to the four heaviest; rigid and linear skinning are meant, dual quaternions are warned of.

use std::sync::Arc;

use glam::DAffine3;
use ufbx::{Mesh, SkinDeformer, SkinningMethod};

use super::number;
use crate::import::{Joints, Warnings};
use crate::world::SkinBinding;

/// Joints and weights of the vertices of a mesh of the file.
pub struct Weights {
    joints: Vec<[u32; 4]>,
    weights: Vec<[f32; 4]>,
    /// The joint of what nothing holds.
    own: u32,
}

/// The weights of a mesh with a skin.
pub fn read(mesh: &Mesh, warnings: &mut Warnings) -> Option<Weights> {
    let skin = skin_of(mesh)?;
    let name = &mesh.element.name;
    if mesh.skin_deformers.len() > 1 {
        warnings.push(format!("of the skins of `{name}` only the first counts"));
    }
    if !matches!(
        skin.skinning_method,
        SkinningMethod::Linear | SkinningMethod::Rigid
    ) {
        warnings.push(format!(
            "`{name}` is skinned by dual quaternions; it is skinned linearly"
        ));
    }
    let own = skin.clusters.len() as u32;
    let mut cut = 0;
    let (joints, weights) = (0..mesh.num_vertices)
        .map(|vertex| {
            let (row, more) = heaviest(skin, vertex, own);
            cut += usize::from(more);
            row
        })
        .unzip();
    if cut > 0 {
        warnings.push(format!(
            "{cut} vertices of `{name}` are held by more than four bones; the four heaviest count"
        ));
    }
    Some(Weights {
        joints,
        weights,
        own,
    })
}

/// The joints of a mesh with a skin that the node in this row shows.
pub fn joints(mesh: &Mesh, row: usize) -> Option<Joints> {
    let skin = skin_of(mesh)?;
    let mut joints = Joints::default();
    for cluster in &skin.clusters {
        let bone = cluster.bone_node.as_ref();
        let held = number::affine(&cluster.geometry_to_bone);
        // A bone that is missing or nonsense leaves its vertices where they are.
        let (node, joint_from_mesh) = match (bone, held) {
            (Some(bone), Some(held)) => (bone.element.typed_id as usize, held),
            _ => (row, DAffine3::IDENTITY),
        };
        joints.nodes.push(node);
        joints.joint_from_mesh.push(joint_from_mesh);
    }
    joints.nodes.push(row);
    joints.joint_from_mesh.push(DAffine3::IDENTITY);
    Some(joints)
}

fn skin_of(mesh: &Mesh) -> Option<&SkinDeformer> {
    let skin = mesh.skin_deformers.iter().next()?;
    (!skin.clusters.is_empty()).then_some(skin)
}

/// Joints and weights of a vertex, and whether there were more.
fn heaviest(skin: &SkinDeformer, vertex: usize, own: u32) -> (([u32; 4], [f32; 4]), bool) {
    let range = skin.vertices.get(vertex).copied().unwrap_or_default();
    let first = range.weight_begin as usize;
    let held = skin.weights.get(first..first + range.num_weights as usize);
    let mut held: Vec<(f64, u32)> = held
        .unwrap_or_default()
        .iter()
        .filter(|weight| weight.weight > 0.0 && weight.weight.is_finite())
        .filter(|weight| weight.cluster_index < own)
        .map(|weight| (weight.weight, weight.cluster_index))
        .collect();
    held.sort_by(|a, b| b.0.total_cmp(&a.0));
    let more = held.len() > 4;
    // As shares, so that tiny and huge weights fit f32.
    let sum: f64 = held.iter().take(4).map(|(weight, _)| weight).sum();
    let mut row = ([own; 4], [0.0; 4]);
    for (i, (weight, joint)) in held.into_iter().take(4).enumerate() {
        row.0[i] = joint;
        row.1[i] = (weight / sum) as f32;
    }
    if !(row.1[0] > 0.0) {
        row = ([own; 4], [1.0, 0.0, 0.0, 0.0]);
    }
    (row, more)
}

impl Weights {
    /// The binding of vertices that are these of the file's.
    ///
    /// # Errors
    /// A sentence that says what is wrong with the weights.
    pub fn binding(&self, sources: &[u32]) -> Result<Arc<SkinBinding>, String> {
        let joints = |&source: &u32| self.joints.get(source as usize).copied();
        let weights = |&source: &u32| self.weights.get(source as usize).copied();
        let joints = sources.iter().map(|s| joints(s).unwrap_or([self.own; 4]));
        let weights = sources
            .iter()
            .map(|s| weights(s).unwrap_or([1.0, 0.0, 0.0, 0.0]));
        SkinBinding::new(joints.collect(), weights.collect()).map(Arc::new)
    }
}
