//! A scene that moves to another folder: the files it names are where they were, so their paths are said anew.

use std::path::{Component, Path, PathBuf};

use super::schema::{Entity, Scene, Shape};

impl Scene {
    /// Says the paths that are relative to one folder relative to another one.
    pub fn rebase(&mut self, from: &Path, to: &Path) {
        let (from, to) = (whole(from), whole(to));
        let mut said = |path: &mut String| *path = moved(path, &from, &to);
        if let Some(picture) = &mut self.background.picture {
            said(&mut picture.value);
        }
        for (_, material) in &mut self.materials {
            let maps = [&mut material.color_map, &mut material.normal_map];
            for map in maps.into_iter().flatten() {
                said(&mut map.path.value);
            }
        }
        self.entities.iter_mut().for_each(|e| rebase(e, &mut said));
    }
}

fn rebase(entity: &mut Entity, said: &mut impl FnMut(&mut String)) {
    if let Some(Shape::Mesh(mesh)) = &mut entity.shape {
        said(&mut mesh.path.value);
    }
    if let Some(keys) = &mut entity.deform.keys {
        keys.poses.iter_mut().for_each(|pose| said(&mut pose.value));
    }
    if let Some(morph) = &mut entity.deform.morph {
        morph
            .targets
            .iter_mut()
            .for_each(|target| said(&mut target.value));
    }
    entity
        .children
        .iter_mut()
        .for_each(|child| rebase(child, said));
}

/// A file's path as a scene file in a folder has it.
pub fn path_from(folder: &Path, file: &Path) -> String {
    said_from(&whole(folder), &whole(file))
}

/// From the root on, without steps up.
fn whole(path: &Path) -> PathBuf {
    let path = if path.as_os_str().is_empty() {
        Path::new(".")
    } else {
        path
    };
    // The folder need not be one that can be asked for.
    plain(&std::path::absolute(path).unwrap_or_else(|_| path.to_owned()))
}

fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if plain.file_name().is_some() => {
                plain.pop();
            }
            part => plain.push(part),
        }
    }
    plain
}

fn moved(path: &str, from: &Path, to: &Path) -> String {
    if Path::new(path).is_absolute() || path.is_empty() {
        return path.to_owned();
    }
    said_from(to, &plain(&from.join(path)))
}

/// One whole path from another.
fn said_from(to: &Path, target: &Path) -> String {
    let shared = target
        .components()
        .zip(to.components())
        .take_while(|(a, b)| a == b)
        .count();
    if shared == 0 {
        return target.to_string_lossy().replace('\\', "/");
    }
    let up = to.components().skip(shared).map(|_| "..".into());
    let down = target.components().skip(shared);
    let down = down.map(|part| part.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<String>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_said_from_the_new_folder() {
        let said = |path, from: &str, to: &str| {
            moved(path, &whole(Path::new(from)), &whole(Path::new(to)))
        };
        assert_eq!(
            said("../models/a.obj", "/s/scenes", "/s/scenes/mine"),
            "../../models/a.obj"
        );
        assert_eq!(said("a.obj", "/s", "/t/u"), "../../s/a.obj");
        assert_eq!(said("b/a.obj", "/s", "/s/b"), "a.obj");
        assert_eq!(said("/x/a.obj", "/s", "/t"), "/x/a.obj");
        let named = path_from(Path::new("/s/scenes"), Path::new("/s/models/a.obj"));
        assert_eq!(named, "../models/a.obj");
    }
}
