// What: a ray against the four boxes, or spheres, of a node.
// Reads: nodes. Writes: nothing.
// Twin: engine/src/geom/ray.rs and engine/src/trace/cpu/enter.rs.
#define_import_path orrery::slab

#import orrery::types::CHILD_NONE
#import orrery::scene::nodes

// Beyond every box and hit, with room to multiply.
const FARTHEST: f32 = 1e30;
// Rows of 16 bytes of a node: its boxes' least x, y, z, their greatest, and its children.
const NODE_ROWS: u32 = 7u;

// A ray for the faces of a box.
struct SlabRay {
    origin: vec3f,
    inverse: vec3f,
}

// The children a ray enters, farthest first; `near` is FARTHEST for those it does not.
struct Entered {
    near: vec4f,
    slot: vec4u,
}

// 1/x with |x| at least `least`, so no product in a slab test is 0 * inf, which WGSL leaves open.
fn safe_reciprocal(dir: vec3f, least: vec3f) -> vec3f {
    return 1.0 / select(dir, select(least, -least, dir < vec3f(0.0)), abs(dir) < least);
}

fn slab_ray(origin: vec3f, dir: vec3f) -> SlabRay {
    return SlabRay(origin, safe_reciprocal(dir, vec3f(1e-30)));
}

// A plane, or number, of each of a node's children.
fn plane(row: u32) -> vec4f {
    return bitcast<vec4f>(nodes[row]);
}

#ifdef BARE_BOXES
// A ray for the boxes of trees.
struct TreeRay {
    origin: vec3f,
    inverse: vec3f,
}

fn tree_ray(origin: vec3f, slack: vec3f, dir: vec3f) -> TreeRay {
    return TreeRay(origin, 1.0 / dir);
}

// What boxes were grown by: see enter_bare_boxes in engine/src/trace/cpu/enter.rs.
fn growth(side: vec4f) -> vec4f {
    return max(abs(side) * 5.9604652e-8, vec4f(1e-20));
}

// The slab test as it is written down: nothing widened, and the growth of boxes taken off again.
fn enter_children(node: u32, ray: TreeRay, least: f32, most: f32) -> Entered {
    let first = node * NODE_ROWS;
    let x_low = (plane(first) + growth(plane(first)) - ray.origin.x) * ray.inverse.x;
    let y_low = (plane(first + 1u) + growth(plane(first + 1u)) - ray.origin.y) * ray.inverse.y;
    let z_low = (plane(first + 2u) + growth(plane(first + 2u)) - ray.origin.z) * ray.inverse.z;
    let x_high = (plane(first + 3u) - growth(plane(first + 3u)) - ray.origin.x) * ray.inverse.x;
    let y_high = (plane(first + 4u) - growth(plane(first + 4u)) - ray.origin.y) * ray.inverse.y;
    let z_high = (plane(first + 5u) - growth(plane(first + 5u)) - ray.origin.z) * ray.inverse.z;
    let near = max(max(min(x_low, x_high), min(y_low, y_high)), max(min(z_low, z_high), vec4f(least)));
    let far = min(min(max(x_low, x_high), max(y_low, y_high)), min(max(z_low, z_high), vec4f(most)));
    let children = nodes[first + 6u];
    return farthest_first(near, (near <= far) & (children != vec4u(CHILD_NONE)), children);
}
#else
// 1 + 4 ulp: the far side of a slab is widened by it (Ize 2013). Boxes are grown when they are built.
const FAR_WIDENING: f32 = 1.00000048;
// 2^-22: of the size of origin * inverse, four times what it errs by when it is rounded. It is rounded, `spare` is taken off it, and
// where fma is a product and a sum, the product of a plane as far away is rounded, too.
const TERM_SLACK: f32 = 2.3841858e-7;

// A ray for the boxes of trees: a plane at x is met at x * inverse + term. That form alone would lose up to 77 % of hits, as
// origin * inverse may be far larger than what is left of it: so what it errs by is in the terms. The CPU, where a fused product
// is not to be had everywhere, takes the origin off first instead; boxes only cull, so no hit depends on which.
struct TreeRay {
    inverse: vec3f,
    // Of the planes that boxes are entered by, a little too near, and of those they are left by, a little too far.
    near_term: vec3f,
    far_term: vec3f,
}

