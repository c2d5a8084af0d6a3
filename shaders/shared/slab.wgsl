// What: a ray against the four boxes, or spheres, of a node.
// Reads: nothing. Writes: nothing.
// Twin: engine/src/geom/ray.rs and engine/src/trace/cpu/enter.rs.
#define_import_path orrery::slab

#import orrery::types::{CHILD_NONE, Node4}

// 1 + 4 ulp: the far side of a slab is widened by it (Ize 2013). Boxes are grown when they are built.
const FAR_WIDENING: f32 = 1.00000048;
// Beyond every box and hit, with room to multiply.
const FARTHEST: f32 = 1e30;

struct SlabRay {
    // What the least and the greatest sides of boxes are measured from: the origin, or a little beyond it.
    from_least: vec3f,
    from_greatest: vec3f,
    inverse: vec3f,
}

// The children a ray enters, farthest first; `near` is FARTHEST for those it does not.
struct Entered {
    near: vec4f,
    slot: vec4u,
}

// 1/x with |x| at least 1e-30, so no product in a slab test is 0 * inf, which WGSL leaves open.
fn slab_ray(origin: vec3f, dir: vec3f) -> SlabRay {
    let least = select(vec3f(1e-30), vec3f(-1e-30), dir < vec3f(0.0));
    return SlabRay(origin, origin, 1.0 / select(dir, least, abs(dir) < vec3f(1e-30)));
}

// The same whose origin may be off by `slack`: no box is missed that any such origin would meet.
fn slack_ray(origin: vec3f, slack: vec3f, dir: vec3f) -> SlabRay {
    return SlabRay(origin + slack, origin - slack, slab_ray(origin, dir).inverse);
}

// A ray for the boxes of trees.
fn tree_ray(origin: vec3f, slack: vec3f, dir: vec3f) -> SlabRay {
#ifdef BARE_BOXES
    return SlabRay(origin, origin, 1.0 / dir);
#else
    return slack_ray(origin, slack, dir);
#endif
}

#ifdef BARE_BOXES
// What boxes were grown by: see enter_bare_boxes in engine/src/trace/cpu/enter.rs.
fn growth(side: vec4f) -> vec4f {
    return max(abs(side) * 5.9604652e-8, vec4f(1e-20));
}

// The slab test as it is written down: nothing widened, and the growth of boxes taken off again.
fn enter_children(node: Node4, ray: SlabRay, least: f32, most: f32) -> Entered {
    let x_low = (node.min_x + growth(node.min_x) - ray.from_least.x) * ray.inverse.x;
    let x_high = (node.max_x - growth(node.max_x) - ray.from_least.x) * ray.inverse.x;
    let y_low = (node.min_y + growth(node.min_y) - ray.from_least.y) * ray.inverse.y;
    let y_high = (node.max_y - growth(node.max_y) - ray.from_least.y) * ray.inverse.y;
    let z_low = (node.min_z + growth(node.min_z) - ray.from_least.z) * ray.inverse.z;
    let z_high = (node.max_z - growth(node.max_z) - ray.from_least.z) * ray.inverse.z;
    let near = max(max(min(x_low, x_high), min(y_low, y_high)), max(min(z_low, z_high), vec4f(least)));
    let far = min(min(max(x_low, x_high), max(y_low, y_high)), min(max(z_low, z_high), vec4f(most)));
    let entered = (near <= far) & (node.children != vec4u(CHILD_NONE));
    return farthest_first(Entered(select(vec4f(FARTHEST), near, entered), select(vec4u(CHILD_NONE), node.children, entered)));
}
#else
// (side - origin) * inverse, never side * inverse - origin * inverse: that form loses up to 77 % of hits.
fn enter_children(node: Node4, ray: SlabRay, least: f32, most: f32) -> Entered {
    let x_low = (node.min_x - ray.from_least.x) * ray.inverse.x;
    let x_high = (node.max_x - ray.from_greatest.x) * ray.inverse.x;
    let y_low = (node.min_y - ray.from_least.y) * ray.inverse.y;
    let y_high = (node.max_y - ray.from_greatest.y) * ray.inverse.y;
    let z_low = (node.min_z - ray.from_least.z) * ray.inverse.z;
    let z_high = (node.max_z - ray.from_greatest.z) * ray.inverse.z;
    let near = max(max(min(x_low, x_high), min(y_low, y_high)), max(min(z_low, z_high), vec4f(least)));
    let far = min(min(max(x_low, x_high), max(y_low, y_high)), max(z_low, z_high)) * FAR_WIDENING;
    let entered = (near <= min(far, vec4f(most))) & (node.children != vec4u(CHILD_NONE));
    return farthest_first(Entered(select(vec4f(FARTHEST), near, entered), select(vec4u(CHILD_NONE), node.children, entered)));
}
#endif

// The child spheres a ray enters, in the order of boxes: centre in min_x, min_y, min_z, radius in max_x. Both
// are widened by what the test errs by, 2^-19 of the distance to the centre.
fn enter_spheres(node: Node4, origin: vec3f, dir: vec3f, least: f32, most: f32) -> Entered {
    let x = origin.x - node.min_x;
    let y = origin.y - node.min_y;
    let z = origin.z - node.min_z;
    let a = max(dot(dir, dir), 1e-30);
    let middle = (x * dir.x + y * dir.y + z * dir.z) / -a;
    let rest_x = x + dir.x * middle;
    let rest_y = y + dir.y * middle;
    let rest_z = z + dir.z * middle;
    let slack = sqrt(x * x + y * y + z * z) * 1.9073486e-6;
    let radius = node.max_x + slack;
    let inside = radius * radius - (rest_x * rest_x + rest_y * rest_y + rest_z * rest_z);
    let half = (sqrt(max(inside, vec4f(0.0))) + slack) * inverseSqrt(a);
    let near = max(middle - half, vec4f(least));
    let reached = (inside >= vec4f(0.0)) & (near <= min(middle + half, vec4f(most)));
    let entered = reached & (node.children != vec4u(CHILD_NONE));
    return farthest_first(Entered(select(vec4f(FARTHEST), near, entered), select(vec4u(CHILD_NONE), node.children, entered)));
}

// A sorting network of four, two comparisons at a time. What is not entered comes first.
fn farthest_first(e: Entered) -> Entered {
    let first = e.near.xz >= e.near.yw;
    let a = vec4f(max(e.near.xz, e.near.yw), min(e.near.xz, e.near.yw));
    let a_slot = vec4u(select(e.slot.yw, e.slot.xz, first), select(e.slot.xz, e.slot.yw, first));
    let second = a.xz >= a.yw;
    let b = vec4f(max(a.xz, a.yw), min(a.xz, a.yw));
    let b_slot = vec4u(select(a_slot.yw, a_slot.xz, second), select(a_slot.xz, a_slot.yw, second));
    // b: largest, larger of the smaller pair, smaller of the larger pair, smallest.
    let third = b.z >= b.y;
    let near = vec4f(b.x, select(b.y, b.z, third), select(b.z, b.y, third), b.w);
    let slot = vec4u(b_slot.x, select(b_slot.y, b_slot.z, third), select(b_slot.z, b_slot.y, third), b_slot.w);
    return Entered(near, slot);
}
