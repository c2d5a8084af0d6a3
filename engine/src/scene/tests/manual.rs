//! The manual says what the program does.

use super::*;

fn manual() -> String {
    std::fs::read_to_string(assets().join("README.md")).unwrap()
}

/// The text between ```` ```language ```` and the next fence.
fn block(text: &str, language: &str) -> String {
    let start = text
        .find(&format!("```{language}\n"))
        .expect("a block of the language")
        + language.len()
        + 4;
    let length = text[start..].find("```").expect("the end of the block");
    text[start..start + length].to_owned()
}

#[test]
fn the_example_of_the_manual_loads_and_plays() {
    let text = block(&manual(), "ron");
    let mut engine = Engine::new();
    let report = load_text(&mut engine.world, &text, &assets().join("manual.ron"))
        .unwrap_or_else(|problems| panic!("{problems}"));
    assert_eq!(report.warnings, []);
    assert_eq!(report.summary.entities, 14);
    assert_eq!(report.summary.triangles, 5856);
    engine.validate().unwrap();
    engine.frame();
    assert!(
        ron::Options::default()
            .from_str::<ron::Value>(&text)
            .is_ok()
    );
}

#[test]
fn the_manual_lists_the_fields_that_can_be_keyed() {
    let listed = block(&manual(), "fields");
    let listed: Vec<&str> = listed.split_whitespace().collect();
    let keyable: Vec<&str> = fields::all()
        .iter()
        .filter(|field| field.kind != fields::FieldKind::Text)
        .map(|field| field.path)
        .collect();
    assert_eq!(listed, keyable);
}

#[test]
fn every_scene_of_the_assets_loads_without_a_warning() {
    let entries = std::fs::read_dir(assets())
        .unwrap()
        .map(|entry| entry.unwrap().path());
    for path in entries.filter(|path| path.extension().is_some_and(|e| e == "ron")) {
        let report = check(&path);
        assert!(report.problems.0.is_empty(), "{}", report.problems);
        assert_eq!(report.warnings, [], "{}", path.display());
        assert!(
            report.summary.cameras > 0 && report.summary.lights > 0,
            "{}",
            path.display()
        );
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(
            ron::Options::default()
                .from_str::<ron::Value>(&text)
                .is_ok(),
            "{}",
            path.display()
        );
    }
}

#[test]
fn the_scenes_of_the_report_have_what_their_names_say() {
    for (name, shapes) in [
        ("two_spheres", 2),
        ("two_triangles", 2),
        ("spheres_36", 36),
        ("polygons_35", 35),
        ("mirrors_21", 21),
    ] {
        let scene = parse(
            &std::fs::read_to_string(assets().join(name).with_extension("ron")).unwrap(),
            Path::new(name),
        )
        .unwrap();
        fn count(entities: &[schema::Entity], of: &dyn Fn(&schema::Shape) -> bool) -> usize {
            entities
                .iter()
                .map(|e| usize::from(e.shape.as_ref().is_some_and(of)) + count(&e.children, of))
                .sum()
        }
        let of: &dyn Fn(&schema::Shape) -> bool = match name {
            "two_triangles" => {
                &|shape| matches!(shape, schema::Shape::Polygon(p) if p.loops[0].len() == 3)
            }
            "polygons_35" => &|shape| matches!(shape, schema::Shape::Polygon(_)),
            _ => &|shape| matches!(shape, schema::Shape::Sphere(_)),
        };
        assert_eq!(count(&scene.entities, of), shapes, "{name}");
    }
}
