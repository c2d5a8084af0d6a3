//! Frames as a window runs them: the host is ahead of the device by no more pictures than a swap chain holds.

use std::collections::VecDeque;
use std::sync::Arc;

use orrery_engine::trace::TraceError;
use orrery_engine::trace::gpu::Gpu;

/// Pictures under way beside the one that is being made: what windows ask of the display.
const AHEAD: usize = 2;

/// Holds the host back where a window's display would. Without a device there is nothing to wait for.
pub struct Flight {
    gpu: Option<Arc<Gpu>>,
    ends: VecDeque<wgpu::SubmissionIndex>,
}

impl Flight {
    /// Nothing is under way.
    pub fn new(gpu: Option<Arc<Gpu>>) -> Self {
        Self {
            gpu,
            ends: VecDeque::new(),
        }
    }

    /// A frame has been submitted; waits for the one that is too far behind it.
    ///
    /// # Errors
    /// [`TraceError::Device`].
    pub fn submitted(&mut self) -> Result<(), TraceError> {
        let Some(gpu) = &self.gpu else {
            return Ok(());
        };
        // Empty, and behind all that the frame submitted.
        self.ends.push_back(gpu.queue.submit([]));
        while self.ends.len() > AHEAD {
            let oldest = self.ends.pop_front();
            let waited = gpu.device.poll(wgpu::PollType::Wait {
                submission_index: oldest,
                timeout: None,
            });
            waited.map_err(|error| TraceError::Device(error.to_string()))?;
        }
        Ok(())
    }
}
