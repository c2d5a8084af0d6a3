//! Poses and morph targets of meshes: files that must have the faces of the mesh.

use std::path::Path;

use super::{MeshKey, Resolver, mesh_key, nearest_file};
use crate::import::import_pose;
use crate::scene::schema::{At, Entity, MeshFile, Shape};

/// A mesh and the path of another pose of it.
pub type PoseKey = (MeshKey, String);

impl Resolver {
    /// Opens the poses and morph targets of an entity; reports those that do not fit its mesh.
    pub(super) fn open_poses(&mut self, entity: &Entity, folder: &Path) {
        let keys = entity.deform.keys.iter().flat_map(|keys| &keys.poses);
        let targets = entity.deform.morph.iter().flat_map(|morph| &morph.targets);
        for file in keys.chain(targets) {
            match &entity.shape {
                Some(Shape::Mesh(mesh)) => self.open_pose(mesh, file, folder),
                _ => self.reader.report_at(
                    file.place.clone(),
                    "found a pose of an entity without a mesh",
                    Some("a mesh file beside it".into()),
                    None,
                ),
            }
        }
    }

    fn open_pose(&mut self, mesh: &MeshFile, file: &At<String>, folder: &Path) {
        let key = mesh_key(&mesh.path.value, mesh.smooth_angle);
        // A mesh that is not there is a problem told already.
        let Some(model) = self.models.get(&key) else {
            return;
        };
        let pose_key = (key, file.value.clone());
        if self.poses.contains_key(&pose_key) {
            return;
        }
        let path = folder.join(&file.value);
        match import_pose(&path, model) {
            Ok(pose) => drop(self.poses.insert(pose_key, pose)),
            Err(why) => {
                let nearest = match !path.is_file() && self.may_compare() {
                    true => nearest_file(&path),
                    false => None,
                };
                self.reader.report_at(
                    file.place.clone(),
                    format!("the pose `{}` cannot be used: {why}", file.value),
                    Some(format!(
                        "an OBJ file with the vertices and faces of `{}`",
                        mesh.path.value
                    )),
                    nearest,
                );
            }
        }
    }
}
