//! What a traversal has still to visit.

use glam::Vec4;

use super::simd::{Instructions, prefetch};
use crate::bvh::{Node4, TRAVERSAL_CAPACITY};

/// Nodes still to visit and the distance at which a ray enters them. Kept from ray to ray.
pub struct Stack {
    /// What serves packets.
    pub instructions: Instructions,
    /// Distances at which nodes are entered, as [`order`] has them, above what the nodes are; where three of a
    /// node's children are entered, three are written and two count.
    entries: [i64; TRAVERSAL_CAPACITY as usize + 4],
    /// How many there are.
    pub len: usize,
}

impl Default for Stack {
    fn default() -> Self {
        Self::with(Instructions::default())
    }
}

impl Stack {
    /// Of rays that go in packets by these.
    pub fn with(instructions: Instructions) -> Self {
        Self {
            instructions,
            entries: [0; TRAVERSAL_CAPACITY as usize + 4],
            len: 0,
        }
    }
}

impl Stack {
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

    /// Takes the last: a node and where it is entered.
    #[inline(always)]
    pub fn pop(&mut self) -> (u32, f32) {
        self.len -= 1;
        let entry = self.entries[self.len];
        (entry as u32, f32::from_bits(order((entry >> 32) as u32)))
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
}

#[inline(always)]
fn entry(child: u32, near: f32) -> i64 {
    i64::from(order(near.to_bits()) as i32) << 32 | i64::from(child)
}

/// The bits of a number, in an order that is that of whole numbers with a sign; and back.
#[inline(always)]
fn order(bits: u32) -> u32 {
    bits ^ (((bits as i32) >> 31) as u32 >> 1)
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
