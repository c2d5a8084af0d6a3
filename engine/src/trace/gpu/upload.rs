//! The packed frame on the device: only what changed is written.

use bytemuck::{Pod, bytes_of, cast_slice};

use super::buffers::RowBuffer;
use super::context::Gpu;
use super::layout::{Layouts, SCENE_BINDINGS, bind};
use super::texels::TexelMemory;
use super::trees::SceneBuffers;
use crate::frame::wire::{
    InstanceRow, LightRow, MaterialRow, Node4, PassRow, PlacedTriangleRow, VertexRow, ViewRow,
};
use crate::trace::pack::{DirtyRows, PackedMesh, Stale};
use crate::trace::{PackedScene, TraceError, Upload};

/// Triangles that get their positions at a time, on their way to the device: a mebibyte of them.
const PLACED_AT_A_TIME: usize = 1 << 14;

/// Groups 0 and 1.
pub struct SceneOnDevice {
    view: RowBuffer,
    passes: RowBuffer,
    nodes: RowBuffer,
    triangles: RowBuffer,
    vertices: RowBuffer,
    instances: RowBuffer,
    materials: RowBuffer,
    lights: RowBuffer,
    /// Bytes from one pass row to the next.
    pass_stride: u64,
    /// A buffer grew into another one that group 1 does not bind yet; kept over an upload that fails.
    moved: bool,
    /// Rows of meshes whose vertices and boxes the device has to compute.
    undeformed: Vec<u32>,
    /// Triangles on their way; kept for its room.
    placed: Vec<PlacedTriangleRow>,
    /// Bytes of textures since [`SceneOnDevice::take_written`].
    texels_written: u64,
    /// Group 3.
    pub texels: TexelMemory,
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
        let triangles = rows::<PlacedTriangleRow>(gpu, "triangles");
        let vertices = rows::<VertexRow>(gpu, "vertices");
        let instances = rows::<InstanceRow>(gpu, "instances");
        let materials = rows::<MaterialRow>(gpu, "materials");
        let lights = rows::<LightRow>(gpu, "lights");
        let all = [
            &nodes, &triangles, &vertices, &instances, &materials, &lights,
        ];
        let alignment = gpu.device.limits().min_uniform_buffer_offset_alignment;
        Self {
            frame: bind_frame(gpu, layouts, &view, &passes),
            scene: bind_scene(gpu, layouts, all),
            view,
            passes,
            nodes,
            triangles,
            vertices,
            instances,
            materials,
            lights,
            pass_stride: u64::from(alignment).max(size_of::<PassRow>() as u64),
            moved: false,
            undeformed: Vec::new(),
            placed: Vec::new(),
            texels_written: 0,
            texels: TexelMemory::default(),
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
        packed: &mut PackedScene,
    ) -> Result<u64, TraceError> {
        let arenas = &packed.arenas;
        let sizes = [
            (&mut self.nodes, bytes_of_rows::<Node4>(arenas.nodes.len())),
            (
                &mut self.triangles,
                bytes_of_rows::<PlacedTriangleRow>(arenas.triangles.len()),
            ),
            (
                &mut self.vertices,
                bytes_of_rows::<VertexRow>(arenas.vertices.len()),
            ),
        ];
        for (buffer, size) in sizes {
            if buffer.reserve(gpu, size)? {
                // The new buffer holds nothing.
                self.moved = true;
                packed.lose_copy();
            }
        }
        let mut written = self.write_meshes(gpu, packed);
        for range in packed.instances.take_stale_nodes() {
            let first = packed.instance_nodes_start() + range.start;
            let nodes = &packed.instance_nodes()[range.start as usize..range.end as usize];
            let offset = bytes_of_rows::<Node4>(first);
            written += self.nodes.write(gpu, offset, cast_slice(nodes));
        }
        let texels = self.texels.upload(gpu, layouts, &mut packed.texels)?;
        self.texels_written += texels;
        written += texels;
        let moved = &mut self.moved;
        written += put(gpu, &mut self.instances, &mut packed.instances.rows, moved)?;
        written += put(gpu, &mut self.materials, &mut packed.materials, moved)?;
        written += put(gpu, &mut self.lights, &mut packed.lights, moved)?;
        written += self.view.write_changed(gpu, 0, bytes_of(&packed.view));
        if self.moved {
            self.scene = bind_scene(gpu, layouts, self.scene_rows());
            self.moved = false;
        }
        Ok(written)
    }

    fn write_meshes(&mut self, gpu: &Gpu, packed: &mut PackedScene) -> u64 {
        let mut written = 0;
        for row in packed.take_stale_meshes() {
            let Some(mesh) = packed.meshes.get_mut(row as usize) else {
                continue;
            };
            let stale = std::mem::take(&mut mesh.stale);
            if stale == Stale::Nothing {
                continue;
            }
            if mesh.is_left_to_device() {
                self.undeformed.push(row);
                if stale == Stale::Deformed {
                    continue;
                }
            }
            let at = |start: u32, size: usize| u64::from(start) * size as u64;
            let nodes = at(mesh.place.nodes.start, size_of::<Node4>());
            let vertices = at(mesh.place.vertices.start, size_of::<VertexRow>());
            written += self.nodes.write(gpu, nodes, cast_slice(mesh.nodes()));
            written += self.write_triangles(gpu, mesh);
            written += self
                .vertices
                .write(gpu, vertices, cast_slice(&mesh.vertices));
        }
        written
    }

