//! How steeply a curve rises: the exponent of the power law that fits it best.

/// The slope of a line through the logarithms, by least squares: y grows as x to this power. None of fewer than two
/// points, or where all x are the same.
pub fn exponent(points: &[(f64, f64)]) -> Option<f64> {
    let points: Vec<(f64, f64)> = points
        .iter()
        .filter(|(x, y)| *x > 0.0 && *y > 0.0)
        .map(|(x, y)| (x.ln(), y.ln()))
        .collect();
    let count = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let spread: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    let shared: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    (spread > 0.0).then(|| shared / spread)
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
    fn the_upper_half_leaves_out_what_is_constant() {
        let points: Vec<_> = [1.0, 10.0, 100.0, 1e3, 1e4].map(|x| (x, 100.0 + x)).into();
        let all = exponent(&points).expect("a slope");
        let top = exponent(upper(&points)).expect("a slope");
        assert!(top > 1.5 * all, "{top} after {all}");
        assert_eq!(upper(&points[..2]).len(), 2);
        assert_eq!(upper(&points[..1]).len(), 1);
    }
}
