//! FrameScene to the rows that both f32 tracers read, kept from frame to frame: what changed is packed anew.
//!
//! Here f64 becomes f32: positions relative to the eye are subtracted in f64 first, so a scene far from
//! the origin packs to the same bits as the same scene near it.
//!
//! Wald's three classes of motion ("Realtime Ray Tracing and Interactive Global Illumination", 2004,
//! chapter 9) need no labels: what is static is not in any batch of changes, hierarchical motion packs an
//! instance's row and moves its leaf, unstructured motion refits the mesh's own tree.

mod arena;
mod bound;
mod deform;
mod dirty;
mod hierarchy;
mod instance;
mod instances;
mod lanes;
mod mesh;
mod reach;
mod rows;
mod texels;
mod users;

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

pub use self::dirty::DirtyRows;
pub use self::instances::most_nodes;
pub use self::lanes::{Block, Node8, blocks_of};
pub use self::mesh::{PackedMesh, Stale};
pub use self::texels::{Texel, Texels};

use self::bound::radiance_bounds;
use self::instances::PackedInstances;
use self::mesh::{Arenas, Place};
use self::rows::{light_row, material_row, view_row};
use super::PassTime;
use crate::bvh::{LEAF_FIRST_MASK, Node4, Rebuilder, TreeAction};
use crate::frame::wire::{
    GENERATIONS_CAPACITY, InstanceRow, KIND_MESH, LightRow, MATERIAL_TRANSMITS, MaterialRow, NONE,
    PlacedTriangleRow, VertexRow, ViewRow,
};
use crate::frame::{Features, FrameScene, Kernels, Skip, Skips, TraceSettings};
use crate::world::Changes;

/// Rows from which a device builds the tree over instances that move: a device's passes have a price that does not
/// depend on how many there are, so fewer are built here.
const DEVICE_FROM: usize = 8192;

/// The rows of a frame.
#[derive(Default)]
pub struct PackedScene {
    /// The uniform.
    pub view: ViewRow,
    /// The arithmetic of the next picture.
    pub kernels: Kernels,
    /// What of the next picture is left out.
    pub skips: Skips,
    /// Materials.
    pub materials: DirtyRows<MaterialRow>,
    /// Lights.
    pub lights: DirtyRows<LightRow>,
    /// Row for row those of the frame.
    pub meshes: Vec<PackedMesh>,
    /// Some instance lets light through, so shadows are not all or nothing.
    pub transparent: bool,
    /// Some mesh has a colour of its own, or a normal map.
    pub has_looks: bool,
    /// The background is not the same everywhere.
    pub has_sky: bool,
    /// Some mesh's triangles stand for a curved surface.
    pub has_curved: bool,
    /// Some material takes light away within.
    pub absorbs: bool,
    /// Some mesh has holes by alpha.
    pub has_cutouts: bool,
    /// Pictures that materials name.
    pub texels: Texels,
    /// The last [`PackedScene::refit`] and [`PackedScene::pack`] found something that a picture may show.
    pub has_changed: bool,
    /// Trees built or refitted by them.
    pub trees_updated: u64,
    /// Meshes are deformed and refitted where their rows are copied to, not here.
    pub deforms_on_device: bool,
    pub(super) instances: PackedInstances,
    pub(super) arenas: Arenas,
    /// Where a device keeps the tree over instances.
    instance_nodes: Place,
    /// Meshes built or refitted since the last pack.
    changed_meshes: Vec<u32>,
    /// Builds new trees for worn ones off the frame.
    rebuilder: Rebuilder,
    /// Meshes of which a device's copy lacks something.
    stale_meshes: Vec<u32>,
    /// Versions of materials, meshes and lights that are packed.
    seen: [u64; 3],
    /// The eye that lights are relative to.
    eye: DVec3,
    features: Features,
}

impl PackedScene {
    /// For a device that deforms and refits meshes itself, and builds the tree over many instances.
    pub fn for_device() -> Self {
        let mut scene = Self {
            deforms_on_device: true,
            ..Self::default()
        };
        scene.instances.device_from = Some(DEVICE_FROM);
        scene
    }

