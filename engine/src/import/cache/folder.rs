//! The folder of kept models: where it is, reading, writing, and keeping it small.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, SystemTime};

/// Names the folder instead of the system; empty: there is no cache.
const CACHE_VARIABLE: &str = "ORRERY_CACHE_DIR";
/// Ends the names of kept models.
const ENDING: &str = "model";
/// Ends the names of files that are being written.
const UNFINISHED: &str = "unfinished";
/// A file that is written for longer was given up.
const GIVEN_UP: Duration = Duration::from_secs(3600);

/// The folder for models that the user or the system says; none: there is to be no cache, or no place for one.
pub fn user_folder() -> Option<PathBuf> {
    Some(cache_folder()?.join("models"))
}

/// The folder beside it for what drivers have compiled.
pub fn pipelines_folder() -> Option<PathBuf> {
    Some(cache_folder()?.join("pipelines"))
}

fn cache_folder() -> Option<PathBuf> {
    match std::env::var_os(CACHE_VARIABLE) {
        Some(folder) if folder.is_empty() => None,
        Some(folder) => Some(PathBuf::from(folder)),
        None => Some(system_folder()?.join("orrery")),
    }
}

/// Where programs keep what they can make again.
fn system_folder() -> Option<PathBuf> {
    let folder = |name: &str| {
        let folder = PathBuf::from(std::env::var_os(name)?);
        folder.is_absolute().then_some(folder)
    };
    if cfg!(target_os = "windows") {
        folder("LOCALAPPDATA")
    } else if cfg!(target_os = "macos") {
        Some(folder("HOME")?.join("Library/Caches"))
    } else {
        // The XDG Base Directory Specification.
        folder("XDG_CACHE_HOME").or_else(|| Some(folder("HOME")?.join(".cache")))
    }
}

/// The bytes of a kept model.
pub fn read(folder: &Path, name: &str, most_bytes: u64) -> Option<Vec<u8>> {
    let path = path_of(folder, name);
    let file = fs::metadata(&path).ok()?;
    (file.is_file() && file.len() <= most_bytes).then(|| fs::read(path).ok())?
}

/// Takes note that a model was used now, so that others are removed first.
pub fn note_use(folder: &Path, name: &str) {
    let file = File::options().write(true).open(path_of(folder, name));
    // Where it cannot be noted, the folder is not ours to clean either.
    let _ = file.and_then(|file| file.set_modified(SystemTime::now()));
}

/// Keeps a model, and removes others where there is no room for all.
pub fn write(folder: &Path, name: &str, bytes: &[u8], most_bytes: u64) {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let Some(room) = most_bytes.checked_sub(bytes.len() as u64) else {
        return;
    };
    if fs::create_dir_all(folder).is_err() {
        return;
    }
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    let process = std::process::id();
    let unfinished = folder.join(format!("{name}.{process}.{count}.{UNFINISHED}"));
    make_room(folder, name, room);
    let whole =
        fs::write(&unfinished, bytes).and_then(|()| fs::rename(&unfinished, path_of(folder, name)));
    if whole.is_err() {
        let _ = fs::remove_file(&unfinished);
    }
}

/// Removes the models that were not used for longest until the others, but for this one, take at most so many bytes.
fn make_room(folder: &Path, name: &str, most_bytes: u64) {
    let now = SystemTime::now();
    let mut kept = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        let Some((used, bytes)) = entry
            .metadata()
            .ok()
            .filter(fs::Metadata::is_file)
            .and_then(|file| Some((file.modified().ok()?, file.len())))
        else {
            continue;
        };
        let ending = path.extension().unwrap_or_default();
        if ending == UNFINISHED && now.duration_since(used).is_ok_and(|age| age > GIVEN_UP) {
            let _ = fs::remove_file(&path);
        } else if ending == ENDING && path != path_of(folder, name) {
            kept.push((used, bytes, path));
        }
    }
    kept.sort();
    let mut total: u64 = kept.iter().map(|(_, bytes, _)| bytes).sum();
    for (_, bytes, path) in kept {
        if total <= most_bytes {
            break;
        }
        if fs::remove_file(&path).is_ok() {
            total -= bytes;
        }
    }
}

fn path_of(folder: &Path, name: &str) -> PathBuf {
    folder.join(format!("{name}.{ENDING}"))
}
