//! Compiled kernels, one for each set of features that was asked for.
//!
//! Asking waits for the compiler, so that no picture depends on how long it takes; but where somebody plays, a frame must
//! not wait either. There ([`Pipelines::compile_in_background`]) a thread compiles, and until it is done a kernel is used
//! that has everything the scene needs and more: of those that are there the one with least of it, so that taking away
//! the last glass changes nothing at first, or the general one, which has everything and is compiled ahead.

use std::collections::{HashMap, HashSet};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::thread::JoinHandle;

use super::by_hand::HandKernel;
use super::context::Gpu;
use super::layout::Layouts;
use super::shader::{Kernel, Specialisation, shader_source};
use crate::frame::{Features, Kernels, Offset};
use crate::trace::TraceError;

/// Generations that the general kernel has room for.
const GENERAL_GENERATIONS: u32 = 16;

/// A compiled kernel.
#[derive(Clone)]
pub struct Pipeline {
    /// What a pass sets.
    pub compute: wgpu::ComputePipeline,
    /// Invocations of a workgroup.
    pub workgroup: [u32; 3],
}

type Key = (Kernel, Specialisation, Option<HandKernel>);

/// The cache.
#[derive(Default)]
pub struct Pipelines {
    compiled: HashMap<Key, Pipeline>,
    /// In place of the kernel of pictures.
    pub by_hand: Option<HandKernel>,
    background: Option<Background>,
}

/// A thread that compiles, one after the other. It ends before this goes: a driver must not be at work in it when the
/// program ends.
struct Background {
    thread: Option<JoinHandle<()>>,
    /// What is ordered still is not wanted any more.
    is_over: Arc<AtomicBool>,
    orders: mpsc::Sender<Order>,
    /// Asked by one at a time; a receiver alone could not be shared.
    answers: Mutex<mpsc::Receiver<Answer>>,
    ordered: HashSet<Key>,
}

struct Order {
    key: Key,
    layout: wgpu::PipelineLayout,
}

struct Answer {
    key: Key,
    pipeline: Result<Pipeline, TraceError>,
}

impl Pipelines {
    /// From now on asking does not wait where there is a kernel that will do meanwhile.
    pub fn compile_in_background(&mut self, gpu: &Arc<Gpu>) {
        if self.background.is_none() {
            self.background = Background::start(Arc::clone(gpu));
        }
    }

    /// Whether some other kernel than the one that is asked for may be the answer.
    pub fn is_in_background(&self) -> bool {
        self.background.is_some()
    }

    /// The kernel for these needs, or where that is not there yet one with more.
    ///
    /// # Errors
    /// [`TraceError::Device`] if the driver refuses it.
    pub fn get(
        &mut self,
        gpu: &Gpu,
        layouts: &Layouts,
        kernel: Kernel,
        special: Specialisation,
    ) -> Result<Pipeline, TraceError> {
        let by_hand = self.by_hand.filter(|_| kernel == Kernel::Whitted);
        let key = (kernel, relevant(kernel, special), by_hand);
        self.take_answers()?;
        if let Some(pipeline) = self.compiled.get(&key) {
            return Ok(pipeline.clone());
        }
        let meanwhile = self.covering(key).cloned();
        match (&mut self.background, meanwhile) {
            (Some(background), Some(meanwhile)) => {
                background.order(gpu, layouts, key);
                Ok(meanwhile)
            }
            (Some(background), None) if background.ordered.contains(&key) => self.wait_for(key),
            _ => {
                let pipeline = compile(gpu, key, &layout_of(gpu, layouts, key))?;
                gpu.check()?;
                self.compiled.insert(key, pipeline.clone());
                Ok(pipeline)
            }
        }
    }

    /// Has the general kernel compiled, where a thread does that: before a scene needs it.
    pub fn prepare_general(
        &mut self,
        gpu: &Gpu,
        layouts: &Layouts,
        kernel: Kernel,
        special: Specialisation,
    ) {
        let key = (kernel, relevant(kernel, general(special)), None);
        if let Some(background) = &mut self.background
            && !self.compiled.contains_key(&key)
        {
            background.order(gpu, layouts, key);
        }
    }

    /// The kernel with least beyond these needs, of those that have all of them.
    fn covering(&self, (kernel, special, by_hand): Key) -> Option<&Pipeline> {
        self.background.as_ref()?;
        let covers = |(key, _): &(&Key, &Pipeline)| {
            (key.0, key.2) == (kernel, by_hand) && key.1.covers(&special)
        };
        let covering = self.compiled.iter().filter(covers);
        let least = covering.min_by_key(|(key, _)| (key.1.features.count(), key.1.deferred_slots));
        least.map(|(_, pipeline)| pipeline)
    }

