//! Saving and loading again changes no bit.

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};

use super::*;
use crate::scene::schema::{
    self as s, Ease, Key, KeyValue, LookAt, Loop, Pose, Rotation, Scene, Track,
};
use crate::world::*;

fn vector(chance: &mut Chance) -> DVec3 {
    DVec3::new(chance.number(), chance.number(), chance.number())
}

fn color(chance: &mut Chance) -> Vec3 {
    vector(chance).abs().as_vec3()
}

fn size(chance: &mut Chance) -> f64 {
    chance.number().abs() + 1e-3
}

fn share(chance: &mut Chance) -> f32 {
    chance.number().abs().fract() as f32
}

fn angle(chance: &mut Chance) -> f64 {
    chance.number().abs().fract() * 1.5 + 0.01
}

fn rotation(chance: &mut Chance) -> Rotation {
    if chance.one_in(2) {
        Rotation::Euler(vector(chance))
    } else {
        let [x, y] = [vector(chance), vector(chance)];
        let quat = DQuat::from_xyzw(x.x, x.y, x.z, y.x);
        Rotation::Quat(if quat.length() > 0.0 {
            quat.normalize()
        } else {
            DQuat::IDENTITY
        })
    }
}

fn lobe(chance: &mut Chance) -> Option<Lobe> {
    chance.one_in(2).then(|| Lobe {
        strength: share(chance),
        exponent: size(chance) as f32,
    })
}

fn material(chance: &mut Chance) -> Material {
    let transmit = share(chance);
    Material {
        color: color(chance),
        diffuse: share(chance),
        emission: share(chance),
        phong: lobe(chance),
        specular: lobe(chance),
        reflection: match chance.below(4) {
            0 => Reflection::None,
            1 => Reflection::Fresnel,
            2 => Reflection::Constant(Vec3::splat(share(chance))),
            _ => Reflection::Constant(color(chance)),
        },
        transmit,
        filter: share(chance) * (1.0 - transmit),
        ior: size(chance),
    }
}

fn fade(chance: &mut Chance) -> Option<Fade> {
    chance.one_in(2).then(|| Fade {
        distance: size(chance),
        power: size(chance),
    })
}

fn light(chance: &mut Chance) -> s::Light {
    let (color, intensity) = (color(chance), share(chance));
    match chance.below(3) {
        0 => s::Light::Point(PointLight {
            color,
            intensity,
            fade: fade(chance),
        }),
        1 => s::Light::Directional(DirectionalLight { color, intensity }),
        _ => {
            let inner_angle = angle(chance);
            let outer_angle = inner_angle + angle(chance);
            s::Light::Spot(SpotLight {
                color,
                intensity,
                fade: fade(chance),
                inner_angle,
                outer_angle,
            })
        }
    }
}

fn shape(chance: &mut Chance) -> s::Shape {
    match chance.below(8) {
        0 => s::Shape::Sphere(Sphere {
            radius: size(chance),
        }),
        1 => s::Shape::Plane(Plane {
            normal: vector(chance) + DVec3::splat(0.5e8),
            distance: chance.number(),
        }),
        2 => {
            let min = vector(chance);
            s::Shape::Box(Cuboid {
                min,
                max: min + vector(chance).abs() + DVec3::splat(0.1),
            })
        }
        3 => s::Shape::Disc(Disc {
            center: vector(chance),
            normal: vector(chance) + DVec3::splat(0.5e8),
            radius: size(chance),
        }),
        4 => s::Shape::Cylinder(Cylinder {
            a: vector(chance),
            b: vector(chance) + DVec3::splat(0.5e8),
            radius: size(chance),
        }),
        5 => s::Shape::Cone(Cone {
            a: vector(chance),
            radius_a: if chance.one_in(2) { 0.0 } else { size(chance) },
            b: vector(chance) + DVec3::splat(0.5e8),
            radius_b: size(chance),
        }),
        6 => {
            let minor = size(chance);
            let major = minor * 2.0 + size(chance);
            s::Shape::Torus(Torus { major, minor })
        }
        _ => {
            let corners = [(0.0, 0.0), (3.0, 0.0), (2.0, 1.0), (0.0, 2.0)];
            let height = chance.number();
            s::Shape::Polygon(Polygon {
                loops: vec![corners.map(|(x, z)| DVec3::new(x, height, z)).to_vec()],
            })
        }
    }
}

fn camera(chance: &mut Chance) -> Camera {
    Camera {
        projection: if chance.one_in(2) {
            Projection::Perspective {
                vertical_fov: angle(chance),
            }
        } else {
            Projection::Orthographic {
                height: size(chance),
            }
        },
        exposure: chance.number() as f32,
        tone_map: [ToneMap::Clip, ToneMap::Reinhard, ToneMap::Filmic][chance.below(3)],
    }
}

