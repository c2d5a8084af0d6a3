//! Buffers that grow with what is put into them, are not written what they already hold, and come back.

use std::sync::mpsc;
use std::time::Duration;

use super::context::Gpu;
use crate::trace::{TraceError, Upload};

/// How long a callback may take to run once its work is done.
const PATIENCE: Duration = Duration::from_secs(20);

/// Rows on the device.
pub struct RowBuffer {
    label: &'static str,
    usage: wgpu::BufferUsages,
    /// Bytes of a row.
    row: u64,
    buffer: wgpu::Buffer,
    /// Bytes written since [`RowBuffer::take_written`].
    written: u64,
    /// What the last [`RowBuffer::write_changed`] left there, and where.
    known: Option<(u64, Vec<u8>)>,
}

impl RowBuffer {
    /// Room for one row of `size` bytes, so that it can be bound, all zero.
    pub fn new(gpu: &Gpu, label: &'static str, usage: wgpu::BufferUsages, size: u64) -> Self {
        let usage = usage | wgpu::BufferUsages::COPY_DST;
        Self {
            label,
            usage,
            row: size,
            buffer: create(gpu, label, usage, size),
            written: 0,
            known: None,
        }
    }

    /// The buffer as of now; another one after growth.
    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    /// Makes room; true: in another buffer, which holds nothing yet.
    ///
    /// # Errors
    /// [`TraceError::TooLarge`] beyond what the device binds.
    pub fn reserve(&mut self, gpu: &Gpu, size: u64) -> Result<bool, TraceError> {
        if size <= self.buffer.size() {
            return Ok(false);
        }
        let (most, limit) = gpu.most_bound();
        if size > most {
            return Err(TraceError::TooLarge(format!(
                "the scene's {} take {size} bytes (room for {}); {} binds at most {most} ({limit})",
                self.label,
                size.div_ceil(self.row),
                gpu.describe()
            )));
        }
        // Half as much again, so that a scene that grows step by step does not move each time.
        let roomy = (size + size / 2).next_multiple_of(16).min(most);
        self.buffer = create(gpu, self.label, self.usage, roomy);
        self.known = None;
        Ok(true)
    }

    /// What was written since the last call.
    pub fn take_written(&mut self) -> Upload {
        Upload {
            buffer: self.label,
            bytes: std::mem::take(&mut self.written),
        }
    }

    /// Writes; returns the bytes written.
    pub fn write(&mut self, gpu: &Gpu, offset: u64, bytes: &[u8]) -> u64 {
        if !bytes.is_empty() {
            gpu.queue.write_buffer(&self.buffer, offset, bytes);
        }
        self.written += bytes.len() as u64;
        bytes.len() as u64
    }

    /// Writes unless the last call wrote the same; returns the bytes written.
    pub fn write_changed(&mut self, gpu: &Gpu, offset: u64, bytes: &[u8]) -> u64 {
        if self
            .known
            .as_ref()
            .is_some_and(|(at, known)| *at == offset && known == bytes)
        {
            return 0;
        }
        let mut kept = self.known.take().map_or_else(Vec::new, |(_, kept)| kept);
        kept.clear();
        kept.extend_from_slice(bytes);
        self.known = Some((offset, kept));
        self.write(gpu, offset, bytes)
    }
}

/// A buffer on the device.
pub fn create(gpu: &Gpu, label: &str, usage: wgpu::BufferUsages, size: u64) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage,
        mapped_at_creation: false,
    })
}

/// Waits for everything submitted, and reads a buffer made with `MAP_READ`; it is unmapped again.
///
/// # Errors
/// [`TraceError::Device`].
pub fn read(gpu: &Gpu, buffer: &wgpu::Buffer) -> Result<Vec<u8>, TraceError> {
    let (answer, answered) = mpsc::channel();
    buffer.map_async(wgpu::MapMode::Read, .., move |result| {
        // The receiver is only gone if the wait below failed, which says so itself.
        let _ = answer.send(result);
    });
    let lost = |why: String| TraceError::Device(format!("the GPU's answer did not come: {why}"));
    let waited = gpu.device.poll(wgpu::PollType::wait_indefinitely());
    gpu.check()?;
    waited.map_err(|error| lost(error.to_string()))?;
    // All work is done, but another thread's poll may have taken our callback and be about to run it.
    match answered.recv_timeout(PATIENCE) {
        Ok(Ok(())) => {}
        Ok(Err(error)) => return Err(lost(error.to_string())),
        Err(error) => return Err(lost(error.to_string())),
    }
    let bytes = buffer
        .get_mapped_range(..)
        .map_err(|error| lost(error.to_string()))?
        .to_vec();
    buffer.unmap();
    Ok(bytes)
}
