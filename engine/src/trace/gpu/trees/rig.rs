//! [`Rig`]: trees alone on a device, without a tracer: what tests compare and benchmarks time.

use std::sync::Arc;

use bytemuck::{Pod, cast_slice, pod_read_unaligned};

use super::{DeformedMesh, DeviceTrees, InstanceBuild, MeshPlace, Plan, SceneBuffers, TreesReport};
use crate::bvh::Node4;
use crate::frame::wire::{BoxRow, BuildRow, PlacedTriangleRow, TriangleRow, VertexRow};
use crate::trace::gpu::buffers::{create, read};
use crate::trace::gpu::context::Gpu;
use crate::trace::{PassTime, TraceError};

/// What lies on the device at first.
#[derive(Clone, Debug, Default)]
pub struct RigRows {
    /// Nodes of meshes, and room for a tree over the boxes.
    pub nodes: Vec<Node4>,
    /// Triangles in the order of leaves; where their corners are, a refit finds.
    pub triangles: Vec<TriangleRow>,
    /// Positions and normals.
    pub vertices: Vec<VertexRow>,
    /// Boxes of instances.
    pub boxes: Vec<BoxRow>,
}

/// See the module.
pub struct Rig {
    gpu: Arc<Gpu>,
    trees: DeviceTrees,
    nodes: wgpu::Buffer,
    triangles: wgpu::Buffer,
    vertices: wgpu::Buffer,
    boxes: wgpu::Buffer,
    box_count: u32,
}

impl Rig {
    /// Uploads.
    ///
    /// # Errors
    /// [`TraceError::Device`].
    pub fn new(gpu: Arc<Gpu>, rows: &RigRows) -> Result<Self, TraceError> {
        let nowhere = |_| [f32::NAN; 3];
        let place = |triangle| PlacedTriangleRow::new(triangle, nowhere);
        let triangles: Vec<_> = rows.triangles.iter().map(place).collect();
        let rig = Self {
            nodes: upload(&gpu, "nodes", &rows.nodes),
            triangles: upload(&gpu, "triangles", &triangles),
            vertices: upload(&gpu, "vertices", &rows.vertices),
            boxes: upload(&gpu, "boxes", &rows.boxes),
            box_count: rows.boxes.len() as u32,
            trees: DeviceTrees::new(Arc::clone(&gpu)),
            gpu,
        };
        rig.gpu.check()?;
        Ok(rig)
    }

    /// Deforms these meshes, then refits those; milliseconds of each kernel.
    ///
    /// # Errors
    /// See [`TraceError`].
    pub fn refit(
        &mut self,
        deformed: &[DeformedMesh],
        refitted: &[MeshPlace],
    ) -> Result<Vec<PassTime>, TraceError> {
        let mut plan = Plan::default();
        let scene = SceneBuffers {
            nodes: &self.nodes,
            triangles: &self.triangles,
            vertices: &self.vertices,
        };
        self.trees.deform(&mut plan, scene, deformed)?;
        self.trees.refit(&mut plan, scene, refitted)?;
        self.run(&plan)
    }

    /// Builds the tree over the boxes, with its root at a place among the nodes; milliseconds of each kernel.
    ///
    /// # Errors
    /// See [`TraceError`].
    pub fn build(&mut self, root: u32) -> Result<Vec<PassTime>, TraceError> {
        let mut plan = Plan::default();
        let tree = InstanceBuild {
            boxes: &self.boxes,
            count: self.box_count,
            nodes: &self.nodes,
            root,
        };
        self.trees.instances(&mut plan, &tree)?;
        self.run(&plan)
    }

    /// Nodes as they are now.
    ///
    /// # Errors
    /// [`TraceError::Device`].
    pub fn nodes(&self) -> Result<Vec<Node4>, TraceError> {
        self.rows(&self.nodes)
    }

    /// Triangles as they are now.
    ///
    /// # Errors
    /// [`TraceError::Device`].
    pub fn triangles(&self) -> Result<Vec<PlacedTriangleRow>, TraceError> {
        self.rows(&self.triangles)
    }

    /// Vertices as they are now.
    ///
    /// # Errors
    /// [`TraceError::Device`].
    pub fn vertices(&self) -> Result<Vec<VertexRow>, TraceError> {
        self.rows(&self.vertices)
    }

    /// Boxes, nodes and levels of the tree that was built last.
    ///
    /// # Errors
    /// [`TraceError::Device`].
    pub fn built(&self) -> Result<BuildRow, TraceError> {
        let rows = self.rows(self.trees.instance_tree())?;
        Ok(rows.first().copied().unwrap_or_default())
    }

    /// The newest report since the last call.
    pub fn report(&mut self) -> Option<TreesReport> {
        self.trees.collect()
    }

    /// Waits for a plan. Times are of the device's own clock where it has one, else none are returned.
    fn run(&mut self, plan: &Plan) -> Result<Vec<PassTime>, TraceError> {
        let marks = plan.len() as u32 + 1;
        let inside = wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES;
        let timed = self.gpu.device.features().contains(inside);
        let queries = timed.then(|| {
            self.gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("marks"),
                ty: wgpu::QueryType::Timestamp,
                count: marks,
            })
        });
        let mut encoder = self
            .gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.trees.record(&mut encoder, plan, queries.as_ref())?;
        let report = self.trees.reports.record(&mut encoder);
        let size = u64::from(marks) * 8;
        use wgpu::BufferUsages as Usage;
        let resolving = Usage::QUERY_RESOLVE | Usage::COPY_SRC;
        let resolved = create(&self.gpu, "marks", resolving, size);
        let waiting = Usage::MAP_READ | Usage::COPY_DST;
        let staging = create(&self.gpu, "marks on their way", waiting, size);
        if let Some(queries) = &queries {
            encoder.resolve_query_set(queries, 0..marks, &resolved, 0);
        }
        encoder.copy_buffer_to_buffer(&resolved, 0, &staging, 0, size);
        self.gpu.queue.submit([encoder.finish()]);
        if let Some(slot) = report {
            self.trees.reports.request(slot, None);
        }
        let times: Vec<u64> = parse(&read(&self.gpu, &staging)?);
        let period = f64::from(self.gpu.queue.get_timestamp_period()) * 1e-6;
        let passes = plan.names().zip(times.windows(2));
        let passes = passes.map(|(name, mark)| PassTime {
            start: None,
            name,
            millis: mark[1].saturating_sub(mark[0]) as f64 * period,
        });
        Ok(if timed { passes.collect() } else { Vec::new() })
    }

    fn rows<T: Pod>(&self, buffer: &wgpu::Buffer) -> Result<Vec<T>, TraceError> {
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let staging = create(&self.gpu, "rows on their way", usage, buffer.size());
        let mut encoder = self
            .gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, buffer.size());
        self.gpu.queue.submit([encoder.finish()]);
        Ok(parse(&read(&self.gpu, &staging)?))
    }
}

fn parse<T: Pod>(bytes: &[u8]) -> Vec<T> {
    let rows = bytes.chunks_exact(size_of::<T>());
    rows.map(pod_read_unaligned).collect()
}

fn upload<T: Pod>(gpu: &Gpu, label: &str, rows: &[T]) -> wgpu::Buffer {
    use wgpu::BufferUsages as Usage;
    let usage = Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST;
    let bytes: &[u8] = cast_slice(rows);
    let buffer = create(gpu, label, usage, bytes.len().max(size_of::<T>()) as u64);
    gpu.queue.write_buffer(&buffer, 0, bytes);
    buffer
}
