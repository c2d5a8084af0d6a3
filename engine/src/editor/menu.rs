//! The bar at the top: files, edits with their history, what can be added, the clock.

use bevy_ecs::prelude::*;

use super::history::Command;
use super::tools::hide_or_show;
use super::{Document, EditQueue, EditorState, History, Wish, spawnable, theme};
use crate::input::{Action, KeyMap};
use crate::time::{Clock, Time};
use crate::world::Visibility;

/// Steps of the history that a menu lists.
const LISTED: usize = 30;

/// Draws the bar.
pub fn show(ui: &mut egui::Ui, world: &mut World) {
    egui::Panel::top("menu")
        .frame(theme::bar())
        .resizable(false)
        .show(ui, |ui| {
            egui::MenuBar::new().ui(ui, |ui| {
                ui.menu_button("File", |ui| file_menu(ui, world));
                ui.menu_button("Edit", |ui| edit_menu(ui, world));
                ui.menu_button("History", |ui| history_menu(ui, world));
                ui.menu_button("Add", |ui| spawnable::menu(ui, world));
                ui.separator();
                clock(ui, world);
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    let words = document_words(world);
                    ui.label(theme::faint(words));
                });
            });
        });
    ask_where(ui, world);
    offer_left(ui, world);
}

/// The file, and whether it has all that was done.
fn document_words(world: &World) -> String {
    let path = world.resource::<Document>().path.as_deref();
    let name = path.and_then(|path| path.file_name()).map_or_else(
        || "no file yet".into(),
        |name| name.to_string_lossy().into_owned(),
    );
    if world.resource::<History>().is_unsaved() {
        format!("{name} \u{2022} unsaved")
    } else {
        name
    }
}

/// The first key of an action, as a menu shows it.
fn key(world: &World, action: Action) -> String {
    let keys = world.resource::<KeyMap>();
    keys.triggers(action)
        .next()
        .map_or_else(String::new, |trigger| trigger.to_string())
}

fn item(ui: &mut egui::Ui, enabled: bool, name: &str, key: String) -> bool {
    let button = egui::Button::new(name)
        .shortcut_text(key)
        .min_size(egui::vec2(190.0, 0.0));
    let clicked = ui.add_enabled(enabled, button).clicked();
    if clicked {
        ui.close();
    }
    clicked
}

fn file_menu(ui: &mut egui::Ui, world: &mut World) {
    let has_file = world.resource::<Document>().path.is_some();
    let entries = [
        (true, "Save", key(world, Action::Save), Wish::Save),
        (
            true,
            "Save as\u{2026}",
            key(world, Action::SaveAs),
            Wish::AskWhere,
        ),
        (has_file, "Revert to saved", String::new(), Wish::Revert),
    ];
    for (enabled, name, key, wish) in entries {
        if item(ui, enabled, name, key) {
            world.resource_mut::<EditQueue>().0.push(wish);
        }
    }
}

fn edit_menu(ui: &mut egui::Ui, world: &mut World) {
    let history = world.resource::<History>();
    let named = |verb: &str, name: Option<&str>| match name {
        Some(name) => format!("{verb} {name}"),
        None => verb.to_owned(),
    };
    let last = history.done().next_back().map(|step| step.name.as_str());
    let next = history.undone().next().map(|step| step.name.as_str());
    let undo = (last.is_some(), named("Undo", last));
    let redo = (next.is_some(), named("Redo", next));
    let selected = world.resource::<EditorState>().selection.all().to_vec();
    let any = !selected.is_empty();
    let mut wishes = Vec::new();
    if item(ui, undo.0, &undo.1, key(world, Action::Undo)) {
        wishes.push(Wish::Undo(1));
    }
    if item(ui, redo.0, &redo.1, key(world, Action::Redo)) {
        wishes.push(Wish::Redo(1));
    }
    ui.separator();
    let mut queue = Vec::new();
    if item(ui, any, "Duplicate", key(world, Action::Duplicate)) {
        queue.push(Command::Duplicate(selected.clone()));
    }
    if item(ui, any, "Delete", key(world, Action::Delete)) {
        queue.push(Command::Delete(selected.clone()));
    }
    if item(ui, any, "Hide or show", key(world, Action::Hide)) {
        queue.push(hide_or_show(&selected, |e| world.get::<Visibility>(e)));
    }
    let mut edits = world.resource_mut::<EditQueue>();
    edits.0.extend(wishes);
    queue.into_iter().for_each(|command| edits.push(command));
}

