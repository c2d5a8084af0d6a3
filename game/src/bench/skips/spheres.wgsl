// What: a minimal kernel by hand for one kind of scene: opaque spheres under one point light; with REFLECTION, mirrors.
// Reads: groups 0 and 1. Writes: pixels. It counts nothing, and knows no other shape, light or material.
// Shared with the tracer: the arithmetic of boxes and spheres. Stands in for shaders/whitted.wgsl; the picture is the same.
#import orrery::types::{CHILD_LEAF, CHILD_NONE, LEAF_FIRST_MASK, NONE}
#import orrery::scene::{instances, lights, materials, pass_row, view}
#import orrery::slab::{enter_children, tree_ray}
#import orrery::sphere::{hit_sphere, sphere_frame, sphere_height}

@group(2) @binding(0) var<storage, read_write> pixels: array<vec4f>;

const STACK: u32 = #{STACK}u;
const FARTHEST: f32 = 1e30;
const REACH: f32 = 1.00012207;
const ORIGIN_SLACK: f32 = 9.5367432e-7;
const FLATTEST: f32 = 0.015625;
const LEAST_COSINE: f32 = 1e-10;

var<private> stack: array<u32, STACK>;

struct Hit {
    t: f32,
    row: u32,
}

// The nearest sphere before `most`, or any.
fn meet(origin: vec3f, dir: vec3f, start: u32, most: f32, any_will_do: bool) -> Hit {
    var best = Hit(most, NONE);
    let slack = (abs(origin) + abs(view.eye_from_anchor)) * ORIGIN_SLACK;
    let ray = tree_ray(origin + view.eye_from_anchor, slack, dir);
    var depth = 0u;
    // Where one leaf is all of the tree, the root is that leaf.
    var slot = select(0u, view.root, (view.root & CHILD_LEAF) != 0u);
    loop {
        if (slot & CHILD_LEAF) == 0u {
            let entered = enter_children(view.root + slot, ray, 0.0, best.t * REACH);
            if entered.slot.w != CHILD_NONE {
                depth = push(depth, entered.slot.x);
                depth = push(depth, entered.slot.y);
                depth = push(depth, entered.slot.z);
                slot = entered.slot.w;
                continue;
            }
        } else {
            let row = slot & LEAF_FIRST_MASK;
            let rows = instances[row].local_from_world;
            let roots = hit_sphere(sphere_frame(rows[0], rows[1]), origin, dir, row == start);
            let t = select(roots.far, roots.near, roots.near > 0.0);
            if roots.hits && t > 0.0 && t < best.t {
                best = Hit(t, row);
                if any_will_do {
                    return best;
                }
            }
        }
        if depth == 0u {
            break;
        }
        depth -= 1u;
        slot = stack[depth];
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

// Where a ray along `dir` starts.
fn leave(position: vec3f, error: f32, normal: vec3f, dir: vec3f) -> vec3f {
    let reach = error + dot(abs(normal), abs(position)) * 5.96046483e-8;
    return position + step_off(select(-reach, reach, dot(normal, dir) >= 0.0), normal, dir);
}

fn radiance(camera_dir: vec3f) -> vec3f {
    var sum = vec3f(0.0);
    var weight = vec3f(1.0);
    var origin = vec3f(0.0);
    var dir = camera_dir;
    var start = NONE;
    for (var generation = 1u; generation <= view.max_generations; generation++) {
        let hit = meet(origin, dir, start, FARTHEST, false);
        if hit.row == NONE {
            return sum + weight * view.background;
        }
        let near = origin + dir * hit.t;
        let rows = instances[hit.row].local_from_world;
        let over = sphere_height(sphere_frame(rows[0], rows[1]), near);
        let position = near - step_off(over.height, over.normal, dir);
        let normal = select(over.normal, -over.normal, dot(over.normal, dir) > 0.0);
        let material = instances[hit.row].material;
        let line = lights[0].position - position;
        let to_light = line / length(line);
        let cosine = dot(normal, to_light);
        if cosine >= LEAST_COSINE {
            let lit_from = leave(position, over.error, normal, to_light);
            let beam = lights[0].position - lit_from;
            let distance = length(beam);
            if meet(lit_from, beam / distance, hit.row, distance, true).row == NONE {
                sum += weight * lights[0].color * materials[material].color * (materials[material].diffuse * cosine);
            }
        }
#ifdef REFLECTION
        weight *= materials[material].reflection;
        let mirrored = normalize(dir - normal * (2.0 * dot(dir, normal)));
        origin = leave(position, over.error, normal, mirrored);
        dir = mirrored;
        start = hit.row;
#else
        break;
#endif
    }
    return sum;
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
