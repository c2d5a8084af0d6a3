//! Motion, deformation and structures of a scene file: what is refused, what is spawned, what comes back.

use glam::{DVec3, Vec3};

use super::*;
use crate::time::Clock;
use crate::world::{
    KeyFrames, Mesh, Meshes, Morph, Orbit, OwnMesh, Rest, Structure, Transform, Wave,
};

/// A folder of its own for one test: a square of two triangles, itself taller, and one with another face.
fn folder(name: &str) -> std::path::PathBuf {
    let folder = std::env::temp_dir().join(format!("orrery-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let square = |height: f64, faces: &str| {
        format!("v 9 9 9\nv 0 0 0\nv 1 0 0\nv 1 {height} 0\nv 0 {height} 0\n{faces}")
    };
    // The first vertex is nobody's, and the faces name theirs in another order than the file does.
    let faces = "f 4 2 3\nf 4 5 2\n";
    for (file, text) in [
        ("flat.obj", square(1.0, faces)),
        ("tall.obj", square(3.0, faces)),
        ("other.obj", square(1.0, "f 4 2 3\nf 4 5 3\n")),
        ("few.obj", square(1.0, "f 4 2 3\n")),
    ] {
        std::fs::write(folder.join(file), text).unwrap();
    }
    folder
}

#[test]
fn poses_of_files_deform_the_mesh() {
    for smooth in ["", ", smooth_angle: 60"] {
        let folder = folder(&format!("poses{}", smooth.len()));
        let text = format!(
            "(version: 1, entities: [(id: \"m\", mesh: (path: \"flat.obj\"{smooth}), structure: Boxes2,
                deform: (keys: (poses: [\"flat.obj\", \"tall.obj\"], times: [0, 2], loop: PingPong),
                    morph: (targets: [\"tall.obj\"], weights: [0.25])))])"
        );
        let mut engine = Engine::new();
        load_text(&mut engine.world, &text, &folder.join("f.ron"))
            .unwrap_or_else(|problems| panic!("{problems}"));
        engine.world.insert_resource(Clock::Frame(30));
        engine.frame();
        let world = &mut engine.world;
        let mut query = world.query::<(&KeyFrames, &Morph, &Mesh, &OwnMesh)>();
        let (keys, morph, mesh, own) = query.single(world).unwrap();
        let meshes = world.resource::<Meshes>();
        let data = meshes.get(mesh.0).unwrap();
        for (i, rest) in data.vertices.iter().enumerate() {
            let tall = DVec3::new(rest.x, rest.y * 3.0, rest.z);
            let key = |set| keys.keys.set(set)[i].as_dvec3() + data.origin;
            assert_eq!((key(0), key(1)), (*rest, tall), "vertex {i}");
            let offset = Vec3::new(0.0, rest.y as f32 * 2.0, 0.0);
            assert_eq!(morph.targets.set(0)[i], offset, "vertex {i}");
        }
        let row = &meshes.rows()[own.0.0 as usize];
        assert_eq!(row.structure, Structure::Boxes2);
        assert_eq!(row.deformation.as_ref().unwrap().steps.len(), 2);
        let saved = save(world);
        for part in [
            "times: [0, 2]",
            "loop: PingPong",
            "weights: [0.25]",
            "structure: Boxes2",
        ] {
            assert!(saved.contains(part), "{saved}");
        }
        load_text(world, &saved, &folder.join("f.ron")).unwrap();
        assert_eq!(save(world), saved);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}

/// The one problem of an entity's fields, without the file.
#[track_caller]
fn problem(folder: &Path, fields: &str) -> String {
    let text = format!("(version: 1, entities: [(id: \"m\", {fields})])");
    let report = check_text(&text, &folder.join("f.ron"));
    let found: Vec<String> = report.problems.0.iter().map(ToString::to_string).collect();
    assert_eq!(found.len(), 1, "{fields}: {found:#?}");
    found[0].clone()
}

#[test]
fn a_pose_that_does_not_fit_says_why() {
    let folder = folder("unfit");
    for (file, why) in [
        ("other.obj", "its faces are not those of the mesh"),
        ("few.obj", "its faces use 3 vertices, those of the mesh 4"),
        ("tal.obj", "cannot be read"),
    ] {
        let fields = format!("mesh: \"flat.obj\", deform: (keys: (poses: [\"{file}\"]))");
        let found = problem(&folder, &fields);
        let place = "f.ron:1:77: entities[0] \"m\".deform.keys.poses[0]: the pose";
        assert!(found.contains(place) && found.contains(why), "{found}");
        assert!(found.contains("expected an OBJ file with the vertices and faces of `flat.obj`"));
        assert_eq!(
            found.contains("did you mean `tall.obj`"),
            file == "tal.obj",
            "{found}"
        );
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn what_cannot_move_or_deform_is_refused() {
    let folder = folder("refused");
    for (fields, expected) in [
        (
            "sphere: (), deform: (wave: ())",
            "found `deform` of an entity without triangles",
        ),
        ("structure: Boxes2", "a mesh or a polygon beside it"),
        ("polygon: (), structure: Boxes3", "did you mean `Boxes4`?"),
        (
            "polygon: (), structure: Spheres(leaf: 9)",
            "a whole number from 1 to 8",
        ),
        (
            "polygon: (), deform: (wave: (length: 0))",
            "deform.wave.length: found 0",
        ),
        (
            "polygon: (), deform: (twist: (axis: (0, 0, 0)))",
            "expected a direction",
        ),
        (
            "polygon: (), deform: (keys: (poses: [\"flat.obj\"]))",
            "an entity without a mesh",
        ),
        (
            "mesh: \"flat.obj\", deform: (keys: ())",
            "there are no poses",
        ),
        (
            "mesh: \"flat.obj\", deform: (morph: (targets: []))",
            "at least one file",
        ),
        (
            "mesh: \"flat.obj\", deform: (keys: (poses: [\"flat.obj\"], times: [0, 1]))",
            "found 2 numbers; expected 1, one a file",
        ),
        (
            "mesh: \"flat.obj\", deform: (keys: (poses: [\"flat.obj\", \"tall.obj\"], times: [1, 1]))",
            "rising numbers of seconds",
        ),
        ("motion: (orbit: (axis: (0, 0, 0)))", "motion.orbit.axis"),
        ("motion: (path: (points: []))", "at least one point"),
        ("motion: (path: ())", "the path has no points"),
        ("motion: (spinn: ())", "did you mean `spin`?"),
    ] {
        let found = problem(&folder, fields);
        assert!(
            found.contains(expected),
            "{found}\nshould contain {expected}"
        );
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn what_motion_moves_the_timeline_must_not() {
    let scene = |motion: &str, timeline: &str| {
        let text = format!(
            "(version: 1, entities: [(id: \"m\", light: Point(), motion: ({motion}))], timeline: ({timeline}))"
        );
        let report = check_text(&text, Path::new("f.ron"));
        report.problems.to_string()
    };
    let track =
        "tracks: [(target: \"m\", field: \"transform.rotation\", keys: [(0, Euler(0, 0, 0))])]";
    let path = "paths: [(target: \"m\", keys: [(0, (0, 0, 0))])]";
    for (motion, timeline, clash) in [
        (
            "spin: ()",
            track,
            "the motion of `m` writes `transform.rotation` too",
        ),
        ("sway: ()", track, ""),
        (
            "sway: ()",
            path,
            "the motion of `m` writes `transform.translation` too",
        ),
        ("spin: ()", path, ""),
    ] {
        let found = scene(motion, timeline);
        assert_eq!(found.is_empty(), clash.is_empty(), "{found}");
        assert!(found.contains(clash), "{found}");
    }
}

#[test]
fn deformations_can_be_keyed_and_motion_saves_its_rest() {
    let text = "(version: 1, entities: [
        (id: \"p\", polygon: (), deform: (wave: ()), motion: (orbit: (radius: 5)), transform: (translation: (1, 2, 3))),
    ], timeline: (tracks: [
        (target: \"p\", field: \"deform.wave.amplitude\", keys: [(0, (0, 0, 0)), (2, (0, 4, 0))]),
    ]))";
    let mut engine = Engine::new();
    load_text(&mut engine.world, text, Path::new("f.ron")).unwrap();
    let first = save(&mut engine.world);
    engine.world.insert_resource(Clock::Frame(30));
    engine.frame();
    let world = &mut engine.world;
    let mut query = world.query::<(&Wave, &Orbit, &Rest, &Transform)>();
    let (wave, orbit, rest, pose) = query.single(world).unwrap();
    assert_eq!(wave.amplitude, DVec3::Y * 2.0);
    assert_eq!(pose.translation, rest.0.translation + orbit.at(1.0));
    assert_eq!(rest.0.translation, DVec3::new(1.0, 2.0, 3.0));
    let later = save(world);
    assert_eq!(
        first.replace("wave: ()", "wave: (amplitude: (0, 2, 0))"),
        later
    );
    let missing = text.replace("deform.wave.amplitude", "deform.twist.axis");
    assert!(load_text(world, &missing, Path::new("f.ron")).is_err());
    let other = text.replace(
        "deform.wave.amplitude\", keys: [(0, (0, 0, 0)), (2, (0, 4, 0))]",
        "deform.twist.rate\", keys: [(0, 1)]",
    );
    let problems = load_text(world, &other, Path::new("f.ron")).unwrap_err();
    assert!(
        problems
            .to_string()
            .contains("no field `deform.twist.rate`"),
        "{problems}"
    );
}
