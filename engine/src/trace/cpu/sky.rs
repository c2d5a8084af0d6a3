//! The background along a direction: a colour by height, times a panorama.
//!
//! Twin of `shaders/shared/sky.wgsl`.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use crate::frame::wire::NONE;
use crate::geom::angle_of;
use crate::trace::PackedScene;
use crate::trace::pack::Texel;

/// The background along a unit direction.
pub fn sky(scene: &PackedScene, dir: Vec3) -> Vec3 {
    let view = &scene.view;
    let horizon = Vec3::from(view.background);
    if !scene.has_sky {
        return horizon;
    }
    let height = dir.y.abs().min(1.0);
    let end = if dir.y > 0.0 {
        view.zenith
    } else {
        view.ground
    };
    let color = horizon * (1.0 - height) + Vec3::from(end) * height;
    if view.panorama == NONE {
        return color;
    }
    color
        * panorama(
            &scene.texels.memory,
            (view.panorama, view.panorama_turn),
            dir,
        )
}

/// The four texels around a direction: the picture goes round, and ends at the poles.
fn panorama(memory: &[Texel], (first, turn): (u32, f32), dir: Vec3) -> Vec3 {
    let [low, high, width, height] = memory[first as usize + 1];
    let place = usize::from(low) | usize::from(high) << 16;
    let (width, height) = (i32::from(width), i32::from(height));
    let around = 0.5 + angle_of(dir.x, -dir.z) * (1.0 / TAU) + turn;
    let level = Vec2::new(dir.x, dir.z).length();
    let down = 0.5 - angle_of(dir.y, level) * (2.0 / TAU);
    let at =
        Vec2::new(around - around.floor(), down) * Vec2::new(width as f32, height as f32) - 0.5;
    let corner = at.floor();
    let share = at - corner;
    let (left, top) = (corner.x as i32, corner.y as i32);
    let columns = [left, left + 1].map(|x| x.rem_euclid(width) as usize);
    let [upper, lower] = [top, top + 1].map(|y| {
        let row = place + (y.clamp(0, height - 1) * width) as usize;
        let [a, b] = columns.map(|x| radiance(memory[row + x]));
        a * (1.0 - share.x) + b * share.x
    });
    upper * (1.0 - share.y) + lower * share.y
}

/// Three numbers and their exponent.
fn radiance([r, g, b, exponent]: Texel) -> Vec3 {
    let scale = f32::from_bits(u32::from(exponent) << 23);
    Vec3::new(r.into(), g.into(), b.into()) * (1.0 / 65_535.0) * scale
}
