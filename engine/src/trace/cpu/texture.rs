//! Filtered lookups in the memory of texels: bilinear in a level, linear between two.
//!
//! The level comes from how much of the picture a ray's cone covers (Akenine-Möller et al., "Texture Level of Detail
//! Strategies for Real-Time Ray Tracing", Ray Tracing Gems, 2019, ch. 20). Twin of `shaders/shared/texture.wgsl`.

use glam::{Vec2, Vec4};

use crate::frame::wire::{WRAP_MIRROR, WRAP_REPEAT};
use crate::trace::pack::Texel;

/// Size of the last level that is looked at; narrower footprints read the first one.
const NARROWEST: f32 = 1e-30;

/// The texture that begins at `first`, at `uv`, averaged over about `footprint` of its edge: linear RGB and alpha.
pub fn sample(memory: &[Texel], first: u32, uv: Vec2, footprint: f32) -> Vec4 {
    let [levels, wrap, ..] = memory[first as usize];
    let [.., width, height] = memory[first as usize + 1];
    let across = footprint * (f32::from(width) * f32::from(height)).sqrt();
    let level = across
        .max(NARROWEST)
        .log2()
        .clamp(0.0, f32::from(levels - 1));
    let fine = level.floor();
    let share = level - fine;
    let head = first + 1 + fine as u32;
    let uv = Vec2::new(inside(uv.x, u32::from(wrap)), inside(uv.y, u32::from(wrap)));
    let near = bilinear(memory, head, uv, u32::from(wrap));
    if share == 0.0 {
        return near;
    }
    near * (1.0 - share) + bilinear(memory, head + 1, uv, u32::from(wrap)) * share
}

/// The place in the picture that a coordinate beyond it shows, from 0 to 1.
fn inside(x: f32, wrap: u32) -> f32 {
    match wrap {
        WRAP_REPEAT => x - x.floor(),
        WRAP_MIRROR => 1.0 - (x - 2.0 * (x * 0.5).floor() - 1.0).abs(),
        _ => x.clamp(0.0, 1.0),
    }
}

/// The four texels around a place in the level with this head.
fn bilinear(memory: &[Texel], head: u32, uv: Vec2, wrap: u32) -> Vec4 {
    let [low, high, width, height] = memory[head as usize];
    let place = usize::from(low) | usize::from(high) << 16;
    let (width, height) = (i32::from(width), i32::from(height));
    let at = uv * Vec2::new(width as f32, height as f32) - 0.5;
    let corner = at.floor();
    let share = at - corner;
    let (left, top) = (corner.x as i32, corner.y as i32);
    let columns = [left, left + 1].map(|x| beside(x, width, wrap));
    let [upper, lower] = [top, top + 1].map(|y| {
        let row = place + (beside(y, height, wrap) * width) as usize;
        let [a, b] = columns.map(|x| texel(memory[row + x as usize]));
        a * (1.0 - share.x) + b * share.x
    });
    upper * (1.0 - share.y) + lower * share.y
}

/// The texel that stands for one at most one beyond the edge.
fn beside(i: i32, count: i32, wrap: u32) -> i32 {
    if wrap != WRAP_REPEAT {
        i.clamp(0, count - 1)
    } else if i < 0 {
        i + count
    } else if i >= count {
        i - count
    } else {
        i
    }
}

fn texel(texel: Texel) -> Vec4 {
    Vec4::from(texel.map(f32::from)) * (1.0 / 65_535.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::pack::Texels;
    use crate::world::{ColorSpace, Table, Texture, Wrap};
    use std::sync::Arc;

    fn packed(size: [u32; 2], wrap: Wrap) -> Texels {
        let bytes: Vec<u8> = (0..size[0] * size[1])
            .flat_map(|i| [(i * 10) as u8, 255 - (i * 10) as u8, 0, (i * 7) as u8])
            .collect();
        let texture = Texture::new("ramp", size, &bytes, ColorSpace::Linear, wrap);
        let table: Table<Arc<Texture>> =
            vec![Arc::default(), Arc::new(texture.expect("a texture"))].into();
        let mut texels = Texels::default();
        assert!(texels.update(&table) && !texels.update(&table));
        texels
    }

    #[test]
    fn centres_of_texels_are_the_texels_and_between_is_between() {
        let texels = packed([4, 3], Wrap::Repeat);
        let first = texels.first(Some(crate::world::TextureId(1)));
        let red = |x: f32, y: f32| sample(&texels.memory, first, Vec2::new(x, y), 0.0).x * 255.0;
        for i in 0..12 {
            let (x, y) = ((i % 4) as f32 + 0.5, (i / 4) as f32 + 0.5);
            let found = red(x / 4.0, y / 3.0);
            assert!((found - (i * 10) as f32).abs() < 1e-3, "{i}: {found}");
            // The same a whole number of pictures away.
            let away = red(x / 4.0 - 3.0, y / 3.0 + 2.0);
            assert!((away - found).abs() < 1e-3, "{i}: {away}");
        }
        assert!((red(0.25, 0.5 / 3.0) - 5.0).abs() < 1e-3);
        // Beyond the right edge comes the left one.
        assert!((red(1.0, 0.5 / 3.0) - 15.0).abs() < 1e-3);
    }

    #[test]
    fn edges_clamp_and_mirror() {
        let id = Some(crate::world::TextureId(1));
        for (wrap, x, expected) in [
            (Wrap::Clamp, 7.0, 30.0),
            (Wrap::Clamp, -7.0, 0.0),
            (Wrap::Mirror, 1.0 + 0.5 / 4.0, 30.0),
            (Wrap::Mirror, 1.0 + 2.5 / 4.0, 10.0),
            (Wrap::Mirror, -0.5 / 4.0, 0.0),
            (Wrap::Mirror, -1.5 / 4.0, 10.0),
        ] {
            let texels = packed([4, 1], wrap);
            let found = sample(&texels.memory, texels.first(id), Vec2::new(x, 0.5), 0.0).x;
            assert!(
                (found * 255.0 - expected).abs() < 1e-3,
                "{wrap:?} {x}: {found}"
            );
        }
    }

    #[test]
    fn wide_footprints_see_the_mean() {
        let texels = packed([4, 4], Wrap::Repeat);
        let first = texels.first(Some(crate::world::TextureId(1)));
        let mean = (0..16).map(|i| (i * 10) as f32).sum::<f32>() / 16.0;
        for footprint in [1.0, 5.0, 1e30] {
            let found = sample(&texels.memory, first, Vec2::new(0.3, 0.9), footprint).x * 255.0;
            assert!((found - mean).abs() < 0.1, "{footprint}: {found}");
        }
        // Half way between two levels.
        let at = |footprint| sample(&texels.memory, first, Vec2::new(0.3, 0.9), footprint).x;
        let middle = at(2_f32.powf(0.5) / 4.0);
        assert!((middle - 0.5 * (at(0.25) + at(0.5))).abs() < 1e-5);
    }
}
