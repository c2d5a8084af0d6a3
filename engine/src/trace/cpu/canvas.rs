//! The picture under way: for each pixel the mean of its samples and how many they are.
//!
//! Twin of `shaders/whitted.wgsl` and `shaders/antialias.wgsl`, where the count is a pixel's alpha.

use std::ops::Range;

use glam::{UVec2, Vec3};
use rayon::prelude::*;

use super::edges::edges;
use super::packet::PACKET;
use super::pixel::{Kept, Sample, light_of};
use super::simd::Instructions;
use super::stack::Stack;
use crate::trace::progress::first_samples;
use crate::trace::{Counters, PackedScene, Picture};

/// Pixels across and down that are traced together; a task takes a row of such tiles.
const TILE: usize = 8;

/// See the module.
#[derive(Default)]
pub struct Canvas {
    /// The means.
    pub picture: Picture,
    /// What packets are traced with.
    pub instructions: Instructions,
    taken: Vec<u16>,
}

impl Canvas {
    /// A picture from the start; adaptive ones have the first sample of each pixel.
    pub fn start(&mut self, scene: &PackedScene) -> Counters {
        let size = UVec2::new(scene.view.width, scene.view.height);
        if self.picture.size != size {
            self.picture = Picture::new(size);
        }
        self.picture.pixels.fill(Vec3::ZERO);
        self.taken.clear();
        self.taken.resize(self.picture.pixels.len(), 0);
        let first = first_samples(&scene.view);
        self.take(scene, |_, _| first)
    }

    /// All samples of the pixels that differ from a neighbour.
    pub fn antialias(&mut self, scene: &PackedScene) -> Counters {
        let edges = edges(&self.picture, scene.view.edge_contrast);
        let all = scene.view.samples;
        let pick = |pixel: usize, taken| if edges[pixel] { all } else { taken };
        Counters {
            edge_pixels: edges.iter().filter(|edge| **edge).count() as u64,
            ..self.take(scene, pick)
        }
    }

    /// The next sample of each pixel that has fewer than `limit`.
    pub fn refine(&mut self, scene: &PackedScene, limit: u32) -> Counters {
        self.take(scene, |_, taken| (taken + 1).min(limit))
    }

    /// Takes each pixel to as many samples as `wanted` says, given its number and how many it has.
    fn take(&mut self, scene: &PackedScene, wanted: impl Fn(usize, u32) -> u32 + Sync) -> Counters {
        let instructions = self.instructions;
        let width = self.picture.size.x as usize;
        let in_task = (width * TILE).max(1);
        let pixels = self.picture.pixels.par_chunks_mut(in_task);
        pixels
            .zip(self.taken.par_chunks_mut(in_task))
            .enumerate()
            .map_init(
                || Brush::with(instructions),
                |brush, (task, (means, taken))| {
                    brush.kept.path.counters = Counters::default();
                    let rows = means.len() / width.max(1);
                    for left in (0..width).step_by(TILE) {
                        let columns = left..width.min(left + TILE);
                        let pixels =
                            (0..rows).flat_map(|row| columns.clone().map(move |x| (x, row)));
                        for (x, row) in pixels {
                            let place = row * width + x;
                            let first = u32::from(taken[place]);
                            let end = wanted(task * in_task + place, first);
                            if end > first {
                                taken[place] = end as u16;
                                brush.add(place, [x, task * TILE + row], first..end);
                            }
                        }
                        brush.paint(scene, means);
                    }
                    brush.kept.path.counters
                },
            )
            .reduce(Counters::default, |a, b| a + b)
    }
}

/// Traces the samples of a tile together.
#[derive(Default)]
struct Brush {
    kept: Kept,
    samples: Vec<Sample>,
    /// Which pixel each is of.
    owners: Vec<usize>,
    pixels: Vec<Pixel>,
}

/// A pixel that takes samples.
struct Pixel {
    place: usize,
    samples: Range<u32>,
    sum: Vec3,
}

impl Brush {
    fn with(instructions: Instructions) -> Self {
        let mut brush = Self::default();
        brush.kept.path.stack = Stack::with(instructions);
        brush
    }

    fn add(&mut self, place: usize, [x, y]: [usize; 2], samples: Range<u32>) {
        let at = [x as u32, y as u32];
        self.owners
            .extend(samples.clone().map(|_| self.pixels.len()));
        self.samples
            .extend(samples.clone().map(|number| Sample { at, number }));
        self.pixels.push(Pixel {
            place,
            samples,
            sum: Vec3::ZERO,
        });
    }

    /// Brings the means up to what was added.
    fn paint(&mut self, scene: &PackedScene, means: &mut [Vec3]) {
        let packets = self.samples.chunks(PACKET).zip(self.owners.chunks(PACKET));
        for (samples, owners) in packets {
            let lights = light_of(scene, samples, &mut self.kept);
            for (&owner, light) in owners.iter().zip(lights) {
                self.pixels[owner].sum += light;
            }
        }
        for pixel in self.pixels.drain(..) {
            let (mean, count) = (&mut means[pixel.place], pixel.samples.len());
            *mean += (pixel.sum - *mean * count as f32) / pixel.samples.end as f32;
        }
        self.samples.clear();
        self.owners.clear();
    }
}
