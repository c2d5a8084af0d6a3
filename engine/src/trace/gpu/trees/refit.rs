//! Levels of many meshes' trees, from the deepest up.
//!
//! WGSL's atomics are relaxed: within a dispatch no invocation may count on seeing what another one wrote
//! to other places. So no "last child goes on to the parent" (Karras 2012): a dispatch a level, in which
//! every mesh that is refitted has a run of workgroups.

use bytemuck::Zeroable;

use super::MeshPlace;
use crate::frame::wire::JobRow;

/// Nodes of a workgroup of `refit.wgsl`.
const GROUP_NODES: u32 = 32;

/// Jobs of one dispatch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct JobRange {
    /// First row.
    pub(super) first: u32,
    /// Rows.
    pub(super) count: u32,
    /// Workgroups of all of them.
    pub(super) groups: u32,
}

/// The jobs of all levels and of the sum of costs.
pub(super) struct RefitJobs {
    /// The deepest level of every mesh first.
    pub(super) levels: Vec<JobRange>,
    /// A job a mesh.
    pub(super) costs: JobRange,
    /// Numbers that workgroups leave for the sum.
    pub(super) partials: u32,
}

/// Appends the jobs of a refit of these meshes, which have trees.
pub(super) fn append_jobs(meshes: &[MeshPlace], jobs: &mut Vec<JobRow>) -> RefitJobs {
    let groups_of = |nodes: u32| nodes.div_ceil(GROUP_NODES);
    let depth = |mesh: &MeshPlace| mesh.levels.len().saturating_sub(1);
    let mut partials = 0;
    let mut costs = Vec::with_capacity(meshes.len());
    for mesh in meshes {
        let count = mesh.levels.windows(2).map(|l| groups_of(l[1] - l[0])).sum();
        costs.push(JobRow {
            count,
            root: mesh.root,
            partial: partials,
            ..JobRow::zeroed()
        });
        partials += count;
    }
    let mut next_partial: Vec<u32> = costs.iter().map(|job| job.partial).collect();
    let deepest = meshes.iter().map(depth).max().unwrap_or(0);
    let mut levels = Vec::with_capacity(deepest);
    for above_deepest in 0..deepest {
        let first = jobs.len() as u32;
        let mut groups = 0;
        for (mesh, partial) in meshes.iter().zip(&mut next_partial) {
            if depth(mesh) <= above_deepest {
                continue;
            }
            let level = depth(mesh) - 1 - above_deepest;
            let nodes = mesh.levels[level + 1] - mesh.levels[level];
            jobs.push(JobRow {
                first_group: groups,
                count: nodes,
                first: mesh.levels[level],
                root: mesh.root,
                first_triangle: mesh.first_triangle,
                first_vertex: mesh.first_vertex,
                partial: *partial,
                ..JobRow::zeroed()
            });
            groups += groups_of(nodes);
            *partial += groups_of(nodes);
        }
        let count = jobs.len() as u32 - first;
        levels.push(JobRange {
            first,
            count,
            groups,
        });
    }
    let costs_range = JobRange {
        first: jobs.len() as u32,
        count: costs.len() as u32,
        groups: costs.len() as u32,
    };
    jobs.append(&mut costs);
    RefitJobs {
        levels,
        costs: costs_range,
        partials,
    }
}
