//! Model files whose own cameras see nothing of them.

use glam::DVec3;

use super::*;
use crate::time::Time;
use crate::world::{Camera, Framing, GlobalTransform};

fn view(from: &str, at: &str) -> String {
    format!("v\nfrom {from}\nat {at}\nup 0 1 0\nangle 45\nhither 0.01\nresolution 90 90\n")
}

/// The warnings of a model file, the places of the cameras that are left, and whether all is framed.
fn seen(name: &str, text: &str) -> (Vec<String>, Vec<DVec3>, bool) {
    let file = format!("orrery-blind-{name}-{}.nff", std::process::id());
    let path = std::env::temp_dir().join(file);
    std::fs::write(&path, text).unwrap();
    let mut world = World::new();
    let report = load(&mut world, &path).unwrap_or_else(|problems| panic!("{problems}"));
    std::fs::remove_file(&path).unwrap();
    let told = report.warnings.into_iter().map(|problem| problem.what);
    let mut cameras = world.query_filtered::<&GlobalTransform, With<Camera>>();
    let left = cameras.iter(&world).map(|pose| pose.0.translation);
    let left = left.collect();
    assert_eq!(world.resource::<Time>().secs, 0.0);
    (told.collect(), left, world.contains_resource::<Framing>())
}

#[test]
fn a_model_that_its_camera_does_not_see_is_framed() {
    let ball = "f 1 1 1 1 0 0 0 1\ns 0 0 0 1\n";
    let ahead = view("0 0 9", "0 0 0") + ball;
    let (told, left, is_framed) = seen("ahead", &ahead);
    assert_eq!(
        (told.len(), left.len(), is_framed),
        (0, 1, false),
        "{told:?}"
    );
    for (name, away) in [
        ("behind", view("0 0 9", "0 0 20")),
        ("beside", view("0 0 9", "9 0 9")),
    ] {
        let (told, left, is_framed) = seen(name, &(away + ball));
        assert!(
            told[0].contains("sees nothing of it; the picture shows all there is"),
            "{told:?}"
        );
        assert_eq!((told.len(), left.len(), is_framed), (1, 0, true), "{name}");
    }
}
