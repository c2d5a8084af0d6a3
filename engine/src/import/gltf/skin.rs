//! Skins: joints with their bind poses, and which of them hold which vertex.

use std::sync::Arc;

use glam::{DAffine3, Mat4};
use gltf::accessor::Dimensions;
use gltf::mesh::{Primitive, Semantic};

use super::file::File;
use super::node::Rows;
use crate::import::{Joints, Model};
use crate::world::{FARTHEST, SkinBinding};

/// Joints that hold a vertex.
const HELD_BY: usize = 4;

/// Puts the skins of the file into the model, row by row; one that cannot be used has no joints.
pub fn read_skins(file: &File, rows: &Rows, model: &mut Model) {
    for skin in file.document.skins() {
        let joints = joints_of(file, &skin, rows).unwrap_or_else(|why| {
            let warning = format!("skins[{}]: {why}; it holds nothing", skin.index());
            model.warnings.push(warning);
            Joints::default()
        });
        model.skins.push(joints);
    }
}

fn joints_of(file: &File, skin: &gltf::Skin, rows: &Rows) -> Result<Joints, String> {
    let nodes: Option<Vec<usize>> = skin
        .joints()
        .map(|joint| rows.get(&joint.index()).copied())
        .collect();
    let nodes = nodes.ok_or("a joint is not in the scene")?;
    let joint_from_mesh = match skin.inverse_bind_matrices() {
        None => vec![DAffine3::IDENTITY; nodes.len()],
        Some(accessor) => {
            let numbers = file.numbers(&accessor, Dimensions::Mat4)?;
            let matrices = numbers.chunks_exact(16).take(nodes.len());
            let affine =
                |numbers: &[f32]| DAffine3::from_mat4(Mat4::from_cols_slice(numbers).as_dmat4());
            matrices.map(affine).collect()
        }
    };
    let within = |x: &f64| x.abs() <= FARTHEST;
    let fits = |m: &DAffine3| m.to_cols_array().iter().all(within);
    if joint_from_mesh.len() != nodes.len() || !joint_from_mesh.iter().all(fits) {
        return Err("its inverse bind matrices are too few or not finite".into());
    }
    Ok(Joints {
        nodes,
        joint_from_mesh,
    })
}

/// Which joints hold the vertices `used` of a primitive; none: it is bound to nothing.
///
/// # Errors
/// What of them cannot be read, without the place.
pub fn binding_of(
    file: &File,
    primitive: &Primitive,
    used: &[u32],
    (place, model): (&str, &mut Model),
) -> Result<Option<Arc<SkinBinding>>, String> {
    let mut joints: Vec<Vec<u32>> = Vec::new();
    let mut weights: Vec<Vec<f32>> = Vec::new();
    for set in 0_u32.. {
        let sets = (
            primitive.get(&Semantic::Joints(set)),
            primitive.get(&Semantic::Weights(set)),
        );
        let (Some(joint), Some(weight)) = sets else {
            break;
        };
        joints.push(file.whole_numbers(&joint, Dimensions::Vec4)?);
        weights.push(file.numbers(&weight, Dimensions::Vec4)?);
    }
    if joints.is_empty() {
        return Ok(None);
    }
    let (mut rows, mut shares) = (Vec::new(), Vec::new());
    let (mut most_lost, mut unheld) = (0.0_f32, 0_usize);
    for &vertex in used {
        let first = vertex as usize * HELD_BY;
        let mut held: Vec<(u32, f32)> = Vec::with_capacity(HELD_BY * joints.len());
        for (joints, weights) in joints.iter().zip(&weights) {
            let joints = joints.get(first..first + HELD_BY);
            let weights = weights.get(first..first + HELD_BY);
            let (Some(joints), Some(weights)) = (joints, weights) else {
                return Err("too few joints or weights for its vertices".into());
            };
            let pairs = joints.iter().copied().zip(weights.iter().copied());
            held.extend(pairs.filter(|&(_, weight)| weight > 0.0 && weight.is_finite()));
        }
        // Stable, so that of equals the first stay.
        held.sort_by(|a, b| b.1.total_cmp(&a.1));
        let all: f32 = held.iter().map(|&(_, weight)| weight).sum();
        let lost: f32 = held.iter().skip(HELD_BY).map(|&(_, weight)| weight).sum();
        if held.is_empty() || !all.is_finite() {
            unheld += 1;
            held = vec![(0, 1.0)];
        } else {
            most_lost = most_lost.max(lost / all);
        }
        held.resize(HELD_BY, (0, 0.0));
        rows.push([0, 1, 2, 3].map(|i| held[i].0));
        shares.push([0, 1, 2, 3].map(|i| held[i].1));
    }
    if most_lost > 0.01 {
        model.warnings.push(format!(
            "{place}: vertices are held by more than {HELD_BY} joints; the heaviest {HELD_BY} stay, without up to {:.0} % of the weight",
            100.0 * most_lost
        ));
    }
    if unheld > 0 {
        let warning = format!("{place}: {unheld} vertices without weights follow the first joint");
        model.warnings.push(warning);
    }
    SkinBinding::new(rows, shares).map(|binding| Some(Arc::new(binding)))
}
