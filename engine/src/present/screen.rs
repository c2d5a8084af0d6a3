//! The swap chain: the picture, and the overlay over it, on a window's surface.

use std::sync::Arc;
use std::time::Instant;

use bevy_ecs::prelude::*;
use glam::UVec2;

use super::pass::{Look, PresentPass};
use super::ui::Ui;
use crate::frame::FrameScene;
use crate::time::Time;
use crate::trace::gpu::{Ends, Gpu, Report, Reports};
use crate::trace::{
    ActiveTracer, DeviceClock, DeviceReport, OtherPasses, PassTime, TraceError, TraceFault,
};

/// What presenting is called in the profile.
const PRESENT: &str = "present and overlay";

/// A window's surface, and what draws to it.
#[derive(Resource)]
pub struct Screen {
    gpu: Arc<Gpu>,
    window: Arc<dyn wgpu::DisplayAndWindowHandle>,
    /// None: it was lost, and another one could not be made yet.
    surface: Option<wgpu::Surface<'static>>,
    config: wgpu::SurfaceConfiguration,
    pass: PresentPass,
    overlay: egui_wgpu::Renderer,
    /// Timestamps of presenting, where the device has them.
    reports: Option<Reports>,
    /// What the last presenting took that has come back.
    time: Option<PassTime>,
    /// When this frame waited for the display: for an image to draw to, and to hand it over.
    waits: Vec<PassTime>,
    /// What has come back of presenting since the profile last looked.
    told: Vec<DeviceReport>,
    /// The tracer's picture lies on this screen's device.
    shares_device: bool,
    /// The swap chain no longer fits the window well; configured anew once its image is shown.
    stale: bool,
    fault: Option<TraceError>,
}

impl Screen {
    /// Prepares a window's surface for presenting.
    ///
    /// # Errors
    /// [`TraceError::NoDevice`] where the adapter knows no format for the surface; [`TraceError::Device`] where that fails.
    pub fn new(
        gpu: Arc<Gpu>,
        window: Arc<dyn wgpu::DisplayAndWindowHandle>,
        surface: wgpu::Surface<'static>,
        size: UVec2,
        vsync: bool,
    ) -> Result<Self, TraceError> {
        let capabilities = surface.get_capabilities(&gpu.adapter);
        // The shader and the overlay both encode sRGB themselves where the format lets them.
        let plain = [
            wgpu::TextureFormat::Bgra8Unorm,
            wgpu::TextureFormat::Rgba8Unorm,
        ];
        let format = plain
            .into_iter()
            .find(|format| capabilities.formats.contains(format))
            .or_else(|| capabilities.formats.first().copied());
        let config = surface.get_default_config(&gpu.adapter, size.x.max(1), size.y.max(1));
        let (Some(format), Some(mut config)) = (format, config) else {
            return Err(TraceError::NoDevice(format!(
                "{} cannot present to this window",
                gpu.describe()
            )));
        };
        config.format = format;
        config.present_mode = if vsync {
            wgpu::PresentMode::AutoVsync
        } else {
            wgpu::PresentMode::AutoNoVsync
        };
        surface.configure(&gpu.device, &config);
        gpu.check()?;
        let options = egui_wgpu::RendererOptions {
            msaa_samples: 1,
            ..egui_wgpu::RendererOptions::default()
        };
        let timed = gpu
            .device
            .features()
            .contains(wgpu::Features::TIMESTAMP_QUERY);
        Ok(Self {
            reports: timed.then(|| Reports::new(&gpu, [PRESENT; 2])),
            time: None,
            waits: Vec::new(),
            told: Vec::new(),
            pass: PresentPass::new(&gpu.device, format),
            overlay: egui_wgpu::Renderer::new(&gpu.device, format, options),
            gpu,
            window,
            surface: Some(surface),
            config,
            shares_device: false,
            stale: false,
            fault: None,
        })
    }

