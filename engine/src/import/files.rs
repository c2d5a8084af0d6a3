//! The files that a model is made of: all of an importer's reading goes through here, so that a cache knows what a model
//! depends on, files that were looked for and not there included.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// Longest file that is read, bytes.
pub const LONGEST: u64 = 1 << 30;

/// The hash of a file's bytes; none: there is no such file, or none that [`Files::bytes`] reads.
pub type Content = Option<[u8; 32]>;

/// What was read for a model so far; none: something that cannot be named here.
type Seen = Option<BTreeMap<PathBuf, Content>>;

/// See the module.
#[derive(Debug)]
pub struct Files {
    folder: PathBuf,
    seen: Mutex<Seen>,
}

impl Files {
    /// Those of a model in that folder, where the files are that it names.
    pub fn of_folder(folder: &Path) -> Self {
        Self {
            folder: folder.to_owned(),
            seen: Mutex::new(Some(BTreeMap::new())),
        }
    }

    /// Those of the model in that file.
    pub fn beside(path: &Path) -> Self {
        Self::of_folder(path.parent().unwrap_or(Path::new("")))
    }

    /// Where the model is.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The bytes of a file. Not of a device, which could be read for ever.
    ///
    /// # Errors
    /// Why it cannot be read, as a sentence without its name.
    pub fn bytes(&self, path: &Path) -> Result<Vec<u8>, String> {
        let bytes = bytes_of(path);
        self.note(path, bytes.as_ref().ok().map(|bytes| hash(bytes)));
        bytes
    }

    /// Whether a file is there. One that is, and is made use of, is to be read by [`Files::bytes`].
    pub fn is_there(&self, path: &Path) -> bool {
        let is_there = path.is_file();
        if !is_there {
            self.note(path, None);
        }
        is_there
    }

    /// Takes note that others read files which they do not name: what comes of them may change unseen.
    pub fn lose_track(&self) {
        *self.lock() = None;
    }

    /// Every file that was asked for; none: there are others.
    pub fn into_seen(self) -> Option<BTreeMap<PathBuf, Content>> {
        self.lock().take()
    }

    fn note(&self, path: &Path, content: Content) {
        let mut seen = self.lock();
        let Some(files) = seen.as_mut() else { return };
        let before = files.insert(path.to_owned(), content);
        if before.is_some_and(|before| before != content) {
            // It changed while it was read.
            *seen = None;
        }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Seen> {
        // A reader that panicked has noted all that it read.
        self.seen.lock().unwrap_or_else(|held| held.into_inner())
    }
}

/// The content of a file as it is now.
pub fn content_of(path: &Path) -> Content {
    check(path).ok()?;
    let mut hasher = blake3::Hasher::new();
    let file = File::open(path).ok()?;
    hasher.update_reader(file.take(LONGEST)).ok()?;
    Some(*hasher.finalize().as_bytes())
}

fn hash(bytes: &[u8]) -> [u8; 32] {
    *blake3::hash(bytes).as_bytes()
}

/// [`Files::bytes`] of a file that no cache depends on.
pub fn bytes_of(path: &Path) -> Result<Vec<u8>, String> {
    check(path)?;
    fs::read(path).map_err(unreadable)
}

/// Whether this is a file to be read, before it is opened: to open a pipe waits for whoever writes to it.
fn check(path: &Path) -> Result<(), String> {
    let what = fs::metadata(path).map_err(unreadable)?;
    if !what.is_file() {
        return Err("it cannot be read: it is not a file".into());
    }
    if what.len() > LONGEST {
        return Err(format!("it is longer than {} MiB", LONGEST >> 20));
    }
    Ok(())
}

fn unreadable(error: std::io::Error) -> String {
    format!("it cannot be read: {error}")
}
