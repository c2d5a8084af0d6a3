//! Orrery's test harness: ground truth, picture metrics, and what the suite in `tests/suite` shares.

pub mod metrics;
pub mod mutate;
pub mod panes;
pub mod program;
pub mod random_looks;
pub mod random_scene;
pub mod scene_json;
pub mod tracers;
pub mod truth;
