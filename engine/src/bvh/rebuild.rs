//! New trees off the frame: a thread that builds while frames go on with what they have.
//!
//! A tracer asks when a refitted tree has become bad ([`super::Tree::cost`]), and takes finished trees at the
//! start of a frame ([`Rebuilder::poll`]); it refits a tree to the frame's vertices before it uses it. So no
//! frame waits, and none sees half a tree. Requests are worked off by benefit, the greatest first.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use super::Tree;
use crate::geom::Aabb;

/// A tree that was asked for.
#[derive(Debug)]
pub struct Rebuilt {
    /// Of the request.
    pub key: u64,
    /// Over the boxes of the request; `None` if building it failed, so that what there is must do.
    pub tree: Option<Tree>,
}

/// Hands boxes to the thread and trees back. Dropping it ends the thread, after the tree it is at.
pub struct Rebuilder {
    shared: Arc<Shared>,
    build: Arc<dyn Fn(&[Aabb]) -> Tree + Send + Sync>,
    is_started: bool,
}

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    wake: Condvar,
}

#[derive(Default)]
struct State {
    waiting: Vec<Request>,
    /// Key of what is being built, unless that is no longer wanted.
    current: Option<u64>,
    done: Vec<Rebuilt>,
    ends: bool,
}

struct Request {
    key: u64,
    boxes: Box<dyn FnOnce() -> Vec<Aabb> + Send>,
    benefit: f64,
}

impl Default for Rebuilder {
    fn default() -> Self {
        Self::with(Tree::build)
    }
}

impl Drop for Rebuilder {
    fn drop(&mut self) {
        self.shared.lock().ends = true;
        self.shared.wake.notify_all();
    }
}

impl Rebuilder {
    /// With another way of building than [`Tree::build`].
    pub fn with(build: impl Fn(&[Aabb]) -> Tree + Send + Sync + 'static) -> Self {
        Self {
            shared: Arc::default(),
            build: Arc::new(build),
            is_started: false,
        }
    }

    /// Asks for a tree over these boxes, which the thread finds out, too. Of several requests under one key
    /// only the last is answered.
    ///
    /// `benefit` is what a frame would save, in any unit that all requests share; not a number counts as none.
    pub fn request(
        &mut self,
        key: u64,
        boxes: impl FnOnce() -> Vec<Aabb> + Send + 'static,
        benefit: f64,
    ) {
        let mut state = self.shared.lock();
        state.forget(key);
        let benefit = if benefit.is_nan() { 0.0 } else { benefit };
        state.waiting.push(Request {
            key,
            boxes: Box::new(boxes),
            benefit,
        });
        drop(state);
        self.shared.wake.notify_one();
        self.start();
    }

    /// Takes a request back; nothing will come under this key.
    pub fn cancel(&mut self, key: u64) {
        self.shared.lock().forget(key);
    }

    /// Whether an answer under this key is still to come, or to be fetched.
    pub fn is_pending(&self, key: u64) -> bool {
        let state = self.shared.lock();
        state.current == Some(key)
            || state.waiting.iter().any(|request| request.key == key)
            || state.done.iter().any(|rebuilt| rebuilt.key == key)
    }

    /// What was finished since the last call. Never waits for a tree.
    pub fn poll(&mut self) -> Vec<Rebuilt> {
        std::mem::take(&mut self.shared.lock().done)
    }

    /// Starts the thread unless it runs. Without threads the caller builds.
    fn start(&mut self) {
        if self.is_started {
            return;
        }
        let (shared, build) = (Arc::clone(&self.shared), Arc::clone(&self.build));
        let thread = std::thread::Builder::new().name("rebuild of trees".into());
        let work = move || {
            // A pool of itself: in the frame's, a build would be in its way.
            let alone = rayon::ThreadPoolBuilder::new().num_threads(1);
            let _alone = alone.use_current_thread().build();
            while shared.work(&*build, true) {}
        };
        self.is_started = thread.spawn(work).is_ok();
        if !self.is_started {
            self.shared.work(&*self.build, false);
        }
    }
}

impl State {
    /// Drops all that there is of a key.
    fn forget(&mut self, key: u64) {
        self.waiting.retain(|request| request.key != key);
        self.done.retain(|rebuilt| rebuilt.key != key);
        self.current = self.current.filter(|&current| current != key);
    }

    fn take_best(&mut self) -> Option<Request> {
        let benefit = |i: &usize| self.waiting[*i].benefit;
        let best = (0..self.waiting.len()).max_by(|a, b| benefit(a).total_cmp(&benefit(b)))?;
        Some(self.waiting.swap_remove(best))
    }
}

