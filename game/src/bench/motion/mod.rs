//! The benchmark `motion`: what a frame costs when nothing, one thing, or everything moves.
//!
//! Crowds and meshes are made by code, so counts are exact. Beside every time stands what proves that the
//! work was done: counts that must be 0 (wrong pixels, invalid trees, rays with another answer).

mod change;
mod deformed;
mod device;
mod packing;
mod rival;
mod scenes;
mod trees;

use self::rival::Rivals;
use super::frame::backends;
use super::report::Report;
use crate::args::{BackendChoice, BenchRequest, Common};
use crate::device as devices;
use crate::failure::Failure;
use crate::output::note;

/// How many of everything.
#[derive(Clone, Copy, Debug)]
struct Sizes {
    /// Things in the worlds of which nothing, one or the camera moves.
    crowds: &'static [usize],
    /// Things that all move, from the world to packed rows.
    packed: &'static [usize],
    /// Things in instance trees.
    trees: &'static [usize],
    /// Triangles of meshes that deform on the host.
    meshes: &'static [usize],
    /// Triangles of the mesh that deforms on a device.
    device_mesh: usize,
    /// Things in instance trees on a device.
    device_trees: &'static [usize],
    /// Rays of a sample.
    rays: usize,
}

const FULL: Sizes = Sizes {
    crowds: &[100, 10_000, 100_000],
    packed: &[10_000, 100_000],
    trees: &[1000, 10_000, 100_000],
    meshes: &[100_000, 1_000_000],
    device_mesh: 2_400_000,
    device_trees: &[10_000, 100_000],
    rays: 20_000,
};

const SMALL: Sizes = Sizes {
    crowds: &[10, 1000],
    packed: &[1000],
    trees: &[100, 1000],
    meshes: &[1000],
    device_mesh: 1000,
    device_trees: &[1000],
    rays: 500,
};

/// Measures everything there is.
pub fn run(request: &BenchRequest, common: &Common) -> Result<Report, Failure> {
    let sizes = if request.small { &SMALL } else { &FULL };
    let samples = request.repeat as usize;
    let mut rows = Vec::new();
    let mut names = Vec::new();
    let choices = backends(common);
    for &choice in &choices {
        let tracer = devices::open_choice(choice, common)?;
        names.push(tracer.device());
        let backend = tracer.backend().to_string();
        drop(tracer);
        note(format_args!(
            "{backend}: nothing, one thing, the camera moves"
        ));
        rows.extend(change::rows(&backend, choice, sizes, samples, common)?);
    }
    let remarks = vec![
        format!(
            "crowds by code: spheres and one mesh, or meshes of 4 triangles (\"meshes\"); {samples} samples a row at least"
        ),
        "frame: without the profiler of systems, whose own cost is in profiled; 1t, 2t, ...: threads; wrong: rays or pixels that differ from those of a tree or a tracer made anew".into(),
    ];
    if choices.contains(&BackendChoice::Cpu) {
        note("everything moves: packed rows");
        rows.extend(packing::rows(sizes, samples, common)?);
        let mut rivals = Rivals::of(request);
        for recording in trees::recordings(sizes, samples) {
            note(format_args!(
                "everything moves: {} in a tree",
                recording.name
            ));
            rows.extend(trees::rows(&recording, sizes, samples)?);
            if let (Some(rivals), true) = (&mut rivals, recording.is_for_rivals) {
                rivals.add(&recording.name, &recording.last)?;
            }
        }
        for &triangles in sizes.meshes {
            note(format_args!("a mesh of {triangles} triangles deforms"));
            rows.extend(deformed::rows(triangles, sizes, samples)?);
            if let Some(rivals) = &mut rivals {
                rivals.add(&format!("mesh.{triangles}"), &deformed::still(triangles)?)?;
            }
        }
        if let Some(rivals) = rivals {
            rows.extend(rivals.run(&rows)?);
        }
    }
    if choices.contains(&BackendChoice::Gpu) {
        note("everything moves: trees on the device");
        rows.extend(device::rows(sizes, samples, common)?);
    }
    Ok(Report {
        rows,
        remarks,
        ..Report::new("motion", &names)
    })
}
