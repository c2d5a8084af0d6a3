//! Sixteen rays of a packet in lanes.

use glam::Vec3;

use super::query::{Found, Key, Probe, Start};
use super::simd::{Floats, LANES, Mask, Row, Simd};
use super::traverse::reach;
use crate::frame::wire::NONE;

/// Sixteen rays, and the best hit of each.
#[repr(align(64))]
#[derive(Clone)]
pub struct Group {
    /// Starts, by axis.
    pub origin: [Row; 3],
    /// Directions, by axis.
    pub dir: [Row; 3],
    /// Lower ends, exclusive.
    pub after: Row,
    /// Distances of the best hits so far, or upper ends.
    pub t: Row,
    /// Their instances, bits.
    pub id: Row,
    /// Their primitives, bits.
    pub prim: Row,
    /// [`Found::triangle`], bits.
    pub triangle: Row,
    /// [`Found::uv`].
    pub uv: [Row; 2],
    /// [`Start::id`] of each.
    pub start_id: [u32; LANES],
    /// [`Start::prim`] of each.
    pub start_prim: [u32; LANES],
    /// Some ray starts on something.
    pub has_starts: bool,
    /// Lanes whose search is not over.
    pub active: Mask,
    /// Lanes that have a hit.
    pub hit: Mask,
}

impl Group {
    /// No rays.
    pub const EMPTY: Self = Self {
        origin: [[0.0; LANES]; 3],
        dir: [[1.0; LANES]; 3],
        after: [0.0; LANES],
        t: [0.0; LANES],
        id: [0.0; LANES],
        prim: [0.0; LANES],
        triangle: [0.0; LANES],
        uv: [[0.0; LANES]; 2],
        start_id: [NONE; LANES],
        start_prim: [NONE; LANES],
        has_starts: false,
        active: 0,
        hit: 0,
    };

    /// Puts a ray into a lane.
    pub fn set(&mut self, lane: usize, probe: &Probe) {
        for axis in 0..3 {
            self.origin[axis][lane] = probe.origin[axis];
            self.dir[axis][lane] = probe.dir[axis];
        }
        self.after[lane] = probe.after.t;
        self.t[lane] = probe.before.t;
        self.id[lane] = f32::from_bits(probe.before.id);
        self.prim[lane] = f32::from_bits(probe.before.prim);
        self.start_id[lane] = probe.start.id;
        self.start_prim[lane] = probe.start.prim;
        self.has_starts |= probe.start != Start::FREE;
    }

    /// The key of the best hit of a lane, or its upper end.
    pub fn key(&self, lane: usize) -> Key {
        Key {
            t: self.t[lane],
            id: self.id[lane].to_bits(),
            prim: self.prim[lane].to_bits(),
        }
    }

    /// The best hit of a lane that has one.
    pub fn found(&self, lane: usize) -> Found {
        Found {
            key: self.key(lane),
            triangle: self.triangle[lane].to_bits(),
            uv: self.uv.map(|row| row[lane]),
        }
    }

    /// Gives a lane a better hit.
    pub fn take(&mut self, lane: usize, found: &Found) {
        self.t[lane] = found.key.t;
        self.id[lane] = f32::from_bits(found.key.id);
        self.prim[lane] = f32::from_bits(found.key.prim);
        self.triangle[lane] = f32::from_bits(found.triangle);
        self.uv[0][lane] = found.uv[0];
        self.uv[1][lane] = found.uv[1];
        self.hit |= 1 << lane;
    }

    /// A ray by itself, and the best that it has.
    pub fn probe(&self, lane: usize) -> Probe {
        let of = |rows: &[Row; 3]| Vec3::from(rows.each_ref().map(|row| row[lane]));
        Probe {
            origin: of(&self.origin),
            dir: of(&self.dir),
            after: Key::after(self.after[lane]),
            before: self.key(lane),
            start: Start {
                id: self.start_id[lane],
                prim: self.start_prim[lane],
            },
        }
    }

    /// How far boxes may begin for any lane to have something in them.
    #[inline(always)]
    pub fn reach<S: Simd>(&self, simd: S) -> f32 {
        if self.active == 0 {
            return f32::NEG_INFINITY;
        }
        let mut t = self.t;
        simd.splat(f32::NEG_INFINITY)
            .store_where(!self.active, &mut t);
        reach(simd.load(&t).greatest())
    }
}
