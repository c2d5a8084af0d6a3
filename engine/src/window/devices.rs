//! The devices of a window: the one that presents, the one that traces (often the same), and both again after a loss.
//!
//! A driver that resets, or a GPU that is unplugged, takes the device and all that was on it, and nothing of the world: that is
//! on the host. So another device is opened, the window gets a new surface on it, and the tracer brings it all its rows.

use std::sync::Arc;
use std::time::{Duration, Instant};

use bevy_ecs::prelude::*;
use glam::UVec2;
use winit::window::Window;

use super::{WindowError, WindowOptions};
use crate::editor::Notices;
use crate::present::Screen;
use crate::trace::gpu::Gpu;
use crate::trace::{ActiveTracer, Backend, BackendChoice, TraceError, open_tracer};

/// Failures that end the run when they come close together: one may be a passing hiccup of the driver.
const TOLERATED: u32 = 8;
/// Frames that must go well before failures are forgotten: a loss shows some frames after its cause.
const FORGOTTEN_AFTER: u32 = 60;
/// Before the first attempt to go on after a loss; it doubles with each failure. Drivers take seconds to reset.
const FIRST_PAUSE: Duration = Duration::from_millis(100);
/// It doubles so often at most.
const DOUBLINGS: u32 = 5;

/// Whether the device that presents traces as well.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sharing {
    /// The picture need not leave it.
    Shared,
    /// Another device traces, or the host.
    Apart,
}

/// Opens the device that presents to the window, and its surface.
///
/// # Errors
/// [`WindowError::NoDisplay`].
pub fn open_screen(
    window: &Arc<Window>,
    options: &WindowOptions,
) -> Result<(Arc<Gpu>, Screen), WindowError> {
    let no_display = |why: String| WindowError::NoDisplay(why);
    let instance = Gpu::instance();
    let surface = instance
        .create_surface(window.clone())
        .map_err(|error| no_display(format!("nothing can draw to the window: {error}")))?;
    let mut gpu = Gpu::open(instance, &options.presenting_adapter(), Some(&surface))
        .map_err(|error| no_display(error.to_string()))?;
    if let Some(folder) = &options.pipelines {
        gpu.keep_pipelines_in(folder);
    }
    let gpu = Arc::new(gpu);
    let size = inner_size(window);
    let screen = Screen::new(gpu.clone(), window.clone(), surface, size, options.vsync)
        .map_err(|error| no_display(error.to_string()))?;
    Ok((gpu, screen))
}

/// Gives the world the tracer of the run, unless it has one.
///
/// # Errors
/// [`WindowError::NoTracer`].
pub fn give_tracer(
    world: &mut World,
    options: &WindowOptions,
    gpu: &Arc<Gpu>,
) -> Result<Sharing, WindowError> {
    if world.resource::<ActiveTracer>().0.is_some() {
        return Ok(Sharing::Apart);
    }
    let (choice, adapter) = (options.backend, options.adapter.as_deref());
    let (mut tracer, note) =
        open_tracer(choice, adapter, Some(gpu.clone())).map_err(WindowError::NoTracer)?;
    // Software Vulkan compiles where a kernel first runs, and everything waits for that whoever asked.
    if !tracer.runs_on_processor() {
        tracer.compile_in_background();
    }
    if let Some(note) = note {
        // Not by default what one would expect: the default level of the log shows it.
        tracing::warn!("{note}");
        world.resource_mut::<Notices>().toast(note);
    }
    // By itself, a hardware GPU is preferred over the software adapter that presents.
    let elsewhere = choice == BackendChoice::Auto && adapter.is_none() && gpu.is_software();
    let is_shared = tracer.backend() == Backend::Gpu && !elsewhere;
    world.resource_mut::<ActiveTracer>().0 = Some(tracer);
    Ok(if is_shared {
        Sharing::Shared
    } else {
        Sharing::Apart
    })
}

/// Opens anew what was lost. Where it fails, the world is as it was but may have no [`Screen`]: it can be tried again.
///
/// # Errors
/// [`TraceError::NoDevice`]: what was lost is not there again, or not yet.
pub fn recover(
    world: &mut World,
    window: &Arc<Window>,
    options: &WindowOptions,
    sharing: Sharing,
) -> Result<(), TraceError> {
    let presents = world
        .get_resource::<Screen>()
        .is_some_and(|screen| !screen.is_lost());
    if presents {
        return recover_tracer(world, None);
    }
    // The old surface goes first: a window has one at a time.
    drop(world.remove_resource::<Screen>());
    let (gpu, mut screen) = open_screen(window, options)
        .map_err(|error| TraceError::NoDevice(format!("the GPU did not come back: {error}")))?;
    if sharing == Sharing::Shared {
        screen.share_device();
        // Without a screen there is no going on: this is to be tried again, whatever it was.
        recover_tracer(world, Some(gpu)).map_err(|error| {
            TraceError::NoDevice(format!("the GPU came back, but not its tracer: {error}"))
        })?;
    }
    world.insert_resource(screen);
    Ok(())
}

