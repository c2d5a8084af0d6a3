//! The GPU itself: which adapter, the device opened on it, and what goes wrong with it.
//!
//! Opened by [`super::GpuTracer`]'s callers: once, and shared with the window that presents. wgpu reports
//! errors through callbacks and panics if nobody listens; here they land in a slot that [`Gpu::check`]
//! turns into errors, so a lost device is an answer, not a crash. wgpu tells of a loss only
//! once and keeps quiet about every call after it, so the loss is kept and answered from then on, until somebody goes on
//! with another device ([`Gpu::reopened`]).

use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::adapters::{AdapterChoice, choose, describe, is_software, list};
use super::kept::KeptPipelines;
use crate::trace::TraceError;

/// Storage buffers that one stage may bind: what every device that runs WebGPU offers.
pub const STORAGE_BUFFERS: u32 = 8;

/// An open device.
pub struct Gpu {
    /// Where surfaces come from.
    pub instance: wgpu::Instance,
    /// What the device was opened on.
    pub adapter: wgpu::Adapter,
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// The adapter in words.
    pub info: wgpu::AdapterInfo,
    faults: Faults,
    kept: Option<KeptPipelines>,
}

/// What went wrong, noted by wgpu's callbacks from any thread.
#[derive(Clone, Default)]
struct Faults(Arc<Mutex<Noted>>);

#[derive(Default)]
struct Noted {
    /// The first error since the last look.
    error: Option<String>,
    /// Why the device is gone for good.
    loss: Option<String>,
}

impl Faults {
    fn noted(&self) -> MutexGuard<'_, Noted> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn note_error(&self, what: String) {
        self.noted().error.get_or_insert(what);
    }

    fn note_loss(&self, why: String) {
        self.noted().loss.get_or_insert(why);
    }

    /// Whether there is a loss; errors stay for [`Faults::look`].
    fn is_lost(&self) -> bool {
        self.noted().loss.is_some()
    }

    /// An error is answered once, a loss every time.
    fn look(&self) -> Option<Fault> {
        let mut noted = self.noted();
        let error = noted.error.take();
        let loss = noted.loss.clone().map(Fault::Loss);
        loss.or(error.map(Fault::Error))
    }
}

/// What [`Faults`] answer.
#[derive(Debug, PartialEq)]
enum Fault {
    Error(String),
    Loss(String),
}

impl Gpu {
    /// An instance with every backend that was compiled in.
    pub fn instance() -> wgpu::Instance {
        wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env())
    }

    /// All adapters: discrete, integrated, virtual, unknown, software; within a kind as the drivers list them.
    pub fn adapters(instance: &wgpu::Instance) -> Vec<wgpu::AdapterInfo> {
        list(instance).iter().map(wgpu::Adapter::get_info).collect()
    }

    /// Opens a device. With a surface, only adapters that can present to it are considered.
    ///
    /// # Errors
    /// [`TraceError::NoDevice`] if no adapter fits the choice or none of those opens.
    pub fn open(
        instance: wgpu::Instance,
        choice: &AdapterChoice,
        surface: Option<&wgpu::Surface>,
    ) -> Result<Self, TraceError> {
        let adapters = list(&instance);
        let infos: Vec<_> = adapters.iter().map(wgpu::Adapter::get_info).collect();
        let mut reasons = Vec::new();
        for index in choose(&infos, choice)? {
            let adapter = &adapters[index];
            if surface.is_some_and(|surface| !adapter.is_surface_supported(surface)) {
                reasons.push(format!(
                    "{} cannot present to the window",
                    describe(&infos[index])
                ));
                continue;
            }
            match open_device(adapter, limits(&adapter.limits()), wanted_features()) {
                Ok(opened) => return Ok(Self::around(instance, adapter.clone(), opened)),
                Err(why) => reasons.push(format!("{}: {why}", describe(&infos[index]))),
            }
        }
        Err(TraceError::NoDevice(format!(
            "no GPU could be opened: {}; `--backend cpu` needs none",
            reasons.join("; ")
        )))
    }

    /// The same adapter with a new device of the same limits, for one that was lost.
    ///
    /// # Errors
    /// [`TraceError::NoDevice`] if the adapter is no longer there or does not open.
    pub fn reopened(&self) -> Result<Self, TraceError> {
        let gone = |why: String| {
            let adapter = self.describe();
            TraceError::NoDevice(format!("the GPU ({adapter}) did not come back: {why}"))
        };
        let same = |adapter: &wgpu::Adapter| adapter.get_info() == self.info;
        let adapter = list(&self.instance).into_iter().find(same);
        let adapter = adapter.ok_or_else(|| gone("it is no longer there".into()))?;
        let opened = open_device(&adapter, self.device.limits(), self.device.features());
        let opened = opened.map_err(|error| gone(error.to_string()))?;
        Ok(Self::around(self.instance.clone(), adapter, opened))
    }

    /// What is open already, with its errors listened to.
    fn around(instance: wgpu::Instance, adapter: wgpu::Adapter, (device, queue): Opened) -> Self {
        let faults = Faults::default();
        listen(&device, &faults);
        Self {
            info: adapter.get_info(),
            instance,
            adapter,
            device,
            queue,
            faults,
            kept: None,
        }
    }

    /// From now on compiled pipelines are kept in this folder, where the adapter can have that.
    pub fn keep_pipelines_in(&mut self, folder: &Path) {
        self.kept = KeptPipelines::open(self, folder);
    }

    /// What pipelines are created with.
    pub fn kept_pipelines(&self) -> Option<&wgpu::PipelineCache> {
        self.kept.as_ref().map(KeptPipelines::cache)
    }

    /// Writes the pipelines that have come since the last time, if they are kept.
    pub fn write_pipelines(&self) {
        if let Some(kept) = &self.kept {
            kept.write();
        }
    }

    /// Whether the "GPU" is a program on the CPU (Mesa's lavapipe, Microsoft's WARP).
    pub fn is_software(&self) -> bool {
        is_software(&self.info)
    }

    /// Name, API and driver, as in "NVIDIA H200, Vulkan, driver 580.159".
    pub fn describe(&self) -> String {
        describe(&self.info)
    }

    /// What went wrong on the device since the last call; of a lost device, its loss at every call.
    ///
    /// # Errors
    /// [`TraceError::Device`] or [`TraceError::DeviceLost`] with the driver's or wgpu's words.
    pub fn check(&self) -> Result<(), TraceError> {
        match self.faults.look() {
            Some(Fault::Error(what)) => Err(TraceError::Device(format!(
                "the GPU failed ({}): {what}",
                self.describe()
            ))),
            Some(Fault::Loss(why)) => Err(TraceError::DeviceLost(format!(
                "the GPU was lost ({}): {why}",
                self.describe()
            ))),
            None => Ok(()),
        }
    }

    /// Whether the device is gone for good. What else went wrong is left for [`Gpu::check`].
    pub fn is_lost(&self) -> bool {
        self.faults.is_lost()
    }

    /// Most bytes of a buffer that a kernel binds, and the name of the limit that says so.
    pub fn most_bound(&self) -> (u64, &'static str) {
        let limits = self.device.limits();
        let (bound, created) = (
            limits.max_storage_buffer_binding_size,
            limits.max_buffer_size,
        );
        if bound <= created {
            (bound & !15, "max_storage_buffer_binding_size")
        } else {
            (created & !15, "max_buffer_size")
        }
    }
}

