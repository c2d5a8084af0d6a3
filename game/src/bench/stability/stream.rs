//! Any number of rays through a tracer's ray buffers: while a batch is traced, the next one is made and the last
//! one judged, on all cores.

use std::panic::resume_unwind;
use std::thread;
use std::time::Instant;

use orrery_engine::trace::{Hit, Query, Ray, Tracer};
use rayon::prelude::*;

use super::tally::{Tally, Verdict};
use crate::failure::Failure;
use crate::output::progress;

/// Most rays of a batch.
const MOST: u64 = 1 << 21;
/// Least, so that there is something to share out.
const LEAST: u64 = 1 << 12;
/// Rays that one task makes or judges.
const CHUNK: usize = 1 << 12;

/// Rays that belong together: `1`, or the pairs of [`Query::Leave`].
pub struct Stream<'a, M, J> {
    /// What is said while it runs.
    pub label: &'a str,
    /// How many groups of rays.
    pub count: u64,
    /// What is asked.
    pub query: Query,
    /// Writes the rays of a group.
    pub make: M,
    /// Says what the hits of a group are worth.
    pub judge: J,
}

/// A batch that has come back.
struct Batch {
    first: u64,
    rays: Vec<Ray>,
    hits: Vec<Hit>,
}

impl<M, J> Stream<'_, M, J>
where
    M: Fn(u64, &mut [Ray]) + Sync,
    J: Fn(u64, &[Ray], &[Hit]) -> Verdict + Sync,
{
    /// Rays a group.
    fn group(&self) -> usize {
        match self.query {
            Query::Leave => 2,
            Query::Closest | Query::Any => 1,
        }
    }

    /// Runs them all against the frame that was uploaded.
    ///
    /// # Errors
    /// Those of the tracer.
    pub fn run(&self, tracer: &mut dyn Tracer) -> Result<Tally, Failure> {
        let start = Instant::now();
        let step = (self.count / 4).clamp(LEAST, MOST / self.group() as u64);
        let bar = progress(self.count, self.label);
        let mut tally = Tally::default();
        let mut before: Option<Batch> = None;
        let mut rays = self.rays(0, step);
        let mut first = 0;
        while first < self.count {
            let last = before.take();
            let (hits, next, judged) = thread::scope(|scope| {
                let beside = scope.spawn(|| {
                    let judged = last.as_ref().map(|batch| self.judged(batch));
                    (self.rays(first + step, step), judged)
                });
                let hits = tracer.intersect(&rays, self.query);
                match beside.join() {
                    Ok((next, judged)) => (hits, next, judged),
                    Err(panic) => resume_unwind(panic),
                }
            });
            tally.extend(judged);
            let traced = std::mem::replace(&mut rays, next);
            before = Some(Batch {
                first,
                rays: traced,
                hits: hits?,
            });
            first += step;
            bar.set_position(first.min(self.count));
        }
        tally.extend(before.map(|batch| self.judged(&batch)));
        tally.secs = start.elapsed().as_secs_f64();
        bar.finish_and_clear();
        Ok(tally)
    }

    fn rays(&self, first: u64, step: u64) -> Vec<Ray> {
        let count = self.count.saturating_sub(first).min(step) as usize;
        let nothing = Ray {
            origin: glam::Vec3::ZERO,
            dir: glam::Vec3::Z,
            t_min: 0.0,
            t_max: f32::MAX,
        };
        let group = self.group();
        let mut rays = vec![nothing; count * group];
        rays.par_chunks_mut(group)
            .with_min_len(CHUNK)
            .enumerate()
            .for_each(|(i, rays)| (self.make)(first + i as u64, rays));
        rays
    }

    fn judged(&self, batch: &Batch) -> Tally {
        let group = self.group();
        let rays = batch.rays.par_chunks(group * CHUNK);
        let hits = batch.hits.par_chunks(group * CHUNK);
        rays.zip(hits)
            .enumerate()
            .map(|(chunk, (rays, hits))| {
                let mut tally = Tally::default();
                let groups = rays.chunks(group).zip(hits.chunks(group));
                for (i, (rays, hits)) in groups.enumerate() {
                    let index = batch.first + (chunk * CHUNK + i) as u64;
                    tally.take((self.judge)(index, rays, hits));
                }
                tally
            })
            .reduce(Tally::default, Tally::with)
    }
}
