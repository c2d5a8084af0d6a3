//! Keys of transforms (`k`): the splines of Kochanek and Bartels ("Interpolating splines with local tension,
//! continuity, and bias control", SIGGRAPH 1984), as tracks of the nodes they move.
//!
//! The first and the last key only give tangents; before the second and after the last but one, nothing moves. The velocity
//! at a key counts the unequal lengths of the stretches on both sides (Kochanek and Bartels, section 4). Rotations are `squad`
//! curves (Shoemake, "Quaternion calculus and fast animation", SIGGRAPH course notes 10, 1987), as those of BART (Lext, Assarsson
//! and Möller 2000): the quaternions that bend the curve at a key give it those velocities.

use glam::{DQuat, DVec3, DVec4};

use super::moving::stretched;
use super::stage::{Stage, turned};
use super::words::Words;
use crate::import::Warnings;
use crate::world::{Channel, Clip, Interpolation, Track, Transform};

/// Times and values that the tracks of a file may come to: keys of one name move all transforms of that name.
const KEYS: usize = 1 << 22;
/// What a track takes off them besides.
const A_TRACK: usize = 16;

/// All keys of one transform.
#[derive(Debug, Default)]
pub struct Block {
    name: String,
    tracks: Vec<Track>,
}

/// A value at a time.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    pub time: f64,
    /// Three numbers, or a quaternion.
    pub value: DVec4,
    pub tension: f64,
    pub continuity: f64,
    pub bias: f64,
}

impl Block {
    /// What follows `k`.
    pub fn read(words: &mut Words, warnings: &mut Warnings) -> Result<Self, String> {
        let name = words.word("the name of a transform")?.to_owned();
        words.expect("{")?;
        let mut block = Self {
            name,
            ..Self::default()
        };
        loop {
            let kind = words.word("`}`")?;
            let channel = match kind {
                "}" => return Ok(block),
                "transl" => Channel::Translation,
                "rot" => Channel::Rotation,
                "scale" => Channel::Scale,
                "visibility" => {
                    block.tracks.extend(shown(words)?);
                    continue;
                }
                other => {
                    return Err(words.wrong("`transl`, `rot`, `scale`, `visibility` or `}`", other));
                }
            };
            let mut keys = keys(words, channel)?;
            let there = keys.len();
            keep_rising(&mut keys);
            if keys.len() < there {
                warnings.push(format!(
                    "{}: {} keys `{kind}` of `{}` are left out: they are of times gone by",
                    words.place(),
                    there - keys.len(),
                    block.name
                ));
            }
            match track(channel, &keys) {
                Ok(track) => block.tracks.push(track),
                Err(why) => warnings.push(format!(
                    "{}: the keys `{kind}` of `{}` are left out: {why}",
                    words.place(),
                    block.name
                )),
            }
        }
    }
}

fn keys(words: &mut Words, channel: Channel) -> Result<Vec<Key>, String> {
    let count = words.count("keys", 14)?;
    let mut keys = Vec::with_capacity(count);
    for _ in 0..count {
        let time = words.number("the time of a key")?;
        let value = if channel == Channel::Rotation {
            let axis = words.vector("the axis of a rotation")?;
            DVec4::from(turned(axis, words.number("an angle in degrees")?))
        } else {
            words.point("a value")?.extend(0.0)
        };
        keys.push(Key {
            time,
            value,
            tension: words.number("a tension")?,
            continuity: words.number("a continuity")?,
            bias: words.number("a bias")?,
        });
    }
    Ok(keys)
}

/// Leaves out keys of times that keys before them have passed.
pub fn keep_rising(keys: &mut Vec<Key>) {
    let mut latest = f64::NEG_INFINITY;
    keys.retain(|key| {
        let rises = key.time >= latest;
        latest = latest.max(key.time);
        rises
    });
}

/// Shown until the first key says otherwise.
fn shown(words: &mut Words) -> Result<Option<Track>, String> {
    let count = words.count("keys", 4)?;
    let mut track = Track {
        target: 0,
        channel: Channel::Shown,
        times: Vec::new(),
        values: Vec::new(),
        interpolation: Interpolation::Step,
    };
    for _ in 0..count {
        let time = words.number("the time of a key")?;
        let value = words.number("0 or 1")?;
        if track.times.is_empty() {
            track.times.push(time - 1.0);
            track.values.push(1.0);
        }
        track.times.push(time);
        track.values.push(f64::from(u8::from(value != 0.0)));
    }
    let is_rising = track.times.is_sorted();
    Ok((count > 0 && is_rising).then_some(track))
}

/// The curve through all keys but the first and the last, of no target yet.
///
/// # Errors
/// Why there is none.
pub fn track(channel: Channel, keys: &[Key]) -> Result<Track, String> {
    if keys.len() < 4 {
        return Err(format!("there are {} of at least 4", keys.len()));
    }
    if !keys.is_sorted_by(|a, b| a.time <= b.time) {
        return Err("their times do not rise".into());
    }
    let mut keys = keys.to_vec();
    if channel == Channel::Rotation {
        go_the_shorter_way(&mut keys);
    }
    let mut track = Track {
        target: 0,
        channel,
        times: Vec::new(),
        values: Vec::new(),
        interpolation: match channel {
            Channel::Rotation => Interpolation::Squad,
            _ => Interpolation::Cubic,
        },
    };
    let numbers = if channel == Channel::Rotation { 4 } else { 3 };
    for three in keys.windows(3) {
        let [before, key, after] = three else {
            continue;
        };
        // Of several at one time the last one is what is seen.
        if track.times.last() == Some(&key.time) {
            track.times.pop();
            track.values.truncate(track.values.len() - 3 * numbers);
        }
        let (reached, left) = match channel {
            Channel::Rotation => bends([before, key, after]),
            _ => velocities(
                [before, key, after],
                key.value - before.value,
                after.value - key.value,
            ),
        };
        track.times.push(key.time);
        for vector in [reached, key.value, left] {
            track.values.extend(&vector.to_array()[..numbers]);
        }
    }
    Ok(track)
}

