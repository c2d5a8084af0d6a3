// What: finding hits: one walk over the two levels of trees for closest, any-hit and shadow rays.
// Reads: nodes, triangles, instances. Writes: its own stack.
// Twin: engine/src/trace/cpu/traverse.rs.
#define_import_path orrery::traverse

#import orrery::types::{CHILD_LEAF, CHILD_NONE, InstanceRow, KIND_CONE, KIND_CUBOID, KIND_DISC, KIND_ELLIPSOID, KIND_MESH, KIND_SPHERE, KIND_TORUS, LEAF_COUNT_SHIFT, LEAF_FIRST_MASK, NONE, ROOT_OF_SPHERES}
#import orrery::scene::{instances, triangles, view}
#ifdef TRANSMISSION
#import orrery::scene::materials
#import orrery::types::MATERIAL_TRANSMITS
#endif
#import orrery::affine::{map_point, map_vector}
#import orrery::slab::{Entered, TreeRay, enter_children, tree_ray}
#ifdef SPHERE_TREES
#import orrery::slab::enter_spheres
#endif
#ifdef MESHES
#import orrery::triangle::{Shear, hit_triangle, make_shear}
#endif
#ifdef CUTOUTS
#import orrery::look::is_hole
#endif
#ifdef SPHERES
#import orrery::sphere::{hit_sphere, sphere_frame, unit_sphere}
#endif
#ifdef CUBOIDS
#import orrery::cuboid::hit_cuboid
#import orrery::slab::slab_ray
#endif
#ifdef DISCS
#import orrery::disc::hit_disc
#endif
#ifdef CONES
#import orrery::cone::hit_cone
#endif
#ifdef OPEN_CONES
#import orrery::cone::CONE_SIDE
#import orrery::types::CONE_OPEN
#endif
#ifdef TORI
#import orrery::torus::hit_torus
#endif

// 1 + 2^-13: a box may begin so far behind the best hit and still hold a nearer one. The t of a triangle that a ray grazes
// errs by hundreds of ulps here, as it does not on the CPU, and no answer may depend on which box came first.
const REACH: f32 = 1.00012207;
// 2^-20: what a ray's origin errs by, of its size, in the space of the instance tree's boxes or of an instance.
const ORIGIN_SLACK: f32 = 9.5367432e-7;

// Orders hits by t, then instance, then primitive: no answer depends on trees.
struct Key {
    t: f32,
    id: u32,
    prim: u32,
}

// A ray, and the hits it asks for: those with after < key < before.
struct Probe {
    origin: vec3f,
    dir: vec3f,
    after: Key,
    before: Key,
    // The primitive it starts on (by instance row), which it cannot hit; a sphere answers with its other root.
    start_row: u32,
    start_prim: u32,
    // Which hit ends the search, though nearer ones may be left: UNTIL_NEAREST, UNTIL_ANY or UNTIL_OPAQUE.
    until: u32,
}

// No hit ends the search: the nearest is found.
const UNTIL_NEAREST: u32 = 0u;
// Any hit ends it.
const UNTIL_ANY: u32 = 1u;
// A hit that lets no light through ends it, however much glass is before it: of what a shadow ray meets, that decides.
const UNTIL_OPAQUE: u32 = 2u;

// row == NONE: no hit.
struct Found {
    key: Key,
    row: u32,
    triangle: u32,
    uv: vec2f,
}

// Of a leaf: how many triangles there are beside its first, and what leads to the leaf without that one.
const LEAF_REST: u32 = ~(CHILD_LEAF | LEAF_FIRST_MASK);
const NEXT_TRIANGLE: u32 = (1u << LEAF_COUNT_SHIFT) - 1u;

const STACK: u32 = #{STACK}u;
// Private rather than local: cleared once an invocation, not once a ray. Slots alone, without the distances
// at which their boxes begin: testing a box in vain costs less than a second array (measured, 4.4 times).
var<private> stack: array<u32, STACK>;

fn key_after(t: f32) -> Key {
    return Key(t, NONE, NONE);
}

fn key_before(t: f32) -> Key {
    return Key(t, 0u, 0u);
}

