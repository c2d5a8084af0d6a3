//! From text to a scene whose names and files are all found. Needs no world, so `check` can use it.

mod clips;
mod poses;
mod textures;
mod timeline;

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::model_file;
use super::problem::{Place, Problems, RawProblem, Report, Summary, locate, nearest};
use super::reader::{Reader, Schema};
use super::schema::{self, At, Entity, MeshFile, Scene, Shape};
use super::syntax;
use super::timeline::last_key;
use crate::import::{self, Content, Loader, Model};
use crate::world::Texture;
pub use poses::PoseKey;
pub use textures::{TextureKey, pictures, texture_key};

/// A scene and its meshes.
pub struct Resolved {
    pub scene: Scene,
    /// By path and smoothing, as [`mesh_key`] says.
    pub models: HashMap<MeshKey, Model>,
    /// Places of the vertices of each part, by mesh and path of the pose.
    pub poses: HashMap<PoseKey, Vec<Vec<DVec3>>>,
    /// Pictures of materials; none: the file could not be read.
    pub textures: HashMap<TextureKey, Option<Texture>>,
    /// The background's panorama.
    pub sky: Option<Texture>,
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
pub fn resolve(text: &str, path: &Path, loader: &Loader) -> (Resolved, Report) {
    let (scene, problems) = read(text);
    look_up((scene, problems), (text, path), loader)
}

/// A model file as the scene that shows it.
pub fn resolve_model(path: &Path, loader: &Loader) -> (Resolved, Report) {
    let scene = (model_file::scene_of(path), Vec::new());
    let (mut resolved, mut report) = look_up(scene, ("", path), loader);
    model_file::complete(&mut resolved);
    for problem in report.problems.0.iter_mut().chain(&mut report.warnings) {
        // Importers say where in the file; the scene that shows it is written nowhere.
        (problem.line, problem.column) = (0, 0);
        problem.field.clear();
    }
    (resolved, report)
}

/// Looks up every name, opens every file.
fn look_up(
    (scene, problems): (Scene, Vec<RawProblem>),
    (text, path): (&str, &Path),
    loader: &Loader,
) -> (Resolved, Report) {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut resolver = Resolver {
        loader: loader.clone(),
        ..Resolver::default()
    };
    resolver.reader.problems = problems;
    resolver.gather(&scene.entities, &mut Vec::new());
    resolver.materials = scene
        .materials
        .iter()
        .map(|(id, _)| id.value.clone())
        .collect();
    let sky = resolver.open_sky(&scene.background, folder);
    for (_, material) in &scene.materials {
        resolver.open_textures(material, folder);
    }
    resolver.load_models(&scene.entities, folder);
    resolver.look_up(&scene.entities, folder);
    resolver.look_up_timeline(&scene);
    if let Some(id) = &scene.active_camera {
        resolver.known_entity(id);
    }
    resolver.summary.materials = scene.materials.len();
    resolver.summary.tracks = scene.timeline.tracks.len() + scene.timeline.paths.len();
    resolver.summary.timeline_secs = scene.timeline.length.unwrap_or(last_key(&scene.timeline));
    // A model by itself is given what it lacks.
    if resolver.reader.problems.is_empty() && !import::is_model(path) {
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
            poses: resolver.poses,
            textures: resolver.textures,
            sky,
        },
        report,
    )
}

/// Names that are not there for which suggestions are looked for.
const COMPARED: usize = 20;

