//! The event loop's side: opens the window when the system says so, runs one frame a redraw.

use std::sync::Arc;
use std::time::Instant;

use bevy_ecs::change_detection::{DetectChangesMut, Mut};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{DeviceEvent, DeviceId, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::window::{Fullscreen, Window, WindowId};

use super::commands::{Requests, screenshot_path};
use super::devices::{
    Failures, Sharing, device_failure, give_tracer, inner_size, open_screen, recover,
};
use super::dropped::Dropped;
use super::resolution::Resolution;
use super::router::{self, Router};
use super::title::{Caption, Title};
use super::work::Work;
use super::{WindowError, WindowOptions};
use crate::app::Engine;
use crate::editor::{self, Document, EditorState, History, Notices, theme};
use crate::frame::TraceSettings;
use crate::input::Input;
use crate::present::{Screen, Screenshot, Ui};
use crate::time::Time;
use crate::trace::{ActiveTracer, TraceFault};

/// A window that is open.
struct Open {
    window: Arc<Window>,
    router: Router,
    resolution: Resolution,
    title: Title,
    device: String,
    hidden: bool,
    sharing: Sharing,
    /// Largest texture that the overlay may ask for.
    texture_side: usize,
    failures: Failures,
}

/// The engine, and its window once there is one.
pub struct WindowApp<'a> {
    engine: Engine,
    options: WindowOptions,
    observer: &'a mut dyn FnMut(&Engine),
    open: Option<Open>,
    dropped: Dropped,
    error: Option<WindowError>,
}

impl<'a> WindowApp<'a> {
    /// An engine whose window is yet to open, and who looks at it after each frame.
    pub fn new(
        mut engine: Engine,
        options: WindowOptions,
        observer: &'a mut dyn FnMut(&Engine),
    ) -> Self {
        let world = &mut engine.world;
        world.insert_resource(options.key_map.clone());
        world.resource_mut::<EditorState>().panels = options.show_editor;
        if let Some(file) = &options.file {
            world.insert_resource(Document::of(file));
        }
        world.resource_mut::<Notices>().issues = options.issues.clone();
        Self {
            engine,
            options,
            observer,
            open: None,
            dropped: Dropped::default(),
            error: None,
        }
    }

    /// Why the run ended, if not because the window was closed.
    pub fn take_error(&mut self) -> Option<WindowError> {
        self.error.take()
    }

    fn fail(&mut self, event_loop: &ActiveEventLoop, error: WindowError) {
        self.error.get_or_insert(error);
        event_loop.exit();
    }

    /// Opens window, device and tracer.
    fn open(&mut self, event_loop: &ActiveEventLoop) -> Result<Open, WindowError> {
        let no_display = |why: String| WindowError::NoDisplay(why);
        let size = self.options.size;
        let attributes = Window::default_attributes()
            .with_title(self.options.title.clone())
            .with_inner_size(PhysicalSize::new(size.x, size.y));
        let window = event_loop
            .create_window(attributes)
            .map_err(|error| no_display(format!("the window cannot open: {error}")))?;
        let window = Arc::new(window);
        let (gpu, mut screen) = open_screen(&window, &self.options)?;
        let sharing = give_tracer(&mut self.engine.world, &self.options, &gpu)?;
        if sharing == Sharing::Shared {
            screen.share_device();
        }
        self.engine.world.insert_resource(screen);
        let context = self.engine.world.resource::<Ui>().context().clone();
        theme::apply(&context);
        let texture_side = gpu.device.limits().max_texture_dimension_2d as usize;
        let overlay_input = egui_winit::State::new(
            context,
            egui::ViewportId::ROOT,
            &window,
            Some(window.scale_factor() as f32),
            window.theme(),
            Some(texture_side),
        );
        Ok(Open {
            resolution: self.first_resolution(),
            window,
            router: Router::new(overlay_input),
            title: Title::new(),
            device: self.device(),
            hidden: false,
            sharing,
            texture_side,
            failures: Failures::default(),
        })
    }

