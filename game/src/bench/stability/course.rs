//! [`Course`]: what a suite is given: a tracer, how much to try, and where its rows go.

use glam::{DAffine3, UVec2};
use orrery_engine::frame::{Features, FrameScene, Instance, Kernels, Shape, TraceSettings};
use orrery_engine::trace::{Picture, Tracer};
use orrery_engine::world::Material;

use super::tally::Tally;
use crate::args::BenchRequest;
use crate::bench::report::{Better, Row, Trial};
use crate::failure::Failure;
use crate::stage::traced;

/// What share of its known failures a form must show here, on other meshes and devices.
const LEAST_OF_KNOWN: f64 = 0.1;

/// See the module.
pub struct Course<'a> {
    /// What is tried.
    pub tracer: Box<dyn Tracer>,
    /// What came of it.
    pub rows: Vec<Row>,
    /// What is to be said of it.
    pub remarks: Vec<String>,
    request: &'a BenchRequest,
}

impl<'a> Course<'a> {
    /// Without rows yet.
    pub fn new(tracer: Box<dyn Tracer>, request: &'a BenchRequest) -> Self {
        Self {
            tracer,
            rows: Vec::new(),
            remarks: Vec::new(),
            request,
        }
    }

    /// The tracer's word.
    pub fn backend(&self) -> String {
        self.tracer.backend().to_string()
    }

    /// Rays of an aim: what was asked for, else the usual number, or a hundredth of it where little is to be done.
    pub fn rays(&self, usual: u64) -> u64 {
        self.request.rays.unwrap_or(self.brief(usual))
    }

    /// A number of scenes or frames: the usual one, or a hundredth; `long` where rays without end are asked for.
    pub fn scenes(&self, usual: u64, long: u64) -> u64 {
        match self.request.rays {
            Some(rays) if rays >= 10_000_000 => long,
            _ => self.brief(usual),
        }
    }

    /// The usual number, or a hundredth of it where little is to be done.
    pub fn brief(&self, usual: u64) -> u64 {
        if self.request.small {
            (usual / 100).max(1)
        } else {
            usual
        }
    }

    /// Brings a frame to the tracer.
    ///
    /// # Errors
    /// Those of the tracer.
    pub fn upload(&mut self, scene: &FrameScene, kernels: Kernels) -> Result<(), Failure> {
        let settings = settings(UVec2::ONE, kernels);
        self.tracer.refit(scene)?;
        Ok(self.tracer.upload(scene, &settings)?)
    }

    /// A picture of a frame.
    ///
    /// # Errors
    /// Those of the tracer.
    pub fn picture(
        &mut self,
        scene: &FrameScene,
        size: UVec2,
        kernels: Kernels,
    ) -> Result<Picture, Failure> {
        traced(self.tracer.as_mut(), scene, &settings(size, kernels))
    }

    /// A row that must show no failure.
    pub fn none_may_fail(&mut self, name: &str, tally: &Tally) {
        let row = tally.row(self.name(name));
        self.push(row, Some(0.0), tally);
    }

    /// A row of a form that is known to fail, which must: at least a tenth as often as it does elsewhere, if that
    /// is known.
    pub fn must_fail(&mut self, name: &str, tally: &Tally, known_ppm: Option<f64>) {
        let row = tally.row(self.name(name));
        let row = Row {
            better: Better::Higher,
            trial: row.trial.map(|trial| Trial { known_ppm, ..trial }),
            ..row
        };
        let known = known_ppm.unwrap_or(0.0) * 1e-6 * tally.tried as f64;
        self.push(row, Some((known * LEAST_OF_KNOWN).floor().max(1.0)), tally);
    }

    /// A row of a number that these tries came to, which may be at most `target`.
    pub fn at_most(
        &mut self,
        name: &str,
        unit: &'static str,
        tally: &Tally,
        value: f64,
        target: Option<f64>,
    ) {
        let row = tally.row_of(self.name(name), unit, value);
        self.push(row, target, tally);
    }

    fn name(&self, name: &str) -> String {
        format!("{name}.{}", self.backend())
    }

    /// A row whose target is missed, whatever its value, where too few of its tries count.
    fn push(&mut self, row: Row, target: Option<f64>, tally: &Tally) {
        let row = match target {
            Some(target) => row.with_target(target),
            None => row,
        };
        let met = row.met.map(|met| met && tally.is_telling());
        if !tally.is_telling() {
            let (name, tried, void) = (&row.name, tally.tried, tally.void);
            self.remarks.push(format!(
                "{name}: only {tried} of {} tries count, too few",
                tried + void
            ));
        }
        self.rows.push(Row { met, ..row });
    }
}

/// How a suite traces.
pub fn settings(size: UVec2, kernels: Kernels) -> TraceSettings {
    TraceSettings {
        size,
        kernels,
        ..TraceSettings::default()
    }
}

/// A frame of these shapes, all of the default material.
pub fn scene_of(shapes: impl IntoIterator<Item = (Shape, DAffine3)>) -> FrameScene {
    let mut scene = FrameScene {
        materials: vec![Material::default()].into(),
        max_generations: 1,
        ..FrameScene::default()
    };
    for (shape, world_from_local) in shapes {
        scene.instances.push(Instance {
            tag: 0,
            shape,
            world_from_local,
            material: 0,
        });
    }
    scene
}

/// The same once its meshes and lights are there.
pub fn ready(mut scene: FrameScene) -> FrameScene {
    scene.features = Features::of(&scene);
    scene
}

#[cfg(test)]
mod tests {
    use orrery_engine::trace::cpu::CpuTracer;

    use super::*;

    #[test]
    fn nothing_tried_is_not_met_and_known_forms_fail_about_as_often() {
        #[derive(clap::Parser)]
        struct Line {
            #[command(flatten)]
            request: BenchRequest,
        }
        let Line { request } = clap::Parser::parse_from(["bench"]);
        let mut course = Course::new(Box::new(CpuTracer::new()), &request);
        course.none_may_fail("empty", &Tally::default());
        course.at_most("none", "ULP", &Tally::default(), 0.0, Some(1.0));
        course.none_may_fail("good", &Tally::counted(10, 0));
        course.must_fail("seldom", &Tally::counted(1000, 1), Some(1e5));
        course.must_fail("often", &Tally::counted(1000, 20), Some(1e5));
        course.must_fail("unknown", &Tally::counted(1000, 1), None);
        let met: Vec<_> = course
            .rows
            .iter()
            .map(|row| row.met == Some(true))
            .collect();
        assert_eq!(met, [false, false, true, false, true, true]);
        assert_eq!(course.remarks.len(), 2);
    }
}
