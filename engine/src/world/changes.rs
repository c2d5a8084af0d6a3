//! Change, a table at a time: whether any component of a kind changed, and writing those that come out other.

use bevy_ecs::change_detection::{ContiguousMut, ContiguousRef, Tick};
use bevy_ecs::prelude::*;
use bevy_ecs::query::ArchetypeFilter;
use rayon::prelude::*;

/// Rows of a table that are worth a task of their own: some 20 microseconds of work.
const PARALLEL: usize = 1024;

/// Whether a component changed since the system last ran: by the summary tick of each table where the component
/// keeps one, else by the ticks of its rows.
pub fn any_changed<T: Component, F: ArchetypeFilter>(query: &Query<Ref<T>, F>) -> bool {
    let Ok(mut tables) = query.contiguous_iter() else {
        return query.iter().any(|component| component.is_changed());
    };
    tables.any(|table| {
        let (_, ticks) = ContiguousRef::split(table);
        ticks
            .summary_tick_is_changed()
            .unwrap_or_else(|| ticks.is_changed_iter().any(|changed| changed))
    })
}

/// Writes the rows of a table for which there is a value and it is another one; equal ones are no change.
pub fn write_rows<T: Component + PartialEq + Send>(
    rows: ContiguousMut<T>,
    value: impl Fn(usize) -> Option<T> + Sync,
) {
    let (values, mut ticks) = ContiguousMut::bypass_change_detection_split(rows);
    let this_run = ticks.this_run();
    let write = |(chunk, (values, changed)): (usize, (&mut [T], &mut [Tick]))| {
        let first = chunk * PARALLEL;
        let mut written = None;
        for (i, (old, tick)) in values.iter_mut().zip(changed).enumerate() {
            if let Some(new) = value(first + i).filter(|new| new != old) {
                *old = new;
                *tick = this_run;
                written = Some(first + i);
            }
        }
        written
    };
    let changed = ticks.changed_mut();
    let written = if values.len() <= PARALLEL {
        write((0, (values, changed)))
    } else {
        let chunks = values.par_chunks_mut(PARALLEL);
        let chunks = chunks.zip(changed.par_chunks_mut(PARALLEL)).enumerate();
        chunks.filter_map(write).max()
    };
    if let Some(row) = written {
        // One row stands for all in what the table says of itself (its summary tick).
        let row = row as u32;
        ticks.slice(row..row + 1).mark_all_as_changed();
    }
}
