//! Animation stacks to clips.
//!
//! ufbx bakes layers, Euler angles and tangents to keys with straight ways between them: what is straight in the file
//! keeps its keys, what is not is sampled several times a frame, on the file's frames. Steps become two keys as close
//! together as numbers can be.

use std::collections::HashMap;

use ufbx::{BakeOpts, BakeStepHandling, BakedAnim, BakedNode, BakedProp, BakedVec3, Scene};

use super::{limits, morph, number};
use crate::import::{Content, Model};
use crate::world::{Camera, Channel, Clip, Interpolation, Projection, Track};

/// Samples a second, at least.
const SAMPLES: f64 = 60.0;
/// Samples between two keys of the file, at most.
const MOST_SAMPLES: usize = 1024;
/// Adds the animation stacks of a file of so many bytes to the model, whose nodes are all there.
pub fn read(scene: &Scene, size: usize, model: &mut Model) {
    for stack in &scene.anim_stacks {
        let name = stack.element.name.to_string();
        let baked = match ufbx::bake_anim(scene, &stack.anim, options(scene, size)) {
            Ok(baked) => baked,
            Err(error) => {
                let why = error.description.to_string();
                let warning = format!("animation `{name}` is left out: {why}");
                model.warnings.push(warning);
                continue;
            }
        };
        let mut tracks: Vec<Track> = baked.nodes.iter().flat_map(node_tracks).collect();
        property_tracks(scene, &baked, model, &mut tracks);
        tracks.retain(|track| {
            track.target < model.nodes.len()
                && track.values.iter().all(|number| number.is_finite())
                && track.times.iter().all(|time| time.is_finite())
        });
        if tracks.is_empty() {
            continue;
        }
        let (start, end) = match (stack.time_begin, stack.time_end) {
            (start, end) if start < end && start.is_finite() && end.is_finite() => (start, end),
            _ => span(&tracks),
        };
        model.clips.push(Clip {
            name,
            start,
            end,
            tracks,
        });
    }
}

fn options(scene: &Scene, size: usize) -> BakeOpts {
    let frames = scene.settings.frames_per_second;
    let frames = if (1.0..=1000.0).contains(&frames) {
        frames
    } else {
        30.0
    };
    BakeOpts {
        temp_allocator: limits(size),
        result_allocator: limits(size),
        resample_rate: frames * (SAMPLES / frames).ceil(),
        max_keyframe_segments: MOST_SAMPLES,
        step_handling: BakeStepHandling::AdjacentDouble,
        key_reduction_enabled: true,
        key_reduction_rotation: true,
        ..BakeOpts::default()
    }
}

/// From the first key to the last.
fn span(tracks: &[Track]) -> (f64, f64) {
    let times = || tracks.iter().flat_map(|track| &track.times).copied();
    let start = times().fold(f64::INFINITY, f64::min);
    let end = times().fold(f64::NEG_INFINITY, f64::max);
    (start, end)
}

fn node_tracks(node: &BakedNode) -> Vec<Track> {
    let target = node.typed_id as usize;
    let vectors = |keys: &[BakedVec3], channel| {
        let numbers = |key: &BakedVec3| number::vector(key.value).to_array();
        track(
            target,
            channel,
            keys.iter().map(|key| (key.time, numbers(key).to_vec())),
        )
    };
    let turns = node.rotation_keys.iter().filter_map(|key| {
        let turn = number::rotation(key.value)?;
        Some((key.time, turn.to_array().to_vec()))
    });
    let tracks = [
        vectors(&node.translation_keys, Channel::Translation),
        track(target, Channel::Rotation, turns),
        vectors(&node.scale_keys, Channel::Scale),
    ];
    tracks.into_iter().flatten().collect()
}

/// A track with straight ways between keys; none: it has no key. One key does for many that are equal.
fn track(
    target: usize,
    channel: Channel,
    keys: impl Iterator<Item = (f64, Vec<f64>)>,
) -> Option<Track> {
    let mut keys: Vec<(f64, Vec<f64>)> = keys.collect();
    let first = keys.first()?.1.clone();
    if keys.iter().all(|(_, numbers)| *numbers == first) {
        keys.truncate(1);
    }
    let (times, numbers): (Vec<f64>, Vec<Vec<f64>>) = keys.into_iter().unzip();
    Some(Track {
        target,
        channel,
        times,
        values: numbers.concat(),
        interpolation: Interpolation::Linear,
    })
}

/// Keys of one number of an element.
type Curve<'a> = (u32, &'a BakedProp);
/// Keys by the element and the name of the number.
type Curves<'a> = HashMap<(u32, &'a str), &'a BakedProp>;
/// What the weight of a channel is called.
const WEIGHT: &str = "DeformPercent";

fn property_tracks(scene: &Scene, baked: &BakedAnim, model: &mut Model, tracks: &mut Vec<Track>) {
    let mut weights: Curves = HashMap::new();
    let is_channel = |(id, property): Curve| {
        let mesh = scene
            .meshes
            .iter()
            .find(|mesh| mesh.element.element_id == id);
        mesh.is_some_and(|mesh| {
            morph::channels(mesh)
                .any(|channel| channel.element.name.as_ref() == property.name.as_ref())
        })
    };
    for element in &baked.elements {
        for property in &element.props {
            let curve: Curve = (element.element_id, property);
            match property.name.as_ref() {
                "Visibility" => tracks.extend(visibility(scene, curve)),
                name if name == WEIGHT || is_channel(curve) => {
                    weights.insert((element.element_id, name), property);
                }
                "FieldOfView" | "FieldOfViewY" | "FocalLength" => {
                    tracks.extend(opening(scene, curve, model));
                }
                // Layers are baked with their weights.
                "Weight" => {}
                name if !property.constant_value => model
                    .warnings
                    .push(format!("the animation of `{name}` is left out")),
                _ => {}
            }
        }
    }
    for mesh in &scene.meshes {
        let Some((times, numbers)) = mesh_weights(mesh, &weights) else {
            continue;
        };
        for node in &mesh.element.instances {
            let keys = times.iter().copied().zip(numbers.iter().cloned());
            tracks.extend(track(
                node.element.typed_id as usize,
                Channel::Weights,
                keys,
            ));
        }
    }
}

