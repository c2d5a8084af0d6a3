//! Pictures that the scene's background and materials name: each file is read once a use; one that cannot be read is a warning.

use std::path::Path;

use super::{RawProblem, Resolver, nearest_file};
use crate::import::{import_sky, import_texture};
use crate::scene::schema::{At, BackgroundFile, MaterialFile, TextureFile};
use crate::world::{ColorSpace, Texture, Wrap};

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
            let texture = self.picture((&file.path, &path), "a PNG, JPEG, BMP or TGA file", read);
            self.textures.insert(key, texture);
        }
    }

    /// Reads the background's panorama.
    pub(super) fn open_sky(&mut self, file: &BackgroundFile, folder: &Path) -> Option<Texture> {
        let name = file.picture.as_ref()?;
        let path = folder.join(&name.value);
        self.picture(
            (name, &path),
            "a HDR, EXR, PNG, JPEG, BMP or TGA file",
            import_sky(&path),
        )
    }

    /// A picture that was read, under the scene file's name for it; else a warning.
    fn picture(
        &mut self,
        (name, path): (&At<String>, &Path),
        expected: &str,
        read: Result<Texture, String>,
    ) -> Option<Texture> {
        match read {
            Ok(mut texture) => {
                texture.path.clone_from(&name.value);
                Some(texture)
            }
            Err(why) => {
                let suggestion = match !path.is_file() && self.may_compare() {
                    true => nearest_file(path),
                    false => None,
                };
                self.warnings.push(RawProblem {
                    place: name.place.clone(),
                    what: format!("the picture `{}` is left out: {why}", name.value),
                    expected: Some(expected.into()),
                    suggestion,
                });
                None
            }
        }
    }
}
