//! The profiler: the last frames as bars, one of them as a flame, and what it cost in tables.
//!
//! It draws what [`Frames`] holds and keeps nothing of its own but what is looked at. A click on a bar, or on one of the
//! slowest frames, looks at that frame and stops the recording, so that it stays; `Record` goes on.

mod colors;
mod flame;
mod history;
mod pixel;
mod save;
mod summary;
mod tables;
#[cfg(test)]
mod tests;
mod things;
mod uploads;

use std::sync::Arc;

use bevy_ecs::prelude::*;
use egui::{Align, DragValue, Layout, RichText, TextStyle, Ui};

pub use self::pixel::{PixelView, draw_rays};

use self::summary::Summary;
use super::overlay::Notices;
use super::selection::Pick;
use super::{EditorState, theme};
use crate::profile::{Frame, Frames, Ledger, Profile, Stop};
use crate::trace::ActiveTracer;

/// What of the frames is looked at.
#[derive(Resource, Debug, Default)]
pub struct ProfilerView {
    /// The frame's number; none: the newest that is complete.
    pub selected: Option<u64>,
    /// From when to when of it, microseconds; none: all of it.
    shown: Option<[f64; 2]>,
    /// A name that was clicked: it stands out everywhere.
    marked: Option<Arc<str>>,
    tab: Tab,
    summary: Summary,
}

/// What the tables show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Tab {
    /// What everything cost, the dearest first.
    #[default]
    Costs,
    /// The slowest frames and what made them slow.
    Worst,
    /// Rays, bytes, trees, and what was left out.
    Counters,
    /// What each entity costs of the picture.
    Things,
    /// What was brought to the tracer, and why.
    Uploads,
    /// The ray tree of a pixel.
    Pixel,
}

impl ProfilerView {
    /// Looks at a frame, and keeps it.
    fn select(&mut self, frames: &mut Frames, id: u64) {
        self.selected = Some(id);
        self.shown = None;
        if frames.stopped().is_none() {
            frames.set_stopped(true);
        }
    }

    /// Follows the newest frames again.
    fn resume(&mut self, frames: &mut Frames) {
        (self.selected, self.shown) = (None, None);
        frames.set_stopped(false);
    }
}

/// The panel at the bottom.
pub fn show(ui: &mut Ui, world: &mut World) {
    if !world.contains_resource::<Frames>() || !world.contains_resource::<Profile>() {
        return;
    }
    let mut asked = Asked::default();
    world.resource_scope(|world, mut view: Mut<ProfilerView>| {
        world.resource_scope(|world, mut frames: Mut<Frames>| {
            world.resource_scope(|world, mut pixel: Mut<PixelView>| {
                let views = (&mut *view, &mut *pixel);
                asked = panel(ui, views, &mut frames, world);
            });
        });
    });
    pixel::pick(ui, world);
    if let Some(entity) = asked.entity {
        let mut state = world.resource_mut::<EditorState>();
        state.selection.pick(entity, Pick::Only);
    }
    if asked.count {
        world.resource_scope(|world, mut pixel: Mut<PixelView>| pixel.count_things(world));
    }
    if asked.save {
        let tracer = world.resource::<ActiveTracer>().0.as_ref();
        let device = tracer.map_or_else(String::new, |tracer| tracer.device());
        let said = save::captures(world.resource::<Frames>(), &device);
        world.resource_mut::<Notices>().toast(said);
    }
}

/// Has uploads looked into while their table is shown.
pub fn mind_ledger(world: &mut World, is_open: bool) {
    let wanted = is_open && world.resource::<ProfilerView>().tab == Tab::Uploads;
    if let Some(mut ledger) = world.get_resource_mut::<Ledger>() {
        ledger.wanted = wanted;
    }
}

/// What was clicked that is others' to do.
#[derive(Default)]
struct Asked {
    /// The frames are to be saved.
    save: bool,
    /// To be selected.
    entity: Option<Entity>,
    /// What entities cost is to be counted.
    count: bool,
}

fn panel(
    ui: &mut Ui,
    views: (&mut ProfilerView, &mut PixelView),
    frames: &mut Frames,
    world: &World,
) -> Asked {
    egui::Panel::bottom("profiler")
        .default_size(330.0)
        .min_size(180.0)
        .resizable(true)
        .frame(theme::panel())
        .show(ui, |ui| contents(ui, views, frames, world))
        .inner
}

