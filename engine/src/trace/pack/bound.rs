//! The most light that a ray can bring back, by its generation: what the cut-off's proof rests on.
//!
//! A surface adds at most its local light `E`: emission, and for every light (faded ones are at most doubled) the diffuse
//! share and the highlights at full. With `n` for the bound of the next generation, a material of reflection `R` and
//! transmission `T` answers with at most `E + R n + T v`, where `v` is what lies beyond it: `n` if the ray bends, else
//! the rest of its own generation (a boundary of equal indices does not end one). Fresnel's shares sum to 1, so such a
//! material gives at most `E + max(n, T v)`; total reflection at most `E + n`.
//!
//! Called when materials, lights, background or depth change; read by both f32 tracers through the frame's uniform. Twin:
//! none.

use glam::DVec3;

use crate::frame::wire::{GENERATIONS_CAPACITY, STRAIGHT_CAPACITY};
use crate::frame::{FrameScene, Light};
use crate::world::{Lobe, Material, Reflection};

/// What is added for rounding in f32: of weights, of light, and of the purse that pays (a hundredth).
const MARGIN: f64 = 1.02;
/// A cosine in f32 may exceed 1 by so much.
const COSINE_EXCESS: f64 = 1e-6;
/// Surfaces that a ray of one generation can meet.
const SURFACES: f64 = (STRAIGHT_CAPACITY + 1) as f64;
/// Bounds beyond this say nothing, and would leave the range of f32 when they are multiplied.
const LARGEST: f64 = 1e12;

/// The bounds by generation, that of generation g as number g - 1, the largest of the channels; none: there is no
/// useful bound, so nothing may be left out.
pub(super) fn radiance_bounds(scene: &FrameScene) -> Option<[f32; GENERATIONS_CAPACITY as usize]> {
    let arriving: DVec3 = scene.lights.iter().map(brightest).sum();
    let background = scene.background.as_dvec3().abs();
    let mut plain = background;
    let mut scattering = Vec::new();
    for material in scene.materials.iter() {
        let answer = Answer::of(material, arriving);
        plain = plain.max(answer.local);
        if answer.reflected.is_some() || answer.passed.max_element() > 0.0 {
            scattering.push(answer);
        }
    }
    let mut bounds = [0.0; GENERATIONS_CAPACITY as usize];
    let mut next = DVec3::ZERO;
    for generation in (0..scene.max_generations.min(GENERATIONS_CAPACITY) as usize).rev() {
        next = one_generation(plain, &scattering, next)?;
        let rounded = (next.max_element() * MARGIN) as f32;
        bounds[generation] = rounded.next_up();
        if !next.is_finite() || next.max_element() > LARGEST {
            return None;
        }
    }
    Some(bounds)
}

/// The bound of a generation from that of the next. What a ray meets one after the other without bending is a chain of
/// affine steps `v <- max(base, a + T v)`: steps with T < 1 never lift v above a / (1 - T), steps with T = 1 lift it by a.
fn one_generation(plain: DVec3, scattering: &[Answer], next: DVec3) -> Option<DVec3> {
    let mut base = plain.max(next);
    let mut lift = DVec3::ZERO;
    for answer in scattering {
        let mirrored = answer.reflected.unwrap_or(DVec3::ZERO) * next;
        let is_clear = answer.passed.max_element() > 0.0;
        // Total reflection, and Fresnel's share, which may be all.
        let all = if is_clear || answer.is_fresnel {
            next
        } else {
            DVec3::ZERO
        };
        base = base.max(answer.local + mirrored.max(all));
        if !is_clear {
            continue;
        }
        let step = answer.local + mirrored;
        for channel in 0..3 {
            let (a, through) = (step[channel], answer.passed[channel]);
            // NaN fails this test too.
            if !(through <= 1.0) {
                return None;
            }
            let settled = a / (1.0 - through);
            if settled <= SURFACES * a {
                base[channel] = base[channel].max(settled);
            } else {
                lift[channel] = lift[channel].max(a);
            }
        }
    }
    Some(base + lift * SURFACES)
}

/// What a material does with light, at most.
struct Answer {
    local: DVec3,
    /// Weight of the mirrored ray; Fresnel's is told apart.
    reflected: Option<DVec3>,
    is_fresnel: bool,
    passed: DVec3,
}

impl Answer {
    fn of(material: &Material, arriving: DVec3) -> Self {
        let color = material.color.as_dvec3().abs();
        let opaque = (1.0 - f64::from(material.filter) - f64::from(material.transmit)).max(0.0);
        let diffuse = color * (f64::from(material.diffuse).abs() * opaque);
        let highlights = highest(material.phong) + highest(material.specular);
        let (reflected, is_fresnel) = match material.reflection {
            Reflection::None => (None, false),
            Reflection::Constant(weight) => (Some(weight.as_dvec3().abs()), false),
            Reflection::Fresnel => (Some(DVec3::ZERO), true),
        };
        Self {
            local: color * (f64::from(material.emission).abs() * opaque)
                + arriving * (diffuse + highlights),
            reflected,
            is_fresnel,
            passed: material.transmission().as_dvec3().abs(),
        }
    }
}

/// A lobe at its centre. Rounding may lift the cosine above 1, and the exponent that; no exponent below 0 has a bound.
fn highest(lobe: Option<Lobe>) -> f64 {
    lobe.map_or(0.0, |lobe| {
        let exponent = f64::from(lobe.exponent);
        let centre = if exponent < 0.0 {
            f64::INFINITY
        } else {
            (1.0 + COSINE_EXCESS).powf(exponent)
        };
        f64::from(lobe.strength).abs() * centre
    })
}

/// A light where it is brightest.
fn brightest(light: &Light) -> DVec3 {
    light.color.as_dvec3().abs() * if light.fade.is_some() { 2.0 } else { 1.0 }
}
