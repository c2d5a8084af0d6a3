//! Playing clips: what is played as components, and the system that poses what they move.
//!
//! A pose is a pure function of [`Time::secs`] and the player: no state is carried from frame to frame, so frame N is
//! the same however it was reached. Nothing is written that is equal. A player whose layers stand still, and any in a frame
//! at the same time as the last, does nothing unless it changed, so that what is paused can be edited. What no clip of the
//! model keys is never written.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_reflect::prelude::*;
use glam::{DQuat, DVec3};

use super::set::Moment;
use super::{Channel, ClipSet};
use crate::time::Time;
use crate::world::{Camera, Loop, Morph, Projection, Transform, Visibility, any_changed};

/// Plays clips on the entities that a model became.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[component(summary_tick)]
pub struct ClipPlayer {
    /// All that can be played; shared by all who show the same model.
    #[reflect(ignore)]
    pub clips: Arc<ClipSet>,
    /// Entities that the clips move.
    #[entities]
    pub targets: Vec<Entity>,
    /// What is played at once; none: the rest pose.
    pub layers: Vec<ClipLayer>,
}

/// A clip that is being played.
///
/// Poses are means by weight; where the weights of those that key a value sum to less than 1, the rest pose has what
/// is missing.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct ClipLayer {
    /// Row of [`ClipSet::clips`].
    pub clip: usize,
    /// Seconds of the clip that have passed at scene time 0.
    pub start: f64,
    /// Seconds of the clip a second of scene time; negative plays backwards.
    pub speed: f64,
    /// Its share of the pose; 0 or less: none.
    pub weight: f64,
    /// What follows its end.
    pub repeat: Loop,
    /// Holds the pose at `start`.
    pub paused: bool,
}

impl Default for ClipLayer {
    fn default() -> Self {
        Self {
            clip: 0,
            start: 0.0,
            speed: 1.0,
            weight: 1.0,
            repeat: Loop::Repeat,
            paused: false,
        }
    }
}

impl ClipPlayer {
    /// Seconds of the scene until the slowest layer has played its clip through; 0: nothing plays.
    pub fn period(&self) -> f64 {
        let layers = self.layers.iter().filter(|layer| !layer.paused);
        let period = |layer: &ClipLayer| {
            let clip = self.clips.clips().get(layer.clip)?;
            let secs = (clip.end - clip.start) / layer.speed.abs();
            secs.is_finite().then_some(secs)
        };
        layers.filter_map(period).fold(0.0, f64::max)
    }

    /// Lets layers that were paused or let go on since `before` keep the pose that they had at a time of the scene.
    pub fn keep_poses(&mut self, before: &[ClipLayer], secs: f64) {
        for (layer, before) in self.layers.iter_mut().zip(before) {
            let passed = before.speed * secs;
            match (before.paused, layer.paused) {
                (false, true) => layer.start += passed,
                (true, false) => layer.start -= passed,
                _ => {}
            }
        }
    }

    /// Whether the pose is the same at any time.
    fn stands(&self) -> bool {
        let stands = |layer: &ClipLayer| layer.paused || layer.speed == 0.0 || layer.weight <= 0.0;
        self.layers.iter().all(stands)
    }

    /// Where the layers stand at a time of the scene; those without weight, or with numbers that are not finite, are
    /// left out.
    fn moments(&self, secs: f64) -> Vec<Moment> {
        let moment = |layer: &ClipLayer| {
            let clip = self.clips.clips().get(layer.clip)?;
            let passed = if layer.paused {
                layer.start
            } else {
                layer.start + layer.speed * secs
            };
            let secs = layer.repeat.wrap(clip.start + passed, clip.start, clip.end);
            let counts = layer.weight > 0.0 && layer.weight.is_finite() && secs.is_finite();
            counts.then_some(Moment {
                clip: layer.clip,
                secs,
                weight: layer.weight,
            })
        };
        self.layers.iter().filter_map(moment).collect()
    }
}

/// What clips write.
#[derive(SystemParam)]
pub struct Targets<'w, 's> {
    transforms: Query<'w, 's, &'static mut Transform>,
    morphs: Query<'w, 's, &'static mut Morph>,
    cameras: Query<'w, 's, &'static mut Camera>,
    visibilities: Query<'w, 's, &'static mut Visibility>,
}

/// Poses the targets of all players; runs after the timeline, which may write the players.
pub fn play_clips(
    time: Res<Time>,
    mut last: Local<Option<u64>>,
    players: Query<Ref<ClipPlayer>>,
    mut targets: Targets,
) {
    let stands = last.replace(time.secs.to_bits()) == Some(time.secs.to_bits());
    if stands && !any_changed(&players) {
        return;
    }
    let mut numbers = Vec::new();
    for player in &players {
        if (stands || player.stands()) && !player.is_changed() {
            continue;
        }
        let moments = player.moments(time.secs);
        for keyed in player.clips.keyed() {
            let Some(&target) = player.targets.get(keyed.target) else {
                continue;
            };
            player.clips.mix(keyed, &moments, &mut numbers);
            targets.write(target, keyed.channel, &numbers);
        }
    }
}

impl Targets<'_, '_> {
    /// Writes a value; an entity that lost the component, or is gone, is left alone.
    fn write(&mut self, target: Entity, channel: Channel, numbers: &[f64]) {
        match channel {
            Channel::Translation | Channel::Rotation | Channel::Scale => {
                if let Ok(mut transform) = self.transforms.get_mut(target) {
                    let mut next = *transform;
                    match channel {
                        Channel::Translation => next.translation = DVec3::from_slice(numbers),
                        Channel::Rotation => next.rotation = DQuat::from_slice(numbers),
                        _ => next.scale = DVec3::from_slice(numbers),
                    }
                    transform.set_if_neq(next);
                }
            }
            Channel::Weights => {
                if let Ok(mut morph) = self.morphs.get_mut(target) {
                    let count = morph.weights.len().min(numbers.len());
                    if morph.weights[..count] != numbers[..count] {
                        morph.weights[..count].copy_from_slice(&numbers[..count]);
                    }
                }
            }
            Channel::VerticalFov => {
                if let Ok(mut camera) = self.cameras.get_mut(target) {
                    let mut next = *camera;
                    if let Projection::Perspective { vertical_fov } = &mut next.projection {
                        *vertical_fov = numbers[0].clamp(NARROWEST, WIDEST);
                    }
                    camera.set_if_neq(next);
                }
            }
            Channel::Shown => {
                if let Ok(mut visibility) = self.visibilities.get_mut(target) {
                    let shown = numbers[0] >= 0.5;
                    visibility.set_if_neq(Visibility { shown });
                }
            }
        }
    }
}

/// Angles that cubic keys may not overshoot, radians.
const NARROWEST: f64 = 1e-4;
const WIDEST: f64 = std::f64::consts::PI - 1e-4;
