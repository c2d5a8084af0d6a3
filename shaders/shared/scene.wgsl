// What: the bindings that every kernel reads: groups 0 (frame) and 1 (scene).
// Reads: the rows of types.wgsl. Writes: nothing.
// Twin: engine/src/trace/gpu/layout.rs.
#define_import_path orrery::scene

#import orrery::types::{InstanceRow, LightRow, MaterialRow, PassRow, PlacedTriangleRow, VertexRow, ViewRow}

@group(0) @binding(0) var<uniform> view: ViewRow;
@group(0) @binding(1) var<uniform> pass_row: PassRow;

// Node4, as rows of 16 bytes: which of its planes a ray meets first decides which row is read.
@group(1) @binding(0) var<storage, read> nodes: array<vec4u>;
@group(1) @binding(1) var<storage, read> triangles: array<PlacedTriangleRow>;
@group(1) @binding(2) var<storage, read> vertices: array<VertexRow>;
@group(1) @binding(3) var<storage, read> instances: array<InstanceRow>;
@group(1) @binding(4) var<storage, read> materials: array<MaterialRow>;
@group(1) @binding(5) var<storage, read> lights: array<LightRow>;
