// What: one camera ray and all that follows from it: Whitted's recursion as a loop with a stack.
// Reads: materials and what traverse and light read. Writes: counts of rays, its own stack.
// Twin: engine/src/trace/cpu/path.rs.
#define_import_path orrery::path

#import orrery::types::{MATERIAL_FRESNEL, MATERIAL_MIRROR, MATERIAL_TRANSMITS, MaterialRow, NONE, PROJECTION_PERSPECTIVE, STRAIGHT_CAPACITY}
#import orrery::scene::{materials, view}
#import orrery::affine::unit_or
#import orrery::slab::FARTHEST
#import orrery::surface::{Surface, excluded_row, origin_towards, resolve}
#import orrery::traverse::{Probe, UNTIL_NEAREST, key_after, key_before, trace}
#import orrery::light::local_light
#ifdef TINTED
#import orrery::appear::appear
#endif
#ifdef SKY
#import orrery::sky::sky
#endif
#ifdef REFLECTION
#import orrery::counters::reflected_rays
#endif
#ifdef SCATTERS
#import orrery::counters::weightless_rays
#endif
#ifdef SKIPS_FAINT_RAYS
#import orrery::counters::dropped_rays
#import orrery::cutoff::{buys, most_added}
#endif
#ifdef TRANSMISSION
#import orrery::counters::{media_overflows, refracted_rays, straight_overflows}
#import orrery::media::{Media, cross_boundary, index_ratio, no_media}
#endif
#ifdef ABSORPTION
#import orrery::media::left_after
#endif

// Two indices closer than this, relatively, are one: the ray goes straight on.
const SAME_INDEX: f32 = 1e-6;

// A ray on its way, and its share of the pixel.
struct Travel {
    origin: vec3f,
    generation: u32,
    dir: vec3f,
    start_row: u32,
    weight: vec3f,
    start_prim: u32,
#ifdef FOOTPRINTS
    // Of its cone where it starts: as wide as a pixel, and as wide again each time it has gone as far. Mirrors and boundaries
    // count as flat.
    width: f32,
#endif
#ifdef TRANSMISSION
    straight: u32,
    media: Media,
#endif
}

#ifdef DEFERS
// One slot a generation: a deferred ray's slot is its parent hit's, and the followed ray's subtree ends
// before it is taken up.
const DEFERRED_SLOTS: u32 = #{DEFERRED_SLOTS}u;
var<private> deferred: array<Travel, DEFERRED_SLOTS>;
#endif

// A camera ray; `dir` is unit.
fn camera_travel(origin: vec3f, dir: vec3f) -> Travel {
    var ray: Travel;
    ray.origin = origin;
    ray.generation = 1u;
    ray.dir = dir;
    ray.start_row = NONE;
    ray.weight = vec3f(1.0);
    ray.start_prim = NONE;
#ifdef FOOTPRINTS
    ray.width = select(pixel_width(), 0.0, view.projection == PROJECTION_PERSPECTIVE);
#endif
#ifdef TRANSMISSION
    ray.media = no_media();
#endif
    return ray;
}

#ifdef FOOTPRINTS
// Width of a pixel: at distance 1, or at any where rays are parallel.
fn pixel_width() -> f32 {
    return 2.0 * length(view.up_step);
}

// What a cone widens by, a length.
fn cone_spread() -> f32 {
    return select(0.0, pixel_width(), view.projection == PROJECTION_PERSPECTIVE);
}
#endif

// Linear RGB seen along a camera ray, less at most what the purse holds.
fn radiance(camera_ray: Travel) -> vec3f {
    var sum = vec3f(0.0);
    var ray = camera_ray;
#ifdef DEFERS
    var waiting = 0u;
#endif
    loop {
        var goes_on = false;
        let probe = Probe(
            ray.origin, ray.dir, key_after(0.0), key_before(FARTHEST),
            ray.start_row, ray.start_prim, UNTIL_NEAREST,
        );
        let found = trace(probe);
#ifdef ABSORPTION
        ray.weight *= left_after(ray.media, found.key.t);
#endif
        if found.row == NONE {
#ifdef SKY
            sum += ray.weight * sky(ray.dir);
#else
            sum += ray.weight * view.background;
#endif
        } else {
            var surface = resolve(found, ray.origin, ray.dir);
#ifdef FOOTPRINTS
            surface.width = ray.width + cone_spread() * found.key.t;
#ifdef TINTED
            surface = appear(found, surface, ray.dir, surface.width);
#endif
#else
#ifdef TINTED
            surface = appear(found, surface, ray.dir, 0.0);
#endif
#endif
#ifdef ABSORPTION
            sum += ray.weight * local_light(surface, ray.dir, ray.weight, ray.media);
#else
            sum += ray.weight * local_light(surface, ray.dir, ray.weight);
#endif
#ifdef SCATTERS
            let scattered = scatter(ray, surface);
            goes_on = scattered.follows;
            ray = scattered.followed;
#ifdef DEFERS
            if scattered.defers && waiting < DEFERRED_SLOTS {
                deferred[waiting] = scattered.deferred;
                waiting += 1u;
            }
#endif
#endif
        }
#ifdef DEFERS
        if !goes_on && waiting > 0u {
            waiting -= 1u;
            ray = deferred[waiting];
            goes_on = true;
        }
#endif
        if !goes_on {
            break;
        }
    }
    return sum;
}

