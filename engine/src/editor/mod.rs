//! The editor: hierarchy, inspector, profiler, help and notices, over the picture.
//!
//! A consumer of everything below; nothing below knows it. Panels, gizmo, menus and keys never write the world: they
//! queue [`Command`]s, one system runs them, and the [`History`] keeps each as a step that can be undone.

mod document;
mod edits;
mod fields;
mod gizmo;
mod hierarchy;
mod history;
mod inspector;
mod levels;
mod marks;
mod menu;
mod naming;
mod outline;
mod overlay;
mod picking;
mod playing;
mod pointer;
mod profiler;
mod reload;
mod selection;
mod sight;
mod spawnable;
pub mod theme;
mod tools;

pub use document::{Document, copy_at_end};
pub use edits::{EditQueue, Wish};
pub use history::{Command, FieldSet, History, Step, Value};
pub use overlay::Notices;
pub use selection::{Pick, Selection};

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::IntoScheduleConfigs;

use crate::app::Engine;
use crate::input::HandSet;
use crate::present::{DrawOverPicture, Ui};
use crate::schedule::FrameSet;
use crate::trace::Level;

/// What is open, and what is selected.
#[derive(Resource, Debug, Default)]
pub struct EditorState {
    /// Hierarchy and inspector are shown.
    pub panels: bool,
    /// The help is shown.
    pub help: bool,
    /// The profiler is shown.
    pub profiler: bool,
    /// What the inspector shows, and what commands are about.
    pub selection: Selection,
    /// What can be added is listed in the middle.
    pub adding: bool,
    /// The level of the trees that is shown over the picture.
    pub level: Option<Level>,
}

impl EditorState {
    /// Shows a level, or none if it is shown already.
    pub fn toggle_level(&mut self, level: Option<Level>) {
        self.level = level.filter(|_| self.level != level);
    }
}

/// The systems that draw panels and apply edits.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct DrawPanels;

/// Adds the panels and the edits (set [`FrameSet::Edit`]) and what shows the frame's trees (set
/// [`FrameSet::Present`]); needs [`crate::present::plugin`].
pub fn plugin(engine: &mut Engine) {
    init_resources(&mut engine.world);
    engine.add_systems(
        FrameSet::Edit,
        (
            hierarchy::watch,
            tools::obey_tools,
            pointer::use_pointer,
            draw_panels,
            edits::apply_edits,
            document::copy_unsaved,
            reload::reload_changed,
            playing::note_play,
        )
            .chain()
            .in_set(DrawPanels)
            .after(HandSet),
    );
    engine.add_systems(
        FrameSet::Present,
        (levels::draw_levels, marks::draw_marks, profiler::draw_rays)
            .chain()
            .in_set(DrawOverPicture),
    );
}

fn init_resources(world: &mut World) {
    world.init_resource::<EditorState>();
    world.init_resource::<EditQueue>();
    world.init_resource::<History>();
    world.init_resource::<Document>();
    world.init_resource::<Notices>();
    world.init_resource::<hierarchy::Tree>();
    world.init_resource::<inspector::Clipboard>();
    world.init_resource::<playing::BeforePlay>();
    world.init_resource::<reload::Watched>();
    world.init_resource::<profiler::ProfilerView>();
    world.init_resource::<profiler::PixelView>();
    world.init_resource::<gizmo::Gizmo>();
    world.init_resource::<pointer::Press>();
    world.init_resource::<outline::Boxes>();
}

/// Another scene is there: nothing of the old one is selected, and nothing that was done to it can be undone.
pub fn scene_replaced(world: &mut World) {
    history::clear(world);
    world.resource_mut::<EditorState>().selection.clear();
}

/// The panels of the editor, around the picture.
fn show_panels(ui: &mut egui::Ui, world: &mut World) {
    menu::show(ui, world);
    hierarchy::show(ui, world);
    inspector::show(ui, world);
}

/// Draws what is open. Exclusive, because an inspector may read any component.
fn draw_panels(world: &mut World) {
    let context = world.resource::<Ui>().context().clone();
    let (panels, profiler, help) = {
        let state = world.resource::<EditorState>();
        (state.panels, state.profiler, state.help)
    };
    world.resource_scope(|world, mut state: Mut<EditorState>| state.selection.drop_gone(world));
    context.root_ui(|ui| {
        if panels {
            show_panels(ui, world);
        }
        profiler::mind_ledger(world, profiler);
        if profiler {
            profiler::show(ui, world);
        }
        // A drag in a panel is one step; once nobody drags or types, the next edit is another.
        let context = ui.ctx();
        let drags = world.resource::<gizmo::Gizmo>().drag.is_some();
        if !drags && !context.egui_is_using_pointer() && !context.egui_wants_keyboard_input() {
            world.resource_mut::<EditQueue>().0.push(Wish::CloseGroup);
        }
        let picture = ui.available_rect_before_wrap();
        world.resource_mut::<Ui>().leave_to_picture(picture);
        overlay::show(ui, world, help);
    });
}

#[cfg(test)]
mod tests;
