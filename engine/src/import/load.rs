//! A model file to a model that is ready to trace: read or taken from the cache, smoothed, the trees of its meshes built.
//!
//! Parts are smoothed and their trees built side by side; what comes of it does not depend on how many threads do it.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use bevy_ecs::prelude::*;
use rayon::prelude::*;

use super::{Cache, Files, Model, Part, Progress, import_from, smooth_part};
use crate::bvh::Tree;

/// How model files are loaded.
#[derive(Resource, Clone, Debug, Default)]
pub struct Loader {
    /// Where models are kept from one start to the next; none: nowhere.
    pub cache: Option<Cache>,
    /// Who looks here is told how far loading is.
    pub progress: Progress,
}

impl Loader {
    /// Loads models side by side, each with its smoothing angle in degrees if its normals are to be made anew. What comes
    /// of them is in their order.
    ///
    /// # Errors
    /// See [`super::import()`].
    pub fn load(&self, models: &[(PathBuf, Option<f64>)]) -> Vec<Result<Model, String>> {
        self.progress.expect(models.len());
        let loaded = models.par_iter().map(|(path, smooth_angle)| {
            let model = self.load_one(path, *smooth_angle);
            self.progress.advance();
            model
        });
        loaded.collect()
    }

    fn load_one(&self, path: &Path, smooth_angle: Option<f64>) -> Result<Model, String> {
        let files = Files::beside(path);
        let keyed = self.cache.as_ref();
        let keyed = keyed.and_then(|cache| Some((cache, cache.key(path, smooth_angle)?)));
        let Some((cache, key)) = keyed else {
            return self.make(path, smooth_angle, &files);
        };
        self.step("looking in the cache for", path);
        if let Some(model) = cache.find(&key, path) {
            self.progress.find();
            return Ok(model);
        }
        let begun = Instant::now();
        let model = self.make(path, smooth_angle, &files)?;
        if begun.elapsed() >= cache.least {
            self.step("keeping in the cache", path);
            cache.keep(&key, path, (files, &model));
        }
        Ok(model)
    }

    fn make(&self, path: &Path, smooth_angle: Option<f64>, files: &Files) -> Result<Model, String> {
        self.step("reading", path);
        let mut model = import_from(path, files)?;
        self.step("building the trees of", path);
        self.progress.expect(model.parts.len());
        model.parts.par_iter_mut().for_each(|part| {
            if let Some(angle) = smooth_angle {
                smooth_part(part, angle);
            }
            build_tree(part);
            self.progress.advance();
        });
        Ok(model)
    }

    fn step(&self, what: &str, path: &Path) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        self.progress.begin(format!("{what} {name}"));
    }
}

/// Builds the tree of a part that is traced as it is; one that deforms is given one as it is deformed at first.
fn build_tree(part: &mut Part) {
    let deforms = part.keys.is_some() || part.morph.is_some() || part.binding.is_some();
    if !deforms {
        part.mesh.tree = Some(Arc::new(Tree::build(&part.mesh.boxes())));
    }
}
