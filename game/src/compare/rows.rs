//! What two captures have, name by name: medians, and whether the second takes more than is let through.

use std::collections::BTreeMap;

use orrery_engine::profile::export::capture::{Capture, FrameRecord};
use orrery_engine::profile::percentile_of_sorted;

/// Counts of work, of which more is worse; the others are of work left out, or of what a picture lacks.
const WORK: [&str; 8] = [
    "camera rays",
    "mirrored rays",
    "refracted rays",
    "shadow rays",
    "pixels on edges",
    "bytes uploaded",
    "instance tree's nodes written",
    "trees updated",
];

/// The share of the frame's time below which a difference is noise.
const NOISE: f64 = 0.01;

/// What a row is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// The frame as a whole.
    Frame,
    /// A system, microseconds with what lies within.
    System,
    /// A step of a system.
    Step,
    /// What the device did.
    Pass,
    /// A count.
    Count,
}

impl Kind {
    /// In the table.
    pub fn word(self) -> &'static str {
        match self {
            Self::Frame => "frame",
            Self::System => "system",
            Self::Step => "step",
            Self::Pass => "pass",
            Self::Count => "count",
        }
    }

    /// A value of this kind: milliseconds, or a whole number.
    pub fn value(self, value: f64) -> String {
        match self {
            Self::Count => format!("{value:.0}"),
            _ => format!("{:.3}", value * 1e-3),
        }
    }
}

/// A name in both captures, or in one: what it did not do took nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What it is of.
    pub kind: Kind,
    /// Of the system, step, pass or count.
    pub name: String,
    /// Of A and B: microseconds, or how many.
    pub medians: [f64; 2],
    /// What 95 % of frames do not exceed.
    pub p95: [f64; 2],
    /// B takes more than A by more than the limit.
    pub is_regression: bool,
    /// Worth showing.
    pub is_notable: bool,
}

impl Row {
    /// B's median over A's.
    pub fn ratio_in_words(&self) -> String {
        match self.medians {
            [0.0, 0.0] => "1.00".into(),
            [0.0, _] => "new".into(),
            [_, 0.0] => "gone".into(),
            [a, b] => format!("{:.2}", b / a),
        }
    }

    /// From what to what.
    pub fn change(&self) -> String {
        let [a, b] = self.medians.map(|value| self.kind.value(value));
        let unit = if self.kind == Kind::Count { "" } else { " ms" };
        format!("from {a}{unit} to {b}{unit}")
    }
}

type Samples = BTreeMap<(Kind, String), Vec<f64>>;

/// The rows, whole frames first, then those that differ most.
pub fn rows(a: &Capture, b: &Capture, limit_percent: f64) -> Vec<Row> {
    let captures = [a, b];
    let samples = captures.map(samples);
    let counts = captures.map(|capture| capture.frames.len());
    let frame = captures.map(|capture| {
        let work = capture.frames.iter().map(FrameRecord::work_micros);
        spread(work.collect(), capture.frames.len())[0]
    });
    let noise = NOISE * frame[0].max(frame[1]);
    let mut names: Vec<&(Kind, String)> = samples.iter().flat_map(BTreeMap::keys).collect();
    names.sort();
    names.dedup();
    let mut rows: Vec<Row> = names
        .into_iter()
        .map(|name| {
            let spread = |side: usize| {
                let taken = samples[side].get(name).cloned().unwrap_or_default();
                spread(taken, counts[side])
            };
            let sides = [spread(0), spread(1)];
            row(name, sides, limit_percent, noise)
        })
        .collect();
    let weight = |row: &Row| {
        let [a, b] = row.medians;
        (b - a).abs()
    };
    rows.sort_by(|x, y| {
        let group = |row: &Row| match row.kind {
            Kind::Frame => 0,
            Kind::System | Kind::Step | Kind::Pass => 1,
            Kind::Count => 2,
        };
        group(x)
            .cmp(&group(y))
            .then(weight(y).total_cmp(&weight(x)))
    });
    rows
}

fn row((kind, name): &(Kind, String), sides: [[f64; 2]; 2], limit_percent: f64, noise: f64) -> Row {
    let medians = sides.map(|side| side[0]);
    let [a, b] = medians;
    let is_past = b > a * (1.0 + limit_percent * 1e-2);
    let (is_regression, is_notable) = match kind {
        Kind::Count => {
            let is_work = WORK.contains(&name.as_str());
            (is_work && is_past, a != b)
        }
        // The wait is no work: it is what the display, not the program, takes.
        Kind::Frame if name == "wait" || name == "interval" => (false, true),
        Kind::Frame => (is_past && b - a > noise, true),
        _ => (is_past && b - a > noise, (b - a).abs() > noise),
    };
    Row {
        kind: *kind,
        name: name.clone(),
        medians,
        p95: sides.map(|side| side[1]),
        is_regression,
        is_notable,
    }
}

