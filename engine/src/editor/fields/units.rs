//! What a number means: its unit, how it is shown, what it may be. Components hold radians and plain numbers; people read
//! degrees, and do not type what no picture can be made of.

use std::ops::RangeInclusive;

/// How a number is shown and changed.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    /// What is written behind it.
    pub suffix: &'static str,
    /// Shown number for a held one of 1.
    pub factor: f64,
    /// What may be typed, in shown numbers.
    pub range: RangeInclusive<f64>,
    /// Shown change for a point of dragging; none: in proportion to the number.
    pub pace: Option<f64>,
    /// Both ends of the range are reached by hand: a slider.
    pub slides: bool,
}

/// As far as the scene file lets numbers be.
const ANY: RangeInclusive<f64> = f64::MIN..=f64::MAX;
/// More than nothing.
const POSITIVE: RangeInclusive<f64> = 1e-9..=f64::MAX;
/// Nothing or more.
const NOT_NEGATIVE: RangeInclusive<f64> = 0.0..=f64::MAX;

impl Unit {
    const PLAIN: Self = Self {
        suffix: "",
        factor: 1.0,
        range: ANY,
        pace: None,
        slides: false,
    };

    fn plain(suffix: &'static str, range: RangeInclusive<f64>) -> Self {
        Self {
            suffix,
            range,
            ..Self::PLAIN
        }
    }

    fn angle(range: RangeInclusive<f64>) -> Self {
        Self {
            suffix: "\u{b0}",
            factor: 1_f64.to_radians().recip(),
            range,
            pace: Some(0.5),
            slides: false,
        }
    }

    fn share() -> Self {
        Self {
            range: 0.0..=1.0,
            slides: true,
            ..Self::PLAIN
        }
    }

    /// The unit of a field of a component.
    pub fn of(component: &str, field: &str) -> Self {
        match (component, field) {
            (_, "vertical_fov") => Self::angle(0.1..=179.0),
            ("SpotLight", "inner_angle" | "outer_angle") => Self::angle(0.0..=90.0),
            (_, "phase") | ("Twist", "angle" | "rate" | "swing") => Self::angle(ANY),
            (_, "period" | "start") => Self::plain(" s", ANY),
            (_, "exposure") => Self::plain(" stops", -30.0..=30.0),
            ("Material", "transmit" | "filter") => Self::share(),
            ("Material", "ior") => Self::plain("", 0.01..=100.0),
            ("Material", "alpha_cutoff" | "value") => Self::share(),
            ("Material", "diffuse" | "emission" | "strength" | "exponent") => {
                Self::plain("", NOT_NEGATIVE)
            }
            (_, "intensity" | "radius_a" | "radius_b") => Self::plain("", NOT_NEGATIVE),
            ("Orbit", "radius") => Self::PLAIN,
            (_, "radius" | "major" | "minor" | "height" | "length" | "distance" | "power")
                if component != "Plane" =>
            {
                Self::plain("", POSITIVE)
            }
            _ => Self::PLAIN,
        }
    }

    /// A held number as it is shown.
    pub fn shown(&self, held: f64) -> f64 {
        held * self.factor
    }

    /// A shown number as it is held: an angle that is typed comes to the radians that the scene file's degrees do.
    pub fn held(&self, shown: f64) -> f64 {
        if self.factor == 1.0 {
            shown
        } else {
            shown.to_radians()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_shown_in_degrees_and_held_in_radians() {
        let unit = Unit::of("SpotLight", "outer_angle");
        assert!((unit.shown(std::f64::consts::FRAC_PI_6) - 30.0).abs() < 1e-12);
        assert_eq!(unit.held(30.0), 30_f64.to_radians());
        assert_eq!(unit.suffix, "\u{b0}");
    }

    #[test]
    fn what_may_be_negative_may_be() {
        assert!(Unit::of("Plane", "distance").range.contains(&-3.0));
        assert!(Unit::of("Orbit", "period").range.contains(&-3.0));
        assert!(!Unit::of("Sphere", "radius").range.contains(&0.0));
        assert_eq!(Unit::of("Material", "transmit").range, 0.0..=1.0);
    }
}