    fn take_answers(&mut self) -> Result<(), TraceError> {
        let Some(background) = &mut self.background else {
            return Ok(());
        };
        while let Ok(answer) = background.answers().try_recv() {
            background.ordered.remove(&answer.key);
            self.compiled.insert(answer.key, answer.pipeline?);
        }
        Ok(())
    }

    /// An order that nothing else will do for.
    fn wait_for(&mut self, key: Key) -> Result<Pipeline, TraceError> {
        while let Some(background) = &mut self.background {
            let Ok(answer) = background.answers().recv() else {
                break;
            };
            background.ordered.remove(&answer.key);
            let pipeline = answer.pipeline?;
            self.compiled.insert(answer.key, pipeline.clone());
            if answer.key == key {
                return Ok(pipeline);
            }
        }
        Err(TraceError::Device(
            "the thread that compiles shaders has ended".into(),
        ))
    }
}

impl Background {
    /// None: there is no thread to be had, so asking waits as it did.
    fn start(gpu: Arc<Gpu>) -> Option<Self> {
        let (orders, order) = mpsc::channel::<Order>();
        let (answer, answers) = mpsc::channel();
        let is_over = Arc::new(AtomicBool::new(false));
        let ends = Arc::clone(&is_over);
        let work = move || {
            while let Ok(Order { key, layout }) = order.recv()
                && !ends.load(Ordering::Relaxed)
            {
                let pipeline = compile(&gpu, key, &layout);
                if answer.send(Answer { key, pipeline }).is_err() {
                    break;
                }
                gpu.write_pipelines();
            }
        };
        let thread = std::thread::Builder::new()
            .name("compiler".into())
            .spawn(work)
            .ok()?;
        Some(Self {
            thread: Some(thread),
            is_over,
            orders,
            answers: Mutex::new(answers),
            ordered: HashSet::new(),
        })
    }

    fn answers(&mut self) -> &mut mpsc::Receiver<Answer> {
        let answers = self.answers.get_mut();
        answers.unwrap_or_else(PoisonError::into_inner)
    }

    fn order(&mut self, gpu: &Gpu, layouts: &Layouts, key: Key) {
        if self.ordered.insert(key) {
            let layout = layout_of(gpu, layouts, key);
            // A thread that has ended shows in what waits for it.
            let _ = self.orders.send(Order { key, layout });
        }
    }
}

impl Drop for Background {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        // Without a sender the thread waits for no order.
        self.orders = mpsc::channel().0;
        if let Some(thread) = self.thread.take() {
            // Should it have panicked, it has said so.
            let _ = thread.join();
        }
    }
}

fn layout_of(gpu: &Gpu, layouts: &Layouts, (kernel, special, _): Key) -> wgpu::PipelineLayout {
    layouts.pipeline(gpu, kernel, special.features.reads_texels())
}

/// Composes and compiles; what the driver says against it shows in [`Gpu::check`].
fn compile(
    gpu: &Gpu,
    (kernel, special, by_hand): Key,
    layout: &wgpu::PipelineLayout,
) -> Result<Pipeline, TraceError> {
    let shader = match by_hand {
        Some(by_hand) => by_hand.shader(special),
        None => shader_source(kernel, special),
    };
    let shader = shader.map_err(|why| {
        TraceError::Device(format!(
            "the shader {} does not compose: {why}",
            kernel.name()
        ))
    })?;
    let module = module_of(gpu, kernel, shader.source);
    let compute = gpu
        .device
        .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(kernel.name()),
            layout: Some(layout),
            module: &module,
            entry_point: Some(kernel.name()),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: gpu.kept_pipelines(),
        });
    Ok(Pipeline {
        compute,
        workgroup: shader.workgroup,
    })
}

/// What serves every scene of the same arithmetic.
fn general(special: Specialisation) -> Specialisation {
    Specialisation {
        cutoff: true,
        ..Specialisation::new(Features::all(), GENERAL_GENERATIONS).with(special.kernels)
    }
}

/// A kernel without the counter that wgpu puts into every loop, in case one does not end: that takes registers and about
/// 4 % of a picture's time on an NVIDIA H200. Bounds of buffers and arrays stay checked.
fn module_of(gpu: &Gpu, kernel: Kernel, source: String) -> wgpu::ShaderModule {
    let descriptor = wgpu::ShaderModuleDescriptor {
        label: Some(kernel.name()),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    };
    let checks = wgpu::ShaderRuntimeChecks {
        force_loop_bounding: false,
        ..wgpu::ShaderRuntimeChecks::checked()
    };
    // SAFETY: every loop of our kernels ends, and what comes from elsewhere promises the same (`HandKernel`). Walks visit each node of a tree at most
    // once, and builders name each node by one slot; rounds of a shadow ray have ever greater keys;
    // a path's generations and straight crossings are counted; all other loops count to a number of rows.
    #[allow(unsafe_code)]
    unsafe {
        gpu.device.create_shader_module_trusted(descriptor, checks)
    }
}

