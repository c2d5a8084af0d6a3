//! What the scene is made of and what its camera sees, counted.

use std::path::Path;

use glam::UVec2;
use orrery_engine::Engine;
use orrery_engine::frame::{FrameScene, Instance, Shape};
use orrery_engine::trace::{ActiveTracer, Query};
use orrery_engine::world::{Material, MeshRow, Reflection};

use crate::args::{BackendChoice, Common};
use crate::bench::frame::{FRAMES_PER_SEC, SIZE};
use crate::bench::rays::primary_rays;
use crate::bench::report::{Better, Row};
use crate::failure::Failure;
use crate::{device, stage};

/// What an opaque surface reflects in its brightest channel, at least, to be called a mirror.
const MIRROR: f32 = 0.2;
/// Triangles in motion, at least, half of them deforming.
const TRIANGLES: f64 = 100_000.0;
/// Pixels whose camera ray meets a mirror, and glass: at least, in per cent.
const SEEN: [f64; 2] = [30.0, 10.0];

/// Triangles of every instance that is not as it was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Motion {
    /// In another place, otherwise the same.
    rigid: usize,
    /// With other corners.
    deforming: usize,
}

impl Motion {
    fn between(before: &FrameScene, after: &FrameScene) -> Self {
        let mut motion = Self::default();
        for (old, new) in before.instances.iter().zip(after.instances.iter()) {
            let (Shape::Mesh(from), Shape::Mesh(to)) = (old.shape, new.shape) else {
                continue;
            };
            let (from, to) = (&before.meshes[from as usize], &after.meshes[to as usize]);
            let triangles = to.data.triangles.len();
            if is_deformed(from, to) {
                motion.deforming += triangles;
            } else if old.world_from_local != new.world_from_local {
                motion.rigid += triangles;
            }
        }
        motion
    }
}

fn is_deformed(from: &MeshRow, to: &MeshRow) -> bool {
    from.deformation != to.deformation
}

/// What a camera ray meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Seen {
    Mirror,
    Glass,
    Other,
}

impl Seen {
    fn of(material: &Material) -> Self {
        let is_mirror = match material.reflection {
            Reflection::Constant(share) => share.max_element() >= MIRROR,
            Reflection::None | Reflection::Fresnel => false,
        };
        if material.transmission().max_element() > 0.0 {
            Self::Glass
        } else if is_mirror {
            Self::Mirror
        } else {
            Self::Other
        }
    }
}

/// Rows that say what there is: triangles in motion from a frame to the next, and shares of the pixels.
pub fn rows(scene: &Path, frame: u64, common: &Common) -> Result<Vec<Row>, Failure> {
    let mut engine = stage::set(scene, common, SIZE, FRAMES_PER_SEC)?;
    stage::cast(
        &mut engine,
        device::open_choice(BackendChoice::Cpu, common)?,
    );
    stage::advance(&mut engine, frame)?;
    let before = engine.world.resource::<FrameScene>().clone();
    stage::advance(&mut engine, frame + 1)?;
    let after = engine.world.resource::<FrameScene>();
    let motion = Motion::between(&before, after);
    let is_mesh = |instance: &&Instance| matches!(instance.shape, Shape::Mesh(_));
    let meshes = after.instances.iter().filter(is_mesh).count();
    // Many fish are one mesh in many places.
    let distinct: usize = after
        .meshes
        .iter()
        .map(|row| row.data.triangles.len())
        .sum();
    let triangles = |what, count: usize| {
        Row::single(what, "triangles", Better::Higher, count as f64).with_target(TRIANGLES / 2.0)
    };
    let mut rows = vec![
        triangles("rigid", motion.rigid),
        triangles("deforming", motion.deforming),
        Row::single("distinct", "triangles", Better::Higher, distinct as f64),
        Row::single("meshes", "shapes", Better::Higher, meshes as f64),
        Row::single(
            "lights",
            "lights",
            Better::Higher,
            after.lights.len() as f64,
        ),
    ];
    let size = stage::settings(common, SIZE).size;
    rows.extend(shares(&mut engine, size)?);
    Ok(rows)
}

/// Of the pixels of the last frame, those that see a mirror, and glass.
fn shares(engine: &mut Engine, size: UVec2) -> Result<[Row; 2], Failure> {
    let scene = engine.world.resource::<FrameScene>().clone();
    let rays = primary_rays(&scene.view, size);
    let mut tracer = engine.world.resource_mut::<ActiveTracer>();
    let Some(tracer) = &mut tracer.0 else {
        return Err(Failure::NoDevice("no tracer was opened".into()));
    };
    let hits = tracer.intersect(&rays, Query::Closest)?;
    let seen = hits.iter().filter(|hit| hit.instance != u32::MAX);
    let seen: Vec<Seen> = seen
        .map(|hit| {
            let instance = &scene.instances[hit.instance as usize];
            Seen::of(&scene.materials[instance.material as usize])
        })
        .collect();
    let row = |name, what, least| {
        let count = seen.iter().filter(|seen| **seen == what).count();
        let share = count as f64 / rays.len().max(1) as f64 * 100.0;
        Row::single(name, "% pixels", Better::Higher, share).with_target(least)
    };
    Ok([
        row("mirror", Seen::Mirror, SEEN[0]),
        row("glass", Seen::Glass, SEEN[1]),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn glass_that_reflects_is_no_mirror() {
        let of = |reflection, transmit| {
            Seen::of(&Material {
                reflection,
                transmit,
                ..Material::default()
            })
        };
        let half = Reflection::Constant(Vec3::splat(0.5));
        assert_eq!(of(half, 0.0), Seen::Mirror);
        assert_eq!(of(half, 0.5), Seen::Glass);
        assert_eq!(of(Reflection::Fresnel, 0.5), Seen::Glass);
        assert_eq!(of(Reflection::Fresnel, 0.0), Seen::Other);
        let faint = Reflection::Constant(Vec3::splat(0.1));
        assert_eq!(of(faint, 0.0), Seen::Other);
    }
}
