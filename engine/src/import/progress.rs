//! How far loading is, for a bar or a title: written by whoever loads, read from another thread.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Where loading is.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Step {
    /// What was begun last, as a title says it.
    pub what: String,
    /// Parts of the whole that are done.
    pub done: usize,
    /// Parts of the whole as far as they are known.
    pub count: usize,
    /// Models that the cache had.
    pub found: usize,
}

/// How far a load is; clones tell of the same.
#[derive(Clone, Debug, Default)]
pub struct Progress(Arc<Mutex<Step>>);

impl Progress {
    /// Where it is now.
    pub fn now(&self) -> Step {
        self.lock().clone()
    }

    /// Names what is done from now on.
    pub(super) fn begin(&self, what: String) {
        self.lock().what = what;
    }

    /// Adds parts that are to be done.
    pub(super) fn expect(&self, count: usize) {
        self.lock().count += count;
    }

    /// Takes note that a part is done.
    pub(super) fn advance(&self) {
        self.lock().done += 1;
    }

    /// Takes note that the cache had a model.
    pub(super) fn find(&self) {
        self.lock().found += 1;
    }

    fn lock(&self) -> MutexGuard<'_, Step> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
