//! The clips of a model, sorted by what they write, with the rest pose of all they write.

use std::collections::HashMap;

use glam::DQuat;

use super::{Channel, Clip, Track};

/// Clips that can be played together, and what their targets are like where no clip says otherwise. Compared by
/// identity.
#[derive(Debug, Default)]
pub struct ClipSet {
    clips: Vec<Clip>,
    keyed: Vec<Keyed>,
}

/// Where the numbers of a track go.
#[derive(Clone, Debug, PartialEq)]
pub struct ClipPlace {
    /// Row of [`super::ClipPlayer::targets`].
    pub target: usize,
    /// The numbers at rest.
    pub rest: Vec<f64>,
}

/// A value that some clip writes.
#[derive(Debug)]
pub struct Keyed {
    pub target: usize,
    pub channel: Channel,
    pub rest: Vec<f64>,
    /// Clip and track in it, by rising clip.
    tracks: Vec<(usize, usize)>,
}

/// A clip at a moment, and how much of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Row of [`ClipSet::clips`].
    pub clip: usize,
    /// Seconds on the clip's own clock.
    pub secs: f64,
    /// More than 0.
    pub weight: f64,
}

impl PartialEq for ClipSet {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self, other)
    }
}

impl ClipSet {
    /// Sorts clips by what they write. `places` says where a track's numbers go; a track that cannot be played is
    /// left out.
    pub fn new(clips: Vec<Clip>, places: impl Fn(&Track) -> Vec<ClipPlace>) -> Self {
        let mut rows: HashMap<(usize, Channel), usize> = HashMap::new();
        let mut keyed: Vec<Keyed> = Vec::new();
        for (clip, tracks) in clips.iter().map(|clip| &clip.tracks).enumerate() {
            let playable = |(_, track): &(usize, &Track)| track.check().is_ok();
            for (number, track) in tracks.iter().enumerate().filter(playable) {
                for ClipPlace { target, rest } in places(track) {
                    let row = *rows.entry((target, track.channel)).or_insert_with(|| {
                        keyed.push(Keyed {
                            target,
                            channel: track.channel,
                            rest,
                            tracks: Vec::new(),
                        });
                        keyed.len() - 1
                    });
                    let tracks = &mut keyed[row].tracks;
                    // Of two tracks of a clip for the same value the first holds.
                    if tracks.last().is_none_or(|&(last, _)| last != clip) {
                        tracks.push((clip, number));
                    }
                }
            }
        }
        keyed.sort_by_key(|keyed| (keyed.target, keyed.channel));
        Self { clips, keyed }
    }

    /// The clips.
    pub fn clips(&self) -> &[Clip] {
        &self.clips
    }

    /// All that any clip writes, by target.
    pub(super) fn keyed(&self) -> &[Keyed] {
        &self.keyed
    }

    /// The mean of moments by weight, into `out`: rotations as the weighted sum of quaternions on one side, brought
    /// back to unit length. The rest pose has what the weights lack to 1.
    pub(super) fn mix(&self, keyed: &Keyed, moments: &[Moment], out: &mut Vec<f64>) {
        let mut total = 0.0;
        let mut sum = Vec::new();
        for moment in moments {
            let found = keyed
                .tracks
                .binary_search_by_key(&moment.clip, |&(clip, _)| clip);
            let Ok(found) = found else { continue };
            out.clear();
            let (clip, track) = keyed.tracks[found];
            self.clips[clip].tracks[track].sample(moment.secs, out);
            add(&mut sum, keyed.channel, out, moment.weight);
            total += moment.weight;
        }
        if total < 1.0 {
            add(&mut sum, keyed.channel, &keyed.rest, 1.0 - total);
        }
        out.clear();
        if keyed.channel != Channel::Rotation {
            return out.extend(sum.iter().map(|number| number / total.max(1.0)));
        }
        let turn = DQuat::from_slice(&sum);
        let unit = turn.length_squared() > 0.0 && turn.is_finite();
        let rest = DQuat::from_slice(&keyed.rest);
        out.extend(if unit { turn.normalize() } else { rest }.to_array());
    }
}

/// Adds so much of the numbers. A quaternion and its negative are the same turn: the one on the side of the sum counts.
fn add(sum: &mut Vec<f64>, channel: Channel, numbers: &[f64], weight: f64) {
    if sum.is_empty() {
        return sum.extend(numbers.iter().map(|number| number * weight));
    }
    let along: f64 = sum.iter().zip(numbers).map(|(a, b)| a * b).sum();
    let turned = channel == Channel::Rotation && along < 0.0;
    let weight = if turned { -weight } else { weight };
    for (sum, number) in sum.iter_mut().zip(numbers) {
        *sum += number * weight;
    }
}
