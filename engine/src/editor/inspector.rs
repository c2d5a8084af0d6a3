//! The inspector: every reflected component of the selected entity, field by field.

use std::any::TypeId;

use bevy_ecs::prelude::*;
use bevy_ecs::reflect::{AppTypeRegistry, ReflectComponent};
use bevy_reflect::TypeRegistry;

use super::fields::{FieldEdit, Fields};
use super::history::{Command, FieldSet};
use super::naming::label;
use super::{EditQueue, EditorState, history, theme};
use crate::world::SceneId;

/// Components that systems derive: shown, never edited.
fn is_derived(component: TypeId) -> bool {
    // The scene file's key: renaming it here would break the links of the file. A parent is chosen in the hierarchy.
    history::is_derived(component)
        || component == TypeId::of::<SceneId>()
        || component == TypeId::of::<ChildOf>()
}

/// The panel on the right.
pub fn show(ui: &mut egui::Ui, world: &mut World) {
    egui::Panel::right("inspector")
        .default_size(310.0)
        .min_size(220.0)
        .resizable(true)
        .frame(theme::panel())
        .show(ui, |ui| {
            // As wide empty as full.
            ui.expand_to_include_x(ui.max_rect().right());
            let selected = world.resource::<EditorState>().selection.lead();
            match selected.filter(|&entity| world.get_entity(entity).is_ok()) {
                None => {
                    theme::heading(ui, "Inspector");
                    ui.label(theme::faint("Select something on the left"));
                }
                Some(entity) => {
                    theme::heading(ui, &label(world, entity));
                    egui::ScrollArea::vertical()
                        .auto_shrink([false, false])
                        .show(ui, |ui| components(ui, world, entity));
                }
            }
        });
}

/// A component of an entity as the registry knows it.
struct Listed {
    name: &'static str,
    id: TypeId,
}

fn listed(world: &World, registry: &TypeRegistry, entity: Entity) -> Vec<Listed> {
    let Ok(found) = world.get_entity(entity) else {
        return Vec::new();
    };
    let mut listed: Vec<Listed> = found
        .archetype()
        .components()
        .iter()
        .filter_map(|&component| world.components().get_info(component)?.type_id())
        .filter_map(|id| registry.get(id))
        .filter(|registration| registration.data::<ReflectComponent>().is_some())
        .map(|registration| Listed {
            name: registration
                .type_info()
                .type_path_table()
                .ident()
                .unwrap_or("?"),
            id: registration.type_id(),
        })
        .collect();
    // What can be edited first, each part by name, so that the order is that of no archetype.
    listed.sort_by_key(|c| (is_derived(c.id), c.name));
    listed
}

fn components(ui: &mut egui::Ui, world: &mut World, entity: Entity) {
    let registry = world.resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    let mut edits = Vec::new();
    for component in listed(world, &registry, entity) {
        let derived = is_derived(component.id);
        let title = egui::RichText::new(component.name).strong();
        let title = if derived {
            title.color(theme::FAINT)
        } else {
            title
        };
        egui::CollapsingHeader::new(title)
            .id_salt((component.name, entity))
            .default_open(!derived)
            .show(ui, |ui| {
                let data = registry.get_type_data::<ReflectComponent>(component.id);
                let value = data.and_then(|data| data.reflect(world.entity(entity)));
                let Some(value) = value else {
                    return;
                };
                let mut fields = Fields::new(&registry, world);
                ui.add_enabled_ui(!derived, |ui| {
                    fields.show(ui, component.name, value.as_partial_reflect());
                });
                if let Some(target) = fields.jump {
                    edits.push(Wish::Select(target));
                }
                edits.extend(
                    fields
                        .edits
                        .into_iter()
                        .map(|edit| Wish::Edit(component.id, edit)),
                );
            });
        ui.add_space(2.0);
    }
    for wish in edits {
        match wish {
            Wish::Select(target) => world.resource_mut::<EditorState>().selection.set([target]),
            Wish::Edit(component, FieldEdit { path, value }) => {
                let group = format!("{entity} {component:?} {path}");
                let set = FieldSet {
                    entity,
                    component,
                    path,
                    value,
                };
                let mut queue = world.resource_mut::<EditQueue>();
                queue.push_dragged(Command::Set(vec![set]), None, group);
            }
        }
    }
}

/// What the user did in the panel.
enum Wish {
    Edit(TypeId, FieldEdit),
    Select(Entity),
}
