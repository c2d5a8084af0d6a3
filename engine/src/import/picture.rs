//! Picture files to textures, for importers and the scene file: PNG, JPEG, BMP, TGA, and skies as Radiance HDR and OpenEXR by the `image` crate.
//!
//! A file's own numbers are not believed: sizes are checked against its bytes before anything is allocated, and a decoder
//! that gives up ends nothing.

use std::collections::HashMap;
use std::fmt;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use glam::Vec3;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::{Files, Warnings, bytes_of, caught};
use crate::world::{ColorSpace, Texture, TextureId, Wrap, linear_light};

/// Most texels of a picture: 8192 along both edges.
const MOST_TEXELS: u64 = 1 << 26;
/// Bytes of memory that a byte of a file may ask for, twice what any of the formats can press into one.
const MOST_GROWTH: u64 = 2048;

/// Reads a picture file.
///
/// # Errors
/// A sentence without the file's name: it cannot be read, is none of the formats, is broken or too large.
pub fn import_texture(path: &Path, space: ColorSpace, wrap: Wrap) -> Result<Texture, String> {
    texture_of(path, &bytes_of(path)?, space, wrap)
}

fn texture_of(path: &Path, bytes: &[u8], space: ColorSpace, wrap: Wrap) -> Result<Texture, String> {
    let ending = path.extension().and_then(|ending| ending.to_str());
    let mut texture = decode_texture(bytes, ending, space, wrap)?;
    texture.name = path
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    Ok(texture)
}

/// Reads a picture from the bytes of a file; the ending of its name tells what the bytes do not (TGA).
///
/// # Errors
/// See [`import_texture`].
pub fn decode_texture(
    bytes: &[u8],
    ending: Option<&str>,
    space: ColorSpace,
    wrap: Wrap,
) -> Result<Texture, String> {
    let picture = caught("pictures", || decode(bytes, ending))?.into_rgba8();
    let size = [picture.width(), picture.height()];
    Texture::new("picture", size, picture.as_raw(), space, wrap)
}

fn decode(bytes: &[u8], ending: Option<&str>) -> Result<DynamicImage, String> {
    let broken = |error: image::ImageError| format!("it is not a picture: {error}");
    let mut reader = ImageReader::new(Cursor::new(bytes));
    let by_content = image::guess_format(bytes).ok();
    let by_name = || ImageFormat::from_extension(ending?);
    match by_content.or_else(by_name) {
        Some(format) => reader.set_format(format),
        None => return Err("it is no PNG, JPEG, BMP or TGA".into()),
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(Texture::LARGEST);
    limits.max_image_height = Some(Texture::LARGEST);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(broken)?;
    let (width, height) = decoder.dimensions();
    let texels = u64::from(width) * u64::from(height);
    if texels > MOST_TEXELS {
        return Err(format!("its {width} x {height} texels are too many"));
    }
    let grown = decoder.total_bytes();
    if grown > MOST_GROWTH * (bytes.len() as u64 + 1) {
        let held = bytes.len();
        return Err(format!(
            "it says that it has {width} x {height} texels, which cannot be in {held} bytes"
        ));
    }
    DynamicImage::from_decoder(decoder).map_err(broken)
}

/// Reads a panorama for a sky: Radiance HDR, OpenEXR, or any picture of sRGB colours.
///
/// # Errors
/// See [`import_texture`].
pub fn import_sky(path: &Path) -> Result<Texture, String> {
    let ending = path.extension().and_then(|ending| ending.to_str());
    decode_sky(&bytes_of(path)?, ending)
}

/// [`import_sky`] for the bytes of a file; the ending of its name tells what the bytes do not.
///
/// # Errors
/// See [`import_texture`].
pub fn decode_sky(bytes: &[u8], ending: Option<&str>) -> Result<Texture, String> {
    let picture = caught("pictures", || decode(bytes, ending))?;
    let is_linear = matches!(
        picture,
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_)
    );
    let picture = picture.into_rgb32f();
    let size = [picture.width(), picture.height()];
    let (texels, _) = picture.as_raw().as_chunks::<3>();
    let light = |&texel: &[f32; 3]| {
        if is_linear {
            Vec3::from(texel)
        } else {
            Vec3::from(texel.map(|x| linear_light(x.into()) as f32))
        }
    };
    let texels: Vec<Vec3> = texels.iter().map(light).collect();
    Texture::radiance("sky", size, &texels)
}