fn period(chance: &mut Chance) -> f64 {
    [0.0, -2.5, chance.number()][chance.below(3)]
}

fn motion(chance: &mut Chance) -> s::Motion {
    s::Motion {
        orbit: chance.one_in(3).then(|| Orbit {
            center: vector(chance),
            axis: vector(chance) + DVec3::splat(0.5e8),
            radius: chance.number(),
            period: period(chance),
            phase: angle(chance),
        }),
        spin: chance.one_in(3).then(|| Spin {
            axis: vector(chance) + DVec3::splat(0.5e8),
            period: period(chance),
            phase: angle(chance),
        }),
        sway: chance.one_in(3).then(|| Sway {
            amplitude: vector(chance),
            period: period(chance),
            phase: angle(chance),
        }),
        path: chance.one_in(3).then(|| PathMotion {
            points: (0..1 + chance.below(4)).map(|_| vector(chance)).collect(),
            period: period(chance),
            start: chance.number(),
            closed: chance.one_in(2),
            smooth: chance.one_in(2),
            look_along: chance.one_in(2),
        }),
    }
}

fn deform(chance: &mut Chance) -> s::Deform {
    s::Deform {
        wave: chance.one_in(2).then(|| Wave {
            direction: vector(chance) + DVec3::splat(0.5e8),
            length: size(chance),
            amplitude: vector(chance),
            period: period(chance),
            phase: angle(chance),
        }),
        twist: chance.one_in(2).then(|| Twist {
            origin: vector(chance),
            axis: vector(chance) + DVec3::splat(0.5e8),
            rate: angle(chance),
            swing: angle(chance),
            period: period(chance),
            angle: angle(chance),
        }),
        ..s::Deform::default()
    }
}

fn structure(chance: &mut Chance) -> Structure {
    let leaf = 1 + chance.below(8) as u32;
    let structures = [
        Structure::Boxes4,
        Structure::Boxes2,
        Structure::Spheres { leaf },
        Structure::None,
    ];
    structures[chance.below(4)]
}

fn entity(chance: &mut Chance, ids: &mut Vec<String>, materials: usize, depth: usize) -> s::Entity {
    let id = format!("thing \"{}\"\n", ids.len());
    ids.push(id.clone());
    let children = if depth == 0 { 0 } else { chance.below(3) };
    let shape = chance.one_in(2).then(|| shape(chance));
    let has_triangles = matches!(shape, Some(s::Shape::Polygon(_)));
    s::Entity {
        id: Some(id.into()),
        name: chance.one_in(3).then(|| "a name \\ \u{7}".to_owned()),
        hidden: chance.one_in(5),
        pose: Pose {
            transform: Transform {
                translation: vector(chance),
                rotation: rotation(chance).quat(),
                scale: vector(chance),
            },
            shear: chance.one_in(3).then(|| {
                let m = DMat3::from_cols(vector(chance), vector(chance), vector(chance));
                Shear(DAffine3::from_mat3_translation(m, vector(chance)))
            }),
        },
        shape,
        deform: if has_triangles {
            deform(chance)
        } else {
            s::Deform::default()
        },
        structure: (has_triangles && chance.one_in(2)).then(|| structure(chance)),
        motion: motion(chance),
        material: chance
            .one_in(2)
            .then(|| format!("m{}", chance.below(materials)).into()),
        light: chance.one_in(3).then(|| light(chance)),
        camera: chance.one_in(4).then(|| camera(chance)),
        children: (0..children)
            .map(|_| entity(chance, ids, materials, depth - 1))
            .collect(),
    }
}

fn keys(chance: &mut Chance, value: impl Fn(&mut Chance) -> KeyValue) -> Vec<Key> {
    let mut time = 0.0;
    (0..1 + chance.below(4))
        .map(|_| {
            time += size(chance);
            let ease = [
                Ease::Step,
                Ease::Linear,
                Ease::In,
                Ease::Out,
                Ease::InOut,
                Ease::Smooth,
            ];
            Key {
                time,
                value: value(chance),
                ease: ease[chance.below(6)],
            }
        })
        .collect()
}

