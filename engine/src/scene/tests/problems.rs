//! Each kind of problem, its exact place and the name it suggests.

use super::*;

/// The problems of a text, as printed, without the file.
fn problems(text: &str) -> Vec<String> {
    let report = check_text(text, Path::new("f.ron"));
    report
        .problems
        .0
        .iter()
        .map(|p| p.to_string()["f.ron:".len()..].to_owned())
        .collect()
}

#[track_caller]
fn one(text: &str, start: &str, within: &[&str]) {
    let found = problems(text);
    assert_eq!(found.len(), 1, "{text}\n{found:#?}");
    assert!(
        found[0].starts_with(start),
        "{}\nshould start with {start}",
        found[0]
    );
    for part in within {
        assert!(
            found[0].contains(part),
            "{}\nshould contain {part}",
            found[0]
        );
    }
}

#[test]
fn a_misspelt_field_names_the_nearest() {
    one(
        "(version: 1, entities: [\n  (id: \"moon\", sphere: (radus: 2)),\n])",
        "2:25: entities[0] \"moon\".sphere: unknown field `radus`",
        &["expected one of radius", "did you mean `radius`?"],
    );
}

#[test]
fn a_wrong_type_names_both() {
    one(
        "(version: 1, entities: [(id: \"moon\", sphere: (radius: \"big\"))])",
        "1:55: entities[0] \"moon\".sphere.radius: found the string \"big\"; expected a number",
        &[],
    );
}

#[test]
fn ranges_are_held() {
    let entity = |body: &str| format!("(version: 1, entities: [({body})])");
    one(
        &entity("sphere: (radius: -1)"),
        "1:43: entities[0].sphere.radius: found -1",
        &["greater than 0"],
    );
    one(&entity("sphere: (radius: inf)"), "1:43", &["finite"]);
    one(&entity("sphere: (radius: 1e999)"), "1:43", &["finite"]);
    one(
        &entity("camera: (fov: 180)"),
        "1:40: entities[0].camera.fov: found 180",
        &["between 0 and 180"],
    );
    one(
        &entity("box: (min: (0, 0, 0), max: (1, 0, 1))"),
        "1:53",
        &["every axis"],
    );
    one(&entity("disc: (normal: (0, 0, 0))"), "1:41", &["direction"]);
    one(
        &entity("cylinder: (a: (1, 2, 3), b: (1, 2, 3))"),
        "1:54",
        &["a and b both at (1, 2, 3)", "two different points"],
    );
    one(
        &entity("cone: (radius_a: 0)"),
        "1:43",
        &["both radii 0", "greater than 0"],
    );
    one(&entity("cone: (radius_a: -1)"), "1:43", &["at least 0"]);
    one(
        &entity("torus: (major: 1, minor: 1)"),
        "1:51",
        &["minor 1 for major 1", "less than major"],
    );
    one(
        &entity("plane: (normal: (0, 0, 0))"),
        "1:42",
        &["direction"],
    );
    one(
        &entity("light: Spot(inner_angle: 40, outer_angle: 30)"),
        "1:33",
        &["inner_angle"],
    );
    one(
        "(version: 1, max_generations: 0)",
        "1:31: max_generations",
        &["1 to 64"],
    );
    one(
        "(version: 1, background: (0, -1, 0))",
        "1:26: background",
        &["at least 0"],
    );
    one(
        "(version: 1, materials: {\"a\": (ior: 0)})",
        "1:37: materials[\"a\"].ior",
        &["greater than 0"],
    );
}

#[test]
fn polygons_are_flat_and_have_an_area() {
    let polygon =
        |corners: &str| format!("(version: 1, entities: [(polygon: (corners: [{corners}]))])");
    one(
        &polygon("(0,0,0), (1,0,0), (1,1,0), (0,1,0.1)"),
        "1:35: entities[0].polygon: the polygon is not flat",
        &["three corners"],
    );
    one(&polygon("(0,0,0), (1,0,0), (2,0,0)"), "1:35", &["no area"]);
    one(
        &polygon("(0,0,0), (1,0,0)"),
        "1:35",
        &["fewer than 3 corners"],
    );
}

