//! Hands values down the hierarchy, touching changed subtrees only.
//!
//! One mechanism serves every inherited value ([`Inherited`]): poses and visibility. The cost is that
//! of finding the changed rows plus the subtrees below them; an unchanged subtree is not visited.

use bevy_ecs::component::Mutable;
use bevy_ecs::prelude::*;

/// A derived component that a child composes from its parent's.
pub trait Inherited: Component<Mutability = Mutable> + PartialEq + Copy {
    /// The component that people write.
    type Local: Component;
    /// A second, optional component that takes part.
    type Extra: Component;

    /// The child's value from its parent's (none at a root) and its own components.
    fn compose(parent: Option<&Self>, local: &Self::Local, extra: Option<&Self::Extra>) -> Self;
}

type Dirty<T> = Or<(
    Changed<<T as Inherited>::Local>,
    Changed<<T as Inherited>::Extra>,
    Changed<ChildOf>,
    Added<T>,
)>;

/// Recomputes `T` for every entity whose local value, extra or parent changed, and for all below it.
///
/// A value that comes out equal is not written, so it does not count as changed further on.
pub fn propagate<T: Inherited>(
    mut access: ParamSet<(Query<Entity, (With<T::Local>, Dirty<T>)>, Query<&mut T>)>,
    mut orphans: RemovedComponents<ChildOf>,
    mut unsheared: RemovedComponents<T::Extra>,
    parents: Query<&ChildOf>,
    locals: Query<(&T::Local, Option<&T::Extra>, Option<&Children>)>,
) {
    let mut roots: Vec<Entity> = access.p0().iter().collect();
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
