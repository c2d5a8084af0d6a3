//! Animations to clips.

use glam::DQuat;
use gltf::accessor::Dimensions;
use gltf::animation::{Interpolation as Between, Property};

use super::file::File;
use super::node::{Rows, unit};
use crate::import::Model;
use crate::world::{Channel, Clip, Interpolation, Track};

/// Puts the animations of the file into the model. A clip begins at 0, or at its first key if that is before, and
/// ends at its last key. What moves nodes outside of the scene is left out.
pub fn read_clips(file: &File, rows: &Rows, model: &mut Model) {
    for animation in file.document.animations() {
        let mut clip = Clip {
            name: animation.name().unwrap_or_default().to_owned(),
            ..Clip::default()
        };
        for channel in animation.channels() {
            let target = channel.target();
            let Some(&row) = rows.get(&target.node().index()) else {
                continue;
            };
            let place = || {
                format!(
                    "animations[{}].channels[{}]",
                    animation.index(),
                    channel.index()
                )
            };
            let track = track_of(file, &channel.sampler(), (row, target.property()));
            let track = track.and_then(|track| track.check().map(|()| track));
            let track = match track {
                Ok(track) => track,
                Err(why) => {
                    let warning = format!("{}: {why}; it is left out", place());
                    model.warnings.push(warning);
                    continue;
                }
            };
            clip.start = clip.start.min(track.times[0]);
            clip.end = clip.end.max(track.times[track.times.len() - 1]);
            clip.tracks.push(track);
        }
        if !clip.tracks.is_empty() {
            model.clips.push(clip);
        }
    }
}

fn track_of(
    file: &File,
    sampler: &gltf::animation::Sampler,
    (target, property): (usize, Property),
) -> Result<Track, String> {
    let times = file.numbers(&sampler.input(), Dimensions::Scalar)?;
    let (channel, shape) = match property {
        Property::Translation => (Channel::Translation, Dimensions::Vec3),
        Property::Rotation => (Channel::Rotation, Dimensions::Vec4),
        Property::Scale => (Channel::Scale, Dimensions::Vec3),
        Property::MorphTargetWeights => (Channel::Weights, Dimensions::Scalar),
    };
    let values = file.numbers(&sampler.output(), shape)?;
    let interpolation = match sampler.interpolation() {
        Between::Step => Interpolation::Step,
        Between::Linear => Interpolation::Linear,
        Between::CubicSpline => Interpolation::Cubic,
    };
    let mut values: Vec<f64> = values.into_iter().map(f64::from).collect();
    if channel == Channel::Rotation && interpolation != Interpolation::Cubic {
        for turn in values.chunks_exact_mut(4) {
            let rounded = unit(DQuat::from_slice(turn));
            turn.copy_from_slice(&rounded.to_array());
        }
    }
    Ok(Track {
        target,
        channel,
        times: times.into_iter().map(f64::from).collect(),
        values,
        interpolation,
    })
}
