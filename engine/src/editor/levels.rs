//! A level of the trees over the picture, and a line that says what is shown.
//!
//! Drawn once the frame is traced, so that volumes lie where the picture has what is in them.

use bevy_ecs::prelude::*;
use egui::{Align2, Color32, Id, LayerId, Order, Rect, Stroke};
use glam::Vec2;

use super::{EditorState, theme};
use crate::frame::FrameScene;
use crate::present::{MOST_VOLUMES, Ui, wireframe};
use crate::trace::ActiveTracer;

/// Draws the level that is to be shown: of all trees, or of what is selected in the panels if it has one.
pub fn draw_levels(
    state: Res<EditorState>,
    tracer: Res<ActiveTracer>,
    scene: Res<FrameScene>,
    ui: Res<Ui>,
) {
    let (Some(level), Some(tracer)) = (state.level, &tracer.0) else {
        return;
    };
    let selected = state.selection.lead().filter(|_| state.panels);
    let row = selected.and_then(|entity| {
        let rows = scene.instances.iter();
        let row = rows
            .map(|row| row.tag)
            .position(|tag| tag == entity.to_bits());
        row.map(|row| row as u32)
    });
    let Some(shown) = tracer.hierarchy(level, row, MOST_VOLUMES) else {
        let words = format!("{level}: the {} tracer has no such trees", tracer.backend());
        return say(&ui, words);
    };
    let context = ui.context();
    let window = context.content_rect();
    let layer = LayerId::new(Order::Background, Id::unique("levels"));
    let painter = context
        .layer_painter(layer)
        .with_clip_rect(ui.picture_rect());
    for stroke in wireframe(&shown.volumes, level, &scene.view) {
        let [r, g, b] = stroke.color;
        let color = Color32::from_rgb(r, g, b).gamma_multiply(stroke.opacity);
        let width = 2.0 * stroke.half_width * window.height();
        let ends = stroke.ends.map(|end| place(window, end));
        painter.line_segment(ends, Stroke::new(width.max(0.6), color));
    }
    say(&ui, shown.words(level));
}

/// Where in the window a place in the picture is.
pub(super) fn place(window: Rect, at: Vec2) -> egui::Pos2 {
    window.center() + egui::vec2(at.x * window.width(), -at.y * window.height())
}

fn say(ui: &Ui, words: String) {
    let picture = ui.picture_rect();
    egui::Area::new(Id::unique("levels in words"))
        .pivot(Align2::RIGHT_BOTTOM)
        .fixed_pos(picture.right_bottom() - egui::vec2(12.0, 12.0))
        .interactable(false)
        .show(ui.context(), |ui| {
            // On one line: an area that has just come does not know yet how much room there is.
            theme::card().show(ui, |ui| ui.add(egui::Label::new(words).extend()));
        });
}
