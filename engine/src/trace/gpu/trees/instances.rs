//! The tree over many instances, built anew on the device: codes, a sort, and a tree from the top down.
//!
//! Boxes are sorted by the Morton code of their centres (30 bits) with a least-significant-digit radix sort
//! whose passes are dispatches of their own. Then each level splits the ranges of the last one at the highest
//! differing bit (Karras 2012, "Maximizing Parallelism in the Construction of BVHs, Octrees, and k-d Trees"),
//! three times a node, straight into four children; a split is moved where a child would hold more than the
//! levels below have room for, so the depth is bounded whatever the input (that of nested boxes, which all
//! have one centre, too). Boxes of nodes are filled in from the deepest level up. The order of nodes within a
//! level depends on timing; no picture depends on the order of nodes.

use bytemuck::cast_slice;

use crate::frame::wire::{BoxRow, BuildRow, StageRow};
use crate::geom::Aabb;
use crate::trace::TraceError;
use crate::trace::gpu::buffers::RowBuffer;
use crate::trace::gpu::context::Gpu;
use crate::trace::gpu::shader::Kernel;

use super::Plan;
pub use crate::trace::pack::most_nodes;

/// Levels that no tree exceeds: 15 levels leave at most 46 nodes waiting, which is what rays keep room for.
const MOST_LEVELS: u32 = 15;
/// Levels beyond those of a full tree, for clusters; each costs two dispatches.
const SPARE_LEVELS: u32 = 3;
/// Digits of a code.
const DIGITS: u32 = 4;
/// Values of a digit.
const DIGIT_VALUES: u32 = 256;
/// Boxes of a workgroup of `span.wgsl` and `morton.wgsl`.
const GROUP_BOXES: u32 = 256;
/// Boxes of a workgroup of the sort.
const BLOCK_PAIRS: u32 = 1024;
/// Nodes of a workgroup of `split.wgsl`.
const GROUP_SPLITS: u32 = 64;
/// Nodes of a workgroup of `fit.wgsl`.
const GROUP_FITS: u32 = 32;
/// Bytes of a code with its row, and of a range.
const PAIR: u64 = 8;

/// Boxes, and where the tree goes.
#[derive(Clone, Copy)]
pub struct InstanceBuild<'a> {
    /// [`crate::frame::wire::BoxRow`]s, one an instance row; vacant ones are in no leaf. Finite.
    pub boxes: &'a wgpu::Buffer,
    /// How many.
    pub count: u32,
    /// Where nodes go; room for [`most_nodes`] behind `root`.
    pub nodes: &'a wgpu::Buffer,
    /// The root's place among the nodes.
    pub root: u32,
}

/// The host's boxes on the device.
pub(super) struct InstanceBoxes {
    rows: RowBuffer,
    packed: Vec<BoxRow>,
}

impl InstanceBoxes {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let size = size_of::<BoxRow>() as u64;
        Self {
            rows: RowBuffer::new(gpu, "boxes", wgpu::BufferUsages::STORAGE, size),
            packed: Vec::new(),
        }
    }

    pub(super) fn buffer(&self) -> &wgpu::Buffer {
        self.rows.buffer()
    }

    /// Returns the bytes written.
    pub(super) fn upload(&mut self, gpu: &Gpu, boxes: &[Aabb]) -> Result<u64, TraceError> {
        self.packed.clear();
        self.packed.extend(boxes.iter().map(|bounds| BoxRow {
            min: bounds.min.to_array(),
            max: bounds.max.to_array(),
            ..BoxRow::default()
        }));
        let bytes: &[u8] = cast_slice(&self.packed);
        self.rows.reserve(gpu, bytes.len() as u64)?;
        Ok(self.rows.write(gpu, 0, bytes))
    }
}

/// Levels that a tree over so many boxes may have.
pub fn most_levels(boxes: u32) -> u32 {
    let full = boxes.max(1).ilog2() / 2 + 1;
    (full + SPARE_LEVELS).min(MOST_LEVELS)
}

