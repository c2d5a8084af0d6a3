//! The bar at the top: files, edits with their history, what can be added, the clock.

use std::path::{Path, PathBuf};

use bevy_ecs::prelude::*;

use super::document::Asked;
use super::gizmo::{Gizmo, Mode};
use super::history::Command;
use super::playing::{self, BeforePlay};
use super::tools::hide_or_show;
use super::{Document, EditQueue, EditorState, History, Wish, spawnable, theme};
use crate::input::{Action, KeyMap};
use crate::scene;
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
                ui.separator();
                handles(ui, world);
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    let words = document_words(world);
                    ui.label(theme::faint(words));
                });
            });
        });
    add_window(ui, world);
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
    if world.resource::<BeforePlay>().is_there() {
        let since = playing::edits_while_playing(world);
        ui.menu_button("Back", |ui| {
            let mut wish = None;
            if item(ui, true, "To before play", String::new()) {
                wish = Some(Wish::Back { keeps_edits: true });
            }
            let name = format!("And undo {since} edits since");
            if since > 0 && item(ui, true, &name, String::new()) {
                wish = Some(Wish::Back { keeps_edits: false });
            }
            world.resource_mut::<EditQueue>().0.extend(wish);
        });
    }
    ui.label(theme::faint(format!("{:.2} s", time.secs)));
}

/// What the handles do.
fn handles(ui: &mut egui::Ui, world: &mut World) {
    let modes = [
        (Mode::Move, "Move", Action::Move),
        (Mode::Rotate, "Rotate", Action::Rotate),
        (Mode::Scale, "Scale", Action::Scale),
    ];
    for (mode, name, action) in modes {
        let hint = key(world, action);
        let mut gizmo = world.resource_mut::<Gizmo>();
        ui.selectable_value(&mut gizmo.mode, mode, name)
            .on_hover_text(hint);
    }
    let hint = key(world, Action::Axes);
    let mut gizmo = world.resource_mut::<Gizmo>();
    let name = if gizmo.own_axes {
        "Own axes"
    } else {
        "World axes"
    };
    let button = egui::Button::new(name).frame_when_inactive(false);
    gizmo.own_axes ^= ui.add(button).on_hover_text(hint).clicked();
}

/// What can be added, listed by a key.
fn add_window(ui: &mut egui::Ui, world: &mut World) {
    let mut open = world.resource::<EditorState>().adding;
    if !open {
        return;
    }
    egui::Window::new("Add")
        .open(&mut open)
        .collapsible(false)
        .resizable(false)
        .frame(theme::card())
        .anchor(egui::Align2::CENTER_CENTER, egui::Vec2::ZERO)
        .show(ui.ctx(), |ui| spawnable::menu(ui, world));
    let queue = world.resource::<EditQueue>();
    let chosen = queue.0.iter().any(|wish| {
        matches!(
            wish,
            Wish::Do {
                command: Command::Spawn { .. },
                ..
            }
        )
    });
    world.resource_mut::<EditorState>().adding = open && !chosen;
}

/// A path: where to save to, or of a model to add.
fn ask_where(ui: &mut egui::Ui, world: &mut World) {
    let Some(mut asked) = world.resource::<Document>().asked.clone() else {
        return;
    };
    let (title, verb) = if asked.adds {
        ("Add a model file", "Add")
    } else {
        ("Save as", "Save")
    };
    let (mut open, mut chosen) = (true, false);
    egui::Window::new(title)
        .open(&mut open)
        .collapsible(false)
        .resizable(false)
        .frame(theme::card())
        .anchor(egui::Align2::CENTER_CENTER, egui::Vec2::ZERO)
        .show(ui.ctx(), |ui| {
            let field = egui::TextEdit::singleline(&mut asked.typed).desired_width(440.0);
            let line = ui.add(field);
            if !line.has_focus() && !line.lost_focus() {
                line.request_focus();
            }
            let hint = hint(&asked);
            if let Some(hint) = &hint.0 {
                ui.label(theme::faint(hint.as_str()));
            }
            let entered = line.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
            let button = ui.add_enabled(hint.1, egui::Button::new(verb));
            chosen = hint.1 && (entered || button.clicked());
        });
    let path = PathBuf::from(asked.typed.trim());
    let wish = if asked.adds {
        spawnable::model(world, path)
    } else {
        Wish::SaveAs(path)
    };
    world.resource_mut::<Document>().asked = (open && !chosen).then_some(asked);
    if chosen {
        world.resource_mut::<EditQueue>().0.push(wish);
    }
}

/// What is to be said of a path that was typed, and whether it will do.
fn hint(asked: &Asked) -> (Option<String>, bool) {
    let path = Path::new(asked.typed.trim());
    if asked.adds {
        let words = match (scene::is_model(path), path.exists()) {
            (false, _) => format!("A model's file: {}", scene::endings()),
            (true, false) => "There is no such file".into(),
            (true, true) => return (None, true),
        };
        return (Some(words), false);
    }
    if path.extension().is_none_or(|ending| ending != "ron") {
        return (Some("Scene files end in .ron".into()), false);
    }
    let over = "There is such a file: it is written over";
    (path.exists().then(|| over.into()), true)
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
