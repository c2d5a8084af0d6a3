//! Values of displays, which files hold, as the light they stand for.

/// Linear light of an sRGB value (IEC 61966-2-1); beyond 1 it goes on as the power it ends with.
pub fn linear_from_srgb(x: f32) -> f32 {
    if x <= 0.040_45 {
        x / 12.92
    } else {
        ((x + 0.055) / 1.055).powf(2.4)
    }
}
