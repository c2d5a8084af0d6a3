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
use super::compile::{Key, Pipeline, compile, general, layout_of, relevant};
use super::context::Gpu;
use super::layout::Layouts;
use super::shader::{Kernel, Specialisation};
use crate::trace::TraceError;

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
    /// What could not be compiled: it is not tried again where something else will do.
    refused: HashSet<Key>,
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
        self.take_answers();
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
                // A device that is lost compiles nothing and says nothing.
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

    fn take_answers(&mut self) {
        while let Some(background) = &mut self.background
            && let Ok(answer) = background.answers().try_recv()
        {
            // What nothing stands in for is asked for again, and the error told then.
            let _ = self.take(answer);
        }
    }

    fn take(&mut self, Answer { key, pipeline }: Answer) -> Result<Pipeline, TraceError> {
        if let Some(background) = &mut self.background {
            background.ordered.remove(&key);
            if let Err(error) = &pipeline {
                tracing::warn!("{error}");
                background.refused.insert(key);
            }
        }
        let pipeline = pipeline?;
        self.compiled.insert(key, pipeline.clone());
        Ok(pipeline)
    }

    /// An order that nothing else will do for.
    fn wait_for(&mut self, key: Key) -> Result<Pipeline, TraceError> {
        while let Some(background) = &mut self.background {
            let Ok(answer) = background.answers().recv() else {
                break;
            };
            let is_ours = answer.key == key;
            let pipeline = self.take(answer);
            if is_ours {
                return pipeline;
            }
        }
        Err(TraceError::Device(
            "the thread that compiles shaders has ended".into(),
        ))
    }
}

/// A compiler that panics refuses this one shader: the thread goes on, and nobody waits for what will not come.
fn held<T>(compile: impl FnOnce() -> Result<T, TraceError>) -> Result<T, TraceError> {
    let compiled = std::panic::catch_unwind(std::panic::AssertUnwindSafe(compile));
    compiled.unwrap_or_else(|_| {
        Err(TraceError::Device(
            "a shader's compiler panicked; what it said is above".into(),
        ))
    })
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
                let pipeline = held(|| compile(&gpu, key, &layout));
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
            refused: HashSet::new(),
        })
    }

    fn answers(&mut self) -> &mut mpsc::Receiver<Answer> {
        let answers = self.answers.get_mut();
        answers.unwrap_or_else(PoisonError::into_inner)
    }

    fn order(&mut self, gpu: &Gpu, layouts: &Layouts, key: Key) {
        if !self.refused.contains(&key) && self.ordered.insert(key) {
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

#[cfg(test)]
mod tests;
