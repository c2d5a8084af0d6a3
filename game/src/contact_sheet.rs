//! A sheet of small pictures that shows at a glance what moved.

use glam::{UVec2, Vec3};
use orrery_engine::trace::Picture;

/// Small pictures across, where they are moments of one scene.
pub const MOMENTS: u32 = 4;
/// Dark pixels between them.
const GAP: u32 = 4;

/// Lays the pictures out in rows of so many from the top left; all have the size of the first.
pub fn contact_sheet(pictures: &[Picture], columns: u32) -> Picture {
    let size = pictures.first().map_or(UVec2::ONE, |first| first.size);
    let rows = (pictures.len() as u32).div_ceil(columns).max(1);
    let cell = size + GAP;
    let mut sheet = Picture::new(UVec2::new(columns, rows) * cell + GAP);
    for (number, picture) in (0..).zip(pictures) {
        let corner = UVec2::new(number % columns, number / columns) * cell + GAP;
        for y in 0..size.y.min(picture.size.y) {
            let from = (y * picture.size.x) as usize;
            let to = ((corner.y + y) * sheet.size.x + corner.x) as usize;
            let width = size.x.min(picture.size.x) as usize;
            sheet.pixels[to..to + width].copy_from_slice(&picture.pixels[from..from + width]);
        }
    }
    sheet
}

/// The picture at half the size: each pixel the mean of four, in linear light clipped as a display does.
pub fn halved(picture: &Picture) -> Picture {
    let mut half = Picture::new((picture.size / 2).max(UVec2::ONE));
    let at = |x: u32, y: u32| {
        let (x, y) = (x.min(picture.size.x - 1), y.min(picture.size.y - 1));
        picture.pixels[(y * picture.size.x + x) as usize].clamp(Vec3::ZERO, Vec3::ONE)
    };
    for y in 0..half.size.y {
        for x in 0..half.size.x {
            let sum = at(2 * x, 2 * y)
                + at(2 * x + 1, 2 * y)
                + at(2 * x, 2 * y + 1)
                + at(2 * x + 1, 2 * y + 1);
            half.pixels[(y * half.size.x + x) as usize] = sum / 4.0;
        }
    }
    half
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_lie_side_by_side() {
        let mut picture = Picture::new(UVec2::new(3, 2));
        picture.pixels.fill(Vec3::ONE);
        let sheet = contact_sheet(&vec![picture; 5], MOMENTS);
        assert_eq!(sheet.size, UVec2::new(4 * 7 + 4, 2 * 6 + 4));
        let lit = sheet.pixels.iter().filter(|p| **p == Vec3::ONE).count();
        assert_eq!(lit, 5 * 6);
        let fifth = (10 * sheet.size.x + 4) as usize;
        assert_eq!(sheet.pixels[fifth], Vec3::ONE);
    }

    #[test]
    fn halving_keeps_the_mean() {
        let mut picture = Picture::new(UVec2::new(2, 2));
        picture.pixels[0] = Vec3::ONE;
        assert_eq!(halved(&picture).pixels, [Vec3::splat(0.25)]);
    }
}