    /// The tracer was given this screen's device: its picture need not come to the host.
    pub fn share_device(&mut self) {
        self.shares_device = true;
    }

    /// Whether its device is gone for good: another screen is to take its place.
    pub fn is_lost(&self) -> bool {
        self.gpu.is_lost()
    }

    /// Follows the window; a size of zero (minimised) is left alone.
    pub fn resize(&mut self, size: UVec2) {
        if size.min_element() > 0 && size != self.size() {
            (self.config.width, self.config.height) = (size.x, size.y);
            self.configure();
        }
    }

    /// Fits the swap chain to the window. Where that fails there is no surface any more: one without a swap chain must not
    /// be asked for an image.
    fn configure(&mut self) {
        if let Some(surface) = &self.surface {
            surface.configure(&self.gpu.device, &self.config);
            if let Err(error) = self.gpu.check() {
                (self.fault, self.surface) = (Some(error), None);
            }
        }
    }

    /// Another surface for the window, in place of one that was lost.
    fn replace_surface(&mut self) -> Result<(), TraceError> {
        // The old swap chain goes first: a window has one at a time.
        self.surface = None;
        let surface = self
            .gpu
            .instance
            .create_surface(self.window.clone())
            .map_err(|error| {
                TraceError::Device(format!("the window's surface cannot be replaced: {error}"))
            })?;
        self.surface = Some(surface);
        self.configure();
        Ok(())
    }

    /// Pixels across and down.
    pub fn size(&self) -> UVec2 {
        UVec2::new(self.config.width, self.config.height)
    }

    /// Milliseconds that the last frame waited for the display.
    pub fn waited_millis(&self) -> f64 {
        self.waits.iter().map(|wait| wait.millis).sum()
    }

    /// Milliseconds of the device on presenting, of the last that has come back; 0 where it has no timestamps.
    pub fn present_millis(&self) -> f64 {
        self.time.as_ref().map_or(0.0, |time| time.millis)
    }

    /// What went wrong with presenting since the last call.
    pub fn take_fault(&mut self) -> Option<TraceError> {
        self.fault.take()
    }

    /// The next image of the swap chain; none if there is none just now.
    fn next_image(&mut self) -> Option<wgpu::SurfaceTexture> {
        use wgpu::CurrentSurfaceTexture as Current;
        let mut fault = None;
        for _ in 0..2 {
            if self.is_lost() {
                break;
            }
            let surface = self.surface.as_ref();
            match surface.map_or(Current::Lost, wgpu::Surface::get_current_texture) {
                Current::Success(image) => return Some(image),
                Current::Timeout | Current::Occluded => return None,
                Current::Validation => break,
                Current::Suboptimal(image) => {
                    self.stale = true;
                    return Some(image);
                }
                // The window is being resized: the next frame knows its size.
                Current::Outdated => self.configure(),
                Current::Lost => {
                    fault = self.replace_surface().err().or_else(|| Some(lost_again()));
                }
            }
        }
        // A loss is told when the device is asked; an error here shows in `check`.
        let _ = self.gpu.device.poll(wgpu::PollType::Poll);
        let told = self.gpu.check().err().or(self.fault.take());
        self.fault = told.or(fault);
        None
    }

    /// Brings the overlay's new pictures (letters, mostly) to the device, shown or not.
    fn upload_overlay(&mut self, ui: &mut Ui) {
        for (id, deltas) in ui.textures.set.drain() {
            for delta in deltas {
                self.overlay
                    .update_texture(&self.gpu.device, &self.gpu.queue, id, &delta);
            }
        }
    }

    /// Takes in the newest timestamps that have come back.
    fn collect_time(&mut self) {
        let told = &mut self.told;
        let each = |frame, _: &Report, passes| {
            told.push(DeviceReport {
                frame,
                clock: DeviceClock::Screen,
                passes,
                rays: None,
            });
        };
        let reports = self.reports.as_mut();
        let report = reports.and_then(|reports| reports.collect(&self.gpu, each));
        if let Some(millis) = report.and_then(|report| report.millis) {
            self.time = Some(PassTime {
                name: PRESENT,
                millis,
                start: None,
            });
        }
    }

