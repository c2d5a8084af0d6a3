//! Rows as the f32 tracers read them, byte for byte the structs of `shaders/shared/types.wgsl`; only
//! [`TriangleRow`] never leaves the host.
//!
//! A test parses the WGSL and compares names, order, offsets, sizes and constants with these.
//! Positions are relative to the render origin (the eye), which is subtracted in f64 before rounding.
//! "Affine rows" are the three rows of a 3x4 matrix: `p'[i] = dot(row[i].xyz, p) + row[i].w`.

use bytemuck::{Pod, Zeroable};

mod trees;

pub use self::trees::{
    BoxRow, BuildRow, JobRow, STEP_KEYS, STEP_MORPH, STEP_SKIN, STEP_TWIST, STEP_WAVE, StageRow,
    StepRow,
};
pub use crate::bvh::{Node4, TRAVERSAL_CAPACITY};
use crate::geom::{AffineRows, PlaneFrame, SphereFrame};

/// No row, no hit.
pub const NONE: u32 = u32::MAX;
/// [`InstanceRow::kind`]: triangles below [`InstanceRow::root`].
pub const KIND_MESH: u32 = 0;
/// [`InstanceRow::kind`]: a sphere in render space: the rows of `local_from_world` are those of a [`SphereFrame`].
pub const KIND_SPHERE: u32 = 1;
/// [`InstanceRow::kind`]: the unit sphere in local space.
pub const KIND_ELLIPSOID: u32 = 2;
/// [`InstanceRow::kind`]: the box [-1, 1]^3 in local space.
pub const KIND_CUBOID: u32 = 3;
/// [`InstanceRow::kind`]: a plane in render space: the rows of `local_from_world` are those of a [`PlaneFrame`].
pub const KIND_PLANE: u32 = 4;
/// [`InstanceRow::kind`]: the unit disc across Y in local space.
pub const KIND_DISC: u32 = 5;
/// [`InstanceRow::kind`]: a cone about Y in local space, |y| <= 1, its larger radius 1.
pub const KIND_CONE: u32 = 6;
/// [`InstanceRow::kind`]: a torus about Y in local space, its major radius 1.
pub const KIND_TORUS: u32 = 7;
/// [`InstanceRow::root`] of cones: the side alone, no caps.
pub const CONE_OPEN: u32 = 1;
/// [`InstanceRow::root`]: the tree's nodes hold spheres, not boxes.
pub const ROOT_OF_SPHERES: u32 = 1 << 31;
/// [`MaterialRow::flags`]: reflection by Fresnel's formula; `reflection` is unused.
pub const MATERIAL_FRESNEL: u32 = 1;
/// [`MaterialRow::flags`]: reflects by the constant weight `reflection`.
pub const MATERIAL_MIRROR: u32 = 2;
/// [`MaterialRow::flags`]: lets light through.
pub const MATERIAL_TRANSMITS: u32 = 4;
/// Flag of [`VertexRow::further`]: the mesh has no texture coordinates, so its material's pictures do not show.
pub const LOOK_UNPLACED: u32 = 1 << 31;
/// Beyond a texture's edge comes the texture again.
pub const WRAP_REPEAT: u32 = 0;
/// Beyond a texture's edge comes the texel at the edge.
pub const WRAP_CLAMP: u32 = 1;
/// Beyond a texture's edge comes the texture turned round.
pub const WRAP_MIRROR: u32 = 2;
/// Texels of a row of the memory of texels, as a power of two; as many rows make a layer.
pub const TEXELS_SHIFT: u32 = 12;
/// [`LightRow::kind`].
pub const LIGHT_POINT: u32 = 0;
/// [`LightRow::kind`]: `position` is the unit direction towards the light.
pub const LIGHT_DIRECTIONAL: u32 = 1;
/// [`LightRow::kind`].
pub const LIGHT_SPOT: u32 = 2;
/// [`ViewRow::projection`]: a pinhole.
pub const PROJECTION_PERSPECTIVE: u32 = 0;
/// [`ViewRow::projection`]: parallel rays.
pub const PROJECTION_ORTHOGRAPHIC: u32 = 1;
/// [`PassRow::query`]: the nearest hit.
pub const QUERY_CLOSEST: u32 = 0;
/// [`PassRow::query`]: whether there is any hit.
pub const QUERY_ANY: u32 = 1;
/// Media a ray can be inside of at once; one more is counted in [`CounterRow::media_overflows`].
pub const MEDIA_CAPACITY: u32 = 8;
/// Generations a path can have, whatever the scene asks: the size of the stack of deferred rays.
pub const GENERATIONS_CAPACITY: u32 = 64;
/// Surfaces of equal index a ray may cross within one generation; one more is counted in
/// [`CounterRow::straight_overflows`].
pub const STRAIGHT_CAPACITY: u32 = 256;

