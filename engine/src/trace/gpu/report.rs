//! Counters and timestamps of a picture, back on the host without waiting for it.
//!
//! If too many are under way the picture goes unreported. The screen times its presenting the same way; it
//! counts nothing.

use std::time::Instant;

use bytemuck::pod_read_unaligned;
use glam::UVec2;

use super::buffers::create;
use super::context::Gpu;
use super::readback::{Readback, SLOTS};
use crate::frame::wire::CounterRow;
use crate::trace::DevicePass;

const ENTRY: u64 = size_of::<u32>() as u64;
const COUNTING: wgpu::BufferUsages = wgpu::BufferUsages::STORAGE
    .union(wgpu::BufferUsages::COPY_SRC)
    .union(wgpu::BufferUsages::COPY_DST);
/// Bytes of the counters.
pub const COUNTERS: u64 = size_of::<CounterRow>() as u64;
const TIMESTAMPS: u64 = QUERIES as u64 * size_of::<u64>() as u64;
/// Timestamps: when the picture began, when it was there, and when its edges were done too.
const QUERIES: u32 = 3;

/// What came back of a picture.
#[derive(Clone, Copy, Debug)]
pub struct Report {
    /// Its counters.
    pub counters: CounterRow,
    /// Milliseconds on the device, from first to last; none: the device has no timestamps.
    pub millis: Option<f64>,
    /// Milliseconds of the passes for edges after that; none: there were none.
    pub edges_millis: Option<f64>,
    /// What was traced.
    pub traced: Traced,
}

/// What a report is of.
#[derive(Clone, Copy, Debug, Default)]
pub struct Traced {
    /// Pixels across and down.
    pub size: UVec2,
    /// It was traced from its start; otherwise samples that refined it.
    pub is_whole: bool,
    /// Samples, those of edges aside.
    pub samples: u64,
    /// When, as the pace of dispatches counts.
    pub epoch: u64,
}

/// What of a picture is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// The picture, or that of one sample a pixel.
    Picture,
    /// The further samples of its edges.
    Edges,
}

impl Ends {
    fn query(self) -> u32 {
        match self {
            Self::Picture => 1,
            Self::Edges => 2,
        }
    }
}

/// What a device was given to do, and when: no pass of it begins earlier.
#[derive(Clone, Copy, Debug)]
pub struct Submission {
    /// The frame's number.
    pub frame: u64,
    /// Not after it was submitted.
    pub at: Instant,
}

impl Submission {
    /// A pass of it that has come back by now, with its timestamps.
    pub fn pass(self, gpu: &Gpu, name: &'static str, ticks: [u64; 2]) -> DevicePass {
        let tick = f64::from(gpu.queue.get_timestamp_period()) * 1e-3;
        DevicePass {
            name,
            submitted: self.at,
            seen: Instant::now(),
            micros: ticks.map(|ticks| ticks as f64 * tick),
        }
    }
}

/// See the module.
pub struct Reports {
    /// What the time up to the first end is called, and that up to the second.
    names: [&'static str; 2],
    /// What is under way, and what of each slot.
    submission: Option<Submission>,
    submissions: [Option<Submission>; SLOTS],
    /// Where kernels count, and behind that where they list edges.
    pub counters: wgpu::Buffer,
    /// Timestamps of a picture.
    queries: Option<wgpu::QuerySet>,
    resolved: wgpu::Buffer,
    readback: Readback,
    /// Of each report under way.
    traced: [Traced; SLOTS],
}

impl Reports {
    /// Buffers, and queries if the device has them.
    pub fn new(gpu: &Gpu, names: [&'static str; 2]) -> Self {
        use wgpu::BufferUsages as Usage;
        let timed = gpu
            .device
            .features()
            .contains(wgpu::Features::TIMESTAMP_QUERY);
        let queries = timed.then(|| {
            gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("picture"),
                ty: wgpu::QueryType::Timestamp,
                count: QUERIES,
            })
        });
        Self {
            names,
            submission: None,
            submissions: [None; SLOTS],
            counters: create(gpu, "counters", COUNTING, COUNTERS + ENTRY),
            queries,
            resolved: create(
                gpu,
                "timestamps",
                Usage::QUERY_RESOLVE | Usage::COPY_SRC,
                TIMESTAMPS,
            ),
            readback: Readback::new(gpu, "report", COUNTERS + TIMESTAMPS),
            traced: [Traced::default(); SLOTS],
        }
    }

