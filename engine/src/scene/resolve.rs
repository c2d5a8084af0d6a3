//! From text to a scene whose names and files are all found. Needs no world, so `check` can use it.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use super::problem::{Place, Problems, RawProblem, Report, Summary, locate, nearest};
use super::reader::{Reader, Schema};
use super::schema::{self, At, Entity, Light, LookAt, MeshFile, Scene, Shape};
use super::syntax;
use super::timeline::last_key;
use crate::import::{Model, import_obj, smooth};

/// A scene and its meshes.
pub struct Resolved {
    pub scene: Scene,
    /// By path and smoothing, as [`mesh_key`] says.
    pub models: HashMap<MeshKey, Model>,
}

/// What makes two uses of a mesh file the same mesh: its path and the bits of its smoothing angle.
pub type MeshKey = (String, Option<u64>);

/// The key of a mesh.
pub fn mesh_key(path: &str, smooth_angle: Option<f64>) -> MeshKey {
    (path.to_owned(), smooth_angle.map(f64::to_bits))
}

/// The values of a text, and what is wrong with their form.
pub fn read(text: &str) -> (Scene, Vec<RawProblem>) {
    let (root, errors) = syntax::parse(text);
    let mut reader = Reader::default();
    for error in errors {
        let place = Place {
            at: error.at,
            field: String::new(),
        };
        reader.report_at(place, error.what, error.expected, None);
    }
    let scene = Scene::read(&mut reader, &root).unwrap_or_default();
    (scene, reader.problems)
}

/// Reads, looks up every name, opens every file.
pub fn resolve(text: &str, path: &Path) -> (Resolved, Report) {
    let (scene, problems) = read(text);
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut resolver = Resolver::default();
    resolver.reader.problems = problems;
    resolver.gather(&scene.entities, &mut Vec::new());
    resolver.materials = scene
        .materials
        .iter()
        .map(|(id, _)| id.value.clone())
        .collect();
    resolver.look_up(&scene.entities, folder);
    resolver.look_up_timeline(&scene);
    if let Some(id) = &scene.active_camera {
        resolver.known_entity(id);
    }
    resolver.summary.materials = scene.materials.len();
    resolver.summary.tracks = scene.timeline.tracks.len() + scene.timeline.paths.len();
    resolver.summary.timeline_secs = scene.timeline.length.unwrap_or(last_key(&scene.timeline));
    if resolver.reader.problems.is_empty() {
        resolver.warn_of_darkness(&scene);
    }
    let report = Report {
        problems: Problems(locate(resolver.reader.problems, text, path)),
        warnings: locate(resolver.warnings, text, path),
        summary: resolver.summary,
    };
    (
        Resolved {
            scene,
            models: resolver.models,
        },
        report,
    )
}

#[derive(Default)]
struct Resolver {
    reader: Reader,
    warnings: Vec<RawProblem>,
    /// Ids of entities, each with the ids above it.
    entities: HashMap<String, Vec<String>>,
    materials: HashSet<String>,
    models: HashMap<MeshKey, Model>,
    /// Mesh files that could not be imported, so that each is told once a use.
    failed: HashMap<MeshKey, String>,
    summary: Summary,
}

impl Resolver {
    /// Warns of what makes the picture arbitrary or black: no camera, nothing that shines.
    fn warn_of_darkness(&mut self, scene: &Scene) {
        let mut warn = |what: &str, expected: &str| {
            self.warnings.push(RawProblem {
                place: Place::default(),
                what: what.into(),
                expected: Some(expected.into()),
                suggestion: None,
            });
        };
        if self.summary.cameras == 0 {
            warn(
                "there is no camera, so the picture shows the whole scene from one side",
                "an entity with `camera: ()`",
            );
        }
        let own = scene.materials.iter().map(|(_, material)| material);
        let models = self.models.values().flat_map(|model| &model.materials);
        let imported = models.map(|(_, material)| material);
        let keyed = |track: &schema::Track| track.field.value == "material.emission";
        let glows = own.chain(imported).any(|material| material.emission > 0.0)
            || scene.timeline.tracks.iter().any(keyed);
        if self.summary.lights == 0 && !glows {
            warn(
                "there is no light and no material with emission, so all shapes are black",
                "an entity with `light: Point()`, or a material with `emission`",
            );
        }
    }

    /// Collects ids, and reports those that are there twice.
    fn gather(&mut self, entities: &[Entity], above: &mut Vec<String>) {
        for entity in entities {
            self.summary.entities += 1;
            self.summary.lights += usize::from(entity.light.is_some());
            self.summary.cameras += usize::from(entity.camera.is_some());
            if let Some(id) = &entity.id
                && self
                    .entities
                    .insert(id.value.clone(), above.clone())
                    .is_some()
            {
                self.reader.report_at(
                    id.place.clone(),
                    format!("the id `{}` is there twice", id.value),
                    Some("an id of its own".into()),
                    None,
                );
            }
            above.extend(entity.id.as_ref().map(|id| id.value.clone()));
            let depth = above.len();
            self.gather(&entity.children, above);
            above.truncate(depth - usize::from(entity.id.is_some()));
        }
    }

