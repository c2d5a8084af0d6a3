//! glTF 2.0 (Khronos 2021), as `.gltf` with its buffers beside or inside it, and as `.glb`.
//!
//! The `gltf` crate reads the JSON and holds it against the schema; bytes are read here, so that no count is believed
//! before the bytes behind it were seen. The scene is the file's default one, else the first, else all nodes without
//! a parent. Units, axes (+Y up) and the directions of cameras and lights are those of this engine.
//!
//! What cannot be shown is left out with a warning: points and lines, pictures that are missing, and whatever its bytes are
//! missing of, part by part; a file is refused where nothing of it is left to see. Draco and other compressed buffers
//! are refused when the file requires them.

mod accessor;
mod clip;
mod file;
mod light;
mod looks;
mod material;
mod node;
mod picture;
mod primitive;
mod skin;
#[cfg(test)]
mod tests;

use std::path::Path;

use file::File;
use material::Materials;
use primitive::Parts;

use super::{Content, Files, Model};

/// Reads a file and the buffers it names, which lie in its folder.
///
/// # Errors
/// A sentence without the file's name that says what is wrong, and in which part of the JSON.
pub fn import(path: &Path, files: &Files) -> Result<Model, String> {
    read(&files.bytes(path)?, files)
}

/// `import` for bytes; `folder` is where its buffers are.
///
/// # Errors
/// See `import`.
pub fn read_gltf(bytes: &[u8], folder: &Path) -> Result<Model, String> {
    read(bytes, &Files::of_folder(folder))
}

fn read(bytes: &[u8], files: &Files) -> Result<Model, String> {
    let file = File::open(bytes, files)?;
    let mut model = Model::default();
    let materials = Materials::read(&file, files, &mut model);
    let rows = node::read_nodes(&file, &mut model);
    skin::read_skins(&file, &rows, &mut model);
    let mut parts = Parts::new(&file, &materials);
    node::fill_nodes(&file, &rows, &mut parts, &mut model);
    clip::read_clips(&file, &rows, &mut model);
    match parts.broken {
        Some(why) if !model.contents().any(Content::is_visible) => Err(why),
        _ => Ok(model),
    }
}
