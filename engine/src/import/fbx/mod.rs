//! FBX, binary and ASCII, versions 3000 to 7700, through the `ufbx` crate. Called by the scene loader.
//!
//! The node hierarchy is kept: row i of [`Model::nodes`] is node i of the file. What Autodesk's transforms say beyond
//! translation, rotation and scale stands on helper nodes that ufbx puts in: one below a node whose geometry has a
//! transform of its own, one below a node whose scale its children do not inherit. Cameras and lights stand on nodes
//! after those of the file, because they look along other axes there.
//!
//! Axes become right-handed with Y up, by a turn of the root. Lengths stay in the file's own units (mostly
//! centimetres): only the people who model know what a unit is to them, and cameras frame what there is.
//! Animation stacks become clips, skins and blend shapes those of the engine, geometry caches key frames. Not read:
//! NURBS, line curves, constraints. They are warned of.
//!
//! What ufbx may allocate is bounded by the size of the file.

mod cache;
mod clip;
mod light;
mod material;
mod mesh;
mod morph;
mod node;
mod number;
mod skin;

use std::path::Path;

use ufbx::{
    AllocatorOpts, CoordinateAxes, CoordinateAxis, ErrorType, FileFormat,
    GeometryTransformHandling, InheritModeHandling, LoadOpts, Scene,
};

use super::{Files, Model};

/// Nodes below nodes; deeper files are refused.
const DEEPEST: u32 = 500;

/// Right-handed, Y up.
const AXES: CoordinateAxes = CoordinateAxes {
    right: CoordinateAxis::PositiveX,
    up: CoordinateAxis::PositiveY,
    front: CoordinateAxis::PositiveZ,
};

/// Reads an FBX file.
///
/// # Errors
/// A sentence without the file's name: it cannot be opened, or what ufbx finds wrong with it.
pub fn import(path: &Path, files: &Files) -> Result<Model, String> {
    read(&files.bytes(path)?, files)
}

/// What the bytes of an FBX file in that folder hold.
///
/// # Errors
/// A sentence without the file's name.
pub fn read_fbx(bytes: &[u8], folder: &Path) -> Result<Model, String> {
    read(bytes, &Files::of_folder(folder))
}

fn read(bytes: &[u8], files: &Files) -> Result<Model, String> {
    let scene = ufbx::load_memory(bytes, options(bytes.len())).map_err(|error| refused(&error))?;
    let mut model = Model::default();
    for warning in &scene.metadata.warnings {
        model.warnings.push(warning.description.to_string());
    }
    warn_of_what_is_left_out(&scene, &mut model);
    material::read(&scene, files, &mut model);
    let shapes = mesh::read(&scene, (bytes.len(), files), &mut model);
    node::read(&scene, &shapes, &mut model);
    clip::read(&scene, bytes.len(), &mut model);
    if model.nodes.iter().all(|node| node.contents.is_empty()) {
        let mut why = String::from("it has nothing to show: no mesh, no light, no camera");
        for sentence in model.warnings.sentences() {
            why = why + "; " + &sentence;
        }
        return Err(why);
    }
    Ok(model)
}

fn refused(error: &ufbx::Error) -> String {
    let mut what = error.description.to_string();
    if !error.info().is_empty() {
        what += &format!(" ({})", error.info());
    } else if error.type_ == ErrorType::Unknown && error.stack_size > 0 {
        // Then only the reader's own check tells more.
        let check = &error.stack[0];
        what += &format!(" (`{}` in {})", check.description, check.function);
    }
    format!("it is not a valid FBX file: {what}")
}

fn options<'a>(size: usize) -> LoadOpts<'a> {
    LoadOpts {
        temp_allocator: limits(size),
        result_allocator: limits(size),
        file_format: FileFormat::Fbx,
        clean_skin_weights: true,
        generate_missing_normals: true,
        node_depth_limit: DEEPEST,
        geometry_transform_handling: GeometryTransformHandling::HelperNodes,
        inherit_mode_handling: InheritModeHandling::HelperNodes,
        target_axes: AXES,
        ..LoadOpts::default()
    }
}

/// Room for what compresses well (arrays of equal numbers), but not for a bomb.
fn limits(size: usize) -> AllocatorOpts {
    AllocatorOpts {
        memory_limit: (64 << 20) + size.saturating_mul(128),
        allocation_limit: 100_000 + size,
        ..AllocatorOpts::default()
    }
}

fn warn_of_what_is_left_out(scene: &Scene, model: &mut Model) {
    let kinds = [
        (scene.nurbs_surfaces.len(), "NURBS surfaces"),
        (
            scene.nurbs_curves.len() + scene.line_curves.len(),
            "line curves",
        ),
        (scene.constraints.len(), "constraints"),
    ];
    for (count, what) in kinds.into_iter().filter(|(count, _)| *count > 0) {
        model
            .warnings
            .push(format!("{what} are not read; it has {count}"));
    }
}

#[cfg(test)]
mod tests;
