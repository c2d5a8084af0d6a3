//! Samples of pixels: the light along the ray through each, many at a time.
//!
//! Camera rays through neighbouring pixels, and their first shadow rays, go as packets; from there each path goes on alone.
//! Twin of `shaders/shared/pixel.wgsl`, where the lanes of a workgroup are the packet.

use glam::Vec3;

use super::cutoff::Purse;
use super::light::{Way, first_on_the_ways, shadow_probe};
use super::packet::{PACKET, trace_all};
use super::path::{Met, Scratch, Travel, first_width, radiance};
use super::query::{Nearest, Probe};
use crate::frame::sample_offset;
use crate::frame::wire::{PROJECTION_PERSPECTIVE, ViewRow};
use crate::trace::PackedScene;

/// A sample of a pixel.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Column and row.
    pub at: [u32; 2],
    /// Its number among the pixel's.
    pub number: u32,
}

/// What is kept from packet to packet.
#[derive(Default)]
pub struct Kept {
    /// Of paths.
    pub path: Scratch,
    probes: Vec<Probe>,
    /// Which rays the probes are of.
    rays: Vec<usize>,
    /// What the first thing on the way from each ray's hit to each light is.
    lights: Vec<Way>,
}

/// The light of at most [`PACKET`] samples, in order.
pub fn light_of(scene: &PackedScene, samples: &[Sample], kept: &mut Kept) -> [Vec3; PACKET] {
    let samples = &samples[..samples.len().min(PACKET)];
    let ray_of = |sample: &Sample| {
        let [right, down] = sample_offset(sample.number);
        let [x, y] = sample.at.map(|n| n as f32);
        camera_ray(&scene.view, x + right, y + down)
    };
    kept.probes.clear();
    kept.probes
        .extend(samples.iter().map(|sample| ray_of(sample).probe()));
    let mut found = [None; PACKET];
    let both = (&mut kept.path.packet, &mut kept.path.stack);
    trace_all::<Nearest>(scene, &kept.probes, &mut found[..samples.len()], both);
    let mut met: [Option<Met>; PACKET] = [const { None }; PACKET];
    for ((met, found), sample) in met.iter_mut().zip(found).zip(samples) {
        *met = found.map(|found| Met::of(scene, &ray_of(sample), found));
    }
    look_at_lights(scene, samples, &met, ray_of, kept);
    let lights = std::mem::take(&mut kept.lights);
    let mut sums = [Vec3::ZERO; PACKET];
    let count = scene.lights.len();
    for (ray, ((sum, met), sample)) in sums.iter_mut().zip(met).zip(samples).enumerate() {
        let purse = Purse::of_sample(&scene.view, sample.number);
        let known = (met, &lights[ray * count..][..count]);
        *sum = radiance(scene, ray_of(sample), known, purse, &mut kept.path);
    }
    kept.lights = lights;
    sums
}

/// Fills [`Kept::lights`], light by light.
fn look_at_lights(
    scene: &PackedScene,
    samples: &[Sample],
    met: &[Option<Met>; PACKET],
    ray_of: impl Fn(&Sample) -> Travel,
    kept: &mut Kept,
) {
    let count = scene.lights.len();
    kept.lights.clear();
    kept.lights.resize(count * samples.len(), Way::Unknown);
    let mut purses = [Purse::default(); PACKET];
    for (purse, sample) in purses.iter_mut().zip(samples) {
        *purse = Purse::of_sample(&scene.view, sample.number);
    }
    for (number, light) in scene.lights.iter().enumerate() {
        kept.probes.clear();
        kept.rays.clear();
        for (ray, (met, sample)) in met.iter().zip(samples).enumerate() {
            let surface = met.as_ref().map(|met| &met.surface);
            let purse = &mut purses[ray];
            let probe = surface
                .and_then(|surface| shadow_probe(scene, surface, light, &ray_of(sample), purse));
            if let Some(probe) = probe {
                kept.probes.push(probe);
                kept.rays.push(ray);
            }
        }
        let mut found = [None; PACKET];
        let both = (&mut kept.path.packet, &mut kept.path.stack);
        first_on_the_ways(scene, &kept.probes, &mut found[..kept.probes.len()], both);
        for (&ray, found) in kept.rays.iter().zip(found) {
            kept.lights[ray * count + number] = Way::Known(found);
        }
    }
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
