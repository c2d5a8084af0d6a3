//! What made a frame slow: of all that ran in it, that which took most beyond what it usually takes.

use std::collections::HashMap;
use std::sync::Arc;

use super::frame::Frame;
use super::percentile_of_sorted;

/// The culprit.
#[derive(Clone, Debug, PartialEq)]
pub struct Blame {
    /// The system, step or pass.
    pub name: Arc<str>,
    /// What it took in that frame, without what lies within it, microseconds.
    pub micros: f64,
    /// What it takes in the middle one of the other frames, microseconds; 0 if it ran in none.
    pub usual_micros: f64,
    /// It is a pass of the device.
    pub on_device: bool,
}

/// What took longest beyond its usual time in a frame, by what it took in others; none: nothing ran.
pub fn blame<'a>(frame: &Frame, others: impl Iterator<Item = &'a Frame>) -> Option<Blame> {
    let mut usual: HashMap<(Arc<str>, bool), Vec<f64>> = HashMap::new();
    let mut count = 0;
    for other in others.filter(|other| other.id != frame.id) {
        count += 1;
        for (name, taken) in costs(other) {
            usual.entry(name).or_default().push(taken);
        }
    }
    let usual = |name: &(Arc<str>, bool)| {
        let mut taken = usual.get(name).cloned().unwrap_or_default();
        // Frames in which it did not run took nothing for it.
        taken.resize(count.max(taken.len()), 0.0);
        taken.sort_unstable_by(f64::total_cmp);
        percentile_of_sorted(&taken, 0.5)
    };
    let beyond = costs(frame).into_iter().map(|(name, micros)| Blame {
        usual_micros: usual(&name),
        name: name.0,
        micros,
        on_device: name.1,
    });
    beyond.max_by(|a, b| (a.micros - a.usual_micros).total_cmp(&(b.micros - b.usual_micros)))
}

/// What each name took in a frame, on the host or on the device, summed over its runs.
pub fn costs(frame: &Frame) -> HashMap<(Arc<str>, bool), f64> {
    let mut costs = HashMap::new();
    for (span, own) in frame.spans.iter().zip(frame.self_micros()) {
        *costs.entry((Arc::clone(&span.name), false)).or_default() += own;
    }
    for pass in &frame.passes {
        *costs.entry((Arc::clone(&pass.name), true)).or_default() += pass.micros;
    }
    costs
}

#[cfg(test)]
mod tests {
    use super::super::frame::{nest, tests::span};
    use super::*;

    fn frame(id: u64, slow: f64, always: f64) -> Frame {
        let mut spans = vec![
            span("always slow", 0.0, always),
            span("system", always, 100.0 + slow),
            span("step", always + 10.0, slow),
        ];
        nest(&mut spans);
        Frame {
            id,
            spans,
            ..Frame::default()
        }
    }

    #[test]
    fn what_is_always_slow_is_not_to_blame_and_the_innermost_is() {
        let frames: Vec<Frame> = (0..9)
            .map(|id| frame(id, if id == 4 { 900.0 } else { 20.0 }, 5000.0))
            .collect();
        let found = blame(&frames[4], frames.iter()).expect("something ran");
        assert_eq!((&*found.name, found.on_device), ("step", false));
        assert_eq!((found.micros, found.usual_micros), (900.0, 20.0));
        assert_eq!(blame(&Frame::default(), frames.iter()), None);
    }
}
