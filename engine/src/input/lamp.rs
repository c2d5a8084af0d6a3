//! The light in hand: the 2008 report moved its light with W A S D; so does the `report` key map.

use bevy_ecs::prelude::*;
use glam::DVec3;

use super::{Action, FlyCamera, Input, KeyMap};
use crate::frame::FrameScene;
use crate::time::Time;
use crate::world::{PointLight, SpotLight, Transform};

/// The light as its user holds it, over whatever the timeline says.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct HeldLight {
    hold: Option<Hold>,
}

#[derive(Clone, Copy, Debug)]
struct Hold {
    entity: Entity,
    /// In its parent's space, like the one to give back.
    position: DVec3,
    home: DVec3,
}

/// Lights that stand somewhere.
type Placed = Or<(With<PointLight>, With<SpotLight>)>;

/// Moves the first light with a position, level, as the picture's camera sees right and away.
pub(super) fn move_light(
    input: Res<Input>,
    keys: Res<KeyMap>,
    time: Res<Time>,
    fly: Res<FlyCamera>,
    scene: Res<FrameScene>,
    mut held: ResMut<HeldLight>,
    mut lights: Query<(Entity, &mut Transform), Placed>,
) {
    if keys.is_pressed(Action::Return, &input) {
        if let Some(hold) = held.hold.take()
            && let Ok((_, mut transform)) = lights.get_mut(hold.entity)
        {
            transform.translation = hold.home;
        }
        return;
    }
    let right = keys.axis(Action::LightRight, Action::LightLeft, &input);
    let away = keys.axis(Action::LightAway, Action::LightNear, &input);
    let level = |v: DVec3| v.with_y(0.0).normalize_or_zero();
    let direction = level(scene.view.right) * right + level(scene.view.forward) * away;
    if held.hold.is_none() && direction != DVec3::ZERO {
        held.hold = lights
            .iter()
            .min_by_key(|(entity, _)| *entity)
            .map(|(entity, transform)| Hold {
                entity,
                position: transform.translation,
                home: transform.translation,
            });
    }
    let Some(hold) = &mut held.hold else {
        return;
    };
    hold.position += direction * (fly.speed * time.wall_delta_secs.min(0.1));
    match lights.get_mut(hold.entity) {
        Ok((_, mut transform)) => {
            let position = hold.position;
            let moved = Transform {
                translation: position,
                ..*transform
            };
            transform.set_if_neq(moved);
        }
        Err(_) => held.hold = None, // the light was removed
    }
}
