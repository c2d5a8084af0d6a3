//! Whitted's recursion, as one would write it on a blackboard, in f64; the model is told in [`crate::trace`].

use glam::DVec3;

use super::explain::{RayKind, Recorder};
use super::look;
use super::world::{Key, World, WorldHit, WorldRay};
use crate::frame::wire::{GENERATIONS_CAPACITY, STRAIGHT_CAPACITY};
use crate::frame::{FrameScene, Light, LightKind, ViewProjection};
use crate::trace::Counters;
use crate::world::{Material, Reflection};

/// A scene, its world of shapes, and what tracing it adds up.
pub struct Whitted<'a, R = ()> {
    /// The frame.
    pub scene: &'a FrameScene,
    /// Shapes relative to the eye.
    pub world: &'a World,
    /// Of a pixel: at distance 1, or at any where rays are parallel.
    pub pixel_width: f64,
    /// Rays so far.
    pub counters: Counters,
    /// Who is told of every ray.
    pub recorder: R,
}

/// A point where a ray met a surface.
struct Surface {
    point: DVec3,
    n_geom: DVec3,
    n_shade: DVec3,
    material: Material,
    /// In place of the material's.
    color: DVec3,
    /// Of the ray's cone here.
    width: f64,
    /// From the point to the curved surface that triangles stand for; none: they stand for themselves.
    lift: Option<DVec3>,
    start: (u32, u32),
}

/// The media a ray is inside of: instance and index, in order of entry.
type Media = Vec<(u32, f64)>;

