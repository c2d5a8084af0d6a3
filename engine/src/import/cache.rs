//! Models kept from one start to the next: a file a model, in a folder of the user's.
//!
//! A file is named by its key, a hash of all that decides what the model becomes: the bytes of the model file, its
//! format, the smoothing, and the sources that this program was built from, so that no other version's are read. It
//! repeats its key inside, and lists the files that the model refers to (materials, pictures, includes) with their
//! hashes, those that were not there as well; where one has changed, the model is made anew.
//!
//! Nothing here fails a load: what is not there, broken or of others is made anew and replaced, what cannot be written is
//! not kept. A file is written under another name first, so several programs may share the folder.

mod entry;
mod folder;

use std::path::{Path, PathBuf};
use std::time::Duration;

use rayon::prelude::*;

use super::files::{Content, content_of};
use super::{Files, Model, format_of};

pub use folder::{pipelines_folder, user_folder};

/// Models that took less are not kept: finding one costs milliseconds too, and many small ones would push out the few
/// that are worth it.
const LEAST: Duration = Duration::from_millis(20);
/// Bytes that all files may come to; the ones that were not used for longest go first.
const MOST_BYTES: u64 = 2 << 30;

/// See the module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cache {
    folder: PathBuf,
    /// What making a model must take for it to be kept.
    pub least: Duration,
    /// Bytes that all that is kept may come to.
    pub most_bytes: u64,
}

/// What tells a model from all others, and the content of its file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Key {
    hash: blake3::Hash,
    content: Content,
}

impl Cache {
    /// A cache in that folder, which need not be there.
    pub fn in_folder(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: folder.into(),
            least: LEAST,
            most_bytes: MOST_BYTES,
        }
    }

    /// The key of a model file as it is now; none: there is none that could be read.
    pub(super) fn key(&self, path: &Path, smooth_angle: Option<f64>) -> Option<Key> {
        let format = format_of(path)?;
        let content = content_of(path)?;
        let mut hasher = blake3::Hasher::new();
        hasher.update(&content);
        hasher.update(&entry::BUILD);
        hasher.update(format.name.as_bytes());
        if let Some(angle) = smooth_angle {
            hasher.update(&angle.to_bits().to_le_bytes());
        }
        Some(Key {
            hash: hasher.finalize(),
            content: Some(content),
        })
    }

    /// The model of that key, if all files that it refers to are as they were.
    pub(super) fn find(&self, key: &Key, path: &Path) -> Option<Model> {
        let bytes = folder::read(&self.folder, &key.name(), self.most_bytes)?;
        let beside = Files::beside(path);
        let model = entry::decode(&bytes, key.hash.as_bytes(), |files| {
            let as_now = |(name, content): &(String, Content)| {
                content_of(&beside.folder().join(name)) == *content
            };
            files.par_iter().all(as_now)
        })?;
        folder::note_use(&self.folder, &key.name());
        Some(model)
    }

    /// Keeps a model that was made of these files.
    pub(super) fn keep(&self, key: &Key, path: &Path, (files, model): (Files, &Model)) {
        let folder = files.folder().to_owned();
        let Some(mut seen) = files.into_seen() else {
            return;
        };
        // The model may be of other bytes than the key.
        if seen.remove(path) != Some(key.content) {
            return;
        }
        let name = |file: &PathBuf| {
            let name = file.strip_prefix(&folder).unwrap_or(file);
            name.to_str().map(str::to_owned)
        };
        let files = seen
            .iter()
            .map(|(file, content)| Some((name(file)?, *content)));
        let Some(files) = files.collect::<Option<Vec<_>>>() else {
            return;
        };
        let bytes = entry::encode(key.hash.as_bytes(), (&files, model), self.most_bytes);
        if let Some(bytes) = bytes {
            folder::write(&self.folder, &key.name(), &bytes, self.most_bytes);
        }
    }
}

impl Key {
    /// What the file is called that holds the model, without an ending.
    fn name(&self) -> String {
        self.hash.to_hex().to_string()
    }
}
