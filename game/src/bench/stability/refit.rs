//! Meshes that deform for a long time: refitted trees still hold everything, and give what brute force gives.
//!
//! On the host every primitive must be inside every ancestor, after random walks of all vertices. On the backend two copies
//! of a mesh go through the same deformations, one with a tree and one without: same hits.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3, Vec3A};
use orrery_engine::bvh::{Extent, Tree};
use orrery_engine::frame::{FrameScene, Kernels, Shape};
use orrery_engine::geom::Aabb;
use orrery_engine::trace::{Backend, Hit, Query, Ray};
use orrery_engine::world::{DeformStep, Deformation, MeshRow, Structure};

use super::course::{Course, ready, scene_of};
use super::draw::Draw;
use super::solids::Solid;
use super::tally::{Tally, Verdict};
use crate::failure::Failure;
use crate::output::progress;

/// The suite.
pub const NAME: &str = "refit";
/// Frames of the host's walk.
const FRAMES: u64 = 3000;
/// The same where rays without end are asked for.
const LONG: u64 = 100_000;
/// Frames on the backend for each hundred on the host.
const SHARE: u64 = 30;
/// Rays a frame.
const RAYS: u64 = 1000;

/// Runs both.
pub fn run(course: &mut Course) -> Result<(), Failure> {
    let frames = course.scenes(FRAMES, LONG);
    let mut walk = Walk::new();
    let stale = walk.stale(10);
    course.must_fail(&format!("{NAME}.stale"), &stale, None);
    let held = walk.refitted(frames);
    course.none_may_fail(&format!("{NAME}.contained"), &held);
    let late = against_none(course, 1, 2)?;
    course.must_fail(&format!("{NAME}.rays.late"), &late, None);
    let same = against_none(course, 0, (frames / SHARE).max(2))?;
    course.none_may_fail(&format!("{NAME}.rays"), &same);
    Ok(())
}

/// A mesh whose vertices wander, and its tree.
struct Walk {
    positions: Vec<Vec3A>,
    triangles: Vec<[u32; 3]>,
    tree: Tree,
    draw: Draw,
}

impl Walk {
    fn new() -> Self {
        let solid = Solid::icosphere(2);
        let positions: Vec<Vec3A> = solid.points.iter().map(|p| p.as_vec3a()).collect();
        let mut walk = Self {
            positions,
            triangles: solid.triangles,
            tree: Tree::default(),
            draw: Draw::of(1300, 0),
        };
        walk.tree = Tree::build(&walk.boxes());
        walk
    }

    fn boxes(&self) -> Vec<Aabb> {
        let boxes = self.triangles.iter().map(|t| self.extent(*t).into());
        boxes.collect()
    }

    fn extent(&self, triangle: [u32; 3]) -> Extent {
        Extent::of_triangle(triangle.map(|v| self.positions[v as usize]))
    }

    /// Every vertex somewhere else; now and then far out, or flat.
    fn step(&mut self) {
        let reach = self.draw.power(-3.0, 1.0) as f32;
        let flat = self.draw.below(6);
        for p in &mut self.positions {
            let mut next = *p + Vec3A::from(self.draw.cube().as_vec3()) * reach;
            if flat < 3 {
                next[flat] = 0.25;
            }
            *p = next.clamp(Vec3A::splat(-1e3), Vec3A::splat(1e3));
        }
    }

    /// Trees that are not refitted.
    fn stale(&mut self, frames: u64) -> Tally {
        let mut tally = Tally::default();
        for _ in 0..frames {
            self.step();
            let is_right = self.tree.validate(&self.boxes()).is_ok();
            tally.take(Verdict::of(is_right));
        }
        tally
    }

