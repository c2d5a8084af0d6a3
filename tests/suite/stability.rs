//! What must never go wrong: the benchmark `stability` in its short form, on both f32 tracers. Its textbook
//! kernels go wrong where the robust ones do not.

use glam::{DAffine3, UVec2, Vec3};
use orrery_engine::frame::{
    BoxTest, Features, FrameScene, Instance, Kernels, Offset, Shape, TraceSettings, TriangleTest,
};
use orrery_engine::trace::{Backend, Hit, Query, Ray, Tracer};
use orrery_tests::metrics::compare_pictures;
use orrery_tests::random_scene::{Random, icosphere, random_scene};
use orrery_tests::tracers::{open, picture};
use serde_json::Value;

use crate::cli::{folder, orrery};

fn settings(kernels: Kernels) -> TraceSettings {
    TraceSettings {
        size: UVec2::new(64, 48),
        kernels,
        ..TraceSettings::default()
    }
}

/// A closed mesh around the eye.
fn closed_mesh() -> FrameScene {
    let mut scene = FrameScene {
        meshes: vec![icosphere(4).into()].into(),
        materials: vec![Default::default()].into(),
        ..FrameScene::default()
    };
    scene.instances.push(Instance {
        tag: 0,
        shape: Shape::Mesh(0),
        world_from_local: DAffine3::IDENTITY,
        material: 0,
    });
    scene.features = Features::of(&scene);
    scene
}

fn answers(
    tracer: &mut dyn Tracer,
    scene: &FrameScene,
    kernels: Kernels,
    rays: &[Ray],
) -> Vec<Hit> {
    tracer.refit(scene).expect("refits");
    tracer.upload(scene, &settings(kernels)).expect("uploads");
    tracer.intersect(rays, Query::Closest).expect("answers")
}

fn misses(hits: &[Hit]) -> usize {
    hits.iter().filter(|hit| **hit == Hit::MISS).count()
}

/// From inside, at points of edges as f32 has them.
fn rays_at_edges(scene: &FrameScene, count: usize) -> Vec<Ray> {
    let mesh = &scene.meshes[0].data;
    let mut random = Random::new(5);
    let mut ray = || {
        let corners = mesh.triangles[random.below(mesh.triangles.len())];
        let [a, b, _] = corners.map(|v| mesh.vertices[v as usize].as_vec3());
        let weight = random.unit() as f32;
        let origin = (random.cube() * 0.3).as_vec3();
        Ray {
            origin,
            dir: a * weight + b * (1.0 - weight) - origin,
            t_min: 0.0,
            t_max: f32::MAX,
        }
    };
    (0..count).map(|_| ray()).collect()
}

#[test]
fn edges_tested_one_triangle_at_a_time_leak_and_shared_ones_do_not() {
    let scene = closed_mesh();
    let rays = rays_at_edges(&scene, 20_000);
    let leaky = Kernels {
        triangles: TriangleTest::MollerTrumbore,
        ..Kernels::default()
    };
    for backend in [Backend::Cpu, Backend::Gpu] {
        let mut tracer = open(backend).expect("a tracer");
        let robust = answers(tracer.as_mut(), &scene, Kernels::default(), &rays);
        assert_eq!(misses(&robust), 0, "{backend}");
        let leaks = misses(&answers(tracer.as_mut(), &scene, leaky, &rays));
        assert!(leaks > 200, "{backend}: {leaks} of 20,000 leak");
    }
}

#[test]
fn boxes_as_they_are_lose_hits_and_padded_ones_do_not() {
    // An icosahedron: a tree of a few boxes, met at the corners of triangles, which are on their sides.
    let mesh = &icosphere(0);
    let corners: Vec<Vec3> = mesh.vertices.iter().map(|v| v.as_vec3()).collect();
    let scene = {
        let mut scene = closed_mesh();
        scene.meshes = vec![mesh.clone().into()].into();
        scene
    };
    let mut random = Random::new(11);
    let rays: Vec<Ray> = (0..20_000)
        .map(|_| {
            let corner = corners[random.below(corners.len())];
            let origin = (random.cube() * 0.3).as_vec3();
            Ray {
                origin,
                dir: corner - origin,
                t_min: 0.0,
                t_max: f32::MAX,
            }
        })
        .collect();
    let bare = Kernels {
        boxes: BoxTest::Bare,
        ..Kernels::default()
    };
    for backend in [Backend::Cpu, Backend::Gpu] {
        let mut tracer = open(backend).expect("a tracer");
        let robust = answers(tracer.as_mut(), &scene, Kernels::default(), &rays);
        assert_eq!(misses(&robust), 0, "{backend}");
        let lost = misses(&answers(tracer.as_mut(), &scene, bare, &rays));
        assert!(lost > 20, "{backend}: {lost} of 20,000 are lost");
    }
}