/// Draws it all.
fn contents(
    ui: &mut Ui,
    (view, pixel): (&mut ProfilerView, &mut PixelView),
    frames: &mut Frames,
    world: &World,
) -> Asked {
    view.summary.refresh(frames, world.resource::<Profile>());
    if let (Some(Stop::Spike(id)), None) = (frames.stopped(), view.selected) {
        view.selected = Some(id);
    }
    let mut asked = Asked {
        save: headline(ui, view, frames),
        ..Asked::default()
    };
    history::show(ui, view, frames);
    ui.add_space(4.0);
    let Some(frame) = looked_at(view, frames) else {
        ui.label(theme::faint("no frame has been recorded yet"));
        return asked;
    };
    let frame = frame.clone();
    let (wide, high) = (ui.available_width(), ui.available_height());
    let tables = (wide * 0.36).clamp(260.0, 560.0).min(wide * 0.5);
    ui.horizontal_top(|ui| {
        let gap = ui.spacing().item_spacing.x;
        let left = egui::vec2(wide - tables - gap, high);
        ui.allocate_ui_with_layout(left, Layout::top_down(Align::Min), |ui| {
            flame::show(ui, view, &frame);
        });
        ui.allocate_ui_with_layout(
            egui::vec2(tables, high),
            Layout::top_down(Align::Min),
            |ui| tables::show(ui, (view, pixel), (frames, &frame), (world, &mut asked)),
        );
    });
    asked
}

/// The frame that is drawn: the one selected, else the newest whose device has told, else the newest.
fn looked_at<'a>(view: &ProfilerView, frames: &'a Frames) -> Option<&'a Frame> {
    let selected = view.selected.and_then(|id| frames.get(id));
    let recent = || frames.iter().rev().take(8).filter(|f| !f.awaits_device);
    let with_passes = || recent().find(|frame| !frame.passes.is_empty());
    selected
        .or_else(with_passes)
        .or_else(|| recent().next())
        .or_else(|| frames.latest())
}

/// Title, figures, and what can be done.
fn headline(ui: &mut Ui, view: &mut ProfilerView, frames: &mut Frames) -> bool {
    let mut save = false;
    let figures = RichText::new(view.summary.words()).monospace();
    let has_room = ui.horizontal(|ui| {
        ui.label(RichText::new("Profiler").heading().color(theme::ACCENT));
        ui.add_space(6.0);
        let is_stopped = frames.stopped().is_some();
        let words = if is_stopped { "Record" } else { "Stop" };
        if ui.button(words).clicked() {
            match is_stopped {
                true => view.resume(frames),
                false => frames.set_stopped(true),
            }
        }
        spike_limit(ui, frames);
        save = ui
            .button("Save")
            .on_hover_text("the frames held, as a trace for Perfetto and as a capture to compare")
            .clicked();
        let font = TextStyle::Monospace.resolve(ui.style());
        let galley = ui
            .painter()
            .layout_no_wrap(view.summary.words(), font, theme::FAINT);
        let has_room = galley.size().x < ui.available_width();
        if has_room {
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                ui.label(figures.clone());
            });
        }
        has_room
    });
    if !has_room.inner {
        ui.label(figures);
    }
    save
}

/// Whether, and from which time on, a frame stops the recording.
fn spike_limit(ui: &mut Ui, frames: &mut Frames) {
    let mut limit = frames.spike_limit();
    let mut is_on = limit.is_some();
    let toggled = ui.checkbox(&mut is_on, "stop above").changed();
    let mut millis = limit.unwrap_or(33.0);
    let value = DragValue::new(&mut millis)
        .range(1.0..=10_000.0)
        .speed(0.5)
        .suffix(" ms");
    let dragged = ui.add_enabled(is_on, value).changed();
    if toggled || dragged {
        limit = is_on.then_some(millis);
        frames.set_spike_limit(limit);
    }
    if let Some(Stop::Spike(id)) = frames.stopped() {
        let words = format!("stopped by frame {id}");
        ui.label(RichText::new(words).color(theme::ALARM));
    }
}
