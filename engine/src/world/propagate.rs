//! Hands values down the hierarchy, touching changed subtrees only.
//!
//! One mechanism serves every inherited value ([`Inherited`]): poses and visibility. The cost is that
//! of finding the changed rows plus the subtrees below them; an unchanged subtree is not visited.

use bevy_ecs::change_detection::{ContiguousRef, Tick};
use bevy_ecs::component::Mutable;
use bevy_ecs::prelude::*;

use super::{Transform, Visibility, any_changed, write_rows};

/// A derived component that a child composes from its parent's.
pub trait Inherited: Component<Mutability = Mutable> + PartialEq + Copy + Send + Sync {
    /// The component that people write.
    type Local: Component + Sync;
    /// A second, optional component that takes part.
    type Extra: Component + Sync;

    /// The child's value from its parent's (none at a root) and its own components.
    fn compose(parent: Option<&Self>, local: &Self::Local, extra: Option<&Self::Extra>) -> Self;
}

type Dirty<T> = Or<(
    Changed<<T as Inherited>::Local>,
    Changed<<T as Inherited>::Extra>,
    Added<T>,
)>;
/// Entities with neither parent nor children: most, where there are many.
type Alone = (Without<ChildOf>, Without<Children>);
type Related = Or<(With<ChildOf>, With<Children>)>;

/// A new parent is a change of all that is inherited.
pub fn mark_reparented(
    event: On<Insert<ChildOf>>,
    mut locals: Query<(Option<&mut Transform>, Option<&mut Visibility>)>,
) {
    if let Ok((transform, visibility)) = locals.get_mut(event.entity) {
        transform
            .into_iter()
            .for_each(|mut local| local.set_changed());
        visibility
            .into_iter()
            .for_each(|mut local| local.set_changed());
    }
}

/// [`propagate`] for entities without relatives: table by table, in parallel where that pays.
pub fn propagate_alone<T: Inherited>(
    locals: Query<Ref<T::Local>, Alone>,
    extras: Query<Ref<T::Extra>, Alone>,
    mut rows: Query<(Ref<T::Local>, Option<Ref<T::Extra>>, &mut T), Alone>,
) {
    if !any_changed(&locals) && !any_changed(&extras) {
        return;
    }
    let Ok(tables) = rows.contiguous_iter_mut() else {
        unreachable!("inherited components are stored in tables");
    };
    for (locals, extras, globals) in tables {
        let (locals, ticks) = ContiguousRef::split(locals);
        let extras = extras.map(ContiguousRef::split);
        let (last_run, this_run) = (ticks.last_run(), ticks.this_run());
        let is_new = |tick: Tick| tick.is_newer_than(last_run, this_run);
        let is_extra_new = |row: usize| {
            extras
                .as_ref()
                .is_some_and(|(_, ticks)| is_new(ticks.changed()[row]))
        };
        // A row is there from its first frame on with its local value, so what was added was changed.
        write_rows(globals, |row| {
            (is_new(ticks.changed()[row]) || is_extra_new(row)).then(|| {
                let extra = extras.as_ref().map(|(values, _)| &values[row]);
                T::compose(None, &locals[row], extra)
            })
        });
    }
}

/// Recomputes `T` for every entity whose local value, extra or parent changed, and for all below it.
///
/// A value that comes out equal is not written, so it does not count as changed further on.
pub fn propagate<T: Inherited>(
    watch: (Query<Ref<T::Local>, Related>, Query<Ref<T::Extra>, Related>),
    mut access: ParamSet<(
        Query<Entity, (With<T::Local>, Related, Dirty<T>)>,
        Query<&mut T>,
    )>,
    mut orphans: RemovedComponents<ChildOf>,
    mut unsheared: RemovedComponents<T::Extra>,
    parents: Query<&ChildOf>,
    locals: Query<(&T::Local, Option<&T::Extra>, Option<&Children>)>,
) {
    let mut roots: Vec<Entity> = Vec::new();
    if any_changed(&watch.0) || any_changed(&watch.1) {
        roots.extend(access.p0().iter());
    }
    roots.extend(orphans.read().filter(|&e| locals.contains(e)));
    roots.extend(unsheared.read().filter(|&e| locals.contains(e)));
    if roots.is_empty() {
        return;
    }
    roots.sort_unstable();
    roots.dedup();
    let topmost: Vec<Entity> = roots
        .iter()
        .copied()
        .filter(|&e| {
            !parents
                .iter_ancestors(e)
                .any(|ancestor| roots.binary_search(&ancestor).is_ok())
        })
        .collect();
    let mut globals = access.p1();
    let mut pending: Vec<(Entity, Option<T>)> = topmost
        .into_iter()
        .map(|e| {
            let parent = parents.get(e).ok().map(ChildOf::parent);
            (e, parent.and_then(|p| globals.get(p).ok().copied()))
        })
        .collect();
    while let Some((entity, parent)) = pending.pop() {
        let Ok((local, extra, children)) = locals.get(entity) else {
            continue;
        };
        let value = T::compose(parent.as_ref(), local, extra);
        if let Ok(mut global) = globals.get_mut(entity) {
            global.set_if_neq(value);
        }
        if let Some(children) = children {
            pending.extend(children.iter().map(|child| (child, Some(value))));
        }
    }
}
