//! Finding scene files: as named, else among the scenes that come along; else the nearest name is told.

use std::path::{Path, PathBuf};

use orrery_engine::scene::edit_distance;

use crate::failure::Failure;
use crate::output::note;

/// The demo, inside the folder of scenes.
pub const DEMO: &str = "demo";
const SCENES: &str = "assets/scenes";

/// The file that `named` means: the path itself, else a scene of that name in `assets/scenes`.
pub fn find_scene(named: &Path) -> Result<PathBuf, Failure> {
    if named.is_file() {
        return Ok(named.to_path_buf());
    }
    if named.is_dir() {
        return Err(Failure::Input(format!(
            "{} is a folder; expected a scene file",
            named.display()
        )));
    }
    let scenes = scenes_folder();
    let is_bare = named.components().count() == 1;
    if let Some(scenes) = scenes.as_deref().filter(|_| is_bare) {
        let ending = [named.to_path_buf(), named.with_added_extension("ron")];
        if let Some(found) = ending.iter().map(|n| scenes.join(n)).find(|p| p.is_file()) {
            return Ok(found);
        }
    }
    Err(Failure::Input(missing(named, scenes.as_deref())))
}

/// Whether a file that does not come along is there; where not, a note says what is skipped for it.
pub fn is_there(name: &str, file: &Path) -> bool {
    let there = file.is_file();
    if !there {
        note(format_args!(
            "skipped {name}: there is no {}",
            file.display()
        ));
    }
    there
}

/// What to say of a file that is not there.
fn missing(named: &Path, scenes: Option<&Path>) -> String {
    let here = std::env::current_dir().map_or("?".into(), |folder| folder.display().to_string());
    let mut sentence = format!("no scene file `{}` (looked in {here}", named.display());
    match scenes {
        Some(scenes) => sentence += &format!(" and {})", scenes.display()),
        None => {
            sentence +=
                &format!("; the folder {SCENES} was found neither above it nor above the program)");
        }
    }
    if let Some(near) = nearest(named, scenes) {
        sentence += &format!("; did you mean `{}`?", near.display());
    }
    sentence
}

/// The folder of scenes that come along: above the current folder, else above the program.
fn scenes_folder() -> Option<PathBuf> {
    let here = std::env::current_dir().ok();
    let program = std::env::current_exe().ok();
    [here, program].into_iter().flatten().find_map(|start| {
        start
            .ancestors()
            .map(|folder| folder.join(SCENES))
            .find(|folder| folder.is_dir())
    })
}

/// The scene file whose name is nearest to `named`, in its own folder or among those that come along.
fn nearest(named: &Path, scenes: Option<&Path>) -> Option<PathBuf> {
    let own = match named.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_path_buf(),
        _ => PathBuf::from("."),
    };
    let wanted = named.file_stem()?.to_str()?.to_lowercase();
    let distance = |path: &Path| {
        let stem = path.file_stem()?.to_str()?.to_lowercase();
        Some(edit_distance(&wanted, &stem))
    };
    let folders = [Some(own.as_path()), scenes];
    let mut files: Vec<(usize, PathBuf)> = folders
        .into_iter()
        .flatten()
        .filter_map(|folder| std::fs::read_dir(folder).ok())
        .flat_map(|entries| entries.flatten().map(|entry| entry.path()))
        .filter(|path| path.extension().is_some_and(|e| e == "ron"))
        .filter_map(|path| Some((distance(&path)?, path)))
        .collect();
    files.sort();
    // Further than half its letters it is another word, not a misspelling.
    let near = files.into_iter().next()?;
    (near.0 <= wanted.chars().count().div_ceil(2)).then(|| clean(&near.1))
}

/// Without a leading `./`.
fn clean(path: &Path) -> PathBuf {
    path.strip_prefix(".").unwrap_or(path).to_path_buf()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_file_is_named_with_where_it_was_looked_for() {
        let failure = find_scene(Path::new("no/such/scene.ron")).unwrap_err();
        let text = failure.to_string();
        assert_eq!(failure.exit_code(), 1);
        assert!(
            text.contains("no/such/scene.ron") && text.contains("looked in"),
            "{text}"
        );
    }
}
