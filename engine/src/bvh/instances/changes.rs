//! Which rows of a tree over instances moved, came and went.
//!
//! [`super::InstanceTree::update`] sorts them once a frame, before it chooses what to do about them.

use crate::bvh::fast::NOWHERE;
use crate::geom::Aabb;

/// Rows by what becomes of them.
#[derive(Clone, Debug, Default)]
pub struct Changes {
    /// They have a place, and a box still.
    pub moved: Vec<u32>,
    /// They have a box and no place yet; once each, in order.
    pub came: Vec<u32>,
    /// They have a place and no box any more; once each, in order.
    pub went: Vec<u32>,
}

impl Changes {
    /// Takes in what has changed since rows had these places, which are extended to as many as there are boxes.
    ///
    /// `changed` are the rows to look at, `None`: all of them; those past the last box are always looked at.
    pub fn sort(&mut self, places: &mut Vec<u32>, boxes: &[Aabb], changed: Option<&[u32]>) {
        let Self { moved, came, went } = self;
        moved.clear();
        came.clear();
        went.clear();
        let gone = boxes.len().min(places.len())..places.len();
        let held = gone.filter(|&row| places[row] != NOWHERE);
        went.extend(held.map(|row| row as u32));
        if places.len() < boxes.len() {
            places.resize(boxes.len(), NOWHERE);
        }
        let mut sort = |row: u32| match (
            places[row as usize] != NOWHERE,
            is_there(&boxes[row as usize]),
        ) {
            (true, true) => moved.push(row),
            (false, true) => came.push(row),
            (true, false) => went.push(row),
            (false, false) => {}
        };
        match changed {
            None => (0..boxes.len() as u32).for_each(sort),
            Some(rows) => rows.iter().for_each(|&row| sort(row)),
        }
        // A row named twice comes and goes once.
        for rows in [came, went] {
            rows.sort_unstable();
            rows.dedup();
        }
    }
}

/// Whether a box is one of a row.
pub fn is_there(bounds: &Aabb) -> bool {
    bounds.min.cmple(bounds.max).all()
}
