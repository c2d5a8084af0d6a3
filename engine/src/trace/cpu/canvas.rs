//! The picture under way: for each pixel the mean of its samples and how many they are.
//!
//! Twin of `shaders/whitted.wgsl` and `shaders/antialias.wgsl`, where the count is a pixel's alpha.

use glam::UVec2;
use rayon::prelude::*;

use super::edges::edges;
use super::path::Scratch;
use super::pixel::sum_of_samples;
use crate::trace::progress::first_samples;
use crate::trace::{Counters, PackedScene, Picture};

/// Rows of pixels a task takes: small enough to share out, large enough to be worth a task.
const ROWS_PER_TASK: usize = 4;

/// See the module.
#[derive(Default)]
pub struct Canvas {
    /// The means.
    pub picture: Picture,
    taken: Vec<u16>,
}

impl Canvas {
    /// A picture from the start; adaptive ones have the first sample of each pixel.
    pub fn start(&mut self, scene: &PackedScene) -> Counters {
        let size = UVec2::new(scene.view.width, scene.view.height);
        if self.picture.size != size {
            self.picture = Picture::new(size);
        }
        self.picture.pixels.fill(glam::Vec3::ZERO);
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
        let width = self.picture.size.x as usize;
        let in_task = (width * ROWS_PER_TASK).max(1);
        let pixels = self.picture.pixels.par_chunks_mut(in_task);
        pixels
            .zip(self.taken.par_chunks_mut(in_task))
            .enumerate()
            .map_init(Scratch::default, |scratch, (task, (pixels, taken))| {
                scratch.counters = Counters::default();
                for (i, (mean, taken)) in pixels.iter_mut().zip(taken).enumerate() {
                    let pixel = task * in_task + i;
                    let first = u32::from(*taken);
                    let end = wanted(pixel, first);
                    if end <= first {
                        continue;
                    }
                    let at = [(pixel % width) as u32, (pixel / width) as u32];
                    let sum = sum_of_samples(scene, at, first..end, scratch);
                    *mean += (sum - *mean * (end - first) as f32) / end as f32;
                    *taken = end as u16;
                }
                scratch.counters
            })
            .reduce(Counters::default, |a, b| a + b)
    }
}
