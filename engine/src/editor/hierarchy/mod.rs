//! The hierarchy: everything in the scene by name, indented under its parent, in the order of the scene's file.
//!
//! What it lists is found anew only when something came, went, was renamed or hung elsewhere; only rows that are seen are
//! laid out. Ten thousand things cost what a screenful costs.

mod index;
mod row;

pub use index::{Index, watch};

use std::any::TypeId;
use std::collections::HashSet;

use bevy_ecs::prelude::*;
use bevy_ecs::reflect::{AppTypeRegistry, ReflectComponent};

use super::history::is_derived;
use super::naming::words;
use super::{EditorState, History, theme};

/// Height of a row, points.
const HEIGHT: f32 = 20.0;
/// Space between rows, points.
const GAP: f32 = 1.0;

/// What the hierarchy remembers.
#[derive(Resource, Debug, Default)]
pub struct Tree {
    /// Branches that are closed.
    closed: HashSet<Entity>,
    /// What names are searched for.
    search: String,
    /// The component that is asked for, and its name.
    filter: Option<(TypeId, String)>,
    /// All there is.
    index: Index,
    /// Rows of the index that are listed, and what they were found for.
    listed: (Vec<usize>, Option<Asked>),
    /// The name being typed.
    renaming: Option<(Entity, String)>,
    /// What led the selection in the last frame.
    led: Option<Entity>,
    /// How far the list is scrolled, points.
    offset: f32,
    /// Rows that were laid out in the last frame.
    laid_out: usize,
}

/// What a list was made for.
#[derive(Clone, Debug, PartialEq)]
struct Asked {
    search: String,
    filter: Option<TypeId>,
    closed: usize,
    index: u64,
}

/// The panel on the left.
pub fn show(ui: &mut egui::Ui, world: &mut World) {
    egui::Panel::left("hierarchy")
        .default_size(240.0)
        .min_size(160.0)
        .resizable(true)
        .frame(theme::panel())
        .show(ui, |ui| {
            let mut tree = std::mem::take(&mut *world.resource_mut::<Tree>());
            heading(ui, world, &mut tree);
            let state = world.resource::<History>().state();
            tree.index.refresh(world, state);
            reveal_lead(world, &mut tree);
            tree.find_rows(world);
            list(ui, world, &mut tree);
            *world.resource_mut::<Tree>() = tree;
        });
}

fn heading(ui: &mut egui::Ui, world: &World, tree: &mut Tree) {
    ui.horizontal(|ui| {
        theme::heading(ui, "Scene");
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let count = tree.listed.0.len();
            ui.label(theme::faint(count.to_string()));
        });
    });
    let search = egui::TextEdit::singleline(&mut tree.search)
        .hint_text("Search names")
        .desired_width(f32::INFINITY);
    ui.add(search);
    let shown = tree
        .filter
        .as_ref()
        .map_or("All components", |(_, name)| name);
    egui::ComboBox::from_id_salt("filter by component")
        .selected_text(shown)
        .width(ui.available_width())
        .show_ui(ui, |ui| {
            if ui
                .selectable_label(tree.filter.is_none(), "All components")
                .clicked()
            {
                tree.filter = None;
            }
            for (id, name) in components(world) {
                let chosen = tree.filter.as_ref().is_some_and(|(known, _)| *known == id);
                if ui.selectable_label(chosen, &name).clicked() {
                    tree.filter = Some((id, name));
                }
            }
        });
    ui.add_space(4.0);
}

/// Components that people know, by name.
fn components(world: &World) -> Vec<(TypeId, String)> {
    let registry = world.resource::<AppTypeRegistry>().read();
    let mut found: Vec<(TypeId, String)> = registry
        .iter()
        .filter(|registration| registration.data::<ReflectComponent>().is_some())
        .filter(|registration| !is_derived(registration.type_id()))
        .filter_map(|registration| {
            let name = registration.type_info().type_path_table().ident()?;
            Some((registration.type_id(), words(name)))
        })
        .collect();
    found.sort_by(|a, b| a.1.cmp(&b.1));
    found
}

/// What was selected elsewhere is opened up to.
fn reveal_lead(world: &World, tree: &mut Tree) {
    let lead = world.resource::<EditorState>().selection.lead();
    if lead == tree.led {
        return;
    }
    let mut above = lead.and_then(|lead| world.get::<ChildOf>(lead));
    while let Some(parent) = above.map(ChildOf::parent) {
        tree.closed.remove(&parent);
        above = world.get::<ChildOf>(parent);
    }
}

impl Tree {
    /// Finds the rows that are listed, if that may have changed.
    fn find_rows(&mut self, world: &World) {
        let asked = Asked {
            search: self.search.to_lowercase(),
            filter: self.filter.as_ref().map(|(id, _)| *id),
            closed: self.closed.len(),
            index: self.index.version(),
        };
        if self.listed.1.as_ref() == Some(&asked) {
            return;
        }
        let rows = if asked.search.is_empty() && asked.filter.is_none() {
            self.index.open_rows(&self.closed)
        } else {
            self.index.matching(world, &asked.search, asked.filter)
        };
        self.listed = (rows, Some(asked));
    }

    /// Whether rows are indented: a search lists what it finds one below the other.
    fn is_tree(&self) -> bool {
        self.search.is_empty() && self.filter.is_none()
    }

    /// Rows that are listed.
    #[cfg(test)]
    pub fn listed(&self) -> usize {
        self.listed.0.len()
    }

    /// Rows that were laid out in the last frame.
    #[cfg(test)]
    pub fn laid_out(&self) -> usize {
        self.laid_out
    }

    /// Another number whenever all there is was found anew.
    #[cfg(test)]
    pub fn version(&self) -> u64 {
        self.index.version()
    }

    /// The row of an entity among those that are listed.
    fn row_of(&self, entity: Entity) -> Option<usize> {
        let is_it = |&row: &usize| self.index.items()[row].entity == entity;
        self.listed.0.iter().position(is_it)
    }
}

fn list(ui: &mut egui::Ui, world: &mut World, tree: &mut Tree) {
    if tree.listed.0.is_empty() {
        ui.label(theme::faint("Nothing by that name"));
    }
    ui.spacing_mut().item_spacing.y = GAP;
    let mut area = egui::ScrollArea::vertical().auto_shrink([false, false]);
    let lead = world.resource::<EditorState>().selection.lead();
    let is_news = lead != tree.led;
    tree.led = lead;
    if let Some(row) = lead.filter(|_| is_news).and_then(|lead| tree.row_of(lead)) {
        let (top, seen) = (row as f32 * (HEIGHT + GAP), ui.available_height());
        let offset = tree.offset;
        if top < offset || top + HEIGHT > offset + seen {
            area = area.vertical_scroll_offset((top - 0.4 * seen).max(0.0));
        }
    }
    tree.laid_out = 0;
    let count = tree.listed.0.len();
    let shown = area
        .id_salt("rows")
        .show_rows(ui, HEIGHT, count, |ui, visible| {
            tree.laid_out = visible.len();
            for at in visible {
                row::show(ui, world, tree, at);
            }
        });
    tree.offset = shown.state.unclamped_offset().y;
    // Dropped beside all rows: to the top of the hierarchy.
    row::drop_at_top(ui, world, shown.inner_rect);
}
