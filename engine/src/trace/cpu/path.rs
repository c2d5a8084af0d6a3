//! One camera ray and all that follows from it: Whitted's recursion as a loop with a stack.
//!
//! Twin of `shaders/shared/path.wgsl`. The steps are those of [`crate::trace`].

use glam::Vec3;

use super::cutoff::{Purse, most_added};
use super::light::{Way, local_light};
use super::look::appear;
use super::media::Media;
use super::packet::Packet;
use super::query::{Found, Key, Nearest, Probe, Start};
use super::sky::sky;
use super::stack::Stack;
use super::surface::{Surface, resolve};
use super::traverse::trace;
use crate::frame::Skip;
use crate::frame::wire::{
    MATERIAL_FRESNEL, MATERIAL_MIRROR, MATERIAL_TRANSMITS, PROJECTION_PERSPECTIVE,
    STRAIGHT_CAPACITY, ViewRow,
};
use crate::trace::{Counters, PackedScene};

/// Two indices closer than this, relatively, are one: the ray goes straight on.
const SAME_INDEX: f32 = 1e-6;

/// A ray on its way, and what it will add to the pixel.
#[derive(Clone, Copy)]
pub struct Travel {
    origin: Vec3,
    /// Unit.
    pub dir: Vec3,
    /// Its share of the pixel.
    pub weight: Vec3,
    start: Start,
    generation: u32,
    straight: u32,
    /// What it is inside of.
    pub media: Media,
    /// Of its cone where it starts: as wide as a pixel, and as wide again each time it has gone as far. Mirrors and
    /// boundaries count as flat.
    width: f32,
}

impl Travel {
    /// A camera ray, `width` wide at its start; `dir` is unit.
    pub fn from_camera(origin: Vec3, dir: Vec3, width: f32) -> Self {
        Self {
            origin,
            dir,
            weight: Vec3::ONE,
            start: Start::FREE,
            generation: 1,
            straight: 0,
            media: Media::default(),
            width,
        }
    }

    /// What it asks for.
    pub fn probe(&self) -> Probe {
        Probe {
            origin: self.origin,
            dir: self.dir,
            after: Key::after(0.0),
            before: Key::before(f32::MAX),
            start: self.start,
        }
    }
}

/// Width of a pixel: at distance 1, or at any where rays are parallel.
fn pixel_width(view: &ViewRow) -> f32 {
    2.0 * Vec3::from(view.up_step).length()
}

/// Width of a camera ray's cone at the eye.
pub fn first_width(view: &ViewRow) -> f32 {
    match view.projection {
        PROJECTION_PERSPECTIVE => 0.0,
        _ => pixel_width(view),
    }
}

/// What a cone widens by, a length.
fn cone_spread(view: &ViewRow) -> f32 {
    match view.projection {
        PROJECTION_PERSPECTIVE => pixel_width(view),
        _ => 0.0,
    }
}

/// What a worker keeps from ray to ray.
#[derive(Default)]
pub struct Scratch {
    /// Of traversals.
    pub stack: Stack,
    /// Of many rays at once.
    pub packet: Packet,
    deferred: Vec<Travel>,
    /// What this camera ray may still leave out.
    pub purse: Purse,
    /// What its rays added up.
    pub counters: Counters,
}

/// What a ray met, and its look.
pub struct Met<'a> {
    /// The hit.
    pub found: Found,
    /// The surface there.
    pub surface: Surface<'a>,
}

impl<'a> Met<'a> {
    /// Of a hit of a ray.
    pub fn of(scene: &'a PackedScene, ray: &Travel, found: Found) -> Self {
        let mut surface = resolve(scene, &found, ray.origin, ray.dir);
        let width = ray.width + cone_spread(&scene.view) * found.key.t;
        surface.width = width;
        appear(scene, &found, &mut surface, ray.dir, width);
        Self { found, surface }
    }
}

