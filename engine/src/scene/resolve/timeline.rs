//! What a timeline names, and whether its tracks can do what they say.

use std::collections::HashSet;

use super::{Resolver, find, mesh_key};
use crate::import::Model;
use crate::scene::fields;
use crate::scene::schema::{self, At, Light, LookAt, Scene, Shape};

impl Resolver {
    /// Reports tracks and paths whose targets are not there, or that go round in circles.
    pub(super) fn look_up_timeline(&mut self, scene: &Scene) {
        let mut keyed: HashSet<(&str, &str)> = HashSet::new();
        for track in &scene.timeline.tracks {
            if track.field.value.starts_with("material.") {
                if !self.materials.contains(&track.target.value) {
                    self.unknown("material", &track.target, |own| {
                        own.materials.iter().cloned().collect()
                    });
                }
            } else if self.known_entity(&track.target) {
                self.has_field(scene, track.target.value.as_str(), &track.field);
            }
            if !keyed.insert((&track.target.value, &track.field.value)) {
                self.reader.report_at(
                    track.field.place.clone(),
                    format!(
                        "a track before keys `{}` of `{}` already",
                        track.field.value, track.target.value
                    ),
                    Some("one track a field".into()),
                    None,
                );
            }
        }
        for path in &scene.timeline.paths {
            self.known_entity(&path.target);
            if let Some(LookAt::Entity(id)) = &path.look_at
                && self.known_entity(id)
                && id == &path.target
            {
                self.reader.report_at(
                    id.place.clone(),
                    format!("`{}` looks at itself", id.value),
                    Some("another entity, or a point".into()),
                    None,
                );
            }
        }
        self.find_overwritten(scene);
        self.find_moved_twice(scene);
        self.find_cycles(scene);
    }

    /// Reports tracks and paths that do nothing, because a path writes the same field later in the frame.
    fn find_overwritten(&mut self, scene: &Scene) {
        let paths = &scene.timeline.paths;
        for track in &scene.timeline.tracks {
            let target = &track.target.value;
            let overwrites = |path: &schema::Path| match track.field.value.as_str() {
                "transform.translation" => true,
                "transform.rotation" => path.look_at.is_some(),
                _ => false,
            };
            if paths
                .iter()
                .any(|path| path.target.value == *target && overwrites(path))
            {
                let field = &track.field.value;
                self.reader.report_at(
                    track.field.place.clone(),
                    format!("a path of `{target}` overwrites `{field}` in every frame"),
                    Some("the track or the path, not both".into()),
                    None,
                );
            }
        }
        for (i, path) in paths.iter().enumerate() {
            let target = &path.target;
            if paths[..i].iter().any(|p| p.target.value == target.value) {
                self.reader.report_at(
                    target.place.clone(),
                    format!("a path before moves `{}` already", target.value),
                    Some("one path an entity".into()),
                    None,
                );
            }
        }
    }

    /// Reports tracks and paths of what motion components move as well: only one of the two would be seen.
    fn find_moved_twice(&mut self, scene: &Scene) {
        let tracks = &scene.timeline.tracks;
        let keyed = tracks.iter().map(|track| {
            let field = track.field.value.as_str();
            (&track.target.value, field, &track.field.place)
        });
        let paths = scene.timeline.paths.iter().flat_map(|path| {
            let (target, place) = (&path.target.value, &path.target.place);
            let turns = path.look_at.is_some();
            let turned = turns.then_some((target, "transform.rotation", place));
            std::iter::once((target, "transform.translation", place)).chain(turned)
        });
        let mut twice = Vec::new();
        for (target, field, place) in keyed.chain(paths) {
            let entity = find(&scene.entities, target);
            if entity.is_some_and(|entity| entity.motion.writes(field)) {
                let what = format!("the motion of `{target}` writes `{field}` too");
                twice.push((place.clone(), what));
            }
        }
        for (place, what) in twice {
            let expected = Some("the motion or the timeline; or one of them on a parent".into());
            self.reader.report_at(place, what, expected, None);
        }
    }

