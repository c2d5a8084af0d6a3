//! FrameScene to rows (stub).
/// Rows.
#[derive(Default)]
pub struct PackedScene {}