/// Velocities with which a key is reached and left (Kochanek and Bartels 1984, equations 8, 9 and 11, over the lengths
/// of their stretches), by the ways to it and from it.
fn velocities([before, key, after]: [&Key; 3], come: DVec4, go: DVec4) -> (DVec4, DVec4) {
    let span = after.time - before.time;
    let over = if span > 0.0 { 1.0 / span } else { 0.0 };
    let (t, c, b) = (key.tension, key.continuity, key.bias);
    let reached =
        (come * ((1.0 - c) * (1.0 + b)) + go * ((1.0 + c) * (1.0 - b))) * (over * (1.0 - t));
    let left = (come * ((1.0 + c) * (1.0 + b)) + go * ((1.0 - c) * (1.0 - b))) * (over * (1.0 - t));
    (reached, left)
}

/// The quaternions that a `squad` curve bends towards before and after a key, so that it has the velocities there: with the
/// logarithms of ways, it leaves q with log(way) + 2 log(bend), which is the velocity times the length of the stretch.
fn bends([before, key, after]: [&Key; 3]) -> (DVec4, DVec4) {
    // The way of a rotation as the half angle about its axis.
    let way = |from: &Key, to: &Key| {
        let turn = rotation(from).inverse() * rotation(to);
        (turn.normalize().to_scaled_axis() * 0.5).extend(0.0)
    };
    let (come, go) = (way(before, key), way(key, after));
    let (reached, left) = velocities([before, key, after], come, go);
    let bent = |half: DVec4| {
        let turn = DQuat::from_scaled_axis(half.truncate() * 2.0);
        DVec4::from(rotation(key) * turn)
    };
    (
        bent((come - reached * (key.time - before.time)) * 0.5),
        bent((left * (after.time - key.time) - go) * 0.5),
    )
}

fn rotation(key: &Key) -> DQuat {
    DQuat::from_vec4(key.value)
}

/// Of the two quaternions of each rotation takes that which is nearer to the last one.
fn go_the_shorter_way(keys: &mut [Key]) {
    for i in 1..keys.len() {
        if keys[i].value.dot(keys[i - 1].value) < 0.0 {
            keys[i].value = -keys[i].value;
        }
    }
}

/// Puts what a track moves where its first key has it.
fn begin(pose: &mut Transform, track: &Track) {
    // Between the velocities it is reached and left with.
    let value = |numbers: usize| track.values.get(numbers..2 * numbers);
    match (track.channel, value(3), value(4)) {
        (Channel::Translation, Some(&[x, y, z]), _) => pose.translation = DVec3::new(x, y, z),
        (Channel::Scale, Some(&[x, y, z]), _) => pose.scale = DVec3::new(x, y, z),
        (Channel::Rotation, _, Some(&[x, y, z, w])) => {
            pose.rotation = DQuat::from_xyzw(x, y, z, w).normalize();
        }
        _ => {}
    }
}

impl Stage<'_> {
    /// Makes a clip of all keys, and puts what they move where it begins.
    pub(super) fn animate(&mut self) {
        let mut clip = Clip {
            name: "animation".to_owned(),
            ..Clip::default()
        };
        let mut room = KEYS;
        for block in std::mem::take(&mut self.blocks) {
            let Some(nodes) = self.named.get(&block.name) else {
                let warning = format!("there are keys of `{}`, but no such transform", block.name);
                self.model.warnings.push(warning);
                continue;
            };
            for (&target, track) in nodes
                .iter()
                .flat_map(|n| block.tracks.iter().map(move |t| (n, t)))
            {
                let numbers = track.times.len() + track.values.len() + A_TRACK;
                let Some(left) = room.checked_sub(numbers) else {
                    let name = &block.name;
                    let warning = format!("keys of `{name}` are left out: there are too many");
                    self.model.warnings.push(warning);
                    break;
                };
                room = left;
                if let Some(node) = self.model.nodes.get_mut(target) {
                    begin(&mut node.pose, track);
                }
                clip.tracks.push(Track {
                    target,
                    ..track.clone()
                });
            }
        }
        let keys = self
            .model
            .parts
            .iter()
            .filter_map(|part| part.keys.as_ref());
        let times = clip.tracks.iter().map(|track| &track.times);
        let times = times.chain(keys.map(|keys| &keys.times)).flatten();
        let (first, last) = times.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &time| {
            (low.min(time), high.max(time))
        });
        let [start, end] = self.span.unwrap_or([first, last]);
        (clip.start, clip.end) = (start, end);
        let parts = self.model.parts.iter_mut();
        for keys in parts.filter_map(|part| part.keys.as_mut()) {
            *keys = stretched(keys, [start, end]);
        }
        if !clip.tracks.is_empty() {
            self.model.clips.push(clip);
        }
    }
}
