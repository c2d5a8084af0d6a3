//! Motion without scripts, for any number of things: [`Orbit`], [`Spin`], [`Sway`], [`PathMotion`].
//!
//! A pose is a pure function of [`Time::secs`]: nothing adds up from frame to frame, so a million frames cause no
//! drift, and after whole periods it is the same bit for bit. All start from the [`Rest`] pose and compose: the
//! offsets of orbit, sway and path add up to the translation, a path's direction turns the rest, and a spin
//! turns it about its own axis. Nothing is written that is equal, and a frame at the same time as the last looks
//! only at whether a component changed.
//!
//! Of the three classes of Wald, Benthin and Slusallek (2003), what stands still needs nothing, hierarchical motion
//! is this module with parents and children, and unstructured motion is a deformation
//! ([`super::Deformation`]). No entity says which it is: change ticks do.

mod orbit;
mod path;
mod spin;
mod sway;

pub use orbit::Orbit;
pub use path::PathMotion;
pub use spin::Spin;
pub use sway::Sway;

use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_ecs::world::DeferredWorld;
use bevy_reflect::prelude::*;

use super::{Transform, any_changed, write_rows};
use crate::time::Time;

/// The pose that an entity's motion starts from: its [`Transform`] when the first motion component came. Write
/// this one to put a moving thing elsewhere; it goes with the last motion component.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[component(summary_tick, on_add = capture)]
pub struct Rest(pub Transform);

fn capture(mut world: DeferredWorld, context: HookContext) {
    let pose = world.get::<Transform>(context.entity).copied();
    if let (Some(pose), Some(mut rest)) = (pose, world.get_mut::<Rest>(context.entity)) {
        rest.0 = pose;
    }
}

/// When a motion component goes: without another, the entity has no rest pose any more.
fn release(mut world: DeferredWorld, context: HookContext) {
    world.commands().queue(move |world: &mut World| {
        let Ok(mut entity) = world.get_entity_mut(context.entity) else {
            return;
        };
        let moves = entity.contains::<Orbit>()
            || entity.contains::<Spin>()
            || entity.contains::<Sway>()
            || entity.contains::<PathMotion>();
        if !moves {
            entity.remove::<Rest>();
        }
    });
}

type Moving = Or<(With<Orbit>, With<Spin>, With<Sway>, With<PathMotion>)>;

type Parts<'a> = (
    &'a Rest,
    &'a mut Transform,
    Option<&'a Orbit>,
    Option<&'a Spin>,
    Option<&'a Sway>,
    Option<&'a PathMotion>,
);

/// What tells that motion changed while time stands still.
#[derive(SystemParam)]
pub struct Watch<'w, 's> {
    rests: Query<'w, 's, Ref<'static, Rest>>,
    orbits: Query<'w, 's, Ref<'static, Orbit>>,
    spins: Query<'w, 's, Ref<'static, Spin>>,
    sways: Query<'w, 's, Ref<'static, Sway>>,
    paths: Query<'w, 's, Ref<'static, PathMotion>>,
}

impl Watch<'_, '_> {
    fn any_changed(&self) -> bool {
        any_changed(&self.rests)
            || any_changed(&self.orbits)
            || any_changed(&self.spins)
            || any_changed(&self.sways)
            || any_changed(&self.paths)
    }
}

/// Poses all that moves; runs before the timeline, whose cameras look at where things are now.
pub fn move_things(
    time: Res<Time>,
    mut last: Local<Option<u64>>,
    watch: Watch,
    mut things: Query<Parts, Moving>,
) {
    let stands = last.replace(time.secs.to_bits()) == Some(time.secs.to_bits());
    if stands && !watch.any_changed() {
        return;
    }
    let Ok(tables) = things.contiguous_iter_mut() else {
        unreachable!("motion components are stored in tables");
    };
    for (rests, transforms, orbits, spins, sways, paths) in tables {
        let pose = |row: usize| {
            Motions {
                orbit: orbits.map(|orbits| &orbits[row]),
                spin: spins.map(|spins| &spins[row]),
                sway: sways.map(|sways| &sways[row]),
                path: paths.map(|paths| &paths[row]),
            }
            .pose(&rests[row].0, time.secs)
        };
        write_rows(transforms, |row| Some(pose(row)));
    }
}

/// The motions of one entity.
struct Motions<'a> {
    orbit: Option<&'a Orbit>,
    spin: Option<&'a Spin>,
    sway: Option<&'a Sway>,
    path: Option<&'a PathMotion>,
}

impl Motions<'_> {
    fn pose(&self, rest: &Transform, secs: f64) -> Transform {
        let mut pose = *rest;
        if let Some(path) = self.path {
            let (offset, turn) = path.at(secs);
            pose.translation += offset;
            if let Some(turn) = turn {
                pose.rotation = turn * pose.rotation;
            }
        }
        if let Some(orbit) = self.orbit {
            pose.translation += orbit.at(secs);
        }
        if let Some(sway) = self.sway {
            pose.translation += sway.at(secs);
        }
        if let Some(spin) = self.spin {
            pose.rotation = (pose.rotation * spin.at(secs)).normalize();
        }
        pose
    }
}

#[cfg(test)]
mod tests;
