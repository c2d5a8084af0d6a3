// What: light that reaches a surface from the lamps (POV-Ray's model), with tinted shadows.
// Reads: lights, materials, instances and what traverse reads. Writes: the count of shadow rays.
// Twin: engine/src/trace/cpu/light.rs.
#define_import_path orrery::light

#import orrery::types::{LIGHT_DIRECTIONAL, LIGHT_SPOT, LightRow, MATERIAL_TRANSMITS, MaterialRow, NONE}
#import orrery::scene::{instances, lights, materials, view}
#import orrery::affine::unit_or
#import orrery::slab::FARTHEST
#import orrery::surface::{Surface, excluded_row, origin_towards}
#import orrery::traverse::{Probe, UNTIL_ANY, UNTIL_OPAQUE, key_after, key_before, trace}
#import orrery::counters::{away_shadows, black_shadows, faint_shadows, shadow_rays}
#ifdef SKIPS_FAINT_LIGHTS
#import orrery::cutoff::buys
#endif
#ifdef TINTED
#import orrery::look::tint
#endif
#ifdef ABSORPTION
#import orrery::media::{Media, cross_boundary, left_after}
#endif

// Below this cosine a light does not count (the model's own bound).
const LEAST_COSINE: f32 = 1e-10;

#ifdef FADE
// Least power of the distance that an exact falloff divides by.
const FADE_NEAREST: f32 = 1e-8;
#endif

// The line from a surface to a light; `dir` is unit.
struct Beam {
    dir: vec3f,
    distance: f32,
}

// Emission, and what every light adds, seen along `dir` by a ray of this weight.
fn local_light(
    surface: Surface,
    dir: vec3f,
    weight: vec3f,
#ifdef ABSORPTION
    media: Media,
#endif
) -> vec3f {
    let material = materials[surface.material];
    let opaque = max(1.0 - material.filtered - material.transmit, 0.0);
#ifdef TINTED
    let color = surface.color;
#else
    let color = material.color;
#endif
    var sum = color * (material.emission * opaque);
    if material.diffuse * opaque == 0.0 && material.phong_strength == 0.0 && material.specular_strength == 0.0 {
#ifdef SKIPS_BLACK
        black_shadows += view.light_count;
        return sum;
#endif
    }
    for (var index = 0u; index < view.light_count; index++) {
        let light = lights[index];
        let beam = beam_to(light, surface.position);
        let cosine = dot(surface.n_shade, beam.dir);
        var is_away = dot(surface.n_geom, beam.dir) < LEAST_COSINE;
#ifdef CURVED
        // A curved surface faces the light where its normal does, whatever its triangle does.
        is_away = is_away && !surface.is_curved;
#endif
        var strength = vec3f(0.0);
        var answer = vec3f(0.0);
        if cosine < LEAST_COSINE || is_away {
#ifdef SKIPS_AWAY
            away_shadows += 1u;
            continue;
#endif
        } else {
            strength = beam_strength(light, beam);
            answer = color * (material.diffuse * opaque * cosine)
                + vec3f(highlights(material, surface.n_shade, dir, beam.dir));
#ifdef SKIPS_BLACK
            if all(strength == vec3f(0.0)) || all(answer == vec3f(0.0)) {
                black_shadows += 1u;
                continue;
            }
#endif
#ifdef SKIPS_FAINT_LIGHTS
            // Shadows take light away, and add none.
            let most = abs(weight * strength * answer);
            if buys(max(most.x, max(most.y, most.z))) {
                faint_shadows += 1u;
                continue;
            }
#endif
        }
#ifdef ABSORPTION
        sum += shadow(surface, light, beam.dir, media) * strength * answer;
#else
        sum += shadow(surface, light, beam.dir) * strength * answer;
#endif
    }
    return sum;
}

fn beam_to(light: LightRow, point: vec3f) -> Beam {
#ifdef DIRECTIONAL_LIGHTS
    if light.kind == LIGHT_DIRECTIONAL {
        return Beam(light.position, FARTHEST);
    }
#endif
    let line = light.position - point;
    let distance = length(line);
    return Beam(line / max(distance, 1.17549435e-38), distance);
}