    /// Reports a field of a component that the entity does not have.
    fn has_field(&mut self, scene: &Scene, id: &str, field: &At<String>) {
        let Some(entity) = find(&scene.entities, id) else {
            return;
        };
        let component = field.value.split('.').next().unwrap_or_default();
        let there = match component {
            shape if Shape::NAMES.contains(&shape) => entity
                .shape
                .as_ref()
                .is_some_and(|found| found.name() == shape),
            "deform" => self.deforms(entity, &field.value),
            "clip" => entity.clips.len() > fields::clip_layer(&field.value),
            "light" => entity.light.is_some(),
            "camera" => entity.camera.is_some(),
            _ => true,
        };
        if !there {
            self.reader.report_at(
                field.place.clone(),
                format!("`{id}` has no {component}, so no field `{}`", field.value),
                Some(format!("a {component} on `{id}`, or another field")),
                None,
            );
        } else if let Some(light) = &entity.light
            && let Some(kind) = without_field(light, &field.value)
        {
            self.reader.report_at(
                field.place.clone(),
                format!("the {kind} light of `{id}` has no field `{}`", field.value),
                Some("a light that has it, or another field".into()),
                None,
            );
        }
    }

    /// Whether an entity has a field of its deformation; a mesh of several parts has one on each.
    fn deforms(&self, entity: &schema::Entity, field: &str) -> bool {
        let deform = &entity.deform;
        let there = match field.split('.').nth(1) {
            Some("keys") => deform.keys.is_some(),
            Some("morph") => {
                let targets = deform.morph.as_ref().map_or(0, |morph| morph.targets.len());
                let number = field.rsplit('.').next().and_then(|n| n.parse().ok());
                number.is_some_and(|number: usize| number < targets)
            }
            Some("wave") => deform.wave.is_some(),
            Some("twist") => deform.twist.is_some(),
            _ => false,
        };
        let parts = match &entity.shape {
            Some(Shape::Mesh(mesh)) => {
                let key = mesh_key(&mesh.path.value, mesh.smooth_angle);
                let parts = |model: &Model| model.contents().filter(|c| c.is_part()).count();
                self.models.get(&key).map_or(1, parts)
            }
            _ => 1,
        };
        there && parts == 1
    }

    /// Reports looks that depend on each other's rotation in a circle.
    fn find_cycles(&mut self, scene: &Scene) {
        let looks: Vec<_> = scene
            .timeline
            .paths
            .iter()
            .filter(|path| path.look_at.is_some())
            .collect();
        let above = |id: &str| self.entities.get(id).cloned().unwrap_or_default();
        let needs: Vec<Vec<usize>> = looks
            .iter()
            .map(|path| {
                let mut needed = above(&path.target.value);
                if let Some(LookAt::Entity(id)) = &path.look_at {
                    needed.extend(above(&id.value));
                }
                (0..looks.len())
                    .filter(|&i| needed.contains(&looks[i].target.value))
                    .collect()
            })
            .collect();
        if let Err(i) = crate::scene::timeline::sorted(&needs) {
            let target = &looks[i].target;
            self.reader.report_at(
                target.place.clone(),
                format!(
                    "what `{}` looks at moves with `{}` itself: a cycle",
                    target.value, target.value
                ),
                Some("something that its own rotation does not move".into()),
                None,
            );
        }
    }
}

/// The light's kind if it has not this field of lights.
fn without_field(light: &Light, field: &str) -> Option<&'static str> {
    let fades = field.starts_with("light.fade.");
    let opens = matches!(field, "light.inner_angle" | "light.outer_angle");
    match light {
        Light::Directional(_) if fades || opens => Some("directional"),
        Light::Point(_) if opens => Some("point"),
        _ => None,
    }
}
