//! How steeply a curve rises: the exponent of the power law that fits it best.

/// The slope of a line through the logarithms, the median of those of all pairs of points (Theil 1950, Sen 1968): y grows as x
/// to this power, and one point that something else came into does not change it much. None of fewer than two points, or
/// where all x are the same.
pub fn exponent(points: &[(f64, f64)]) -> Option<f64> {
    let points: Vec<(f64, f64)> = points
        .iter()
        .filter(|(x, y)| *x > 0.0 && *y > 0.0)
        .map(|(x, y)| (x.ln(), y.ln()))
        .collect();
    let mut slopes = Vec::new();
    for (i, a) in points.iter().enumerate() {
        let others = points[i + 1..].iter().filter(|b| b.0 != a.0);
        slopes.extend(others.map(|b| (b.1 - a.1) / (b.0 - a.0)));
    }
    slopes.sort_unstable_by(f64::total_cmp);
    let (low, high) = (slopes.len().saturating_sub(1) / 2, slopes.len() / 2);
    Some((slopes.get(low)? + slopes.get(high)?) / 2.0)
}

/// The part of a curve in which what grows counts for the most: its upper half, at least two points.
pub fn upper(points: &[(f64, f64)]) -> &[(f64, f64)] {
    let half = (points.len() / 2).min(points.len().saturating_sub(2));
    &points[half..]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn power_laws_have_their_exponents() {
        for power in [-0.5, 0.0, 0.3, 1.0, 2.0] {
            let law = |x: f64| (x, 7.0 * x.powf(power));
            let points: Vec<_> = [1.0, 10.0, 55.0, 1e4].into_iter().map(law).collect();
            let found = exponent(&points).expect("a slope");
            assert!((found - power).abs() < 1e-12, "{found} for {power}");
        }
        assert_eq!(exponent(&[(3.0, 1.0)]), None);
        assert_eq!(exponent(&[(3.0, 1.0), (3.0, 2.0)]), None);
    }

    #[test]
    fn one_point_that_is_off_changes_little() {
        let law = |x: f64| (x, 3.0 * x.powf(0.7));
        let mut points: Vec<_> = [1.0, 4.0, 16.0, 64.0, 256.0].into_iter().map(law).collect();
        points[4].1 *= 30.0;
        let found = exponent(&points).expect("a slope");
        assert!((found - 0.7).abs() < 0.05, "{found}");
    }

    #[test]
    fn the_upper_half_leaves_out_what_is_constant() {
        let points: Vec<_> = [1.0, 10.0, 100.0, 1e3, 1e4].map(|x| (x, 100.0 + x)).into();
        let all = exponent(&points).expect("a slope");
        let top = exponent(upper(&points)).expect("a slope");
        assert!(top > 1.5 * all, "{top} after {all}");
        assert_eq!(upper(&points[..2]).len(), 2);
        assert_eq!(upper(&points[..1]).len(), 1);
    }
}