/// Linear RGB seen along a camera ray, less at most what the purse holds; what it met first is known, and what is on the
/// ways from there to some lights.
pub fn radiance<'a>(
    scene: &'a PackedScene,
    camera_ray: Travel,
    (met, ways): (Option<Met<'a>>, &[Way]),
    purse: Purse,
    scratch: &mut Scratch,
) -> Vec3 {
    let mut sum = Vec3::ZERO;
    scratch.counters.primary_rays += 1;
    scratch.deferred.clear();
    scratch.purse = purse;
    let mut next = Some(camera_ray);
    let mut first = Some((met, ways));
    while let Some(mut ray) = next.take().or_else(|| scratch.deferred.pop()) {
        let (met, ways) = first.take().unwrap_or_else(|| {
            let found = trace::<Nearest>(scene, &ray.probe(), &mut scratch.stack);
            (found.map(|found| Met::of(scene, &ray, found)), &[])
        });
        if scene.absorbs {
            let length = met.as_ref().map_or(f32::MAX, |met| met.found.key.t);
            ray.weight *= ray.media.left_after(scene, length);
        }
        let Some(Met { surface, .. }) = met else {
            sum += ray.weight * sky(scene, ray.dir);
            continue;
        };
        sum += ray.weight * local_light(scene, &surface, &ray, ways, scratch);
        let (followed, deferred) = scatter(scene, &ray, &surface, scratch);
        next = followed;
        scratch.deferred.extend(deferred);
        // One entry a generation: a deferred ray's slot is its parent hit's generation.
        debug_assert!(scratch.deferred.len() <= scene.view.max_generations as usize);
    }
    sum
}

/// The rays that leave a surface: the one to follow now, the one to take up after its subtree.
fn scatter(
    scene: &PackedScene,
    ray: &Travel,
    surface: &Surface,
    scratch: &mut Scratch,
) -> (Option<Travel>, Option<Travel>) {
    let material = surface.material;
    let any = MATERIAL_FRESNEL | MATERIAL_MIRROR | MATERIAL_TRANSMITS;
    if material.flags & any == 0 {
        return (None, None);
    }
    let crossing = ray.media.crossing(surface.start.id, material.ior);
    let cosine = (-ray.dir.dot(surface.n_shade)).clamp(0.0, 1.0);
    let mut reflected = Vec3::ZERO;
    let mut passed = Vec3::ZERO;
    if material.flags & MATERIAL_TRANSMITS != 0 {
        passed = surface.color * material.filtered + material.transmit;
    }
    if material.flags & MATERIAL_FRESNEL != 0 {
        let share = fresnel(crossing.eta, cosine);
        reflected = Vec3::splat(share);
        passed *= 1.0 - share;
    } else if material.flags & MATERIAL_MIRROR != 0 {
        reflected = Vec3::from(material.reflection);
    }
    let bent = if passed.max_element() > 0.0 {
        refract(ray, surface, crossing.eta, cosine)
    } else {
        Bent::NotAtAll
    };
    if matches!(bent, Bent::TotallyReflected) {
        (reflected, passed) = (Vec3::ONE, Vec3::ZERO);
    }
    if scratch.purse.holds_any() && scene.skips.has(Skip::FaintRays) {
        let is_straight = matches!(bent, Bent::Straight);
        leave_out_faint(
            scene,
            ray,
            &mut reflected,
            &mut passed,
            is_straight,
            scratch,
        );
    }
    let counters = &mut scratch.counters;
    let mut transmitted = None;
    if passed.max_element() > 0.0 {
        match bent {
            Bent::Straight => transmitted = straight_on(ray, surface, passed, counters),
            Bent::Refracted(dir) => {
                if let Some(mut onward) = spawn(scene, ray, surface, (dir, passed), counters) {
                    if !onward.media.cross(surface.start.id, material.ior) {
                        counters.media_overflows += 1;
                    }
                    counters.refracted_rays += 1;
                    transmitted = Some(onward);
                }
            }
            Bent::TotallyReflected | Bent::NotAtAll => {}
        }
    }
    let mut mirrored = None;
    if reflected.max_element() > 0.0 {
        let dir = mirror(ray.dir, surface);
        mirrored = spawn(scene, ray, surface, (dir, reflected), counters);
        counters.reflected_rays += u64::from(mirrored.is_some());
    }
    match (mirrored, transmitted) {
        // The straight ray stays in this generation: it waits in this generation's slot.
        (Some(mirrored), Some(onward)) if onward.generation == ray.generation => {
            (Some(mirrored), Some(onward))
        }
        (mirrored, Some(onward)) => (Some(onward), mirrored),
        (mirrored, None) => (mirrored, None),
    }
}

