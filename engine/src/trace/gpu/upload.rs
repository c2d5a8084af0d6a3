//! The packed frame on the device: only what changed is written.

use bytemuck::{Pod, bytes_of, cast_slice};

use super::buffers::RowBuffer;
use super::context::Gpu;
use super::layout::{Layouts, SCENE_BINDINGS, bind};
use crate::frame::wire::{
    InstanceRow, LightRow, MaterialRow, Node4, NormalRow, PassRow, TriangleRow, ViewRow,
};
use crate::trace::{PackedScene, TraceError};

/// Groups 0 and 1.
pub struct SceneOnDevice {
    view: RowBuffer,
    passes: RowBuffer,
    nodes: RowBuffer,
    triangles: RowBuffer,
    normals: RowBuffer,
    instances: RowBuffer,
    materials: RowBuffer,
    lights: RowBuffer,
    /// [`PackedScene::mesh_version`] on the device.
    mesh_version: Option<u64>,
    /// Bytes from one pass row to the next.
    pass_stride: u64,
    /// A buffer grew into another one that group 1 does not bind yet; kept over an upload that fails.
    moved: bool,
    /// Group 0.
    pub frame: wgpu::BindGroup,
    /// Group 1.
    pub scene: wgpu::BindGroup,
}

impl SceneOnDevice {
    /// Empty buffers.
    pub fn new(gpu: &Gpu, layouts: &Layouts) -> Self {
        fn rows<T>(gpu: &Gpu, label: &'static str) -> RowBuffer {
            RowBuffer::new(
                gpu,
                label,
                wgpu::BufferUsages::STORAGE,
                size_of::<T>() as u64,
            )
        }
        let uniform = |label, size| RowBuffer::new(gpu, label, wgpu::BufferUsages::UNIFORM, size);
        let view = uniform("view", size_of::<ViewRow>() as u64);
        let passes = uniform("passes", size_of::<PassRow>() as u64);
        let nodes = rows::<Node4>(gpu, "nodes");
        let triangles = rows::<TriangleRow>(gpu, "triangles");
        let normals = rows::<NormalRow>(gpu, "normals");
        let instances = rows::<InstanceRow>(gpu, "instances");
        let materials = rows::<MaterialRow>(gpu, "materials");
        let lights = rows::<LightRow>(gpu, "lights");
        let all = [
            &nodes, &triangles, &normals, &instances, &materials, &lights,
        ];
        let alignment = gpu.device.limits().min_uniform_buffer_offset_alignment;
        Self {
            frame: bind_frame(gpu, layouts, &view, &passes),
            scene: bind_scene(gpu, layouts, all),
            view,
            passes,
            nodes,
            triangles,
            normals,
            instances,
            materials,
            lights,
            mesh_version: None,
            pass_stride: u64::from(alignment).max(size_of::<PassRow>() as u64),
            moved: false,
        }
    }

    /// Brings the device up to the packed frame; returns the bytes written.
    ///
    /// # Errors
    /// [`TraceError::TooLarge`].
    pub fn upload(
        &mut self,
        gpu: &Gpu,
        layouts: &Layouts,
        packed: &PackedScene,
    ) -> Result<u64, TraceError> {
        let meshes_end = packed.instance_nodes_start as usize;
        for (buffer, size) in [
            (&mut self.nodes, size_of_val(&packed.nodes[..])),
            (&mut self.triangles, size_of_val(&packed.triangles[..])),
            (&mut self.normals, size_of_val(&packed.normals[..])),
        ] {
            if buffer.reserve(gpu, size as u64)? {
                self.moved = true;
                self.mesh_version = None; // the new buffer holds nothing
            }
        }
        let mut written = 0;
        if self.mesh_version != Some(packed.mesh_version) {
            let mesh_nodes: &[u8] = cast_slice(&packed.nodes[..meshes_end]);
            written += self.nodes.write(gpu, 0, mesh_nodes);
            written += self.triangles.write(gpu, 0, cast_slice(&packed.triangles));
            written += self.normals.write(gpu, 0, cast_slice(&packed.normals));
            self.mesh_version = Some(packed.mesh_version);
        }
        let tail = (meshes_end * size_of::<Node4>()) as u64;
        let instance_nodes: &[u8] = cast_slice(&packed.nodes[meshes_end..]);
        written += self.nodes.write_changed(gpu, tail, instance_nodes);
        let moved = &mut self.moved;
        written += put(gpu, &mut self.instances, &packed.instances, moved)?;
        written += put(gpu, &mut self.materials, &packed.materials, moved)?;
        written += put(gpu, &mut self.lights, &packed.lights, moved)?;
        written += self.view.write_changed(gpu, 0, bytes_of(&packed.view));
        if self.moved {
            self.scene = bind_scene(gpu, layouts, self.scene_rows());
            self.moved = false;
        }
        Ok(written)
    }

