//! The left mouse button in the picture: handles first, then a click selects, a drag selects what is in its box.
//!
//! The window's router gives presses over panels to the panels, so what comes here was meant for the picture.

use bevy_ecs::prelude::*;
use egui::{Pos2, Rect};

use super::gizmo::{self, Drag, Frame, Gizmo, Mode};
use super::history::Command;
use super::naming::label;
use super::sight::Sight;
use super::{EditQueue, EditorState, Pick, Wish, picking};
use crate::frame::FrameScene;
use crate::input::{ALT, CTRL, Input, MouseButton, SHIFT};
use crate::present::Ui;

/// Points the mouse may move in a click.
const STILL: f32 = 4.0;

/// A press on the picture that is not a handle's.
#[derive(Resource, Debug, Default)]
pub struct Press {
    began: Option<Pos2>,
    /// The box that is being drawn.
    pub area: Option<Rect>,
}

/// Uses the mouse; a system of [`crate::schedule::FrameSet::Edit`].
pub fn use_pointer(world: &mut World) {
    if !world.resource::<EditorState>().panels {
        *world.resource_mut::<Press>() = Press::default();
        let mut gizmo = world.resource_mut::<Gizmo>();
        (gizmo.hover, gizmo.drag) = (None, None);
        return;
    }
    let sight = sight(world);
    let input = world.resource::<Input>();
    let scale = world.resource::<Ui>().context().pixels_per_point();
    let pointer = input.pointer().map(|p| (p / f64::from(scale)).as_vec2());
    let Some(at) = pointer.map(|p| Pos2::new(p.x, p.y)) else {
        return;
    };
    let pressed = input.is_button_pressed(MouseButton::Left);
    let released = input.is_button_released(MouseButton::Left);
    let held = input.is_button_down(MouseButton::Left);
    if world.resource::<Gizmo>().drag.is_none() {
        hover(world, &sight, at);
    }
    if pressed && !grab(world, &sight, at) {
        world.resource_mut::<Press>().began = Some(at);
    }
    if world.resource::<Gizmo>().drag.is_some() {
        pull(world, &sight, at);
        if released || !held {
            world.resource_mut::<Gizmo>().drag = None;
            world.resource_mut::<EditQueue>().0.push(Wish::CloseGroup);
        }
        return;
    }
    let Some(began) = world.resource::<Press>().began else {
        return;
    };
    let area = Rect::from_two_pos(began, at);
    let is_box = began.distance(at) > STILL || world.resource::<Press>().area.is_some();
    world.resource_mut::<Press>().area = is_box.then_some(area);
    if released || !held {
        *world.resource_mut::<Press>() = Press::default();
        if is_box {
            select_box(world, &sight, area);
        } else {
            select_at(world, &sight, at);
        }
    }
}

/// The picture's view as it was drawn last.
pub fn sight(world: &World) -> Sight {
    Sight {
        view: world.resource::<FrameScene>().view,
        window: world.resource::<Ui>().context().content_rect(),
    }
}

/// The handles of what is selected.
pub fn frame(world: &World, sight: &Sight) -> Option<Frame> {
    let gizmo = world.resource::<Gizmo>();
    let lead = world.resource::<EditorState>().selection.lead()?;
    // Scale has no axes but the thing's own.
    let own_axes = gizmo.own_axes || gizmo.mode == Mode::Scale;
    Frame::of(world, sight, lead, own_axes)
}

fn hover(world: &mut World, sight: &Sight, at: Pos2) {
    let covered = world.resource::<Ui>().covers(at);
    let mode = world.resource::<Gizmo>().mode;
    let found = frame(world, sight).filter(|_| !covered).and_then(|frame| {
        let shown = gizmo::handles(&frame, mode, sight);
        gizmo::under(&shown, sight, at)
    });
    world.resource_mut::<Gizmo>().hover = found;
}

/// Takes hold of the handle under the mouse, if there is one.
fn grab(world: &mut World, sight: &Sight, at: Pos2) -> bool {
    let (handle, mode) = {
        let gizmo = world.resource::<Gizmo>();
        (gizmo.hover, gizmo.mode)
    };
    let (Some(handle), Some(frame)) = (handle, frame(world, sight)) else {
        return false;
    };
    let selected = world.resource::<EditorState>().selection.all().to_vec();
    let drag = Drag::begin(world, (handle, frame, mode), &selected, at);
    let mut gizmo = world.resource_mut::<Gizmo>();
    gizmo.drags += 1;
    gizmo.drag = Some(drag);
    true
}

/// Asks for what the drag wants now.
fn pull(world: &mut World, sight: &Sight, at: Pos2) {
    let snaps = world.resource::<Input>().is_held(CTRL);
    let Some(mut drag) = world.resource_mut::<Gizmo>().drag.take() else {
        return;
    };
    let fields = drag.fields(world, sight, at, snaps);
    let who = match drag.count() {
        1 => label(world, drag.frame.entity),
        count => format!("{count} things"),
    };
    let name = format!("{} {who}", drag.verb());
    let mut gizmo = world.resource_mut::<Gizmo>();
    let group = format!("drag {}", gizmo.drags);
    gizmo.drag = Some(drag);
    if !fields.is_empty() {
        let mut queue = world.resource_mut::<EditQueue>();
        queue.push_dragged(Command::Set(fields), Some(name), group);
    }
}

fn pick(input: &Input) -> Pick {
    match (input.is_held(CTRL), input.is_held(SHIFT)) {
        (true, _) => Pick::Toggle,
        (_, true) => Pick::Also,
        _ => Pick::Only,
    }
}

fn select_at(world: &mut World, sight: &Sight, at: Pos2) {
    let input = world.resource::<Input>();
    let (pick, through) = (pick(input), input.is_held(ALT));
    let mark = if through {
        None
    } else {
        picking::mark_at(world, sight, at)
    };
    let found = mark.or_else(|| picking::entity_at(world, sight, at, through));
    let lead = world.resource::<EditorState>().selection.lead();
    let thing = found.map(|entity| picking::thing_of(world, entity, lead));
    let selection = &mut world.resource_mut::<EditorState>().selection;
    match thing {
        Some(thing) => selection.pick(thing, pick),
        None if pick == Pick::Only => selection.clear(),
        None => {}
    }
}

fn select_box(world: &mut World, sight: &Sight, area: Rect) {
    let pick = pick(world.resource::<Input>());
    let things = picking::things_in(world, sight, area);
    let selection = &mut world.resource_mut::<EditorState>().selection;
    match pick {
        Pick::Only => selection.set(things),
        pick => things
            .into_iter()
            .for_each(|thing| selection.pick(thing, pick)),
    }
}
