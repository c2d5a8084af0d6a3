//! One row of the hierarchy: its branch, its name, what clicks, drags and its menu do.

use bevy_ecs::prelude::*;

use super::{HEIGHT, Tree};
use crate::editor::history::{Command, with_all_below};
use crate::editor::tools::hide_or_show;
use crate::editor::{EditQueue, EditorState, Pick, theme};
use crate::world::Visibility;

/// What is dragged through the list.
struct Dragged(Vec<Entity>);

/// Draws a row that is listed.
pub fn show(ui: &mut egui::Ui, world: &mut World, tree: &mut Tree, at: usize) {
    let row = tree.listed.0[at];
    let (indent, is_tree) = (ui.spacing().indent, tree.is_tree());
    let Some(item) = tree.index.items().get(row) else {
        return;
    };
    let (entity, has_children, hidden) = (item.entity, item.below > 0, item.hidden);
    let (depth, label) = (item.depth, item.label.clone());
    ui.push_id(entity, |ui| {
        ui.horizontal(|ui| {
            ui.set_height(HEIGHT);
            if is_tree {
                ui.add_space(depth as f32 * indent);
                branch(ui, tree, entity, has_children);
            }
            if tree.renaming.as_ref().is_some_and(|(e, _)| *e == entity) {
                rename(ui, world, tree);
                return;
            }
            let is_selected = world.resource::<EditorState>().selection.contains(entity);
            let text = egui::RichText::new(&label);
            let text = if hidden {
                text.color(theme::FAINT).strikethrough()
            } else {
                text
            };
            // The whole line is the button, not the letters alone.
            let line = egui::Button::selectable(is_selected, (text, egui::Atom::grow()))
                .truncate()
                .sense(egui::Sense::click_and_drag())
                .min_size(egui::vec2(ui.available_width(), HEIGHT));
            let response = ui.add(line);
            act(ui, world, tree, (entity, &label), &response);
        });
    });
}

/// What the mouse does on a row.
fn act(
    ui: &egui::Ui,
    world: &mut World,
    tree: &mut Tree,
    (entity, label): (Entity, &str),
    response: &egui::Response,
) {
    if response.double_clicked() {
        tree.renaming = Some((entity, label.to_owned()));
    } else if response.clicked() {
        click(world, tree, entity, ui.input(|input| input.modifiers));
    }
    if response.secondary_clicked() {
        let mut state = world.resource_mut::<EditorState>();
        if !state.selection.contains(entity) {
            state.selection.set([entity]);
        }
    }
    response.context_menu(|ui| menu(ui, world, tree, (entity, label)));
    if response.drag_started() {
        let selection = &world.resource::<EditorState>().selection;
        let dragged = if selection.contains(entity) {
            selection.all().to_vec()
        } else {
            vec![entity]
        };
        response.dnd_set_drag_payload(Dragged(dragged));
    }
    let over = response.dnd_hover_payload::<Dragged>();
    if over.is_some_and(|dragged| !dragged.0.contains(&entity)) {
        let line = egui::Stroke::new(1.5, theme::ACCENT);
        let rect = response.rect;
        ui.painter()
            .rect_stroke(rect, 4.0, line, egui::StrokeKind::Inside);
    }
    if let Some(dragged) = response.dnd_release_payload::<Dragged>()
        && !dragged.0.contains(&entity)
    {
        let command = Command::Reparent(dragged.0.clone(), Some(entity));
        world.resource_mut::<EditQueue>().push(command);
    }
}

/// What is dropped where no row is goes to the top.
pub fn drop_at_top(ui: &egui::Ui, world: &mut World, area: egui::Rect) {
    let released = ui.input(|input| input.pointer.any_released());
    let is_over = ui.rect_contains_pointer(area);
    if !(released && is_over) {
        return;
    }
    if let Some(dragged) = egui::DragAndDrop::take_payload::<Dragged>(ui.ctx()) {
        let command = Command::Reparent(dragged.0.clone(), None);
        world.resource_mut::<EditQueue>().push(command);
    }
}

/// Selects; with Shift all rows from the leading one to this.
fn click(world: &mut World, tree: &mut Tree, entity: Entity, modifiers: egui::Modifiers) {
    let lead = world.resource::<EditorState>().selection.lead();
    let range = lead.filter(|_| modifiers.shift && !modifiers.command);
    let range = range.and_then(|lead| Some((tree.row_of(lead)?, tree.row_of(entity)?)));
    let mut state = world.resource_mut::<EditorState>();
    match range {
        Some((from, to)) => {
            let step: Box<dyn Iterator<Item = usize>> = if from <= to {
                Box::new(from..=to)
            } else {
                Box::new((to..=from).rev())
            };
            for at in step {
                let entity = tree.index.items()[tree.listed.0[at]].entity;
                state.selection.pick(entity, Pick::Also);
            }
        }
        None => state.selection.pick(entity, Pick::of(modifiers)),
    }
    // It is seen already: no need to scroll to it.
    tree.led = state.selection.lead();
}

fn menu(ui: &mut egui::Ui, world: &mut World, tree: &mut Tree, (entity, label): (Entity, &str)) {
    let selected = world.resource::<EditorState>().selection.all().to_vec();
    let mut commands = Vec::new();
    if ui.button("Rename").clicked() {
        tree.renaming = Some((entity, label.to_owned()));
    }
    if ui.button("Duplicate").clicked() {
        commands.push(Command::Duplicate(selected.clone()));
    }
    if ui.button("Hide or show").clicked() {
        commands.push(hide_or_show(&selected, |e| world.get::<Visibility>(e)));
    }
    if ui.button("To the top").clicked() {
        commands.push(Command::Reparent(selected.clone(), None));
    }
    if ui.button("Select all below").clicked() {
        let below = with_all_below(world, &selected);
        world.resource_mut::<EditorState>().selection.set(below);
    }
    ui.separator();
    if ui.button("Delete").clicked() {
        commands.push(Command::Delete(selected.clone()));
    }
    let mut queue = world.resource_mut::<EditQueue>();
    commands.into_iter().for_each(|command| queue.push(command));
}

/// The field in which a name is typed: Enter and leaving it take it, Escape does not.
fn rename(ui: &mut egui::Ui, world: &mut World, tree: &mut Tree) {
    let Some((entity, mut text)) = tree.renaming.take() else {
        return;
    };
    let field = egui::TextEdit::singleline(&mut text).desired_width(f32::INFINITY);
    let response = ui.add(field);
    let given_up = ui.input(|input| input.key_pressed(egui::Key::Escape));
    if response.lost_focus() {
        let name = text.trim();
        if !given_up
            && !name.is_empty()
            && world.get::<Name>(entity).is_none_or(|n| n.as_str() != name)
        {
            let command = Command::rename(entity, name);
            world.resource_mut::<EditQueue>().push(command);
        }
        return;
    }
    if !response.has_focus() {
        response.request_focus();
    }
    tree.renaming = Some((entity, text));
}

/// The triangle that opens and closes a branch, or the space where it would be.
fn branch(ui: &mut egui::Ui, tree: &mut Tree, entity: Entity, has_children: bool) {
    let size = egui::vec2(12.0, 16.0);
    if !has_children {
        ui.allocate_space(size);
        return;
    }
    let (_, response) = ui.allocate_exact_size(size, egui::Sense::click());
    let open = !tree.closed.contains(&entity);
    egui::collapsing_header::paint_default_icon(ui, if open { 1.0 } else { 0.0 }, &response);
    if response.clicked() {
        if open {
            tree.closed.insert(entity);
        } else {
            tree.closed.remove(&entity);
        }
    }
}