fn visibility(scene: &Scene, (id, property): Curve) -> Option<Track> {
    let node = scene
        .nodes
        .iter()
        .find(|node| node.element.element_id == id)?;
    let keys = property
        .keys
        .iter()
        .map(|key| (key.time, vec![key.value.x]));
    track(node.element.typed_id as usize, Channel::Shown, keys)
}

/// The opening angle of a camera: the tangent of its half goes as that of the angle the file keys, and as the
/// reciprocal of the focal length.
fn opening(scene: &Scene, (id, property): Curve, model: &Model) -> Vec<Track> {
    let found = scene
        .cameras
        .iter()
        .find(|camera| camera.element.element_id == id);
    let Some(camera) = found else {
        return Vec::new();
    };
    let tangent = |degrees: f64| (0.5 * degrees.to_radians()).tan();
    let rest = tangent(camera.field_of_view_deg.y);
    let width = camera.field_of_view_tan.x / camera.field_of_view_tan.y;
    let half = |number: f64| match property.name.as_ref() {
        "FocalLength" => rest * camera.focal_length_mm / number,
        "FieldOfViewY" => tangent(number),
        _ => tangent(number) / width,
    };
    let angle = |number: f64| 2.0 * half(number).atan();
    let keys: Vec<(f64, Vec<f64>)> = property
        .keys
        .iter()
        .map(|key| (key.time, vec![angle(key.value.x).clamp(1e-3, 3.1)]))
        .collect();
    let is_opening = |content: &Content| {
        matches!(
            content,
            Content::Camera(Camera {
                projection: Projection::Perspective { .. },
                ..
            })
        )
    };
    let rows = (0..model.nodes.len()).filter(|&row| {
        let node = &model.nodes[row];
        let parent = node.parent.and_then(|parent| scene.nodes.get(parent));
        let here = parent.and_then(|parent| parent.camera.as_ref());
        here.is_some_and(|here| here.element.element_id == id)
            && node.contents.iter().any(is_opening)
    });
    rows.filter_map(|row| track(row, Channel::VerticalFov, keys.iter().cloned()))
        .collect()
}

/// Times, and the weights of all targets of a mesh at each; none: none of its channels is keyed.
fn mesh_weights(mesh: &ufbx::Mesh, keyed: &Curves) -> Option<(Vec<f64>, Vec<Vec<f64>>)> {
    let channels: Vec<(Vec<f64>, f64, Option<Vec<(f64, f64)>>)> = morph::channels(mesh)
        .map(|channel| {
            let knots = morph::knots(channel);
            let own = keyed.get(&(channel.element.element_id, WEIGHT));
            // Before version 6000 the mesh holds the weight under the channel's name.
            let of_mesh = || keyed.get(&(mesh.element.element_id, channel.element.name.as_ref()));
            let curve = own.or_else(of_mesh);
            let curve = curve.map(|property| with_knots(property, &knots));
            (knots, channel.weight, curve)
        })
        .collect();
    let curves = || channels.iter().filter_map(|(_, _, curve)| curve.as_ref());
    let mut times: Vec<f64> = curves().flatten().map(|&(time, _)| time).collect();
    times.retain(|time| time.is_finite());
    times.sort_by(f64::total_cmp);
    times.dedup();
    if times.is_empty() {
        return None;
    }
    let at = |time: f64| {
        let shares = channels.iter().flat_map(|(knots, rest, curve)| {
            let weight = curve.as_ref().map_or(*rest, |curve| value_at(curve, time));
            morph::shares(knots, weight)
        });
        shares.collect()
    };
    let numbers = times.iter().map(|&time| at(time)).collect();
    Some((times, numbers))
}

/// The keys of a channel's weight, with one wherever it passes a shape: the ways between are straight then for each
/// shape's weight too.
fn with_knots(property: &BakedProp, knots: &[f64]) -> Vec<(f64, f64)> {
    let keys: Vec<(f64, f64)> = property
        .keys
        .iter()
        .map(|key| (key.time, key.value.x / 100.0))
        .filter(|(time, weight)| time.is_finite() && weight.is_finite())
        .collect();
    let mut all = keys.clone();
    for pair in keys.windows(2) {
        let [(t0, w0), (t1, w1)] = [pair[0], pair[1]];
        let between = |knot: f64| (knot - w0) * (knot - w1) < 0.0;
        for &knot in knots.iter().chain(&[0.0]).filter(|&&knot| between(knot)) {
            all.push((t0 + (t1 - t0) * (knot - w0) / (w1 - w0), knot));
        }
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all
}

/// On straight ways between keys, of which there is one at least.
fn value_at(curve: &[(f64, f64)], time: f64) -> f64 {
    let next = curve.partition_point(|&(key, _)| key <= time);
    match (next.checked_sub(1).map(|row| curve[row]), curve.get(next)) {
        (Some((t0, w0)), Some(&(t1, w1))) => w0 + (w1 - w0) * (time - t0) / (t1 - t0),
        (Some((_, held)), None) | (None, Some(&(_, held))) => held,
        (None, None) => 0.0,
    }
}
