//! The CPU tracer.
