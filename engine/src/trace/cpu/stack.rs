//! What a traversal has still to visit.

use glam::Vec4;

use super::simd::{Instructions, prefetch};
use crate::bvh::{CHILD_LEAF, LEAF_FIRST_MASK, Node4, TRAVERSAL_CAPACITY};
use crate::trace::pack::{Block, Node8};

/// Entries that are there: those that two levels of trees may need, and those that are written and do not count.
const ROOM: usize = TRAVERSAL_CAPACITY as usize + 8;

/// Nodes still to visit and the distance at which a ray enters them. Kept from ray to ray.
pub struct Stack {
    /// What rays are traced by.
    pub instructions: Instructions,
    /// Bits of the distances at which nodes are entered, above what the nodes are; some are written that
    /// do not count.
    entries: [i64; ROOM],
    /// How many there are.
    pub len: usize,
}

impl Default for Stack {
    fn default() -> Self {
        Self::with(Instructions::default())
    }
}

impl Stack {
    /// Of rays that are traced by these.
    pub fn with(instructions: Instructions) -> Self {
        Self {
            instructions,
            entries: [0; ROOM],
            len: 0,
        }
    }

    /// Has the memory brought near of the nodes that were pushed since there were so many.
    #[inline(always)]
    pub fn ask_for(&self, since: usize, nodes: &[Node4]) {
        for entry in self.entries.get(since..self.len).unwrap_or_default() {
            // Leaves have numbers beyond those of nodes.
            if let Some(node) = nodes.get(*entry as u32 as usize) {
                prefetch(node);
            }
        }
    }

    /// The same of nodes of eight, and of the triangles of leaves.
    #[inline(always)]
    pub fn ask_for_eights(&self, since: usize, nodes: &[Node8], blocks: &[Block]) {
        for entry in self.entries.get(since..self.len).unwrap_or_default() {
            let child = *entry as u32;
            if child & CHILD_LEAF == 0 {
                if let Some(node) = nodes.get(child as usize) {
                    prefetch(node);
                }
            } else if let Some(block) = blocks.get((child & LEAF_FIRST_MASK) as usize) {
                prefetch(block);
            }
        }
    }

    /// Takes the last: a node and where it is entered.
    #[inline(always)]
    pub fn pop(&mut self) -> (u32, f32) {
        self.len -= 1;
        let entry = self.entries[self.len];
        (entry as u32, f32::from_bits((entry >> 32) as u32))
    }

    /// Pushes the children a ray enters at `near`, farthest first, but for the nearest, which is returned. More than two are
    /// sorted by a network: which come first is what no processor can guess.
    #[inline(always)]
    pub fn push_entered(&mut self, node: &Node4, near: Vec4, entered: u32) -> Option<u32> {
        if entered == 0 {
            return None;
        }
        let near = near.to_array();
        let first = entered.trailing_zeros() as usize & 3;
        let others = entered & (entered - 1);
        if others == 0 {
            return Some(node.children[first]);
        }
        if others & (others - 1) == 0 {
            let second = others.trailing_zeros() as usize & 3;
            let (closer, farther) = if near[second] < near[first] {
                (second, first)
            } else {
                (first, second)
            };
            self.entries[self.len] = entry(node.children[farther], near[farther]);
            self.len += 1;
            return Some(node.children[closer]);
        }
        let of = |slot: usize| match entered & (1 << slot) {
            0 => i64::MIN,
            _ => entry(node.children[slot], near[slot]),
        };
        let (a, b, c, d) = (of(0), of(1), of(2), of(3));
        let (a, b, c, d) = (a.max(b), a.min(b), c.max(d), c.min(d));
        let (a, c, b, d) = (a.max(c), a.min(c), b.max(d), b.min(d));
        let (b, c) = (b.max(c), b.min(c));
        if let Some(places) = self.entries.get_mut(self.len..self.len + 3) {
            places.copy_from_slice(&[a, b, c]);
        }
        if others.count_ones() == 2 {
            self.len += 2;
            return Some(c as u32);
        }
        self.len += 3;
        Some(d as u32)
    }

    /// The same of a node's eight, of which some are entered.
    #[inline(always)]
    pub fn push_nearest_of(&mut self, children: &[u32; 8], near: &[f32; 8], entered: u32) -> u32 {
        let (a, rest) = lowest(children, near, entered);
        if rest == 0 {
            return a as u32;
        }
        let (b, rest) = lowest(children, near, rest);
        let (a, b) = (a.max(b), a.min(b));
        let Some(places) = self.entries.get_mut(self.len..self.len + 8) else {
            unreachable!("trees need no more than there is");
        };
        places[0] = a;
        if rest == 0 {
            self.len += 1;
            return b as u32;
        }
        let (c, rest) = lowest(children, near, rest);
        // Of three, farthest first.
        let (b, c) = (b.max(c), b.min(c));
        let (a, b) = (a.max(b), a.min(b));
        places[0] = a;
        places[1] = b;
        if rest == 0 {
            self.len += 2;
            return c as u32;
        }
        let (d, mut rest) = lowest(children, near, rest);
        let (c, d) = (c.max(d), c.min(d));
        let (b, c) = (b.max(c), b.min(c));
        let (a, b) = (a.max(b), a.min(b));
        places[..4].copy_from_slice(&[a, b, c, d]);
        let mut count = 4;
        while rest != 0 {
            let (one, left) = lowest(children, near, rest);
            rest = left;
            let mut place = count & 7;
            count += 1;
            while place > 0 && places[place - 1] < one {
                places[place] = places[place - 1];
                place -= 1;
            }
            places[place] = one;
        }
        self.len += count - 1;
        places[(count - 1) & 7] as u32
    }

    /// The same in no order.
    #[inline(always)]
    pub fn push_any_of(&mut self, children: &[u32; 8], entered: u32) -> u32 {
        let first = children[entered.trailing_zeros() as usize & 7];
        let mut rest = entered & (entered - 1);
        while rest != 0 {
            self.entries[self.len] = i64::from(children[rest.trailing_zeros() as usize & 7]);
            self.len += 1;
            rest &= rest - 1;
        }
        first
    }
}

/// The entry of the lowest of some slots, and the others.
#[inline(always)]
fn lowest(children: &[u32; 8], near: &[f32; 8], slots: u32) -> (i64, u32) {
    let slot = slots.trailing_zeros() as usize & 7;
    (entry(children[slot], near[slot]), slots & (slots - 1))
}

/// Of numbers that are not negative, the order is that of their bits; others are only looked at in another order.
#[inline(always)]
fn entry(child: u32, near: f32) -> i64 {
    i64::from(near.to_bits() as i32) << 32 | i64::from(child)
}

/// Puts an entry among those from `base` on, the nearest last.
#[inline(always)]
pub fn push_nearest_last<E: Copy>(
    entries: &mut [E],
    base: usize,
    len: &mut usize,
    entry: E,
    near: impl Fn(&E) -> f32,
) {
    let mut place = *len;
    while place > base && near(&entries[place - 1]) < near(&entry) {
        entries[place] = entries[place - 1];
        place -= 1;
    }
    entries[place] = entry;
    *len += 1;
}
