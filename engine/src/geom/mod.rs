//! Pure maths of rays against shapes, in f32 as the fast tracers do it.