/// How a picture is made of others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Recipe {
    /// The colours of one, or white, with the brightness of the other as alpha.
    CutOut(Option<TextureId>, TextureId),
    /// A map of normals so many times as steep; the bits of an f64.
    Steeper(TextureId, u64),
    /// The map of normals of a map of heights, so many times as high.
    Heights(TextureId, u64),
}

impl fmt::Display for Recipe {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::CutOut(..) => "picture that is cut out",
            Self::Steeper(..) => "normal map with its own steepness",
            Self::Heights(..) => "map of heights",
        })
    }
}

/// Texels along an edge of the hatch, and of a stripe along it.
const HATCH: [u32; 2] = [64, 16];

/// Stripes of orange and grey: what is drawn in place of a picture or a material that cannot be read.
pub fn hatch(wrap: Wrap) -> Texture {
    let [edge, stripe] = HATCH;
    let rgba: Vec<u8> = (0..edge * edge)
        .flat_map(|i| match (i % edge + i / edge) / stripe % 2 {
            0 => [214, 122, 40, 255],
            _ => [96, 98, 102, 255],
        })
        .collect();
    // Its size is one that textures have.
    Texture::new("hatch", [edge; 2], &rgba, ColorSpace::Srgb, wrap).unwrap_or_default()
}

/// Texels of all pictures of a model together: as many as four of the largest have.
const MOST_TEXELS_OF_ALL: u64 = 4 * MOST_TEXELS;
/// What is said of pictures beyond these.
const TOO_MANY: &str = "its pictures come to too many texels";

/// The textures of a model under way: each picture once a use, missing ones told once.
///
/// A picture of colours that is there but cannot be read is hatched, so that one sees where it should be; one that is not there
/// is left out, as are pictures of other things.
pub struct Pictures<'a> {
    files: &'a Files,
    rows: HashMap<(String, ColorSpace, Wrap), Option<TextureId>>,
    /// Pictures that were made of others, by what they were made of and how.
    made: HashMap<Recipe, Option<TextureId>>,
    /// Texels that may still be read or made.
    room: u64,
    /// Rows of [`super::Model::textures`].
    pub textures: Vec<Texture>,
}

impl<'a> Pictures<'a> {
    /// None yet; files are looked for from their folder.
    pub fn new(files: &'a Files) -> Self {
        Self {
            files,
            rows: HashMap::new(),
            made: HashMap::new(),
            room: MOST_TEXELS_OF_ALL,
            textures: Vec::new(),
        }
    }

    /// The texture of a file, by its name in the model; none, and a warning, where there is no such picture.
    pub fn file(
        &mut self,
        name: &str,
        (space, wrap): (ColorSpace, Wrap),
        warnings: &mut Warnings,
    ) -> Option<TextureId> {
        let path = self.find(name);
        let files = self.files;
        let read = || texture_of(&path, &files.bytes(&path)?, space, wrap);
        self.row((name, space, wrap), files.is_there(&path), warnings, read)
    }

    /// The texture of a picture within the model; `name` tells it from others.
    pub fn bytes(
        &mut self,
        (name, bytes, ending): (&str, &[u8], Option<&str>),
        (space, wrap): (ColorSpace, Wrap),
        warnings: &mut Warnings,
    ) -> Option<TextureId> {
        let read = || decode_texture(bytes, ending, space, wrap);
        self.row((name, space, wrap), true, warnings, read)
    }