    fn write_triangles(&mut self, gpu: &Gpu, mesh: &PackedMesh) -> u64 {
        let mut at = bytes_of_rows::<PlacedTriangleRow>(mesh.place.triangles.start);
        let mut written = 0;
        let position = |vertex: u32| mesh.vertices[vertex as usize].vector;
        for part in mesh.triangles.chunks(PLACED_AT_A_TIME) {
            let rows = part.iter().map(|t| PlacedTriangleRow::new(t, position));
            self.placed.clear();
            self.placed.extend(rows);
            let bytes = self.triangles.write(gpu, at, cast_slice(&self.placed));
            at += bytes;
            written += bytes;
        }
        written
    }

    /// Bytes written since the last call, buffer by buffer.
    pub fn take_written(&mut self) -> Vec<Upload> {
        let buffers = [
            &mut self.instances,
            &mut self.nodes,
            &mut self.triangles,
            &mut self.vertices,
            &mut self.materials,
            &mut self.lights,
            &mut self.view,
            &mut self.passes,
        ];
        let mut uploads: Vec<Upload> = buffers.map(RowBuffer::take_written).into();
        uploads.push(Upload {
            buffer: "textures",
            bytes: std::mem::take(&mut self.texels_written),
        });
        uploads
    }

    /// Meshes whose vertices and boxes are to be computed here, since the last call.
    pub fn take_undeformed(&mut self) -> Vec<u32> {
        std::mem::take(&mut self.undeformed)
    }

    /// What the passes over trees work on.
    pub fn tree_buffers(&self) -> SceneBuffers<'_> {
        SceneBuffers {
            nodes: self.nodes.buffer(),
            triangles: self.triangles.buffer(),
            vertices: self.vertices.buffer(),
        }
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
            &self.vertices,
            &self.instances,
            &self.materials,
            &self.lights,
        ]
    }
}

fn bytes_of_rows<T>(count: u32) -> u64 {
    u64::from(count) * size_of::<T>() as u64
}

/// Writes what changed of rows that have a buffer of their own, making room for them.
fn put<T: Pod>(
    gpu: &Gpu,
    buffer: &mut RowBuffer,
    rows: &mut DirtyRows<T>,
    moved: &mut bool,
) -> Result<u64, TraceError> {
    if buffer.reserve(gpu, size_of_val(&rows[..]) as u64)? {
        *moved = true;
        rows.all_mut();
    }
    Ok(write_dirty(gpu, buffer, rows))
}

/// Writes what changed.
fn write_dirty<T: Pod>(gpu: &Gpu, buffer: &mut RowBuffer, rows: &mut DirtyRows<T>) -> u64 {
    let mut written = 0;
    for range in rows.take_dirty() {
        let offset = bytes_of_rows::<T>(range.start);
        let range = range.start as usize..range.end as usize;
        written += buffer.write(gpu, offset, cast_slice(&rows[range]));
    }
    written
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
    use super::*;

    use crate::frame::{FrameScene, TraceSettings};
    use crate::world::MeshData;

    /// A strip of triangles: most bytes are theirs, fewer their vertices', fewest the nodes'.
    fn packed(triangles: u32) -> PackedScene {
        let vertices =
            (0..triangles + 2).map(|i| glam::DVec3::new(f64::from(i), f64::from(i % 2), 0.0));
        let corners = (0..triangles).map(|i| [i, i + 1, i + 2]).collect();
        let mesh = MeshData::new("strip", vertices.collect(), Vec::new(), corners);
        let scene = FrameScene {
            meshes: vec![mesh.expect("a strip is a mesh").into()].into(),
            ..FrameScene::default()
        };
        let mut packed = PackedScene::default();
        packed.refit(&scene);
        packed.pack(&scene, &TraceSettings::default());
        packed
    }

    #[test]
    fn a_buffer_that_grew_before_an_upload_failed_is_bound_by_the_next() {
        let most = 1 << 18;
        let gpu = Gpu::limited(most).expect("a GPU, or software Vulkan, for the tests");
        let layouts = Layouts::new(&gpu);
        let mut on_device = SceneOnDevice::new(&gpu, &layouts);
        let before = on_device.scene.clone();
        let mut large = packed(most as u32 / size_of::<PlacedTriangleRow>() as u32 + 1);
        let too_large = on_device.upload(&gpu, &layouts, &mut large);
        assert!(
            matches!(&too_large, Err(TraceError::TooLarge(_))),
            "{too_large:?}"
        );
        let mut small = packed(most as u32 / size_of::<PlacedTriangleRow>() as u32 / 8);
        let written = on_device.upload(&gpu, &layouts, &mut small);
        let nodes = size_of_val(small.meshes[0].nodes());
        assert!(
            written.is_ok_and(|bytes| bytes as usize >= nodes),
            "the new buffer stayed empty"
        );
        assert_ne!(on_device.scene, before, "the old buffer is still bound");
        gpu.check().expect("nothing went wrong on the device");
    }
}
