//! Samples by the wall clock, and pools of one thread and of all.

use std::time::Instant;

use rayon::{ThreadPool, ThreadPoolBuilder};

use super::report::{Better, Row};
use crate::failure::Failure;

/// Milliseconds of each of `count` runs after `warm_up` that do not count; a run gets its number.
pub fn millis(warm_up: usize, count: usize, mut run: impl FnMut(usize)) -> Vec<f64> {
    let mut samples = Vec::with_capacity(count);
    for i in 0..warm_up + count {
        let start = Instant::now();
        run(i);
        if i >= warm_up {
            samples.push(start.elapsed().as_secs_f64() * 1e3);
        }
    }
    samples
}

/// Seconds that all threads of this program have worked, waiting for a processor aside; none where the system does not say.
pub fn worked_seconds() -> Option<f64> {
    let threads = std::fs::read_dir("/proc/self/task").ok()?;
    let nanos = threads.map(|thread| {
        let text = std::fs::read_to_string(thread.ok()?.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<u64>().ok()
    });
    Some(nanos.flatten().sum::<u64>() as f64 * 1e-9)
}

/// The median of samples; 0 of none.
pub fn median(samples: &[f64]) -> f64 {
    Row::sampled("", "", Better::Lower, samples).value
}

/// A row of milliseconds.
pub fn millis_row(name: String, samples: &[f64]) -> Row {
    Row::sampled(name, "ms", Better::Lower, samples)
}

/// A count that must be 0: the proof beside the times.
pub fn zero_row(name: String, unit: &'static str, count: u64) -> Row {
    Row::single(name, unit, Better::Lower, count as f64).with_target(0.0)
}

/// A pool of one thread, and one of all where there are more.
///
/// # Errors
/// [`Failure::NoDevice`] if threads cannot be made.
pub fn pools() -> Result<Vec<ThreadPool>, Failure> {
    let all = rayon::current_num_threads();
    let mut counts = vec![1, all];
    counts.dedup();
    counts.into_iter().map(pool_of).collect()
}

/// A pool of so many threads.
///
/// # Errors
/// [`Failure::NoDevice`] if threads cannot be made.
pub fn pool_of(threads: usize) -> Result<ThreadPool, Failure> {
    ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|error| Failure::NoDevice(format!("no pool of {threads} threads: {error}")))
}
