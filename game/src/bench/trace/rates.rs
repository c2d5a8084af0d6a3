//! What is known of a kind of rays: how fast they are answered, how many hit, and how many are answered wrong.

use glam::UVec2;
use orrery_engine::frame::TraceSettings;
use orrery_engine::trace::{Query, Tracer};

use super::kinds;
use super::stage::Stage;
use crate::args::Common;
use crate::bench::rays::RaySet;
use crate::bench::report::{Better, Row};
use crate::failure::Failure;

/// Rays of each kind that the reference answers too.
const CHECKED: usize = 20_000;

/// Time, rate, share of hits and number of a kind.
pub fn kind_rows(name: &str, set: &RaySet, millis: &[f64]) -> Vec<Row> {
    let rates: Vec<f64> = millis
        .iter()
        .map(|millis| set.rays.len() as f64 / millis * 1e-3)
        .collect();
    let hits = set.hits.iter().filter(|hit| match set.query {
        Query::Any => hit.instance == 1,
        Query::Closest | Query::Leave => hit.instance != u32::MAX,
    });
    let rate = hits.count() as f64 / set.rays.len() as f64 * 100.0;
    vec![
        Row::sampled(name, "ms", Better::Lower, millis),
        Row::sampled(format!("{name}.rate"), "Mrays/s", Better::Higher, &rates),
        Row::single(format!("{name}.hit_rate"), "%", Better::Higher, rate),
        Row::single(
            format!("{name}.count"),
            "rays",
            Better::Lower,
            set.rays.len() as f64,
        ),
    ]
}

/// Of rays that the reference answers too, how many of a kind hit where it misses or miss where it hits, per million.
pub fn flips(
    stage: &Stage,
    name: &str,
    sets: &[RaySet],
    reference: &mut dyn Tracer,
    common: &Common,
) -> Result<Vec<Row>, Failure> {
    let settings = TraceSettings {
        size: UVec2::ONE,
        ..crate::stage::settings(common, UVec2::ONE)
    };
    reference.refit(&stage.work.frame)?;
    reference.upload(&stage.work.frame, &settings)?;
    let mut rows = Vec::new();
    for set in sets {
        let step = (set.rays.len() / CHECKED).max(1);
        let rays: Vec<_> = set.rays.iter().copied().step_by(step).collect();
        let truth = reference.intersect(&rays, set.query)?;
        let pairs = truth.iter().zip(set.hits.iter().step_by(step));
        let flips = pairs
            .filter(|(a, b)| a.t.is_finite() != b.t.is_finite())
            .count();
        rows.push(Row::single(
            format!("{name}.{}.flips", set.kind),
            "ppm",
            Better::Lower,
            flips as f64 / rays.len().max(1) as f64 * 1e6,
        ));
    }
    Ok(rows)
}

/// The same sets with primary rays in rows of pixels, as the dump format has them.
pub fn in_rows(size: UVec2, sets: &[RaySet]) -> Vec<RaySet> {
    let mut sets: Vec<RaySet> = sets.to_vec();
    if let Some(primary) = sets.first_mut() {
        let tiled = primary.clone();
        for (i, pixel) in kinds::tiles(size).enumerate() {
            primary.rays[pixel] = tiled.rays[i];
            primary.hits[pixel] = tiled.hits[i];
        }
    }
    sets
}
