//! [`Table`]: rows that say which of them changed, for whoever keeps a derived copy.
//!
//! Changes come in batches: all writes between two readings of the version are one. A version stands for
//! the rows as they were when it was read; no two tables of different rows ever have the same. A reader
//! remembers the version it has seen. One batch behind, it is told the rows; otherwise (it was not there,
//! or has seen another table) it must read everything.

use std::ops::Deref;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// The last version given out; 0 is every empty table that nobody ever wrote to.
static LAST_VERSION: AtomicU64 = AtomicU64::new(0);

/// Rows and the last batch of changes to them. Reads go through the slice it derefs to.
#[derive(Debug)]
pub struct Table<T> {
    rows: Vec<T>,
    version: u64,
    /// The version before the batch.
    previous: u64,
    changed: Vec<u32>,
    /// Nobody has read the version since the batch began.
    is_open: AtomicBool,
}

impl<T: Clone> Clone for Table<T> {
    fn clone(&self) -> Self {
        Self {
            rows: self.rows.clone(),
            version: self.version(),
            previous: self.previous,
            changed: self.changed.clone(),
            is_open: AtomicBool::new(false),
        }
    }
}

/// What a reader has to look at again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Changes<'a> {
    /// Nothing.
    None,
    /// These rows, some perhaps twice; new ones among them, and all below the table's length.
    Rows(&'a [u32]),
    /// Every row; the table may be shorter than before.
    All,
}

impl<T> Default for Table<T> {
    fn default() -> Self {
        Self {
            rows: Vec::new(),
            version: 0,
            previous: 0,
            changed: Vec::new(),
            is_open: AtomicBool::new(false),
        }
    }
}

impl<T> FromIterator<T> for Table<T> {
    fn from_iter<I: IntoIterator<Item = T>>(rows: I) -> Self {
        let mut table = Self::default();
        for row in rows {
            table.push(row);
        }
        table
    }
}

impl<T> From<Vec<T>> for Table<T> {
    fn from(rows: Vec<T>) -> Self {
        rows.into_iter().collect()
    }
}

impl<T> Deref for Table<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.rows
    }
}

impl<T> Table<T> {
    /// What a reader remembers. Reading it ends the batch: the next write begins another.
    pub fn version(&self) -> u64 {
        self.is_open.store(false, Ordering::Relaxed);
        self.version
    }

    /// What changed since the version that a reader has seen.
    pub fn changes_since(&self, seen: u64) -> Changes<'_> {
        if seen == self.version() {
            Changes::None
        } else if seen == self.previous && self.changed.len() <= self.rows.len() {
            Changes::Rows(&self.changed)
        } else {
            Changes::All
        }
    }

    /// Adds a row; its number.
    pub fn push(&mut self, row: T) -> u32 {
        let index = u32::try_from(self.rows.len()).expect("fewer than 2^32 rows");
        self.rows.push(row);
        self.note(index);
        index
    }

    /// Writes a row whether or not it is equal: for rows that cannot be compared.
    pub fn replace(&mut self, index: u32, row: T) {
        self.rows[index as usize] = row;
        self.note(index);
    }

    fn begin(&mut self) {
        *self.is_open.get_mut() = true;
        self.previous = self.version;
        self.version = LAST_VERSION.fetch_add(1, Ordering::Relaxed) + 1;
        self.changed.clear();
    }

    fn note(&mut self, index: u32) {
        if !*self.is_open.get_mut() {
            self.begin();
        }
        // One more than there are rows says that all may have changed, however long nobody reads.
        if self.changed.len() <= self.rows.len() {
            self.changed.push(index);
        }
    }
}

impl<T: PartialEq + Clone> Table<T> {
    /// Changes every row in place; those that come out equal are no change.
    pub fn edit(&mut self, mut change: impl FnMut(&mut T)) {
        for index in 0..self.rows.len() as u32 {
            let mut row = self.rows[index as usize].clone();
            change(&mut row);
            self.set(index, row);
        }
    }
}

impl<T: PartialEq> Table<T> {
    /// Writes a row; an equal one is no change. Whether it was one.
    pub fn set(&mut self, index: u32, row: T) -> bool {
        if self.rows[index as usize] == row {
            return false;
        }
        self.replace(index, row);
        true
    }

    /// Makes the table these rows; equal ones are no change.
    pub fn assign(&mut self, rows: impl IntoIterator<Item = T>) {
        let before = self.rows.len();
        let mut count = 0;
        for row in rows {
            if count < before {
                self.set(count as u32, row);
            } else {
                self.push(row);
            }
            count += 1;
        }
        if count < before {
            self.rows.truncate(count);
            // Told of rows alone, a reader would keep the old end.
            self.begin();
            self.previous = self.version;
            self.changed = vec![0; self.rows.len() + 1];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reader_is_told_what_it_has_not_seen() {
        let mut table = Table::from(vec![1, 2, 3]);
        let new = 0;
        assert_eq!(table.changes_since(new), Changes::Rows(&[0, 1, 2]));
        let other = Table::from(vec![4, 5, 6]);
        assert_eq!(other.changes_since(table.version()), Changes::All);
        let seen = table.version();
        assert_eq!(table.changes_since(seen), Changes::None);
        assert!(!table.set(1, 2), "an equal value is no change");
        assert_eq!(table.changes_since(seen), Changes::None);
        table.set(1, 20);
        table.set(2, 30);
        assert_eq!(table.changes_since(seen), Changes::Rows(&[1, 2]));
        let newer = table.version();
        table.push(4);
        assert_eq!(table.changes_since(seen), Changes::All, "two behind");
        assert_eq!(table.changes_since(newer), Changes::Rows(&[3]));
    }

    #[test]
    fn a_shorter_table_is_read_anew() {
        let mut table = Table::from(vec![1, 2, 3]);
        let seen = table.version();
        table.assign([1, 2]);
        assert_eq!(*table, [1, 2]);
        assert_eq!(table.changes_since(seen), Changes::All);
        let seen = table.version();
        table.assign([1, 2]);
        assert_eq!(table.changes_since(seen), Changes::None);
    }
}
