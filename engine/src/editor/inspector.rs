//! The inspector: every reflected component of what is selected, field by field. With several things selected, an edit is of
//! all that have the component.

use std::any::TypeId;

use bevy_ecs::prelude::*;
use bevy_ecs::reflect::{AppTypeRegistry, ReflectComponent};
use bevy_reflect::TypeRegistry;
use bevy_reflect::std_traits::ReflectDefault;

use super::fields::{FieldEdit, Fields};
use super::history::{Command, FieldSet, Value};
use super::naming::{kind, label, words};
use super::{EditQueue, EditorState, history, theme};
use crate::scene::Imported;
use crate::world::{Rest, SceneId, Transform};

/// A component that was copied, to be pasted.
#[derive(Resource, Debug, Default)]
pub struct Clipboard(Option<Value>);

/// Components that are shown, never edited here.
fn is_fixed(world: &World, entity: Entity, component: TypeId) -> bool {
    // The scene file's key: renaming it here would break the links of the file. A parent is chosen in the hierarchy.
    history::is_derived(component)
        || component == TypeId::of::<SceneId>()
        || component == TypeId::of::<ChildOf>()
        || component == TypeId::of::<Imported>()
        // Motion writes it in every frame, from the rest pose.
        || (component == TypeId::of::<Transform>() && world.get::<Rest>(entity).is_some())
}

/// Whether adding it by hand makes sense.
fn can_be_added(component: TypeId) -> bool {
    let by_others = [
        TypeId::of::<Rest>(),
        TypeId::of::<Imported>(),
        TypeId::of::<Name>(),
        TypeId::of::<ChildOf>(),
    ];
    !history::is_derived(component) && !by_others.contains(&component)
}

/// What the user did in the panel.
enum Wish {
    Edit(TypeId, FieldEdit),
    Select(Entity),
    Add(Value),
    Remove(TypeId),
    Copy(TypeId),
}

/// The panel on the right.
pub fn show(ui: &mut egui::Ui, world: &mut World) {
    egui::Panel::right("inspector")
        .default_size(320.0)
        .min_size(230.0)
        .resizable(true)
        .frame(theme::panel())
        .show(ui, |ui| {
            // As wide empty as full.
            ui.expand_to_include_x(ui.max_rect().right());
            let selection = &world.resource::<EditorState>().selection;
            let (lead, count) = (selection.lead(), selection.all().len());
            match lead.filter(|&entity| world.get_entity(entity).is_ok()) {
                None => {
                    theme::heading(ui, "Inspector");
                    ui.label(theme::faint(
                        "Select something in the picture or on the left",
                    ));
                }
                Some(entity) => {
                    heading(ui, world, entity, count);
                    egui::ScrollArea::vertical()
                        .auto_shrink([false, false])
                        .show(ui, |ui| components(ui, world, entity));
                }
            }
        });
}

fn heading(ui: &mut egui::Ui, world: &World, entity: Entity, count: usize) {
    ui.horizontal(|ui| {
        theme::heading(ui, &label(world, entity));
        let what = world.get_entity(entity).map_or("", kind);
        let more = match count {
            0 | 1 => String::new(),
            count => format!("and {} more; edits are of all", count - 1),
        };
        ui.label(theme::faint(format!("{what} {more}")));
    });
    if world.get::<Imported>(entity).is_some() {
        ui.label(theme::faint(
            "Part of a model file: saving the scene leaves its edits out",
        ));
    }
}

/// A component of an entity as the registry knows it.
struct Listed {
    name: &'static str,
    id: TypeId,
    fixed: bool,
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
            fixed: is_fixed(world, entity, registration.type_id()),
        })
        .collect();
    // What can be edited first, the name and the pose before the rest, each part by name.
    let rank = |c: &Listed| match c.name {
        "Name" => 0,
        "Transform" | "Rest" => 1,
        _ => 2,
    };
    listed.sort_by_key(|c| (c.fixed, rank(c), c.name));
    listed
}

fn components(ui: &mut egui::Ui, world: &mut World, entity: Entity) {
    let registry = world.resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    let mut wishes = Vec::new();
    for component in listed(world, &registry, entity) {
        let title = egui::RichText::new(words(component.name)).strong();
        let title = if component.fixed {
            title.color(theme::FAINT)
        } else {
            title
        };
        let shown = egui::CollapsingHeader::new(title)
            .id_salt((component.name, entity))
            .default_open(!component.fixed)
            .show(ui, |ui| {
                let data = registry.get_type_data::<ReflectComponent>(component.id);
                let value = data.and_then(|data| data.reflect(world.entity(entity)));
                let Some(value) = value else {
                    return;
                };
                let mut fields = Fields::new(&registry, world);
                ui.add_enabled_ui(!component.fixed, |ui| {
                    fields.show(ui, component.name, value.as_partial_reflect());
                });
                wishes.extend(fields.jump.map(Wish::Select));
                let edits = fields.edits.into_iter();
                wishes.extend(edits.map(|edit| Wish::Edit(component.id, edit)));
            });
        let header = shown.header_response;
        header.context_menu(|ui| menu(ui, world, &registry, &component, &mut wishes));
        ui.add_space(2.0);
    }
    ui.add_space(6.0);
    ui.menu_button("Add component", |ui| {
        wishes.extend(add_menu(ui, world, &registry, entity));
    });
    for wish in wishes {
        grant(world, &registry, entity, wish);
    }
}

