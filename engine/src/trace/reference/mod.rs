//! The reference tracer: f64, recursive, plain. The oracle of the accuracy figures, never tuned for speed.
//!
//! It shares no kernel with the f32 tracers, only the frame's data and the model; Rust does not contract
//! a*b+c, so every operation is IEEE double.

pub(super) mod deform;
mod explain;
mod look;
mod shape;
mod survey;
#[cfg(test)]
mod tests;
mod torus;
mod tree;
mod whitted;
mod world;

pub use self::explain::{ExplainedRay, Explanation, Fate, MOST_RAYS, RayKind};
pub use self::survey::{Heat, PixelCost, Survey, ThingCost};

use std::time::Instant;

use glam::{DVec2, DVec3, UVec2};
use rayon::prelude::*;

use self::explain::{Recorder, TreeRecorder};
use self::whitted::Whitted;
use self::world::{World, WorldHit, WorldRay};
use super::{
    Backend, Counters, Hit, PassTime, Picture, PictureTime, Query, Ray, TraceError, Tracer,
};
use crate::frame::wire::SAMPLES_CAPACITY;
use crate::frame::{FrameScene, TraceSettings, ViewProjection, sample_offset};

/// See the module.
#[derive(Default)]
pub struct ReferenceTracer {
    world: World,
    scene: FrameScene,
    settings: TraceSettings,
    picture: Option<Picture>,
    counters: Counters,
    passes: Vec<PassTime>,
}

/// What a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// In lengths of the ray's direction.
    pub t: f64,
    /// Row of `FrameScene::instances`.
    pub instance: u32,
    /// Primitive of the instance.
    pub prim: u32,
    /// Barycentric weights of a triangle's second and third corner; 0 for other shapes.
    pub uv: DVec2,
    /// Relative to the eye, on the surface.
    pub point: DVec3,
    /// Unit normal of the face, outward as the shape or the triangle's winding has it.
    pub normal: DVec3,
    /// Unit normal that light is computed with: interpolated on smooth meshes.
    pub shading_normal: DVec3,
}

impl ReferenceTracer {
    /// A tracer on rayon's global pool.
    pub fn new() -> Self {
        Self::default()
    }

    /// What a ray from `origin` (relative to the eye) along `dir` (of any length but zero) meets first in the uploaded
    /// frame, in f64: the oracle for single rays.
    pub fn answer(&self, origin: DVec3, dir: DVec3) -> Option<Answer> {
        let ray = WorldRay {
            origin,
            dir,
            width: 0.0,
            start: None,
        };
        let (after, before) = ((0.0, u32::MAX, u32::MAX), (f64::INFINITY, 0, 0));
        let hit = self.world.nearest(&ray, after, before)?;
        let point = self.world.on_surface(&hit, origin + dir * hit.key.0);
        let (normal, shading_normal, _) = self.world.normals(&hit, point);
        Some(Answer {
            t: hit.key.0,
            instance: hit.key.1,
            prim: hit.key.2,
            uv: hit.uv,
            point,
            normal,
            shading_normal,
        })
    }

    /// The ray through a point of the picture, in pixels from its top left corner.
    fn camera_ray(&self, px: f64, py: f64) -> WorldRay {
        let view = &self.scene.view;
        let size = self.settings.size.as_dvec2();
        let aside = view.right * (px / size.x - 0.5) + view.up * (0.5 - py / size.y);
        let (origin, dir, width) = match view.projection {
            ViewProjection::Perspective => (DVec3::ZERO, (view.forward + aside).normalize(), 0.0),
            ViewProjection::Orthographic => (aside, view.forward, self.pixel_width()),
        };
        WorldRay {
            origin,
            dir,
            width,
            start: None,
        }
    }

    fn pixel_width(&self) -> f64 {
        self.scene.view.up.length() / f64::from(self.settings.size.y)
    }

    /// [`Query::Leave`] of a pair.
    fn leave(&self, pair: &[Ray]) -> [Hit; 2] {
        let [arriving, leaving] = pair else {
            return [Hit::MISS; 2];
        };
        let nearest = |ray: &WorldRay, ends: &Ray| {
            let after = (f64::from(ends.t_min), u32::MAX, u32::MAX);
            self.world
                .nearest(ray, after, (f64::from(ends.t_max), 0, 0))
        };
        let ray = WorldRay::from(arriving);
        let Some(hit) = nearest(&ray, arriving) else {
            return [Hit::MISS; 2];
        };
        let near = ray.origin + ray.dir * hit.key.0;
        let origin = self.world.on_surface(&hit, near);
        let (face, ..) = self.world.normals(&hit, origin);
        let normal = if face.dot(ray.dir) > 0.0 { -face } else { face };
        let (tangent, bitangent) = normal.any_orthonormal_pair();
        let frame = glam::DMat3::from_cols(tangent, bitangent, normal);
        let onward = WorldRay {
            origin,
            dir: frame * leaving.dir.as_dvec3(),
            width: 0.0,
            start: Some((hit.key.1, hit.key.2)),
        };
        let next = nearest(&onward, leaving);
        [hit_of(&hit), next.map_or(Hit::MISS, |hit| hit_of(&hit))]
    }