    fn refitted(&mut self, frames: u64) -> Tally {
        let bar = progress(frames, NAME);
        let mut tally = Tally::default();
        for _ in 0..frames {
            self.step();
            let Self {
                positions,
                triangles,
                tree,
                ..
            } = self;
            let prims = std::mem::take(&mut tree.prims);
            let corner = |v: u32| positions[v as usize];
            tree.refit(|place| Extent::of_triangle(triangles[prims[place] as usize].map(corner)));
            tree.prims = prims;
            let is_right = self.tree.validate(&self.boxes()).is_ok();
            tally.take(Verdict::of(is_right));
            bar.inc(1);
        }
        bar.finish_and_clear();
        tally
    }
}

/// Rays at a mesh that waves and twists, with its tree, and without one `late` frames after.
fn against_none(course: &mut Course, late: u64, frames: u64) -> Result<Tally, Failure> {
    let mut tally = Tally::default();
    let mut scenes = [Structure::Boxes4, Structure::None].map(wavy);
    let bar = progress(frames, NAME);
    for frame in 0..frames {
        let rays: Vec<Ray> = (0..RAYS).map(|i| ray(frame, i)).collect();
        let mut answers: [Vec<Hit>; 2] = Default::default();
        for ((scene, hits), late) in scenes.iter_mut().zip(&mut answers).zip([0, late]) {
            let scene = scene.as_mut().map_err(|why| Failure::Input(why.clone()))?;
            deform(scene, frame + late);
            course.upload(scene, Kernels::default())?;
            *hits = course.tracer.intersect(&rays, Query::Closest)?;
        }
        let exact = course.tracer.backend() != Backend::Gpu;
        for (found, expected) in answers[0].iter().zip(&answers[1]) {
            tally.take(judge(found, expected, exact));
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(tally)
}

/// The same hit, bit for bit; on a device, which may have the host deform one copy of the mesh and itself the other,
/// the same triangle at the same place, where rounding cannot make it another.
fn judge(found: &Hit, expected: &Hit, exact: bool) -> Verdict {
    if found == expected || exact {
        return Verdict::of(found == expected);
    }
    let is_inside = |hit: &Hit| {
        let [u, v] = hit.uv;
        *hit == Hit::MISS || u.min(v).min(1.0 - u - v) > 1e-3
    };
    if found.prim == expected.prim {
        Verdict::of((found.t - expected.t).abs() <= 1e-4 * expected.t)
    } else if is_inside(found) && is_inside(expected) {
        Verdict::Wrong
    } else {
        Verdict::Void
    }
}

fn wavy(structure: Structure) -> Result<FrameScene, String> {
    let row = MeshRow {
        structure,
        ..Solid::icosphere(2).mesh()?.into()
    };
    let mut scene = scene_of([(Shape::Mesh(0), DAffine3::IDENTITY)]);
    scene.meshes = vec![row].into();
    Ok(ready(scene))
}

fn deform(scene: &mut FrameScene, frame: u64) {
    let mut draw = Draw::of(1400, frame);
    let deformation = Deformation {
        steps: vec![
            DeformStep::Wave {
                wave: draw.cube() * 6.0,
                amplitude: draw.cube() * 0.5,
                phase: draw.range(0.0, 6.3),
            },
            DeformStep::Twist {
                origin: DVec3::ZERO,
                axis: draw.direction(),
                rate: draw.range(-2.0, 2.0),
                offset: 0.0,
            },
        ],
    };
    let row = MeshRow {
        deformation: Some(Arc::new(deformation)),
        ..scene.meshes[0].clone()
    };
    scene.meshes.replace(0, row);
}

fn ray(frame: u64, index: u64) -> Ray {
    let mut draw = Draw::of(1500 + frame, index);
    let origin = (draw.direction() * 2.5).as_vec3();
    let target = (draw.ball() * 0.9).as_vec3();
    let dir = match draw.below(4) {
        0 => {
            let axis = draw.below(3);
            let mut dir = Vec3::ZERO;
            dir[axis] = if origin[axis] > 0.0 { -1.0 } else { 1.0 };
            dir
        }
        _ => target - origin,
    };
    Ray {
        origin,
        dir,
        t_min: 0.0,
        t_max: f32::MAX,
    }
}
