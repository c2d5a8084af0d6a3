//! The editor's keys: each asks for what a menu would.

use bevy_ecs::prelude::*;

use super::gizmo::{Gizmo, Mode};
use super::history::Command;
use super::{EditQueue, EditorState, Wish};
use crate::input::{Action, FlyCamera, Input, KeyMap};
use crate::world::{GlobalTransform, Sphere, Visibility};

/// Turns keys into wishes, while the panels are open.
pub(super) fn obey_tools(
    (input, keys): (Res<Input>, Res<KeyMap>),
    mut state: ResMut<EditorState>,
    mut queue: ResMut<EditQueue>,
    mut gizmo: ResMut<Gizmo>,
    mut fly: ResMut<FlyCamera>,
    places: Query<(&GlobalTransform, Option<&Sphere>)>,
    switches: Query<&Visibility>,
) {
    if !state.panels {
        return;
    }
    let pressed = |action| keys.is_pressed(action, &input);
    let plain = [
        (Action::Undo, Wish::Undo(1)),
        (Action::Redo, Wish::Redo(1)),
        (Action::Save, Wish::Save),
        (Action::SaveAs, Wish::AskWhere),
    ];
    for (action, wish) in plain {
        if pressed(action) {
            queue.0.push(wish);
        }
    }
    if pressed(Action::NoLevels) && state.level.is_none() {
        state.selection.clear();
    }
    let modes = [
        (Action::Move, Mode::Move),
        (Action::Rotate, Mode::Rotate),
        (Action::Scale, Mode::Scale),
    ];
    for (action, mode) in modes {
        if pressed(action) {
            gizmo.mode = mode;
        }
    }
    gizmo.own_axes ^= pressed(Action::Axes);
    state.adding ^= pressed(Action::Add);
    let selected = state.selection.all().to_vec();
    if selected.is_empty() {
        return;
    }
    if pressed(Action::Focus)
        && let Some(lead) = state.selection.lead()
        && let Ok((pose, ball)) = places.get(lead)
    {
        // A mesh says nothing of its size here; a few units are seen well.
        let size = pose.0.matrix3.determinant().abs().cbrt();
        let radius = ball.map_or(1.0, |ball| ball.radius) * size;
        fly.look_at(pose.0.translation, radius);
    }
    if pressed(Action::Duplicate) {
        queue.push(Command::Duplicate(selected.clone()));
    }
    if pressed(Action::Delete) {
        queue.push(Command::Delete(selected.clone()));
    }
    if pressed(Action::Hide) {
        queue.push(hide_or_show(&selected, |entity| switches.get(entity).ok()));
    }
}

/// Hides what is shown; where nothing of it is, shows it.
pub(super) fn hide_or_show<'a>(
    entities: &[Entity],
    switch: impl Fn(Entity) -> Option<&'a Visibility>,
) -> Command {
    let has_switch = |&entity: &Entity| switch(entity).is_some();
    let entities: Vec<Entity> = entities.iter().copied().filter(has_switch).collect();
    let any_shown = entities.iter().any(|&e| switch(e).is_some_and(|v| v.shown));
    Command::show(&entities, !any_shown)
}