#[test]
fn names_are_looked_up() {
    one(
        "(version: 1, materials: {\"brass\": ()}, entities: [(material: \"bras\")])",
        "1:62: entities[0].material: unknown material `bras`",
        &["did you mean `brass`?"],
    );
    one(
        "(version: 1, entities: [(id: \"a\"), (children: [(id: \"a\")])])",
        "1:53: entities[1].children[0] \"a\".id: the id `a` is there twice",
        &[],
    );
    one(
        "(version: 1, active_camera: \"ey\", entities: [(id: \"eye\", camera: ())])",
        "1:29: active_camera: unknown id `ey`",
        &["did you mean `eye`?"],
    );
    one(
        "(version: 1, entities: [(light: Pint())])",
        "1:33: entities[0].light: unknown light `Pint`",
        &["did you mean `Point`?"],
    );
    one(
        "(version: 1, materials: {\"a\": (), \"a\": ()})",
        "1:35",
        &["twice"],
    );
    one(
        "(version: 1, entities: [(sphere: (), box: ())])",
        "1:38: entities[0]",
        &["both `sphere` and `box`"],
    );
    one(
        "(version: 1, entities: [(sphere: (radius: 1, radius: 2))])",
        "1:46: entities[0].sphere.radius",
        &["twice"],
    );
}

#[test]
fn a_missing_mesh_names_folder_and_nearest_file() {
    let text = "(version: 1, entities: [(id: \"m\", mesh: (path: \"../models/spt.obj\"))])";
    let report = check_text(text, &assets().join("x.ron"));
    let problem = &report.problems.0[0];
    assert_eq!((problem.line, problem.column), (1, 48));
    assert_eq!(problem.suggestion.as_deref(), Some("spot.obj"), "{problem}");
    assert!(problem.to_string().contains("models`"), "{problem}");
}

#[test]
fn timelines_are_checked() {
    let track = |body: &str| {
        format!(
            "(version: 1, entities: [(id: \"moon\", sphere: ())], timeline: (tracks: [({body})]))"
        )
    };
    one(
        &track("target: \"mon\", field: \"visible\", keys: [(0, true)]"),
        "1:81: timeline.tracks[0].target: unknown id `mon`",
        &["did you mean `moon`?"],
    );
    one(
        &track("target: \"moon\", field: \"transform.translatio\", keys: [(0, (0,0,0))]"),
        "1:96: timeline.tracks[0].field: unknown field `transform.translatio`",
        &["did you mean `transform.translation`?"],
    );
    one(
        &track("target: \"moon\", field: \"light.color\", keys: [(0, 1)]"),
        "1:96",
        &["`moon` has no light"],
    );
    one(
        &track("target: \"moon\", field: \"sphere.radius\", keys: [(0, 1), (2, 3), (1, 2)]"),
        "1:136: timeline.tracks[0].keys[2]",
        &["order of time"],
    );
    one(
        &track("target: \"moon\", field: \"sphere.radius\", keys: [(0, -1)]"),
        "1:124: timeline.tracks[0].keys[0]",
        &["greater than 0"],
    );
    one(
        &track("target: \"moon\", field: \"sphere.radius\", keys: [(0, 1, Liner)]"),
        "1:127",
        &["unknown ease `Liner`", "did you mean `Linear`?"],
    );
    one(
        &track("target: \"moon\", field: \"sphere.radius\", keys: []"),
        "1:119",
        &["at least one"],
    );
    one(
        &track("target: \"moon\", field: \"sphere.radius\""),
        "1:72",
        &["`keys` is missing"],
    );
}