    /// Who traces, in words.
    fn device(&self) -> String {
        let tracer = &self.engine.world.resource::<ActiveTracer>().0;
        tracer
            .as_ref()
            .map_or_else(String::new, |tracer| tracer.device())
    }

    fn first_resolution(&self) -> Resolution {
        let tracer = &self.engine.world.resource::<ActiveTracer>().0;
        let is_slow = tracer
            .as_ref()
            .is_none_or(|tracer| tracer.runs_on_processor());
        let options = &self.options;
        Resolution::new(options.resolution_scale, options.target_millis, is_slow)
    }

    /// Runs one frame and shows it.
    fn frame(&mut self, event_loop: &ActiveEventLoop) {
        let Some(open) = &mut self.open else {
            return;
        };
        let size = inner_size(&open.window);
        if open.hidden || size.min_element() == 0 {
            return;
        }
        if let Some(at) = open.failures.retry_at {
            if Instant::now() >= at {
                self.recover(event_loop);
            }
            return;
        }
        let world = &mut self.engine.world;
        if let Some(title) = self.dropped.show(world) {
            self.options.title = title;
        }
        let input = open.router.overlay().take_egui_input(&open.window);
        world.resource_mut::<Ui>().feed(input);
        world.resource_mut::<Screen>().resize(size);
        let shoot = std::mem::take(&mut world.resource_mut::<Requests>().screenshot);
        if shoot {
            let time = *world.resource::<Time>();
            let path = screenshot_path(&self.options.screenshots, &self.options.title, &time);
            world.resource_mut::<Screenshot>().wanted = Some(path);
        }
        // A screenshot is worth every pixel of the window.
        let traced = if shoot {
            size
        } else {
            open.resolution.traced(size)
        };
        // Who counts rays is slower by that: the profiler alone shows them.
        let count_rays = world.resource::<EditorState>().profiler;
        let mut settings = world.resource_mut::<TraceSettings>();
        let refine_by = open.resolution.samples_when_still(size, settings.samples);
        let now = TraceSettings {
            size: traced,
            refine_by,
            count_rays,
            ..*settings
        };
        settings.set_if_neq(now);
        let start = Instant::now();
        self.engine.frame();
        let millis = start.elapsed().as_secs_f64() * 1e3;
        (self.observer)(&self.engine);
        self.after_frame(event_loop, millis);
    }

    /// What the frame asks of the window, and what is to be told of it.
    fn after_frame(&mut self, event_loop: &ActiveEventLoop, millis: f64) {
        let Some(open) = &mut self.open else {
            return;
        };
        let world = &mut self.engine.world;
        world.resource_mut::<Input>().end_frame();
        let output = world.resource_mut::<Ui>().take_platform_output();
        open.router
            .overlay()
            .handle_platform_output(&open.window, output);
        if std::mem::take(&mut world.resource_mut::<Requests>().fullscreen) {
            let full = open.window.fullscreen().is_none();
            open.window
                .set_fullscreen(full.then_some(Fullscreen::Borderless(None)));
        }
        if let Some(outcome) = world.resource_mut::<Screenshot>().outcome.take() {
            let mut notices = world.resource_mut::<Notices>();
            notices.toast(match outcome {
                Ok(path) => format!("Saved {}", path.display()),
                Err(why) => why,
            });
        }
        let size = inner_size(&open.window);
        let screen = world.resource::<Screen>();
        let host = (millis - screen.waited_millis()).max(0.0);
        let present = screen.present_millis();
        let (mut work_millis, mut samples) = (host, 1);
        if let Some(tracer) = &world.resource::<ActiveTracer>().0 {
            let work = Work::of(&**tracer, host, present);
            open.resolution.observe(size, &work);
            (work_millis, samples) = (work.frame, tracer.samples());
        }
        let coming = self.dropped.step();
        let unsaved = world.resource::<History>().is_unsaved();
        let title = format!("{}{}", self.options.title, if unsaved { "*" } else { "" });
        let caption = Caption {
            scene: coming.as_ref().unwrap_or(&title),
            window: size,
            scale: open.resolution.scale(),
            target_millis: open.resolution.target_millis(),
            samples,
            device: &open.device,
        };
        if let Some(title) = open.title.frame(work_millis, |pace| caption.words(pace)) {
            open.window.set_title(&title);
        }
        self.count_failures(event_loop);
    }

