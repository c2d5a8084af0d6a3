//! The benchmark `cpu`: rays by kind on the processor, on one thread and on all.
//!
//! Two meshes, of about 100,000 and 1,000,000 triangles, and the rays of a whole frame of each ([`super::trace`] has what
//! they are made of). Samples of all kinds and thread counts take turns, so that what else runs on the machine meets them
//! alike; `--dump` writes the same rays for other tracers.

mod meshes;

use glam::UVec2;
use orrery_engine::frame::TraceSettings;
use orrery_engine::trace::Tracer;
use rayon::ThreadPool;

use self::meshes::Plan;
use super::dump;
use super::rays::RaySet;
use super::report::{Better, Report, Row};
use super::timing::{median, pools, worked_seconds};
use super::trace::kinds;
use super::trace::rates::{flips, in_rows, kind_rows};
use super::trace::stage::Stage;
use crate::args::{BackendChoice, BenchRequest, Common};
use crate::device;
use crate::failure::Failure;
use crate::output::note;

const SIZE: UVec2 = UVec2::new(1024, 768);
/// Of a short run.
const SMALL_SIZE: UVec2 = UVec2::new(64, 48);
/// Rounds before the clock counts.
const WARM_UP: usize = 2;
/// Kinds that are timed.
const KINDS: [&str; 4] = ["primary", "shadow", "reflect", "diffuse"];

/// Measures every mesh.
pub fn run(request: &BenchRequest, common: &Common) -> Result<Report, Failure> {
    let plans = plans(request)?;
    let size = match (common.size, request.small) {
        (Some(size), _) => size,
        (None, true) => SMALL_SIZE,
        (None, false) => SIZE,
    };
    let mut tracer = device::open_choice(BackendChoice::Cpu, common)?;
    let mut reference = device::open_choice(BackendChoice::Reference, common)?;
    let pools = pools()?;
    let mut rows = Vec::new();
    for plan in plans {
        note(format_args!("rays on {}", plan.name));
        let stage = plan.stage().map_err(Failure::Input)?;
        let settings = TraceSettings {
            size,
            ..crate::stage::settings(common, size)
        };
        tracer.refit(&stage.work.frame)?;
        tracer.upload(&stage.work.frame, &settings)?;
        let mut sets = kinds::trace(&stage, size, tracer.as_mut())?;
        sets.retain(|set| KINDS.contains(&set.kind) && !set.rays.is_empty());
        if let Some(folder) = &request.dump {
            write(&folder.join(&stage.name), size, &stage, &sets)?;
        }
        rows.extend(rates(
            &stage.name,
            &sets,
            &pools,
            request.repeat as usize,
            tracer.as_mut(),
        )?);
        rows.extend(flips(
            &stage,
            &stage.name,
            &sets,
            reference.as_mut(),
            common,
        )?);
    }
    Ok(Report {
        rows,
        remarks: vec![format!(
            "rays of {}x{} pixels, in tiles of 8 x 8; 1t, {}t: threads; scaling: how many times the rate of one thread; rate_per_cpu: a second of a processor's work, whatever else runs",
            size.x,
            size.y,
            rayon::current_num_threads()
        )],
        ..Report::new("cpu", &[tracer.device()])
    })
}

/// The meshes that were asked for.
fn plans(request: &BenchRequest) -> Result<Vec<Plan>, Failure> {
    let all = if request.small {
        meshes::SMALL.to_vec()
    } else {
        meshes::FULL.to_vec()
    };
    let names: Vec<&str> = all.iter().map(|plan| plan.name).collect();
    if let Some(unknown) = request
        .suite
        .iter()
        .find(|name| !names.contains(&name.as_str()))
    {
        return Err(Failure::Usage(format!(
            "no mesh `{unknown}` in `cpu`; there is {}",
            names.join(", ")
        )));
    }
    let is_asked =
        |plan: &Plan| request.suite.is_empty() || request.suite.iter().any(|s| s == plan.name);
    Ok(all.into_iter().filter(is_asked).collect())
}

fn write(
    folder: &std::path::Path,
    size: UVec2,
    stage: &Stage,
    sets: &[RaySet],
) -> Result<(), Failure> {
    dump::write(folder, &stage.name, size, &stage.work, &in_rows(size, sets))
}

/// Times of every kind on every pool, in turn.
fn rates(
    name: &str,
    sets: &[RaySet],
    pools: &[ThreadPool],
    samples: usize,
    tracer: &mut dyn Tracer,
) -> Result<Vec<Row>, Failure> {
    let mut millis = vec![vec![Vec::with_capacity(samples); sets.len()]; pools.len()];
    let mut worked = millis.clone();
    for round in 0..WARM_UP + samples {
        for (number, pool) in pools.iter().enumerate() {
            for (kind, set) in sets.iter().enumerate() {
                let before = worked_seconds();
                let taken = pool.install(|| tracer.time_rays(&set.rays, set.query, 1))?;
                if round >= WARM_UP {
                    millis[number][kind].extend(taken);
                    let both = before.zip(worked_seconds());
                    worked[number][kind].extend(both.map(|(from, to)| (to - from) * 1e3));
                }
            }
        }
    }
    let mut rows = Vec::new();
    for (number, pool) in pools.iter().enumerate() {
        let threads = pool.current_num_threads();
        for (kind, set) in sets.iter().enumerate() {
            let name = format!("{name}.{threads}t.{}", set.kind);
            rows.extend(kind_rows(&name, set, &millis[number][kind]));
            // The system may not have counted a short job's work yet.
            let worked = worked[number][kind].iter().filter(|&&millis| millis > 0.0);
            let rates: Vec<f64> = worked
                .map(|millis| set.rays.len() as f64 / millis * 1e-3)
                .collect();
            if !rates.is_empty() {
                let name = format!("{name}.rate_per_cpu");
                rows.push(Row::sampled(name, "Mrays/s", Better::Higher, &rates));
            }
        }
    }
    if let [one, .., all] = &millis[..] {
        for ((set, one), all) in sets.iter().zip(one).zip(all) {
            rows.push(Row::single(
                format!("{name}.{}.scaling", set.kind),
                "1",
                Better::Higher,
                median(one) / median(all),
            ));
        }
    }
    Ok(rows)
}
