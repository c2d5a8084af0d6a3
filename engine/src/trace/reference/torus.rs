//! The torus in f64: the roots of its quartic, isolated by derivatives and refined by bisection.
//!
//! Between two neighbouring roots of its derivative a polynomial is monotone, so it has one root there or
//! none (Rolle); the derivatives' roots are found in the same way, down to a line. Slow and sure. The quartic is in the
//! distance from the ray's closest approach to the centre, where its coefficients are smallest; of a ray that
//! starts on the torus the root at zero is divided out.

use glam::{DVec2, DVec3};

use super::shape::{LocalHit, LocalRay};

/// All roots of the torus about Y of these radii, nearest first.
pub fn torus(ray: &LocalRay, major: f64, minor: f64) -> Vec<LocalHit> {
    let length = ray.dir.length();
    let along = ray.dir / length;
    let starts_on = ray.start.is_some();
    let middle = if starts_on {
        0.0
    } else {
        -ray.origin.dot(along)
    };
    let from = ray.origin + along * middle;
    let end = 2.0 * (major + minor);
    if from.length() > end {
        return Vec::new();
    }
    let quartic = quartic(from, along, major, minor);
    let found = if starts_on {
        roots(&quartic[1..], 0.0, end)
    } else {
        roots(&quartic, -end, end)
    };
    let polished = found.into_iter().map(|s| {
        let (excess, slope) = excess(from + along * s, along, major, minor);
        let step = excess / slope;
        // Not next to a root that was divided out, nor where the ray only touches.
        if step.abs() < 1e-6 * s.abs() {
            s - step
        } else {
            s
        }
    });
    polished
        .map(|s| LocalHit::on(0, (middle + s) / length))
        .collect()
}

/// The point moved onto the torus.
pub fn on_torus(point: DVec3, major: f64, minor: f64) -> DVec3 {
    let ring = ring(point, major);
    ring + (point - ring).normalize_or(DVec3::Y) * minor
}

/// Outward normal at a point of the torus, of any length.
pub fn torus_normal(point: DVec3, major: f64) -> DVec3 {
    point - ring(point, major)
}

/// The point of the ring in the middle of the tube that is nearest to a point.
fn ring(point: DVec3, major: f64) -> DVec3 {
    let out = DVec2::new(point.x, point.z).normalize_or(DVec2::X) * major;
    DVec3::new(out.x, 0.0, out.y)
}

/// Coefficients of (|p|^2 + R^2 - r^2)^2 - 4 R^2 (x^2 + z^2) along a line, the constant first.
fn quartic(from: DVec3, along: DVec3, major: f64, minor: f64) -> [f64; 5] {
    let flat = |a: DVec3, b: DVec3| a.x * b.x + a.z * b.z;
    let square = 4.0 * major * major;
    let center = from.dot(from) + (major - minor) * (major + minor);
    let slope = 2.0 * from.dot(along);
    [
        center * center - square * flat(from, from),
        2.0 * center * slope - 2.0 * square * flat(from, along),
        slope * slope + 2.0 * center - square * flat(along, along),
        2.0 * slope,
        1.0,
    ]
}

/// The squared distance to the ring less that of the surface, and its slope along a direction.
fn excess(point: DVec3, along: DVec3, major: f64, minor: f64) -> (f64, f64) {
    let out = torus_normal(point, major);
    (out.length_squared() - minor * minor, 2.0 * out.dot(along))
}

/// Roots of a polynomial within a range, in order. Coefficients are the constant first.
fn roots(polynomial: &[f64], low: f64, high: f64) -> Vec<f64> {
    if polynomial.len() < 2 {
        return Vec::new();
    }
    let derivative: Vec<f64> = polynomial
        .iter()
        .zip(0_u32..)
        .skip(1)
        .map(|(c, power)| c * f64::from(power))
        .collect();
    let mut places = roots(&derivative, low, high);
    places.insert(0, low);
    places.push(high);
    let value = |s: f64| polynomial.iter().rev().fold(0.0, |sum, c| sum * s + c);
    places
        .windows(2)
        .filter_map(|span| bisect(value, span[0], span[1]))
        .collect()
}

/// Where a function changes its sign, to the last bit; none where it does not.
fn bisect(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> Option<f64> {
    let is_below = f(low) < 0.0;
    if is_below == (f(high) < 0.0) {
        return None;
    }
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return Some(middle);
        }
        if (f(middle) < 0.0) == is_below {
            low = middle;
        } else {
            high = middle;
        }
    }
}
