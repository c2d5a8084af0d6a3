//! What a frame cost: work alone, without the time that it waited for the display.
//!
//! A GPU works alongside the host, so a frame takes as long as the slower of the two; a "GPU" that is a program on the
//! processor shares its cores with the host, and both add up. Where the device has timestamps its work is known by them.

use crate::trace::{PictureTime, Tracer};

/// Milliseconds of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Work {
    /// All of it.
    pub frame: f64,
    /// What of it would be the same for a picture of another size.
    pub rest: f64,
    /// The picture, if one from its start was timed in this frame.
    pub picture: Option<PictureTime>,
}

impl Work {
    /// Of a frame whose host worked for `host` milliseconds, and whose presenting took the device `present`.
    pub fn of(tracer: &dyn Tracer, host: f64, present: f64) -> Self {
        let picture = tracer.timed_picture();
        let device = tracer.device_millis().unwrap_or(0.0) + present;
        let rays = picture.map_or(0.0, |picture| picture.rays);
        let (frame, with_rays) = if tracer.runs_on_processor() {
            (host + device, host + device)
        } else {
            (host.max(device), device)
        };
        Self {
            frame,
            rest: (with_rays - rays).max(0.0),
            picture,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{FrameScene, TraceSettings};
    use crate::trace::cpu::CpuTracer;
    use glam::UVec2;

    #[test]
    fn only_pictures_from_the_start_are_timed_and_the_rest_is_what_is_not_rays() {
        let scene = FrameScene::default();
        let settings = TraceSettings {
            size: UVec2::splat(8),
            refine_to: 4,
            ..Default::default()
        };
        let mut tracer = CpuTracer::new();
        let mut timed = [false; 8];
        for frame in &mut timed {
            tracer.refit(&scene).unwrap();
            tracer.upload(&scene, &settings).unwrap();
            tracer.render().unwrap();
            let work = Work::of(&tracer, 100.0, 3.0);
            *frame = work.picture.is_some();
            let rays = work.picture.map_or(0.0, |picture| picture.rays);
            assert_eq!((work.frame, work.rest), (103.0, 103.0 - rays));
        }
        assert_eq!(timed, [0, 1, 2, 3, 4, 5, 6, 7].map(|frame| frame == 0));
    }
}
