//! Blend shapes: each key of each channel becomes a morph target.
//!
//! A channel with several keys (in-betweens) goes from shape to shape as its weight rises: [`shares`] says how much
//! of each key a weight is.

use std::sync::Arc;

use glam::Vec3;
use ufbx::{BlendChannel, BlendShape, Mesh};

use super::number;
use crate::world::{Morph, VertexSets};

/// Largest weight of a target.
const HEAVIEST: f64 = 1e6;

/// A key of a channel.
pub struct Target<'a> {
    shape: &'a BlendShape,
    weight: f64,
}

/// Offsets that all blend shapes of a file of so many bytes may have together: shapes are sparse in files.
pub fn room(size: usize) -> usize {
    (16 << 20) + size.saturating_mul(16)
}

/// Channels of all blend shapes of a mesh, in the order of its targets.
pub fn channels(mesh: &Mesh) -> impl Iterator<Item = &BlendChannel> {
    mesh.blend_deformers
        .into_iter()
        .flat_map(|deformer| &deformer.channels)
}

/// The weights of a channel's keys, in order.
pub fn knots(channel: &BlendChannel) -> Vec<f64> {
    let keys = channel.keyframes.iter();
    keys.map(|key| key.target_weight).collect()
}

/// The targets of a mesh, and their weights at rest.
pub fn read(mesh: &Mesh) -> Vec<Target<'_>> {
    channels(mesh)
        .flat_map(|channel| {
            let weights = shares(&knots(channel), channel.weight);
            let keys = channel.keyframes.iter().zip(weights);
            keys.map(|(key, weight)| Target {
                shape: key.shape.as_ref(),
                weight,
            })
        })
        .collect()
}

/// The morph of vertices that are these of the file's; none: there is no target.
///
/// # Errors
/// A sentence: there is no room left for its offsets.
pub fn morph(
    targets: &[Target],
    sources: &[u32],
    room: &mut usize,
) -> Result<Option<Morph>, String> {
    if targets.is_empty() {
        return Ok(None);
    }
    let needed = targets.len().saturating_mul(sources.len());
    *room = room
        .checked_sub(needed)
        .ok_or_else(|| format!("{needed} offsets are too many for a file of its size"))?;
    let mut values = Vec::with_capacity(needed);
    let vertices = sources.iter().map(|&source| source as usize + 1);
    let mut offsets = vec![Vec3::ZERO; vertices.max().unwrap_or(0)];
    for target in targets {
        offsets.fill(Vec3::ZERO);
        let moved = target.shape.offset_vertices.iter();
        for (&vertex, offset) in moved.zip(target.shape.position_offsets.iter()) {
            let offset = number::vector(*offset).as_vec3();
            if let Some(row) = offsets
                .get_mut(vertex as usize)
                .filter(|_| offset.is_finite())
            {
                *row += offset;
            }
        }
        values.extend(sources.iter().map(|&source| offsets[source as usize]));
    }
    Ok(Some(Morph {
        targets: Arc::new(VertexSets {
            vertices: sources.len(),
            values,
        }),
        weights: targets.iter().map(|target| target.weight).collect(),
    }))
}

/// How much of each key the weight of a channel is: straight from key to key, and from nothing at 0; beyond the
/// outermost keys as between the last two.
pub fn shares(knots: &[f64], weight: f64) -> Vec<f64> {
    let mut shares = vec![0.0; knots.len()];
    let mut rising: Vec<(f64, Option<usize>)> = knots
        .iter()
        .enumerate()
        .filter(|(_, knot)| knot.is_finite())
        .map(|(key, &knot)| (knot, Some(key)))
        .collect();
    if rising.is_empty() || !weight.is_finite() {
        return shares;
    }
    if !rising.iter().any(|&(knot, _)| knot == 0.0) {
        rising.push((0.0, None));
    }
    rising.sort_by(|a, b| a.0.total_cmp(&b.0));
    let next = rising.partition_point(|&(knot, _)| knot <= weight);
    let next = next.clamp(1, rising.len().max(2) - 1);
    let [(from, a), (to, b)] = match rising.as_slice() {
        [only] => [*only, *only],
        several => [several[next - 1], several[next]],
    };
    let t = match to > from {
        true => (weight - from) / (to - from),
        false => 1.0,
    };
    let mut put = |key: Option<usize>, share: f64| {
        if let Some(key) = key {
            shares[key] = share.clamp(-HEAVIEST, HEAVIEST);
        }
    };
    put(a, 1.0 - t);
    put(b, t);
    shares
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_go_from_key_to_key() {
        assert_eq!(shares(&[1.0], 0.25), [0.25]);
        assert_eq!(shares(&[1.0], -0.5), [-0.5]);
        assert_eq!(shares(&[1.0], 2.0), [2.0]);
        assert_eq!(shares(&[0.5, 1.0], 0.25), [0.5, 0.0]);
        assert_eq!(shares(&[0.5, 1.0], 0.75), [0.5, 0.5]);
        assert_eq!(shares(&[0.5, 1.0], 1.0), [0.0, 1.0]);
        assert_eq!(shares(&[0.5, 1.0], -0.5), [-1.0, 0.0]);
        assert_eq!(shares(&[-1.0, 1.0], -0.5), [0.5, 0.0]);
        assert_eq!(shares(&[-1.0, 1.0], 0.0), [0.0, 0.0]);
        assert_eq!(shares(&[], 0.5), [0.0; 0]);
        assert!(
            shares(&[f64::NAN, 1.0, 1.0], 0.5)
                .iter()
                .all(|s| s.is_finite())
        );
        assert!(shares(&[0.0], 0.5).iter().all(|s| s.is_finite()));
    }
}