impl<R: Recorder> Whitted<'_, R> {
    /// [`Whitted::radiance`] of a ray that is sent for a share of what sends it.
    pub fn send(
        &mut self,
        (kind, share): (RayKind, DVec3),
        ray: &WorldRay,
        generation: u32,
        media: &Media,
    ) -> DVec3 {
        let depth = self.recorder.depth();
        self.recorder.enter(kind, ray, share);
        let radiance = self.radiance(ray, generation, media);
        self.recorder.back_to(depth);
        radiance
    }

    /// Linear RGB along a ray of a generation (the camera's is 1) that is inside `media`. A boundary of
    /// equal indices does not end the generation: the ray goes straight on, a loop and no recursion.
    fn radiance(&mut self, ray: &WorldRay, generation: u32, media: &Media) -> DVec3 {
        if generation > self.scene.max_generations.min(GENERATIONS_CAPACITY) {
            return DVec3::ZERO;
        }
        let (mut ray, mut media) = (*ray, media.clone());
        let (mut sum, mut weight) = (DVec3::ZERO, DVec3::ONE);
        for _ in 0..=STRAIGHT_CAPACITY {
            let met = self.meet(&ray);
            let length = met.as_ref().map_or(f64::INFINITY, |met| met.1);
            let left = self.left_after(&media, length);
            weight *= left;
            self.recorder.meet(met.as_ref().map(|met| &met.2), left);
            let Some((surface, ..)) = met else {
                let sky = self.sky(ray.dir);
                self.recorder.add(sky);
                return sum + weight * sky;
            };
            sum += weight * self.local_light(&surface, ray.dir, &media);
            let (eta, beyond) = cross(&media, surface.start.0, surface.material.ior);
            let shares = Shares::of(&surface, ray.dir, eta);
            let from_here = |dir| WorldRay {
                origin: surface.point,
                dir,
                width: surface.width,
                start: Some(surface.start),
            };
            if shares.reflected.max_element() > 0.0 {
                self.counters.reflected_rays += 1;
                let mirrored = from_here(mirror(ray.dir, &surface));
                let sent = (RayKind::Mirrored, shares.reflected);
                let light = self.send(sent, &mirrored, generation + 1, &media);
                sum += weight * shares.reflected * light;
            }
            let Some(onward) = shares.onward else {
                return sum;
            };
            self.counters.refracted_rays += 1;
            weight *= shares.passed;
            if onward != ray.dir {
                let bent = from_here(onward);
                let sent = (RayKind::Refracted, shares.passed);
                return sum + weight * self.send(sent, &bent, generation + 1, &beyond);
            }
            (ray, media) = (from_here(onward), beyond);
            self.recorder.enter(RayKind::Straight, &ray, shares.passed);
        }
        self.counters.straight_overflows += 1;
        sum
    }

    /// The background along a direction.
    fn sky(&self, dir: DVec3) -> DVec3 {
        let background = &self.scene.background;
        let height = dir.normalize().y;
        let end = if height > 0.0 {
            background.zenith
        } else {
            background.ground
        };
        let horizon = background.horizon.as_dvec3();
        if background.is_plain() {
            return horizon;
        }
        let color = horizon.lerp(end.as_dvec3(), height.abs());
        match look::texture(self.scene, background.picture) {
            Some(panorama) => color * look::panorama(panorama, background.turn, dir.normalize()),
            None => color,
        }
    }

    /// What is left of light after a length within the innermost medium.
    fn left_after(&self, media: &Media, length: f64) -> DVec3 {
        let Some(&(id, _)) = media.last() else {
            return DVec3::ONE;
        };
        let material = self.scene.instances[id as usize].material;
        let absorption = self.scene.materials[material as usize]
            .absorption
            .as_dvec3();
        let left = |a: f64| if a > 0.0 { (-a * length).exp() } else { 1.0 };
        DVec3::from(absorption.to_array().map(left))
    }

    /// The surface that a ray meets, how far away, and the hit.
    fn meet(&mut self, ray: &WorldRay) -> Option<(Surface, f64, WorldHit)> {
        let before = (f64::INFINITY, 0, 0);
        let recorder = &mut self.recorder;
        let world = self.world;
        let hit = world.nearest_told(ray, just_after(0.0), before, recorder)?;
        let point = self
            .world
            .on_surface(&hit, ray.origin + ray.dir * hit.key.0);
        let (face, shading, material) = self.world.normals(&hit, point);
        let n_geom = if face.dot(ray.dir) > 0.0 { -face } else { face };
        let n_shade = if shading.dot(n_geom) < 0.0 {
            -shading
        } else {
            shading
        };
        let material = self.scene.materials[material as usize];
        let mut surface = Surface {
            point,
            n_geom,
            n_shade,
            material,
            color: material.color.as_dvec3(),
            width: ray.width + self.spread() * hit.key.0,
            lift: self.world.lift(&hit, face.dot(n_geom)),
            start: (hit.key.1, hit.key.2),
        };
        let is_outward = face.dot(n_geom) > 0.0;
        self.appear(&mut surface, &hit, ray.dir, is_outward);
        Some((surface, hit.key.0, hit))
    }

    /// What a cone widens by, a length: rays of a pinhole's pixels part.
    fn spread(&self) -> f64 {
        match self.scene.view.projection {
            ViewProjection::Perspective => self.pixel_width,
            ViewProjection::Orthographic => 0.0,
        }
    }

    /// Colour and normal of a mesh with looks.
    fn appear(&self, surface: &mut Surface, hit: &WorldHit, dir: DVec3, is_outward: bool) {
        let Some((look, chart)) = self.world.look(hit) else {
            return;
        };
        surface.color *= look.color.truncate();
        let Some(uv) = look.uv else {
            return;
        };
        let footprint = chart.footprint(surface.width, dir.dot(surface.n_geom));
        let material = &surface.material;
        if let Some(map) = look::texture(self.scene, material.color_map) {
            surface.color *= look::sample(map, uv, footprint).truncate();
        }
        let Some(map) = look::texture(self.scene, material.normal_map) else {
            return;
        };
        let side = if is_outward { 1.0 } else { -1.0 };
        let map = look::sample(map, uv, footprint).truncate();
        let tilted = chart.tilted(surface.n_shade * side, map);
        if let Some(tilted) = tilted.filter(|n| n.dot(surface.n_geom) * side > 0.0) {
            surface.n_shade = tilted * side;
        }
    }

    /// The colour of a hit at the finest level: what tints a shadow.
    fn tint(&self, hit: &WorldHit, material: &Material) -> DVec3 {
        let mut color = material.color.as_dvec3();
        if let Some((look, _)) = self.world.look(hit) {
            color *= look.color.truncate();
            let map = look::texture(self.scene, material.color_map);
            if let Some((map, uv)) = map.zip(look.uv) {
                color *= look::sample(map, uv, 0.0).truncate();
            }
        }
        color
    }

    /// Emission and every light's diffuse, Phong and Blinn-Phong share.
    fn local_light(&mut self, surface: &Surface, dir: DVec3, media: &Media) -> DVec3 {
        let m = &surface.material;
        let color = surface.color;
        let opaque = (1.0 - f64::from(m.filter) - f64::from(m.transmit)).max(0.0);
        let mut sum = color * (f64::from(m.emission) * opaque);
        self.recorder.add(sum);
        for (number, light) in self.scene.lights.iter().enumerate() {
            let (to_light, distance) = self.beam(light, surface.point);
            let cosine = surface.n_shade.dot(to_light);
            let is_away = surface.lift.is_none() && surface.n_geom.dot(to_light) < 1e-10;
            if cosine < 1e-10 || is_away {
                continue;
            }
            let mut answer = color * (f64::from(m.diffuse) * opaque * cosine);
            if let Some(phong) = m.phong {
                let mirrored = dir - surface.n_shade * (2.0 * dir.dot(surface.n_shade));
                let cosine = mirrored.dot(to_light).max(0.0);
                answer += f64::from(phong.strength) * cosine.powf(phong.exponent.into());
            }
            if let Some(specular) = m.specular {
                let half = (to_light - dir).normalize_or(surface.n_shade);
                let cosine = surface.n_shade.dot(half).max(0.0);
                answer += f64::from(specular.strength) * cosine.powf(specular.exponent.into());
            }
            let strength = strength(light, to_light, distance);
            if answer * strength != DVec3::ZERO {
                let share = answer * strength;
                let sent = (RayKind::Shadow(number as u32), share);
                sum += share * self.shadow(sent, (surface, media), to_light, distance);
            }
        }
        sum
    }

    /// Unit direction to a light and its distance.
    fn beam(&self, light: &Light, from: DVec3) -> (DVec3, f64) {
        match light.kind {
            LightKind::Directional { to_light } => (to_light, f64::INFINITY),
            LightKind::Point { position } | LightKind::Spot { position, .. } => {
                let line = position - self.scene.view.origin - from;
                (line.normalize_or_zero(), line.length())
            }
        }
    }

    /// The product over all surfaces between a point and a light, and over the media between them.
    fn shadow(
        &mut self,
        (kind, share): (RayKind, DVec3),
        (surface, media): (&Surface, &Media),
        to_light: DVec3,
        distance: f64,
    ) -> DVec3 {
        self.counters.shadow_rays += 1;
        let ray = WorldRay {
            origin: surface.point + surface.lift.unwrap_or(DVec3::ZERO),
            dir: to_light,
            width: 0.0,
            start: Some(surface.start),
        };
        let depth = self.recorder.depth();
        self.recorder.enter(kind, &ray, share);
        let passed = self.passed(&ray, distance, media.clone());
        self.recorder.add(passed);
        self.recorder.back_to(depth);
        passed
    }

    /// What passes along a shadow ray that starts inside of media.
    fn passed(&mut self, ray: &WorldRay, distance: f64, mut inside: Media) -> DVec3 {
        let before = (distance, 0, 0);
        let (mut passed, mut after) = (DVec3::ONE, just_after(0.0));
        self.recorder.meet(None, DVec3::ONE);
        let world = self.world;
        while let Some(hit) = world.nearest_told(ray, after, before, &mut self.recorder) {
            self.recorder.meet(Some(&hit), DVec3::ONE);
            let (.., material) = world.normals(&hit, DVec3::Y);
            let material = &self.scene.materials[material as usize];
            if material.transmission().max_element() <= 0.0 {
                return DVec3::ZERO;
            }
            passed *= passes(material, self.tint(&hit, material));
            passed *= self.left_after(&inside, hit.key.0 - after.0);
            inside = cross(&inside, hit.key.1, material.ior).1;
            after = hit.key;
        }
        passed * self.left_after(&inside, distance - after.0)
    }
}

