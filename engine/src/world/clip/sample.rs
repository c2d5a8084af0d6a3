//! A track's numbers as a pure function of time.

use glam::DQuat;

use super::{Channel, Interpolation, Track};
use crate::world::hermite;

impl Track {
    /// Numbers of one key of the value itself, without the velocities of a cubic one.
    pub fn width(&self) -> usize {
        self.values.len() / (self.rows_a_key() * self.times.len().max(1))
    }

    /// Rows of [`Track::width`] numbers that a key has.
    fn rows_a_key(&self) -> usize {
        match self.interpolation {
            Interpolation::Step | Interpolation::Linear => 1,
            Interpolation::Cubic | Interpolation::Squad => 3,
        }
    }

    /// Says what keeps a track from being played.
    ///
    /// # Errors
    /// A sentence: no key, times that fall or are not finite, too few or too many numbers, a number that is not finite.
    pub fn check(&self) -> Result<(), String> {
        if self.times.is_empty() {
            return Err("a track has no key".into());
        }
        if !self.times.iter().all(|time| time.is_finite()) || !self.times.is_sorted() {
            return Err("the times of a track's keys are not finite or fall".into());
        }
        let (keys, numbers) = (self.times.len(), self.values.len());
        let width = match self.channel {
            Channel::Translation | Channel::Scale => 3,
            Channel::Rotation => 4,
            Channel::VerticalFov | Channel::Shown => 1,
            Channel::Weights => self.width(),
        };
        if self.interpolation == Interpolation::Squad && self.channel != Channel::Rotation {
            return Err("a track that is no rotation bends as rotations do".into());
        }
        if width == 0 || numbers != width * keys * self.rows_a_key() {
            return Err(format!("a track has {numbers} numbers for {keys} keys"));
        }
        match self.values.iter().all(|number| number.is_finite()) {
            true => Ok(()),
            false => Err("a number of a track is not finite".into()),
        }
    }

    /// Appends the numbers at a time in seconds to `out`. Before the first key and after the last, that key holds.
    ///
    /// The track is one that [`Track::check`] passes.
    pub fn sample(&self, secs: f64, out: &mut Vec<f64>) {
        let last = self.times.len() - 1;
        let next = self.times.partition_point(|&key| key <= secs);
        let Some(before) = next.checked_sub(1) else {
            return out.extend(self.value(0));
        };
        let step = self.interpolation == Interpolation::Step;
        if before == last || step || self.times[before] == secs {
            return out.extend(self.value(before));
        }
        let length = self.times[next] - self.times[before];
        let t = (secs - self.times[before]) / length;
        let first = out.len();
        let (a, b) = (self.value(before), self.value(next));
        match (self.interpolation, self.channel) {
            (Interpolation::Cubic, _) => {
                let leave = self.row(3 * before + 2);
                let reach = self.row(3 * next);
                let numbers = a.iter().zip(leave).zip(b.iter().zip(reach));
                out.extend(
                    numbers.map(|((&p0, &m0), (&p1, &m1))| {
                        hermite(p0, m0 * length, p1, m1 * length, t)
                    }),
                );
            }
            (Interpolation::Squad, _) => {
                let bends = [self.row(3 * before + 2), self.row(3 * next)];
                let [a, b, leave, reach] = [a, b, bends[0], bends[1]].map(DQuat::from_slice);
                let (along, bent) = (a.slerp(b, t), leave.slerp(reach, t));
                return out.extend(along.slerp(bent, 2.0 * t * (1.0 - t)).to_array());
            }
            (_, Channel::Rotation) => {
                let [a, b] = [a, b].map(DQuat::from_slice);
                return out.extend(a.slerp(b, t).to_array());
            }
            _ => out.extend(a.iter().zip(b).map(|(&a, &b)| a + (b - a) * t)),
        }
        if self.channel == Channel::Rotation {
            // The curve through the four numbers leaves the unit sphere.
            let turn = DQuat::from_slice(&out[first..]);
            let turn = if turn.length_squared() > 0.0 {
                turn.normalize()
            } else {
                DQuat::from_slice(a)
            };
            out[first..].copy_from_slice(&turn.to_array());
        }
    }

    /// The value of a key.
    fn value(&self, key: usize) -> &[f64] {
        match self.interpolation {
            Interpolation::Cubic | Interpolation::Squad => self.row(3 * key + 1),
            Interpolation::Step | Interpolation::Linear => self.row(key),
        }
    }

    fn row(&self, row: usize) -> &[f64] {
        let width = self.width();
        &self.values[row * width..(row + 1) * width]
    }
}