/// Samples a pixel can have: after so many the sequence would start again.
pub const SAMPLES_CAPACITY: u32 = 256;
/// The cell of the first sample on a grid of 256 x 256: column in the low byte, row in the next.
pub const SAMPLE_FIRST_CELL: u32 = 0x8080;
/// What each bit of a sample's number changes in that cell, by exclusive or; lowest bit first.
pub const SAMPLE_COLUMNS: [u32; 8] = [
    0xc4b2, 0xad6b, 0xf738, 0x801a, 0xce0e, 0xa104, 0xfe03, 0x8e01,
];
/// Vectors of [`ViewRow::bounds`].
const BOUNDS: usize = GENERATIONS_CAPACITY as usize / 4;

/// The uniform of a frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ViewRow {
    /// Unit view direction.
    pub forward: [f32; 3],
    /// Picture width in pixels.
    pub width: u32,
    /// What half a pixel to the right adds to a ray: the span of the picture's width over twice its pixels.
    pub right_step: [f32; 3],
    /// Picture height in pixels.
    pub height: u32,
    /// What half a pixel up adds.
    pub up_step: [f32; 3],
    /// Samples of a pixel, 1 to [`SAMPLES_CAPACITY`].
    pub samples: u32,
    /// Linear RGB of a miss; where the background is not plain, of a level one.
    pub background: [f32; 3],
    /// Generations followed, at most [`GENERATIONS_CAPACITY`].
    pub max_generations: u32,
    /// `PROJECTION_*`.
    pub projection: u32,
    /// First instance row that is a plane, the others follow by [`InstanceRow::link`]: planes are in
    /// no tree. [`NONE`]: there is none.
    pub first_plane: u32,
    /// Rows of lights.
    pub light_count: u32,
    /// Root of the instance tree among the nodes, or the leaf that is all of it (see [`crate::bvh::Node4`]); [`NONE`]: no
    /// instances but planes.
    pub root: u32,
    /// The eye relative to the anchor that the boxes of the instance tree are about.
    pub eye_from_anchor: [f32; 3],
    /// Largest error of a pixel that leaving out rays may cause; 0: all are followed.
    pub cutoff: f32,
    /// The most that a ray can bring back, a channel, by generation: that of generation g is number g - 1. All
    /// 0 without a cut-off.
    pub bounds: [[f32; 4]; BOUNDS],
    /// Room for more.
    pub spare: [u32; 3],
    /// Contrast with a neighbour above which a pixel takes all its samples; 0: every pixel does.
    pub edge_contrast: f32,
    /// Linear RGB of a miss straight up.
    pub zenith: [f32; 3],
    /// Where the background's panorama begins in the memory of texels; [`NONE`]: there is none.
    pub panorama: u32,
    /// Linear RGB of a miss straight down.
    pub ground: [f32; 3],
    /// How far the panorama is turned, in whole turns.
    pub panorama_turn: f32,
}

/// The uniform of one dispatch: a part of the picture or of the rays.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PassRow {
    /// Pictures: first row of pixels, or entry of the list of edges.
    pub first: u32,
    /// Rows of pixels, entries, or rays.
    pub count: u32,
    /// Rays: `QUERY_*`.
    pub query: u32,
    /// Pictures: 0 starts every pixel anew, 1 goes on with the samples it has.
    pub goes_on: u32,
    /// Room for more.
    pub spare: [u32; 3],
    /// Pictures: pixels that have fewer samples take their next.
    pub limit: u32,
}

