//! Commands: what can be done to a scene, one kind each. Panels, gizmo, menus and keys say what they want with one.

use std::any::TypeId;
use std::path::PathBuf;

use bevy_ecs::prelude::*;
use bevy_reflect::PartialReflect;

use super::parts::Value;
use crate::editor::naming::{kind_of_part, label, spaced};
use crate::world::{Transform, Visibility};

/// A field that is to have a value.
#[derive(Debug)]
pub struct FieldSet {
    /// Whose.
    pub entity: Entity,
    /// Of which component.
    pub component: TypeId,
    /// Where in the component, as bevy_reflect writes paths (".translation"); empty: all of it.
    pub path: String,
    /// What it is to become.
    pub value: Box<dyn PartialReflect>,
}

/// Something to be done to the scene.
#[derive(Debug)]
pub enum Command {
    /// Writes fields; those that are equal already are no change.
    Set(Vec<FieldSet>),
    /// Gives entities a component, or another value of the one they have.
    Insert(Vec<Entity>, Value),
    /// Takes a component off.
    Remove(Vec<Entity>, TypeId),
    /// A new entity with these components, below a parent or at the top.
    Spawn {
        /// What it is called; its id in the scene's file is made from that.
        name: String,
        /// Whom it goes below.
        parent: Option<Entity>,
        /// What it is made of.
        parts: Vec<Value>,
    },
    /// What a model's file shows, before the eye.
    Model {
        /// The file.
        file: PathBuf,
        /// The file of the scene that it comes into: paths in it are from its folder.
        scene: PathBuf,
        /// Where it is put.
        pose: Transform,
    },
    /// Takes entities away, with all below them.
    Delete(Vec<Entity>),
    /// Copies entities beside themselves, with all below them.
    Duplicate(Vec<Entity>),
    /// Hangs entities below another one, or at the top; they stay where they are in the world.
    Reparent(Vec<Entity>, Option<Entity>),
}

/// What a command did besides changing the scene.
#[derive(Debug, Default)]
pub struct Outcome {
    /// What is to be selected now; none: what was.
    pub select: Option<Vec<Entity>>,
}

impl Command {
    /// Writes a name.
    pub fn rename(entity: Entity, name: &str) -> Self {
        Self::Insert(vec![entity], Box::new(Name::new(name.to_owned())))
    }

    /// Shows or hides entities.
    pub fn show(entities: &[Entity], shown: bool) -> Self {
        let set = |&entity| FieldSet {
            entity,
            component: TypeId::of::<Visibility>(),
            path: ".shown".into(),
            value: Box::new(shown),
        };
        Self::Set(entities.iter().map(set).collect())
    }

    /// What menus call it.
    pub fn name(&self, world: &World) -> String {
        let who = |entities: &[Entity]| match entities {
            [one] => label(world, *one),
            many => format!("{} things", many.len()),
        };
        match self {
            Self::Set(sets) => {
                let entities: Vec<Entity> = sets.iter().map(|set| set.entity).collect();
                let Some(first) = sets.first() else {
                    return "Nothing".into();
                };
                let part = kind_of_part(world, first.component);
                if first.component == TypeId::of::<Visibility>() {
                    let shown = first.value.try_downcast_ref::<bool>() != Some(&false);
                    let verb = if shown { "Show" } else { "Hide" };
                    return format!("{verb} {}", who(&entities));
                }
                let field = spaced(first.path.rsplit('.').next().unwrap_or_default());
                let field = if field.parse::<usize>().is_ok() {
                    String::new()
                } else {
                    format!(" {field}")
                };
                format!("{part}{field} of {}", who(&entities))
            }
            Self::Insert(entities, value) => {
                let id = (**value).type_id();
                if id == TypeId::of::<Name>() {
                    return format!("Rename {}", who(entities));
                }
                format!("{} on {}", kind_of_part(world, id), who(entities))
            }
            Self::Remove(entities, component) => {
                let part = kind_of_part(world, *component);
                format!("Remove {part} of {}", who(entities))
            }
            Self::Spawn { name, .. } => format!("New {name}"),
            Self::Model { file, .. } => {
                let name = file.file_stem().unwrap_or_default();
                format!("New {}", name.to_string_lossy())
            }
            Self::Delete(entities) => format!("Delete {}", who(entities)),
            Self::Duplicate(entities) => format!("Duplicate {}", who(entities)),
            Self::Reparent(entities, parent) => match parent {
                Some(parent) => format!("Put {} into {}", who(entities), label(world, *parent)),
                None => format!("Put {} at the top", who(entities)),
            },
        }
    }
}