    fn row(
        &mut self,
        (name, space, wrap): (&str, ColorSpace, Wrap),
        is_there: bool,
        warnings: &mut Warnings,
        read: impl FnOnce() -> Result<Texture, String>,
    ) -> Option<TextureId> {
        let key = (name.to_owned(), space, wrap);
        if let Some(&row) = self.rows.get(&key) {
            return row;
        }
        let read = match self.room {
            0 => Err(TOO_MANY.into()),
            _ => read(),
        };
        let texture = match read {
            Ok(texture) => Some(texture),
            Err(why) => {
                let is_hatched = is_there && space == ColorSpace::Srgb;
                let instead = match is_hatched {
                    true => "hatched",
                    false => "left out, its colour is plain",
                };
                warnings.push(format!("the texture `{name}` is {instead}: {why}"));
                is_hatched.then(|| hatch(wrap))
            }
        };
        let row = texture.map(|texture| self.add(texture));
        self.rows.insert(key, row);
        row
    }

    /// Adds a texture, which takes of the room for all.
    fn add(&mut self, texture: Texture) -> TextureId {
        let texels = texture.levels.first().map_or(0, |level| level.texels.len());
        self.room = self.room.saturating_sub(texels as u64);
        self.textures.push(texture);
        TextureId(self.textures.len() as u32 - 1)
    }

    /// The texture that a recipe makes of those that are there, once; none, and a warning, where it makes none or there is
    /// no room for it.
    pub fn made(
        &mut self,
        recipe: Recipe,
        make: impl FnOnce(&[Texture]) -> Result<Texture, String>,
        warnings: &mut Warnings,
    ) -> Option<TextureId> {
        if let Some(&row) = self.made.get(&recipe) {
            return row;
        }
        let made = match self.room {
            0 => Err(format!("a {recipe} is left out: {TOO_MANY}")),
            _ => make(&self.textures),
        };
        let row = match made {
            Ok(texture) => Some(self.add(texture)),
            Err(why) => {
                warnings.push(why);
                None
            }
        };
        self.made.insert(recipe, row);
        row
    }

    /// The normal map so many times as steep: that itself where it is 1.
    pub fn steeper(
        &mut self,
        map: TextureId,
        times: f64,
        warnings: &mut Warnings,
    ) -> Option<TextureId> {
        let is_alike = times == 1.0 || !times.is_finite();
        if is_alike || map.0 as usize >= self.textures.len() {
            return Some(map);
        }
        let steeper = |textures: &[Texture]| Ok(textures[map.0 as usize].steeper(times));
        self.made(Recipe::Steeper(map, times.to_bits()), steeper, warnings)
    }

