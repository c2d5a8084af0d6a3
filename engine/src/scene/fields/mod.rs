//! Fields by their path in the scene file: the one way to read and write a value by name.
//!
//! The timeline, the editor, undo and scripts address what they change as (id, path): `"moon"`,
//! `"transform.translation"`. Values are those of the file (angles in degrees). `material.*` fields belong to
//! the material's entity, all others to the entity itself. Writing an equal value is no change: the
//! component's change tick stays, so nothing downstream runs.

mod table;

pub use table::all;

use std::fmt;

use bevy_ecs::prelude::*;
use glam::{DQuat, DVec3};

use super::problem::nearest;

/// A value of a field.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A switch.
    Bool(bool),
    /// A number; an angle is in degrees.
    Number(f64),
    /// A position, a scale, a direction or a linear RGB colour.
    Vec3(DVec3),
    /// A unit quaternion.
    Rotation(DQuat),
    /// A name, or a choice by its word in the file.
    Text(String),
}

/// Which variant of [`Value`] a field takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldKind {
    /// [`Value::Bool`]
    Bool,
    /// [`Value::Number`]
    Number,
    /// [`Value::Vec3`]
    Vec3,
    /// [`Value::Rotation`]
    Rotation,
    /// [`Value::Text`]; cannot be keyed.
    Text,
}

impl Value {
    /// The kind of field it fits.
    pub fn kind(&self) -> FieldKind {
        match self {
            Self::Bool(_) => FieldKind::Bool,
            Self::Number(_) => FieldKind::Number,
            Self::Vec3(_) => FieldKind::Vec3,
            Self::Rotation(_) => FieldKind::Rotation,
            Self::Text(_) => FieldKind::Text,
        }
    }

    /// Whether every number in it is finite.
    fn is_finite(&self) -> bool {
        match self {
            Self::Number(number) => number.is_finite(),
            Self::Vec3(vector) => vector.is_finite(),
            Self::Rotation(quat) => quat.is_finite(),
            Self::Bool(_) | Self::Text(_) => true,
        }
    }
}

/// A row of the table of fields.
pub struct Field {
    /// Its path in the scene file.
    pub path: &'static str,
    /// What it holds.
    pub kind: FieldKind,
    range: fn(&Value) -> Result<(), &'static str>,
    is_on: fn(&EntityRef) -> bool,
    get: fn(&EntityRef) -> Option<Value>,
    set: fn(&mut EntityWorldMut, &Value) -> Option<bool>,
}

impl Field {
    /// True if the field is one of a material's entity.
    pub fn is_material(&self) -> bool {
        self.path.starts_with("material.")
    }

    /// Whether the value is of the right kind, finite and in range.
    ///
    /// # Errors
    /// What was expected.
    pub fn check(&self, value: &Value) -> Result<(), &'static str> {
        if value.kind() != self.kind {
            return Err(match self.kind {
                FieldKind::Bool => "true or false",
                FieldKind::Number => "a number",
                FieldKind::Vec3 => "three numbers",
                FieldKind::Rotation => "a rotation",
                FieldKind::Text => "a string",
            });
        }
        if !value.is_finite() {
            return Err("finite numbers");
        }
        (self.range)(value)
    }

    /// Whether the entity has a component that the field is of.
    pub fn is_on(&self, world: &World, entity: Entity) -> bool {
        world
            .get_entity(entity)
            .is_ok_and(|entity| (self.is_on)(&entity))
    }

    /// The value; none where the entity does not have it.
    pub fn get(&self, world: &World, entity: Entity) -> Option<Value> {
        (self.get)(&world.get_entity(entity).ok()?)
    }

    /// Writes the value and says whether that changed anything.
    ///
    /// # Errors
    /// [`FieldError::BadValue`] and [`FieldError::NotThere`].
    pub fn set(
        &self,
        world: &mut World,
        entity: Entity,
        value: &Value,
    ) -> Result<bool, FieldError> {
        self.check(value).map_err(|expected| FieldError::BadValue {
            path: self.path,
            found: format!("{value:?}"),
            expected,
        })?;
        if self.get(world, entity).as_ref() == Some(value) {
            return Ok(false);
        }
        let entity_mut = world.get_entity_mut(entity).ok();
        entity_mut
            .and_then(|mut entity| (self.set)(&mut entity, value))
            .ok_or(FieldError::NotThere {
                path: self.path,
                entity,
            })
    }
}

impl fmt::Debug for Field {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({:?})", self.path, self.kind)
    }
}

/// Why a field could not be read or written.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldError {
    /// No field has this path.
    Unknown {
        /// The path asked for.
        path: String,
        /// The nearest one there is.
        suggestion: Option<String>,
    },
    /// The entity does not have the component, or is gone.
    NotThere {
        /// The field's path.
        path: &'static str,
        /// The entity.
        entity: Entity,
    },
    /// The value is of the wrong kind or out of range.
    BadValue {
        /// The field's path.
        path: &'static str,
        /// The value.
        found: String,
        /// What would be right.
        expected: &'static str,
    },
}

impl fmt::Display for FieldError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown { path, suggestion } => {
                write!(f, "unknown field `{path}`")?;
                match suggestion {
                    Some(suggestion) => write!(f, "; did you mean `{suggestion}`?"),
                    None => Ok(()),
                }
            }
            Self::NotThere { path, entity } => write!(f, "{entity} has no field `{path}`"),
            Self::BadValue {
                path,
                found,
                expected,
            } => {
                write!(f, "`{path}`: found {found}; expected {expected}")
            }
        }
    }
}

impl std::error::Error for FieldError {}

/// The field of a path.
///
/// # Errors
/// [`FieldError::Unknown`] with the nearest path.
pub fn find(path: &str) -> Result<&'static Field, FieldError> {
    all()
        .iter()
        .find(|field| field.path == path)
        .ok_or_else(|| FieldError::Unknown {
            path: path.to_owned(),
            suggestion: nearest(path, all().iter().map(|field| field.path)),
        })
}

/// The value of a field of an entity (for `material.*`: of a material's entity).
///
/// # Errors
/// [`FieldError::Unknown`] and [`FieldError::NotThere`].
pub fn get(world: &World, entity: Entity, path: &str) -> Result<Value, FieldError> {
    let field = find(path)?;
    field.get(world, entity).ok_or(FieldError::NotThere {
        path: field.path,
        entity,
    })
}

/// Writes a field of an entity (for `material.*`: of a material's entity); true if that changed it.
///
/// # Errors
/// See [`FieldError`].
pub fn set(
    world: &mut World,
    entity: Entity,
    path: &str,
    value: &Value,
) -> Result<bool, FieldError> {
    find(path)?.set(world, entity, value)
}

/// The layer of [`crate::world::ClipPlayer`] that a field of `clip` is of.
pub(super) fn clip_layer(path: &str) -> usize {
    let part = path.split('.').nth(1);
    part.and_then(|part| part.parse().ok()).unwrap_or(0)
}

/// `transform.translation`, which paths write.
pub(super) fn position() -> &'static Field {
    &all()[0]
}

#[cfg(test)]
mod tests;
