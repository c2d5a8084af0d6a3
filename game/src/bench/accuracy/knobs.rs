//! The knobs that trade run time for error, each turned by itself from the engine's defaults.

use orrery_engine::frame::{BoxTest, FrameScene, Kernels, Offset, TraceSettings, TriangleTest};

/// What a setting is judged by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Panel {
    /// One sample a pixel, against one sample of the reference.
    Arithmetic,
    /// Any number of samples, against 256 of the reference.
    Sampling,
}

/// One setting of one knob.
#[derive(Clone, Debug)]
pub struct Knob {
    /// As rows and charts call it.
    pub name: String,
    /// What it is judged by.
    pub panel: Panel,
    /// The engine as it comes.
    pub is_default: bool,
    /// Generations followed, if fewer than the scene's.
    pub depth: Option<u32>,
    /// See [`TraceSettings::cutoff`]; none: the default.
    pub cutoff: Option<f32>,
    /// See [`TraceSettings::kernels`].
    pub kernels: Kernels,
    /// See [`TraceSettings::samples`].
    pub samples: u32,
    /// See [`TraceSettings::adaptive`].
    pub adaptive: Option<f32>,
    /// Traced pixels for each of the picture's, along an axis; enlarged by linear interpolation.
    pub scale: f64,
}

impl Knob {
    fn new(panel: Panel, name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            panel,
            is_default: false,
            depth: None,
            cutoff: None,
            kernels: Kernels::default(),
            samples: 1,
            adaptive: None,
            scale: 1.0,
        }
    }

    /// A frame with no more generations than the knob allows.
    pub fn shorten(&self, mut frame: FrameScene) -> FrameScene {
        let most = self.depth.unwrap_or(u32::MAX);
        frame.max_generations = frame.max_generations.min(most);
        frame
    }

    /// Turns a run's settings.
    pub fn turn(&self, settings: TraceSettings) -> TraceSettings {
        TraceSettings {
            cutoff: self.cutoff.unwrap_or(settings.cutoff),
            kernels: self.kernels,
            samples: self.samples,
            adaptive: self.adaptive,
            size: (settings.size.as_dvec2() * self.scale).round().as_uvec2(),
            ..settings
        }
    }
}

/// All, the defaults first in each panel.
pub fn all() -> Vec<Knob> {
    let mut knobs = arithmetic();
    knobs.extend(sampling());
    knobs
}

fn arithmetic() -> Vec<Knob> {
    let knob = |name: &str| Knob::new(Panel::Arithmetic, name);
    let with = |name: &str, kernels| Knob {
        kernels,
        ..knob(name)
    };
    let robust = Kernels::default();
    let mut knobs = vec![
        Knob {
            is_default: true,
            ..knob("default")
        },
        with(
            "Moller-Trumbore",
            Kernels {
                triangles: TriangleTest::MollerTrumbore,
                ..robust
            },
        ),
        with(
            "bare boxes",
            Kernels {
                boxes: BoxTest::Bare,
                ..robust
            },
        ),
        with(
            "fixed offset",
            Kernels {
                offsets: Offset::Fixed,
                ..robust
            },
        ),
    ];
    knobs.extend([1, 2, 3, 5].map(|depth| Knob {
        depth: Some(depth),
        ..knob(&format!("depth {depth}"))
    }));
    knobs.extend([1e-1, 1e-2, 1e-3, 1e-4, 1e-6].map(|cutoff| Knob {
        cutoff: Some(cutoff),
        ..knob(&format!("cutoff {cutoff:.0e}"))
    }));
    knobs
}

fn sampling() -> Vec<Knob> {
    let knob = |name: &str| Knob::new(Panel::Sampling, name);
    let mut knobs = vec![Knob {
        is_default: true,
        ..knob("1 sample")
    }];
    knobs.extend([2, 4, 16, 64].map(|samples| Knob {
        samples,
        ..knob(&format!("{samples} samples"))
    }));
    knobs.extend([4, 16, 64].map(|samples| Knob {
        samples,
        adaptive: Some(TraceSettings::EDGE_CONTRAST),
        ..knob(&format!("{samples} at edges"))
    }));
    knobs.push(Knob {
        scale: 0.5,
        ..knob("half size")
    });
    knobs
}
