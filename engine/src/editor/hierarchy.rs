//! The hierarchy: every entity of the scene by name, indented under its parent. Only visible rows are drawn.

use std::collections::HashSet;

use bevy_ecs::prelude::*;

use super::{EditorState, theme};
use crate::world::{
    Camera, Cone, Cuboid, Cylinder, DirectionalLight, Disc, Material, Mesh, Plane, PointLight,
    Polygon, SceneId, Sphere, SpotLight, Torus, Transform,
};

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

/// What people call an entity: its name, else its id in the scene file, else its kind and number.
pub fn label(world: &World, entity: Entity) -> String {
    let Ok(found) = world.get_entity(entity) else {
        return format!("{entity} (gone)");
    };
    if let Some(name) = found.get::<Name>() {
        name.to_string()
    } else if let Some(id) = found.get::<SceneId>() {
        id.0.clone()
    } else {
        format!("{} {}", kind(found), entity.index())
    }
}

/// What an entity is, in a word.
fn kind(entity: EntityRef) -> &'static str {
    let kinds = [
        (entity.contains::<Camera>(), "camera"),
        (entity.contains::<PointLight>(), "point light"),
        (entity.contains::<DirectionalLight>(), "sun"),
        (entity.contains::<SpotLight>(), "spot light"),
        (entity.contains::<Sphere>(), "sphere"),
        (entity.contains::<Plane>(), "plane"),
        (entity.contains::<Cuboid>(), "box"),
        (entity.contains::<Disc>(), "disc"),
        (entity.contains::<Cylinder>(), "cylinder"),
        (entity.contains::<Cone>(), "cone"),
        (entity.contains::<Torus>(), "torus"),
        (entity.contains::<Polygon>(), "polygon"),
        (entity.contains::<Mesh>(), "mesh"),
        (entity.contains::<Material>(), "material"),
    ];
    let found = kinds.iter().find(|(is, _)| *is);
    found.map_or("group", |(_, kind)| kind)
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
    let selected = world.resource::<EditorState>().selected;
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
                    let is_selected = selected == Some(row.entity);
                    // The whole line is the button, not the letters alone.
                    let text = (row.label.as_str(), egui::Atom::grow());
                    let line = egui::Button::selectable(is_selected, text)
                        .truncate()
                        .min_size(egui::vec2(ui.available_width(), height));
                    if ui.add(line).clicked() {
                        let mut state = world.resource_mut::<EditorState>();
                        state.selected = (!is_selected).then_some(row.entity);
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