fn is_before(a: Key, b: Key) -> bool {
    return a.t < b.t || (a.t == b.t && (a.id < b.id || (a.id == b.id && a.prim < b.prim)));
}

// The better of the best so far and a candidate.
fn offer(probe: Probe, best: Found, candidate: Found) -> Found {
    if is_before(probe.after, candidate.key) && is_before(candidate.key, best.key) {
        return candidate;
    }
    return best;
}

// Whether the best hit so far ends the search.
fn ends(probe: Probe, best: Found) -> bool {
    if probe.until == UNTIL_NEAREST || best.row == NONE {
        return false;
    }
#ifdef TRANSMISSION
    if probe.until == UNTIL_OPAQUE {
        return (materials[instances[best.row].material].flags & MATERIAL_TRANSMITS) == 0u;
    }
#endif
    return true;
}

// The nearest hit a probe asks for, or one that ends the search.
fn trace(probe: Probe) -> Found {
    var best = Found(probe.before, NONE, NONE, vec2f(0.0));
#ifdef PLANES
    best = trace_planes(probe, best);
#endif
    if view.root == NONE || ends(probe, best) {
        return best;
    }
    return trace_trees(probe, best);
}

#ifdef PLANES
fn trace_planes(probe: Probe, so_far: Found) -> Found {
    var best = so_far;
    for (var row = view.first_plane; row != NONE; row = instances[row].link) {
        let plane = instances[row].local_from_world[0];
        let along = dot(plane.xyz, probe.dir);
        if along != 0.0 && probe.start_row != row {
            let t = (plane.w - dot(plane.xyz, probe.origin)) / along;
            best = offer(probe, best, Found(Key(t, row, 0u), row, NONE, vec2f(0.0)));
        }
    }
    return best;
}
#endif

// A ray in the space of a tree.
struct Walk {
    ray: TreeRay,
    // Node of the tree's root; its slots count from there.
    root: u32,
    origin: vec3f,
#ifdef MESHES
    // NONE in the tree over instances.
    mesh: u32,
    shear: Shear,
#endif
#ifdef SPHERE_TREES
    in_spheres: bool,
    dir: vec3f,
#endif
}

#ifdef INSTANCES
// In the tree over instances, whose boxes are about an anchor.
fn walk_instances(probe: Probe) -> Walk {
    var walk: Walk;
    let slack = (abs(probe.origin) + abs(view.eye_from_anchor)) * ORIGIN_SLACK;
    walk.ray = tree_ray(probe.origin + view.eye_from_anchor, slack, probe.dir);
    walk.root = view.root;
#ifdef MESHES
    walk.mesh = NONE;
#endif
    return walk;
}
#endif

#ifdef MESHES
// In the tree of a mesh.
fn walk_mesh(probe: Probe, row: u32) -> Walk {
    var walk: Walk;
    let rows = instances[row].local_from_world;
    let dir = map_vector(rows, probe.dir);
    walk.origin = map_point(rows, probe.origin);
    walk.ray = tree_ray(walk.origin, vec3f(0.0), dir);
    walk.shear = make_shear(dir);
    walk.root = instances[row].root & ~ROOT_OF_SPHERES;
    walk.mesh = row;
#ifdef SPHERE_TREES
    walk.in_spheres = walk.root != instances[row].root;
    walk.dir = dir;
#endif
    return walk;
}
#endif

fn enter(walk: Walk, slot: u32, least: f32, most: f32) -> Entered {
#ifdef SPHERE_TREES
    if walk.in_spheres {
        return enter_spheres(walk.root + slot, walk.origin, walk.dir, least, most);
    }
#endif
    return enter_children(walk.root + slot, walk.ray, least, most);
}

#ifdef INSTANCES
// Whether a slot is a leaf of the tree over instances.
fn is_instance(walk: Walk, slot: u32) -> bool {
#ifdef MESHES
    if walk.mesh != NONE {
        return false;
    }
#endif
    return (slot & CHILD_LEAF) != 0u;
}
#endif

