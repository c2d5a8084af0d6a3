//! What each entity costs of the picture, the dearest first: counted by the f64 reference over one of so many pixels, when asked.

use bevy_ecs::prelude::*;
use egui::{Align, Layout, RichText, ScrollArea, Ui};

use super::tables::grouped;
use crate::editor::naming::label;
use crate::editor::theme;
use crate::frame::{FrameScene, TraceSettings};
use crate::profile::{EntityCost, EntityCosts};
use crate::trace::Tracer;
use crate::trace::reference::ReferenceTracer;

/// Pixels that are looked at, about: enough to tell what is dear, and soon done.
const PIXELS: u32 = 6000;
const ROW: f32 = 18.0;

/// The table; the answer is an entity that was clicked in it, and whether to count anew.
pub fn show(ui: &mut Ui, world: &World) -> (Option<Entity>, bool) {
    let (mut clicked, mut counts) = (None, false);
    ui.horizontal(|ui| {
        let button = ui.button("Count");
        counts = button
            .on_hover_text(
                "the f64 reference traces a few thousand pixels and counts: it takes a moment",
            )
            .clicked();
        ui.label(theme::faint(
            "share of the work; rays that met it, and that it sent on",
        ));
    });
    let costs = world.resource::<EntityCosts>();
    let mut rows: Vec<(Entity, EntityCost)> = costs.0.iter().map(|(&e, &c)| (e, c)).collect();
    rows.sort_by(|a, b| b.1.share.total_cmp(&a.1.share).then(a.0.cmp(&b.0)));
    ScrollArea::vertical()
        .id_salt("things")
        .auto_shrink([false, false])
        .show_rows(ui, ROW, rows.len(), |ui, visible| {
            for (entity, cost) in &rows[visible] {
                ui.horizontal(|ui| {
                    ui.set_min_height(ROW);
                    let share = format!("{:5.1} %", 100.0 * cost.share);
                    ui.label(RichText::new(share).monospace().color(theme::ACCENT));
                    if ui.link(label(world, *entity)).clicked() {
                        clicked = Some(*entity);
                    }
                    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                        let words = format!("{} / {}", grouped(cost.met), grouped(cost.sent));
                        ui.label(theme::faint(words).monospace());
                    });
                });
            }
        });
    (clicked, counts)
}

/// Counts the frame as it is now.
pub fn count(tracer: &mut ReferenceTracer, world: &mut World) {
    let scene = world.resource::<FrameScene>();
    let settings = world.resource::<TraceSettings>();
    let brought = tracer
        .refit(scene)
        .and_then(|()| tracer.upload(scene, settings));
    if brought.is_err() {
        return;
    }
    let pixels = settings.size.element_product();
    let every = (f64::from(pixels) / f64::from(PIXELS)).sqrt().ceil() as u32;
    let survey = tracer.survey(every);
    let tests = survey.tests().max(1) as f64;
    let things = scene.instances.iter().zip(&survey.things);
    let costs = things.filter_map(|(row, thing)| {
        let entity = Entity::try_from_bits(row.tag).filter(|_| thing.met > 0)?;
        let cost = EntityCost {
            met: thing.met,
            sent: thing.sent,
            share: thing.tests as f64 / tests,
        };
        Some((entity, cost))
    });
    world.insert_resource(EntityCosts(costs.collect()));
}
