//! The profiler: what the last frame cost, system by system and pass by pass.

use bevy_ecs::prelude::*;

use super::theme;
use crate::frame::Skip;
use crate::profile::Profile;

/// The panel at the bottom.
pub fn show(ui: &mut egui::Ui, world: &World) {
    let Some(profile) = world.get_resource::<Profile>() else {
        return;
    };
    egui::Panel::bottom("profiler")
        .default_size(210.0)
        .min_size(120.0)
        .resizable(true)
        .frame(theme::panel())
        .show(ui, |ui| {
            headline(ui, profile);
            ui.add_space(4.0);
            egui::ScrollArea::vertical()
                .auto_shrink([false, false])
                .show(ui, |ui| {
                    ui.columns(3, |columns| {
                        let spans = profile.spans.iter();
                        table(
                            &mut columns[0],
                            "Systems",
                            spans.map(|span| (&*span.name, span.micros / 1e3)),
                            profile.frame_millis,
                        );
                        let passes = profile.passes.iter();
                        table(
                            &mut columns[1],
                            "Passes",
                            passes.map(|pass| (pass.name, pass.millis)),
                            profile.frame_millis,
                        );
                        counters(&mut columns[2], profile);
                    });
                });
        });
}

fn headline(ui: &mut egui::Ui, profile: &Profile) {
    ui.horizontal(|ui| {
        ui.label(
            egui::RichText::new("Profiler")
                .heading()
                .color(theme::ACCENT),
        );
        ui.add_space(8.0);
        let words = format!(
            "{:.0} FPS    work {:.2} ms    median {:.2} ms    95 % {:.2} ms    1 % low {:.0} FPS",
            profile.history.mean_fps(),
            profile.frame_millis,
            profile.history.percentile(0.5),
            profile.history.percentile(0.95),
            profile.history.one_percent_low_fps(),
        );
        ui.label(egui::RichText::new(words).monospace());
    });
}

/// Names with their milliseconds, and a bar for their share of the frame.
fn table<'a>(
    ui: &mut egui::Ui,
    title: &str,
    rows: impl Iterator<Item = (&'a str, f64)>,
    frame_millis: f64,
) {
    ui.label(theme::faint(title));
    let mut rows: Vec<(&str, f64)> = rows.collect();
    if rows.is_empty() {
        ui.label(theme::faint("nothing was measured"));
    }
    rows.sort_by(|a, b| b.1.total_cmp(&a.1));
    for (name, millis) in rows {
        bar(ui, name, millis, millis / frame_millis.max(1e-9));
    }
}

fn bar(ui: &mut egui::Ui, name: &str, millis: f64, share: f64) {
    let size = egui::vec2(ui.available_width(), 18.0);
    let (rect, _) = ui.allocate_exact_size(size, egui::Sense::hover());
    let painter = ui.painter_at(rect);
    let mut filled = rect;
    filled.set_width(rect.width() * share.clamp(0.0, 1.0) as f32);
    painter.rect_filled(filled, 3.0, ui.visuals().selection.bg_fill);
    let font = egui::TextStyle::Monospace.resolve(ui.style());
    let color = ui.visuals().text_color();
    let inset = egui::vec2(4.0, 0.0);
    painter.text(
        rect.right_center() - inset,
        egui::Align2::RIGHT_CENTER,
        format!("{millis:.3} ms"),
        font.clone(),
        color,
    );
    let room = egui::Rect::from_min_max(rect.min, rect.max - egui::vec2(84.0, 0.0));
    painter.with_clip_rect(room).text(
        rect.left_center() + inset,
        egui::Align2::LEFT_CENTER,
        name,
        font,
        color,
    );
}

fn counters(ui: &mut egui::Ui, profile: &Profile) {
    ui.label(theme::faint("Rays and bytes"));
    let counters = &profile.counters;
    let rows = [
        ("camera rays", counters.primary_rays),
        ("mirrored rays", counters.reflected_rays),
        ("refracted rays", counters.refracted_rays),
        ("shadow rays", counters.shadow_rays),
        ("pixels on edges", counters.edge_pixels),
        ("bytes uploaded", counters.bytes_uploaded),
        ("instance tree's nodes written", counters.tree_nodes),
        ("trees updated", counters.trees_updated),
        ("media that did not fit", counters.media_overflows),
        ("straight rays ended", counters.straight_overflows),
    ];
    let saved = Skip::ALL.map(|skip| (skip.saved(), counters.saved(skip)));
    egui::Grid::new("counters")
        .num_columns(2)
        .spacing([16.0, 3.0])
        .show(ui, |ui| {
            for (name, count) in rows.into_iter().chain(saved) {
                ui.label(theme::faint(name));
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    ui.label(egui::RichText::new(grouped(count)).monospace());
                });
                ui.end_row();
            }
        });
}

/// 1234567 as "1 234 567".
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::grouped;

    #[test]
    fn numbers_are_grouped_by_thousands() {
        assert_eq!(
            [0, 999, 1000, 1_234_567].map(grouped),
            ["0", "999", "1 000", "1 234 567"]
        );
    }
}