#ifdef MESHES
// Whether a slot is a leaf, or the rest of one, of a mesh's tree.
fn is_triangle(walk: Walk, slot: u32) -> bool {
    return walk.mesh != NONE && (slot & CHILD_LEAF) != 0u && slot != CHILD_NONE;
}
#endif

// One loop over both levels: at a mesh the ray and the tree are changed for the mesh's, and changed back once the stack has
// shrunk to where it was. A scene that is one mesh has one level. In a turn a ray may take a slot off the stack, go into an
// instance, a node and a triangle, one after the other: rays side by side take every step that any of them takes, so a ray
// that took only one of them a turn would idle through the others.
fn trace_trees(probe: Probe, so_far: Found) -> Found {
    var best = so_far;
    var depth = 0u;
#ifdef INSTANCES
    var walk = walk_instances(probe);
    var floor_depth = 0u;
    var slot = select(0u, view.root, (view.root & CHILD_LEAF) != 0u);
#else
    let walk = walk_mesh(probe, view.root & LEAF_FIRST_MASK);
    var slot = 0u;
#endif
    loop {
        if slot == CHILD_NONE {
            if depth == 0u {
                break;
            }
#ifdef INSTANCES
#ifdef MESHES
            if walk.mesh != NONE && depth == floor_depth {
                walk = walk_instances(probe);
            }
#endif
#endif
            depth -= 1u;
            slot = stack[depth];
        }
#ifdef INSTANCES
        if is_instance(walk, slot) {
            let row = slot & LEAF_FIRST_MASK;
            slot = CHILD_NONE;
#ifdef MESHES
            if instances[row].kind == KIND_MESH {
                walk = walk_mesh(probe, row);
                floor_depth = depth;
                slot = 0u;
            } else {
                best = offer_solid(probe, best, row);
            }
#else
            best = offer_solid(probe, best, row);
            // Solids alone: the rest of the turn is for the next slot.
            if depth > 0u {
                depth -= 1u;
                slot = stack[depth];
            }
#endif
            if ends(probe, best) {
                return best;
            }
        }
#endif
        if (slot & CHILD_LEAF) == 0u {
            let entered = enter(walk, slot, probe.after.t, best.key.t * REACH);
            depth = push(depth, entered.slot.x);
            depth = push(depth, entered.slot.y);
            depth = push(depth, entered.slot.z);
            slot = entered.slot.w;
        }
#ifdef MESHES
        if is_triangle(walk, slot) {
            best = offer_triangle(probe, best, walk, slot & LEAF_FIRST_MASK);
            if ends(probe, best) {
                return best;
            }
            // The same leaf from its next triangle on, or none.
            slot = select(CHILD_NONE, slot - NEXT_TRIANGLE, (slot & LEAF_REST) != 0u);
        }
#endif
    }
    return best;
}

// Written where there is nothing to keep, too: the next slot goes over it, and no ray turns aside for it. So one place more is there
// than trees need; should one ever need more, boxes are lost rather than memory.
fn push(depth: u32, slot: u32) -> u32 {
    stack[min(depth, STACK - 1u)] = slot;
    return min(depth + select(1u, 0u, slot == CHILD_NONE), STACK - 1u);
}

#ifdef MESHES
// A triangle of the mesh that is walked, by its place in the order of leaves.
fn offer_triangle(probe: Probe, best: Found, walk: Walk, place: u32) -> Found {
    let mesh = walk.mesh;
    let index = instances[mesh].first_triangle + place;
    let prim = triangles[index].prim;
    let hit = hit_triangle(walk.shear, walk.origin, triangles[index].a, triangles[index].b, triangles[index].c);
    if !hit.hits || (probe.start_row == mesh && probe.start_prim == prim) {
        return best;
    }
#ifdef CUTOUTS
    if hit.t <= best.key.t && is_hole(mesh, index, vec2f(hit.u, hit.v)) {
        return best;
    }
#endif
    return offer(probe, best, Found(Key(hit.t, mesh, prim), mesh, index, vec2f(hit.u, hit.v)));
}
#endif

