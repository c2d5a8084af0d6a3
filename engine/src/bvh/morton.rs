//! Boxes along a space-filling curve: the order in which [`super::cluster`] looks for neighbours.
//!
//! Morton order (Morton 1966) of the boxes' centres. The upper 30 bits are sorted by radix, ten bits a pass;
//! where many share them (a small group in a large scene), the order is refined by all 63 bits.

use glam::Vec3A;

use super::Extent;

/// Cells along an axis, as a power of two.
const BITS: u32 = 21;
/// Bits of a pass of the sort, and of each axis in the part that is sorted by radix.
const DIGIT: u32 = 10;
const DIGITS: usize = 1 << DIGIT;

/// Sorts, keeping its memory from one call to the next.
#[derive(Clone, Debug, Default)]
pub struct MortonSort {
    /// Upper 30 bits of the code, then the number of the box.
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
        let grid = Grid::around(boxes);
        let entry =
            |(number, b): (usize, &Extent)| u64::from(grid.upper_code(b)) << 32 | number as u64;
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
        for run in self.entries.chunk_by_mut(|a, b| a >> 32 == b >> 32) {
            if run.len() > 1 {
                run.sort_unstable_by_key(|&entry| {
                    let number = entry as u32;
                    (grid.code(&boxes[number as usize]), number)
                });
            }
        }
        self.entries.iter().map(|&entry| entry as u32)
    }
}

fn digit(entry: u64, pass: usize) -> usize {
    (entry >> (32 + DIGIT * pass as u32)) as usize & (DIGITS - 1)
}

impl Grid {
    fn around(boxes: &[Extent]) -> Self {
        let center = |b: &Extent| b.min + b.max;
        let (min, max) = boxes
            .iter()
            .map(center)
            .fold((Vec3A::MAX, Vec3A::MIN), |(min, max), c| {
                (min.min(c), max.max(c))
            });
        let cells = ((1 << BITS) - 1) as f32;
        Self {
            origin: min,
            scale: cells / (max - min).max(Vec3A::splat(f32::MIN_POSITIVE)),
        }
    }

    /// The cell of a box's centre.
    #[inline]
    fn cell(&self, b: &Extent) -> [u32; 3] {
        let most = (1 << BITS) - 1;
        ((b.min + b.max - self.origin) * self.scale)
            .to_array()
            .map(|x| (x as u32).min(most))
    }

    #[inline]
    fn upper_code(&self, b: &Extent) -> u32 {
        let [x, y, z] = self.cell(b).map(|c| spread_10(c >> (BITS - DIGIT)));
        x << 2 | y << 1 | z
    }

    fn code(&self, b: &Extent) -> u64 {
        let [x, y, z] = self.cell(b).map(spread_21);
        x << 2 | y << 1 | z
    }
}

/// Ten bits with two zeros before each.
#[inline]
fn spread_10(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

/// 21 bits with two zeros before each.
fn spread_21(x: u32) -> u64 {
    let x = u64::from(x);
    let x = (x | x << 32) & 0x001f_0000_0000_ffff;
    let x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    let x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    let x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}
