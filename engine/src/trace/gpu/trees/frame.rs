//! What the tracer has the device do for a frame.

use super::{DeformedMesh, DeviceTrees, InstanceBuild, MeshPlace, Plan, SceneBuffers};
use crate::geom::Aabb;
use crate::trace::TraceError;
use crate::trace::pack::PackedMesh;

impl DeviceTrees {
    /// Plans new vertices and boxes of those of these meshes that are deformed; keys are their rows.
    ///
    /// # Errors
    /// [`TraceError::TooLarge`].
    pub(in crate::trace::gpu) fn update_meshes(
        &mut self,
        plan: &mut Plan,
        scene: SceneBuffers,
        rows: &[u32],
        meshes: &[PackedMesh],
    ) -> Result<(), TraceError> {
        let mut deformed = Vec::with_capacity(rows.len());
        let mut refitted = Vec::with_capacity(rows.len());
        for &key in rows {
            let mesh = &meshes[key as usize];
            let Some(deformation) = mesh.source.deformation.as_deref() else {
                continue;
            };
            if mesh.nodes().is_empty() {
                continue;
            }
            deformed.push(DeformedMesh {
                first_vertex: mesh.place.vertices.start,
                first_normal: mesh.first_normal(),
                data: &mesh.source.data,
                deformation,
            });
            refitted.push(MeshPlace {
                key,
                root: mesh.place.nodes.start,
                levels: mesh.levels(),
                first_triangle: mesh.place.triangles.start,
                first_vertex: mesh.place.vertices.start,
            });
        }
        if deformed.is_empty() {
            return Ok(());
        }
        self.deform(plan, scene, &deformed)?;
        self.refit(plan, scene, &refitted)
    }

    /// Plans the tree over the boxes of all rows, empty ones left out, with its root at a place among the nodes.
    ///
    /// # Errors
    /// [`TraceError::TooLarge`].
    pub(in crate::trace::gpu) fn build_instances(
        &mut self,
        plan: &mut Plan,
        scene: SceneBuffers,
        boxes: &[Aabb],
        root: u32,
    ) -> Result<(), TraceError> {
        self.written += self.boxes.upload(&self.gpu, boxes)?;
        let tree = InstanceBuild {
            boxes: self.boxes.buffer(),
            count: boxes.len() as u32,
            nodes: scene.nodes,
            root,
        };
        self.builder.plan(&self.gpu, plan, &tree)
    }
}
