//! Pictures on surfaces, and the store that owns them.
//!
//! Texels are held as linear light of 16 bits a channel whatever the file had: filtering needs linear light, and tracers
//! read them without decoding. 8 bits of sRGB or of linear numbers come out exact to 1/65535. Each texture carries its
//! smaller levels (Williams, "Pyramidal Parametrics", SIGGRAPH 1983), box-filtered from one to the next.

mod normals;

use std::collections::HashSet;
use std::sync::Arc;

use bevy_ecs::prelude::*;
use bevy_reflect::prelude::*;
use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::Table;

/// Row of [`Textures`]; in a model that is imported, a row of its own textures.
#[derive(
    Reflect, Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize,
)]
#[reflect(Clone, PartialEq)]
pub struct TextureId(pub u32);

/// What the numbers of a picture mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ColorSpace {
    /// Colours as displays take them (IEC 61966-2-1).
    #[default]
    Srgb,
    /// Numbers as they are: normals, shares.
    Linear,
}

/// What is beyond a picture's edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Wrap {
    /// The picture again.
    #[default]
    Repeat,
    /// The texel at the edge.
    Clamp,
    /// The picture again, every other one turned round.
    Mirror,
}

/// One size of a texture.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Level {
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// Linear red, green and blue, and alpha; 65535 is 1. Row by row from the upper left. Of radiance, the last number is an
    /// exponent e in place of alpha: the others are times 2^(e - 127).
    #[serde(with = "crate::pod::array")]
    pub texels: Vec<[u16; 4]>,
}

/// A picture. Texture coordinate (0, 0) is its upper left corner, (1, 1) its lower right one. Immutable.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Texture {
    /// What people call it.
    pub name: String,
    /// Where it came from, as the scene file wrote it; empty where the scene file did not.
    pub path: String,
    /// Beyond its edges.
    pub wrap: Wrap,
    /// From the picture itself down to one texel; none: nothing to show.
    pub levels: Vec<Level>,
    /// The greatest of its numbers; above 1 for radiance alone.
    pub brightest: f32,
}

impl Texture {
    /// Most texels along an edge.
    pub const LARGEST: u32 = 16_384;

    /// A texture of red, green, blue and alpha bytes, row by row from the upper left. Alpha is always linear.
    ///
    /// # Errors
    /// A sentence about a size that is 0 or too large, or a wrong count of bytes.
    pub fn new(
        name: impl Into<String>,
        [width, height]: [u32; 2],
        rgba: &[u8],
        space: ColorSpace,
        wrap: Wrap,
    ) -> Result<Self, String> {
        let sizes = 1..=Self::LARGEST;
        if !sizes.contains(&width) || !sizes.contains(&height) {
            let most = Self::LARGEST;
            return Err(format!(
                "it has {width} x {height} texels, not 1 to {most} along each edge"
            ));
        }
        let (texels, rest) = rgba.as_chunks::<4>();
        if texels.len() as u64 != u64::from(width) * u64::from(height) || !rest.is_empty() {
            let bytes = rgba.len();
            return Err(format!("{bytes} bytes for {width} x {height} texels"));
        }
        let color: Vec<u16> = (0..=255_u8).map(|byte| linear(byte, space)).collect();
        let texel = |&[r, g, b, a]: &[u8; 4]| {
            let [r, g, b] = [r, g, b].map(|byte| color[usize::from(byte)]);
            [r, g, b, linear(a, ColorSpace::Linear)]
        };
        let whole = Level {
            width,
            height,
            texels: texels.iter().map(texel).collect(),
        };
        Ok(Self {
            name: name.into(),
            path: String::new(),
            wrap,
            levels: whole.with_smaller(),
            brightest: 1.0,
        })
    }

    /// A picture of light without a largest value, row by row from the upper left: what a sky is. It has one level. What is no
    /// number is black.
    ///
    /// # Errors
    /// See [`Texture::new`].
    pub fn radiance(
        name: impl Into<String>,
        [width, height]: [u32; 2],
        rgb: &[Vec3],
    ) -> Result<Self, String> {
        let sizes = 1..=Self::LARGEST;
        let count = u64::from(width) * u64::from(height);
        if !sizes.contains(&width) || !sizes.contains(&height) || rgb.len() as u64 != count {
            let found = rgb.len();
            return Err(format!("{found} texels for {width} x {height}"));
        }
        let usable = |x: f32| if x > 0.0 { x.min(BRIGHTEST) } else { 0.0 };
        let usable = |light: &Vec3| Vec3::from(light.to_array().map(usable));
        let brightest = rgb.iter().map(usable).fold(Vec3::ZERO, Vec3::max);
        Ok(Self {
            name: name.into(),
            levels: vec![Level {
                width,
                height,
                texels: rgb
                    .iter()
                    .map(|light| shared_exponent(usable(light)))
                    .collect(),
            }],
            brightest: brightest.max_element(),
            ..Self::default()
        })
    }
}

