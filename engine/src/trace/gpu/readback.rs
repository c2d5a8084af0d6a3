//! Small answers of the device, back on the host without waiting for them.
//!
//! A few buffers take turns: an answer is copied into a free one and mapped when the GPU gets there. If none
//! is free, there is no answer.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use super::buffers::create;
use super::context::Gpu;

/// Answers under way at once: frames in flight, and one to spare.
pub const SLOTS: usize = 4;

const FREE: u8 = 0;
const PENDING: u8 = 1;
const READY: u8 = 2;
const FAILED: u8 = 3;

/// The buffers.
pub struct Readback {
    slots: Vec<Slot>,
}

struct Slot {
    buffer: wgpu::Buffer,
    state: Arc<AtomicU8>,
}

impl Readback {
    /// For answers of `size` bytes.
    pub fn new(gpu: &Gpu, label: &str, size: u64) -> Self {
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let slot = || Slot {
            buffer: create(gpu, label, usage, size),
            state: Arc::new(AtomicU8::new(FREE)),
        };
        Self {
            slots: (0..SLOTS).map(|_| slot()).collect(),
        }
    }

    /// A buffer that waits for an answer, if there is one.
    pub fn free(&self) -> Option<usize> {
        let free = |slot: &Slot| slot.state.load(Ordering::Acquire) == FREE;
        self.slots.iter().position(free)
    }

    /// Where to copy the answer to.
    pub fn buffer(&self, index: usize) -> &wgpu::Buffer {
        &self.slots[index].buffer
    }

    /// Asks for an answer whose copy is submitted.
    pub fn request(&self, index: usize) {
        let slot = &self.slots[index];
        slot.state.store(PENDING, Ordering::Release);
        let state = Arc::clone(&slot.state);
        slot.buffer
            .map_async(wgpu::MapMode::Read, .., move |result| {
                let outcome = if result.is_ok() { READY } else { FAILED };
                state.store(outcome, Ordering::Release);
            });
    }

    /// Whether an answer is on its way or waits to be collected.
    pub fn is_waiting(&self) -> bool {
        let taken = |slot: &Slot| slot.state.load(Ordering::Acquire) != FREE;
        self.slots.iter().any(taken)
    }

    /// Calls `take` with the buffer and the bytes of each answer that has come back since the last call.
    pub fn collect(&self, mut take: impl FnMut(usize, &[u8])) {
        for (index, slot) in self.slots.iter().enumerate() {
            match slot.state.load(Ordering::Acquire) {
                READY => {
                    if let Ok(bytes) = slot.buffer.get_mapped_range(..) {
                        take(index, &bytes);
                    }
                    slot.buffer.unmap();
                    slot.state.store(FREE, Ordering::Release);
                }
                FAILED => slot.state.store(FREE, Ordering::Release),
                _ => {}
            }
        }
    }
}