/// A shape in render space; its row is that of `FrameScene::instances`, which is what a hit names and what
/// breaks ties.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct InstanceRow {
    /// Affine rows; of spheres and planes see [`KIND_SPHERE`] and [`KIND_PLANE`].
    pub local_from_world: AffineRows,
    /// Affine rows.
    pub world_from_local: AffineRows,
    /// `KIND_*`.
    pub kind: u32,
    /// Row of materials.
    pub material: u32,
    /// Meshes: root of the mesh's tree among the nodes, with [`ROOT_OF_SPHERES`]. Child indices in a tree count
    /// from its root. Cones: 0, or [`CONE_OPEN`].
    pub root: u32,
    /// Meshes: first row of its triangles. Leaf ranges of the tree count from here.
    pub first_triangle: u32,
    /// Cones: half of what the radius gains from y = -1 to y = 1. Tori: the minor radius. Meshes: 1 where the triangles stand
    /// for a curved surface, else 0.
    pub parameter: f32,
    /// Meshes: row of `FrameScene::meshes`.
    pub mesh: u32,
    /// Planes: the next one, or [`NONE`]. Meshes: first row of its looks, in the order of vertices; [`NONE`]: it has neither
    /// texture coordinates nor colours.
    pub link: u32,
    /// Meshes: first row of its normals, in the order of vertices; [`NONE`]: faces are flat.
    pub first_normal: u32,
}

impl InstanceRow {
    /// The sphere of a row of [`KIND_SPHERE`].
    #[inline]
    pub fn sphere(&self) -> SphereFrame {
        SphereFrame::from_rows(self.local_from_world.0)
    }

    /// The plane of a row of [`KIND_PLANE`].
    #[inline]
    pub fn plane(&self) -> PlaneFrame {
        PlaneFrame::from_rows(self.local_from_world.0)
    }
}

/// A triangle of the host's, in the order of its tree's leaves: small, so that a refit reads little.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct TriangleRow {
    /// Vertices, counted from the mesh's first.
    pub corners: [u32; 3],
    /// Triangle number in the mesh: what a hit names and what breaks ties.
    pub prim: u32,
}

/// A triangle of the device's, in the order of its tree's leaves. Positions are in place, as copies of the
/// vertices': a ray that looked them up by number would wait for memory twice.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PlacedTriangleRow {
    /// [`TriangleRow::corners`].
    pub corners: [u32; 3],
    /// Room for one more number.
    pub spare: u32,
    /// Position of the first corner.
    pub a: [f32; 3],
    /// [`TriangleRow::prim`].
    pub prim: u32,
    /// Position of the second corner.
    pub b: [f32; 3],
    /// Room for one more number.
    pub spare_too: u32,
    /// Position of the third corner.
    pub c: [f32; 3],
    /// Room for one more number.
    pub spare_also: u32,
}

impl PlacedTriangleRow {
    /// Copies the corners' positions.
    #[inline]
    pub fn new(triangle: &TriangleRow, position: impl Fn(u32) -> [f32; 3]) -> Self {
        let [a, b, c] = triangle.corners.map(position);
        Self {
            corners: triangle.corners,
            prim: triangle.prim,
            a,
            b,
            c,
            ..Self::default()
        }
    }
}

/// A vector of a vertex: its position in its mesh's space relative to the mesh's origin, its unit normal, or its looks.
/// A mesh's positions come first, a smooth one's normals after them, then texture coordinates with alpha, then colours.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct VertexRow {
    /// Position, normal, texture coordinates and alpha, or linear RGB.
    pub vector: [f32; 3],
    /// Texture coordinates: how many rows on the vertex has its colour; 0: it has none; with [`LOOK_UNPLACED`] where the
    /// coordinates are none. Others: 0.
    pub further: u32,
}

