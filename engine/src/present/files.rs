//! Pictures to files: 8-bit sRGB PNG for people, 16-bit linear PNG and f32 EXR for measuring.
//!
//! A file appears under its name only when it is whole: it is written beside it and renamed, so a run
//! that was interrupted never leaves half a picture that a resumed run would take for a done one.

use std::ffi::OsString;
use std::fmt;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use exr::prelude::{Encoding, Image, SpecificChannels, WritableImage};
use exr::prelude::{Layer, LayerAttributes};
use glam::{UVec2, Vec3};

use super::Developed;
use crate::trace::Picture;
use crate::world::{ToneMap, linear_from_srgb};

/// Why a picture did not become a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileError {
    /// The file that should have come to be.
    pub path: PathBuf,
    /// What went wrong.
    pub why: String,
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}: cannot write the picture: {}",
            self.path.display(),
            self.why
        )
    }
}

impl std::error::Error for FileError {}

/// Writes what a display would show: exposure (stops), tone curve, sRGB, 8 bit.
///
/// # Errors
/// Names the path; the folder is made if it is missing.
pub fn write_png8(
    path: &Path,
    picture: &Picture,
    exposure: f32,
    tone: ToneMap,
) -> Result<(), FileError> {
    write_developed(path, &Developed::new(picture, exposure, tone))
}

