//! What was brought to the tracer in the last frame, buffer by buffer, and why: the components that changed and the systems
//! that wrote them. Kept only while this table is shown.

use bevy_ecs::prelude::*;
use egui::{Align, Layout, RichText, ScrollArea, Ui};

use super::tables::grouped;
use crate::editor::naming::label;
use crate::editor::theme;
use crate::profile::{Change, Ledger, Profile};

/// The table; the answer is an entity that was clicked in it.
pub fn show(ui: &mut Ui, world: &World) -> Option<Entity> {
    let ledger = world.resource::<Ledger>();
    let counters = &world.resource::<Profile>().counters;
    ui.label(theme::faint(format!(
        "the last frame; {} trees updated, {} kept; looking took {:.2} ms",
        counters.trees_updated,
        counters.trees_kept,
        ledger.micros * 1e-3
    )));
    let mut clicked = None;
    ScrollArea::vertical()
        .id_salt("uploads")
        .auto_shrink([false, false])
        .show(ui, |ui| {
            for upload in &ledger.uploads {
                ui.horizontal(|ui| {
                    ui.label(RichText::new(upload.buffer).color(theme::ACCENT));
                    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                        let bytes = format!("{} bytes", grouped(upload.bytes));
                        ui.label(RichText::new(bytes).monospace());
                    });
                });
                for change in ledger.reasons(upload.buffer) {
                    clicked = clicked.or(reason(ui, change, world));
                }
            }
            if ledger.uploads.is_empty() {
                ui.label(theme::faint("nothing was brought"));
            }
            let mut lost = ledger.idle().peekable();
            if lost.peek().is_some() {
                ui.label(theme::faint("changed, and not brought as such"));
            }
            for change in lost {
                clicked = clicked.or(reason(ui, change, world));
            }
        });
    clicked
}

/// What changed, by whom, and on which entities.
fn reason(ui: &mut Ui, change: &Change, world: &World) -> Option<Entity> {
    let mut clicked = None;
    ui.horizontal_wrapped(|ui| {
        ui.add_space(10.0);
        let by = change
            .system
            .as_deref()
            .unwrap_or("no system, between frames");
        ui.label(format!("{} of {}, by {by}", change.component, change.count));
        for &entity in &change.entities {
            if ui.link(label(world, entity)).clicked() {
                clicked = Some(entity);
            }
        }
        if change.count > change.entities.len() {
            ui.label(theme::faint("…"));
        }
    });
    clicked
}