    /// Writes the rows of the passes to come; returns the offset of each for group 0.
    ///
    /// # Errors
    /// [`TraceError::TooLarge`].
    pub fn write_passes(
        &mut self,
        gpu: &Gpu,
        layouts: &Layouts,
        rows: &[PassRow],
    ) -> Result<Vec<u32>, TraceError> {
        let stride = self.pass_stride as usize;
        let mut bytes = vec![0; rows.len() * stride];
        for (row, place) in rows.iter().zip(bytes.chunks_exact_mut(stride)) {
            place[..size_of::<PassRow>()].copy_from_slice(bytes_of(row));
        }
        if self.passes.reserve(gpu, bytes.len() as u64)? {
            self.frame = bind_frame(gpu, layouts, &self.view, &self.passes);
        }
        self.passes.write_changed(gpu, 0, &bytes);
        Ok((0..rows.len()).map(|i| (i * stride) as u32).collect())
    }

    fn scene_rows(&self) -> [&RowBuffer; SCENE_BINDINGS.len()] {
        [
            &self.nodes,
            &self.triangles,
            &self.normals,
            &self.instances,
            &self.materials,
            &self.lights,
        ]
    }
}

fn put<T: Pod>(
    gpu: &Gpu,
    buffer: &mut RowBuffer,
    rows: &[T],
    moved: &mut bool,
) -> Result<u64, TraceError> {
    let bytes: &[u8] = cast_slice(rows);
    *moved |= buffer.reserve(gpu, bytes.len() as u64)?;
    Ok(buffer.write_changed(gpu, 0, bytes))
}

fn bind_frame(
    gpu: &Gpu,
    layouts: &Layouts,
    view: &RowBuffer,
    passes: &RowBuffer,
) -> wgpu::BindGroup {
    let one_row = wgpu::BufferBinding {
        buffer: passes.buffer(),
        offset: 0,
        size: std::num::NonZeroU64::new(size_of::<PassRow>() as u64),
    };
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("frame"),
        layout: &layouts.frame,
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: view.buffer().as_entire_binding(),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: wgpu::BindingResource::Buffer(one_row),
            },
        ],
    })
}

fn bind_scene(
    gpu: &Gpu,
    layouts: &Layouts,
    rows: [&RowBuffer; SCENE_BINDINGS.len()],
) -> wgpu::BindGroup {
    bind(gpu, "scene", &layouts.scene, &rows.map(RowBuffer::buffer))
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;

    const NODE: usize = size_of::<Node4>();

    fn packed(nodes: usize, triangles: usize) -> PackedScene {
        let mut packed = PackedScene::default();
        packed.nodes = vec![Node4::zeroed(); nodes];
        packed.instance_nodes_start = nodes as u32;
        packed.triangles = vec![TriangleRow::zeroed(); triangles];
        packed.mesh_version = 1;
        packed
    }

    #[test]
    fn a_buffer_that_grew_before_an_upload_failed_is_bound_by_the_next() {
        let most = 1 << 18;
        let gpu = Gpu::limited(most).expect("a GPU, or software Vulkan, for the tests");
        let layouts = Layouts::new(&gpu);
        let mut on_device = SceneOnDevice::new(&gpu, &layouts);
        let nodes = most as usize / 2 / NODE;
        let before = on_device.scene.clone();
        let too_large = on_device.upload(&gpu, &layouts, &packed(nodes, most as usize));
        assert!(
            matches!(&too_large, Err(TraceError::TooLarge(why)) if why.contains("triangles")),
            "{too_large:?}"
        );
        let written = on_device.upload(&gpu, &layouts, &packed(nodes, 1));
        assert!(
            written.is_ok_and(|bytes| bytes as usize >= nodes * NODE),
            "the new buffer stayed empty"
        );
        assert_ne!(on_device.scene, before, "the old buffer is still bound");
        gpu.check().expect("nothing went wrong on the device");
    }
}
