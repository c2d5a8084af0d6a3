//! Tells the engine which sources it is built from: what older ones left in the cache of models is not read
//! (`src/import/cache`), whether or not anybody thought of counting a version up.

use std::collections::hash_map::DefaultHasher;
use std::fs;
use std::hash::{Hash, Hasher};
use std::path::{Path, PathBuf};

/// What decides what becomes of a model file: the code, which crates it uses, and with which of their features. Not all
/// that could: another compiler, or other flags for it, may round or lay numbers out otherwise and goes unseen here.
const SOURCES: [&str; 4] = ["src", "Cargo.toml", "../Cargo.toml", "../Cargo.lock"];

fn main() {
    let mut files = Vec::new();
    for source in SOURCES {
        println!("cargo::rerun-if-changed={source}");
        list(Path::new(source), &mut files);
    }
    files.sort();
    let mut hasher = DefaultHasher::new();
    for file in &files {
        (file, fs::read(file).unwrap_or_default()).hash(&mut hasher);
    }
    for variable in ["TARGET", "PROFILE", "CARGO_PKG_VERSION"] {
        std::env::var(variable)
            .unwrap_or_default()
            .hash(&mut hasher);
    }
    println!("cargo::rustc-env=ORRERY_SOURCES={:016x}", hasher.finish());
}

/// Files at and below a path.
fn list(path: &Path, files: &mut Vec<PathBuf>) {
    match fs::read_dir(path) {
        Ok(entries) => entries
            .flatten()
            .for_each(|entry| list(&entry.path(), files)),
        Err(_) => files.push(path.to_owned()),
    }
}
