//! The editor: hierarchy, inspector, profiler, help and notices, over the picture.
//!
//! A consumer of everything below; nothing below knows it. Panels never write the world: they queue
//! [`Edit`]s, and one system applies them, so that an undo can stand between.

mod edits;
mod fields;
mod hierarchy;
mod inspector;
mod levels;
mod overlay;
mod profiler;
pub mod theme;

pub use edits::{Edit, EditQueue};
pub use overlay::Notices;

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
    /// What the inspector shows.
    pub selected: Option<Entity>,
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
    engine.world.init_resource::<EditorState>();
    engine.world.init_resource::<EditQueue>();
    engine.world.init_resource::<Notices>();
    engine.world.init_resource::<hierarchy::Tree>();
    engine.add_systems(
        FrameSet::Edit,
        (draw_panels, edits::apply_edits)
            .chain()
            .in_set(DrawPanels)
            .after(HandSet),
    );
    engine.add_systems(
        FrameSet::Present,
        levels::draw_levels.in_set(DrawOverPicture),
    );
}

/// Draws what is open. Exclusive, because an inspector may read any component.
fn draw_panels(world: &mut World) {
    let context = world.resource::<Ui>().context().clone();
    let (panels, profiler, help) = {
        let state = world.resource::<EditorState>();
        (state.panels, state.profiler, state.help)
    };
    context.root_ui(|ui| {
        if panels {
            hierarchy::show(ui, world);
            inspector::show(ui, world);
        }
        if profiler {
            profiler::show(ui, world);
        }
        let picture = ui.available_rect_before_wrap();
        world.resource_mut::<Ui>().leave_to_picture(picture);
        overlay::show(ui, world, help);
    });
}
