//! A track's value as a pure function of time.

use glam::{DQuat, DVec3};

use crate::scene::fields::Value;
use crate::scene::schema::{Ease, Key, KeyValue, Loop, Rotation};
use crate::world::{Blend, hermite};

/// Keys in the form that is fastest to sample.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Rising; at least one.
    times: Vec<f64>,
    values: Values,
    /// How the value comes to each key from the one before.
    eases: Vec<Ease>,
    repeat: Loop,
}

#[derive(Clone, Debug)]
enum Values {
    Bool(Vec<bool>),
    Number(Vec<f64>),
    Vec3(Vec<DVec3>),
    /// Degrees, interpolated angle by angle.
    Euler(Vec<DVec3>),
    /// Signs chosen so that neighbours are less than half a turn apart.
    Quat(Vec<DQuat>),
}

impl Curve {
    /// The curve of keys of one kind, in order of time; none if there is no key.
    ///
    /// Rotations interpolate angle by angle if every key is written as `Euler`, else the short way round.
    pub fn new(keys: &[Key], repeat: Loop) -> Option<Self> {
        let values = match keys.first()?.value {
            KeyValue::Bool(_) => Values::Bool(collect(keys, |v| match v {
                KeyValue::Bool(v) => Some(v),
                _ => None,
            })?),
            KeyValue::Number(_) => Values::Number(collect(keys, |v| match v {
                KeyValue::Number(v) => Some(v),
                _ => None,
            })?),
            KeyValue::Vec3(_) => Values::Vec3(collect(keys, |v| match v {
                KeyValue::Vec3(v) => Some(v),
                _ => None,
            })?),
            KeyValue::Rotation(_) => rotations(keys)?,
        };
        Some(Self {
            times: keys.iter().map(|key| key.time).collect(),
            values,
            eases: keys.iter().map(|key| key.ease).collect(),
            repeat,
        })
    }

    /// The value at a time in seconds.
    pub fn at(&self, secs: f64) -> Value {
        let (i, t) = self.segment(self.local(secs));
        match &self.values {
            Values::Bool(v) => Value::Bool(v[if t < 1.0 { i } else { i + 1 }.min(v.len() - 1)]),
            Values::Number(v) => Value::Number(self.between(v, i, t)),
            Values::Vec3(v) => Value::Vec3(self.between(v, i, t)),
            Values::Euler(v) => Value::Rotation(Rotation::Euler(self.between(v, i, t)).quat()),
            Values::Quat(v) => Value::Rotation(self.turn(v, i, t)),
        }
    }

    /// The value of the key that is nearer to a time in seconds; of two, the later.
    pub fn nearer_key(&self, secs: f64) -> Value {
        let (i, t) = self.segment(self.local(secs));
        let next = usize::from(t >= 0.5 && i + 1 < self.times.len());
        match &self.values {
            Values::Bool(v) => Value::Bool(v[i + next]),
            Values::Number(v) => Value::Number(v[i + next]),
            Values::Vec3(v) => Value::Vec3(v[i + next]),
            Values::Euler(v) => Value::Rotation(Rotation::Euler(v[i + next]).quat()),
            Values::Quat(v) => Value::Rotation(v[i + next]),
        }
    }

    fn span(&self) -> (f64, f64) {
        (self.times[0], self.times[self.times.len() - 1])
    }

    /// The time between the first and the last key that `secs` stands for.
    fn local(&self, secs: f64) -> f64 {
        let (start, end) = self.span();
        self.repeat.wrap(secs, start, end)
    }

    /// The key before a time, and how far the next is reached, in [0, 1], before easing.
    fn segment(&self, time: f64) -> (usize, f64) {
        let last = self.times.len() - 1;
        if last == 0 {
            return (0, 0.0);
        }
        let i = self
            .times
            .partition_point(|&key| key <= time)
            .saturating_sub(1)
            .min(last - 1);
        let t = (time - self.times[i]) / (self.times[i + 1] - self.times[i]);
        (i, t.clamp(0.0, 1.0))
    }

    /// The eased share of the way from key i to the next.
    fn eased(&self, i: usize, t: f64) -> f64 {
        match self.eases[i + 1] {
            Ease::Step => t.floor(),
            Ease::Linear | Ease::Smooth => t,
            Ease::In => t * t * t,
            Ease::Out => 1.0 - (1.0 - t).powi(3),
            Ease::InOut => t * t * (3.0 - 2.0 * t),
        }
    }

    fn between<T: Blend>(&self, v: &[T], i: usize, t: f64) -> T {
        if v.len() == 1 || t == 0.0 {
            return v[i];
        }
        if t == 1.0 {
            return v[i + 1];
        }
        if self.eases[i + 1] == Ease::Smooth {
            let length = self.times[i + 1] - self.times[i];
            let (m0, m1) = (self.tangent(v, i) * length, self.tangent(v, i + 1) * length);
            return hermite(v[i], m0, v[i + 1], m1, t);
        }
        v[i] + (v[i + 1] - v[i]) * self.eased(i, t)
    }

    /// Catmull-Rom velocity at a key: that of the chord between its neighbours. A repeating curve goes on
    /// across its seam; an open one is straight at its ends.
    fn tangent<T: Blend>(&self, v: &[T], i: usize) -> T {
        let last = v.len() - 1;
        let chord = |a: usize, b: usize| (v[b] - v[a], self.times[b] - self.times[a]);
        let ((d0, t0), (d1, t1)) = match i {
            0 if self.repeat == Loop::Repeat => (chord(last - 1, last), chord(0, 1)),
            0 => return velocity(chord(0, 1)),
            i if i == last && self.repeat == Loop::Repeat => (chord(last - 1, last), chord(0, 1)),
            i if i == last => return velocity(chord(last - 1, last)),
            i => (chord(i - 1, i), chord(i, i + 1)),
        };
        velocity((d0 + d1, t0 + t1))
    }

    fn turn(&self, v: &[DQuat], i: usize, t: f64) -> DQuat {
        if v.len() == 1 || t == 0.0 {
            return v[i];
        }
        if t == 1.0 {
            return v[i + 1];
        }
        if self.eases[i + 1] == Ease::Smooth {
            // On the unit sphere the Hermite curve through quaternions, brought back to unit length.
            let blended = self.between(v, i, t);
            return blended.normalize();
        }
        v[i].slerp(v[i + 1], self.eased(i, t))
    }
}

fn collect<T>(keys: &[Key], of: impl Fn(KeyValue) -> Option<T>) -> Option<Vec<T>> {
    keys.iter().map(|key| of(key.value)).collect()
}

fn rotations(keys: &[Key]) -> Option<Values> {
    let written = collect(keys, |v| match v {
        KeyValue::Rotation(rotation) => Some(rotation),
        _ => None,
    })?;
    let angles: Option<Vec<DVec3>> = written
        .iter()
        .map(|rotation| match rotation {
            Rotation::Euler(degrees) => Some(*degrees),
            Rotation::Quat(_) => None,
        })
        .collect();
    if let Some(angles) = angles {
        return Some(Values::Euler(angles));
    }
    let mut quats: Vec<DQuat> = written.into_iter().map(Rotation::quat).collect();
    for i in 1..quats.len() {
        if quats[i].dot(quats[i - 1]) < 0.0 {
            quats[i] = -quats[i];
        }
    }
    Some(Values::Quat(quats))
}

fn velocity<T: Blend>((way, time): (T, f64)) -> T {
    way * (1.0 / time)
}
