//! Which points nothing else beats: the Pareto front of each device and measure.

use super::knobs::Panel;
use super::point::Point;
use crate::bench::report::{Better, Row};

/// A measure of error that a chart shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// Pixels off by more than 1/255, per million.
    Mismatch,
    /// What 99.9 % of the pixels do not exceed.
    P999,
    /// Relative mean square error against 256 samples.
    RelativeMse,
}

impl Measure {
    /// All, as charts stand side by side.
    pub const ALL: [Self; 3] = [Self::Mismatch, Self::P999, Self::RelativeMse];

    /// Whose points it judges.
    pub fn panel(self) -> Panel {
        match self {
            Self::Mismatch | Self::P999 => Panel::Arithmetic,
            Self::RelativeMse => Panel::Sampling,
        }
    }

    /// Its value at a point.
    pub fn of(self, point: &Point) -> f64 {
        match self {
            Self::Mismatch => point.error.mismatch_ppm,
            Self::P999 => point.error.p999,
            Self::RelativeMse => point.error.relative_mse,
        }
    }

    /// As charts and tables call it.
    pub fn title(self) -> &'static str {
        match self {
            Self::Mismatch => "pixels off by more than 1/255, ppm",
            Self::P999 => "error that 99.9 % of pixels stay below",
            Self::RelativeMse => "relMSE against 256 samples",
        }
    }

    fn place(self) -> usize {
        Self::ALL.iter().position(|&m| m == self).unwrap_or(0)
    }
}

/// Finds, for every point, the measures by which it is beaten: another point of its backend errs no more and is
/// faster by more than both scatter.
pub fn mark(points: &mut [Point]) {
    let all = points.to_vec();
    for point in points {
        for measure in Measure::ALL {
            let is_better = |other: &Point| {
                other.panel == point.panel
                    && other.backend == point.backend
                    && measure.of(other) <= measure.of(point)
                    && other.p95 < point.p05
            };
            point.is_beaten[measure.place()] = all.iter().any(is_better);
        }
    }
}

/// Whether a point is beaten by a measure.
pub fn is_beaten(point: &Point, measure: Measure) -> bool {
    point.is_beaten[measure.place()]
}

/// A row for each backend and measure: how many defaults are off the front.
pub fn default_rows(class: &str, points: &[Point]) -> Vec<Row> {
    let defaults = points.iter().filter(|point| point.is_default);
    defaults
        .flat_map(|point| {
            let measures = Measure::ALL.into_iter();
            let measures = measures.filter(|measure| measure.panel() == point.panel);
            measures.map(move |measure| {
                let name = format!("{class}.{}.default_beaten.{measure:?}", point.backend);
                let beaten = f64::from(u8::from(is_beaten(point, measure)));
                Row::single(name, "points", Better::Lower, beaten).with_target(0.0)
            })
        })
        .collect()
}