/// Room to work in.
pub(super) struct InstanceBuilder {
    pairs: RowBuffer,
    sorted: RowBuffer,
    counts: RowBuffer,
    totals: RowBuffer,
    ranges: RowBuffer,
    build: RowBuffer,
}

impl InstanceBuilder {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let rows = |label, size| RowBuffer::new(gpu, label, usage, size);
        Self {
            pairs: rows("instance codes", PAIR),
            sorted: rows("sorted instance codes", PAIR),
            counts: rows("digit counts", 4),
            totals: rows("digit totals", u64::from(DIGIT_VALUES) * 4),
            ranges: rows("instance ranges", PAIR),
            build: rows("instance tree levels", size_of::<BuildRow>() as u64),
        }
    }

    /// Plans a tree.
    ///
    /// # Errors
    /// [`TraceError::TooLarge`].
    pub(super) fn plan(
        &mut self,
        gpu: &Gpu,
        plan: &mut Plan,
        tree: &InstanceBuild,
    ) -> Result<(), TraceError> {
        let count = tree.count;
        let blocks = count.div_ceil(BLOCK_PAIRS);
        self.pairs.reserve(gpu, u64::from(count) * PAIR)?;
        self.sorted.reserve(gpu, u64::from(count) * PAIR)?;
        self.counts
            .reserve(gpu, u64::from(blocks * DIGIT_VALUES) * 4)?;
        self.ranges
            .reserve(gpu, u64::from(most_nodes(count)) * PAIR)?;
        let stage = StageRow {
            first: tree.root,
            count,
            level: 0,
            levels: most_levels(count),
        };
        plan.clear(self.build.buffer());
        self.plan_sort(plan, tree, stage, blocks);
        self.plan_levels(plan, tree, stage);
        Ok(())
    }

    fn plan_sort(&self, plan: &mut Plan, tree: &InstanceBuild, stage: StageRow, blocks: u32) {
        let build = self.build.buffer();
        let (counts, totals) = (self.counts.buffer(), self.totals.buffer());
        let groups = stage.count.div_ceil(GROUP_BOXES);
        plan.add(Kernel::Span, stage, groups, &[tree.boxes, build]);
        let (mut from, mut to) = (self.pairs.buffer(), self.sorted.buffer());
        plan.add(
            Kernel::Morton,
            stage,
            groups.max(1),
            &[tree.boxes, build, from],
        );
        for digit in 0..DIGITS {
            let stage = StageRow {
                level: digit,
                ..stage
            };
            plan.add(Kernel::SortCount, stage, blocks, &[from, counts]);
            plan.add(Kernel::SortScan, stage, DIGIT_VALUES, &[counts, totals]);
            plan.add(
                Kernel::SortScatter,
                stage,
                blocks,
                &[from, counts, totals, to],
            );
            (from, to) = (to, from);
        }
    }

    fn plan_levels(&self, plan: &mut Plan, tree: &InstanceBuild, stage: StageRow) {
        // An even number of digits: sorted pairs are where they were at first.
        let (pairs, build) = (self.pairs.buffer(), self.build.buffer());
        // Nodes hold two boxes or more.
        let most = |level: u32| (1_u32 << (2 * level).min(30)).min((stage.count / 2).max(1));
        let stages = (0..stage.levels).map(|level| StageRow { level, ..stage });
        for stage in stages.clone() {
            let groups = most(stage.level).div_ceil(GROUP_SPLITS);
            let buffers = [pairs, build, tree.nodes, self.ranges.buffer()];
            plan.add(Kernel::Split, stage, groups, &buffers);
        }
        for stage in stages.rev() {
            let groups = most(stage.level).div_ceil(GROUP_FITS);
            plan.add(Kernel::Fit, stage, groups, &[tree.boxes, build, tree.nodes]);
        }
    }

    /// Where [`BuildRow`] is after a tree was built: its nodes and levels.
    pub(super) fn build_row(&self) -> &wgpu::Buffer {
        self.build.buffer()
    }
}
