//! The f64 tracer.