/// The brightest light that a texture of radiance holds.
const BRIGHTEST: f32 = 1e9;

/// Three numbers of at least 0 with one exponent, 127 for 1.
fn shared_exponent(light: Vec3) -> [u16; 4] {
    let most = f64::from(light.max_element()).max(1e-30);
    // Rounding must not lift the greatest above its share.
    let exponent = (most * 1.000_01).log2().floor() as i32 + 1;
    let share = |x: f32| (f64::from(x) / f64::from(exponent).exp2() * 65_535.0).round() as u16;
    let [r, g, b] = light.to_array().map(share);
    [r, g, b, (exponent + 127) as u16]
}

impl Level {
    /// All levels of a picture, from this one down to one texel.
    fn with_smaller(self) -> Vec<Self> {
        let mut levels = vec![self];
        while let Some(smaller) = levels.last().and_then(Self::halved) {
            levels.push(smaller);
        }
        levels
    }

    /// Half as wide and as high, rounded down but never to nothing: each texel the mean of what it covers. None of one texel.
    fn halved(&self) -> Option<Self> {
        if self.width == 1 && self.height == 1 {
            return None;
        }
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let mut texels = Vec::with_capacity((width * height) as usize);
        for y in 0..height {
            for x in 0..width {
                let mut sum = [0.0; 4];
                for (row, high) in covered(y, height, self.height) {
                    for (column, wide) in covered(x, width, self.width) {
                        let texel = self.texels[(row * self.width + column) as usize];
                        for (sum, channel) in sum.iter_mut().zip(texel) {
                            *sum += f64::from(channel) * high * wide;
                        }
                    }
                }
                texels.push(sum.map(|mean| mean.round() as u16));
            }
        }
        Some(Self {
            width,
            height,
            texels,
        })
    }
}

/// Which of `count` cells the cell `at` of `fewer` covers, each with its share; two or three.
fn covered(at: u32, fewer: u32, count: u32) -> impl Iterator<Item = (u32, f64)> {
    let scale = f64::from(count) / f64::from(fewer);
    let (start, end) = (f64::from(at) * scale, f64::from(at + 1) * scale);
    let last = (end.ceil() as u32).min(count);
    (start.floor() as u32..last).map(move |cell| {
        let (low, high) = (f64::from(cell).max(start), f64::from(cell + 1).min(end));
        (cell, (high - low).max(0.0) / scale)
    })
}

/// A byte as 16 bits of linear light.
fn linear(byte: u8, space: ColorSpace) -> u16 {
    let value = f64::from(byte) / 255.0;
    let value = match space {
        ColorSpace::Linear => value,
        ColorSpace::Srgb => linear_light(value),
    };
    (value * 65_535.0).round() as u16
}

/// The light of a number of sRGB, both from 0 to 1 (IEC 61966-2-1).
pub fn linear_light(srgb: f64) -> f64 {
    if srgb <= 0.04045 {
        srgb / 12.92
    } else {
        ((srgb + 0.055) / 1.055).powf(2.4)
    }
}

/// All textures of the world. Rows are stable; an empty one waits for another texture.
#[derive(Resource, Default, Debug)]
pub struct Textures {
    rows: Table<Arc<Texture>>,
    vacant: Vec<TextureId>,
}

impl Textures {
    /// Adds a texture, in the row of a removed one if there is one.
    pub fn add(&mut self, texture: impl Into<Arc<Texture>>) -> TextureId {
        match self.vacant.pop() {
            Some(id) => {
                self.rows.replace(id.0, texture.into());
                id
            }
            None => TextureId(self.rows.push(texture.into())),
        }
    }

    /// The texture of a row.
    pub fn get(&self, id: TextureId) -> Option<&Arc<Texture>> {
        self.rows.get(id.0 as usize)
    }

    /// Frees all but these.
    pub fn retain(&mut self, used: &HashSet<TextureId>) {
        for row in 0..self.rows.len() as u32 {
            let id = TextureId(row);
            if !used.contains(&id) && !self.vacant.contains(&id) {
                self.rows.replace(row, Arc::default());
                self.vacant.push(id);
            }
        }
    }