/// Drops from a specialisation what the kernel does not read, so that it is not compiled twice.
fn relevant(kernel: Kernel, special: Specialisation) -> Specialisation {
    let shapes = Features {
        reflection: false,
        transmission: false,
        smooth_normals: false,
        spot_lights: false,
        directional_lights: false,
        fade: false,
        absorption: false,
        curved: false,
        sky: false,
        panorama: false,
        textures: special.features.textures && special.features.cutouts,
        normal_maps: false,
        vertex_colors: special.features.vertex_colors && special.features.cutouts,
        ..special.features
    };
    let rays = Specialisation::new(shapes, 1).with(special.kernels);
    match kernel {
        Kernel::Whitted | Kernel::Antialias => special,
        Kernel::Leave => rays,
        // Rays of a buffer leave no surface.
        Kernel::Intersect => rays.with(Kernels {
            offsets: Offset::default(),
            ..special.kernels
        }),
        _ => Specialisation::new(Features::default(), 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{FrameScene, TraceSettings};
    use crate::trace::gpu::GpuTracer;
    use crate::trace::gpu::tests::{open, picture, scene, settings};
    use crate::trace::{Picture, Tracer};
    use crate::world::Material;

    fn glassy() -> FrameScene {
        let mut scene = scene(30, 20);
        scene.materials.edit(|material: &mut Material| {
            material.transmit = 0.6;
            material.ior = 1.3;
        });
        scene.features = Features::of(&scene);
        assert!(scene.features.transmission);
        scene
    }

    /// Waits for the thread.
    fn settle(pipelines: &mut Pipelines) {
        let is_busy = |pipelines: &Pipelines| {
            let background = pipelines.background.as_ref();
            background.is_some_and(|background| !background.ordered.is_empty())
        };
        while is_busy(pipelines) {
            std::thread::sleep(std::time::Duration::from_millis(5));
            pipelines.take_answers().expect("compiles");
        }
    }

    fn largest_difference(a: &Picture, b: &Picture) -> f32 {
        let pairs = a.pixels.iter().zip(&b.pixels);
        let differences = pairs.map(|(a, b)| (a - b).abs().max_element());
        differences.fold(0.0, f32::max)
    }

    #[test]
    fn an_edit_that_adds_glass_is_traced_with_the_general_kernel_until_its_own_is_there() {
        let (plain, glass, settings): (_, _, TraceSettings) =
            (scene(30, 20), glassy(), settings(48));
        let mut waiting = GpuTracer::new(open()).expect("a tracer");
        let expected = [&plain, &glass]
            .map(|scene| picture(&mut waiting, scene, &settings).expect("a picture"));
        let mut tracer = GpuTracer::new(open()).expect("a tracer");
        tracer.compile_in_background();
        let first = picture(&mut tracer, &plain, &settings).expect("a picture");
        assert!(
            first == expected[0],
            "the first picture waits for its own kernel"
        );
        settle(&mut tracer.pipelines);
        assert_eq!(
            tracer.pipelines.compiled.len(),
            2,
            "its own and the general one"
        );
        let meanwhile = picture(&mut tracer, &glass, &settings).expect("a picture");
        let off = largest_difference(&meanwhile, &expected[1]);
        assert!(off <= 1.5e-5, "{off}");
        settle(&mut tracer.pipelines);
        assert_eq!(tracer.pipelines.compiled.len(), 3);
        let back = picture(&mut tracer, &plain, &settings).expect("a picture");
        assert!(back == expected[0]);
        let own = picture(&mut tracer, &glass, &settings).expect("a picture");
        assert!(own == expected[1], "its own kernel is there and not used");
    }

    #[test]
    fn of_kernels_that_will_do_the_one_with_least_is_taken() {
        let gpu = open();
        let layouts = Layouts::new(&gpu);
        let mut pipelines = Pipelines::default();
        pipelines.compile_in_background(&gpu);
        let get = |pipelines: &mut Pipelines, features: Features| {
            let special = Specialisation::new(features, 4);
            let pipeline = pipelines.get(&gpu, &layouts, Kernel::Intersect, special);
            pipeline.expect("compiles").compute
        };
        let spheres = Features {
            spheres: true,
            ..Features::default()
        };
        let both = Features {
            cuboids: true,
            ..spheres
        };
        let all = get(&mut pipelines, Features::all());
        let meanwhile = get(&mut pipelines, both);
        assert!(meanwhile == all, "nothing else is there");
        settle(&mut pipelines);
        let own = get(&mut pipelines, both);
        assert!(own != all);
        assert!(get(&mut pipelines, spheres) == own, "less than all will do");
        settle(&mut pipelines);
        assert!(get(&mut pipelines, spheres) != own);
        // Without a thread nothing stands in.
        let mut waiting = Pipelines::default();
        let all = get(&mut waiting, Features::all());
        assert!(get(&mut waiting, both) != all);
    }
}
