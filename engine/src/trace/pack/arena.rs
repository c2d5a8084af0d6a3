//! [`Arena`]: where in one long buffer each of many pieces lies.

use std::ops::Range;

/// Hands out ranges of rows, first fit; a piece keeps its place until it is freed.
#[derive(Clone, Debug, Default)]
pub struct Arena {
    end: u32,
    /// Ascending, apart, none at the end.
    free: Vec<Range<u32>>,
}

impl Arena {
    /// Rows the buffer needs.
    pub fn len(&self) -> u32 {
        self.end
    }

    /// A range of `count` rows that nobody has.
    pub fn take(&mut self, count: u32) -> Range<u32> {
        if count == 0 {
            return 0..0;
        }
        let fits = |range: &Range<u32>| range.end - range.start >= count;
        if let Some(index) = self.free.iter().position(fits) {
            let start = self.free[index].start;
            self.free[index].start += count;
            if self.free[index].is_empty() {
                self.free.remove(index);
            }
            return start..start + count;
        }
        let start = self.end;
        self.end += count;
        start..self.end
    }

    /// Gives a range back.
    pub fn free(&mut self, range: Range<u32>) {
        if range.is_empty() {
            return;
        }
        let index = self.free.partition_point(|f| f.start < range.start);
        self.free.insert(index, range);
        if index + 1 < self.free.len() && self.free[index].end == self.free[index + 1].start {
            self.free[index].end = self.free.remove(index + 1).end;
        }
        if index > 0 && self.free[index - 1].end == self.free[index].start {
            self.free[index - 1].end = self.free.remove(index).end;
        }
        if self.free.last().is_some_and(|last| last.end == self.end) {
            self.end = self.free.pop().map_or(0, |last| last.start);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_row_has_two_owners_and_freed_ones_come_back() {
        let mut state = 3_u32;
        let mut below = |n: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) % n
        };
        let mut arena = Arena::default();
        let mut held: Vec<Range<u32>> = Vec::new();
        for _ in 0..2000 {
            if below(2) == 0 || held.is_empty() {
                let range = arena.take(1 + below(9));
                assert!(range.end <= arena.len());
                let apart =
                    |other: &Range<u32>| range.end <= other.start || other.end <= range.start;
                assert!(held.iter().all(apart), "{range:?} is taken");
                held.push(range);
            } else {
                let range = held.swap_remove(below(held.len() as u32) as usize);
                arena.free(range);
            }
        }
        held.drain(..).for_each(|range| arena.free(range));
        assert_eq!((arena.len(), arena.free.len()), (0, 0));
    }
}
