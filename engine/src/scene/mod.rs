//! The scene file: reading, checking, loading, saving, and the timeline it holds.
//!
//! The format's manual is `assets/scenes/README.md`. On the way in: text, tree with places (`syntax`), values
//! ([`schema`]), names and files resolved (`resolve`), entities (`spawn`). On the way out: entities,
//! values, text (`save`). Problems are collected all the way, so [`check`] lists every one.
//!
//! [`fields`] is the one mechanism for edits: a value by (id, path).

pub mod fields;
mod model_file;
mod problem;
mod reader;
mod rebase;
mod rehearsal;
mod resolve;
mod save;
pub mod schema;
mod spawn;
mod syntax;
mod timeline;
mod writer;

pub use crate::import::{Loader, Progress, endings, is_model};
pub use problem::{LoadReport, Place, Problem, Problems, Report, Summary, edit_distance};
pub use reader::{Fields, Reader, Schema};
pub use save::{describe, save, text_of};
pub use spawn::{Imported, MeshSource, PoseFiles, SceneRoots, unload};
pub use syntax::{Entry, Kind, Node};
pub use timeline::{Curve, Timeline, play_timeline};
pub use writer::Writer;

use std::path::Path;

use bevy_ecs::prelude::*;
use bevy_ecs::reflect::AppTypeRegistry;

use crate::app::Engine;
use crate::schedule::FrameSet;

/// Largest scene file that is read, bytes: a mesh belongs into a file of its own.
const MAX_BYTES: u64 = 64 << 20;

/// Adds the timeline (set [`FrameSet::Animate`]) and what loading and saving need.
pub fn plugin(engine: &mut Engine) {
    engine.world.init_resource::<Timeline>();
    engine.world.init_resource::<SceneRoots>();
    let registry = engine.world.get_resource_or_init::<AppTypeRegistry>();
    registry.write().register::<MeshSource>();
    registry.write().register::<Imported>();
    registry.write().register::<PoseFiles>();
    // Cameras look at where things in motion are now; what it keys of clips holds in the same frame.
    engine.add_systems(
        FrameSet::Animate,
        play_timeline
            .after(crate::world::move_things)
            .before(crate::world::play_clips),
    );
}

/// Loads a scene file in place of the scene that is there; a model file, as the scene that shows it.
///
/// # Errors
/// Every problem of the file; the world is then as it was.
pub fn load(world: &mut World, path: &Path) -> Result<LoadReport, Problems> {
    let loader = world.get_resource_or_init::<Loader>().clone();
    put(world, prepare(path, &loader)?)
}

/// A scene that is read, but in no world yet.
pub struct Prepared {
    resolved: resolve::Resolved,
    report: Report,
    /// The model file that is shown by itself, and is to be framed by all it does.
    model: Option<std::path::PathBuf>,
}

/// The first part of [`load`], and the one that takes long; needs no world, so any thread can do it.
///
/// # Errors
/// The file cannot be read; what else is wrong is told by [`put`].
pub fn prepare(path: &Path, loader: &Loader) -> Result<Prepared, Problems> {
    let is_model = is_model(path);
    let (resolved, report) = if is_model {
        resolve::resolve_model(path, loader)
    } else {
        resolve::resolve(&read_text(path)?, path, loader)
    };
    Ok(Prepared {
        resolved,
        report,
        model: is_model.then(|| path.to_owned()),
    })
}

/// Loads a scene from text; `path` names it in problems, and mesh files are found from its folder.
///
/// # Errors
/// See [`load`].
pub fn load_text(world: &mut World, text: &str, path: &Path) -> Result<LoadReport, Problems> {
    let loader = world.get_resource_or_init::<Loader>().clone();
    let (resolved, report) = resolve::resolve(text, path, &loader);
    put(
        world,
        Prepared {
            resolved,
            report,
            model: None,
        },
    )
}