    /// Builds the trees of meshes that are new or changed; of all, and forgets every other row, where nothing is to be kept.
    pub fn refit(&mut self, scene: &FrameScene) {
        if !self.skips.has(Skip::Trees) {
            let mut anew = Self {
                skips: self.skips,
                deforms_on_device: self.deforms_on_device,
                ..Self::default()
            };
            anew.instances.device_from = self.instances.device_from;
            *self = anew;
        }
        self.trees_updated = 0;
        self.update_meshes(scene);
        self.replace_worn_trees();
        let rows = sorted(std::mem::take(&mut self.changed_meshes));
        self.trees_updated = rows.len() as u64;
        self.changed_meshes = rows;
    }

    fn update_meshes(&mut self, scene: &FrameScene) {
        let changed: Vec<u32> = match scene.meshes.changes_since(self.seen[1]) {
            Changes::None => return,
            Changes::Rows(rows) => sorted(rows.to_vec()),
            Changes::All => (0..scene.meshes.len() as u32).collect(),
        };
        self.seen[1] = scene.meshes.version();
        for mesh in self
            .meshes
            .drain(scene.meshes.len().min(self.meshes.len())..)
        {
            self.arenas.free(mesh.place);
        }
        self.meshes
            .resize_with(scene.meshes.len(), PackedMesh::default);
        let mut work: Vec<(u32, PackedMesh)> = Vec::new();
        let on_device = self.deforms_on_device;
        for row in changed {
            let (mesh, now) = (&mut self.meshes[row as usize], &scene.meshes[row as usize]);
            if mesh.is_of(now) && mesh.deform(now) {
                self.changed_meshes.push(row);
            } else if !mesh.is_of(now) {
                self.rebuilder.cancel(u64::from(row));
                work.push((row, PackedMesh::default()));
            }
        }
        work.par_iter_mut().for_each(|(row, mesh)| {
            *mesh = PackedMesh::build(&scene.meshes[*row as usize], on_device);
        });
        for (row, mut mesh) in work {
            let slot = &mut self.meshes[row as usize];
            mesh.settle_in(&mut self.arenas, std::mem::take(&mut slot.place));
            *slot = mesh;
            self.changed_meshes.push(row);
        }
    }

    /// Takes the trees that were built off the frame, and asks for those that have become due. A tree that
    /// comes is refitted to the vertices of now before anything is traced with it.
    fn replace_worn_trees(&mut self) {
        for rebuilt in self.rebuilder.poll() {
            let row = rebuilt.key as u32;
            let mesh = self.meshes.get_mut(row as usize);
            if let (Some(mesh), Some(tree)) = (mesh, rebuilt.tree)
                && tree.prims.len() == mesh.triangles.len()
                && mesh.is_worn()
            {
                mesh.adopt(tree);
                let place = std::mem::take(&mut mesh.place);
                mesh.settle_in(&mut self.arenas, place);
                self.changed_meshes.push(row);
            }
        }
        for &row in &self.changed_meshes {
            let mesh = &self.meshes[row as usize];
            let key = u64::from(row);
            if mesh.is_worn() && !self.rebuilder.is_pending(key) {
                let (boxes, benefit) = (mesh.boxes_elsewhere(), mesh.benefit());
                self.rebuilder.request(key, boxes, benefit);
            }
        }
    }