    /// All rows in order of id, and what changed.
    pub fn rows(&self) -> &Table<Arc<Texture>> {
        &self.rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(size: [u32; 2], bytes: &[u8], space: ColorSpace) -> Texture {
        let rgba: Vec<u8> = bytes.iter().flat_map(|&b| [b, b, b, 255]).collect();
        Texture::new("grey", size, &rgba, space, Wrap::Repeat).expect("a texture")
    }

    #[test]
    fn bytes_become_linear_light() {
        // Values of IEC 61966-2-1.
        for (byte, light) in [(0, 0.0), (10, 0.003_035), (128, 0.215_861), (255, 1.0)] {
            let texel = grey([1, 1], &[byte], ColorSpace::Srgb).levels[0].texels[0];
            let found = f64::from(texel[0]) / 65_535.0;
            assert!((found - light).abs() < 1e-5, "{byte}: {found}");
            let texel = grey([1, 1], &[byte], ColorSpace::Linear).levels[0].texels[0];
            assert_eq!(texel[0], u16::from(byte) * 257);
            assert_eq!(texel[3], 65_535);
        }
    }

    #[test]
    fn levels_are_means_of_light_whatever_the_size() {
        // A checkerboard of black and white is half the light, not half the sRGB byte.
        let checks: Vec<u8> = (0..16)
            .map(|i| if (i + i / 4) % 2 == 0 { 255 } else { 0 })
            .collect();
        let texture = grey([4, 4], &checks, ColorSpace::Srgb);
        assert_eq!(texture.levels.len(), 3);
        for level in &texture.levels[1..] {
            assert!(level.texels.iter().all(|texel| texel[0] == 32_768));
        }
        // Odd sizes: no texel is lost, whatever level it is in.
        for (width, height) in [(5, 3), (7, 1), (1, 6), (13, 9)] {
            let bytes: Vec<u8> = (0..width * height).map(|i| (i * 37 % 251) as u8).collect();
            let texture = grey([width, height], &bytes, ColorSpace::Linear);
            let mean = bytes.iter().map(|&b| f64::from(b) * 257.0).sum::<f64>();
            let mean = mean / f64::from(width * height);
            let last = texture.levels.last().expect("a level");
            assert_eq!((last.width, last.height), (1, 1));
            assert!((f64::from(last.texels[0][0]) - mean).abs() < 2.0);
        }
    }

    #[test]
    fn radiance_keeps_four_digits_of_any_light() {
        let lights = [1e-3, 0.9999, 1.0, 1.5, 2.0, 65_000.0, 0.0, f32::NAN, -1.0];
        let lights = lights.map(|x| Vec3::new(x, 0.25 * x, 0.0));
        let sky = Texture::radiance("sky", [9, 1], &lights).expect("a sky");
        assert_eq!(sky.brightest, 65_000.0);
        for (texel, light) in sky.levels[0].texels.iter().zip(lights) {
            let scale = (f64::from(texel[3]) - 127.0).exp2() / 65_535.0;
            for (found, expected) in texel.iter().zip(light.to_array()) {
                let found = f64::from(*found) * scale;
                let expected = if light.x > 0.0 {
                    f64::from(expected)
                } else {
                    0.0
                };
                assert!((found - expected).abs() <= 2e-5 * f64::from(light.x.max(0.0)));
            }
        }
    }

    #[test]
    fn what_is_no_picture_is_refused() {
        let new = |size, bytes: &[u8]| {
            Texture::new("bad", size, bytes, ColorSpace::Srgb, Wrap::Repeat).map(|_| ())
        };
        assert!(new([0, 1], &[]).is_err());
        assert!(new([2, 2], &[0; 15]).is_err());
        assert!(new([u32::MAX, u32::MAX], &[0; 4]).is_err());
        assert!(new([2, 2], &[0; 16]).is_ok());
    }

    #[test]
    fn rows_that_nobody_uses_are_taken_again() {
        let mut textures = Textures::default();
        let [a, b] = [1, 2].map(|byte| textures.add(grey([1, 1], &[byte], ColorSpace::Linear)));
        textures.retain(&HashSet::from([b]));
        assert!(textures.get(a).is_some_and(|empty| empty.levels.is_empty()));
        let c = textures.add(grey([1, 1], &[3], ColorSpace::Linear));
        assert_eq!((a, textures.rows().len()), (c, 2));
    }
}
