use std::sync::Arc;

use glam::{DQuat, DVec3, Vec3};

use super::*;
use crate::scene::tests::Chance;
use crate::world::{
    Camera, Clip, ClipLayer, ClipPlayer, ClipSet, Cone, Cuboid, Cylinder, DirectionalLight, Disc,
    Fade, KeyFrames, Lobe, Material, Morph, Plane, PointLight, Projection, Sphere, SpotLight,
    Torus, Transform, Twist, Visibility, Wave,
};

/// Entities that together have every field.
fn cast(world: &mut World) -> Vec<Entity> {
    let fade = Some(Fade {
        range: Some(30.0),
        ..Fade::default()
    });
    let lobe = Some(Lobe::default());
    vec![
        world
            .spawn((
                Transform::IDENTITY,
                Visibility::default(),
                Sphere::default(),
            ))
            .id(),
        world
            .spawn((
                Plane::default(),
                PointLight {
                    fade,
                    ..Default::default()
                },
            ))
            .id(),
        world
            .spawn((
                Cuboid::default(),
                SpotLight {
                    fade,
                    ..Default::default()
                },
            ))
            .id(),
        world
            .spawn((
                Disc::default(),
                Cylinder::default(),
                Cone::default(),
                Torus::default(),
            ))
            .id(),
        world
            .spawn((Camera::default(), DirectionalLight::default()))
            .id(),
        world
            .spawn(Camera {
                projection: Projection::Orthographic { height: 3.0 },
                ..Default::default()
            })
            .id(),
        world
            .spawn((
                KeyFrames::default(),
                Morph {
                    weights: vec![0.0; 4],
                    ..Default::default()
                },
                Wave::default(),
                Twist::default(),
            ))
            .id(),
        world
            .spawn(ClipPlayer {
                clips: clips(["Clip", "Reinhard", "Filmic"]),
                layers: vec![ClipLayer::default(); 4],
                ..Default::default()
            })
            .id(),
        world
            .spawn(Material {
                phong: lobe,
                specular: lobe,
                ..Default::default()
            })
            .id(),
    ]
}

/// Clips that move nothing, by name.
fn clips(names: [&str; 3]) -> Arc<ClipSet> {
    let clip = |name: &str| Clip {
        name: name.to_owned(),
        ..Clip::default()
    };
    Arc::new(ClipSet::new(names.map(clip).to_vec(), |_| Vec::new()))
}

fn random(field: &Field, chance: &mut Chance) -> Value {
    loop {
        let vector = DVec3::new(chance.number(), chance.number(), chance.number()).abs();
        let value = match field.kind {
            FieldKind::Bool => Value::Bool(chance.one_in(2)),
            FieldKind::Number => Value::Number(chance.number().abs()),
            FieldKind::Vec3 => Value::Vec3(vector),
            FieldKind::Rotation => Value::Rotation(DQuat::from_euler(
                glam::EulerRot::XYZ,
                vector.x,
                vector.y,
                vector.z,
            )),
            FieldKind::Text => Value::Text(["Clip", "Reinhard", "Filmic"][chance.below(3)].into()),
        };
        if field.check(&value).is_ok() {
            return value;
        }
    }
}

#[test]
fn every_field_reads_what_was_written_and_an_equal_value_is_no_change() {
    let mut world = World::new();
    let cast = cast(&mut world);
    let mut chance = Chance(7);
    for field in all() {
        let holders: Vec<Entity> = cast
            .iter()
            .copied()
            .filter(|&e| field.get(&world, e).is_some())
            .collect();
        assert!(!holders.is_empty(), "nobody has {}", field.path);
        for entity in holders {
            for _ in 0..50 {
                let value = random(field, &mut chance);
                field.set(&mut world, entity, &value).unwrap();
                let read = field.get(&world, entity).unwrap();
                match (&value, &read) {
                    (Value::Number(a), Value::Number(b)) => {
                        assert!((a - b).abs() <= 1e-6 * a.abs(), "{}: {a} {b}", field.path);
                    }
                    (Value::Vec3(a), Value::Vec3(b)) => {
                        assert!(
                            a.distance(*b) <= 1e-6 * a.length(),
                            "{}: {a} {b}",
                            field.path
                        );
                    }
                    _ => assert_eq!(read, value, "{}", field.path),
                }
                assert_eq!(
                    field.set(&mut world, entity, &read),
                    Ok(false),
                    "{}",
                    field.path
                );
                assert_eq!(
                    field.set(&mut world, entity, &value),
                    Ok(false),
                    "{}",
                    field.path
                );
            }
        }
    }
}

#[test]
fn writing_an_equal_value_leaves_the_change_tick() {
    let mut world = World::new();
    let entity = world.spawn(Sphere { radius: 2.0 }).id();
    world.clear_trackers();
    let changed = |world: &mut World| {
        let mut query = world.query::<Ref<Sphere>>();
        query.single(world).unwrap().is_changed()
    };
    assert_eq!(
        set(&mut world, entity, "sphere.radius", &Value::Number(2.0)),
        Ok(false)
    );
    assert!(!changed(&mut world));
    assert_eq!(
        set(&mut world, entity, "sphere.radius", &Value::Number(3.0)),
        Ok(true)
    );
    assert!(changed(&mut world));
}

#[test]
fn errors_name_the_field_and_the_nearest_one() {
    let mut world = World::new();
    let entity = world.spawn(Sphere::default()).id();
    let message = |result: Result<bool, FieldError>| result.unwrap_err().to_string();
    let unknown = set(&mut world, entity, "sphere.raduis", &Value::Number(1.0));
    assert_eq!(
        message(unknown),
        "unknown field `sphere.raduis`; did you mean `sphere.radius`?"
    );
    let range = set(&mut world, entity, "sphere.radius", &Value::Number(-1.0));
    assert!(message(range).contains("greater than 0"));
    let kind = set(&mut world, entity, "sphere.radius", &Value::Bool(true));
    assert!(message(kind).contains("a number"));
    let nan = set(
        &mut world,
        entity,
        "sphere.radius",
        &Value::Number(f64::NAN),
    );
    assert!(message(nan).contains("finite"));
    let absent = set(&mut world, entity, "camera.fov", &Value::Number(40.0));
    assert!(message(absent).contains("has no field `camera.fov`"));
    world.despawn(entity);
    assert!(set(&mut world, entity, "sphere.radius", &Value::Number(1.0)).is_err());
}

#[test]
fn an_f32_field_rounds_once() {
    let mut world = World::new();
    let entity = world.spawn(Material::default()).id();
    let tenth = Value::Vec3(DVec3::splat(0.1));
    assert_eq!(set(&mut world, entity, "material.color", &tenth), Ok(true));
    assert_eq!(set(&mut world, entity, "material.color", &tenth), Ok(false));
    assert_eq!(
        world.get::<Material>(entity).unwrap().color,
        Vec3::splat(0.1)
    );
}