#ifdef SCATTERS
// The rays that leave a surface: one to follow now, one to take up after its subtree.
struct Scattered {
    follows: bool,
    followed: Travel,
#ifdef DEFERS
    defers: bool,
    deferred: Travel,
#endif
}

fn scatter(ray: Travel, surface: Surface) -> Scattered {
    var out: Scattered;
    out.followed = ray;
    let material = materials[surface.material];
    if (material.flags & (MATERIAL_FRESNEL | MATERIAL_MIRROR | MATERIAL_TRANSMITS)) == 0u {
        return out;
    }
    let eta = crossing_ratio(ray, surface, material);
    let cosine = clamp(-dot(ray.dir, surface.n_shade), 0.0, 1.0);
    var reflected = vec3f(0.0);
    var passed = vec3f(0.0);
    if (material.flags & MATERIAL_TRANSMITS) != 0u {
#ifdef TINTED
        passed = surface.color * material.filtered + vec3f(material.transmit);
#else
        passed = material.color * material.filtered + vec3f(material.transmit);
#endif
    }
    if (material.flags & MATERIAL_FRESNEL) != 0u {
        let share = fresnel(eta, cosine);
        reflected = vec3f(share);
        passed *= 1.0 - share;
    } else if (material.flags & MATERIAL_MIRROR) != 0u {
        reflected = material.reflection;
    }
    let k = 1.0 + eta * eta * (cosine * cosine - 1.0);
    let is_straight = abs(eta - 1.0) < SAME_INDEX;
    if any(passed > vec3f(0.0)) && !is_straight && k < 0.0 {
        // Total internal reflection takes everything.
        reflected = vec3f(1.0);
        passed = vec3f(0.0);
    }
#ifdef SKIPS_FAINT_RAYS
    let kept = affordable(ray, reflected, passed, is_straight);
    reflected *= kept.x;
    passed *= kept.y;
#endif
#ifdef TRANSMISSION
    if any(passed > vec3f(0.0)) {
        if is_straight {
            out = straight_on(ray, surface, passed);
        } else {
            let bent = ray.dir * eta + surface.n_shade * (eta * cosine - sqrt(k));
            out = refracted(ray, surface, unit_or(bent, ray.dir), passed);
        }
    }
#endif
#ifdef REFLECTION
    let weight = ray.weight * reflected;
    if any(reflected > vec3f(0.0)) && may_spawn(ray, weight) {
        reflected_rays += 1u;
        out = with_mirrored(out, ray, spawn(ray, surface, mirror(ray.dir, surface), weight));
    }
#endif
    return out;
}

#ifdef SKIPS_FAINT_RAYS
// 0 for the mirrored ray (x) and for the one that passes (y) if it is left out, else 1. The cheaper one is
// offered first: more are left out that way.
fn affordable(ray: Travel, reflected: vec3f, passed: vec3f, is_straight: bool) -> vec2f {
    let next = ray.generation + 1u;
    let mirrored = most_added(ray.weight * reflected, next);
    let onward = most_added(ray.weight * passed, select(next, ray.generation, is_straight));
    var kept = vec2f(1.0);
    if mirrored <= onward {
        kept.x = kept_share(mirrored);
        kept.y = kept_share(onward);
    } else {
        kept.y = kept_share(onward);
        kept.x = kept_share(mirrored);
    }
    return kept;
}

fn kept_share(cost: f32) -> f32 {
    if buys(cost) {
        dropped_rays += 1u;
        return 0.0;
    }
    return 1.0;
}
#endif