// Everything but meshes and planes.
fn offer_solid(probe: Probe, so_far: Found, row: u32) -> Found {
    var best = so_far;
    let kind = instances[row].kind;
#ifdef CUBOIDS
    if kind == KIND_CUBOID {
        let rows = instances[row].local_from_world;
        let hit = hit_cuboid(slab_ray(map_point(rows, probe.origin), map_vector(rows, probe.dir)));
        let starts_on = hit.hits && probe.start_row == row;
        if hit.hits && !(starts_on && probe.start_prim == hit.near_face) {
            best = offer(probe, best, Found(Key(hit.near, row, hit.near_face), row, NONE, vec2f(0.0)));
        }
        if hit.hits && !(starts_on && probe.start_prim == hit.far_face) {
            best = offer(probe, best, Found(Key(hit.far, row, hit.far_face), row, NONE, vec2f(0.0)));
        }
        return best;
    }
#endif
#ifdef DISCS
    if kind == KIND_DISC {
        return offer_disc(probe, best, row);
    }
#endif
#ifdef CONES
    if kind == KIND_CONE {
        return offer_cone(probe, best, row);
    }
#endif
#ifdef TORI
    if kind == KIND_TORUS {
        return offer_torus(probe, best, row);
    }
#endif
#ifdef SPHERES
    let rows = instances[row].local_from_world;
    var sphere = sphere_frame(rows[0], rows[1]);
    var origin = probe.origin;
    var dir = probe.dir;
    if kind == KIND_ELLIPSOID {
        sphere = unit_sphere();
        origin = map_point(rows, probe.origin);
        dir = map_vector(rows, probe.dir);
    }
    let roots = hit_sphere(sphere, origin, dir, probe.start_row == row);
    if roots.hits {
        best = offer(probe, best, Found(Key(roots.near, row, 0u), row, NONE, vec2f(0.0)));
        best = offer(probe, best, Found(Key(roots.far, row, 0u), row, NONE, vec2f(0.0)));
    }
#endif
    return best;
}

#ifdef DISCS
fn offer_disc(probe: Probe, best: Found, row: u32) -> Found {
    let rows = instances[row].local_from_world;
    let hit = hit_disc(map_point(rows, probe.origin), map_vector(rows, probe.dir));
    if !hit.hits || probe.start_row == row {
        return best;
    }
    return offer(probe, best, Found(Key(hit.t, row, 0u), row, NONE, vec2f(0.0)));
}
#endif

#ifdef CONES
fn offer_cone(probe: Probe, so_far: Found, row: u32) -> Found {
    let rows = instances[row].local_from_world;
    let start = select(NONE, probe.start_prim, probe.start_row == row);
    var hit = hit_cone(map_point(rows, probe.origin), map_vector(rows, probe.dir), instances[row].parameter, start);
#ifdef OPEN_CONES
    // The side of the closed one: what enters or leaves that by a cap misses it there.
    if instances[row].root == CONE_OPEN {
        hit.enters = hit.enters && hit.near_prim == CONE_SIDE;
        hit.leaves = hit.leaves && hit.far_prim == CONE_SIDE;
    }
#endif
    var best = so_far;
    if hit.enters {
        best = offer(probe, best, Found(Key(hit.near, row, hit.near_prim), row, NONE, vec2f(0.0)));
    }
    if hit.leaves {
        best = offer(probe, best, Found(Key(hit.far, row, hit.far_prim), row, NONE, vec2f(0.0)));
    }
    return best;
}
#endif

#ifdef TORI
fn offer_torus(probe: Probe, so_far: Found, row: u32) -> Found {
    let rows = instances[row].local_from_world;
    let origin = map_point(rows, probe.origin);
    let roots = hit_torus(origin, map_vector(rows, probe.dir), instances[row].parameter, probe.start_row == row);
    var best = offer(probe, so_far, Found(Key(roots.x, row, 0u), row, NONE, vec2f(0.0)));
    best = offer(probe, best, Found(Key(roots.y, row, 0u), row, NONE, vec2f(0.0)));
    best = offer(probe, best, Found(Key(roots.z, row, 0u), row, NONE, vec2f(0.0)));
    return offer(probe, best, Found(Key(roots.w, row, 0u), row, NONE, vec2f(0.0)));
}
#endif