#[derive(Default)]
struct Resolver {
    loader: Loader,
    reader: Reader,
    warnings: Vec<RawProblem>,
    /// Ids of entities, each with the ids above it.
    entities: HashMap<String, Vec<String>>,
    materials: HashSet<String>,
    models: HashMap<MeshKey, Model>,
    poses: HashMap<PoseKey, Vec<Vec<DVec3>>>,
    textures: HashMap<TextureKey, Option<Texture>>,
    /// Warnings of models that were not told yet.
    unsaid: HashMap<MeshKey, Vec<String>>,
    /// Mesh files that could not be imported, so that each is told once a use.
    failed: HashMap<MeshKey, String>,
    /// Names that were not there and were compared with those that are.
    compared: usize,
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
        let own = scene.materials.iter().map(|(_, file)| &file.material);
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
                self.unknown("material", material, |own| {
                    own.materials.iter().cloned().collect()
                });
            }
            match &entity.shape {
                Some(Shape::Mesh(mesh)) => self.open_mesh(mesh, folder),
                Some(_) => self.summary.shapes += 1,
                None => {}
            }
            self.look_up_clips(entity);
            self.open_poses(entity, folder);
            self.look_up(&entity.children, folder);
        }
    }

    /// Reports a name that is not there; the first few with those that are.
    fn unknown(&mut self, what: &str, id: &At<String>, names: impl Fn(&Self) -> Vec<String>) {
        let is_compared = self.may_compare();
        let mut names = match is_compared {
            true => names(self),
            false => Vec::new(),
        };
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
        let expected = if !is_compared {
            "one that is there".to_owned()
        } else if names.is_empty() {
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

    /// Whether another name that is not there may be compared with all that are: with thousands of either it would take
    /// long, and nobody reads so many suggestions.
    fn may_compare(&mut self) -> bool {
        self.compared += 1;
        self.compared <= COMPARED
    }

    fn known_entity(&mut self, id: &At<String>) -> bool {
        let known = self.entities.contains_key(&id.value);
        if !known {
            self.unknown("id", id, |own| own.entities.keys().cloned().collect());
        }
        known
    }

    /// Loads the model of every mesh.
    fn load_models(&mut self, entities: &[Entity], folder: &Path) {
        let mut keys = Vec::new();
        list_models(entities, (&mut keys, &mut HashSet::new()));
        let files: Vec<_> = keys
            .iter()
            .map(|(path, angle)| (folder.join(path), angle.map(f64::from_bits)))
            .collect();
        for (key, model) in keys.into_iter().zip(self.loader.load(&files)) {
            match model {
                Ok(model) => {
                    let warnings = model.warnings.sentences();
                    self.unsaid.insert(key.clone(), warnings);
                    self.models.insert(key, model);
                }
                Err(why) => drop(self.failed.insert(key, why)),
            }
        }
    }

    fn open_mesh(&mut self, mesh: &MeshFile, folder: &Path) {
        let key = mesh_key(&mesh.path.value, mesh.smooth_angle);
        let place = &mesh.path.place;
        // Told where the file is named first.
        for warning in self.unsaid.remove(&key).into_iter().flatten() {
            self.warnings.push(RawProblem {
                place: place.clone(),
                what: format!("`{}`: {warning}", mesh.path.value),
                expected: None,
                suggestion: None,
            });
        }
        if let Some(model) = self.models.get(&key) {
            self.summary.meshes += model.parts.len().min(1);
            self.summary.triangles += model.triangles();
            self.summary.clips += model.clips.len();
            for content in model.contents() {
                self.summary.lights += usize::from(content.is_light());
                self.summary.cameras += usize::from(matches!(content, Content::Camera(_)));
                self.summary.shapes += usize::from(matches!(content, Content::Solid { .. }));
            }
        } else if let Some(why) = self.failed.get(&key) {
            let file = folder.join(&mesh.path.value);
            let (what, expected) = if file.is_file() {
                (
                    format!("the mesh `{}` cannot be used: {why}", mesh.path.value),
                    format!(
                        "a valid file of a format whose name ends in {}",
                        import::endings()
                    ),
                )
            } else {
                let searched = file.parent().unwrap_or(folder).display();
                (
                    format!("there is no mesh file `{}`", mesh.path.value),
                    format!("a file in the folder `{searched}`"),
                )
            };
            let nearest = match !file.is_file() && self.may_compare() {
                true => nearest_file(&file),
                false => None,
            };
            self.reader
                .report_at(place.clone(), what, Some(expected), nearest);
        }
    }
}

/// Every mesh once, in order.
fn list_models(entities: &[Entity], (keys, seen): (&mut Vec<MeshKey>, &mut HashSet<MeshKey>)) {
    for entity in entities {
        if let Some(Shape::Mesh(mesh)) = &entity.shape {
            let key = mesh_key(&mesh.path.value, mesh.smooth_angle);
            if seen.insert(key.clone()) {
                keys.push(key);
            }
        }
        list_models(&entity.children, (keys, seen));
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
