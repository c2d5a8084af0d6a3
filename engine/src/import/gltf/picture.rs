//! Textures of materials: pictures in files beside this one, in data URIs and in buffers.

use std::collections::HashSet;

use gltf::texture::WrappingMode;

use super::file::{File, data_of, percent_decoded};
use crate::import::{Files, Pictures, Warnings};
use crate::world::{ColorSpace, Texture, TextureId, Wrap};

/// What a byte of a picture takes off the numbers a file may ask for: of a file's size, four times.
const A_BYTE: usize = 8;

/// The pictures of a file.
pub struct Maps<'a> {
    file: &'a File,
    shown: Pictures<'a>,
    /// Those of which only the mean counts.
    measured: Pictures<'a>,
    /// Those that were taken off what the file may ask for.
    paid: HashSet<Use>,
}

/// A picture by its number, and how it is read.
type Use = (usize, ColorSpace, Wrap);

impl<'a> Maps<'a> {
    /// None is read yet; its pictures are among these files.
    pub fn new(file: &'a File, files: &'a Files) -> Self {
        Self {
            file,
            shown: Pictures::new(files),
            measured: Pictures::new(files),
            paid: HashSet::new(),
        }
    }

    /// Rows of [`crate::import::Model::textures`].
    pub fn into_textures(self) -> Vec<Texture> {
        self.shown.textures
    }

    /// The row of a texture; none, and a warning, where there is no picture.
    pub fn texture(
        &mut self,
        texture: &gltf::Texture,
        space: ColorSpace,
        warnings: &mut Warnings,
    ) -> Option<TextureId> {
        let held = (self.file, &mut self.paid);
        read(held, &mut self.shown, (texture, space), warnings)
    }

    /// The row of a normal map so many times as steep.
    pub fn steeper(
        &mut self,
        map: TextureId,
        times: f32,
        warnings: &mut Warnings,
    ) -> Option<TextureId> {
        self.shown.steeper(map, times.into(), warnings)
    }

    /// The mean of a texture of plain numbers, from 0 to 1.
    pub fn mean(&mut self, texture: &gltf::Texture, warnings: &mut Warnings) -> Option<[f32; 4]> {
        let texture = (texture, ColorSpace::Linear);
        let held = (self.file, &mut self.paid);
        let row = read(held, &mut self.measured, texture, warnings)?;
        let levels = &self.measured.textures.get(row.0 as usize)?.levels;
        let mean = levels.last()?.texels.first()?;
        Some(mean.map(|channel| f32::from(channel) / 65_535.0))
    }
}

fn read(
    (file, paid): (&File, &mut HashSet<Use>),
    pictures: &mut Pictures,
    (texture, space): (&gltf::Texture, ColorSpace),
    warnings: &mut Warnings,
) -> Option<TextureId> {
    let wrap = match texture.sampler().wrap_s() {
        WrappingMode::Repeat => Wrap::Repeat,
        WrappingMode::ClampToEdge => Wrap::Clamp,
        WrappingMode::MirroredRepeat => Wrap::Mirror,
    };
    let number = texture.source().index();
    let name = format!("images[{number}]");
    // The crate's own look at it gives up where a picture in a buffer does not say what it is.
    let image = &file.document.as_json().images[number];
    let mut held = |bytes: Result<&[u8], String>| {
        let bytes = bytes.and_then(|bytes| {
            if paid.insert((number, space, wrap)) {
                file.spend(bytes.len().saturating_mul(A_BYTE))?;
            }
            Ok(bytes)
        });
        match bytes {
            Ok(bytes) => pictures.bytes((&name, bytes, None), (space, wrap), warnings),
            Err(why) => {
                warnings.push(format!("{name}: it is left out: {why}"));
                None
            }
        }
    };
    if let Some(view) = image.buffer_view {
        let view = file.document.views().nth(view.value())?;
        return held(file.view(&view));
    }
    let Some(uri) = &image.uri else {
        return held(Err("it names neither a file nor a buffer".into()));
    };
    match data_of(uri) {
        Some(Ok(bytes)) => held(Ok(&bytes)),
        Some(Err(why)) => held(Err(why)),
        None => pictures.file(&percent_decoded(uri), (space, wrap), warnings),
    }
}