    /// Reports materials and meshes that are not there.
    fn look_up(&mut self, entities: &[Entity], folder: &Path) {
        for entity in entities {
            if let Some(material) = &entity.material
                && !self.materials.contains(&material.value)
            {
                self.unknown("material", material, |resolver| {
                    resolver.materials.iter().collect()
                });
            }
            match &entity.shape {
                Some(Shape::Mesh(mesh)) => self.open_mesh(mesh, folder),
                Some(_) => self.summary.shapes += 1,
                None => {}
            }
            self.look_up(&entity.children, folder);
        }
    }

    fn unknown(&mut self, what: &str, id: &At<String>, valid: impl Fn(&Self) -> Vec<&String>) {
        let mut names: Vec<String> = valid(self).into_iter().cloned().collect();
        names.sort();
        let suggestion = nearest(&id.value, names.iter().map(String::as_str));
        let mut list = names
            .iter()
            .take(12)
            .map(|name| format!("`{name}`"))
            .collect::<Vec<_>>()
            .join(", ");
        if names.len() > 12 {
            list.push_str(", ...");
        }
        let expected = if names.is_empty() {
            format!("one that is there (no {what} is)")
        } else {
            format!("one of {list}")
        };
        let short: String = id.value.chars().take(60).collect();
        self.reader.report_at(
            id.place.clone(),
            format!("unknown {what} `{short}`"),
            Some(expected),
            suggestion,
        );
    }

    fn known_entity(&mut self, id: &At<String>) -> bool {
        let known = self.entities.contains_key(&id.value);
        if !known {
            self.unknown("id", id, |resolver| resolver.entities.keys().collect());
        }
        known
    }

    fn open_mesh(&mut self, mesh: &MeshFile, folder: &Path) {
        let key = mesh_key(&mesh.path.value, mesh.smooth_angle);
        let place = &mesh.path.place;
        if !self.models.contains_key(&key) && !self.failed.contains_key(&key) {
            match import(&folder.join(&mesh.path.value), mesh.smooth_angle) {
                Ok(model) => {
                    self.warnings
                        .extend(model.warnings.iter().map(|warning| RawProblem {
                            place: place.clone(),
                            what: format!("`{}`: {warning}", mesh.path.value),
                            expected: None,
                            suggestion: None,
                        }));
                    self.models.insert(key.clone(), model);
                }
                Err(why) => {
                    self.failed.insert(key.clone(), why);
                }
            }
        }
        if let Some(model) = self.models.get(&key) {
            self.summary.meshes += 1;
            self.summary.triangles += model.triangles();
        } else if let Some(why) = self.failed.get(&key) {
            let file = folder.join(&mesh.path.value);
            let (what, expected) = if file.is_file() {
                (
                    format!("the mesh `{}` cannot be used: {why}", mesh.path.value),
                    "a valid OBJ file".into(),
                )
            } else {
                let searched = file.parent().unwrap_or(folder).display();
                (
                    format!("there is no mesh file `{}`", mesh.path.value),
                    format!("a file in the folder `{searched}`"),
                )
            };
            let nearest = if file.is_file() {
                None
            } else {
                nearest_file(&file)
            };
            self.reader
                .report_at(place.clone(), what, Some(expected), nearest);
        }
    }

    /// Reports tracks and paths whose targets are not there, or that go round in circles.
    fn look_up_timeline(&mut self, scene: &Scene) {
        let mut keyed: HashSet<(&str, &str)> = HashSet::new();
        for track in &scene.timeline.tracks {
            if track.field.value.starts_with("material.") {
                if !self.materials.contains(&track.target.value) {
                    self.unknown("material", &track.target, |resolver| {
                        resolver.materials.iter().collect()
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

    /// Reports a field of a component that the entity does not have.
    fn has_field(&mut self, scene: &Scene, id: &str, field: &At<String>) {
        let Some(entity) = find(&scene.entities, id) else {
            return;
        };
        let component = field.value.split('.').next().unwrap_or_default();
        let there = match component {
            "sphere" => matches!(entity.shape, Some(Shape::Sphere(_))),
            "plane" => matches!(entity.shape, Some(Shape::Plane(_))),
            "box" => matches!(entity.shape, Some(Shape::Box(_))),
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
        if let Err(i) = super::timeline::sorted(&needs) {
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

fn find<'a>(entities: &'a [Entity], id: &str) -> Option<&'a Entity> {
    entities.iter().find_map(|entity| {
        let own = entity.id.as_ref().is_some_and(|own| own.value == id);
        if own {
            Some(entity)
        } else {
            find(&entity.children, id)
        }
    })
}

fn import(path: &Path, smooth_angle: Option<f64>) -> Result<Model, String> {
    let mut model = import_obj(path)?;
    if let Some(angle) = smooth_angle {
        for part in &mut model.parts {
            part.mesh = smooth(&part.mesh, angle);
        }
    }
    Ok(model)
}

/// The file of the same folder whose name is nearest, if one is near enough.
pub fn nearest_file(path: &Path) -> Option<String> {
    let name = path.file_name()?.to_str()?;
    let folder = path
        .parent()
        .filter(|folder| *folder != Path::new(""))
        .map_or(PathBuf::from("."), Path::to_path_buf);
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .ok()?
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .collect();
    names.sort();
    nearest(
        name,
        names
            .iter()
            .map(String::as_str)
            .filter(|near| *near != name),
    )
}
