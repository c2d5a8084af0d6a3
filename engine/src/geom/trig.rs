//! Sine and cosine in f32, the same bits on every machine: for whoever must agree with a shader.
//!
//! Called by the f32 deformation of meshes. Reduction in three steps (Cody and Waite 1980), polynomials of the
//! Cephes library (Moshier; `sinf.c`). Plain products and sums, nothing fused: WGSL computes the same.

/// Nearest multiple: adding and taking away 1.5 * 2^23 rounds to the nearest whole number, ties to even.
const ROUNDER: f32 = 12_582_912.0;
/// pi/2 = HIGH + MIDDLE + LOW; whole numbers up to 2^13 times HIGH and MIDDLE are exact.
const HIGH: f32 = 1.570_312_5;
const MIDDLE: f32 = 4.837_513e-4;
const LOW: f32 = 7.549_79e-8;

/// Sine and cosine of an angle in radians.
///
/// Within 1.2e-7 for angles up to 8192 either way, and within 2 ulp up to 3.2; less and less exact beyond, yet
/// never outside [-1.01, 1.01]. NaN and infinity give NaN.
pub fn sin_cos(radians: f32) -> (f32, f32) {
    let quarter_turns = (radians * std::f32::consts::FRAC_2_PI + ROUNDER) - ROUNDER;
    let reduced = radians - quarter_turns * HIGH - quarter_turns * MIDDLE - quarter_turns * LOW;
    // Far out the reduction is worthless; this keeps the polynomials from running away.
    let x = reduced.clamp(-0.8, 0.8);
    let z = x * x;
    let sin = ((-1.951_529_6e-4 * z + 8.332_161e-3) * z - 1.666_665_5e-1) * z * x + x;
    let cos = ((2.443_315_7e-5 * z - 1.388_731_6e-3) * z + 4.166_664_6e-2) * z * z - 0.5 * z + 1.0;
    let quadrant = quarter_turns as i32;
    let (sin, cos) = if quadrant & 1 == 0 {
        (sin, cos)
    } else {
        (cos, sin)
    };
    (
        if quadrant & 2 == 0 { sin } else { -sin },
        if (quadrant + 1) & 2 == 0 { cos } else { -cos },
    )
}

/// Angle of the point (x, y) from the x axis, -pi to pi; 1e-5 off at most. Polynomial: Abramowitz and Stegun 4.4.49's form,
/// minimax on [0, 1].
pub fn angle_of(y: f32, x: f32) -> f32 {
    let low = x.abs().min(y.abs());
    let t = low / x.abs().max(y.abs()).max(1e-30);
    let z = t * t;
    let series = (((-0.011_721_2 * z + 0.052_653_32) * z - 0.116_432_87) * z + 0.193_543_46) * z;
    let mut angle = (series - 0.332_623_47) * z * t + 0.999_977_26 * t;
    if y.abs() > x.abs() {
        angle = std::f32::consts::FRAC_PI_2 - angle;
    }
    if x < 0.0 {
        angle = std::f32::consts::PI - angle;
    }
    if y < 0.0 { -angle } else { angle }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(radians: f32, relative: bool) {
        let (sin, cos) = sin_cos(radians);
        let (exact_sin, exact_cos) = f64::from(radians).sin_cos();
        for (found, exact) in [(sin, exact_sin), (cos, exact_cos)] {
            let error = (f64::from(found) - exact).abs();
            assert!(error <= 1.2e-7, "{radians}: {found} != {exact}");
            let near = exact as f32;
            let ulp = f64::from((near.abs().next_up() - near.abs()).max(f32::MIN_POSITIVE));
            let ulps = error / ulp;
            assert!(
                !relative || ulps <= 2.0,
                "{radians}: {ulps} ulp off {exact}"
            );
        }
    }

    #[test]
    fn sines_agree_with_f64() {
        let mut radians = -3.2_f32;
        while radians <= 3.2 {
            // Beside the zeros but the first, the reduction's last bits show.
            check(radians, radians.abs() < 1.5);
            radians += 1.371e-4;
        }
        let mut radians = -8192.0_f32;
        while radians <= 8192.0 {
            check(radians, false);
            radians += 0.103_7;
        }
        for quarter in -5000..5000 {
            let radians = (f64::from(quarter) * std::f64::consts::FRAC_PI_2) as f32;
            for radians in [radians.next_down(), radians, radians.next_up()] {
                check(radians, false);
            }
        }
    }

    #[test]
    fn huge_angles_stay_bounded() {
        let mut radians = 1e4_f32;
        while radians < 1e38 {
            let (sin, cos) = sin_cos(radians);
            assert!(
                sin.abs() <= 1.01 && cos.abs() <= 1.01,
                "{radians}: {sin} {cos}"
            );
            radians *= 1.37;
        }
        assert_eq!(sin_cos(0.0), (0.0, 1.0));
        assert!(sin_cos(f32::INFINITY).0.is_nan());
    }

    #[test]
    fn angles_go_all_round() {
        for step in -1800..1800 {
            let angle = f64::from(step).to_radians() * 0.1;
            let found = angle_of(3.0 * angle.sin() as f32, 3.0 * angle.cos() as f32);
            assert!(
                (f64::from(found) - angle).abs() < 1.2e-5,
                "{angle}: {found}"
            );
        }
        assert_eq!(angle_of(0.0, 0.0), 0.0);
    }
}
