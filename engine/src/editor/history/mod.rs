//! The history: every edit as a named step that goes back and forth, exactly.
//!
//! Whoever edits queues a [`Command`]; [`perform`] runs it and keeps what it did as [`Step`]. Drags are one step: commands
//! that say they belong together join while the group is open.

mod birth;
mod change;
mod command;
mod parts;
mod place;
mod run;

pub use command::{Command, FieldSet, Outcome};
pub(in crate::editor) use parts::with_all_below;
pub use parts::{Value, is_bare, is_derived};
pub(in crate::editor) use place::world_from;
pub(in crate::editor) use run::topmost;

use std::collections::VecDeque;

use bevy_ecs::prelude::*;

use change::{Change, Way};

/// Steps that are kept.
pub const STEPS: usize = 1000;

/// What one command, or one drag, did.
#[derive(Debug)]
pub struct Step {
    /// As menus call it: "Move ball".
    pub name: String,
    changes: Vec<Change>,
}

impl Step {
    /// Entities that changed, each once.
    pub fn entities(&self) -> Vec<Entity> {
        let mut entities: Vec<Entity> = self.changes.iter().map(Change::entity).collect();
        entities.sort_unstable();
        entities.dedup();
        entities
    }

    fn join(&mut self, later: Self) {
        for change in later.changes {
            let mut left = Some(change);
            for earlier in &mut self.changes {
                match left.take() {
                    Some(change) => left = earlier.join(change),
                    None => break,
                }
            }
            self.changes.extend(left);
        }
    }

    /// Despawns what is gone for good once the step is forgotten: entities that are bare on the side that stays.
    fn forget(self, world: &mut World, side: Way) {
        for entity in self.entities() {
            let has_parts = self.changes.iter().any(|change| match change {
                Change::Part {
                    entity: e,
                    before,
                    after,
                    ..
                } => *e == entity && if side == Way::Back { before } else { after }.is_some(),
                Change::Field { entity: e, .. } => *e == entity,
                Change::Order { .. } => false,
            });
            let is_empty = world
                .get_entity(entity)
                .is_ok_and(|found| found.archetype().components().is_empty());
            if !has_parts && is_empty {
                world.despawn(entity);
            }
        }
    }
}

/// Steps done, and steps undone that can be done again.
#[derive(Resource, Debug, Default)]
pub struct History {
    done: VecDeque<(u64, Step)>,
    undone: Vec<(u64, Step)>,
    /// The group that the last step belongs to, as long as it is open.
    group: Option<String>,
    /// The number of the last step there ever was: each state of the scene has that of the step that led to it.
    last: u64,
    /// The state below the oldest step that is kept.
    ground: u64,
    /// The state that the scene's file has.
    saved: u64,
}

impl History {
    /// Steps done, oldest first.
    pub fn done(&self) -> impl DoubleEndedIterator<Item = &Step> + ExactSizeIterator {
        self.done.iter().map(|(_, step)| step)
    }

    /// Steps that can be done again, the next one first.
    pub fn undone(&self) -> impl ExactSizeIterator<Item = &Step> {
        self.undone.iter().rev().map(|(_, step)| step)
    }

    /// A number of the scene's state: another one after every edit, the old one again after undo.
    pub fn state(&self) -> u64 {
        self.done.back().map_or(self.ground, |(number, _)| *number)
    }

    /// How many steps led here from a state; none: it is not one of those behind.
    pub fn steps_since(&self, state: u64) -> Option<usize> {
        if state == self.ground {
            return Some(self.done.len());
        }
        let from = self.done.iter().position(|(number, _)| *number == state);
        from.map(|from| self.done.len() - 1 - from)
    }

    /// Whether edits were made that the scene's file does not have.
    pub fn is_unsaved(&self) -> bool {
        self.saved != self.state()
    }

    /// The scene as it is now is what its file has.
    pub fn note_saved(&mut self) {
        self.saved = self.state();
        self.group = None;
    }

    /// The scene is another one than its file's though nothing was done to it: it was recovered.
    pub fn note_unsaved(&mut self) {
        self.saved = u64::MAX;
    }

    /// Nothing joins the last step any more: the drag is over.
    pub fn close_group(&mut self) {
        self.group = None;
    }

    /// Keeps a step, joined to the last one if both are of one open group; what is forgotten over it, and the side of each
    /// that the world stays on.
    fn keep(&mut self, step: Step, group: Option<String>) -> Vec<(Step, Way)> {
        let undone = self.undone.drain(..);
        let mut forgotten: Vec<(Step, Way)> = undone.map(|(_, step)| (step, Way::Back)).collect();
        self.last += 1;
        let joins = group.is_some() && group == self.group;
        match self.done.back_mut().filter(|_| joins) {
            Some((number, last)) => {
                *number = self.last;
                last.join(step);
            }
            None => self.done.push_back((self.last, step)),
        }
        self.group = group;
        if self.done.len() > STEPS
            && let Some((number, step)) = self.done.pop_front()
        {
            self.ground = number;
            forgotten.push((step, Way::Forth));
        }
        forgotten
    }
}

/// Runs a command and keeps it as a step; commands of the same open group become one. What it did besides.
///
/// # Errors
/// Why it cannot be done, as a sentence; the world is then as it was.
pub fn perform(
    world: &mut World,
    command: Command,
    name: Option<String>,
    group: Option<String>,
) -> Result<Outcome, String> {
    let name = name.unwrap_or_else(|| command.name(world));
    let (changes, outcome) = run::run(world, command)?;
    if !changes.is_empty() {
        let step = Step { name, changes };
        let forgotten = world.resource_mut::<History>().keep(step, group);
        for (step, side) in forgotten {
            step.forget(world, side);
        }
    }
    Ok(outcome)
}

/// Takes the last step back; its name.
pub fn undo(world: &mut World) -> Option<String> {
    let mut history = world.resource_mut::<History>();
    history.close_group();
    let (number, step) = history.done.pop_back()?;
    change::apply(world, &step.changes, Way::Back);
    let name = step.name.clone();
    world.resource_mut::<History>().undone.push((number, step));
    Some(name)
}

/// Does the step again that was undone last; its name.
pub fn redo(world: &mut World) -> Option<String> {
    let mut history = world.resource_mut::<History>();
    history.close_group();
    let (number, step) = history.undone.pop()?;
    change::apply(world, &step.changes, Way::Forth);
    let name = step.name.clone();
    world
        .resource_mut::<History>()
        .done
        .push_back((number, step));
    Some(name)
}

/// Forgets all steps: another scene is there.
pub fn clear(world: &mut World) {
    let old = std::mem::take(&mut *world.resource_mut::<History>());
    for (_, step) in old.undone {
        step.forget(world, Way::Back);
    }
    for (_, step) in old.done {
        step.forget(world, Way::Forth);
    }
}

#[cfg(test)]
mod tests;
