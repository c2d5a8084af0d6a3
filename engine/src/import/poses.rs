//! Other poses of a mesh: files of the same faces whose vertices are elsewhere.

use std::path::Path;

use glam::DVec3;

use super::obj::outlines;
use super::{Model, Outline, caught};
use crate::world::FARTHEST;

/// Where the vertices of a model's parts are in another file of the same faces, a list a part.
///
/// # Errors
/// A sentence without the file's name: it cannot be opened, is no OBJ, or has not the vertices and faces that
/// the model has.
pub fn import_pose(path: &Path, model: &Model) -> Result<Vec<Vec<DVec3>>, String> {
    let groups = caught("Wavefront OBJ", || outlines(path))?;
    // Parts whose every face was left out have no place in the model.
    let mut groups = groups.into_iter();
    let mut poses = Vec::with_capacity(model.parts.len());
    for part in &model.parts {
        let (outline, vertices) = groups
            .next()
            .ok_or_else(|| format!("it has fewer than {} groups of faces", model.parts.len()))?;
        fits(&outline, &part.outline)?;
        let within = |v: &DVec3| v.is_finite() && v.abs().max_element() <= FARTHEST;
        if let Some(vertex) = vertices.iter().position(|v| !within(v)) {
            return Err(format!(
                "vertex {} is not finite or farther out than {FARTHEST:e}",
                vertex + 1
            ));
        }
        let place = |&source: &u32| vertices.get(source as usize).copied();
        let pose = part.sources.iter().map(place).collect::<Option<Vec<_>>>();
        poses.push(pose.ok_or("its faces are not those of the mesh")?);
    }
    if groups.next().is_some() {
        return Err(format!(
            "it has more than {} groups of faces",
            model.parts.len()
        ));
    }
    Ok(poses)
}

fn fits(pose: &Outline, rest: &Outline) -> Result<(), String> {
    if pose.vertices != rest.vertices {
        return Err(format!(
            "its faces use {} vertices, those of the mesh {}",
            pose.vertices, rest.vertices
        ));
    }
    if pose != rest {
        return Err("its faces are not those of the mesh".into());
    }
    Ok(())
}
