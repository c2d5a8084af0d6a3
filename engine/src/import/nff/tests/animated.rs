//! What AFF adds to NFF.

use glam::{DQuat, DVec4};

use super::*;
use crate::import::nff::keys::{Key, keep_rising, track};
use crate::testing::Random;
use crate::world::Interpolation;

fn with(files: &'static [(&str, &str)], text: &str) -> Result<Model, String> {
    import_nff_text(text, &|name| {
        let file = files.iter().find(|file| file.0 == name);
        file.map(|file| file.1.to_owned())
            .ok_or_else(|| "it is not there".to_owned())
    })
}

const MESH: &str =
    "m vertices 3\n0 0 0\n1 0 0\n0 1 0\nnormals 1\n0 0 1\ntriangles 1\n0 1 2 0 0 0\n";

#[test]
fn an_included_mesh_is_one_part_under_each_transform() {
    let text = "fm 1 1 1 1 1 1 0 0 0 1 0 1\n\
        xs 1 2 3\n0 0 1 90\n4 5 6\n{ i 0 a.aff }\nx mover { i 0 a.aff i 5 detailed.aff }\ni 0 gone.aff";
    let model = with(&[("a.aff", MESH)], text).unwrap();
    assert_eq!(model.parts.len(), 1);
    let shown = model
        .contents()
        .filter(|c| matches!(c, Content::Part { part: 0, .. }));
    assert_eq!(shown.count(), 2);
    let pose = model.nodes[0].pose;
    let corner = pose.affine().transform_point3(DVec3::X);
    assert!(
        corner.abs_diff_eq(DVec3::new(4.0, 6.0, 6.0), 1e-12),
        "{corner}"
    );
    assert_eq!(model.nodes[1].parent, Some(0));
    assert_eq!(model.nodes[2].name, "mover");
    assert_eq!(model.warnings.sentences().len(), 1, "{:?}", model.warnings);
}

#[test]
fn includes_end() {
    let own = with(&[("a.aff", "i 0 a.aff")], "i 0 a.aff").unwrap_err();
    assert!(own.contains("include below another"), "{own}");
    let fan: &[(&str, &str)] = &[
        ("a", "i 0 b i 0 b i 0 b i 0 b i 0 b i 0 b i 0 b i 0 b"),
        ("b", "i 0 c i 0 c i 0 c i 0 c i 0 c i 0 c i 0 c i 0 c"),
        ("c", "i 0 d i 0 d i 0 d i 0 d i 0 d i 0 d i 0 d i 0 d"),
        ("d", "i 0 e i 0 e i 0 e i 0 e i 0 e i 0 e i 0 e i 0 e"),
        ("e", "i 0 f i 0 f i 0 f i 0 f i 0 f i 0 f i 0 f i 0 f"),
        ("f", "i 0 g i 0 g i 0 g i 0 g i 0 g i 0 g i 0 g i 0 g"),
        ("g", "s 0 0 0 1 s 0 0 0 1 s 0 0 0 1 s 0 0 0 1"),
    ];
    let error = with(fan, "i 0 a i 0 a i 0 a").unwrap_err();
    assert!(error.contains("come to more than"), "{error}");
    let place = with(&[("a.aff", "s 0 0 0 1\ns x")], "i 0 a.aff").unwrap_err();
    assert!(place.starts_with("line 2 of `a.aff`"), "{place}");
}

#[test]
fn animated_triangles_become_keys_of_a_welded_mesh() {
    let corner = |x: f64, z: f64| format!("{x} 0 {z} 0 0 1\n");
    let face = |z: f64| format!("{}{}0 1 {z} 0 0 1\n", corner(0.0, z), corner(1.0, z));
    let other = |z: f64| {
        format!(
            "{}{}1 1 {z} 0 0 1\n",
            corner(1.0, z),
            "0 1 0 0 0 1\n".replace("1 0 0", &format!("1 {z} 0"))
        )
    };
    let text = format!(
        "a -1 5 300\ntpa 2\n0\n{}1.5\n{}tpa 2\n0\n{}1.5\n{}",
        face(0.0),
        face(2.0),
        other(0.0),
        other(2.0)
    );
    let model = import(&text).unwrap();
    let part = &model.parts[0];
    assert_eq!(
        (part.mesh.vertices.len(), part.mesh.triangles.len()),
        (4, 2)
    );
    let keys = part.keys.as_ref().unwrap();
    assert_eq!(
        (keys.times.as_slice(), keys.start),
        (&[-1.0, 0.0, 1.5, 5.0][..], -1.0)
    );
    assert_eq!(
        [keys.keys.set(0), keys.keys.set(2)],
        [keys.keys.set(1), keys.keys.set(3)]
    );
    let lifted = keys.keys.set(2).iter().zip(&part.mesh.positions);
    assert!(
        lifted
            .into_iter()
            .all(|(to, from)| *to - *from == Vec3::Z * 2.0)
    );
}

