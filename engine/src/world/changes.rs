//! Whether any component of a kind changed, at the cost of a look a table.

use bevy_ecs::change_detection::ContiguousRef;
use bevy_ecs::prelude::*;
use bevy_ecs::query::ArchetypeFilter;

/// Whether a component changed since the system last ran: by the summary tick of each table where the component
/// keeps one, else by the ticks of its rows.
pub fn any_changed<T: Component, F: ArchetypeFilter>(query: &Query<Ref<T>, F>) -> bool {
    let Ok(mut tables) = query.contiguous_iter() else {
        return query.iter().any(|component| component.is_changed());
    };
    tables.any(|table| {
        let (_, ticks) = ContiguousRef::split(table);
        ticks
            .summary_tick_is_changed()
            .unwrap_or_else(|| ticks.is_changed_iter().any(|changed| changed))
    })
}
