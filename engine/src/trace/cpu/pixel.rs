//! A pixel's samples: the light along the ray through each.
//!
//! Twin of `shaders/shared/pixel.wgsl`.

use glam::Vec3;

use super::cutoff::Purse;
use super::path::{Scratch, Travel, first_width, radiance};
use crate::frame::sample_offset;
use crate::frame::wire::{PROJECTION_PERSPECTIVE, ViewRow};
use crate::trace::PackedScene;

/// The sum over a pixel's samples of these numbers.
pub fn sum_of_samples(
    scene: &PackedScene,
    [x, y]: [u32; 2],
    samples: std::ops::Range<u32>,
    scratch: &mut Scratch,
) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for index in samples {
        let [right, down] = sample_offset(index);
        let ray = camera_ray(&scene.view, x as f32 + right, y as f32 + down);
        let purse = Purse::of_sample(&scene.view, index);
        sum += radiance(scene, ray, purse, scratch);
    }
    sum
}

/// The ray through a point of the picture, in pixels from its top left corner.
fn camera_ray(view: &ViewRow, px: f32, py: f32) -> Travel {
    // Half pixels from the middle: whole numbers, exact in f32, at the centres of pixels.
    let across = 2.0 * px - view.width as f32;
    let upward = view.height as f32 - 2.0 * py;
    let forward = Vec3::from(view.forward);
    let aside = Vec3::from(view.right_step) * across + Vec3::from(view.up_step) * upward;
    let width = first_width(view);
    if view.projection == PROJECTION_PERSPECTIVE {
        Travel::from_camera(Vec3::ZERO, (forward + aside).normalize(), width)
    } else {
        Travel::from_camera(aside, forward, width)
    }
}