/// [`Material::transmission`] of a surface of this colour.
fn passes(material: &Material, color: DVec3) -> DVec3 {
    let color = color.as_vec3();
    Material { color, ..*material }.transmission().as_dvec3()
}

fn just_after(t: f64) -> Key {
    (t, u32::MAX, u32::MAX)
}

/// A light's colour after fading and its cone.
fn strength(light: &Light, to_light: DVec3, distance: f64) -> DVec3 {
    let mut factor = light.fade.map_or(1.0, |fade| fade.factor(distance));
    if let LightKind::Spot {
        axis,
        cos_inner,
        cos_outer,
        ..
    } = light.kind
    {
        let x = ((-to_light.dot(axis) - cos_outer) / (cos_inner - cos_outer)).clamp(0.0, 1.0);
        factor *= x * x * (3.0 - 2.0 * x);
    }
    light.color.as_dvec3() * factor
}

/// What a surface reflects and passes on.
struct Shares {
    reflected: DVec3,
    passed: DVec3,
    /// Direction of what passes; the ray's own where the indices agree.
    onward: Option<DVec3>,
}

impl Shares {
    fn of(surface: &Surface, dir: DVec3, eta: f64) -> Self {
        let material = &surface.material;
        let cosine = (-dir.dot(surface.n_shade)).clamp(0.0, 1.0);
        let mut passed = passes(material, surface.color);
        let mut reflected = match material.reflection {
            Reflection::None => DVec3::ZERO,
            Reflection::Constant(weight) => weight.as_dvec3(),
            Reflection::Fresnel => {
                let share = fresnel(eta, cosine);
                passed *= 1.0 - share;
                DVec3::splat(share)
            }
        };
        let mut onward = None;
        if passed.max_element() > 0.0 {
            let k = 1.0 + eta * eta * (cosine * cosine - 1.0);
            if (eta - 1.0).abs() < 1e-10 {
                onward = Some(dir);
            } else if k < 0.0 {
                reflected = DVec3::ONE;
            } else {
                let bent = dir * eta + surface.n_shade * (eta * cosine - k.sqrt());
                onward = Some(bent.normalize());
            }
        }
        Self {
            reflected,
            passed,
            onward,
        }
    }
}

