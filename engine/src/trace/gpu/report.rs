//! Counters and timestamps of a picture, back on the host without waiting for it.
//!
//! If too many are under way the picture goes unreported. The screen times its presenting the same way; it
//! counts nothing.

use bytemuck::pod_read_unaligned;

use super::buffers::create;
use super::context::Gpu;
use super::readback::Readback;
use crate::frame::wire::CounterRow;

const COUNTERS: u64 = size_of::<CounterRow>() as u64;
const TIMESTAMPS: u64 = 2 * size_of::<u64>() as u64;

/// What came back of a picture.
#[derive(Clone, Copy, Debug)]
pub struct Report {
    /// Its counters.
    pub counters: CounterRow,
    /// Milliseconds on the device, from first to last; none: the device has no timestamps.
    pub millis: Option<f64>,
}

/// See the module.
pub struct Reports {
    /// Where kernels count.
    pub counters: wgpu::Buffer,
    /// First and last timestamp of a picture.
    queries: Option<wgpu::QuerySet>,
    resolved: wgpu::Buffer,
    readback: Readback,
}

impl Reports {
    /// Buffers, and queries if the device has them.
    pub fn new(gpu: &Gpu) -> Self {
        use wgpu::BufferUsages as Usage;
        let timed = gpu
            .device
            .features()
            .contains(wgpu::Features::TIMESTAMP_QUERY);
        let queries = timed.then(|| {
            gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("first and last"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            })
        });
        let counting = Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST;
        Self {
            counters: create(gpu, "counters", counting, COUNTERS),
            queries,
            resolved: create(
                gpu,
                "timestamps",
                Usage::QUERY_RESOLVE | Usage::COPY_SRC,
                TIMESTAMPS,
            ),
            readback: Readback::new(gpu, "report", COUNTERS + TIMESTAMPS),
        }
    }

    /// The timestamps that a pass writes, given whether it is a picture's first and its last.
    pub fn writes(&self, first: bool, last: bool) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let query_set = self.queries.as_ref()?;
        (first || last).then_some(wgpu::ComputePassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: first.then_some(0),
            end_of_pass_write_index: last.then_some(1),
        })
    }

    /// The timestamps of a picture that is drawn by one render pass.
    pub fn render_writes(&self) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        Some(wgpu::RenderPassTimestampWrites {
            query_set: self.queries.as_ref()?,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        })
    }

    /// Records a picture's report; call [`Reports::request`] with the answer after submitting.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder) -> Option<usize> {
        let index = self.readback.free()?;
        let buffer = self.readback.buffer(index);
        encoder.copy_buffer_to_buffer(&self.counters, 0, buffer, 0, COUNTERS);
        if let Some(queries) = &self.queries {
            encoder.resolve_query_set(queries, 0..2, &self.resolved, 0);
            encoder.copy_buffer_to_buffer(&self.resolved, 0, buffer, COUNTERS, TIMESTAMPS);
        }
        Some(index)
    }

    /// Asks for a recorded and submitted report.
    pub fn request(&self, index: usize) {
        self.readback.request(index);
    }

    /// Whether a report is on its way.
    pub fn is_waiting(&self) -> bool {
        self.readback.is_waiting()
    }

    /// The newest report that has come back since the last call.
    pub fn collect(&mut self, gpu: &Gpu) -> Option<Report> {
        let mut newest: Option<(u64, Report)> = None;
        self.readback.collect(|_, bytes| {
            let (end, report) = self.parse(gpu, bytes);
            if newest.is_none_or(|(before, _)| end >= before) {
                newest = Some((end, report));
            }
        });
        newest.map(|(_, report)| report)
    }

    fn parse(&self, gpu: &Gpu, bytes: &[u8]) -> (u64, Report) {
        let (counters, times) = bytes.split_at(COUNTERS as usize);
        let [first, last]: [u64; 2] = pod_read_unaligned(times);
        let ticks = last.saturating_sub(first) as f64;
        let millis = ticks * f64::from(gpu.queue.get_timestamp_period()) * 1e-6;
        let report = Report {
            counters: pod_read_unaligned(counters),
            millis: self.queries.is_some().then_some(millis),
        };
        (last, report)
    }
}
