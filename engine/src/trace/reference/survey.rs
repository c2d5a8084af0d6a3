//! What a picture costs, pixel by pixel and thing by thing: counted by the walk that explains pixels, for many at once.
//!
//! Rays and depth are those of every tracer; boxes and shapes are tests of the reference's own trees, which are plainer than
//! the others'. Pictures are traced without any of it: the counting recorder makes a walk of its own.

use std::fmt;
use std::str::FromStr;

use glam::{DVec3, UVec2, Vec3};
use rayon::prelude::*;

use super::ReferenceTracer;
use super::explain::{RayKind, Recorder};
use super::world::{WorldHit, WorldRay};
use crate::trace::Picture;

/// What a picture of heat shows of each pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heat {
    /// Rays of every kind.
    Rays,
    /// The longest chain of rays.
    Depth,
    /// Boxes that rays were held against.
    Boxes,
    /// Triangles and other shapes that rays were held against.
    Shapes,
}

impl Heat {
    /// All.
    pub const ALL: [Self; 4] = [Self::Rays, Self::Depth, Self::Boxes, Self::Shapes];

    /// In one word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rays => "rays",
            Self::Depth => "depth",
            Self::Boxes => "boxes",
            Self::Shapes => "shapes",
        }
    }
}

impl fmt::Display for Heat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Heat {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|heat| heat.name() == word);
        found.ok_or_else(|| "expected rays, depth, boxes or shapes".into())
    }
}

/// What a pixel cost, all its samples together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PixelCost {
    /// Rays of every kind.
    pub rays: u32,
    /// The longest chain of rays.
    pub depth: u32,
    /// Boxes.
    pub boxes: u32,
    /// Shapes.
    pub shapes: u32,
}

impl PixelCost {
    /// One of the figures.
    pub fn of(&self, heat: Heat) -> u32 {
        match heat {
            Heat::Rays => self.rays,
            Heat::Depth => self.depth,
            Heat::Boxes => self.boxes,
            Heat::Shapes => self.shapes,
        }
    }
}

/// What a thing cost: a row of `FrameScene::instances`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ThingCost {
    /// Rays that met it first (of shadow rays, also those that went on through it).
    pub met: u64,
    /// Rays sent from it: mirrored, refracted, to lights.
    pub sent: u64,
    /// Tests of the rays it sent, and of the camera rays that met it.
    pub tests: u64,
}

/// What was counted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Survey {
    /// Pixels across and down that were looked at: one of so many of the picture's, along each axis.
    pub size: UVec2,
    /// Row by row.
    pub pixels: Vec<PixelCost>,
    /// Of every row of `FrameScene::instances`.
    pub things: Vec<ThingCost>,
    /// Tests of camera rays that met nothing.
    pub nowhere: u64,
}

impl Survey {
    /// The hottest pixel's figure, and the mean.
    pub fn range(&self, heat: Heat) -> (u32, f64) {
        let figures = || self.pixels.iter().map(|pixel| pixel.of(heat));
        let sum: f64 = figures().map(f64::from).sum();
        let count = self.pixels.len().max(1);
        (figures().max().unwrap_or(0), sum / count as f64)
    }

    /// From cold (dark blue) to hot (white), the hottest pixel hottest.
    pub fn picture(&self, heat: Heat) -> Picture {
        let most = self.range(heat).0.max(1) as f32;
        let pixels = self.pixels.iter();
        Picture {
            size: self.size,
            pixels: pixels.map(|p| warmth(p.of(heat) as f32 / most)).collect(),
        }
    }

    /// Tests of all rays.
    pub fn tests(&self) -> u64 {
        self.nowhere + self.things.iter().map(|thing| thing.tests).sum::<u64>()
    }
}

/// Linear RGB of a share from 0 to 1: dark blue, violet, red, yellow, white.
fn warmth(share: f32) -> Vec3 {
    const STOPS: [[f32; 3]; 5] = [
        [0.004, 0.006, 0.04],
        [0.12, 0.01, 0.26],
        [0.7, 0.05, 0.06],
        [0.98, 0.55, 0.04],
        [1.0, 1.0, 0.85],
    ];
    let place = share.clamp(0.0, 1.0) * (STOPS.len() - 1) as f32;
    let below = (place as usize).min(STOPS.len() - 2);
    let [from, to] = [below, below + 1].map(|i| Vec3::from(STOPS[i]));
    from.lerp(to, place - below as f32)
}

