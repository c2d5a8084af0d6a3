//! `orrery render SCENE --heat KIND`: what each pixel costs, in colours, counted by the f64 reference.

use glam::UVec2;
use orrery_engine::frame::{FrameScene, TraceSettings};
use orrery_engine::present::Developed;
use orrery_engine::trace::Tracer;
use orrery_engine::trace::reference::{Heat, ReferenceTracer};
use orrery_engine::world::ToneMap;

use crate::args::{Common, RenderRequest};
use crate::failure::Failure;
use crate::output::{progress, say};
use crate::stage;

/// Writes a picture of heat for each frame that was asked for.
pub fn run(
    heat: Heat,
    request: &RenderRequest,
    common: &Common,
    size: UVec2,
) -> Result<(), Failure> {
    if !request.out.is_png() {
        return Err(Failure::Usage(
            "`--heat` writes colours for a display: it is for .png files".into(),
        ));
    }
    let (mut engine, _) = stage::open(&request.scene, common, size, request.fps)?;
    let mut tracer = ReferenceTracer::new();
    let frames = request.frames.clone();
    let bar = progress(frames.end - frames.start, "counting");
    let mut said = Vec::new();
    for frame in frames {
        stage::advance(&mut engine, frame)?;
        let scene = engine.world.resource::<FrameScene>();
        tracer.refit(scene)?;
        tracer.upload(scene, engine.world.resource::<TraceSettings>())?;
        let survey = tracer.survey(1);
        let developed = Developed::new(&survey.picture(heat), 0.0, ToneMap::Clip);
        request.out.write_developed(frame, &developed)?;
        let (most, mean) = survey.range(heat);
        let path = request.out.path(frame);
        said.push(format!(
            "{}: {heat} a pixel, {mean:.1} on average, at most {most} (white)",
            path.display()
        ));
        bar.inc(1);
    }
    bar.finish_and_clear();
    said.iter().for_each(say);
    Ok(())
}