    /// Draws picture and overlay and hands the image to the display.
    fn present(&mut self, ui: &mut Ui, look: Look, frame: u64) {
        self.upload_overlay(ui);
        let start = Instant::now();
        let image = self.next_image();
        self.waits = vec![PassTime::since("wait for an image", start)];
        if let Some(image) = image {
            self.draw(image, ui, look, frame);
        }
        for id in ui.textures.free.drain() {
            self.overlay.free_texture(&id);
        }
        if std::mem::take(&mut self.stale) {
            self.configure();
        }
    }

    fn draw(&mut self, image: wgpu::SurfaceTexture, ui: &Ui, look: Look, frame: u64) {
        let size = self.size();
        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        let view = image
            .texture
            .create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor {
            label: Some("present"),
        });
        let screen = egui_wgpu::ScreenDescriptor {
            size_in_pixels: size.to_array(),
            pixels_per_point: ui.pixels_per_point,
        };
        let mut commands =
            self.overlay
                .update_buffers(device, queue, &mut encoder, &ui.shapes, &screen);
        {
            let writes = self.reports.as_ref().and_then(Reports::render_writes);
            let mut pass = begin_pass(&mut encoder, &view, writes);
            self.pass.draw(device, queue, &mut pass, size, look);
            self.overlay.render(&mut pass, &ui.shapes, &screen);
        }
        let reports = self.reports.as_mut();
        let report = reports.and_then(|reports| {
            reports.begin(frame);
            let slot = reports.record(&mut encoder, Ends::Picture)?;
            Some((reports, slot))
        });
        commands.push(encoder.finish());
        queue.submit(commands);
        if let Some((reports, slot)) = report {
            reports.request(slot);
        }
        let start = Instant::now();
        queue.present(image);
        self.waits
            .push(PassTime::since("hand the image over", start));
        self.fault = self.gpu.check().err();
    }
}

fn lost_again() -> TraceError {
    TraceError::Device(
        "the surface was lost: the system took away what the window is drawn to, and did not give it back"
            .into(),
    )
}

fn begin_pass(
    encoder: &mut wgpu::CommandEncoder,
    view: &wgpu::TextureView,
    timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
) -> wgpu::RenderPass<'static> {
    encoder
        .begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("present"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            timestamp_writes,
            ..wgpu::RenderPassDescriptor::default()
        })
        .forget_lifetime()
}

/// Shows the tracer's picture and the overlay.
pub(super) fn present_picture(
    screen: Option<ResMut<Screen>>,
    mut tracer: ResMut<ActiveTracer>,
    mut fault: ResMut<TraceFault>,
    (scene, time): (Res<FrameScene>, Res<Time>),
    mut ui: ResMut<Ui>,
    mut passes: ResMut<OtherPasses>,
) {
    let Some(mut screen) = screen else {
        return;
    };
    let screen = &mut *screen;
    if let (Some(tracer), None) = (&mut tracer.0, &fault.0) {
        match tracer.device_picture().filter(|_| screen.shares_device) {
            Some(picture) => screen.pass.show_device(&picture),
            None => match tracer.picture() {
                Ok(picture) => {
                    let (device, queue) = (&screen.gpu.device, &screen.gpu.queue);
                    screen.pass.show_host(device, queue, &picture);
                }
                Err(error) => fault.0 = Some(error),
            },
        }
    }
    let look = Look {
        exposure: scene.view.exposure,
        tone: scene.view.tone_map,
    };
    screen.present(&mut ui, look, time.frame);
    screen.collect_time();
    passes.passes.clear();
    passes.passes.extend(screen.time.clone());
    passes.waits.clone_from(&screen.waits);
    passes.reports.append(&mut screen.told);
}
