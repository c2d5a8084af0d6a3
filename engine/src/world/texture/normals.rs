//! Textures of normals: made flatter or steeper, and made of heights.
//!
//! Called by importers: tracers read a map of normals as it is.

use glam::DVec3;

use super::{Level, Texture, Wrap};

/// How far white stands out over black, of the picture's edge, where a file does not say it.
const RELIEF: f64 = 0.02;

impl Texture {
    /// A map of normals whose tilts are so many times as steep.
    #[must_use]
    pub fn steeper(&self, times: f64) -> Self {
        self.of_normals(|level, x, y| {
            let [r, g, b, _] = level.texels[(y * level.width + x) as usize];
            let tilt = DVec3::from([r, g, b].map(|c| f64::from(c) / 32_767.5 - 1.0));
            DVec3::new(tilt.x * times, tilt.y * times, tilt.z.max(0.0))
        })
    }

    /// The map of normals of a map of heights (its red channel), which stand out so many times as far as usual.
    #[must_use]
    pub fn of_heights(&self, times: f64) -> Self {
        let is_round = self.wrap != Wrap::Clamp;
        self.of_normals(|level, x, y| {
            let (width, height) = (i64::from(level.width), i64::from(level.height));
            let at = |x: i64, y: i64| {
                let within = |i: i64, n: i64| {
                    if is_round {
                        i.rem_euclid(n)
                    } else {
                        i.clamp(0, n - 1)
                    }
                };
                let place = within(y, height) * width + within(x, width);
                f64::from(level.texels[place as usize][0]) / 65_535.0
            };
            let (x, y) = (i64::from(x), i64::from(y));
            let relief = RELIEF * times * 0.5;
            let right = (at(x + 1, y) - at(x - 1, y)) * relief * width as f64;
            let down = (at(x, y + 1) - at(x, y - 1)) * relief * height as f64;
            DVec3::new(-right, down, 1.0)
        })
    }

    /// A map of the normals, of any length, that are found for each texel of the picture: right, up, outward.
    fn of_normals(&self, normal: impl Fn(&Level, u32, u32) -> DVec3) -> Self {
        let Some(level) = self.levels.first() else {
            return self.clone();
        };
        let places = (0..level.height).flat_map(|y| (0..level.width).map(move |x| (x, y)));
        let texel = |(x, y)| {
            let unit = normal(level, x, y).try_normalize().unwrap_or(DVec3::Z);
            let [r, g, b] = unit
                .to_array()
                .map(|c| ((c + 1.0) * 32_767.5).round() as u16);
            [r, g, b, u16::MAX]
        };
        let whole = Level {
            texels: places.map(texel).collect(),
            ..*level
        };
        Self {
            levels: whole.with_smaller(),
            ..self.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::ColorSpace;

    fn normal(texture: &Texture, i: usize) -> DVec3 {
        let [r, g, b, _] = texture.levels[0].texels[i];
        DVec3::from([r, g, b].map(|c| f64::from(c) / 32_767.5 - 1.0))
    }

    fn grey(size: [u32; 2], bytes: &[u8], wrap: Wrap) -> Texture {
        let rgba: Vec<u8> = bytes.iter().flat_map(|&b| [b, b, b, 255]).collect();
        Texture::new("heights", size, &rgba, ColorSpace::Linear, wrap).unwrap()
    }

    #[test]
    fn heights_that_rise_to_the_right_and_down_tilt_to_the_left_and_up() {
        // 51 of 255 a texel, five texels: a slope of 1 where white stands out by the edge's length.
        let right = grey([5, 1], &[0, 51, 102, 153, 204], Wrap::Clamp).of_heights(1.0 / RELIEF);
        let expected = DVec3::new(-1.0, 0.0, 1.0).normalize();
        assert!(normal(&right, 2).distance(expected) < 1e-4);
        let down = grey([1, 5], &[0, 51, 102, 153, 204], Wrap::Clamp).of_heights(1.0 / RELIEF);
        let expected = DVec3::new(0.0, 1.0, 1.0).normalize();
        assert!(normal(&down, 2).distance(expected) < 1e-4);
        // Round the edge: from 204 to 51 on both sides of 0.
        let round = grey([5, 1], &[0, 51, 102, 153, 204], Wrap::Repeat).of_heights(1.0 / RELIEF);
        assert!(normal(&round, 0).x > 0.5);
        assert_eq!(right.levels.len(), 3);
    }

    #[test]
    fn steeper_tilts_are_as_many_times_as_steep() {
        let bytes = [191, 128, 238, 255];
        let map = Texture::new("n", [1, 1], &bytes, ColorSpace::Linear, Wrap::Repeat).unwrap();
        let (before, after) = (normal(&map, 0), normal(&map.steeper(2.0), 0));
        assert!((after.x / after.z - 2.0 * before.x / before.z).abs() < 1e-3);
        assert!((after.length() - 1.0).abs() < 1e-4);
        let flat = normal(&map.steeper(0.0), 0);
        assert!(flat.distance(DVec3::Z) < 1e-4);
    }
}
