// What: the rows and constants that host and device share.
// Reads: nothing. Writes: nothing.
// Twin: engine/src/frame/wire.rs; a test compares names, order, offsets, sizes and values.
#define_import_path orrery::types

const NONE: u32 = 0xffffffffu;
const KIND_MESH: u32 = 0u;
const KIND_SPHERE: u32 = 1u;
const KIND_ELLIPSOID: u32 = 2u;
const KIND_CUBOID: u32 = 3u;
const KIND_PLANE: u32 = 4u;
const KIND_DISC: u32 = 5u;
const KIND_CONE: u32 = 6u;
const KIND_TORUS: u32 = 7u;
const CONE_OPEN: u32 = 1u;
const ROOT_OF_SPHERES: u32 = 0x80000000u;
const MATERIAL_FRESNEL: u32 = 1u;
const MATERIAL_MIRROR: u32 = 2u;
const MATERIAL_TRANSMITS: u32 = 4u;
const LOOK_UNPLACED: u32 = 0x80000000u;
const WRAP_REPEAT: u32 = 0u;
const WRAP_CLAMP: u32 = 1u;
const WRAP_MIRROR: u32 = 2u;
const TEXELS_SHIFT: u32 = 12u;
const LIGHT_POINT: u32 = 0u;
const LIGHT_DIRECTIONAL: u32 = 1u;
const LIGHT_SPOT: u32 = 2u;
const PROJECTION_PERSPECTIVE: u32 = 0u;
const PROJECTION_ORTHOGRAPHIC: u32 = 1u;
const QUERY_CLOSEST: u32 = 0u;
const QUERY_ANY: u32 = 1u;
const MEDIA_CAPACITY: u32 = 8u;
const GENERATIONS_CAPACITY: u32 = 64u;
const STRAIGHT_CAPACITY: u32 = 256u;
const SAMPLES_CAPACITY: u32 = 256u;
const SAMPLE_FIRST_CELL: u32 = 0x8080u;
const SAMPLE_COLUMN_A: u32 = 0xc4b2u;
const SAMPLE_COLUMN_B: u32 = 0xad6bu;
const SAMPLE_COLUMN_C: u32 = 0xf738u;
const SAMPLE_COLUMN_D: u32 = 0x801au;
const SAMPLE_COLUMN_E: u32 = 0xce0eu;
const SAMPLE_COLUMN_F: u32 = 0xa104u;
const SAMPLE_COLUMN_G: u32 = 0xfe03u;
const SAMPLE_COLUMN_H: u32 = 0x8e01u;
const TRAVERSAL_CAPACITY: u32 = 192u;
const CHILD_NONE: u32 = 0xffffffffu;
const CHILD_LEAF: u32 = 0x80000000u;
const LEAF_COUNT_SHIFT: u32 = 28u;
const LEAF_FIRST_MASK: u32 = 0x0fffffffu;
const STEP_KEYS: u32 = 0u;
const STEP_MORPH: u32 = 1u;
const STEP_SKIN: u32 = 2u;
const STEP_WAVE: u32 = 3u;
const STEP_TWIST: u32 = 4u;

struct ViewRow {
    forward: vec3f,
    width: u32,
    right_step: vec3f,
    height: u32,
    up_step: vec3f,
    samples: u32,
    background: vec3f,
    max_generations: u32,
    projection: u32,
    first_plane: u32,
    light_count: u32,
    root: u32,
    eye_from_anchor: vec3f,
    cutoff: f32,
    bounds: array<vec4f, 16>,
    spare: vec3u,
    edge_contrast: f32,
    zenith: vec3f,
    panorama: u32,
    ground: vec3f,
    panorama_turn: f32,
}

struct PassRow {
    first: u32,
    count: u32,
    query: u32,
    goes_on: u32,
    spare: vec3u,
    limit: u32,
}

struct Node4 {
    min_x: vec4f,
    min_y: vec4f,
    min_z: vec4f,
    max_x: vec4f,
    max_y: vec4f,
    max_z: vec4f,
    children: vec4u,
}

struct InstanceRow {
    local_from_world: array<vec4f, 3>,
    world_from_local: array<vec4f, 3>,
    kind: u32,
    material: u32,
    root: u32,
    first_triangle: u32,
    parameter: f32,
    mesh: u32,
    link: u32,
    first_normal: u32,
}

struct PlacedTriangleRow {
    corners: vec3u,
    spare: u32,
    a: vec3f,
    prim: u32,
    b: vec3f,
    spare_too: u32,
    c: vec3f,
    spare_also: u32,
}

struct VertexRow {
    vector: vec3f,
    further: u32,
}

struct MaterialRow {
    color: vec3f,
    diffuse: f32,
    reflection: vec3f,
    emission: f32,
    phong_strength: f32,
    phong_exponent: f32,
    specular_strength: f32,
    specular_exponent: f32,
    transmit: f32,
    filtered: f32,
    ior: f32,
    flags: u32,
    absorption: vec3f,
    alpha_cutoff: f32,
    color_map: u32,
    normal_map: u32,
    spare: array<u32, 2>,
}

struct LightRow {
    position: vec3f,
    kind: u32,
    color: vec3f,
    fade_distance: f32,
    axis: vec3f,
    fade_power: f32,
    cos_inner: f32,
    cos_outer: f32,
    fade_core: f32,
    range_inverse: f32,
}

struct RayRow {
    origin: vec3f,
    t_min: f32,
    dir: vec3f,
    t_max: f32,
}

struct HitRow {
    t: f32,
    u: f32,
    v: f32,
    instance: u32,
    prim: u32,
    spare: array<u32, 3>,
}

struct CounterRow {
    primary_rays: atomic<u32>,
    reflected_rays: atomic<u32>,
    refracted_rays: atomic<u32>,
    shadow_rays: atomic<u32>,
    media_overflows: atomic<u32>,
    straight_overflows: atomic<u32>,
    dropped_rays: atomic<u32>,
    edge_pixels: atomic<u32>,
    away_shadows: atomic<u32>,
    black_shadows: atomic<u32>,
    faint_shadows: atomic<u32>,
    weightless_rays: atomic<u32>,
}

struct StageRow {
    first: u32,
    count: u32,
    level: u32,
    levels: u32,
}

struct JobRow {
    first_group: u32,
    count: u32,
    first: u32,
    root: u32,
    first_triangle: u32,
    first_vertex: u32,
    partial: u32,
    rest: u32,
    step_count: u32,
    first_normal: u32,
    spare: array<u32, 2>,
}

struct StepRow {
    kind: u32,
    from_set: u32,
    to_set: u32,
    params: u32,
    count: u32,
    spare: array<u32, 3>,
}

struct BoxRow {
    min: vec3f,
    spare: u32,
    max: vec3f,
    spare_too: u32,
}

struct BuildRow {
    least: array<atomic<u32>, 3>,
    live: atomic<u32>,
    greatest: array<atomic<u32>, 3>,
    spare: u32,
    level_nodes: array<atomic<u32>, 16>,
    level_starts: array<u32, 16>,
}