fn timeline(chance: &mut Chance, ids: &[String]) -> s::Timeline {
    let repeat = |chance: &mut Chance| [Loop::Once, Loop::Repeat, Loop::PingPong][chance.below(3)];
    let mut tracks = Vec::new();
    for id in ids {
        if chance.one_in(2) {
            tracks.push(Track {
                target: id.clone().into(),
                field: "transform.rotation".to_owned().into(),
                keys: keys(chance, |chance| KeyValue::Rotation(rotation(chance))),
                repeat: repeat(chance),
            });
        }
        if chance.one_in(2) {
            tracks.push(Track {
                target: id.clone().into(),
                field: "visible".to_owned().into(),
                keys: keys(chance, |chance| KeyValue::Bool(chance.one_in(2))),
                repeat: repeat(chance),
            });
        }
    }
    // A look and a track of the rotation would both turn the entity.
    let turned = |id: &String| {
        let mut tracks = tracks.iter();
        tracks.any(|track| track.target.value == *id && track.field.value == "transform.rotation")
    };
    let paths = ids.iter().take(chance.below(2)).map(|id| s::Path {
        target: id.clone().into(),
        keys: keys(chance, |chance| KeyValue::Vec3(vector(chance))),
        look_at: (!turned(id) && chance.one_in(2)).then(|| LookAt::Point(vector(chance))),
        up: vector(chance) + DVec3::splat(0.5e8),
        repeat: repeat(chance),
    });
    let paths = paths.collect::<Vec<_>>();
    s::Timeline {
        length: chance.one_in(2).then(|| size(chance)),
        tracks,
        paths,
    }
}

fn random_scene(chance: &mut Chance) -> Scene {
    let materials: Vec<_> = (0..1 + chance.below(4))
        .map(|i| (format!("m{i}").into(), material(chance)))
        .collect();
    let mut ids = Vec::new();
    let entities: Vec<_> = (0..chance.below(5))
        .map(|_| entity(chance, &mut ids, materials.len(), 3))
        .collect();
    let mut timeline = timeline(chance, &ids);
    let mut pending: Vec<&s::Entity> = entities.iter().collect();
    while let Some(entity) = pending.pop() {
        // What motion writes, the timeline must not.
        let moves = |target: &s::At<String>, field: &str| {
            Some(target) == entity.id.as_ref() && entity.motion.writes(field)
        };
        let tracks = &mut timeline.tracks;
        tracks.retain(|track| !moves(&track.target, &track.field.value));
        let fields = ["transform.translation", "transform.rotation"];
        let paths = &mut timeline.paths;
        paths.retain(|path| !fields.iter().any(|field| moves(&path.target, field)));
        pending.extend(&entity.children);
    }
    Scene {
        background: color(chance),
        max_generations: 1 + chance.below(64) as u32,
        active_camera: ids
            .first()
            .filter(|_| chance.one_in(2))
            .map(|id| id.clone().into()),
        timeline,
        materials,
        entities,
    }
}

fn text_of(scene: &Scene) -> String {
    let mut writer = Writer::pretty();
    scene.write(&mut writer);
    writer.finish() + "\n"
}

#[test]
fn random_scenes_come_back_bit_for_bit() {
    for seed in 1..=300 {
        let scene = random_scene(&mut Chance(seed * 0x9E37_79B9));
        let text = text_of(&scene);
        let mut world = World::new();
        load_text(&mut world, &text, Path::new("f.ron"))
            .unwrap_or_else(|problems| panic!("seed {seed}: {problems}\n{text}"));
        let again = describe(&mut world);
        assert_eq!(again, scene, "seed {seed}\n{text}");
        // The text holds the shortest digits of every number, so equal text is equal bits.
        assert_eq!(save(&mut world), text, "seed {seed}");
    }
}

#[test]
fn the_ron_crate_reads_what_is_saved() {
    let options = ron::Options::default();
    for seed in 1..=50 {
        let text = text_of(&random_scene(&mut Chance(seed * 0x9E37_79B9)));
        let value: Result<ron::Value, _> = options.from_str(&text);
        assert!(value.is_ok(), "seed {seed}: {value:?}\n{text}");
    }
}

#[test]
fn loading_replaces_what_was_there() {
    let mut world = World::new();
    let text = "(version: 1, background: 0.5, materials: {\"a\": ()},
        entities: [(id: \"x\", material: \"a\", polygon: (), children: [(sphere: ())])],
        timeline: (tracks: [(target: \"x\", field: \"visible\", keys: [(0, true)])]))";
    load_text(&mut world, text, Path::new("f.ron")).unwrap();
    let first = save(&mut world);
    load_text(&mut world, &first, Path::new("f.ron")).unwrap();
    assert_eq!(
        save(&mut world),
        first,
        "the text is stable after the first save"
    );
    load_text(&mut world, "(version: 1)", Path::new("f.ron")).unwrap();
    assert_eq!(save(&mut world), "(version: 1)\n");
    assert_eq!(world.query::<&SceneId>().iter(&world).count(), 0);
}

#[test]
fn a_scene_with_problems_leaves_the_world_alone() {
    let mut world = World::new();
    let path = Path::new("f.ron");
    load_text(&mut world, "(version: 1, entities: [(id: \"x\")])", path).unwrap();
    assert!(load_text(&mut world, "(version: 1, entities: [(id: 3)])", path).is_err());
    assert!(save(&mut world).contains("\"x\""));
}