/// The index ratio at the boundary of medium `id`, and the media beyond it.
fn cross(media: &Media, id: u32, ior: f64) -> (f64, Media) {
    let mut beyond = media.clone();
    let top = media.last().map_or(1.0, |m| m.1);
    let Some(place) = media.iter().position(|m| m.0 == id) else {
        beyond.push((id, ior));
        return (top / ior, beyond);
    };
    beyond.remove(place);
    if place + 1 == media.len() {
        (ior / beyond.last().map_or(1.0, |m| m.1), beyond)
    } else {
        (1.0, beyond)
    }
}

/// Unpolarised reflectance; 1 in total internal reflection.
fn fresnel(eta: f64, c: f64) -> f64 {
    let g_squared = 1.0 / (eta * eta) + c * c - 1.0;
    if g_squared <= 0.0 {
        return 1.0;
    }
    let g = g_squared.sqrt();
    let s = (g - c) / (g + c);
    let p = (c * (g + c) - 1.0) / (c * (g - c) + 1.0);
    (0.5 * s * s * (1.0 + p * p)).clamp(0.0, 1.0)
}

fn mirror(dir: DVec3, surface: &Surface) -> DVec3 {
    let about = |n: DVec3| (dir - n * (2.0 * dir.dot(n))).normalize();
    let smooth = about(surface.n_shade);
    if smooth.dot(surface.n_geom) > 0.0 {
        smooth
    } else {
        about(surface.n_geom)
    }
}
