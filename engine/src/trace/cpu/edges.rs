//! Where a picture of one sample a pixel is likely wrong: at pixels that differ from a neighbour.
//!
//! Whitted ("An Improved Illumination Model for Shaded Display", 1980, section on aliasing) divides where the
//! samples at a pixel's corners differ; here the pixels around take the corners' part, so that the first sample
//! serves both. Differences are relative, since the eye's and the error's are (Mitchell 1987), but for the dark.
//!
//! Twin of `shaders/edges.wgsl`.

use glam::{UVec2, Vec3};
use rayon::prelude::*;

use crate::trace::Picture;

/// Light below which differences count as they are: that of the relative error by which pictures are judged.
const DARK: f32 = 0.1;

/// The pixels whose contrast with one of the eight around them is more than `most`.
pub fn edges(picture: &Picture, most: f32) -> Vec<bool> {
    let size = picture.size;
    let width = size.x as usize;
    let is_edge = |pixel: usize| {
        let (x, y) = ((pixel % width) as u32, (pixel / width) as u32);
        around(UVec2::new(x, y), size).any(|at| {
            let other = picture.pixels[at.y as usize * width + at.x as usize];
            contrast(picture.pixels[pixel], other) > most
        })
    };
    (0..picture.pixels.len())
        .into_par_iter()
        .with_min_len(4096)
        .map(is_edge)
        .collect()
}

/// The pixel and those around it.
fn around(at: UVec2, size: UVec2) -> impl Iterator<Item = UVec2> {
    let from = at.saturating_sub(UVec2::ONE);
    let to = (at + UVec2::ONE).min(size - UVec2::ONE);
    (from.y..=to.y).flat_map(move |y| (from.x..=to.x).map(move |x| UVec2::new(x, y)))
}

/// The largest of the channels' differences, each over the greater of the two.
fn contrast(a: Vec3, b: Vec3) -> f32 {
    ((a - b).abs() / (a.abs().max(b.abs()) + DARK)).max_element()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_sides_of_a_step_are_edges_and_nothing_else_is() {
        let mut picture = Picture::new(UVec2::new(9, 7));
        for y in 0..7 {
            for x in 0..9 {
                let light = if x < 5 { 0.5 } else { 0.52 };
                picture.pixels[y * 9 + x] = Vec3::new(0.5, light, 0.5);
            }
        }
        let columns = |most| -> Vec<usize> {
            let found = edges(&picture, most);
            (0..63).filter(|i| found[*i]).map(|i| i % 9).collect()
        };
        assert_eq!(columns(0.03), [4, 5].repeat(7));
        assert!(columns(0.04).is_empty());
    }

    #[test]
    fn a_lone_pixel_is_an_edge_with_all_around_it() {
        let mut picture = Picture::new(UVec2::new(5, 5));
        picture.pixels[12] = Vec3::ONE;
        let found = edges(&picture, 0.5);
        let expected: Vec<bool> = (0..25)
            .map(|i| (1..4).contains(&(i % 5)) && (1..4).contains(&(i / 5)))
            .collect();
        assert_eq!(found, expected);
    }
}
