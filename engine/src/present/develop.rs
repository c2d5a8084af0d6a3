//! The picture as a display shows it, 8 bits a channel, and strokes over it.
//!
//! Written to a file by [`super::write_developed`]; windows draw their strokes with the overlay instead.

use glam::{UVec2, Vec2};

use super::tone::display_rgb8;
use super::wireframe::Stroke;
use crate::trace::Picture;
use crate::world::ToneMap;

/// A thin stroke is not fainter than this share of a pixel's width: small pictures would lose it.
const LEAST_SHARE: f32 = 0.4;

/// sRGB, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Developed {
    /// Pixels across and down.
    pub size: UVec2,
    /// `size.x * size.y` pixels, the top row first.
    pub pixels: Vec<[u8; 3]>,
}

impl Developed {
    /// Exposure (stops), tone curve and sRGB applied.
    pub fn new(picture: &Picture, exposure: f32, tone: ToneMap) -> Self {
        let pixels = picture.pixels.iter();
        Self {
            size: picture.size,
            pixels: pixels
                .map(|&pixel| display_rgb8(pixel, exposure, tone))
                .collect(),
        }
    }

    /// Draws strokes in their order, anti-aliased: a pixel is covered as far as it is within the stroke.
    pub fn draw(&mut self, strokes: &[Stroke]) {
        for stroke in strokes {
            self.draw_stroke(stroke);
        }
    }

    fn draw_stroke(&mut self, stroke: &Stroke) {
        let size = self.size.as_vec2();
        let pixel_of = |p: Vec2| (Vec2::new(p.x, -p.y) + 0.5) * size - 0.5;
        let [from, to] = stroke.ends.map(pixel_of);
        // A line thinner than a pixel is as wide as one and fainter.
        let half = (stroke.half_width * size.y).max(0.5);
        let opacity = stroke.opacity * (stroke.half_width * size.y / half).clamp(LEAST_SHARE, 1.0);
        let step = to - from;
        let along_x = step.x.abs() >= step.y.abs();
        let (major, minor) = if along_x { (0, 1) } else { (1, 0) };
        if step[major] == 0.0 {
            return;
        }
        let slope = step[minor] / step[major];
        // How far the stroke reaches across, along the minor axis.
        let stretch = (1.0 + slope * slope).sqrt();
        let reach = (half + 0.5) * stretch;
        let (first, last) = (from[major].min(to[major]), from[major].max(to[major]));
        // Half open, so that strokes that follow one another share no pixel.
        for along in first.ceil() as i32..last.ceil() as i32 {
            let middle = from[minor] + slope * (along as f32 - from[major]);
            for across in (middle - reach).ceil() as i32..=(middle + reach).floor() as i32 {
                let distance = (across as f32 - middle).abs() / stretch;
                let cover = (half + 0.5 - distance).clamp(0.0, 1.0);
                let at = if along_x {
                    [along, across]
                } else {
                    [across, along]
                };
                self.blend(at, stroke.color, cover * opacity);
            }
        }
    }

    fn blend(&mut self, [x, y]: [i32; 2], color: [u8; 3], share: f32) {
        let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) else {
            return;
        };
        if x >= self.size.x || y >= self.size.y {
            return;
        }
        let pixel = &mut self.pixels[y as usize * self.size.x as usize + x as usize];
        for (below, above) in pixel.iter_mut().zip(color) {
            let mixed = f32::from(*below) + (f32::from(above) - f32::from(*below)) * share;
            *below = (mixed + 0.5) as u8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stroke(ends: [Vec2; 2]) -> Stroke {
        Stroke {
            ends,
            color: [255; 3],
            opacity: 1.0,
            half_width: 0.05,
        }
    }

    fn drawn(ends: [Vec2; 2]) -> Developed {
        let picture = Picture::new(UVec2::new(20, 20));
        let mut developed = Developed::new(&picture, 0.0, ToneMap::Clip);
        developed.draw(&[stroke(ends)]);
        developed
    }

    #[test]
    fn a_stroke_covers_its_width_and_has_soft_edges() {
        // Across the middle, two pixels wide, between the rows 9 and 10.
        let level = drawn([Vec2::new(-0.5, 0.0), Vec2::new(0.5, 0.0)]);
        for (i, pixel) in level.pixels.iter().enumerate() {
            let expected = if matches!(i / 20, 9 | 10) { 255 } else { 0 };
            assert_eq!(pixel[0], expected, "row {}", i / 20);
        }
        let steep = drawn([Vec2::new(-0.1, -0.5), Vec2::new(0.1, 0.5)]);
        let light: f32 = steep.pixels.iter().map(|p| f32::from(p[0]) / 255.0).sum();
        let area = 2.0 * 20.0 * (1.0_f32 + 0.04).sqrt();
        assert!((light - area).abs() < 0.5, "{light} for {area}");
        assert!(steep.pixels.iter().any(|p| (30..220).contains(&p[0])));
    }

    #[test]
    fn a_stroke_beyond_the_picture_draws_nothing_and_does_not_end_the_program() {
        for far in [0.6, 1e6, 1e30] {
            let beyond = drawn([Vec2::new(far, -0.6), Vec2::new(far, -0.55)]);
            assert!(beyond.pixels.iter().all(|p| *p == [0; 3]), "{far}");
        }
    }
}