/// Takes the weight of the mirrored ray and of the one that passes if the purse buys them off. The cheaper one is
/// offered first: more are left out that way.
fn leave_out_faint(
    scene: &PackedScene,
    ray: &Travel,
    reflected: &mut Vec3,
    passed: &mut Vec3,
    is_straight: bool,
    scratch: &mut Scratch,
) {
    let next = ray.generation + 1;
    let onward = if is_straight { ray.generation } else { next };
    let mut offers = [
        (
            most_added(&scene.view, ray.weight * *reflected, next),
            reflected,
        ),
        (
            most_added(&scene.view, ray.weight * *passed, onward),
            passed,
        ),
    ];
    if offers[1].0 < offers[0].0 {
        offers.swap(0, 1);
    }
    for (cost, weight) in offers {
        if scratch.purse.buys(cost) {
            *weight = Vec3::ZERO;
            scratch.counters.dropped_rays += 1;
        }
    }
}

/// A ray of the next generation; none past the last one (black), nor one of which the pixel takes nothing.
fn spawn(
    scene: &PackedScene,
    ray: &Travel,
    surface: &Surface,
    (dir, factor): (Vec3, Vec3),
    counters: &mut Counters,
) -> Option<Travel> {
    if ray.generation >= scene.view.max_generations {
        return None;
    }
    let weight = ray.weight * factor;
    if weight == Vec3::ZERO && scene.skips.has(Skip::Weightless) {
        counters.weightless_rays += 1;
        return None;
    }
    let (origin, start) = surface.leave_towards(dir);
    Some(Travel {
        origin,
        dir,
        weight,
        start,
        generation: ray.generation + 1,
        straight: 0,
        media: ray.media,
        width: surface.width,
    })
}

/// The same ray beyond a boundary of equal indices; none once it has crossed too many.
fn straight_on(
    ray: &Travel,
    surface: &Surface,
    factor: Vec3,
    counters: &mut Counters,
) -> Option<Travel> {
    if ray.straight == STRAIGHT_CAPACITY {
        counters.straight_overflows += 1;
        return None;
    }
    let (origin, start) = surface.leave_towards(ray.dir);
    let mut onward = Travel {
        origin,
        weight: ray.weight * factor,
        start,
        straight: ray.straight + 1,
        width: surface.width,
        ..*ray
    };
    if !onward.media.cross(surface.start.id, surface.material.ior) {
        counters.media_overflows += 1;
    }
    counters.refracted_rays += 1;
    Some(onward)
}

/// Unpolarised Fresnel reflectance for eta = n_from / n_to at the cosine of incidence; 1 in total
/// internal reflection (Cook and Torrance 1982, appendix).
fn fresnel(eta: f32, cosine: f32) -> f32 {
    // Nothing between equal indices, where rounding would leave a trace of a ray.
    if (eta - 1.0).abs() < SAME_INDEX {
        return 0.0;
    }
    let g_squared = 1.0 / (eta * eta) + cosine * cosine - 1.0;
    if g_squared <= 0.0 {
        return 1.0;
    }
    let g = g_squared.sqrt();
    let (plus, minus) = (g + cosine, g - cosine);
    let s = minus / plus;
    let p = (cosine * plus - 1.0) / (cosine * minus + 1.0);
    (0.5 * s * s * (1.0 + p * p)).clamp(0.0, 1.0)
}

enum Bent {
    NotAtAll,
    Straight,
    Refracted(Vec3),
    TotallyReflected,
}

/// Snell's law about the shading normal.
fn refract(ray: &Travel, surface: &Surface, eta: f32, cosine: f32) -> Bent {
    if (eta - 1.0).abs() < SAME_INDEX {
        return Bent::Straight;
    }
    let k = 1.0 + eta * eta * (cosine * cosine - 1.0);
    if k < 0.0 {
        return Bent::TotallyReflected;
    }
    let dir = ray.dir * eta + surface.n_shade * (eta * cosine - k.sqrt());
    Bent::Refracted(dir.normalize_or(ray.dir))
}

/// The mirrored direction about the shading normal, or about the face's where that would dip below it.
fn mirror(dir: Vec3, surface: &Surface) -> Vec3 {
    let about = |n: Vec3| (dir - n * (2.0 * dir.dot(n))).normalize_or(n);
    let smooth = about(surface.n_shade);
    if smooth.dot(surface.n_geom) > 0.0 {
        smooth
    } else {
        about(surface.n_geom)
    }
}
