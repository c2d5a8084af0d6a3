//! Pictures that the scene's materials name: each file is read once a use; one that cannot be read is a warning.

use std::path::Path;

use super::{RawProblem, Resolver, nearest_file};
use crate::import::import_texture;
use crate::scene::schema::{MaterialFile, TextureFile};
use crate::world::{ColorSpace, Wrap};

/// What makes two uses of a picture the same texture.
pub type TextureKey = (String, ColorSpace, Wrap);

/// The key of a picture.
pub fn texture_key(file: &TextureFile, space: ColorSpace) -> TextureKey {
    (file.path.value.clone(), space, file.wrap)
}

/// The pictures of a material, and what their numbers mean.
pub fn pictures(material: &MaterialFile) -> [(Option<&TextureFile>, ColorSpace); 2] {
    [
        (material.color_map.as_ref(), ColorSpace::Srgb),
        (material.normal_map.as_ref(), ColorSpace::Linear),
    ]
}

impl Resolver {
    /// Reads the pictures of a material that are not there yet.
    pub(super) fn open_textures(&mut self, material: &MaterialFile, folder: &Path) {
        for (file, space) in pictures(material) {
            let Some(file) = file else {
                continue;
            };
            let key = texture_key(file, space);
            if self.textures.contains_key(&key) {
                continue;
            }
            let path = folder.join(&file.path.value);
            let read = import_texture(&path, space, file.wrap);
            if let Err(why) = &read {
                self.warnings.push(RawProblem {
                    place: file.path.place.clone(),
                    what: format!("the picture `{}` is left out: {why}", file.path.value),
                    expected: Some("a PNG, JPEG, BMP or TGA file".into()),
                    suggestion: nearest_file(&path).filter(|_| !path.is_file()),
                });
            }
            let texture = read.ok().map(|mut texture| {
                texture.path.clone_from(&file.path.value);
                texture
            });
            self.textures.insert(key, texture);
        }
    }
}