#[test]
fn a_fixed_offset_shows_in_a_small_scene_and_hardly_elsewhere() {
    let fixed = Kernels {
        offsets: Offset::Fixed,
        ..Kernels::default()
    };
    let scene = random_scene(3, 12);
    for backend in [Backend::Cpu, Backend::Gpu] {
        let mut tracer = open(backend).expect("a tracer");
        let robust = picture(tracer.as_mut(), &scene, &settings(Kernels::default())).unwrap();
        let other = picture(tracer.as_mut(), &scene, &settings(fixed)).unwrap();
        assert_ne!(robust, other, "{backend}: the setting does nothing");
        let difference = compare_pictures(&robust, &other);
        assert!(
            difference.mismatch_ppm < 50_000.0,
            "{backend}: {difference:?}"
        );
        let again = picture(tracer.as_mut(), &scene, &settings(Kernels::default())).unwrap();
        assert_eq!(robust, again, "{backend}: the setting stays");
    }
}

/// Rows of the short form. What is off by ULPs is measured, not held to: a few hundred rays say too little of a
/// percentile.
fn short_form(backend: &str, suites: &[&str]) -> Vec<Value> {
    let json = folder(&format!("stability_{backend}")).join("report.json");
    let path = json.display().to_string();
    let mut arguments = vec!["bench", "stability", "--small", "--backend", backend];
    arguments.extend(["--json", &path]);
    for suite in suites {
        arguments.extend(["--suite", suite]);
    }
    let output = orrery(&arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    let text = std::fs::read_to_string(&json).unwrap_or_else(|_| panic!("no report: {said}"));
    let report: Value = serde_json::from_str(&text).expect("the report is JSON");
    let rows = report["rows"].as_array().expect("rows").clone();
    let missed = rows.iter().any(|row| row["met"] == false);
    assert_eq!(output.status.code(), Some(i32::from(missed)), "{said}");
    rows.into_iter()
        .filter(|row| row["unit"] != "ULP" && row["unit"] != "ppm")
        .collect()
}

fn expect_short_form(backend: &str, suites: &[&str], broken: usize) {
    let rows = short_form(backend, suites);
    for row in &rows {
        assert_ne!(row["met"], false, "{row}");
        let tried = row["tried"].as_u64().expect("a count");
        assert!(tried > 0, "nothing was tried: {row}");
    }
    let must_fail = rows.iter().filter(|row| row["better"] == "higher");
    assert!(
        must_fail.count() >= broken,
        "{suites:?} have hardly a row that must fail"
    );
    for suite in suites {
        let start = format!("{suite}.");
        let has_rows = |row: &Value| row["name"].as_str().is_some_and(|n| n.starts_with(&start));
        assert!(rows.iter().any(has_rows), "no rows of `{suite}`");
    }
}

#[test]
fn the_short_form_finds_nothing_wrong_on_the_processor() {
    let suites = [
        "leaks", "trees", "leave", "lift", "ratios", "gaps", "far", "input", "refit", "drift",
        "glass",
    ];
    expect_short_form("cpu", &suites, 40);
}

#[test]
fn the_short_form_finds_nothing_wrong_on_the_gpu() {
    let suites = [
        "leaks", "trees", "leave", "lift", "ratios", "gaps", "far", "input", "refit", "glass",
    ];
    expect_short_form("gpu", &suites, 20);
}

#[test]
fn suites_that_are_not_there_are_usage() {
    let output = orrery(&["bench", "stability", "--suite", "no_such_suite"]);
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        said.contains("no_such_suite") && said.contains("leaks"),
        "{said}"
    );
    let output = orrery(&["bench", "frame", "--rays", "10"]);
    assert_eq!(output.status.code(), Some(2));
}