    /// Packs what changed of everything else, and brings the tree over instances up to it.
    pub fn pack(&mut self, scene: &FrameScene, settings: &TraceSettings) {
        let textures = self.texels.update(&scene.textures);
        let materials = textures || scene.materials.changes_since(self.seen[0]) != Changes::None;
        if materials {
            let texels = &self.texels;
            let rows = scene.materials.iter();
            self.materials
                .assign(rows.map(|material| material_row(material, texels)));
        }
        let lights = scene.lights.changes_since(self.seen[2]) != Changes::None;
        let eye = scene.view.origin;
        if lights || self.eye != eye {
            let rows = scene.lights.iter().map(|light| light_row(light, eye));
            self.lights.assign(rows);
            self.eye = eye;
        }
        self.seen[0] = scene.materials.version();
        self.seen[2] = scene.lights.version();
        let changed_meshes = std::mem::take(&mut self.changed_meshes);
        self.stale_meshes.extend_from_slice(&changed_meshes);
        self.instances.update(scene, &self.meshes, &changed_meshes);
        if self.instances.tree_work().action != TreeAction::None {
            self.trees_updated += 1;
        }
        let nodes = self.instances.node_room();
        if nodes > self.instance_nodes.nodes.len() as u32 {
            // Half as much again, so that a scene that grows does not move it each time.
            self.arenas.free(std::mem::take(&mut self.instance_nodes));
            self.instance_nodes.nodes = self.arenas.nodes.take(nodes + nodes / 2);
            self.instances.lose_nodes();
        }
        let transmits = |row: usize| self.materials[row].flags & MATERIAL_TRANSMITS != 0;
        self.transparent = self.instances.any_material(transmits);
        let mut view = self.make_view(scene, settings);
        self.set_cutoff(&mut view, scene, settings.cutoff, materials || lights);
        self.has_changed = self.instances.rows.is_dirty()
            || materials
            || lights
            || !changed_meshes.is_empty()
            || view != self.view
            || settings.kernels != self.kernels
            || settings.skips != self.skips
            || self.features != scene.features;
        self.view = view;
        self.kernels = settings.kernels;
        self.skips = settings.skips;
        self.features = scene.features;
        self.has_looks = scene.features.textures || scene.features.vertex_colors;
        self.has_cutouts = scene.features.cutouts;
        self.absorbs = scene.features.absorption;
        self.has_curved = scene.features.curved;
        self.has_sky = scene.features.sky;
    }

    /// Whether a ray that looks for anything but planes begins at a mesh, and finds nothing else.
    pub fn is_one_mesh(&self) -> bool {
        let row = self.instances.alone().map(|leaf| leaf & LEAF_FIRST_MASK);
        let row = row.and_then(|row| self.instances.rows.get(row as usize));
        row.is_some_and(|row| row.kind == KIND_MESH)
    }

    fn make_view(&self, scene: &FrameScene, settings: &TraceSettings) -> ViewRow {
        ViewRow {
            background: scene.background.horizon.to_array(),
            zenith: scene.background.zenith.to_array(),
            ground: scene.background.ground.to_array(),
            panorama: self.texels.first(scene.background.picture),
            panorama_turn: (scene.background.turn / std::f64::consts::TAU).fract() as f32,
            max_generations: scene.max_generations.min(GENERATIONS_CAPACITY),
            first_plane: self.instances.first_plane(),
            light_count: self.lights.len() as u32,
            root: match self.instances.alone() {
                _ if self.instances.node_room() == 0 => NONE,
                Some(leaf) => leaf,
                None => self.instance_nodes.nodes.start,
            },
            eye_from_anchor: self.instances.eye_from_anchor().as_vec3().to_array(),
            ..view_row(&scene.view, settings)
        }
    }

    /// The cut-off, and the bounds that it rests on: those of before unless what they are of has changed.
    fn set_cutoff(&self, view: &mut ViewRow, scene: &FrameScene, cutoff: f32, shading: bool) {
        let before = &self.view;
        if !(cutoff > 0.0 && cutoff.is_finite()) {
            return;
        }
        let same = !shading
            && before.cutoff == cutoff
            && before.max_generations == view.max_generations
            && [before.background, before.zenith, before.ground]
                == [view.background, view.zenith, view.ground]
            && before.panorama == view.panorama;
        if same {
            (view.cutoff, view.bounds) = (cutoff, before.bounds);
        } else if let Some(bounds) = radiance_bounds(scene) {
            view.cutoff = cutoff;
            view.bounds = bytemuck::cast(bounds);
        }
    }

    /// Rows of the instances, by row of the frame.
    #[inline]
    pub fn instances(&self) -> &[InstanceRow] {
        &self.instances.rows
    }

    /// Nodes that a traversal of both levels may have to keep at once, at most.
    pub fn stack_bound(&self) -> u32 {
        let meshes = self.meshes.iter().map(|mesh| mesh.stack_need);
        self.instances.stack_bound() + meshes.max().unwrap_or(0)
    }

    /// Where a device keeps the tree over instances, in rows of nodes.
    pub fn instance_nodes_start(&self) -> u32 {
        self.instance_nodes.nodes.start
    }