impl Shared {
    /// No one panics while holding it; if so all the same, what is in it is whole.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Builds one tree, having waited for a request if so told; false: the end.
    fn work(&self, build: &(dyn Fn(&[Aabb]) -> Tree + Send + Sync), waits: bool) -> bool {
        let mut state = self.lock();
        let request = loop {
            if state.ends {
                return false;
            }
            match state.take_best() {
                Some(request) => break request,
                None if !waits => return false,
                None => {
                    state = self
                        .wake
                        .wait(state)
                        .unwrap_or_else(PoisonError::into_inner)
                }
            }
        };
        let key = request.key;
        state.current = Some(key);
        drop(state);
        let tree = catch_unwind(AssertUnwindSafe(|| build(&(request.boxes)()))).ok();
        let mut state = self.lock();
        // Otherwise it was asked for anew, or taken back.
        if state.current.take_if(|current| *current == key).is_some() {
            state.done.push(Rebuilt { key, tree });
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Receiver, Sender, channel};

    use glam::Vec3;

    use super::*;

    fn boxes(count: usize) -> Vec<Aabb> {
        let unit = |i: usize| Aabb::of([Vec3::splat(i as f32), Vec3::splat(i as f32 + 1.0)]);
        (0..count).map(unit).collect()
    }

    #[test]
    fn builds_stay_out_of_the_pool_of_frames() {
        let mut rebuilder = Rebuilder::with(|boxes| {
            assert_eq!(rayon::current_num_threads(), 1);
            assert!(rayon::current_thread_index().is_some());
            Tree::build(boxes)
        });
        rebuilder.request(1, || boxes(20_000), 1.0);
        assert!(wait_for(&mut rebuilder, 1)[0].tree.is_some());
    }

    fn wait_for(rebuilder: &mut Rebuilder, count: usize) -> Vec<Rebuilt> {
        let mut all = Vec::new();
        while all.len() < count {
            all.extend(rebuilder.poll());
            std::thread::yield_now();
        }
        all
    }

    /// Builds when told to, and tells how many boxes it was given before.
    fn gated() -> (Rebuilder, Sender<()>, Receiver<usize>) {
        let ((open, gate), (tell, begun)) = (channel(), channel());
        let gate = Mutex::new((gate, tell));
        let rebuilder = Rebuilder::with(move |boxes| {
            let gate = gate.lock().unwrap_or_else(PoisonError::into_inner);
            gate.1.send(boxes.len()).unwrap();
            gate.0.recv().unwrap();
            Tree::build(boxes)
        });
        (rebuilder, open, begun)
    }

    #[test]
    fn a_tree_comes_back_that_is_one_over_the_boxes() {
        let mut rebuilder = Rebuilder::default();
        rebuilder.request(7, || boxes(100), 1.0);
        let rebuilt = wait_for(&mut rebuilder, 1).remove(0);
        assert_eq!(rebuilt.key, 7);
        rebuilt.tree.unwrap().validate(&boxes(100)).unwrap();
        assert!(!rebuilder.is_pending(7));
    }

    #[test]
    fn the_greatest_benefit_comes_first_and_the_newest_boxes_count() {
        let (mut rebuilder, open, begun) = gated();
        rebuilder.request(1, || boxes(1), 1.0);
        assert_eq!(begun.recv(), Ok(1));
        rebuilder.request(2, || boxes(2), 1.0);
        rebuilder.request(3, || boxes(3), f64::NAN);
        rebuilder.request(4, || boxes(4), 9.0);
        rebuilder.request(2, || boxes(22), 2.0);
        (0..4).for_each(|_| open.send(()).unwrap());
        let keys: Vec<u64> = wait_for(&mut rebuilder, 4).iter().map(|r| r.key).collect();
        assert_eq!(keys, [1, 4, 2, 3]);
        assert_eq!(begun.iter().take(3).collect::<Vec<_>>(), [4, 22, 3]);
    }

    #[test]
    fn what_was_asked_for_anew_or_taken_back_while_building_does_not_come() {
        let (mut rebuilder, open, begun) = gated();
        rebuilder.request(1, || boxes(1), 1.0);
        assert_eq!(begun.recv(), Ok(1));
        rebuilder.request(1, || boxes(5), 1.0);
        open.send(()).unwrap();
        assert_eq!(begun.recv(), Ok(5));
        assert!(rebuilder.poll().is_empty());
        rebuilder.cancel(1);
        rebuilder.request(2, || boxes(2), 1.0);
        (0..2).for_each(|_| open.send(()).unwrap());
        let keys: Vec<u64> = wait_for(&mut rebuilder, 1).iter().map(|r| r.key).collect();
        assert_eq!(keys, [2]);
    }

    #[test]
    fn a_builder_that_fails_takes_nothing_down() {
        let build = |boxes: &[Aabb]| match boxes.len() {
            3 => panic!("not three"),
            _ => Tree::build(boxes),
        };
        let mut rebuilder = Rebuilder::with(build);
        rebuilder.request(1, || boxes(3), 1.0);
        assert!(wait_for(&mut rebuilder, 1)[0].tree.is_none());
        rebuilder.request(1, || boxes(4), 1.0);
        assert!(wait_for(&mut rebuilder, 1)[0].tree.is_some());
    }

    #[test]
    fn dropping_it_ends_the_thread() {
        let (rebuilder, build) = {
            let mut rebuilder = Rebuilder::default();
            rebuilder.request(1, || boxes(1), 1.0);
            wait_for(&mut rebuilder, 1);
            let build = Arc::downgrade(&rebuilder.build);
            (rebuilder, build)
        };
        assert_eq!(build.strong_count(), 2);
        drop(rebuilder);
        while build.strong_count() > 0 {
            std::thread::yield_now();
        }
    }
}
