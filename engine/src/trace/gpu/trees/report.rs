//! What passes over trees took and found, back on the host without waiting for it.

use bytemuck::pod_read_unaligned;

use crate::trace::DevicePass;
use crate::trace::gpu::buffers::create;
use crate::trace::gpu::context::Gpu;
use crate::trace::gpu::readback::Readback;
use crate::trace::gpu::report::Submission;

/// Trees whose costs come back at once; of more, the first ones' do.
pub(super) const MOST_COSTS: usize = 256;
const COSTS: u64 = (MOST_COSTS * size_of::<f32>()) as u64;
const TIMESTAMPS: u64 = 2 * size_of::<u64>() as u64;

/// What came back of a plan.
#[derive(Clone, Debug, Default)]
pub struct TreesReport {
    /// Milliseconds on the device; none: it has no timestamps.
    pub millis: Option<f64>,
    /// For each refitted tree its key and the expected work of a ray that meets the root's box, by the surface
    /// area heuristic, as [`crate::bvh::Tree::cost`] has it.
    pub costs: Vec<(u32, f32)>,
    /// Of every plan that has come back since: its frame, and when the device worked on it.
    pub passes: Vec<(u64, DevicePass)>,
}

/// Where kernels leave it, and how it comes back.
pub(super) struct TreesReports {
    /// Of the trees in [`TreesReports::keys`].
    pub(super) costs: wgpu::Buffer,
    /// Trees of the plan under way.
    pub(super) keys: Vec<u32>,
    queries: Option<wgpu::QuerySet>,
    resolved: wgpu::Buffer,
    readback: Readback,
    /// Keys of each answer on its way, and what it is of.
    asked: Vec<(Vec<u32>, Option<Submission>)>,
}

impl TreesReports {
    pub(super) fn new(gpu: &Gpu) -> Self {
        use wgpu::BufferUsages as Usage;
        let features = gpu.device.features();
        let timed = features.contains(wgpu::Features::TIMESTAMP_QUERY);
        let queries = timed.then(|| {
            gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("first and last of trees"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            })
        });
        let resolving = Usage::QUERY_RESOLVE | Usage::COPY_SRC;
        Self {
            costs: create(
                gpu,
                "costs of trees",
                Usage::STORAGE | Usage::COPY_SRC,
                COSTS,
            ),
            keys: Vec::new(),
            queries,
            resolved: create(gpu, "timestamps of trees", resolving, TIMESTAMPS),
            readback: Readback::new(gpu, "report of trees", TIMESTAMPS + COSTS),
            asked: Vec::new(),
        }
    }

    /// The timestamps of a plan's pass.
    pub(super) fn writes(&self) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        Some(wgpu::ComputePassTimestampWrites {
            query_set: self.queries.as_ref()?,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        })
    }

    /// Records a report; call [`TreesReports::request`] with the answer after submitting.
    pub(super) fn record(&mut self, encoder: &mut wgpu::CommandEncoder) -> Option<usize> {
        let keys = std::mem::take(&mut self.keys);
        let slot = self.readback.free()?;
        let buffer = self.readback.buffer(slot);
        if let Some(queries) = &self.queries {
            encoder.resolve_query_set(queries, 0..2, &self.resolved, 0);
            encoder.copy_buffer_to_buffer(&self.resolved, 0, buffer, 0, TIMESTAMPS);
        }
        encoder.copy_buffer_to_buffer(&self.costs, 0, buffer, TIMESTAMPS, COSTS);
        if slot >= self.asked.len() {
            self.asked.resize(slot + 1, Default::default());
        }
        self.asked[slot] = (keys, None);
        Some(slot)
    }

    /// Asks for a recorded and submitted report; `submission` is what it is of, if it is a frame's.
    pub(super) fn request(&mut self, slot: usize, submission: Option<Submission>) {
        self.asked[slot].1 = submission;
        self.readback.request(slot);
    }

    /// The newest report that has come back since the last call.
    pub(super) fn collect(&self, gpu: &Gpu) -> Option<TreesReport> {
        let mut newest: Option<(u64, TreesReport)> = None;
        let mut passes = Vec::new();
        let tick = f64::from(gpu.queue.get_timestamp_period()) * 1e-6;
        self.readback.collect(|slot, bytes| {
            let (times, costs) = bytes.split_at(TIMESTAMPS as usize);
            let [first, last]: [u64; 2] = pod_read_unaligned(times);
            let costs = costs.chunks_exact(size_of::<f32>());
            let costs = costs.map(pod_read_unaligned::<f32>);
            let millis = last.saturating_sub(first) as f64 * tick;
            let report = TreesReport {
                millis: self.queries.is_some().then_some(millis),
                costs: self.asked[slot].0.iter().copied().zip(costs).collect(),
                passes: Vec::new(),
            };
            if let (Some(of), Some(_)) = (self.asked[slot].1, &self.queries) {
                passes.push((of.frame, of.pass(gpu, "trees", [first, last])));
            }
            if newest.as_ref().is_none_or(|(before, _)| last >= *before) {
                newest = Some((last, report));
            }
        });
        newest.map(|(_, report)| TreesReport { passes, ..report })
    }
}