// Index of refraction here over there.
fn crossing_ratio(ray: Travel, surface: Surface, material: MaterialRow) -> f32 {
#ifdef TRANSMISSION
    return index_ratio(ray.media, surface.row, material.ior);
#else
    return 1.0 / material.ior;
#endif
}

// Rays past the last generation are black; of rays without weight the pixel takes nothing.
fn may_spawn(ray: Travel, weight: vec3f) -> bool {
    if ray.generation >= view.max_generations {
        return false;
    }
#ifdef SKIPS_WEIGHTLESS
    if all(weight == vec3f(0.0)) {
        weightless_rays += 1u;
        return false;
    }
#endif
    return true;
}

// A ray of the next generation.
fn spawn(ray: Travel, surface: Surface, dir: vec3f, weight: vec3f) -> Travel {
    var next = ray;
    next.origin = origin_towards(surface, dir);
    next.generation = ray.generation + 1u;
    next.dir = dir;
    next.start_row = excluded_row(surface);
    next.weight = weight;
    next.start_prim = surface.prim;
#ifdef FOOTPRINTS
    next.width = surface.width;
#endif
#ifdef TRANSMISSION
    next.straight = 0u;
#endif
    return next;
}

// Unpolarised Fresnel reflectance for eta = n_from / n_to (Cook and Torrance 1982); 1 in total reflection, and
// nothing between equal indices, where rounding would leave a trace of a ray.
fn fresnel(eta: f32, cosine: f32) -> f32 {
    if abs(eta - 1.0) < SAME_INDEX {
        return 0.0;
    }
    let g_squared = 1.0 / (eta * eta) + cosine * cosine - 1.0;
    if g_squared <= 0.0 {
        return 1.0;
    }
    let g = sqrt(g_squared);
    let plus = g + cosine;
    let minus = g - cosine;
    let s = minus / plus;
    let p = (cosine * plus - 1.0) / (cosine * minus + 1.0);
    return clamp(0.5 * s * s * (1.0 + p * p), 0.0, 1.0);
}

#ifdef REFLECTION
// The mirrored direction about the shading normal, or about the face's where that would dip below it.
fn mirror(dir: vec3f, surface: Surface) -> vec3f {
    let smooth_dir = mirror_about(dir, surface.n_shade);
    if dot(smooth_dir, surface.n_geom) > 0.0 {
        return smooth_dir;
    }
    return mirror_about(dir, surface.n_geom);
}

fn mirror_about(dir: vec3f, normal: vec3f) -> vec3f {
    return unit_or(dir - normal * (2.0 * dot(dir, normal)), normal);
}

// Adds the mirrored ray: it is followed if it is alone, or if the other one stays in this generation and
// so may wait in this generation's slot.
fn with_mirrored(so_far: Scattered, ray: Travel, mirrored: Travel) -> Scattered {
    var out = so_far;
#ifdef DEFERS
    if so_far.follows {
        out.defers = true;
        if so_far.followed.generation == ray.generation {
            out.deferred = so_far.followed;
        } else {
            out.deferred = mirrored;
            return out;
        }
    }
#endif
    out.follows = true;
    out.followed = mirrored;
    return out;
}
#endif

#ifdef TRANSMISSION
fn refracted(ray: Travel, surface: Surface, dir: vec3f, factor: vec3f) -> Scattered {
    var out: Scattered;
    out.followed = ray;
    let weight = ray.weight * factor;
    if !may_spawn(ray, weight) {
        return out;
    }
    out.follows = true;
    out.followed = entered(spawn(ray, surface, dir, weight), surface.row);
    return out;
}

// The same ray beyond a boundary of equal indices, in the same generation; none once it crossed too many.
fn straight_on(ray: Travel, surface: Surface, factor: vec3f) -> Scattered {
    var out: Scattered;
    out.followed = ray;
    if ray.straight == STRAIGHT_CAPACITY {
        straight_overflows += 1u;
        return out;
    }
    var onward = spawn(ray, surface, ray.dir, ray.weight * factor);
    onward.generation = ray.generation;
    onward.straight = ray.straight + 1u;
    out.follows = true;
    out.followed = entered(onward, surface.row);
    return out;
}

// The ray with its list of media as it is beyond the boundary.
fn entered(ray: Travel, row: u32) -> Travel {
    var beyond = ray;
    let crossed = cross_boundary(ray.media, row);
    beyond.media = crossed.media;
    refracted_rays += 1u;
    if crossed.overflows {
        media_overflows += 1u;
    }
    return beyond;
}
#endif
#endif