// The light's colour after fading and its cone.
fn beam_strength(light: LightRow, beam: Beam) -> vec3f {
    var factor = 1.0;
#ifdef FADE
    if light.fade_distance > 0.0 {
        let gone = power(beam.distance / light.fade_distance, light.fade_power);
        factor = (1.0 + light.fade_core) / max(light.fade_core + gone, FADE_NEAREST);
        let within = min(beam.distance * light.range_inverse, 1.0);
        factor *= 1.0 - within * within * (within * within);
    }
#endif
#ifdef SPOT_LIGHTS
    if light.kind == LIGHT_SPOT {
        let cosine = -dot(beam.dir, light.axis);
        let x = clamp((cosine - light.cos_outer) / (light.cos_inner - light.cos_outer), 0.0, 1.0);
        factor *= x * x * (3.0 - 2.0 * x);
    }
#endif
    return light.color * factor;
}

// Phong about the mirrored eye ray, Blinn-Phong about the half vector; neither is tinted.
fn highlights(material: MaterialRow, normal: vec3f, dir: vec3f, to_light: vec3f) -> f32 {
    var sum = 0.0;
    if material.phong_strength != 0.0 {
        let mirrored = dir - normal * (2.0 * dot(dir, normal));
        sum += material.phong_strength * power(max(dot(mirrored, to_light), 0.0), material.phong_exponent);
    }
    if material.specular_strength != 0.0 {
        let between = unit_or(to_light - dir, normal);
        sum += material.specular_strength * power(max(dot(normal, between), 0.0), material.specular_exponent);
    }
    return sum;
}

// 1 + 4 ulp: surfaces of one instance that lie no farther apart on a ray are the two sides of an edge, which both count the
// edge as theirs, and are crossed once.
const ONE_CROSSING: f32 = 1.00000048;

// How much of a light passes: the product over the transparent surfaces on the way in order of (t, id), so
// that no rounding depends on a tree; nothing behind an opaque one. Each round's key exceeds the last one's,
// so the rounds end with the surfaces. Media take their share of the lengths between surfaces; what light does at them is
// left to the surfaces, which do not bend it here.
fn shadow(
    surface: Surface,
    light: LightRow,
    to_light: vec3f,
#ifdef ABSORPTION
    // Those of the side that the surface is lit from.
    media: Media,
#endif
) -> vec3f {
    shadow_rays += 1u;
    var origin = origin_towards(surface, to_light);
#ifdef CURVED
    if surface.is_curved {
        origin = origin_towards(surface, surface.n_geom) + surface.lift;
    }
#endif
    let beam = beam_to(light, origin);
    var probe = Probe(
        origin, beam.dir, key_after(0.0), key_before(beam.distance), excluded_row(surface), surface.prim, UNTIL_ANY,
    );
#ifdef TRANSMISSION
    probe.until = UNTIL_OPAQUE;
    var passed = vec3f(1.0);
#ifdef ABSORPTION
    var inside = media;
    var behind = 0.0;
#endif
    loop {
        let found = trace(probe);
        if found.row == NONE {
            break;
        }
        let material = materials[instances[found.row].material];
        if (material.flags & MATERIAL_TRANSMITS) == 0u {
            return vec3f(0.0);
        }
        let is_same_edge = found.key.id == probe.after.id && found.key.t <= probe.after.t * ONE_CROSSING;
        if !is_same_edge {
#ifdef ABSORPTION
            passed *= left_after(inside, found.key.t - behind);
            inside = cross_boundary(inside, found.row).media;
            behind = found.key.t;
#endif
#ifdef TINTED
            let color = tint(found.row, found.triangle, found.uv, material);
#else
            let color = material.color;
#endif
            passed *= color * material.filtered + vec3f(material.transmit);
        }
        probe.after = found.key;
    }
#ifdef ABSORPTION
    passed *= left_after(inside, beam.distance - behind);
#endif
    return passed;
#else
    return select(vec3f(1.0), vec3f(0.0), trace(probe).row != NONE);
#endif
}

// base^exponent, base >= 0: whole exponents by repeated multiplication (`pow` may be 6e-5 off), others by
// exp2 and log2.
fn power(base: f32, exponent: f32) -> f32 {
    if fract(exponent) != 0.0 || exponent < 0.0 || exponent > 65536.0 {
        if base <= 0.0 {
            return 0.0;
        }
        return exp2(log2(base) * exponent);
    }
    var result = 1.0;
    var square = base;
    for (var bits = u32(exponent); bits > 0u; bits >>= 1u) {
        if (bits & 1u) == 1u {
            result *= square;
        }
        square *= square;
    }
    return result;
}
