//! What is selected: any number of entities, the last one leading.

use bevy_ecs::prelude::*;

use super::history::is_bare;

/// The selected entities, in the order in which they were.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection(Vec<Entity>);

/// How a click changes the selection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pick {
    /// This alone.
    Only,
    /// This too, or not any more (Ctrl).
    Toggle,
    /// This too (Shift).
    Also,
}

impl Pick {
    /// What the keys that are held say.
    pub fn of(modifiers: egui::Modifiers) -> Self {
        if modifiers.command {
            Self::Toggle
        } else if modifiers.shift {
            Self::Also
        } else {
            Self::Only
        }
    }
}

impl Selection {
    /// All of them, the leading one last.
    pub fn all(&self) -> &[Entity] {
        &self.0
    }

    /// The one the inspector shows: the last that was selected.
    pub fn lead(&self) -> Option<Entity> {
        self.0.last().copied()
    }

    /// Whether an entity is one of them.
    pub fn contains(&self, entity: Entity) -> bool {
        self.0.contains(&entity)
    }

    /// Whether nothing is selected.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Selects these and nothing else.
    pub fn set(&mut self, entities: impl IntoIterator<Item = Entity>) {
        self.0.clear();
        entities.into_iter().for_each(|entity| self.add(entity));
    }

    /// Nothing is selected any more.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Changes it as a click on an entity does.
    pub fn pick(&mut self, entity: Entity, pick: Pick) {
        match pick {
            Pick::Only => self.set([entity]),
            Pick::Toggle if self.contains(entity) => self.0.retain(|&e| e != entity),
            Pick::Toggle | Pick::Also => self.add(entity),
        }
    }

    fn add(&mut self, entity: Entity) {
        self.0.retain(|&e| e != entity);
        self.0.push(entity);
    }

    /// Lets go of what is not there any more.
    pub fn drop_gone(&mut self, world: &World) {
        self.0.retain(|&entity| !is_bare(world, entity));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clicks_select_one_toggle_and_add() {
        let [a, b, c] = [1, 2, 3].map(|row| Entity::from_raw_u32(row).unwrap());
        let mut selection = Selection::default();
        selection.pick(a, Pick::Only);
        selection.pick(b, Pick::Also);
        selection.pick(c, Pick::Toggle);
        assert_eq!(
            (selection.all(), selection.lead()),
            (&[a, b, c][..], Some(c))
        );
        selection.pick(a, Pick::Also);
        assert_eq!(selection.all(), [b, c, a], "the last one leads");
        selection.pick(c, Pick::Toggle);
        assert_eq!(selection.all(), [b, a]);
        selection.pick(c, Pick::Only);
        assert_eq!(selection.all(), [c]);
    }
}
