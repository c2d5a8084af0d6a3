//! Light that reaches a surface from the lamps: POV-Ray's model (see [`crate::world::Material`]), with shadows that
//! transparent surfaces tint.
//!
//! Twin of `shaders/shared/light.wgsl`.

use glam::Vec3;

use super::cutoff::Purse;
use super::look::tint;
use super::media::Media;
use super::packet::{Packet, trace_all};
use super::path::{Scratch, Travel};
use super::query::{AnyHit, Found, Key, Opaque, Probe};
use super::stack::Stack;
use super::surface::Surface;
use super::traverse::trace;
use crate::frame::Skip;
use crate::frame::wire::{LIGHT_DIRECTIONAL, LIGHT_SPOT, LightRow, MATERIAL_TRANSMITS};
use crate::trace::PackedScene;
use crate::world::Fade;

/// Below this cosine a light does not count (the model's own bound).
const LEAST_COSINE: f32 = 1e-10;

/// Four ulps: surfaces of one instance that lie no farther apart on a ray are the two sides of an edge, which both count
/// the edge as theirs, and are crossed once.
const ONE_CROSSING: f32 = 1.0 + 4.0 * f32::EPSILON;

/// What is first on the way to a light.
#[derive(Clone, Copy, Debug)]
pub enum Way {
    /// It was not looked at.
    Unknown,
    /// What [`first_on_the_way`] found.
    Known(Option<Found>),
}

/// Emission, and what every light adds, seen by a ray. Of some lights it is known what is on the way.
pub fn local_light(
    scene: &PackedScene,
    surface: &Surface,
    ray: &Travel,
    ways: &[Way],
    scratch: &mut Scratch,
) -> Vec3 {
    let skips = scene.skips;
    let mut sum = surface.color * (surface.material.emission * opacity(surface));
    if !is_lit(surface) && skips.has(Skip::Black) {
        scratch.counters.black_shadows += scene.lights.len() as u64;
        return sum;
    }
    for (number, light) in scene.lights.iter().enumerate() {
        let lit = Lit::by(light, surface, ray.dir);
        match lit.left_out(scene, ray.weight, &mut scratch.purse) {
            Some(Skip::Away) => scratch.counters.away_shadows += 1,
            Some(Skip::Black) => scratch.counters.black_shadows += 1,
            Some(_) => scratch.counters.faint_shadows += 1,
            None => {
                scratch.counters.shadow_rays += 1;
                let (probe, distance) = towards(surface, light, lit.to_light);
                let first = match ways.get(number) {
                    Some(Way::Known(first)) => *first,
                    _ => first_on_the_way(scene, &probe, &mut scratch.stack),
                };
                let stack = &mut scratch.stack;
                let passed = shadow(scene, &ray.media, (probe, distance), first, stack);
                sum += passed * lit.strength * lit.answer;
            }
        }
    }
    sum
}

/// The shadow ray from what a ray met first to a light, if it is to be traced; `purse` is the ray's.
pub fn shadow_probe(
    scene: &PackedScene,
    surface: &Surface,
    light: &LightRow,
    ray: &Travel,
    purse: &mut Purse,
) -> Option<Probe> {
    if !is_lit(surface) && scene.skips.has(Skip::Black) {
        return None;
    }
    let lit = Lit::by(light, surface, ray.dir);
    let is_traced = lit.left_out(scene, ray.weight, purse).is_none();
    is_traced.then(|| towards(surface, light, lit.to_light).0)
}

/// The first hit of a shadow ray that is looked at: any where all is opaque.
fn first_on_the_way(scene: &PackedScene, probe: &Probe, stack: &mut Stack) -> Option<Found> {
    if scene.transparent {
        trace::<Opaque>(scene, probe, stack)
    } else {
        trace::<AnyHit>(scene, probe, stack)
    }
}

/// [`first_on_the_way`] of many shadow rays.
pub fn first_on_the_ways(
    scene: &PackedScene,
    probes: &[Probe],
    found: &mut [Option<Found>],
    kept: (&mut Packet, &mut Stack),
) {
    if scene.transparent {
        trace_all::<Opaque>(scene, probes, found, kept);
    } else {
        trace_all::<AnyHit>(scene, probes, found, kept);
    }
}

/// What a material does not let through.
fn opacity(surface: &Surface) -> f32 {
    let material = surface.material;
    (1.0 - material.filtered - material.transmit).max(0.0)
}

/// Whether lights add anything.
fn is_lit(surface: &Surface) -> bool {
    let material = surface.material;
    material.diffuse * opacity(surface) != 0.0
        || material.phong_strength != 0.0
        || material.specular_strength != 0.0
}

/// What a light adds if nothing is on its way.
struct Lit {
    /// Unit.
    to_light: Vec3,
    /// The surface faces away from it.
    is_away: bool,
    strength: Vec3,
    answer: Vec3,
}

impl Lit {
    fn by(light: &LightRow, surface: &Surface, dir: Vec3) -> Self {
        let beam = Beam::new(light, surface.position);
        let cosine = surface.n_shade.dot(beam.dir);
        // A curved surface faces the light where its normal does, whatever its triangle does.
        let is_away = cosine < LEAST_COSINE
            || surface.lift.is_none() && surface.n_geom.dot(beam.dir) < LEAST_COSINE;
        let mut lit = Self {
            to_light: beam.dir,
            is_away,
            strength: Vec3::ZERO,
            answer: Vec3::ZERO,
        };
        if !is_away {
            let diffuse = surface.material.diffuse * opacity(surface) * cosine;
            lit.strength = beam.strength(light);
            lit.answer = surface.color * diffuse + highlights(surface, dir, beam.dir);
        }
        lit
    }

    /// Why no shadow ray is traced, if none is; the purse pays for what is left out.
    fn left_out(&self, scene: &PackedScene, weight: Vec3, purse: &mut Purse) -> Option<Skip> {
        let skips = scene.skips;
        if self.is_away {
            return Some(Skip::Away).filter(|skip| skips.has(*skip));
        }
        let is_black = self.strength == Vec3::ZERO || self.answer == Vec3::ZERO;
        if is_black && skips.has(Skip::Black) {
            return Some(Skip::Black);
        }
        if purse.holds_any() && skips.has(Skip::FaintLights) {
            // Shadows take light away, and add none.
            let most = (weight * self.strength * self.answer).abs().max_element();
            return purse.buys(most).then_some(Skip::FaintLights);
        }
        None
    }
}

/// The ray from a surface to a light, and how far that is.
fn towards(surface: &Surface, light: &LightRow, to_light: Vec3) -> (Probe, f32) {
    let (mut origin, start) = surface.leave_towards(to_light);
    if let Some(lift) = surface.lift {
        origin = surface.leave_towards(surface.n_geom).0 + lift;
    }
    let beam = Beam::new(light, origin);
    let probe = Probe {
        origin,
        dir: beam.dir,
        after: Key::after(0.0),
        before: Key::before(beam.distance),
        start,
    };
    (probe, beam.distance)
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
    media: &Media,
    (mut probe, distance): (Probe, f32),
    first: Option<Found>,
    stack: &mut Stack,
) -> Vec3 {
    if !scene.transparent {
        return Vec3::splat(f32::from(u8::from(first.is_none())));
    }
    let mut passed = Vec3::ONE;
    let (mut inside, mut behind) = (*media, 0.0);
    let mut next = first;
    while let Some(found) = next {
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
        next = trace::<Opaque>(scene, &probe, stack);
    }
    if scene.absorbs {
        passed *= inside.left_after(scene, distance - behind);
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
