//! Pictures against truth: scenes whose pixels can be computed by hand, and scenes that another program
//! rendered (`tests/ground_truth`).

use std::path::Path;

use glam::{DVec3, UVec2};
use orrery_engine::frame::TraceSettings;
use orrery_engine::trace::{Backend, Picture};
use orrery_tests::scene_json;
use orrery_tests::tracers;
use orrery_tests::truth::{Row, TruthRun, TruthSet};

/// A scene of the set's form, 32 x 24, seen from (0, 0, 5) along -z; the materials and objects are given.
fn scene(generations: u32, materials: &str, objects: &str) -> scene_json::TruthScene {
    let text = format!(
        r#"{{"name": "made", "width": 32, "height": 24, "max_trace_level": {generations},
        "background": [0.25, 0.5, 0.75],
        "camera": {{"position": [0, 0, 5], "forward": [0, 0, -1], "right": [1, 0, 0], "up": [0, 0.75, 0]}},
        "lights": [{{"position": [1, 2, 3], "color": [1, 0.5, 0.25], "fade": null}}],
        "materials": {{{materials}}}, "objects": [{objects}]}}"#
    );
    scene_json::parse(&text).expect("a scene")
}

/// A material entry: black and without properties but for those given.
fn material(name: &str, given: &str) -> String {
    let mut material = serde_json::json!({
        "color": [0.5, 0.5, 0.5], "diffuse": 0, "emission": 0, "phong": null, "specular": null,
        "reflection": null, "transmit": 0, "filter": 0, "ior": 1.5
    });
    let given: serde_json::Value = serde_json::from_str(given).expect("properties");
    for (key, value) in given.as_object().expect("an object") {
        material[key] = value.clone();
    }
    format!(r#""{name}": {material}"#)
}

fn pictures(scene: &scene_json::TruthScene) -> Vec<(Backend, Picture)> {
    let settings = TraceSettings {
        size: scene.size,
        ..TraceSettings::default()
    };
    let picture = |backend| {
        let mut tracer = tracers::open(backend).expect("a device; tests need one");
        let picture = tracers::picture(tracer.as_mut(), &scene.frame, &settings);
        (backend, picture.expect("a picture"))
    };
    Backend::ALL.into_iter().map(picture).collect()
}

/// Compares every pixel with `expected`, a function of the ray's unit direction.
fn hold(scene: &scene_json::TruthScene, expected: impl Fn(DVec3) -> DVec3) {
    for (backend, picture) in pictures(scene) {
        let size = picture.size;
        for (i, pixel) in picture.pixels.iter().enumerate() {
            let at = UVec2::new(i as u32 % size.x, i as u32 / size.x);
            let part = (at.as_dvec2() + 0.5) / size.as_dvec2() - 0.5;
            let view = &scene.frame.view;
            let dir = (view.forward + view.right * part.x - view.up * part.y).normalize();
            let expected = expected(dir);
            let off = (pixel.as_dvec3() - expected).abs().max_element();
            assert!(
                off < 1e-5,
                "{backend} at {at}: {pixel}, expected {expected}"
            );
        }
    }
}

const WALL: &str = r#"{"type": "plane", "normal": [0, 0, 1], "d": 0, "material": "m"}"#;
const BACKGROUND: DVec3 = DVec3::new(0.25, 0.5, 0.75);

#[test]
fn a_lit_wall_follows_the_cosine() {
    let materials = material("m", r#"{"color": [0.8, 0.4, 0.2], "diffuse": 0.5}"#);
    hold(&scene(1, &materials, WALL), |dir| {
        let point = DVec3::new(0.0, 0.0, 5.0) + dir * (-5.0 / dir.z);
        let to_light = (DVec3::new(1.0, 2.0, 3.0) - point).normalize();
        DVec3::new(0.8, 0.4, 0.2) * 0.5 * to_light.z * DVec3::new(1.0, 0.5, 0.25)
    });
}

#[test]
fn a_mirror_shows_the_background_by_its_weight_and_black_past_the_last_generation() {
    let mirror = r#"{"reflection": {"type": "constant", "k": [0.5, 0.25, 1]}}"#;
    let materials = material("m", mirror);
    hold(&scene(2, &materials, WALL), |_| {
        BACKGROUND * DVec3::new(0.5, 0.25, 1.0)
    });
    hold(&scene(1, &materials, WALL), |_| DVec3::ZERO);
}

/// Fresnel's share of reflected light at a cosine, from index 1 into index `n` (ACCURACY B.5).
fn fresnel(cosine: f64, n: f64) -> f64 {
    let g = (n * n + cosine * cosine - 1.0).sqrt();
    let (minus, plus) = (g - cosine, g + cosine);
    let share = (cosine * plus - 1.0) / (cosine * minus + 1.0);
    0.5 * (minus / plus).powi(2) * (1.0 + share * share)
}

#[test]
fn a_pane_reflects_and_passes_what_fresnel_says() {
    let glass = r#"{"reflection": {"type": "fresnel"}, "transmit": 1}"#;
    let pane = r#"{"type": "box", "min": [-50, -50, -1], "max": [50, 50, 0], "material": "m"}"#;
    let scene = scene(3, &material("m", glass), pane);
    // Generation 2 leaves by the far side or turns back; what turns back is cut off after generation 3.
    hold(&scene, |dir| {
        let reflected = fresnel(-dir.z, 1.5);
        BACKGROUND * (reflected + (1.0 - reflected) * (1.0 - reflected))
    });
}

/// The scenes that come along, by the beginning of their names.
const SET: [&str; 5] = ["s01", "s02", "s03", "s06", "s07"];

fn hold_set(backend: Backend, every: u32) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("ground_truth");
    let set = TruthSet::open(&folder).expect("the set");
    let run = TruthRun { out: None, every };
    let mut tracer = tracers::open(backend).expect("a device; tests need one");
    let names = set.names().expect("names");
    let found: Vec<&str> = names.iter().map(|name| &name[..3]).collect();
    assert_eq!(found, SET, "scenes in {}", folder.display());
    let mut missed = Vec::new();
    for name in &names {
        let row = set.run(name, tracer.as_mut(), &run);
        if !row.is_met() {
            missed.push(row.to_string());
        }
    }
    assert!(
        missed.is_empty(),
        "{backend}\n{}\n{}",
        Row::head(),
        missed.join("\n")
    );
}

#[test]
fn the_cpu_meets_the_targets_of_the_set() {
    hold_set(Backend::Cpu, 1);
}

#[test]
fn the_gpu_meets_the_targets_of_the_set() {
    hold_set(Backend::Gpu, 1);
}

#[test]
fn the_reference_meets_the_targets_of_the_set() {
    hold_set(Backend::Reference, 5);
}