/// The portable limits, with as much room for buffers and pictures as the adapter has.
fn limits(adapter: &wgpu::Limits) -> wgpu::Limits {
    let portable = wgpu::Limits {
        max_buffer_size: adapter.max_buffer_size,
        max_storage_buffer_binding_size: adapter.max_storage_buffer_binding_size,
        max_texture_dimension_2d: adapter.max_texture_dimension_2d,
        max_storage_buffers_per_shader_stage: STORAGE_BUFFERS,
        ..wgpu::Limits::default()
    };
    portable.or_worse_values_from(adapter)
}

/// What is used where the adapter has it.
fn wanted_features() -> wgpu::Features {
    wgpu::Features::PIPELINE_CACHE
        | wgpu::Features::TIMESTAMP_QUERY
        | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS
        | wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES
}

type Opened = (wgpu::Device, wgpu::Queue);

fn open_device(
    adapter: &wgpu::Adapter,
    required_limits: wgpu::Limits,
    wanted: wgpu::Features,
) -> Result<Opened, wgpu::RequestDeviceError> {
    pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        label: Some("orrery"),
        required_features: adapter.features() & wanted,
        required_limits,
        ..wgpu::DeviceDescriptor::default()
    }))
}

fn listen(device: &wgpu::Device, faults: &Faults) {
    let uncaptured = faults.clone();
    device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
        uncaptured.note_error(error.to_string());
    }));
    let lost = faults.clone();
    device.set_device_lost_callback(move |reason, message| {
        let words = [message.trim(), "no reason was given"];
        let why = words.into_iter().find(|words| !words.is_empty());
        lost.note_loss(format!("{reason:?}: {}", why.unwrap_or_default()));
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Gpu {
        /// Any adapter, opened so that no buffer may be larger than `most` bytes: small scenes are too large for it.
        pub(in crate::trace::gpu) fn limited(most: u64) -> Result<Self, TraceError> {
            let smaller = |limits| wgpu::Limits {
                max_buffer_size: most,
                max_storage_buffer_binding_size: most,
                ..limits
            };
            Self::opened_as(|adapter| {
                open_device(
                    adapter,
                    smaller(limits(&adapter.limits())),
                    wanted_features(),
                )
            })
        }

        /// Any adapter, opened without timestamps.
        pub(in crate::trace::gpu) fn untimed() -> Result<Self, TraceError> {
            Self::opened_as(|adapter| {
                open_device(adapter, limits(&adapter.limits()), wgpu::Features::empty())
            })
        }

        fn opened_as(
            open: impl FnOnce(&wgpu::Adapter) -> Result<Opened, wgpu::RequestDeviceError>,
        ) -> Result<Self, TraceError> {
            let instance = Self::instance();
            let adapter = list(&instance)
                .into_iter()
                .next()
                .ok_or_else(|| TraceError::NoDevice("no adapter at all".into()))?;
            let opened = open(&adapter).map_err(|error| TraceError::NoDevice(error.to_string()))?;
            Ok(Self::around(instance, adapter, opened))
        }
    }

    #[test]
    fn an_error_passes_and_a_loss_stays() {
        let faults = Faults::default();
        faults.note_error("a bad binding".into());
        assert!(!faults.is_lost(), "and the error is still there");
        assert_eq!(faults.look(), Some(Fault::Error("a bad binding".into())));
        assert_eq!(faults.look(), None);
        faults.note_loss("it was unplugged".into());
        faults.note_error("a bad binding".into());
        for _ in 0..3 {
            assert!(faults.is_lost());
            assert_eq!(faults.look(), Some(Fault::Loss("it was unplugged".into())));
        }
    }
}
