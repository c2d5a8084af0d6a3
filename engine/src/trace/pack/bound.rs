//! The most light that a ray can bring back, by its generation: what the cut-off's proof rests on.
//!
//! A surface adds at most its local light `E`: emission, and for every light the diffuse share and the highlights at full.
//! A light that fades counts [`crate::world::Fade::most`] times: 2, but 1e8 by the exact law, which knows no end near the
//! light, so that in such scenes next to no ray is ever left out. With `n` for the bound of the next generation, a material of reflection `R` and
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
/// A highlight's cosine in f32 may exceed 1 by so much. A vector that was divided by its length is as long as 1 + e, with
/// e <= 8.5 ulps of 2^-23 as WGSL bounds them (three in a squared length count half, 4.5 a square root, 2.5 a division). The
/// mirrored ray d - 2 (d.n) n is as long as |d| + 2 (|n|^2 - 1) at most, 1 + 5 e, and the light's direction 1 + e: with 18
/// ulps for the products and sums between, 6 e are 69 ulps, 8.3e-6 in all. The half vector's cosine is below 1 + 2 e.
const COSINE_EXCESS: f64 = 1e-5;
/// WGSL's log2 near 1 errs by so much.
const LOG2_ERROR: f64 = 1.0 / (1 << 21) as f64;
/// Whole exponents up to this one are multiplied out in both f32 tracers, others go through log2 and exp2 (`power` in
/// `cpu/light.rs`).
const MOST_MULTIPLIED: f64 = 65_536.0;
/// Surfaces that a ray of one generation can meet.
const SURFACES: f64 = (STRAIGHT_CAPACITY + 1) as f64;
/// Bounds beyond this say nothing, and would leave the range of f32 when they are multiplied.
const LARGEST: f64 = 1e12;

/// The bounds by generation, that of generation g as number g - 1, the largest of the channels; none: there is no
/// useful bound, so nothing may be left out.
pub(super) fn radiance_bounds(scene: &FrameScene) -> Option<[f32; GENERATIONS_CAPACITY as usize]> {
    let arriving: DVec3 = scene.lights.iter().map(brightest).sum();
    let panorama = scene.background.picture;
    let panorama = panorama.and_then(|id| scene.textures.get(id.0 as usize));
    let brightest = panorama.map_or(1.0, |panorama| f64::from(panorama.brightest));
    let background = scene.background.brightest().as_dvec3().abs() * brightest;
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

/// A lobe at its centre. Rounding may lift the cosine above 1, and the exponent that and a logarithm's error; no exponent
/// below 0 has a bound.
fn highest(lobe: Option<Lobe>) -> f64 {
    lobe.map_or(0.0, |lobe| {
        let exponent = f64::from(lobe.exponent);
        let centre = if exponent < 0.0 {
            f64::INFINITY
        } else {
            let is_multiplied = exponent.fract() == 0.0 && exponent <= MOST_MULTIPLIED;
            let error = if is_multiplied { 0.0 } else { LOG2_ERROR };
            (((1.0 + COSINE_EXCESS).log2() + error) * exponent).exp2()
        };
        f64::from(lobe.strength).abs() * centre
    })
}

/// A light where it is brightest.
fn brightest(light: &Light) -> DVec3 {
    light.color.as_dvec3().abs() * light.fade.map_or(1.0, |fade| fade.most())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    /// What f32 makes of a lobe's centre at worst: a cosine as far above 1 as vectors allow, and log2 as far off as WGSL does.
    fn worst(cosine: f64, exponent: f64) -> f64 {
        let is_whole = exponent.fract() == 0.0 && exponent <= 65_536.0;
        if is_whole {
            // One rounding of 2^-24 a factor.
            (cosine * (1.0 + 2_f64.powi(-24))).powf(exponent)
        } else {
            ((cosine.log2() + 2_f64.powi(-21)) * exponent).exp2()
        }
    }

    #[test]
    fn lobes_are_bounded_whatever_their_exponent() {
        for exponent in [0.5, 1.0, 40.0, 399.5, 65_536.0, 65_536.5, 250_000.0, 1e6] {
            let lobe = Lobe {
                strength: 0.7,
                exponent,
            };
            let bound = highest(Some(lobe)) * MARGIN;
            let exponent = f64::from(exponent);
            for ulps in [0.0, 8.0, 23.0, 69.0] {
                let cosine = 1.0 + ulps * f64::from(f32::EPSILON);
                let reached = f64::from(0.7_f32) * worst(cosine, exponent);
                assert!(reached <= bound, "{exponent}: {reached} over {bound}");
            }
        }
        let none = Lobe {
            strength: 0.7,
            exponent: -1.0,
        };
        assert!(highest(Some(none)).is_infinite());
    }

    /// Normals, rays and lights whose lengths err by a few ulps, as divisions leave them.
    #[test]
    fn a_mirrored_rays_cosine_exceeds_1_by_less_than_is_allowed_for() {
        let mut random = Random::new(3);
        let mut most = 0.0_f64;
        for _ in 0..200_000 {
            let mut off = || 1.0 + random.range(-8.5, 8.5) as f32 * f32::EPSILON;
            let lengths = [off(), off(), off()];
            let normal = random.direction().as_vec3().normalize();
            let dir = -(normal.as_dvec3() + random.cube() * 0.3)
                .as_vec3()
                .normalize();
            let to_light = (dir - normal * (2.0 * dir.dot(normal))).normalize();
            let (n, d) = (normal * lengths[0], dir * lengths[1]);
            let mirrored = d - n * (2.0 * d.dot(n));
            most = most.max(f64::from(mirrored.dot(to_light * lengths[2])) - 1.0);
        }
        assert!(most > 2e-6 && most <= COSINE_EXCESS, "{most:e}");
    }
}