/// A material; see [`crate::world::Material`].
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct MaterialRow {
    /// Linear RGB.
    pub color: [f32; 3],
    /// Diffuse share, not yet times a = 1 - filter - transmit.
    pub diffuse: f32,
    /// Constant weight of the mirrored ray.
    pub reflection: [f32; 3],
    /// Emission, not yet times a.
    pub emission: f32,
    /// Phong strength; 0: none.
    pub phong_strength: f32,
    /// Phong exponent.
    pub phong_exponent: f32,
    /// Blinn-Phong strength; 0: none.
    pub specular_strength: f32,
    /// Blinn-Phong exponent.
    pub specular_exponent: f32,
    /// Untinted share that passes.
    pub transmit: f32,
    /// Tinted share that passes (`filter` is a reserved word of WGSL).
    pub filtered: f32,
    /// Index of refraction.
    pub ior: f32,
    /// `MATERIAL_*`.
    pub flags: u32,
    /// What a length within takes away: exp(-absorption * length) is left.
    pub absorption: [f32; 3],
    /// Least alpha of what is there; 0: everything is.
    pub alpha_cutoff: f32,
    /// Where the colour map begins in the memory of texels; [`NONE`]: there is none.
    pub color_map: u32,
    /// Where the normal map begins; [`NONE`]: there is none.
    pub normal_map: u32,
    /// Room for more.
    pub spare: [u32; 2],
}

/// A light in render space; see [`crate::frame::Light`].
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LightRow {
    /// Position, or unit direction towards the light.
    pub position: [f32; 3],
    /// `LIGHT_*`.
    pub kind: u32,
    /// Linear RGB.
    pub color: [f32; 3],
    /// Distance of fade factor 1; 0: no fade.
    pub fade_distance: f32,
    /// Unit axis of a spot's cone, away from the light.
    pub axis: [f32; 3],
    /// Power of the fade.
    pub fade_power: f32,
    /// Cosine of a spot's half angle of full light.
    pub cos_inner: f32,
    /// Cosine of a spot's half angle of no light.
    pub cos_outer: f32,
    /// What the distance's power is added to, plus 1 what it divides: 1; 0 where the falloff is exact.
    pub fade_core: f32,
    /// One over the distance from which on there is no light; 0: there is always some.
    pub range_inverse: f32,
}

/// A ray in render space.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct RayRow {
    /// Start.
    pub origin: [f32; 3],
    /// Hits need t > `t_min`.
    pub t_min: f32,
    /// Direction of any length; t counts in its length.
    pub dir: [f32; 3],
    /// Hits need t < `t_max`.
    pub t_max: f32,
}

/// What a ray met.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct HitRow {
    /// Distance in lengths of the ray's direction; finite but meaningless for a miss.
    pub t: f32,
    /// Barycentric weight of a triangle's second corner.
    pub u: f32,
    /// Barycentric weight of a triangle's third corner.
    pub v: f32,
    /// Row of instances; [`NONE`]: a miss. Any-hit queries: 0 free, 1 occluded.
    pub instance: u32,
    /// Primitive of the instance.
    pub prim: u32,
    /// Room for more.
    pub spare: [u32; 3],
}

/// What tracing a picture added up. On the device these are atomics.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct CounterRow {
    /// Camera rays.
    pub primary_rays: u32,
    /// Mirrored rays.
    pub reflected_rays: u32,
    /// Refracted and straight-through rays.
    pub refracted_rays: u32,
    /// Shadow rays.
    pub shadow_rays: u32,
    /// Entries into a medium that the list of media had no room for.
    pub media_overflows: u32,
    /// Rays ended for crossing more than `STRAIGHT_CAPACITY` surfaces of equal index.
    pub straight_overflows: u32,
    /// Rays left out for being too faint to matter.
    pub dropped_rays: u32,
    /// Pixels that differ from a neighbour and take more samples.
    pub edge_pixels: u32,
    /// Shadow rays left out to lights that the surface faces away from.
    pub away_shadows: u32,
    /// Those left out where nothing could come back.
    pub black_shadows: u32,
    /// Those left out for light too faint to matter.
    pub faint_shadows: u32,
    /// Reflected and refracted rays left out for their weight of 0.
    pub weightless_rays: u32,
}