/// Writes what a display would show: sRGB, 8 bit.
///
/// # Errors
/// Names the path; the folder is made if it is missing.
pub fn write_developed(path: &Path, picture: &Developed) -> Result<(), FileError> {
    whole_file(path, |file| {
        let mut encoder = encoder(file, picture.size, png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encode(encoder, picture.pixels.as_flattened())
    })
}

/// Reads a PNG of sRGB values, 8 bit a channel, as linear light.
///
/// # Errors
/// A sentence that names the path: it cannot be read, or is a PNG of another kind.
pub fn read_png8(path: &Path) -> Result<Picture, String> {
    let told = |why: String| format!("{}: cannot read the picture: {why}", path.display());
    let file = File::open(path).map_err(|error| told(error.to_string()))?;
    let mut decoder = png::Decoder::new(std::io::BufReader::new(file));
    // Palettes and few bits become whole bytes.
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder
        .read_info()
        .map_err(|error| told(error.to_string()))?;
    let bytes = reader.output_buffer_size();
    let mut buffer = vec![0; bytes.ok_or_else(|| told("it is too large".into()))?];
    let info = reader
        .next_frame(&mut buffer)
        .map_err(|error| told(error.to_string()))?;
    let linear = |byte: u8| linear_from_srgb(f32::from(byte) / 255.0);
    let pixel = |bytes: &[u8]| match *bytes {
        [r, g, b, ..] => Vec3::new(linear(r), linear(g), linear(b)),
        [grey, ..] => Vec3::splat(linear(grey)),
        [] => Vec3::ZERO,
    };
    let samples = info.color_type.samples();
    Ok(Picture {
        size: UVec2::new(info.width, info.height),
        pixels: buffer[..info.buffer_size()]
            .chunks(samples)
            .map(pixel)
            .collect(),
    })
}

/// Writes linear light clipped to [0, 1], 16 bit, rounded to nearest, marked gAMA 1.0.
///
/// # Errors
/// Names the path; the folder is made if it is missing.
pub fn write_png16_linear(path: &Path, picture: &Picture) -> Result<(), FileError> {
    let bytes: Vec<u8> = picture
        .pixels
        .iter()
        .flat_map(|pixel| pixel.to_array())
        .flat_map(|channel| linear16(channel).to_be_bytes())
        .collect();
    whole_file(path, |file| {
        let mut encoder = encoder(file, picture.size, png::BitDepth::Sixteen);
        encoder.set_source_gamma(png::ScaledFloat::new(1.0));
        encode(encoder, &bytes)
    })
}

/// Writes linear light as it is: OpenEXR, f32 channels R, G, B, lossless.
///
/// # Errors
/// Names the path; the folder is made if it is missing.
pub fn write_exr(path: &Path, picture: &Picture) -> Result<(), FileError> {
    let (width, height) = (picture.size.x as usize, picture.size.y as usize);
    let channels = SpecificChannels::rgb(|at: exr::math::Vec2<usize>| {
        let pixel = picture.pixels[at.y() * width + at.x()];
        (pixel.x, pixel.y, pixel.z)
    });
    let layer = Layer::new(
        (width, height),
        LayerAttributes::named("linear"),
        Encoding::SMALL_LOSSLESS,
        channels,
    );
    whole_file(path, |file| {
        Image::from_layer(layer)
            .write()
            .to_buffered(BufWriter::new(file))
            .map_err(|error| error.to_string())
    })
}

/// A channel as a 16-bit number; NaN is 0.
fn linear16(channel: f32) -> u16 {
    (f64::from(channel).clamp(0.0, 1.0) * 65535.0).round() as u16
}

fn encoder<'a>(file: File, size: UVec2, depth: png::BitDepth) -> png::Encoder<'a, BufWriter<File>> {
    let mut encoder = png::Encoder::new(BufWriter::new(file), size.x, size.y);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(depth);
    encoder
}

fn encode(encoder: png::Encoder<BufWriter<File>>, bytes: &[u8]) -> Result<(), String> {
    let text = |error: png::EncodingError| error.to_string();
    let mut writer = encoder.write_header().map_err(text)?;
    writer.write_image_data(bytes).map_err(text)?;
    writer.finish().map_err(text)
}

/// Makes `path` out of what `write` puts into a fresh file beside it.
fn whole_file(
    path: &Path,
    write: impl FnOnce(File) -> Result<(), String>,
) -> Result<(), FileError> {
    let error = |why: String| FileError {
        path: path.to_path_buf(),
        why,
    };
    if let Some(folder) = path.parent().filter(|f| !f.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder)
            .map_err(|e| error(format!("the folder {}: {e}", folder.display())))?;
    }
    let mut part = OsString::from(path);
    part.push(".part");
    let part = PathBuf::from(part);
    let file = File::create(&part).map_err(|e| error(e.to_string()))?;
    let written =
        write(file).and_then(|()| std::fs::rename(&part, path).map_err(|e| e.to_string()));
    written.map_err(|why| {
        // The half-written file is of no use; that it cannot be removed adds nothing to `why`.
        let _ = std::fs::remove_file(&part);
        error(why)
    })
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::present::display_rgb8;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("orrery-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        folder
    }

    fn ramp() -> Picture {
        let mut picture = Picture::new(UVec2::new(5, 3));
        for (i, pixel) in picture.pixels.iter_mut().enumerate() {
            *pixel = Vec3::new(i as f32 * 0.1, 0.5 - i as f32 * 0.05, i as f32 / 65535.0);
        }
        picture
    }

    #[test]
    fn png16_holds_linear_light_rounded_to_nearest_and_says_so() {
        let folder = folder("png16");
        let path = folder.join("deep/ramp.png");
        let picture = ramp();
        write_png16_linear(&path, &picture).unwrap();
        let mut reader = png::Decoder::new(std::io::BufReader::new(File::open(&path).unwrap()))
            .read_info()
            .unwrap();
        assert_eq!(
            reader.info().gama_chunk.map(|g| g.into_scaled()),
            Some(100_000)
        );
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut bytes).unwrap();
        for (i, pixel) in picture.pixels.iter().enumerate() {
            for c in 0..3 {
                let stored = u16::from_be_bytes([bytes[i * 6 + c * 2], bytes[i * 6 + c * 2 + 1]]);
                let expected = (f64::from(pixel[c]).clamp(0.0, 1.0) * 65535.0).round() as u16;
                assert_eq!(stored, expected, "pixel {i} channel {c}");
            }
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn png8_holds_what_a_display_shows() {
        let folder = folder("png8");
        let path = folder.join("ramp.png");
        let picture = ramp();
        write_png8(&path, &picture, 1.0, ToneMap::Filmic).unwrap();
        let read = read_png8(&path).unwrap();
        assert_eq!(read.size, picture.size);
        let image = image::open(&path).unwrap().to_rgb8();
        for (i, pixel) in image.pixels().enumerate() {
            let light = pixel
                .0
                .map(|byte| linear_from_srgb(f32::from(byte) / 255.0));
            assert_eq!(read.pixels[i], Vec3::from(light), "pixel {i}");
            assert_eq!(
                pixel.0,
                display_rgb8(picture.pixels[i], 1.0, ToneMap::Filmic),
                "pixel {i}"
            );
        }
        assert_eq!(
            std::fs::read_dir(&folder).unwrap().count(),
            1,
            "something was left beside it"
        );
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn exr_keeps_every_bit() {
        let folder = folder("exr");
        let path = folder.join("ramp.exr");
        let mut picture = ramp();
        picture.pixels[0] = Vec3::new(-3.5, 1.0e20, f32::INFINITY);
        write_exr(&path, &picture).unwrap();
        let image = exr::prelude::read_first_rgba_layer_from_file(
            &path,
            |size, _| Picture::new(UVec2::new(size.width() as u32, size.height() as u32)),
            |picture, at, (r, g, b, _): (f32, f32, f32, f32)| {
                let width = picture.size.x as usize;
                picture.pixels[at.y() * width + at.x()] = Vec3::new(r, g, b);
            },
        )
        .unwrap();
        assert_eq!(image.layer_data.channel_data.pixels, picture);
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn an_error_names_the_path() {
        let folder = folder("error");
        std::fs::create_dir_all(folder.join("taken.png")).unwrap();
        let error = write_png8(&folder.join("taken.png"), &ramp(), 0.0, ToneMap::Clip).unwrap_err();
        assert!(error.to_string().contains("taken.png"), "{error}");
        assert_eq!(
            std::fs::read_dir(&folder).unwrap().count(),
            1,
            "half a file was left"
        );
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