/// Every step, the newest first; a click goes there.
fn history_menu(ui: &mut egui::Ui, world: &mut World) {
    let history = world.resource::<History>();
    let (done, undone) = (history.done().len(), history.undone().len());
    if done + undone == 0 {
        ui.label(theme::faint("Nothing was done yet"));
        return;
    }
    let mut wish = None;
    ui.set_min_width(220.0);
    egui::ScrollArea::vertical()
        .max_height(420.0)
        .show(ui, |ui| {
            let ahead: Vec<&str> = history.undone().map(|step| step.name.as_str()).collect();
            for (i, name) in ahead.iter().enumerate().take(LISTED).rev() {
                if ui.selectable_label(false, theme::faint(*name)).clicked() {
                    wish = Some(Wish::Redo(i + 1));
                }
            }
            for (i, step) in history.done().rev().take(LISTED).enumerate() {
                if ui.selectable_label(i == 0, &step.name).clicked() && i > 0 {
                    wish = Some(Wish::Undo(i));
                }
            }
            let more = done.saturating_sub(LISTED);
            let start = if more > 0 {
                format!("{more} more, and the start")
            } else {
                "The scene as it was opened".to_owned()
            };
            if ui
                .selectable_label(done == 0, theme::faint(start))
                .clicked()
                && done > 0
            {
                wish = Some(Wish::Undo(done));
            }
        });
    if let Some(wish) = wish {
        world.resource_mut::<EditQueue>().0.push(wish);
        ui.close();
    }
}

/// Play or pause, a frame further, back to the start.
fn clock(ui: &mut egui::Ui, world: &mut World) {
    let time = *world.resource::<Time>();
    let plays = *world.resource::<Clock>() == Clock::Wall;
    let words = if plays { "Pause" } else { "Play" };
    let small = |text: &str| egui::Button::new(text.to_owned()).frame_when_inactive(false);
    if ui
        .add(small(words))
        .on_hover_text(key(world, Action::Pause))
        .clicked()
    {
        *world.resource_mut::<Clock>() = if plays { Clock::Paused } else { Clock::Wall };
    }
    if ui
        .add(small("Step"))
        .on_hover_text(key(world, Action::Step))
        .clicked()
    {
        *world.resource_mut::<Clock>() = Clock::Frame(time.number() + 1);
    }
    if ui
        .add(small("Start"))
        .on_hover_text("Back to second 0")
        .clicked()
    {
        *world.resource_mut::<Clock>() = Clock::Frame(0);
    }
    ui.label(theme::faint(format!("{:.2} s", time.secs)));
}

/// Where to save to.
fn ask_where(ui: &mut egui::Ui, world: &mut World) {
    let Some(mut typed) = world.resource::<Document>().asked.clone() else {
        return;
    };
    let (mut open, mut chosen) = (true, false);
    egui::Window::new("Save as")
        .open(&mut open)
        .collapsible(false)
        .resizable(false)
        .frame(theme::card())
        .anchor(egui::Align2::CENTER_CENTER, egui::Vec2::ZERO)
        .show(ui.ctx(), |ui| {
            let line = ui.add(egui::TextEdit::singleline(&mut typed).desired_width(420.0));
            if !line.has_focus() && !line.lost_focus() {
                line.request_focus();
            }
            let path = std::path::Path::new(typed.trim());
            if path.exists() {
                ui.label(theme::faint("There is such a file: it is written over"));
            }
            let is_scene = path.extension().is_some_and(|ending| ending == "ron");
            if !is_scene {
                ui.label(theme::faint("Scene files end in .ron"));
            }
            let entered = line.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
            let save = ui.add_enabled(is_scene, egui::Button::new("Save"));
            chosen = is_scene && (entered || save.clicked());
        });
    let path = typed.trim().into();
    world.resource_mut::<Document>().asked = open.then_some(typed);
    if chosen {
        world.resource_mut::<EditQueue>().0.push(Wish::SaveAs(path));
    }
}

/// What an earlier run left.
fn offer_left(ui: &mut egui::Ui, world: &mut World) {
    if world.resource::<Document>().left.is_none() {
        return;
    }
    egui::Window::new("Unsaved edits")
        .collapsible(false)
        .resizable(false)
        .frame(theme::card())
        .anchor(egui::Align2::CENTER_TOP, egui::vec2(0.0, 60.0))
        .show(ui.ctx(), |ui| {
            ui.label("The last run ended with edits of this scene that were not saved.");
            ui.horizontal(|ui| {
                let mut queue = world.resource_mut::<EditQueue>();
                if ui.button("Take them up").clicked() {
                    queue.0.push(Wish::Recover);
                }
                if ui.button("Drop them").clicked() {
                    queue.0.push(Wish::DropLeft);
                }
            });
        });
}