/// The second part of [`load`].
///
/// # Errors
/// See [`load`].
pub fn put(
    world: &mut World,
    Prepared {
        resolved,
        mut report,
        model,
    }: Prepared,
) -> Result<LoadReport, Problems> {
    if !report.problems.0.is_empty() {
        return Err(report.problems);
    }
    unload(world);
    spawn::spawn(world, resolved);
    if let Some(path) = model {
        let told = rehearsal::rehearse(world).into_iter();
        report.warnings.extend(told.map(|what| Problem {
            file: path.clone(),
            line: 0,
            column: 0,
            field: String::new(),
            what,
            expected: None,
            suggestion: None,
        }));
    }
    Ok(LoadReport {
        warnings: report.warnings,
        summary: report.summary,
    })
}

/// Adds what a model file shows to the scene that is there; `scene` is the file that the scene is of. The entities made: the
/// one that stands for the model first, then materials of the file.
///
/// # Errors
/// Every problem of the model's file; the world is then as it was.
pub fn add_model(
    world: &mut World,
    (id, model): (&str, &Path),
    scene: &Path,
) -> Result<Vec<Entity>, Problems> {
    let folder = scene.parent().unwrap_or(Path::new(""));
    let mesh = schema::MeshFile {
        path: rebase::path_from(folder, model).into(),
        smooth_angle: None,
    };
    let entity = schema::Entity {
        id: Some(id.to_owned().into()),
        shape: Some(schema::Shape::Mesh(mesh)),
        ..schema::Entity::default()
    };
    let text = text_of(&schema::Scene {
        entities: vec![entity],
        ..schema::Scene::default()
    });
    let loader = world.get_resource_or_init::<Loader>().clone();
    let (resolved, report) = resolve::resolve(&text, scene, &loader);
    if !report.problems.0.is_empty() {
        return Err(report.problems);
    }
    let (mut made, materials) = spawn::add(world, resolved);
    made.extend(materials);
    Ok(made)
}

/// Lists every problem of a scene file or a model file, and what is right, without a world.
pub fn check(path: &Path) -> Report {
    if is_model(path) {
        return resolve::resolve_model(path, &Loader::default()).1;
    }
    match read_text(path) {
        Ok(text) => check_text(&text, path),
        Err(problems) => Report {
            problems,
            ..Report::default()
        },
    }
}

/// [`check`] for text; `path` as in [`load_text`].
pub fn check_text(text: &str, path: &Path) -> Report {
    resolve::resolve(text, path, &Loader::default()).1
}

/// A scene file's values without their meaning: no file is opened, no id looked up.
///
/// # Errors
/// Every problem of form.
pub fn parse(text: &str, path: &Path) -> Result<schema::Scene, Problems> {
    let (scene, raw) = resolve::read(text);
    if raw.is_empty() {
        Ok(scene)
    } else {
        Err(Problems(problem::locate(raw, text, path)))
    }
}

/// The text of a file.
fn read_text(path: &Path) -> Result<String, Problems> {
    let fail = |what: String, expected: &str| {
        Problems(vec![Problem {
            file: path.to_owned(),
            line: 0,
            column: 0,
            field: String::new(),
            what,
            expected: Some(expected.to_owned()),
            suggestion: resolve::nearest_file(path),
        }])
    };
    let size = std::fs::metadata(path).map(|metadata| metadata.len());
    if size.is_ok_and(|size| size > MAX_BYTES) {
        return Err(fail(
            format!("the file is larger than {} MiB", MAX_BYTES >> 20),
            "a scene file; large meshes go into OBJ files",
        ));
    }
    let bytes = std::fs::read(path).map_err(|error| {
        fail(
            format!("the file cannot be read: {error}"),
            "a scene file (RON)",
        )
    })?;
    String::from_utf8(bytes)
        .map_err(|_| fail("the file is not UTF-8 text".into(), "a scene file (RON)"))
}

#[cfg(test)]
mod tests;
