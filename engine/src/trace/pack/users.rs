//! Which rows show a mesh, for when it is deformed or replaced: they are packed again, and no others looked at.
//!
//! A row that stops showing a mesh is not searched for: it stays named until so many are out of date that all
//! rows are counted again. So some rows may show another mesh by now, or are not there, and some are named twice.

use crate::frame::wire::{InstanceRow, NONE};

/// See the module.
#[derive(Default)]
pub struct Users {
    of_mesh: Vec<Vec<u32>>,
    noted: usize,
}

impl Users {
    /// Rows that may show a mesh.
    pub fn of(&self, mesh: u32) -> &[u32] {
        self.of_mesh.get(mesh as usize).map_or(&[], Vec::as_slice)
    }

    /// Notes what a row shows now; what it showed before is left for the next count.
    pub fn note(&mut self, row: u32, rows: &[InstanceRow]) {
        if self.noted > 2 * rows.len() + 1024 {
            return self.count(rows);
        }
        let mesh = rows[row as usize].mesh;
        if mesh != NONE {
            if mesh as usize >= self.of_mesh.len() {
                self.of_mesh.resize_with(mesh as usize + 1, Vec::new);
            }
            self.of_mesh[mesh as usize].push(row);
            self.noted += 1;
        }
    }

    /// Notes what all rows show, and nothing else.
    pub fn count(&mut self, rows: &[InstanceRow]) {
        self.of_mesh.iter_mut().for_each(Vec::clear);
        self.noted = 0;
        (0..rows.len() as u32).for_each(|row| self.note(row, rows));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::pack::instance::NOTHING;

    #[test]
    fn whoever_shows_a_mesh_is_named_and_the_list_stays_short() {
        let mut state = 5_u32;
        let mut below = |n: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) % n
        };
        let mut rows = vec![NOTHING.0; 40];
        let mut users = Users::default();
        for _ in 0..20_000 {
            let row = below(40);
            rows[row as usize].mesh = match below(6) {
                5 => NONE,
                mesh => mesh,
            };
            users.note(row, &rows);
            for (row, packed) in (0..).zip(&rows).filter(|(_, packed)| packed.mesh != NONE) {
                assert!(
                    users.of(packed.mesh).contains(&row),
                    "row {row} is forgotten"
                );
            }
        }
        assert!(users.noted <= 2 * rows.len() + 1025);
    }
}