    /// Where a file is: as it is named, or beside the model under the last part of its name. Names come from other
    /// machines, with their folders and their slashes.
    fn find(&self, name: &str) -> PathBuf {
        let name = name.replace('\\', "/");
        let last = name.rsplit('/').next().unwrap_or(&name);
        let places =
            [&name, last, &format!("textures/{last}")].map(|name| self.files.folder().join(name));
        let found = places.iter().find(|place| self.files.is_there(place));
        found.unwrap_or(&places[0]).clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(bytes: &[u8], ending: Option<&str>) -> Result<Texture, String> {
        decode_texture(bytes, ending, ColorSpace::Linear, Wrap::Repeat)
    }

    /// A BMP of 24 bits, 2 x 1: red, green. Its rows are padded to four bytes.
    fn bmp(width: u32, height: u32) -> Vec<u8> {
        let mut bytes = b"BM".to_vec();
        bytes.extend(
            [62_u32, 0, 54, 40, width, height]
                .map(u32::to_le_bytes)
                .concat(),
        );
        bytes.extend([1, 0, 24, 0]);
        bytes.extend([0_u8; 24]);
        bytes.extend([0, 0, 255, 0, 255, 0, 0, 0]);
        bytes
    }

    #[test]
    fn pictures_are_read_by_content_or_by_name() {
        let texture = decoded(&bmp(2, 1), None).expect("a picture");
        let red_green = [[65_535, 0, 0, 65_535], [0, 65_535, 0, 65_535]];
        assert_eq!(texture.levels[0].texels, red_green);
        // Uncompressed true colour, 1 x 1, blue first.
        let tga = [
            0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 24, 0, 255, 0, 0,
        ];
        assert!(decoded(&tga, None).is_err());
        let texture = decoded(&tga, Some("tga")).expect("a picture");
        assert_eq!(texture.levels[0].texels, [[0, 0, 65_535, 65_535]]);
    }

    #[test]
    fn skies_of_openexr_keep_their_light() {
        let mut picture = image::Rgb32FImage::new(2, 1);
        picture.put_pixel(0, 0, image::Rgb([8.0, 0.5, 0.0]));
        let mut bytes = Cursor::new(Vec::new());
        let picture = DynamicImage::ImageRgb32F(picture);
        picture
            .write_to(&mut bytes, ImageFormat::OpenExr)
            .expect("an EXR file");
        let bytes = bytes.into_inner();
        let sky = decode_sky(&bytes, None);
        let broken = decode_sky(&bytes[..bytes.len() / 2], None);
        assert_eq!(sky.expect("a sky").brightest, 8.0);
        assert!(broken.is_err());
    }

    #[test]
    fn a_small_file_that_says_it_is_large_is_refused() {
        let why = decoded(&bmp(16_000, 100), None).expect_err("too large for its bytes");
        assert!(why.contains("16000 x 100"), "{why}");
        for cut in 0..bmp(2, 1).len() - 1 {
            // Whatever comes of it, it comes back.
            let _ = decoded(&bmp(2, 1)[..cut], None);
        }
        assert!(decoded(&[], Some("png")).is_err());
    }

    #[test]
    fn pictures_made_of_others_take_of_the_room_for_all() {
        let files = Files::of_folder(Path::new("no such folder"));
        let mut pictures = Pictures::new(&files);
        let mut warnings = Warnings::default();
        let bytes = bmp(2, 1);
        let picture = ("flat", bytes.as_slice(), None);
        let map = pictures.bytes(picture, (ColorSpace::Linear, Wrap::Clamp), &mut warnings);
        let map = map.expect("a picture");
        pictures.room = 2;
        let steep = [2.0, 3.0, 2.0, 3.0, 1.0];
        let rows = steep.map(|times| pictures.steeper(map, times, &mut warnings));
        let made = Some(TextureId(1));
        assert_eq!(rows, [made, None, made, None, Some(map)]);
        assert_eq!((pictures.room, pictures.textures.len()), (0, 2));
        let told = warnings.sentences();
        assert!(told.len() == 1 && told[0].ends_with(TOO_MANY), "{told:?}");
    }

    #[test]
    fn pictures_of_colours_that_are_broken_are_hatched() {
        let files = Files::of_folder(Path::new("no such folder"));
        let mut pictures = Pictures::new(&files);
        let mut warnings = Warnings::default();
        let broken = ("images[0]", &b"no picture"[..], None);
        let row = pictures.bytes(broken, (ColorSpace::Srgb, Wrap::Clamp), &mut warnings);
        let hatched = &pictures.textures[row.expect("a hatch").0 as usize];
        let stripes = &hatched.levels[0].texels;
        assert!(stripes[0] != stripes[16] && stripes[0] == stripes[32]);
        let normals = pictures.bytes(broken, (ColorSpace::Linear, Wrap::Clamp), &mut warnings);
        let missing = pictures.file("gone.png", (ColorSpace::Srgb, Wrap::Clamp), &mut warnings);
        assert_eq!((normals, missing, pictures.textures.len()), (None, None, 1));
        let told = warnings.sentences();
        assert!(
            told[0].starts_with("the texture `images[0]` is hatched: "),
            "{told:?}"
        );
    }
}
