//! `orrery render SCENE --explain X,Y`: the ray tree of a pixel as text, by the f64 reference.

use bevy_ecs::prelude::*;
use glam::{DVec3, UVec2};
use orrery_engine::Engine;
use orrery_engine::frame::{FrameScene, TraceSettings};
use orrery_engine::trace::Tracer;
use orrery_engine::trace::reference::{ExplainedRay, Explanation, Fate, RayKind, ReferenceTracer};
use orrery_engine::world::SceneId;

use crate::args::{Common, RenderRequest};
use crate::failure::Failure;
use crate::output::{note, say};
use crate::stage;

/// Lines printed at most; a picture of many lamps in many mirrors has more rays than anyone reads.
const MOST_LINES: usize = 2000;

/// Prints the tree of a pixel of the first frame that was asked for.
pub fn run(
    pixel: UVec2,
    request: &RenderRequest,
    common: &Common,
    size: UVec2,
) -> Result<(), Failure> {
    let frame = request.frames.start;
    let (mut engine, _) = stage::open(&request.scene, common, size, request.fps)?;
    stage::advance(&mut engine, frame)?;
    let world = &engine.world;
    let (scene, settings) = (
        world.resource::<FrameScene>(),
        world.resource::<TraceSettings>(),
    );
    let mut tracer = ReferenceTracer::new();
    tracer.refit(scene)?;
    tracer.upload(scene, settings)?;
    let explained = tracer.explain(pixel).ok_or_else(|| {
        let last = settings.size - 1;
        Failure::Usage(format!(
            "--explain {},{}: the picture's pixels are 0,0 to {},{}",
            pixel.x, pixel.y, last.x, last.y
        ))
    })?;
    for line in tree(&explained, &engine) {
        say(line);
    }
    let counters = &explained.counters;
    let boxes: u64 = explained.rays.iter().map(|ray| u64::from(ray.boxes)).sum();
    let shapes: u64 = explained.rays.iter().map(|ray| u64::from(ray.shapes)).sum();
    note(format_args!(
        "{} rays: {} camera, {} mirrored, {} refracted, {} shadow; {boxes} boxes and {shapes} shapes of the reference's trees",
        counters.rays(),
        counters.primary_rays,
        counters.reflected_rays,
        counters.refracted_rays,
        counters.shadow_rays
    ));
    Ok(())
}

/// The lines of the tree: what the pixel is, then each ray below what sent it.
fn tree(explained: &Explanation, engine: &Engine) -> Vec<String> {
    let Explanation {
        pixel, size, color, ..
    } = explained;
    let mut lines = vec![format!(
        "pixel {},{} of {}x{}: {}",
        pixel.x,
        pixel.y,
        size.x,
        size.y,
        rgb(*color)
    )];
    let rays = &explained.rays;
    // Whether each depth has another ray to come, for the lines of the tree.
    for (i, ray) in rays.iter().enumerate().take(MOST_LINES) {
        let mut branch = String::new();
        for depth in 1..=ray.depth {
            let is_own = depth == ray.depth;
            branch += match (goes_on(rays, i, depth), is_own) {
                (true, true) => "├─ ",
                (false, true) => "└─ ",
                (true, false) => "│  ",
                (false, false) => "   ",
            };
        }
        lines.push(branch + &words(explained, i, engine));
    }
    let more = explained.left_out + rays.len().saturating_sub(MOST_LINES) as u64;
    if more > 0 {
        lines.push(format!("and {more} rays more"));
    }
    lines
}

/// Whether after ray `i` there is another one at this depth below the same parent.
fn goes_on(rays: &[ExplainedRay], i: usize, depth: usize) -> bool {
    let later = rays[i + 1..].iter();
    let mut below = later.take_while(|other| other.depth >= depth);
    below.any(|other| other.depth == depth)
}

/// A ray in a line.
fn words(explained: &Explanation, i: usize, engine: &Engine) -> String {
    let ray = &explained.rays[i];
    let kind = match ray.kind {
        RayKind::Camera(sample) => format!("camera, sample {sample}"),
        RayKind::Mirrored => "mirrored".into(),
        RayKind::Refracted => "refracted".into(),
        RayKind::Straight => "straight on".into(),
        RayKind::Shadow(light) => format!("to light {light}"),
    };
    let is_shadow = matches!(ray.kind, RayKind::Shadow(_));
    let fate = match ray.fate {
        Fate::NotFollowed => "not followed: past the last generation".into(),
        Fate::Missed if is_shadow => "nothing in the way".into(),
        Fate::Missed => "the background".into(),
        Fate::Met { t, instance, .. } => {
            format!("{} at {t:.4}", name(instance, engine))
        }
    };
    let below = explained.added_below(i);
    let own = match below == ray.added {
        true => format!("adds {}", rgb(ray.added)),
        false => format!("adds {}, with all below {}", rgb(ray.added), rgb(below)),
    };
    format!(
        "{kind} -> {fate}; weight {}; {own}; {} boxes, {} shapes",
        rgb(ray.weight),
        ray.boxes,
        ray.shapes
    )
}

/// What an instance is called in the scene's file, and what it is there.
fn name(instance: u32, engine: &Engine) -> String {
    let scene = engine.world.resource::<FrameScene>();
    let row = scene.instances.get(instance as usize);
    let entity = row.and_then(|row| Entity::try_from_bits(row.tag));
    let id = entity.and_then(|entity| engine.world.get::<SceneId>(entity));
    id.map_or_else(|| format!("thing {instance}"), |id| format!("`{}`", id.0))
}

/// Red, green, blue with what digits matter.
fn rgb(color: DVec3) -> String {
    let [r, g, b] = color.to_array().map(|channel| {
        let text = format!("{channel:.4}");
        match text.as_str() {
            "0.0000" if channel > 0.0 => format!("{channel:.0e}"),
            _ => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        }
    });
    format!("({r} {g} {b})")
}