    /// What bringing the tree over instances up to the frame took.
    pub fn tree_time(&self) -> PassTime {
        let work = self.instances.tree_work();
        PassTime {
            name: match work.action {
                _ if self.instances.is_on_device() => "instance tree: left to the device",
                TreeAction::None => "instance tree kept",
                TreeAction::Paths => "instance tree: paths",
                TreeAction::Refit => "instance tree: refit",
                TreeAction::Rebuild => "instance tree: rebuild",
            },
            millis: work.nanos as f64 * 1e-6,
            start: None,
        }
    }

    /// Nodes of the tree over instances that the last [`PackedScene::pack`] wrote to.
    pub fn tree_nodes_written(&self) -> u64 {
        self.instances.tree_work().nodes.into()
    }

    /// A device's copy of all this is not to be relied on any more.
    pub fn lose_copy(&mut self) {
        self.stale_meshes = (0..self.meshes.len() as u32).collect();
        self.meshes
            .iter_mut()
            .for_each(|mesh| mesh.stale = Stale::All);
        self.instances.rows.all_mut();
        self.instances.lose_nodes();
        self.materials.all_mut();
        self.lights.all_mut();
        self.texels.is_stale = true;
    }

    /// Meshes of which a device's copy lacks something; from now on it has them.
    pub fn take_stale_meshes(&mut self) -> Vec<u32> {
        std::mem::take(&mut self.stale_meshes)
    }

    /// Brings what tracers on the processor walk in place of meshes' trees up to them; how many it was.
    pub fn bring_lanes(&mut self) -> usize {
        let stale = sorted(self.take_stale_meshes());
        let meshes = self.meshes.par_iter_mut().enumerate();
        let due = meshes.filter(|(row, _)| stale.binary_search(&(*row as u32)).is_ok());
        due.for_each(|(_, mesh)| mesh.bring_lanes());
        stale.len()
    }

    /// Takes every change for copied: for tracers that read these rows themselves. The bytes of rows and nodes
    /// that a copy would have taken; those of meshes are not in it.
    pub fn keep_no_copy(&mut self) -> u64 {
        bytes_of::<MaterialRow>(&self.materials.take_dirty())
            + bytes_of::<LightRow>(&self.lights.take_dirty())
            + bytes_of::<InstanceRow>(&self.instances.rows.take_dirty())
            + bytes_of::<Node4>(&self.instances.take_stale_nodes())
    }

    /// Trees that this frame neither built nor refitted.
    pub fn trees_kept(&self) -> u64 {
        (self.meshes.len() as u64 + 1).saturating_sub(self.trees_updated)
    }

    /// Bytes that a device's copy of rows and trees takes, textures aside.
    pub fn bytes(&self) -> u64 {
        let all = |rows: u32| 0..rows;
        bytes_of::<Node4>(&[all(self.arenas.nodes.len())])
            + bytes_of::<PlacedTriangleRow>(&[all(self.arenas.triangles.len())])
            + bytes_of::<VertexRow>(&[all(self.arenas.vertices.len())])
            + bytes_of::<InstanceRow>(&[all(self.instances.rows.len() as u32)])
            + bytes_of::<MaterialRow>(&[all(self.materials.len() as u32)])
            + bytes_of::<LightRow>(&[all(self.lights.len() as u32)])
    }

    /// Nodes of the tree over instances, root first; none: there is nothing but planes.
    #[inline]
    pub fn instance_nodes(&self) -> &[Node4] {
        self.instances.nodes()
    }

    /// The mesh of an instance's row.
    #[inline]
    pub fn mesh(&self, row: &InstanceRow) -> &PackedMesh {
        &self.meshes[row.mesh as usize]
    }
}

/// Bytes of ranges of rows.
fn bytes_of<T>(ranges: &[Range<u32>]) -> u64 {
    let rows: u64 = ranges
        .iter()
        .map(|range| u64::from(range.end - range.start))
        .sum();
    rows * size_of::<T>() as u64
}

/// In order, each once.
fn sorted(mut rows: Vec<u32>) -> Vec<u32> {
    rows.sort_unstable();
    rows.dedup();
    rows
}

#[cfg(test)]
mod tests;