fn recover_tracer(world: &mut World, gpu: Option<Arc<Gpu>>) -> Result<(), TraceError> {
    match &mut world.resource_mut::<ActiveTracer>().0 {
        Some(tracer) => tracer.recover(gpu),
        None => Ok(()),
    }
}

/// Pixels of the window; zero where it is minimised.
pub fn inner_size(window: &Window) -> UVec2 {
    let size = window.inner_size();
    UVec2::new(size.width, size.height)
}

/// Failures of devices that came close together, and when to try again after a loss.
#[derive(Clone, Copy, Debug, Default)]
pub struct Failures {
    count: u32,
    /// Frames that went well since the last.
    good: u32,
    /// When what was lost is to be opened anew.
    pub retry_at: Option<Instant>,
}

impl Failures {
    /// A frame went well.
    pub fn note_success(&mut self) {
        self.good += 1;
        if self.good >= FORGOTTEN_AFTER {
            self.count = 0;
        }
    }

    /// Something failed; an error: that was once too often.
    ///
    /// # Errors
    /// The failure.
    pub fn note_failure(&mut self, error: TraceError, now: Instant) -> Result<(), TraceError> {
        tracing::warn!("{error}");
        self.good = 0;
        self.count += 1;
        if self.count > TOLERATED {
            return Err(error);
        }
        let is_gone = matches!(error, TraceError::DeviceLost(_) | TraceError::NoDevice(_));
        let pause = FIRST_PAUSE * (1 << (self.count - 1).min(DOUBLINGS));
        self.retry_at = is_gone.then_some(now + pause);
        Ok(())
    }
}

/// What counts as a failing device: whatever presenting says, and of tracing only the device's own faults. A scene that is
/// too large for it is none: the window says so and goes on. A loss is told first.
pub fn device_failure(
    presenting: Option<TraceError>,
    tracing: Option<TraceError>,
) -> Option<TraceError> {
    let tracing = tracing.filter(|fault| !matches!(fault, TraceError::TooLarge(_)));
    let is_loss = |fault: &TraceError| matches!(fault, TraceError::DeviceLost(_));
    match (presenting, tracing) {
        (Some(_), Some(loss)) if is_loss(&loss) => Some(loss),
        (presenting, tracing) => presenting.or(tracing),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn device() -> Option<TraceError> {
        Some(TraceError::Device("a hiccup".into()))
    }

    fn lost() -> Option<TraceError> {
        Some(TraceError::DeviceLost("unplugged".into()))
    }

    #[test]
    fn a_tracer_that_fails_counts_and_a_scene_too_large_does_not() {
        let large = || Some(TraceError::TooLarge("too many triangles".into()));
        assert_eq!(device_failure(None, device()), device());
        assert_eq!(device_failure(device(), large()), device());
        assert_eq!(device_failure(device(), lost()), lost());
        assert_eq!(device_failure(lost(), device()), lost());
        assert_eq!(device_failure(None, large()), None);
        assert_eq!(device_failure(None, None), None);
    }

    #[test]
    fn a_loss_is_tried_again_ever_later_and_a_hiccup_is_not() {
        let now = Instant::now();
        let mut failures = Failures::default();
        let pauses = [(); 8].map(|()| {
            failures.note_failure(lost().unwrap(), now).unwrap();
            failures.retry_at.unwrap() - now
        });
        let expected = [1, 2, 4, 8, 16, 32, 32, 32].map(|times| times * FIRST_PAUSE);
        assert_eq!(pauses, expected);
        assert_eq!(
            failures.note_failure(lost().unwrap(), now),
            Err(lost().unwrap())
        );
        let mut failures = Failures::default();
        failures.note_failure(device().unwrap(), now).unwrap();
        assert_eq!(failures.retry_at, None);
    }

    /// A scene that resets the driver in every picture shows it some frames later, every time.
    #[test]
    fn failures_with_some_good_frames_between_them_still_end_the_run() {
        let now = Instant::now();
        let mut failures = Failures::default();
        let survived = |failures: &mut Failures, good: u32| {
            (0..100)
                .take_while(|_| {
                    (0..good).for_each(|_| failures.note_success());
                    failures.note_failure(lost().unwrap(), now).is_ok()
                })
                .count()
        };
        assert_eq!(survived(&mut failures, 5), TOLERATED as usize);
        assert_eq!(survived(&mut Failures::default(), FORGOTTEN_AFTER), 100);
    }
}