fn key(time: f64, x: f64) -> Key {
    Key {
        time,
        value: DVec4::X * x,
        tension: 0.0,
        continuity: 0.0,
        bias: 0.0,
    }
}

#[test]
fn velocities_are_those_of_kochanek_and_bartels() {
    // 4 in 1 second, then 2 in 3: the mean over both, 6 in 4, where nothing is bent.
    let mut keys = [key(0.0, 0.0), key(1.0, 4.0), key(4.0, 6.0), key(5.0, 6.0)];
    let plain = track(Channel::Translation, &keys).unwrap();
    assert_eq!(plain.interpolation, Interpolation::Cubic);
    assert_eq!(plain.times, [1.0, 4.0]);
    assert_eq!(
        plain.values[0..9],
        [1.5, 0.0, 0.0, 4.0, 0.0, 0.0, 1.5, 0.0, 0.0]
    );
    assert_eq!(plain.values[9], 0.5);
    keys[1].tension = 1.0;
    let tense = track(Channel::Translation, &keys).unwrap();
    assert_eq!((tense.values[0], tense.values[6]), (0.0, 0.0));
    keys[1].tension = 0.0;
    keys[1].continuity = -1.0;
    let broken = track(Channel::Translation, &keys).unwrap();
    assert_eq!(
        (broken.values[0], broken.values[6]),
        (2.0 * 4.0 / 4.0, 2.0 * 2.0 / 4.0)
    );
    keys[1].continuity = 0.0;
    keys[1].bias = 1.0;
    let early = track(Channel::Translation, &keys).unwrap();
    assert_eq!((early.values[0], early.values[6]), (2.0, 2.0));
    assert!(track(Channel::Translation, &keys[..3]).is_err());
}

#[test]
fn keys_of_times_gone_by_are_left_out() {
    let mut keys: Vec<Key> = [0.0, 1.0, 5.0, 3.0, 4.0, 5.0, 6.0]
        .map(|time| key(time, time))
        .into();
    keep_rising(&mut keys);
    let times: Vec<f64> = keys.iter().map(|key| key.time).collect();
    assert_eq!(times, [0.0, 1.0, 5.0, 5.0, 6.0]);
}

#[test]
fn rotations_go_the_shorter_way_and_pass_their_keys_turning() {
    let turn = |time: f64, degrees: f64| Key {
        value: DVec4::from(DQuat::from_rotation_y(degrees.to_radians())),
        ..key(time, 0.0)
    };
    let keys = [
        turn(0.0, 300.0),
        turn(1.0, 330.0),
        turn(2.0, 0.0),
        turn(3.0, 30.0),
    ];
    let track = track(Channel::Rotation, &keys).unwrap();
    assert_eq!(track.interpolation, Interpolation::Squad);
    let at = |secs: f64| {
        let mut out = Vec::new();
        track.sample(secs, &mut out);
        DQuat::from_slice(&out)
    };
    for (secs, degrees) in [(1.0, 330.0), (1.25, 337.5), (1.9, 357.0), (2.0, 0.0)] {
        let expected = DQuat::from_rotation_y(f64::to_radians(degrees));
        assert!(at(secs).angle_between(expected) < 1e-7, "{secs}");
    }
}

