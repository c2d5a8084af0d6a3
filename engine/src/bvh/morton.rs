//! Boxes along a space-filling curve: the order in which [`super::cluster`] looks for neighbours.
//!
//! Morton order (Morton 1966) of the boxes' centres, ten bits an axis, sorted by radix. Where many share a
//! cell (a small group in a large scene), they are put in order by a grid of their own.

use glam::Vec3A;

use super::Extent;

/// Cells along an axis, as a power of two; also the bits of a pass of the sort.
const BITS: u32 = 10;
const DIGITS: usize = 1 << BITS;
/// Boxes in one cell from which they get a grid of their own.
const CROWD: usize = 8;
/// Grids within grids: after these, all of f32's range is resolved.
const MOST_GRIDS: u32 = 24;

/// Sorts, keeping its memory from one call to the next.
#[derive(Clone, Debug, Default)]
pub struct MortonSort {
    /// The code of the cell, then the number of the box.
    entries: Vec<u64>,
    spare: Vec<u64>,
}

/// The grid that codes count in.
#[derive(Clone, Copy)]
struct Grid {
    origin: Vec3A,
    scale: Vec3A,
}

impl MortonSort {
    /// The numbers of these boxes in Morton order, equals in order of number; boxes must be finite.
    pub fn sort(&mut self, boxes: &[Extent]) -> impl ExactSizeIterator<Item = u32> + '_ {
        let grid = Grid::around(boxes.iter());
        let entry = |(number, b): (usize, &Extent)| u64::from(grid.code(b)) << 32 | number as u64;
        self.entries.clear();
        self.entries.extend(boxes.iter().enumerate().map(entry));
        self.spare.resize(self.entries.len(), 0);
        let mut counts = [[0_u32; DIGITS]; 3];
        for entry in &self.entries {
            for (pass, counts) in counts.iter_mut().enumerate() {
                counts[digit(*entry, pass)] += 1;
            }
        }
        for (pass, counts) in counts.iter_mut().enumerate() {
            let mut place = 0;
            for count in counts.iter_mut() {
                (*count, place) = (place, place + *count);
            }
            for &entry in &self.entries {
                let place = &mut counts[digit(entry, pass)];
                self.spare[*place as usize] = entry;
                *place += 1;
            }
            std::mem::swap(&mut self.entries, &mut self.spare);
        }
        refine(&mut self.entries, boxes, MOST_GRIDS);
        self.entries.iter().map(|&entry| entry as u32)
    }
}

fn digit(entry: u64, pass: usize) -> usize {
    (entry >> (32 + BITS * pass as u32)) as usize & (DIGITS - 1)
}

/// Puts those in order that share a cell.
fn refine(entries: &mut [u64], boxes: &[Extent], grids: u32) {
    for crowd in entries.chunk_by_mut(|a, b| a >> 32 == b >> 32) {
        if crowd.len() < CROWD || grids == 0 {
            continue;
        }
        let grid = Grid::around(crowd.iter().map(|&entry| &boxes[entry as u32 as usize]));
        for entry in crowd.iter_mut() {
            let number = *entry as u32;
            *entry = u64::from(grid.code(&boxes[number as usize])) << 32 | u64::from(number);
        }
        crowd.sort_unstable();
        if crowd.first().map(|e| e >> 32) != crowd.last().map(|e| e >> 32) {
            refine(crowd, boxes, grids - 1);
        }
    }
}

impl Grid {
    fn around<'a>(boxes: impl Iterator<Item = &'a Extent>) -> Self {
        let center = |b: &Extent| b.min + b.max;
        let (min, max) = boxes
            .map(center)
            .fold((Vec3A::MAX, Vec3A::MIN), |(min, max), c| {
                (min.min(c), max.max(c))
            });
        Self {
            origin: min,
            scale: (DIGITS - 1) as f32 / (max - min).max(Vec3A::splat(f32::MIN_POSITIVE)),
        }
    }

    /// The cell of a box's centre.
    #[inline]
    fn code(&self, b: &Extent) -> u32 {
        let cell = (b.min + b.max - self.origin) * self.scale;
        let [x, y, z] = cell
            .to_array()
            .map(|x| spread((x as u32).min(DIGITS as u32 - 1)));
        x << 2 | y << 1 | z
    }
}

/// Ten bits with two zeros before each.
#[inline]
fn spread(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}