    /// Ends the run where the device keeps failing, in tracing or in presenting; one that is lost is opened anew a little
    /// later.
    fn count_failures(&mut self, event_loop: &ActiveEventLoop) {
        let Some(open) = &mut self.open else {
            return;
        };
        let world = &mut self.engine.world;
        let tracing_fault = world.resource_mut::<TraceFault>().0.take();
        world.resource_mut::<Notices>().fault = tracing_fault.as_ref().map(ToString::to_string);
        let presenting_fault = world.resource_mut::<Screen>().take_fault();
        match device_failure(presenting_fault, tracing_fault) {
            None => open.failures.note_success(),
            Some(error) => {
                if let Err(error) = open.failures.note_failure(error, Instant::now()) {
                    self.fail(event_loop, WindowError::Device(error));
                }
            }
        }
    }

    /// Goes on after a loss: the world is as it was.
    fn recover(&mut self, event_loop: &ActiveEventLoop) {
        let Some(open) = &mut self.open else {
            return;
        };
        let world = &mut self.engine.world;
        match recover(world, &open.window, &self.options, open.sharing) {
            Ok(()) => {
                open.failures.retry_at = None;
                // The pictures of letters were lost as well: egui makes them anew for another limit of their size.
                open.texture_side -= 1;
                open.router
                    .overlay()
                    .set_max_texture_side(open.texture_side);
                let words = "The GPU was lost and is back; nothing else was.";
                world.resource_mut::<Notices>().toast(words);
            }
            Err(error) => {
                if let Err(error) = open.failures.note_failure(error, Instant::now()) {
                    self.fail(event_loop, WindowError::Device(error));
                }
            }
        }
    }
}

impl ApplicationHandler for WindowApp<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.open.is_some() {
            return;
        }
        match self.open(event_loop) {
            Ok(open) => self.open = Some(open),
            Err(error) => self.fail(event_loop, error),
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        if matches!(event, WindowEvent::RedrawRequested) {
            self.frame(event_loop);
            return;
        }
        let Some(open) = &mut self.open else {
            return;
        };
        match &event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::Occluded(hidden) => open.hidden = *hidden,
            WindowEvent::DroppedFile(path) => {
                self.dropped.take(&mut self.engine.world, path);
            }
            _ => {}
        }
        let world = &mut self.engine.world;
        world.resource_scope(|world, mut input: Mut<Input>| {
            let ui = world.resource::<Ui>();
            open.router.route(&mut input, ui, &open.window, &event);
        });
    }

    fn device_event(&mut self, _: &ActiveEventLoop, _: DeviceId, event: DeviceEvent) {
        if let DeviceEvent::MouseMotion { delta } = event {
            router::mouse_moved(&mut self.engine.world.resource_mut::<Input>(), delta);
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let Some(open) = &self.open else {
            return;
        };
        // Nobody sees a minimised window: wait until somebody does.
        let idle = open.hidden || inner_size(&open.window).min_element() == 0;
        let retry_at = open.failures.retry_at;
        let later = retry_at.filter(|at| *at > Instant::now());
        event_loop.set_control_flow(match later {
            _ if idle => ControlFlow::Wait,
            Some(at) => ControlFlow::WaitUntil(at),
            None => ControlFlow::Poll,
        });
        if !idle && later.is_none() {
            open.window.request_redraw();
        }
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        editor::copy_at_end(&mut self.engine.world);
        // The surface goes before the window it belongs to, while the event loop still lives.
        self.engine.world.remove_resource::<Screen>();
        self.open = None;
    }
}
