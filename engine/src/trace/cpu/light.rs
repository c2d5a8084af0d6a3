//! Light that reaches a surface from the lamps: POV-Ray's model (see [`crate::world::Material`]), with shadows that
//! transparent surfaces tint.
//!
//! Twin of `shaders/shared/light.wgsl`.

use glam::Vec3;

use super::look::tint;
use super::media::Media;
use super::path::{Scratch, Travel};
use super::surface::Surface;
use super::traverse::{AnyHit, Key, Opaque, Probe, trace};
use crate::frame::Skip;
use crate::frame::wire::{LIGHT_DIRECTIONAL, LIGHT_SPOT, LightRow, MATERIAL_TRANSMITS};
use crate::trace::PackedScene;
use crate::world::Fade;

/// Below this cosine a light does not count (the model's own bound).
const LEAST_COSINE: f32 = 1e-10;

/// Four ulps: surfaces of one instance that lie no farther apart on a ray are the two sides of an edge, which both count
/// the edge as theirs, and are crossed once.
const ONE_CROSSING: f32 = 1.0 + 4.0 * f32::EPSILON;

/// Emission, and what every light adds, seen by a ray.
pub fn local_light(
    scene: &PackedScene,
    surface: &Surface,
    ray: &Travel,
    scratch: &mut Scratch,
) -> Vec3 {
    let skips = scene.skips;
    let material = surface.material;
    let color = surface.color;
    let opaque = (1.0 - material.filtered - material.transmit).max(0.0);
    let mut sum = color * (material.emission * opaque);
    let lit = material.diffuse * opaque != 0.0
        || material.phong_strength != 0.0
        || material.specular_strength != 0.0;
    if !lit && skips.has(Skip::Black) {
        scratch.counters.black_shadows += scene.lights.len() as u64;
        return sum;
    }
    for light in scene.lights.iter() {
        let beam = Beam::new(light, surface.position);
        let cosine = surface.n_shade.dot(beam.dir);
        // A curved surface faces the light where its normal does, whatever its triangle does.
        let is_away = surface.lift.is_none() && surface.n_geom.dot(beam.dir) < LEAST_COSINE;
        let (mut strength, mut answer) = (Vec3::ZERO, Vec3::ZERO);
        if cosine < LEAST_COSINE || is_away {
            if skips.has(Skip::Away) {
                scratch.counters.away_shadows += 1;
                continue;
            }
        } else {
            strength = beam.strength(light);
            answer = color * (material.diffuse * opaque * cosine)
                + highlights(surface, ray.dir, beam.dir);
            if (strength == Vec3::ZERO || answer == Vec3::ZERO) && skips.has(Skip::Black) {
                scratch.counters.black_shadows += 1;
                continue;
            }
            if scratch.purse.holds_any() && skips.has(Skip::FaintLights) {
                // Shadows take light away, and add none.
                let most = (ray.weight * strength * answer).abs().max_element();
                if scratch.purse.buys(most) {
                    scratch.counters.faint_shadows += 1;
                    continue;
                }
            }
        }
        let towards = (light, beam.dir);
        let passed = shadow(scene, (surface, &ray.media), towards, scratch);
        sum += passed * strength * answer;
    }
    sum
}

/// The line from a surface to a light.
struct Beam {
    /// Unit.
    dir: Vec3,
    distance: f32,
}

impl Beam {
    fn new(light: &LightRow, from: Vec3) -> Self {
        let position = Vec3::from(light.position);
        if light.kind == LIGHT_DIRECTIONAL {
            return Self {
                dir: position,
                distance: f32::MAX,
            };
        }
        let line = position - from;
        let distance = line.length();
        Self {
            dir: line / distance.max(f32::MIN_POSITIVE),
            distance,
        }
    }

