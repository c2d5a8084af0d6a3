//! A height field of any number of triangles, and the wave that runs through it.

use std::f64::consts::TAU;

use glam::DVec3;
use orrery_engine::world::{DeformStep, Deformation, MeshData};

/// Radians per unit.
const WAVE: DVec3 = DVec3::new(9.0, 0.0, 4.0);
/// Half the height of the wave; the field is 1 wide.
const AMPLITUDE: f64 = 0.05;

/// A square of about so many triangles over [0, 1]^2 in x and z: the largest even square below.
///
/// # Errors
/// Those of [`MeshData::new`].
pub fn hills(triangles: usize) -> Result<MeshData, String> {
    let side = (triangles / 2).isqrt().max(1) as u32;
    let across = side + 1;
    let vertex = |i: u32| {
        let at = |n: u32| f64::from(n) / f64::from(side);
        let (x, z) = (at(i % across), at(i / across));
        DVec3::new(x, 0.03 * (x * 21.0).sin() * (z * 17.0).cos(), z)
    };
    let square = |i: u32| {
        let a = i / side * across + i % side;
        [[a, a + across, a + 1], [a + 1, a + across, a + across + 1]]
    };
    MeshData::new(
        "hills",
        (0..across * across).map(vertex).collect(),
        Vec::new(),
        (0..side * side).flat_map(square).collect(),
    )
}

/// What the wave adds to a vertex, see [`wave`].
pub fn lift(vertex: DVec3, share: f64) -> DVec3 {
    DVec3::Y * AMPLITUDE * (WAVE.dot(vertex) - TAU * share).sin()
}

/// A wave across the field in x, with crests that are not those of the hills, after a share of its period.
pub fn wave(share: f64) -> Deformation {
    Deformation {
        steps: vec![DeformStep::Wave {
            wave: WAVE,
            amplitude: DVec3::Y * AMPLITUDE,
            phase: TAU * share,
        }],
    }
}
