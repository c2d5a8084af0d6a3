//! Whether an entity takes part in the picture: its own switch, and the one its parents leave it.

use bevy_ecs::prelude::*;
use bevy_reflect::prelude::*;

use super::propagate::Inherited;

/// The entity's own switch. A hidden parent hides its children.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[component(summary_tick)]
#[require(GlobalVisibility)]
pub struct Visibility {
    /// True: shown, if every ancestor is.
    pub shown: bool,
}

impl Default for Visibility {
    fn default() -> Self {
        Self { shown: true }
    }
}

/// True if the entity and all its ancestors are shown; written by propagation only.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[component(summary_tick)]
pub struct GlobalVisibility(pub bool);

impl Default for GlobalVisibility {
    fn default() -> Self {
        Self(true)
    }
}

/// Stands where [`Inherited`] asks for an extra component and there is none.
#[derive(Component)]
pub struct NoExtra;

impl Inherited for GlobalVisibility {
    type Local = Visibility;
    type Extra = NoExtra;

    fn compose(parent: Option<&Self>, local: &Visibility, _: Option<&NoExtra>) -> Self {
        Self(local.shown && parent.is_none_or(|parent| parent.0))
    }
}
