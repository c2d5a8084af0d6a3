//! Mesh files with several groups and materials.

use super::*;
use crate::import::import;
use crate::world::{Material, Mesh, Meshes, Reflection, Surface};

/// A folder of its own for one test, with an OBJ of two groups and its MTL.
fn folder(name: &str) -> std::path::PathBuf {
    let folder = std::env::temp_dir().join(format!("orrery-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let obj = "mtllib two.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\no left\nusemtl red\nf 1 2 3\no right\nusemtl mirror\nf 1 3 4\n";
    std::fs::write(folder.join("two.obj"), obj).unwrap();
    let mtl = "newmtl red\nKd 1 0 0\nnewmtl mirror\nKd 0 0 0\nKs 0.9 0.9 0.9\nillum 3\n";
    std::fs::write(folder.join("two.mtl"), mtl).unwrap();
    folder
}

/// Names of the parts and colours of their materials.
fn parts(world: &mut World) -> Vec<(String, [f32; 3])> {
    let mut query = world.query_filtered::<(&Name, &Surface), (With<Mesh>, With<Imported>)>();
    let mut parts: Vec<_> = query
        .iter(world)
        .map(|(name, surface)| {
            let material = world.get::<Material>(surface.0).unwrap();
            (name.as_str().to_owned(), material.color.to_array())
        })
        .collect();
    parts.sort_by(|a, b| a.0.cmp(&b.0));
    parts
}

#[test]
fn parts_have_the_materials_of_their_file_unless_the_scene_says_otherwise() {
    let folder = folder("parts");
    let scene = folder.join("f.ron");
    let mut world = World::new();
    let mut load = |text: &str| {
        load_text(&mut world, text, &scene).unwrap_or_else(|problems| panic!("{problems}"));
        parts(&mut world)
    };
    let own = load("(version: 1, entities: [(id: \"m\", mesh: \"two.obj\")])");
    assert_eq!(
        own,
        [("left".into(), [1.0, 0.0, 0.0]), ("right".into(), [0.0; 3])]
    );
    let named = load(
        "(version: 1, materials: {\"red\": (color: 0.5)}, entities: [(id: \"m\", mesh: \"two.obj\")])",
    );
    assert_eq!(
        named,
        [("left".into(), [0.5; 3]), ("right".into(), [0.0; 3])]
    );
    let all = load(
        "(version: 1, materials: {\"x\": (color: 0.25)}, entities: [(id: \"m\", mesh: \"two.obj\", material: \"x\")])",
    );
    assert_eq!(
        all,
        [("left".into(), [0.25; 3]), ("right".into(), [0.25; 3])]
    );
    let text = save(&mut world);
    assert!(
        text.contains("material: \"x\"") && !text.contains("left"),
        "{text}"
    );
    assert_eq!(
        world.resource::<Meshes>().rows().len(),
        2,
        "rows of removed meshes are used again"
    );
    let model = import(&folder.join("two.obj")).unwrap();
    assert_eq!(
        model.materials[1].1.reflection,
        Reflection::Constant(glam::Vec3::splat(0.9))
    );
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn a_mesh_that_cannot_be_used_says_why() {
    let folder = folder("bad");
    std::fs::write(folder.join("bad.obj"), "v 0 0 0\nf 1 2 3\n").unwrap();
    let text = "(version: 1, entities: [(mesh: \"bad.obj\"), (mesh: \"tow.obj\")])";
    let report = check_text(text, &folder.join("f.ron"));
    let found: Vec<String> = report.problems.0.iter().map(ToString::to_string).collect();
    assert_eq!(found.len(), 2, "{found:#?}");
    assert!(
        found[0].contains("`bad.obj` cannot be used"),
        "{}",
        found[0]
    );
    assert!(found[1].contains("did you mean `two.obj`?"), "{}", found[1]);
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn a_model_file_by_itself_is_a_scene_with_light() {
    let folder = folder("alone");
    let path = folder.join("two.obj");
    let report = check(&path);
    assert!(report.problems.0.is_empty(), "{:?}", report.problems);
    assert_eq!((report.summary.meshes, report.summary.triangles), (1, 2));
    let mut world = World::new();
    load(&mut world, &path).unwrap_or_else(|problems| panic!("{problems}"));
    let names: Vec<String> = parts(&mut world).into_iter().map(|part| part.0).collect();
    assert_eq!(names, ["left", "right"]);
    let mut lights = world.query::<&crate::world::DirectionalLight>();
    assert_eq!(lights.iter(&world).count(), 3);
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_model_file_that_cannot_be_read_is_named_with_the_reason() {
    let folder = folder("bad");
    let path = folder.join("bad.obj");
    std::fs::write(&path, "v 0 0 0\n").unwrap();
    let told = check(&path).problems.to_string();
    assert!(
        told.contains("bad.obj") && told.contains("it has no face"),
        "{told}"
    );
    assert!(load(&mut World::new(), &folder.join("gone.obj")).is_err());
    std::fs::remove_dir_all(folder).unwrap();
}