/// Adds up.
#[derive(Default)]
struct Tally {
    pixel: PixelCost,
    things: Vec<ThingCost>,
    /// Rays under way: which thing sent each, and which it has met.
    open: Vec<(Option<u32>, Option<u32>)>,
    /// Tests of a camera ray that has met nothing yet.
    pending: u64,
    nowhere: u64,
}

impl Tally {
    fn thing(&mut self, id: u32) -> &mut ThingCost {
        &mut self.things[id as usize]
    }

    fn test(&mut self) {
        match self.open.last() {
            Some((Some(sender), _)) => self.things[*sender as usize].tests += 1,
            _ => self.pending += 1,
        }
    }
}

impl Recorder for Tally {
    fn depth(&self) -> usize {
        self.open.len()
    }

    fn enter(&mut self, kind: RayKind, _: &WorldRay, _: DVec3) {
        let sender = self.open.last().and_then(|(_, met)| *met);
        if let Some(sender) = sender {
            self.thing(sender).sent += 1;
        }
        self.open.push((sender, None));
        self.pixel.rays += 1;
        if !matches!(kind, RayKind::Shadow(_)) {
            self.pixel.depth = self.pixel.depth.max(self.open.len() as u32);
        }
    }

    fn meet(&mut self, hit: Option<&WorldHit>, _: DVec3) {
        let met = hit.map(|hit| hit.key.1);
        let pending = std::mem::take(&mut self.pending);
        match met {
            Some(met) => {
                let thing = self.thing(met);
                thing.met += 1;
                thing.tests += pending;
            }
            None => self.nowhere += pending,
        }
        if let Some(ray) = self.open.last_mut() {
            ray.1 = met;
        }
    }

    fn test_box(&mut self) {
        self.pixel.boxes += 1;
        self.test();
    }

    fn test_shape(&mut self) {
        self.pixel.shapes += 1;
        self.test();
    }

    fn back_to(&mut self, depth: usize) {
        self.open.truncate(depth);
    }
}

impl ReferenceTracer {
    /// Counts what one of `every` pixels along each axis of the uploaded frame costs.
    pub fn survey(&self, every: u32) -> Survey {
        let every = every.max(1);
        let size = self.settings.size.map(|side| side.div_ceil(every));
        let count = self.scene.instances.len();
        let row = |y: u32| {
            let things = vec![ThingCost::default(); count];
            let mut whitted = self.whitted(Tally {
                things,
                ..Tally::default()
            });
            let mut pixels = Vec::with_capacity(size.x as usize);
            for x in 0..size.x {
                self.pixel(x * every, y * every, &mut whitted);
                pixels.push(std::mem::take(&mut whitted.recorder.pixel));
            }
            (pixels, whitted.recorder.things, whitted.recorder.nowhere)
        };
        let rows: Vec<_> = (0..size.y).into_par_iter().map(row).collect();
        let mut survey = Survey {
            size,
            things: vec![ThingCost::default(); count],
            ..Survey::default()
        };
        for (pixels, things, nowhere) in rows {
            survey.pixels.extend(pixels);
            survey.nowhere += nowhere;
            for (sum, thing) in survey.things.iter_mut().zip(things) {
                sum.met += thing.met;
                sum.sent += thing.sent;
                sum.tests += thing.tests;
            }
        }
        survey
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heat_goes_from_dark_to_bright() {
        let brightness = |share: f32| warmth(share).element_sum();
        let steps: Vec<f32> = (0..=40).map(|i| brightness(i as f32 / 40.0)).collect();
        assert!(steps.is_sorted(), "{steps:?}");
        assert!(steps[0] < 0.1 && steps[40] > 2.5);
        for heat in Heat::ALL {
            assert_eq!(heat.name().parse(), Ok(heat));
        }
        assert!("warm".parse::<Heat>().is_err());
    }
}
