// What: a minimal kernel by hand for one kind of scene: opaque flat triangles under one point light.
// Reads: groups 0 and 1. Writes: pixels. It counts nothing, and knows no other shape, light or material.
// Shared with the tracer: the arithmetic of boxes and triangles. Stands in for shaders/whitted.wgsl; the picture is the same.
#import orrery::types::{CHILD_LEAF, CHILD_NONE, LEAF_COUNT_SHIFT, LEAF_FIRST_MASK, NONE}
#import orrery::scene::{instances, lights, materials, pass_row, triangles, view}
#import orrery::slab::{enter_children, tree_ray}
#import orrery::triangle::{hit_triangle, make_shear}

@group(2) @binding(0) var<storage, read_write> pixels: array<vec4f>;

const STACK: u32 = #{STACK}u;
const FARTHEST: f32 = 1e30;
const REACH: f32 = 1.00012207;
const ORIGIN_SLACK: f32 = 9.5367432e-7;
const FLATTEST: f32 = 0.015625;
const LEAST_COSINE: f32 = 1e-10;
const GAMMA_ONE: f32 = 5.96046483e-8;
const GAMMA_THREE: f32 = 1.78813966e-7;
const GAMMA_FIVE: f32 = 2.98023313e-7;

const LEAF_REST: u32 = ~(CHILD_LEAF | LEAF_FIRST_MASK);
const NEXT_TRIANGLE: u32 = (1u << LEAF_COUNT_SHIFT) - 1u;

var<private> stack: array<u32, STACK>;

struct Hit {
    t: f32,
    row: u32,
    triangle: u32,
}

fn vector(rows: array<vec4f, 3>, v: vec3f) -> vec3f {
    return vec3f(dot(rows[0].xyz, v), dot(rows[1].xyz, v), dot(rows[2].xyz, v));
}

fn point(rows: array<vec4f, 3>, p: vec3f) -> vec3f {
    return vector(rows, p) + vec3f(rows[0].w, rows[1].w, rows[2].w);
}

// The nearest triangle before `most`, or any; not the one it starts on.
fn meet(origin: vec3f, dir: vec3f, start: Hit, most: f32, any_will_do: bool) -> Hit {
    var best = Hit(most, NONE, NONE);
    let slack = (abs(origin) + abs(view.eye_from_anchor)) * ORIGIN_SLACK;
    var ray = tree_ray(origin + view.eye_from_anchor, slack, dir);
    var local = origin;
    var shear = make_shear(dir);
    var root = view.root;
    var mesh = NONE;
    var floor_depth = 0u;
    var depth = 0u;
    // Where one leaf is all of the tree, the root is that leaf.
    var slot = select(0u, view.root, (view.root & CHILD_LEAF) != 0u);
    loop {
        if slot == CHILD_NONE {
            if depth == 0u {
                break;
            }
            if mesh != NONE && depth == floor_depth {
                mesh = NONE;
                root = view.root;
                ray = tree_ray(origin + view.eye_from_anchor, slack, dir);
            }
            depth -= 1u;
            slot = stack[depth];
        }
        if mesh == NONE && (slot & CHILD_LEAF) != 0u {
            mesh = slot & LEAF_FIRST_MASK;
            let rows = instances[mesh].local_from_world;
            let local_dir = vector(rows, dir);
            local = point(rows, origin);
            ray = tree_ray(local, vec3f(0.0), local_dir);
            shear = make_shear(local_dir);
            root = instances[mesh].root;
            floor_depth = depth;
            slot = 0u;
        }
        if (slot & CHILD_LEAF) == 0u {
            let entered = enter_children(root + slot, ray, 0.0, best.t * REACH);
            depth = push(depth, entered.slot.x);
            depth = push(depth, entered.slot.y);
            depth = push(depth, entered.slot.z);
            slot = entered.slot.w;
        }
        if mesh != NONE && (slot & CHILD_LEAF) != 0u && slot != CHILD_NONE {
            let i = instances[mesh].first_triangle + (slot & LEAF_FIRST_MASK);
            let hit = hit_triangle(shear, local, triangles[i].a, triangles[i].b, triangles[i].c);
            let is_start = start.triangle == i && start.row == mesh;
            if hit.hits && hit.t > 0.0 && hit.t < best.t && !is_start {
                best = Hit(hit.t, mesh, i);
                if any_will_do {
                    return best;
                }
            }
            // The rest of the leaf, or none.
            slot = select(CHILD_NONE, slot - NEXT_TRIANGLE, (slot & LEAF_REST) != 0u);
        }
    }
    return best;
}

