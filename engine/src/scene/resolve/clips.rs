//! Clips that entities play: whether their models have them.

use super::{Resolver, mesh_key};
use crate::scene::schema::{Entity, Shape};

impl Resolver {
    /// Reports clips that a model does not have.
    pub(super) fn look_up_clips(&mut self, entity: &Entity) {
        let (Some(Shape::Mesh(mesh)), false) = (&entity.shape, entity.clips.is_empty()) else {
            return;
        };
        let key = mesh_key(&mesh.path.value, mesh.smooth_angle);
        let Some(model) = self.models.get(&key) else {
            return;
        };
        let names: Vec<String> = model.clips.iter().map(|clip| clip.name.clone()).collect();
        for clip in &entity.clips {
            match &clip.name {
                Some(name) if !names.contains(&name.value) => {
                    self.unknown("clip", name, |_| names.clone());
                }
                None if names.is_empty() => self.reader.report_at(
                    mesh.path.place.clone(),
                    format!("`{}` has no clip to play", mesh.path.value),
                    Some("a model with animations, or no `clip`".into()),
                    None,
                ),
                _ => {}
            }
        }
    }
}
