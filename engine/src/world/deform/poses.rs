//! Deformers that mix given positions: key-framed vertices and morph targets.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use bevy_reflect::prelude::*;
use serde::{Deserialize, Serialize};

use super::{DeformStep, VertexSets};
use crate::world::Loop;

/// Plays through whole poses of a mesh, straight from each to the next. The first deformer there is.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[reflect(Component, Default, Clone, PartialEq)]
#[component(summary_tick)]
pub struct KeyFrames {
    /// Every vertex of every pose, relative to [`crate::world::MeshData::origin`].
    #[reflect(ignore)]
    #[serde(with = "crate::pod::shared")]
    pub keys: Arc<VertexSets>,
    /// Seconds of play at which each pose is reached; rising, one a pose.
    pub times: Vec<f64>,
    /// Seconds of play at scene time 0.
    pub start: f64,
    /// Seconds of play a second of scene time; 0 holds the pose at `start`, negative plays backwards.
    pub speed: f64,
    /// What follows the last pose.
    pub repeat: Loop,
}

impl KeyFrames {
    /// Seconds of the scene until all poses have been played through; 0: nothing plays.
    pub fn period(&self) -> f64 {
        let (Some(&first), Some(&last)) = (self.times.first(), self.times.last()) else {
            return 0.0;
        };
        let secs = (last - first) / self.speed.abs();
        if secs.is_finite() { secs } else { 0.0 }
    }

    /// The step at a time in seconds.
    ///
    /// # Errors
    /// What keeps it from deforming a mesh of so many vertices.
    pub(in crate::world) fn step(&self, secs: f64, vertices: usize) -> Result<DeformStep, String> {
        check_sets("key frames", &self.keys, vertices)?;
        let (Some(&first), Some(&last)) = (self.times.first(), self.times.last()) else {
            return Err("key frames have no pose".into());
        };
        if self.times.len() != self.keys.count() as usize {
            return Err(format!(
                "{} times for {} key frames",
                self.times.len(),
                self.keys.count()
            ));
        }
        let time = self
            .repeat
            .wrap(self.start + self.speed * secs, first, last);
        if !time.is_finite() || !self.times.is_sorted() {
            return Err("times, start and speed of key frames must be finite and rising".into());
        }
        let to = self.times.partition_point(|&key| key <= time);
        let to = to.min(self.times.len() - 1);
        let from = to.saturating_sub(1);
        let length = self.times[to] - self.times[from];
        let share = if length > 0.0 {
            ((time - self.times[from]) / length).clamp(0.0, 1.0)
        } else {
            0.0
        };
        Ok(DeformStep::Keys {
            keys: Arc::clone(&self.keys),
            from: from as u32,
            to: to as u32,
            share,
        })
    }
}

/// Adds weighted offsets to every vertex, after [`KeyFrames`].
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[reflect(Component, Default, Clone, PartialEq)]
#[component(summary_tick)]
pub struct Morph {
    /// Every vertex's offset from the mesh at rest, a set a target.
    #[reflect(ignore)]
    #[serde(with = "crate::pod::shared")]
    pub targets: Arc<VertexSets>,
    /// One a target: 0 leaves it out, 1 goes all the way; up to 1e6 either way.
    pub weights: Vec<f64>,
}

impl Morph {
    /// The step for a mesh of so many vertices.
    ///
    /// # Errors
    /// What keeps it from deforming that mesh.
    pub(in crate::world) fn step(&self, vertices: usize) -> Result<DeformStep, String> {
        check_sets("morph targets", &self.targets, vertices)?;
        if self.weights.len() != self.targets.count() as usize {
            return Err(format!(
                "{} weights for {} morph targets",
                self.weights.len(),
                self.targets.count()
            ));
        }
        if !self.weights.iter().all(|weight| weight.abs() <= 1e6) {
            return Err("weights of morph targets must be within 1e6".into());
        }
        Ok(DeformStep::Morph {
            targets: Arc::clone(&self.targets),
            weights: self.weights.clone(),
        })
    }
}

fn check_sets(what: &str, sets: &VertexSets, vertices: usize) -> Result<(), String> {
    if sets.vertices == vertices {
        Ok(())
    } else {
        Err(format!(
            "{what} are of {} vertices, the mesh of {vertices}",
            sets.vertices
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn frames(repeat: Loop, speed: f64) -> KeyFrames {
        let values = (0..3).map(|i| Vec3::splat(i as f32)).collect();
        KeyFrames {
            keys: Arc::new(VertexSets {
                vertices: 1,
                values,
            }),
            times: vec![1.0, 2.0, 4.0],
            start: 1.0,
            speed,
            repeat,
        }
    }

    fn at(frames: &KeyFrames, secs: f64) -> (u32, u32, f64) {
        match frames.step(secs, 1) {
            Ok(DeformStep::Keys {
                from, to, share, ..
            }) => (from, to, share),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn each_pose_comes_at_its_time() {
        let once = frames(Loop::Once, 1.0);
        assert_eq!(at(&once, 0.0), (0, 1, 0.0));
        assert_eq!(at(&once, 0.25), (0, 1, 0.25));
        assert_eq!(at(&once, 2.0), (1, 2, 0.5));
        assert_eq!(at(&once, 99.0), (1, 2, 1.0));
        assert_eq!(at(&frames(Loop::Repeat, 2.0), 3.5), (1, 2, 0.0));
        assert_eq!(at(&frames(Loop::PingPong, 1.0), 5.5), (0, 1, 0.5));
        assert_eq!(at(&frames(Loop::Once, 0.0), 99.0), (0, 1, 0.0));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        assert!(frames(Loop::Once, 1.0).step(0.0, 2).is_err());
        assert!(frames(Loop::Once, f64::NAN).step(0.0, 1).is_err());
        let mut short = frames(Loop::Once, 1.0);
        short.times.pop();
        assert!(short.step(0.0, 1).is_err());
        assert!(KeyFrames::default().step(0.0, 0).is_err());
    }
}