/// Whatever tension, continuity and bias say, and however long the stretches are.
#[test]
fn rotations_have_the_velocities_of_kochanek_and_bartels_at_their_keys() {
    let mut random = Random::new(4);
    for _ in 0..50 {
        let mut time = 0.0;
        let keys: Vec<Key> = (0..5)
            .map(|_| {
                time += random.range(0.3, 2.0);
                let axis = random.direction();
                let [tension, continuity, bias] = (random.cube() * 0.8).to_array();
                Key {
                    time,
                    value: DVec4::from(DQuat::from_axis_angle(axis, random.range(0.0, 0.9))),
                    tension,
                    continuity,
                    bias,
                }
            })
            .collect();
        let track = track(Channel::Rotation, &keys).unwrap();
        let at = |secs: f64| {
            let mut out = Vec::new();
            track.sample(secs, &mut out);
            DQuat::from_slice(&out)
        };
        let half = |from: DQuat, to: DQuat| (from.inverse() * to).to_scaled_axis() * 0.5;
        let [q0, q1, q2, q3] = [0, 1, 2, 3].map(|i| DQuat::from_vec4(keys[i].value));
        let step = 1e-6;
        let [second, third] = [&keys[1], &keys[2]];
        let left = half(q1, at(second.time + step)) / step;
        let Key {
            tension: t,
            continuity: c,
            bias: b,
            ..
        } = *second;
        let expected = (half(q0, q1) * ((1.0 + c) * (1.0 + b))
            + half(q1, q2) * ((1.0 - c) * (1.0 - b)))
            * ((1.0 - t) / (third.time - keys[0].time));
        assert!(left.distance(expected) < 1e-4, "{left} {expected}");
        let reached = half(at(third.time - step), q2) / step;
        let Key {
            tension: t,
            continuity: c,
            bias: b,
            ..
        } = *third;
        let expected = (half(q1, q2) * ((1.0 - c) * (1.0 + b))
            + half(q2, q3) * ((1.0 + c) * (1.0 - b)))
            * ((1.0 - t) / (keys[3].time - second.time));
        assert!(reached.distance(expected) < 1e-4, "{reached} {expected}");
        assert!(at(third.time).angle_between(q2) < 1e-7);
    }
}

#[test]
fn keys_move_the_camera_lights_and_transforms() {
    let rows = |word: &str, value: &str| {
        let rows: String = (0..4).map(|i| format!("{i} {value} 0 0 0\n")).collect();
        format!("{word} 4\n{rows}")
    };
    let text = format!(
        "a 1 2 30\nv from 0 0 9 at 0 0 0 up 0 1 0 angle 45 hither 1 resolution 8 8\nla lamp 1 1 1\n\
        x top {{ x inner {{ s 0 0 0 1 }} }}\n\
        k camera {{ {} }}\nk lamp {{ {} }}\nk top {{ {} {} visibility 1\n1.5 0 }}\nk nobody {{ {} }}",
        rows("transl", "0 0 5"),
        rows("transl", "7 7 7"),
        rows("scale", "2 2 2"),
        rows("rot", "0 1 0 90"),
        rows("transl", "0 0 0"),
    );
    let model = import(&text).unwrap();
    let [clip] = model.clips.as_slice() else {
        panic!("{:?}", model.clips);
    };
    assert_eq!((clip.start, clip.end), (1.0, 2.0));
    let moved: Vec<_> = clip.tracks.iter().map(|t| (t.target, t.channel)).collect();
    assert_eq!(
        moved,
        [
            (0, Channel::Translation),
            (1, Channel::Translation),
            (2, Channel::Scale),
            (2, Channel::Rotation),
            (2, Channel::Shown)
        ]
    );
    assert_eq!(model.nodes[0].pose.translation, DVec3::Z * 5.0);
    assert_eq!(model.nodes[2].pose.scale, DVec3::splat(2.0));
    let warnings = model.warnings.sentences();
    assert!(warnings[0].contains("nobody"), "{warnings:?}");
}

#[test]
fn keys_of_many_transforms_of_one_name_come_to_an_end() {
    let rows: String = (0..3000).map(|i| format!("{i} 0 0 {i} 0 0 0\n")).collect();
    let text = format!(
        "{}k a {{ transl 3000\n{rows} }}",
        "x a { s 0 0 0 1 }\n".repeat(4000)
    );
    let model = import(&text).unwrap();
    let tracks = model.clips.iter().flat_map(|clip| &clip.tracks);
    let numbers: usize = tracks.map(|track| track.values.len()).sum();
    assert!((1..1 << 22).contains(&numbers), "{numbers}");
    let told = model.warnings.sentences().concat();
    assert!(told.contains("keys of `a` are left out"), "{told}");
}
