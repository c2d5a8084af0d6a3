//! [`DirtyRows`]: rows, and which of them a copy elsewhere does not have yet.

use std::ops::{Deref, Range};

/// Ranges nearer than this many rows are brought over as one: a write has a price of its own.
const GAP: u32 = 16;

/// Rows of which a device holds a copy. Reads go through the slice it derefs to.
#[derive(Clone, Debug)]
pub struct DirtyRows<T> {
    rows: Vec<T>,
    /// Unordered and overlapping until asked for.
    dirty: Vec<Range<u32>>,
}

impl<T> Default for DirtyRows<T> {
    fn default() -> Self {
        Self {
            rows: Vec::new(),
            dirty: Vec::new(),
        }
    }
}

impl<T> Deref for DirtyRows<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.rows
    }
}

impl<T: Copy> DirtyRows<T> {
    /// Makes it `count` rows; new ones are `filler` and dirty.
    pub fn resize(&mut self, count: usize, filler: T) {
        if count > self.rows.len() {
            self.dirty.push(self.rows.len() as u32..count as u32);
        }
        self.rows.resize(count, filler);
    }

    /// All rows, to be written; they count as dirty.
    pub fn all_mut(&mut self) -> &mut [T] {
        self.dirty.clear();
        self.dirty.push(0..self.rows.len() as u32);
        &mut self.rows
    }

    /// The ranges that the copy lacks, ascending and apart; from now on it has them.
    pub fn take_dirty(&mut self) -> Vec<Range<u32>> {
        let end = self.rows.len() as u32;
        let mut ranges = std::mem::take(&mut self.dirty);
        ranges.sort_unstable_by_key(|range| range.start);
        let mut merged: Vec<Range<u32>> = Vec::new();
        for range in ranges {
            let range = range.start.min(end)..range.end.min(end);
            match merged.last_mut() {
                Some(last) if range.start <= last.end.saturating_add(GAP) => {
                    last.end = last.end.max(range.end);
                }
                _ if range.is_empty() => {}
                _ => merged.push(range),
            }
        }
        merged
    }

    /// Whether the copy lacks anything.
    pub fn is_dirty(&self) -> bool {
        !self.dirty.is_empty()
    }
}

impl<T: Copy + PartialEq> DirtyRows<T> {
    /// Writes a row; an equal one stays clean.
    pub fn set(&mut self, index: usize, row: T) {
        if self.rows[index] != row {
            self.rows[index] = row;
            let index = index as u32;
            match self.dirty.last_mut() {
                Some(last) if last.end == index => last.end += 1,
                _ => self.dirty.push(index..index + 1),
            }
        }
    }

    /// Makes it these rows.
    pub fn assign(&mut self, rows: impl ExactSizeIterator<Item = T>)
    where
        T: Default,
    {
        self.resize(rows.len(), T::default());
        for (index, row) in rows.enumerate() {
            self.set(index, row);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_kept_by_ranges_is_a_copy() {
        let mut state = 7_u32;
        let mut below = |n: usize| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as usize % n
        };
        let mut rows = DirtyRows::default();
        let mut copy: Vec<u32> = Vec::new();
        for round in 0..500_u32 {
            if round % 50 == 0 {
                rows.resize(1 + below(300), 0);
            }
            for _ in 0..below(20) {
                let index = below(rows.len());
                rows.set(index, round);
            }
            copy.resize(rows.len(), u32::MAX);
            let mut end = None;
            for range in rows.take_dirty() {
                assert!(end.is_none_or(|end| end < range.start), "{range:?}");
                end = Some(range.end);
                let range = range.start as usize..range.end as usize;
                copy[range.clone()].copy_from_slice(&rows[range]);
            }
            assert_eq!(copy, *rows);
            assert!(!rows.is_dirty());
        }
    }
}