#[test]
fn tracks_that_can_do_nothing_are_problems() {
    let scene = |light: &str, timeline: &str| {
        format!("(version: 1, entities: [(id: \"a\", light: {light})],\ntimeline: ({timeline}))")
    };
    let track = |light: &str, field: &str| {
        let text = format!("tracks: [(target: \"a\", field: \"{field}\", keys: [(0, 1)])]");
        scene(light, &text)
    };
    for (light, field, kind) in [
        ("Directional()", "light.fade.power", "directional"),
        ("Directional()", "light.fade.distance", "directional"),
        ("Directional()", "light.inner_angle", "directional"),
        ("Point()", "light.outer_angle", "point"),
    ] {
        let what = format!("the {kind} light of `a` has no field `{field}`");
        one(
            &track(light, field),
            "2:42: timeline.tracks[0].field",
            &[&what],
        );
    }
    for (light, field) in [
        ("Point()", "light.fade.power"),
        ("Spot()", "light.inner_angle"),
        ("Directional()", "light.intensity"),
    ] {
        assert_eq!(problems(&track(light, field)), [""; 0]);
    }
    let path = "paths: [(target: \"a\", look_at: (0, 0, 9), keys: [(0, (0, 0, 0))])]";
    let with = |field: &str, value: &str| {
        let track = format!("(target: \"a\", field: \"{field}\", keys: [(0, {value})])");
        scene("Point()", &format!("tracks: [{track}], {path}"))
    };
    let what = "a path of `a` overwrites";
    one(&with("transform.translation", "(1, 0, 0)"), "2:42", &[what]);
    one(
        &with("transform.rotation", "Euler(0, 9, 0)"),
        "2:42",
        &[what],
    );
    assert_eq!(problems(&with("transform.scale", "(1, 2, 1)")), [""; 0]);
    let twice = "paths: [(target: \"a\", keys: [(0, (0, 0, 0))]),
(target: \"a\", keys: [(0, (1, 0, 0))])]";
    one(
        &scene("Point()", twice),
        "3:10: timeline.paths[1].target",
        &["one path an entity"],
    );
}

#[test]
fn more_than_all_light_let_through_is_a_problem() {
    let material = |body: &str| format!("(version: 1, materials: {{\"a\": ({body})}})");
    one(
        &material("transmit: 1, filter: 1"),
        "1:53: materials[\"a\"].filter: found transmit 1 and filter 1",
        &["expected a sum of at most 1"],
    );
    assert_eq!(problems(&material("transmit: 0.7, filter: 0.3")), [""; 0]);
}

#[test]
fn a_scene_without_a_camera_or_light_is_warned_of() {
    let warnings = |text: &str| -> Vec<String> {
        let report = check_text(text, Path::new("f.ron"));
        assert_eq!(report.problems.0, []);
        report.warnings.into_iter().map(|w| w.what).collect()
    };
    let found = warnings("(version: 1, entities: [(sphere: ())])");
    assert_eq!(found.len(), 2, "{found:#?}");
    assert!(found[0].contains("no camera"), "{}", found[0]);
    assert!(found[1].contains("no light"), "{}", found[1]);
    let lit = "(version: 1, entities: [(camera: ()), (light: Point())])";
    assert_eq!(warnings(lit), [""; 0]);
    let glowing = "(version: 1, materials: {\"a\": (emission: 1)}, entities: [(camera: ())])";
    assert_eq!(warnings(glowing), [""; 0]);
}

#[test]
fn looks_that_turn_their_own_target_are_a_cycle() {
    let text = "(version: 1,
        entities: [(id: \"a\", children: [(id: \"b\", transform: (translation: (1, 0, 0)))])],
        timeline: (paths: [(target: \"a\", look_at: \"b\", keys: [(0, (0, 0, 0))])]))";
    one(text, "3:37: timeline.paths[0].target", &["a cycle"]);
}

#[test]
fn one_broken_entity_does_not_hide_the_next() {
    let text = "(version: 1, entities: [
        (id: \"a\", sphere: (radius: )),
        (id: \"b\", sphere: (radius: 0)),
        (id: \"c\" sphere: (radius: 1)),
        (id: \"d\", material: \"gone\"),
        (id: \"e\", sphere: (radius: 1)),
    ])";
    let found = problems(text);
    let lines: Vec<&str> = found.iter().map(|p| &p[..2]).collect();
    assert_eq!(lines, ["2:", "3:", "4:", "5:"], "{found:#?}");
    let report = check_text(text, Path::new("f.ron"));
    assert_eq!(report.summary.entities, 5);
}

#[test]
fn the_version_is_asked_for() {
    one("()", "1:1: `version` is missing", &["version: 1"]);
    one(
        "(version: 2)",
        "1:11: version: found version 2",
        &["version 1"],
    );
}

#[test]
fn a_missing_file_is_a_problem() {
    let report = check(Path::new("nowhere/gone.ron"));
    assert_eq!(report.problems.0.len(), 1);
    assert!(
        report
            .problems
            .to_string()
            .starts_with("nowhere/gone.ron: the file cannot be read")
    );
}

#[test]
fn thousands_of_names_that_are_not_there_are_told_on_one_line() {
    let entities: String = (0..5_000)
        .map(|i| format!("(material: \"materialnumber{i}\"),"))
        .collect();
    let materials: String = (0..5_000)
        .map(|i| format!("\"materialnumbre{i}\": (),"))
        .collect();
    let text = format!("(version: 1, entities: [{entities}], materials: {{{materials}}})");
    let problems = check_text(&text, Path::new("x.ron")).problems.0;
    // No more are kept.
    assert_eq!(problems.len(), 1_000);
    assert!(problems[0].suggestion.is_some() && problems[999].suggestion.is_none());
    let last = &problems[999];
    let at = text.find("\"materialnumber999\"").unwrap();
    assert_eq!((last.line, last.column), (1, at + 1));
}
