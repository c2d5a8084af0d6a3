//! Frames as a window runs them: the host is ahead of the device by no more pictures than a swap chain holds.

use std::collections::VecDeque;
use std::sync::Arc;

use orrery_engine::trace::gpu::{AdapterChoice, Gpu};
use orrery_engine::trace::{TraceError, Tracer, open_tracer};

use crate::args::{BackendChoice, Common};
use crate::device;
use crate::failure::Failure;

/// Pictures under way beside the one that is being made: what windows ask of the display.
const AHEAD: usize = 2;

/// A tracer, and its device where it has one.
///
/// # Errors
/// [`Failure::NoDevice`].
pub fn open(
    choice: BackendChoice,
    common: &Common,
) -> Result<(Box<dyn Tracer>, Option<Arc<Gpu>>), Failure> {
    if choice != BackendChoice::Gpu {
        return Ok((device::open_choice(choice, common)?, None));
    }
    let named = common.adapter.clone().map(AdapterChoice::Named);
    let which = named.unwrap_or(AdapterChoice::Any);
    let gpu = Arc::new(Gpu::open(Gpu::instance(), &which, None)?);
    let (tracer, _) = open_tracer(device::wanted(choice), None, Some(Arc::clone(&gpu)))?;
    Ok((tracer, Some(gpu)))
}

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
        if let Some(gpu) = &self.gpu {
            // Empty, and behind all that the frame submitted.
            self.ends.push_back(gpu.queue.submit([]));
        }
        self.wait_but_for(AHEAD)
    }

    /// Waits for all that is under way.
    ///
    /// # Errors
    /// [`TraceError::Device`].
    pub fn land(&mut self) -> Result<(), TraceError> {
        self.wait_but_for(0)
    }

    fn wait_but_for(&mut self, most: usize) -> Result<(), TraceError> {
        let Some(gpu) = &self.gpu else {
            return Ok(());
        };
        while self.ends.len() > most {
            let waited = gpu.device.poll(wgpu::PollType::Wait {
                submission_index: self.ends.pop_front(),
                timeout: None,
            });
            waited.map_err(|error| TraceError::Device(error.to_string()))?;
        }
        Ok(())
    }
}