// The origin may be off by `slack`: no box is missed that any such origin would meet.
fn tree_ray(origin: vec3f, slack: vec3f, dir: vec3f) -> TreeRay {
    // Along an axis: what is put in place of 0 moves a ray by less than boxes are grown by, and terms stay in range.
    let inverse = safe_reciprocal(dir, max(vec3f(1e-30), (abs(origin) + slack) * 1e-36));
    let term = origin * inverse;
    let spare = abs(term) * TERM_SLACK + slack * abs(inverse);
    return TreeRay(inverse, -term - spare, spare - term);
}

fn enter_children(node: u32, ray: TreeRay, least: f32, most: f32) -> Entered {
    let first = node * NODE_ROWS;
    // Of three rows of least and three of greatest planes, those that boxes are entered by: by the directions' signs, asked at
    // every node, as registers are dearer.
    let near_row = 3u * (bitcast<vec3u>(ray.inverse) >> vec3u(31u));
    let x_near = along(plane(first + near_row.x), ray.inverse.x, ray.near_term.x);
    let y_near = along(plane(first + 1u + near_row.y), ray.inverse.y, ray.near_term.y);
    let z_near = along(plane(first + 2u + near_row.z), ray.inverse.z, ray.near_term.z);
    let x_far = along(plane(first + 3u - near_row.x), ray.inverse.x, ray.far_term.x);
    let y_far = along(plane(first + 4u - near_row.y), ray.inverse.y, ray.far_term.y);
    let z_far = along(plane(first + 5u - near_row.z), ray.inverse.z, ray.far_term.z);
    let near = bitcast<vec4f>(max(max(x_near, y_near), max(z_near, vec4i(bitcast<i32>(least)))));
    let far = bitcast<vec4f>(min(min(x_far, y_far), z_far)) * FAR_WIDENING;
    return farthest_first(near, near <= min(far, vec4f(most)), nodes[first + 6u]);
}

// Distances as whole numbers, in whose order they are as long as they are not negative. What is negative is less than all that
// are not, and which of two such numbers is the less matters to no box: none is entered before `least`, or left there.
fn along(planes: vec4f, inverse: f32, term: f32) -> vec4i {
    return bitcast<vec4i>(fma(planes, vec4f(inverse), vec4f(term)));
}
#endif

// The child spheres a ray enters, in the order of boxes: centre in the rows of least x, y, z, radius in that of greatest x. Both
// are widened by what the test errs by, 2^-19 of the distance to the centre.
fn enter_spheres(node: u32, origin: vec3f, dir: vec3f, least: f32, most: f32) -> Entered {
    let first = node * NODE_ROWS;
    let x = origin.x - plane(first);
    let y = origin.y - plane(first + 1u);
    let z = origin.z - plane(first + 2u);
    let a = max(dot(dir, dir), 1e-30);
    let middle = (x * dir.x + y * dir.y + z * dir.z) / -a;
    let rest_x = x + dir.x * middle;
    let rest_y = y + dir.y * middle;
    let rest_z = z + dir.z * middle;
    let slack = sqrt(x * x + y * y + z * z) * 1.9073486e-6;
    let radius = plane(first + 3u) + slack;
    let inside = radius * radius - (rest_x * rest_x + rest_y * rest_y + rest_z * rest_z);
    let half = (sqrt(max(inside, vec4f(0.0))) + slack) * inverseSqrt(a);
    let near = max(middle - half, vec4f(least));
    let reached = (inside >= vec4f(0.0)) & (near <= min(middle + half, vec4f(most)));
    let children = nodes[first + 6u];
    return farthest_first(near, reached & (children != vec4u(CHILD_NONE)), children);
}

// A sorting network of four, two comparisons at a time. What is not entered comes first, and is no child any more. No ray enters
// the box of a child that is not there: its least is the greatest number, and its greatest the least.
fn farthest_first(nears: vec4f, are_entered: vec4<bool>, children: vec4u) -> Entered {
    let e = Entered(select(vec4f(FARTHEST), nears, are_entered), select(vec4u(CHILD_NONE), children, are_entered));
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
