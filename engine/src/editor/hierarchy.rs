//! The hierarchy: every entity of the scene by name, indented under its parent. Only visible rows are drawn.

use std::collections::HashSet;

use bevy_ecs::prelude::*;

use super::naming::label;
use super::selection::Pick;
use super::{EditorState, theme};
use crate::world::{Material, SceneId, Transform};

/// What the hierarchy remembers.
#[derive(Resource, Debug, Default)]
pub struct Tree {
    closed: HashSet<Entity>,
    search: String,
}

/// One line of the list.
struct Row {
    entity: Entity,
    depth: usize,
    label: String,
    has_children: bool,
}

/// The panel on the left.
pub fn show(ui: &mut egui::Ui, world: &mut World) {
    egui::Panel::left("hierarchy")
        .default_size(230.0)
        .min_size(150.0)
        .resizable(true)
        .frame(theme::panel())
        .show(ui, |ui| {
            theme::heading(ui, "Scene");
            let mut tree = std::mem::take(&mut *world.resource_mut::<Tree>());
            let search = egui::TextEdit::singleline(&mut tree.search)
                .hint_text("Search")
                .desired_width(f32::INFINITY);
            ui.add(search);
            ui.add_space(4.0);
            let rows = rows(world, &tree);
            list(ui, world, &mut tree, &rows);
            *world.resource_mut::<Tree>() = tree;
        });
}

fn rows(world: &mut World, tree: &Tree) -> Vec<Row> {
    type Listed = (
        Or<(With<Transform>, With<Material>, With<SceneId>, With<Name>)>,
        Without<ChildOf>,
    );
    let mut roots: Vec<Entity> = world
        .query_filtered::<Entity, Listed>()
        .iter(world)
        .collect();
    roots.sort_unstable();
    let search = tree.search.to_lowercase();
    let mut rows = Vec::new();
    let mut pending: Vec<(Entity, usize)> = roots.into_iter().rev().map(|e| (e, 0)).collect();
    while let Some((entity, depth)) = pending.pop() {
        let label = label(world, entity);
        let children = world.get::<Children>(entity);
        if search.is_empty() || label.to_lowercase().contains(&search) {
            rows.push(Row {
                entity,
                depth: if search.is_empty() { depth } else { 0 },
                has_children: search.is_empty() && children.is_some_and(|c| !c.is_empty()),
                label,
            });
        }
        // A search looks into closed branches too.
        if let Some(children) = children
            && (!search.is_empty() || !tree.closed.contains(&entity))
        {
            pending.extend(children.iter().rev().map(|child| (child, depth + 1)));
        }
    }
    rows
}

fn list(ui: &mut egui::Ui, world: &mut World, tree: &mut Tree, rows: &[Row]) {
    if rows.is_empty() {
        ui.label(theme::faint("Nothing by that name"));
    }
    let selection = world.resource::<EditorState>().selection.clone();
    let height = 20.0;
    ui.spacing_mut().item_spacing.y = 1.0;
    egui::ScrollArea::vertical()
        .auto_shrink([false, false])
        .show_rows(ui, height, rows.len(), |ui, visible| {
            for row in &rows[visible] {
                ui.horizontal(|ui| {
                    ui.set_height(height);
                    ui.add_space(row.depth as f32 * ui.spacing().indent);
                    branch(ui, tree, row);
                    let is_selected = selection.contains(row.entity);
                    // The whole line is the button, not the letters alone.
                    let text = (row.label.as_str(), egui::Atom::grow());
                    let line = egui::Button::selectable(is_selected, text)
                        .truncate()
                        .min_size(egui::vec2(ui.available_width(), height));
                    if ui.add(line).clicked() {
                        let pick = Pick::of(ui.input(|input| input.modifiers));
                        let mut state = world.resource_mut::<EditorState>();
                        state.selection.pick(row.entity, pick);
                    }
                });
            }
        });
}

/// The triangle that opens and closes a branch, or the space where it would be.
fn branch(ui: &mut egui::Ui, tree: &mut Tree, row: &Row) {
    let size = egui::vec2(12.0, 16.0);
    if !row.has_children {
        ui.allocate_space(size);
        return;
    }
    let (_, response) = ui.allocate_exact_size(size, egui::Sense::click());
    let open = !tree.closed.contains(&row.entity);
    egui::collapsing_header::paint_default_icon(ui, if open { 1.0 } else { 0.0 }, &response);
    if response.clicked() {
        if open {
            tree.closed.insert(row.entity);
        } else {
            tree.closed.remove(&row.entity);
        }
    }
}