/// What can be done with a component.
fn menu(
    ui: &mut egui::Ui,
    world: &World,
    registry: &TypeRegistry,
    component: &Listed,
    wishes: &mut Vec<Wish>,
) {
    if ui.button("Copy").clicked() {
        wishes.push(Wish::Copy(component.id));
    }
    let copied = world.resource::<Clipboard>().0.as_ref();
    let same = copied.filter(|copied| (***copied).type_id() == component.id);
    if ui
        .add_enabled(
            same.is_some() && !component.fixed,
            egui::Button::new("Paste"),
        )
        .clicked()
    {
        let copy = same.and_then(|copied| copied.reflect_clone().ok());
        wishes.extend(copy.map(Wish::Add));
    }
    let default = registry.get_type_data::<ReflectDefault>(component.id);
    let can_reset = default.is_some() && !component.fixed;
    if ui
        .add_enabled(can_reset, egui::Button::new("Reset"))
        .clicked()
    {
        wishes.extend(default.map(|default| Wish::Add(default.default())));
    }
    ui.separator();
    let can_go = !component.fixed && component.name != "Name";
    if ui
        .add_enabled(can_go, egui::Button::new("Remove"))
        .clicked()
    {
        wishes.push(Wish::Remove(component.id));
    }
}

/// What the entity does not have yet, and what was copied.
fn add_menu(
    ui: &mut egui::Ui,
    world: &World,
    registry: &TypeRegistry,
    entity: Entity,
) -> Option<Wish> {
    let mut wish = None;
    if let Some(copied) = &world.resource::<Clipboard>().0 {
        let name = copied.reflect_short_type_path().to_owned();
        if ui.button(format!("Paste {}", words(&name))).clicked() {
            wish = copied.reflect_clone().ok().map(Wish::Add);
        }
        ui.separator();
    }
    let has = |id: TypeId| {
        let data = registry.get_type_data::<ReflectComponent>(id);
        data.is_none_or(|data| data.contains(world.entity(entity)))
    };
    let mut kinds: Vec<(String, TypeId)> = registry
        .iter()
        .filter(|kind| kind.data::<ReflectComponent>().is_some())
        .filter(|kind| kind.data::<ReflectDefault>().is_some())
        .map(|kind| (kind, kind.type_id()))
        .filter(|(_, id)| can_be_added(*id) && !has(*id))
        .filter_map(|(kind, id)| Some((words(kind.type_info().type_path_table().ident()?), id)))
        .collect();
    kinds.sort();
    egui::ScrollArea::vertical()
        .max_height(360.0)
        .show(ui, |ui| {
            for (name, id) in kinds {
                let default = registry.get_type_data::<ReflectDefault>(id);
                if ui.button(name).clicked() {
                    wish = default.map(|default| Wish::Add(default.default()));
                }
            }
        });
    wish
}

/// The selected entities that have a component, the leading one last.
fn with_component(world: &World, registry: &TypeRegistry, component: TypeId) -> Vec<Entity> {
    let selected = world.resource::<EditorState>().selection.all();
    let Some(data) = registry.get_type_data::<ReflectComponent>(component) else {
        return Vec::new();
    };
    let has = |&entity: &Entity| world.get_entity(entity).is_ok_and(|e| data.contains(e));
    selected.iter().copied().filter(has).collect()
}

fn grant(world: &mut World, registry: &TypeRegistry, entity: Entity, wish: Wish) {
    match wish {
        Wish::Select(target) => {
            world.resource_mut::<EditorState>().selection.set([target]);
        }
        Wish::Copy(component) => {
            let data = registry.get_type_data::<ReflectComponent>(component);
            let value = data.and_then(|data| data.reflect(world.entity(entity)));
            let copy = value.and_then(|value| value.reflect_clone().ok());
            world.resource_mut::<Clipboard>().0 = copy;
        }
        Wish::Add(value) => {
            let all = world.resource::<EditorState>().selection.all().to_vec();
            let mut queue = world.resource_mut::<EditQueue>();
            queue.push(Command::Insert(all, value));
        }
        Wish::Remove(component) => {
            let all = with_component(world, registry, component);
            let mut queue = world.resource_mut::<EditQueue>();
            queue.push(Command::Remove(all, component));
        }
        Wish::Edit(component, FieldEdit { path, value }) => {
            let group = format!("{entity} {component:?} {path}");
            let set = |entity| {
                Some(FieldSet {
                    entity,
                    component,
                    path: path.clone(),
                    value: value.to_dynamic().ok()?,
                })
            };
            // A name is one thing's own.
            let all = if component == TypeId::of::<Name>() {
                vec![entity]
            } else {
                with_component(world, registry, component)
            };
            let command = Command::Set(all.into_iter().filter_map(set).collect());
            let mut queue = world.resource_mut::<EditQueue>();
            queue.push_dragged(command, None, group);
        }
    }
}