    /// The light's colour after fading and its cone.
    fn strength(&self, light: &LightRow) -> Vec3 {
        let mut factor = 1.0;
        if light.fade_distance > 0.0 {
            let gone = power(self.distance / light.fade_distance, light.fade_power);
            factor = (1.0 + light.fade_core) / (light.fade_core + gone).max(Fade::NEAREST);
            let within = (self.distance * light.range_inverse).min(1.0);
            factor *= 1.0 - within * within * (within * within);
        }
        if light.kind == LIGHT_SPOT {
            let cosine = -self.dir.dot(Vec3::from(light.axis));
            let x = (cosine - light.cos_outer) / (light.cos_inner - light.cos_outer);
            let x = x.clamp(0.0, 1.0);
            factor *= x * x * (3.0 - 2.0 * x);
        }
        Vec3::from(light.color) * factor
    }
}

/// Phong about the mirrored eye ray, Blinn-Phong about the half vector; neither is tinted.
fn highlights(surface: &Surface, dir: Vec3, to_light: Vec3) -> Vec3 {
    let material = surface.material;
    let n = surface.n_shade;
    let mut sum = 0.0;
    if material.phong_strength != 0.0 {
        let mirrored = dir - n * (2.0 * dir.dot(n));
        let cosine = mirrored.dot(to_light).max(0.0);
        sum += material.phong_strength * power(cosine, material.phong_exponent);
    }
    if material.specular_strength != 0.0 {
        let half = (to_light - dir).normalize_or(n);
        let cosine = n.dot(half).max(0.0);
        sum += material.specular_strength * power(cosine, material.specular_exponent);
    }
    Vec3::splat(sum)
}

/// How much of a light passes: the product over the transparent surfaces on the way in order of (t, id),
/// so that no rounding depends on a tree; nothing behind an opaque one. Media take their share of the lengths between
/// surfaces, from those on the side that the surface is lit from on; what light does at surfaces is left to them, which do
/// not bend it here.
fn shadow(
    scene: &PackedScene,
    (surface, media): (&Surface, &Media),
    (light, to_light): (&LightRow, Vec3),
    Scratch {
        stack, counters, ..
    }: &mut Scratch,
) -> Vec3 {
    counters.shadow_rays += 1;
    let (mut origin, start) = surface.leave_towards(to_light);
    if let Some(lift) = surface.lift {
        origin = surface.leave_towards(surface.n_geom).0 + lift;
    }
    let beam = Beam::new(light, origin);
    let mut probe = Probe {
        origin,
        dir: beam.dir,
        after: Key::after(0.0),
        before: Key::before(beam.distance),
        start,
    };
    if !scene.transparent {
        let lit = trace::<AnyHit>(scene, &probe, stack).is_none();
        return Vec3::splat(f32::from(u8::from(lit)));
    }
    let mut passed = Vec3::ONE;
    let (mut inside, mut behind) = (*media, 0.0);
    while let Some(found) = trace::<Opaque>(scene, &probe, stack) {
        let row = &scene.instances()[found.key.id as usize];
        let material = &scene.materials[row.material as usize];
        if material.flags & MATERIAL_TRANSMITS == 0 {
            return Vec3::ZERO;
        }
        let (last, here) = (probe.after, found.key);
        let is_same_edge = here.id == last.id && here.t <= last.t * ONE_CROSSING;
        if !is_same_edge {
            if scene.absorbs {
                passed *= inside.left_after(scene, here.t - behind);
                inside.cross(here.id, material.ior);
                behind = here.t;
            }
            passed *= tint(scene, &found, material) * material.filtered + material.transmit;
        }
        probe.after = found.key;
    }
    if scene.absorbs {
        passed *= inside.left_after(scene, beam.distance - behind);
    }
    passed
}

/// `base^exponent`, base >= 0: whole exponents by repeated multiplication (the same bits here and in
/// WGSL, where `pow` may be 6e-5 off), others by exp2 and log2.
fn power(base: f32, exponent: f32) -> f32 {
    if exponent.fract() != 0.0 || !(0.0..=65536.0).contains(&exponent) {
        return if base > 0.0 {
            (base.log2() * exponent).exp2()
        } else {
            0.0
        };
    }
    let (mut result, mut square, mut bits) = (1.0, base, exponent as u32);
    while bits > 0 {
        if bits & 1 == 1 {
            result *= square;
        }
        square *= square;
        bits >>= 1;
    }
    result
}