    /// Every ray of a pixel of the uploaded frame, whether that was rendered or not; none: the picture has no such pixel.
    pub fn explain(&self, pixel: UVec2) -> Option<Explanation> {
        let size = self.settings.size;
        if pixel.cmpge(size).any() {
            return None;
        }
        let mut whitted = self.whitted(TreeRecorder::new(self.scene.view.origin));
        let color = self.pixel(pixel.x, pixel.y, &mut whitted);
        let counters = whitted.counters;
        let recorder = whitted.recorder;
        Some(recorder.explanation(pixel, size, color, counters))
    }

    /// Whitted's walk of the uploaded frame, told to a recorder.
    fn whitted<R: Recorder>(&self, recorder: R) -> Whitted<'_, R> {
        Whitted {
            scene: &self.scene,
            world: &self.world,
            pixel_width: self.pixel_width(),
            counters: Counters::default(),
            recorder,
        }
    }

    fn pixel<R: Recorder>(&self, x: u32, y: u32, whitted: &mut Whitted<R>) -> DVec3 {
        let samples = self.settings.samples.clamp(1, SAMPLES_CAPACITY);
        let mut sum = DVec3::ZERO;
        for index in 0..samples {
            let [right, down] = sample_offset(index).map(f64::from);
            whitted.counters.primary_rays += 1;
            let ray = self.camera_ray(f64::from(x) + right, f64::from(y) + down);
            let share = DVec3::splat(1.0 / f64::from(samples));
            let sent = (RayKind::Camera(index), share);
            sum += whitted.send(sent, &ray, 1, &Vec::new());
        }
        sum / f64::from(samples)
    }
}

fn hit_of(hit: &WorldHit) -> Hit {
    Hit {
        t: hit.key.0,
        instance: hit.key.1,
        prim: hit.key.2,
        uv: hit.uv.to_array(),
    }
}

impl Tracer for ReferenceTracer {
    fn backend(&self) -> Backend {
        Backend::Reference
    }

    fn device(&self) -> String {
        super::host_description()
    }

    fn refit(&mut self, scene: &FrameScene) -> Result<(), TraceError> {
        let start = Instant::now();
        self.counters = Counters {
            trees_updated: self.world.refit(scene),
            ..Default::default()
        };
        self.passes = vec![PassTime::since("mesh trees", start)];
        Ok(())
    }

    fn upload(&mut self, scene: &FrameScene, settings: &TraceSettings) -> Result<(), TraceError> {
        self.scene.clone_from(scene);
        self.settings = *settings;
        self.world.place(scene);
        Ok(())
    }

    fn render(&mut self) -> Result<(), TraceError> {
        let start = Instant::now();
        let UVec2 {
            x: width,
            y: height,
        } = self.settings.size;
        let rows: Vec<(Vec<glam::Vec3>, Counters)> = (0..height)
            .into_par_iter()
            .map(|y| {
                let mut whitted = self.whitted(());
                let row = (0..width).map(|x| self.pixel(x, y, &mut whitted).as_vec3());
                (row.collect(), whitted.counters)
            })
            .collect();
        let trees_updated = self.counters.trees_updated;
        self.counters = rows
            .iter()
            .fold(Counters::default(), |sum, row| sum + row.1);
        self.counters.trees_updated = trees_updated;
        self.picture = Some(Picture {
            size: self.settings.size,
            pixels: rows.into_iter().flat_map(|row| row.0).collect(),
        });
        self.passes.push(PassTime::since("whitted", start));
        Ok(())
    }

    fn picture(&mut self) -> Result<Picture, TraceError> {
        self.picture.clone().ok_or_else(super::no_picture_yet)
    }

    fn intersect(&mut self, rays: &[Ray], query: Query) -> Result<Vec<Hit>, TraceError> {
        if query == Query::Leave {
            let pairs: Vec<[Hit; 2]> = rays.par_chunks(2).map(|pair| self.leave(pair)).collect();
            return Ok(pairs.into_iter().flatten().take(rays.len()).collect());
        }
        let answer = |ray: &Ray| {
            let after = (f64::from(ray.t_min), u32::MAX, u32::MAX);
            let before = (f64::from(ray.t_max), 0, 0);
            let hit = self.world.nearest(&ray.into(), after, before);
            match query {
                Query::Any => Hit::any(hit.is_some()),
                Query::Closest | Query::Leave => hit.map_or(Hit::MISS, |hit| hit_of(&hit)),
            }
        };
        Ok(rays.par_iter().map(answer).collect())
    }

    fn samples(&self) -> u32 {
        self.settings.samples
    }

    fn counters(&self) -> Counters {
        self.counters
    }

    fn pass_times(&self) -> Vec<PassTime> {
        self.passes.clone()
    }

    fn timed_picture(&self) -> Option<PictureTime> {
        let picture = self.picture.as_ref()?;
        Some(PictureTime {
            size: picture.size,
            rays: self.passes.last()?.millis,
        })
    }
}