    /// Room for a list of so many pixels behind the counters, in another buffer if need be.
    pub fn make_room(&mut self, gpu: &Gpu, entries: u64) {
        let size = COUNTERS + entries * ENTRY;
        if size > self.counters.size() {
            self.counters = create(gpu, "counters and edges", COUNTING, size);
        }
    }

    /// The timestamps that a pass writes, given whether it is a picture's first, and the last of which kind.
    pub fn writes(
        &self,
        is_first: bool,
        ends: Option<Ends>,
    ) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let query_set = self.queries.as_ref()?;
        (is_first || ends.is_some()).then_some(wgpu::ComputePassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: is_first.then_some(0),
            end_of_pass_write_index: ends.map(Ends::query),
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
    /// `last` is what ended last.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder, last: Ends) -> Option<usize> {
        let index = self.readback.free()?;
        let buffer = self.readback.buffer(index);
        encoder.copy_buffer_to_buffer(&self.counters, 0, buffer, 0, COUNTERS);
        if let Some(queries) = &self.queries {
            // Only those that were written; the others stay those of an earlier picture.
            encoder.resolve_query_set(queries, 0..last.query() + 1, &self.resolved, 0);
            encoder.copy_buffer_to_buffer(&self.resolved, 0, buffer, COUNTERS, TIMESTAMPS);
        }
        Some(index)
    }

    /// Says what a recorded report is of; before [`Reports::request`].
    pub fn mark(&mut self, index: usize, traced: Traced) {
        self.traced[index] = traced;
    }

    /// Says that what is submitted from now on is for this frame.
    pub fn begin(&mut self, frame: u64) {
        let at = Instant::now();
        self.submission = Some(Submission { frame, at });
    }

    /// Asks for a recorded and submitted report.
    pub fn request(&mut self, index: usize) {
        self.submissions[index] = self.submission;
        self.readback.request(index);
    }

    /// Whether the device tells how long pictures take.
    pub fn are_timed(&self) -> bool {
        self.queries.is_some()
    }

    /// Whether a report is on its way.
    pub fn is_waiting(&self) -> bool {
        self.readback.is_waiting()
    }

    /// The newest report that has come back since the last call; `each` gets all of them, with their passes.
    pub fn collect(
        &mut self,
        gpu: &Gpu,
        mut each: impl FnMut(u64, &Report, Vec<DevicePass>),
    ) -> Option<Report> {
        let mut newest: Option<(u64, Report)> = None;
        self.readback.collect(|index, bytes| {
            let (end, report) = self.parse(gpu, bytes, self.traced[index]);
            if let Some(submission) = self.submissions[index] {
                let passes = self.passes(gpu, bytes, submission);
                each(submission.frame, &report, passes);
            }
            if newest.is_none_or(|(before, _)| end >= before) {
                newest = Some((end, report));
            }
        });
        newest.map(|(_, report)| report)
    }

    /// When the device worked, by its own clock; nothing where it has no timestamps.
    fn passes(&self, gpu: &Gpu, bytes: &[u8], submission: Submission) -> Vec<DevicePass> {
        let times = &bytes[COUNTERS as usize..];
        let times: [u64; QUERIES as usize] = pod_read_unaligned(times);
        if self.queries.is_none() {
            return Vec::new();
        }
        // The last one may be an earlier picture's.
        let parts = times.windows(2).zip(self.names);
        parts
            .filter(|(ends, _)| ends[1] > ends[0])
            .map(|(ends, name)| submission.pass(gpu, name, [ends[0], ends[1]]))
            .collect()
    }

    fn parse(&self, gpu: &Gpu, bytes: &[u8], traced: Traced) -> (u64, Report) {
        let (counters, times) = bytes.split_at(COUNTERS as usize);
        let [first, there, edges]: [u64; QUERIES as usize] = pod_read_unaligned(times);
        let tick = f64::from(gpu.queue.get_timestamp_period()) * 1e-6;
        let millis = |from: u64, to: u64| to.saturating_sub(from) as f64 * tick;
        let report = Report {
            counters: pod_read_unaligned(counters),
            millis: self.queries.is_some().then_some(millis(first, there)),
            edges_millis: (edges > there).then_some(millis(there, edges)),
            traced,
        };
        (there, report)
    }
}
