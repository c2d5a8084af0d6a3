//! Unit vectors of vectors of any size.

use glam::Vec3;

/// `v` at unit length, `fallback` for no length at all. Squares of very small or large vectors would leave
/// f32's range, so those are brought near 1 first: no length is too small to have a direction.
pub fn unit_or(v: Vec3, fallback: Vec3) -> Vec3 {
    let squared = v.length_squared();
    if squared > 1e-30 && squared < 1e30 {
        return v / squared.sqrt();
    }
    let largest = v.abs().max_element();
    if !(largest > 1e-37 && largest < 1e37) {
        return fallback;
    }
    (v / largest).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_length_has_a_direction() {
        for exponent in -36..=36 {
            let v = Vec3::new(3.0, 0.0, 4.0) * 10_f32.powi(exponent);
            let unit = unit_or(v, Vec3::Y);
            assert!(
                unit.abs_diff_eq(Vec3::new(0.6, 0.0, 0.8), 1e-6),
                "{v} gives {unit}"
            );
        }
        for nothing in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY] {
            assert_eq!(unit_or(nothing, Vec3::Y), Vec3::Y);
        }
    }
}