fn push(depth: u32, slot: u32) -> u32 {
    stack[min(depth, STACK - 1u)] = slot;
    return min(depth + select(1u, 0u, slot == CHILD_NONE), STACK - 1u);
}

fn step_off(height: f32, normal: vec3f, dir: vec3f) -> vec3f {
    let along = dot(normal, dir);
    let slide = height * along / max(along * along, dot(dir, dir) * FLATTEST);
    return dir * slide + normal * (height - slide * along);
}

fn radiance(dir: vec3f) -> vec3f {
    let hit = meet(vec3f(0.0), dir, Hit(0.0, NONE, NONE), FARTHEST, false);
    if hit.row == NONE {
        return view.background;
    }
    // The point on the triangle, and a bound on what it is off.
    let near = dir * hit.t;
    let rows = instances[hit.row].local_from_world;
    let local = point(rows, near);
    let a = triangles[hit.triangle].a;
    let ab = triangles[hit.triangle].b - a;
    let ac = triangles[hit.triangle].c - a;
    let from_corner = local - a;
    let face = cross(ab, ac);
    let unit = face / length(face);
    let spread = abs(ab.yzx) * abs(ac.zxy) + abs(ab.zxy) * abs(ac.yzx);
    let tilt = spread * (GAMMA_THREE / dot(face, unit));
    let own = dot(abs(unit), abs(from_corner) * 2.0 + abs(ab) + abs(ac)) * GAMMA_FIVE + 2.0 * dot(abs(from_corner), tilt);
    let gradient = rows[0].xyz * unit.x + rows[1].xyz * unit.y + rows[2].xyz * unit.z;
    let steepness = length(gradient);
    let outward = gradient / steepness;
    let linear = vec3f(dot(abs(rows[0].xyz), abs(near)), dot(abs(rows[1].xyz), abs(near)), dot(abs(rows[2].xyz), abs(near)));
    let mapped = linear * GAMMA_THREE + abs(local) * GAMMA_ONE;
    let error = (own + 2.0 * dot(abs(unit), mapped)) / steepness;
    let position = near - step_off(dot(unit, from_corner) / steepness, outward, dir);
    let normal = select(outward, -outward, dot(outward, dir) > 0.0);

    let line = lights[0].position - position;
    let to_light = line / length(line);
    let cosine = dot(normal, to_light);
    if cosine < LEAST_COSINE {
        return vec3f(0.0);
    }
    let reach = error + dot(abs(normal), abs(position)) * GAMMA_ONE;
    let origin = position + step_off(reach, normal, to_light);
    let beam = lights[0].position - origin;
    let distance = length(beam);
    if meet(origin, beam / distance, hit, distance, true).row != NONE {
        return vec3f(0.0);
    }
    let material = instances[hit.row].material;
    return lights[0].color * materials[material].color * (materials[material].diffuse * cosine);
}

@compute @workgroup_size(8, 8)
fn whitted(@builtin(global_invocation_id) at: vec3u) {
    if at.x < view.width && at.y < pass_row.count {
        let y = at.y + pass_row.first;
        let across = view.right_step * (2.0 * f32(at.x) + 1.0 - f32(view.width));
        let upward = view.up_step * (f32(view.height) - 2.0 * f32(y) - 1.0);
        pixels[y * view.width + at.x] = vec4f(radiance(normalize(view.forward + (across + upward))), 1.0);
    }
}