/// Median and 95th percentile over `count` frames; those without a sample took nothing.
fn spread(mut taken: Vec<f64>, count: usize) -> [f64; 2] {
    taken.resize(count.max(taken.len()), 0.0);
    taken.sort_unstable_by(f64::total_cmp);
    [0.5, 0.95].map(|q| percentile_of_sorted(&taken, q))
}

/// What every name took, a sample for each frame that has it: its runs there added up.
fn samples(capture: &Capture) -> Samples {
    let mut samples = Samples::new();
    for frame in &capture.frames {
        let mut taken: BTreeMap<(Kind, String), f64> = BTreeMap::new();
        let mut add = |kind, name: &str, value: f64| {
            *taken.entry((kind, name.to_owned())).or_default() += value;
        };
        add(Kind::Frame, "work", frame.work_micros());
        add(Kind::Frame, "wait", frame.wait);
        if frame.interval > 0.0 {
            add(Kind::Frame, "interval", frame.interval);
        }
        for (name, _, micros, depth) in &frame.spans {
            let kind = if *depth == 0 {
                Kind::System
            } else {
                Kind::Step
            };
            add(kind, name, *micros);
        }
        for (name, _, micros, _) in &frame.passes {
            add(Kind::Pass, name, *micros);
        }
        for (name, count) in &frame.counters {
            add(Kind::Count, name, *count as f64);
        }
        for (name, value) in taken {
            samples.entry(name).or_default().push(value);
        }
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;

    fn capture(slow: f64, small: f64, rays: u64) -> Capture {
        let frame = |id| FrameRecord {
            id,
            secs: 0.0,
            start: 0.0,
            micros: 10_000.0 + slow + small,
            wait: 0.0,
            interval: 16_000.0,
            spans: vec![
                ("steady".into(), 0.0, 10_000.0, 0),
                ("slow".into(), 10_000.0, slow, 0),
                ("small".into(), 10_000.0 + slow, small, 0),
            ],
            passes: vec![("whitted".into(), 0.0, 500.0, 1.0)],
            counters: [
                ("shadow rays".to_owned(), rays),
                ("trees kept".to_owned(), rays),
            ]
            .into(),
        };
        Capture {
            device: "test".into(),
            frames: (0..9).map(frame).collect(),
        }
    }

    fn regressions(a: &Capture, b: &Capture) -> Vec<String> {
        let rows = rows(a, b, 10.0);
        let worse = rows.into_iter().filter(|row| row.is_regression);
        worse.map(|row| row.name).collect()
    }

    #[test]
    fn more_time_past_the_limit_is_a_regression_and_noise_is_none() {
        let before = capture(1000.0, 1.0, 100);
        assert_eq!(regressions(&before, &before), [""; 0]);
        // Three times as much, but a fraction of the frame.
        assert_eq!(regressions(&before, &capture(1000.0, 3.0, 100)), [""; 0]);
        let after = capture(2500.0, 1.0, 100);
        assert_eq!(regressions(&before, &after), ["work", "slow"]);
        assert_eq!(regressions(&after, &before), [""; 0]);
        let first = &rows(&before, &after, 10.0)[0];
        assert_eq!((first.kind, first.is_notable), (Kind::Frame, true));
    }

    #[test]
    fn more_counted_work_is_a_regression_and_more_left_out_is_none() {
        let (few, many) = (capture(0.0, 0.0, 100), capture(0.0, 0.0, 120));
        assert_eq!(regressions(&few, &many), ["shadow rays"]);
        assert_eq!(regressions(&many, &few), [""; 0]);
    }

    #[test]
    fn what_is_new_or_gone_is_told() {
        let before = capture(1000.0, 1.0, 100);
        let mut after = before.clone();
        for frame in &mut after.frames {
            frame.spans[1].0 = "renamed".into();
        }
        let rows = rows(&before, &after, 10.0);
        let words = |name: &str| {
            let row = rows.iter().find(|row| row.name == name);
            row.map(Row::ratio_in_words)
        };
        assert_eq!(words("slow").as_deref(), Some("gone"));
        assert_eq!(words("renamed").as_deref(), Some("new"));
        assert_eq!(regressions(&before, &after), ["renamed"]);
    }
}
