//! The benchmark `structures`: what the 2008 report's choice of structure cost, beside none, 2-wide and 4-wide
//! boxes.
//!
//! Scenes of the report's kind that hold meshes, and meshes of 1000 and 100,000 triangles. Under each structure: builds
//! and refits on one thread, what a camera ray visits, and the time of a whole frame on each backend. The picture
//! never depends on the structure, which is proved by counting pixels.

mod frames;
mod meshes;
mod stages;

use orrery_engine::world::Structure;

use super::frame::backends;
use super::report::{Report, Row};
use super::timing::pool_of;
use crate::args::{BenchRequest, Common};
use crate::device;
use crate::failure::Failure;
use crate::output::note;

/// Most triangles of a mesh that is traced without a structure.
const MOST_WITHOUT: usize = 1000;
/// Triangles in a leaf of the report's tree.
const REPORT_LEAF: u32 = 4;

/// All, the report's after none.
const STRUCTURES: [(&str, Structure); 4] = [
    ("none", Structure::None),
    ("spheres", Structure::Spheres { leaf: REPORT_LEAF }),
    ("boxes2", Structure::Boxes2),
    ("boxes4", Structure::Boxes4),
];

/// Measures every scene under every structure.
pub fn run(request: &BenchRequest, common: &Common) -> Result<Report, Failure> {
    let samples = request.repeat as usize;
    let mut rows = Vec::new();
    let mut remarks = vec![format!(
        "spheres: the report's binary tree, at most {REPORT_LEAF} triangles a leaf; nodes and triangles: of meshes, a camera ray; {samples} samples a row"
    )];
    let mut devices = Vec::new();
    let choices = backends(common);
    for &choice in &choices {
        devices.push(device::open_choice(choice, common)?.device());
    }
    let single = pool_of(1)?;
    for stage in stages::all(request, common)? {
        let largest = stage.meshes.iter().map(|mesh| mesh.triangles.len()).max();
        let Some(largest) = largest else {
            remarks.push(format!("{}: no meshes, so no structure", stage.name));
            continue;
        };
        let triangles: usize = stage.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
        remarks.push(format!(
            "{}: {} meshes, {triangles} triangles, {}x{} pixels",
            stage.name,
            stage.meshes.len(),
            stage.size.x,
            stage.size.y
        ));
        let usable = |structure: Structure| structure != Structure::None || largest <= MOST_WITHOUT;
        for (word, structure) in STRUCTURES.into_iter().filter(|(_, s)| usable(*s)) {
            note(format_args!("{}: {word}", stage.name));
            let name = format!("{}.{word}", stage.name);
            rows.extend(single.install(|| meshes::rows(&name, &stage, structure, samples)));
        }
        for &choice in &choices {
            let usable = STRUCTURES.into_iter().filter(|(_, s)| usable(*s));
            rows.extend(frames::rows(&stage, usable, choice, samples, common)?);
        }
    }
    rows.sort_by_key(place);
    Ok(Report {
        rows,
        remarks,
        ..Report::new("structures", &devices)
    })
}

/// Rows of a scene and structure stand together, scenes and structures in the order of their first rows.
fn place(row: &Row) -> (usize, usize) {
    let mut words = row.name.split('.');
    let (scene, structure) = (words.next(), words.next());
    let scene = stages::NAMES.iter().position(|name| Some(*name) == scene);
    let structure = STRUCTURES.iter().position(|s| Some(s.0) == structure);
    (
        scene.unwrap_or(stages::NAMES.len()),
        structure.unwrap_or(STRUCTURES.len()),
    )
}
