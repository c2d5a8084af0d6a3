//! What floats over the picture: help, the first hint, notices and faults.

use std::time::{Duration, Instant};

use bevy_ecs::prelude::*;

use super::{EditorState, theme};
use crate::input::{Action, KeyMap};

/// How long the first line stays.
const HINT_SECS: f32 = 6.0;
/// How long a toast stays.
const TOAST: Duration = Duration::from_secs(6);

/// What the user is to be told.
#[derive(Resource, Debug)]
pub struct Notices {
    /// Sentences that stay until dismissed.
    pub issues: Vec<String>,
    /// Why there is no picture; stays while it is so.
    pub fault: Option<String>,
    toasts: Vec<(Instant, String)>,
    opened: Instant,
}

impl Default for Notices {
    fn default() -> Self {
        Self {
            issues: Vec::new(),
            fault: None,
            toasts: Vec::new(),
            opened: Instant::now(),
        }
    }
}

impl Notices {
    /// Says something for a few seconds.
    pub fn toast(&mut self, text: impl Into<String>) {
        self.toasts.push((Instant::now(), text.into()));
    }
}

/// Draws all of it.
pub fn show(ui: &mut egui::Ui, world: &mut World, help: bool) {
    let picture = ui.available_rect_before_wrap();
    let context = ui.ctx().clone();
    if help {
        show_help(&context, world);
    } else {
        show_hint(&context, picture, world);
    }
    let mut notices = world.resource_mut::<Notices>();
    show_faults(&context, picture, &mut notices);
    notices.toasts.retain(|(since, _)| since.elapsed() < TOAST);
    show_toasts(&context, picture, &notices);
}

/// "F1 help", fading.
fn show_hint(context: &egui::Context, picture: egui::Rect, world: &World) {
    let age = world.resource::<Notices>().opened.elapsed().as_secs_f32();
    if age > HINT_SECS {
        return;
    }
    let keys = world.resource::<KeyMap>();
    let Some(key) = keys.triggers(Action::Help).last() else {
        return;
    };
    egui::Area::new(egui::Id::unique("hint"))
        .fixed_pos(picture.min + egui::vec2(12.0, 12.0))
        .interactable(false)
        .show(context, |ui| {
            ui.set_opacity((HINT_SECS - age).min(1.0));
            theme::card().show(ui, |ui| {
                ui.horizontal(|ui| {
                    ui.label(
                        egui::RichText::new(key.to_string())
                            .color(theme::ACCENT)
                            .strong(),
                    );
                    ui.label("help");
                });
            });
        });
}

/// Every action and its keys, as the key map has them.
fn show_help(context: &egui::Context, world: &mut World) {
    let keys = world.resource::<KeyMap>().clone();
    let mut open = true;
    egui::Window::new("Keys")
        .open(&mut open)
        .collapsible(false)
        .resizable(false)
        .frame(theme::card())
        .anchor(egui::Align2::CENTER_CENTER, egui::Vec2::ZERO)
        .show(context, |ui| {
            ui.horizontal_top(|ui| {
                ui.spacing_mut().item_spacing.x = 28.0;
                ui.vertical(|ui| {
                    help_group(ui, &keys, "Camera");
                });
                ui.vertical(|ui| {
                    help_group(ui, &keys, "Edit");
                });
                ui.vertical(|ui| {
                    for group in ["Light", "Time", "Hierarchies", "Window"] {
                        help_group(ui, &keys, group);
                    }
                });
            });
        });
    if !open {
        world.resource_mut::<EditorState>().help = false;
    }
}

fn help_group(ui: &mut egui::Ui, keys: &KeyMap, group: &str) {
    let bound: Vec<(Action, String)> = Action::ALL
        .into_iter()
        .filter(|action| action.group() == group)
        .filter_map(|action| {
            let triggers: Vec<String> = keys.triggers(action).map(|t| t.to_string()).collect();
            (!triggers.is_empty()).then(|| (action, triggers.join("  or  ")))
        })
        .collect();
    if bound.is_empty() {
        return;
    }
    ui.spacing_mut().item_spacing.x = 14.0;
    theme::heading(ui, group);
    egui::Grid::new(group)
        .num_columns(2)
        .spacing([18.0, 5.0])
        .show(ui, |ui| {
            for (action, triggers) in bound {
                ui.label(egui::RichText::new(triggers).strong());
                ui.label(theme::faint(action.label()));
                ui.end_row();
            }
        });
    ui.add_space(10.0);
}

/// Why there is no picture, and what is wrong with the scene.
fn show_faults(context: &egui::Context, picture: egui::Rect, notices: &mut Notices) {
    if notices.fault.is_none() && notices.issues.is_empty() {
        return;
    }
    let width = (picture.width() - 48.0).clamp(120.0, 560.0);
    let mut dismissed = false;
    egui::Area::new(egui::Id::unique("faults"))
        .fixed_pos(egui::pos2(
            picture.center().x - width * 0.5,
            picture.min.y + 24.0,
        ))
        .show(context, |ui| {
            theme::card().show(ui, |ui| {
                ui.set_width(width);
                if let Some(fault) = &notices.fault {
                    ui.label(
                        egui::RichText::new("No picture")
                            .color(theme::ALARM)
                            .strong(),
                    );
                    ui.label(fault.as_str());
                }
                if !notices.issues.is_empty() {
                    let title = egui::RichText::new("The scene has problems");
                    ui.label(title.color(theme::ALARM).strong());
                    egui::ScrollArea::vertical()
                        .max_height(180.0)
                        .show(ui, |ui| {
                            for issue in &notices.issues {
                                ui.label(egui::RichText::new(issue).monospace());
                            }
                        });
                    dismissed = ui.button("Dismiss").clicked();
                }
            });
        });
    if dismissed {
        notices.issues.clear();
    }
}

fn show_toasts(context: &egui::Context, picture: egui::Rect, notices: &Notices) {
    for (i, (since, text)) in notices.toasts.iter().rev().enumerate() {
        let left = TOAST.saturating_sub(since.elapsed()).as_secs_f32();
        let from_bottom = 12.0 + 46.0 * i as f32;
        egui::Area::new(egui::Id::unique(("toast", i)))
            .pivot(egui::Align2::LEFT_BOTTOM)
            .fixed_pos(picture.left_bottom() + egui::vec2(12.0, -from_bottom))
            .interactable(false)
            .show(context, |ui| {
                ui.set_opacity(left.min(1.0));
                theme::card().show(ui, |ui| ui.label(text.as_str()));
            });
    }
}
