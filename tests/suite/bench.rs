//! The benchmarks from outside, in their short form: which rows there are, and what their counts must be. Never a
//! time.

use std::path::Path;

use serde_json::Value;

use crate::cli::{expect, folder};

/// The report of a benchmark on the CPU, and what was said.
fn report(name: &str, folder: &Path, more: &[&str]) -> Value {
    let json = folder.join("report.json").display().to_string();
    let mut arguments = vec![
        "bench",
        name,
        "--backend",
        "cpu",
        "--small",
        "--json",
        &json,
    ];
    arguments.extend(more);
    expect(&arguments, 0, &[name, "median"]);
    let text = std::fs::read_to_string(&json).expect("the report was written");
    serde_json::from_str(&text).expect("the report is JSON")
}

/// The row of that name.
fn row<'a>(report: &'a Value, name: &str) -> &'a Value {
    let rows = report["rows"].as_array().expect("rows");
    let row = rows.iter().find(|row| row["name"] == name);
    row.unwrap_or_else(|| panic!("no row `{name}` in {rows:#?}"))
}

fn value(report: &Value, name: &str) -> f64 {
    row(report, name)["value"].as_f64().expect("a number")
}

/// Holds that every count that proves the work beside it is 0, and that there are such counts.
fn expect_proofs(report: &Value, words: &[&str]) {
    let rows = report["rows"].as_array().expect("rows");
    for word in words {
        let ending = format!(".{word}");
        let proofs = rows.iter().filter(|row| {
            let name = row["name"].as_str().expect("a name");
            name.ends_with(&ending)
        });
        let proofs: Vec<&Value> = proofs.collect();
        assert!(!proofs.is_empty(), "no row ends in `{word}`");
        for proof in proofs {
            assert_eq!(proof["value"], 0.0, "{proof}");
        }
    }
}

#[test]
fn motion_has_its_rows_and_proofs() {
    let folder = folder("bench_motion");
    let dump = folder.join("dump");
    let report = report("motion", &folder, &["--dump", &dump.display().to_string()]);
    assert_eq!(report["bench"], "motion");
    expect_proofs(&report, &["wrong", "invalid", "trees", "rays"]);
    for count in [10, 1000] {
        let rest = |what: &str| value(&report, &format!("cpu.rest.{count}.{what}"));
        assert!(rest("frame") > 0.0 && rest("profiled") > 0.0);
        for what in ["uploaded", "trees", "rays"] {
            assert_eq!(rest(what), 0.0, "nothing changed, {count} things: {what}");
        }
        let one = |what: &str| value(&report, &format!("cpu.one_of.{count}.{what}"));
        let (bytes, nodes) = (one("uploaded"), one("nodes"));
        assert!(bytes > 0.0 && bytes < 4096.0, "{bytes} bytes for one moved");
        assert!(nodes > 0.0 && nodes < 64.0, "{nodes} nodes for one moved");
    }
    assert_eq!(value(&report, "cpu.camera.1000.nodes"), 0.0);
    for name in [
        "packed.1000.total",
        "tree.spheres.1000.1t.update",
        "tree.meshes.100.1t.rebuild",
        "tree.meshes.1000.1t.refit",
        "tree.meshes.1000.camera_rays.ratio",
        "mesh.1000.1t.deform_refit",
        "mesh.1000.rays.ratio",
    ] {
        let row = row(&report, name);
        assert!(row["value"].as_f64().is_some_and(|v| v > 0.0), "{row}");
    }
    for (scene, instances) in [("meshes.1000", 1000), ("mesh.1000", 1)] {
        let manifest = std::fs::read_to_string(dump.join(scene).join("manifest.json"));
        let manifest: Value = serde_json::from_str(&manifest.expect("a dump")).expect("JSON");
        assert_eq!(manifest["instances"]["count"], instances, "{scene}");
        assert_eq!(manifest["rays"], Value::Array(Vec::new()));
    }
}

#[test]
fn the_hope_has_its_triangles_rays_and_errors() {
    let report = report("hope", &folder("bench_hope"), &[]);
    for (what, least) in [
        ("rigid", 5e4),
        ("deforming", 5e4),
        ("mirror", 30.0),
        ("glass", 10.0),
        ("cpu.rays", 4.0),
    ] {
        assert!(value(&report, what) >= least, "{what}");
    }
    let of = |what: &str| value(&report, &format!("cpu.{what}"));
    assert_eq!(of("primary"), 1.0);
    let kinds = ["primary", "reflected", "refracted", "shadow"].map(of);
    assert!((kinds.iter().sum::<f64>() - of("rays")).abs() < 0.2);
    assert!(of("rate") > 0.0 && of("system.refit_trees") > 0.0 && of("pass.whitted") > 0.0);
    assert!(of("p99.9_error") < 0.01, "{}", of("p99.9_error"));
}

#[test]
fn growth_has_its_curves_exponents_and_page() {
    let folder = folder("bench_growth");
    let page = folder.join("page");
    let report = report(
        "growth",
        &folder,
        &["--report", &page.display().to_string()],
    );
    let of = |what: &str| value(&report, &format!("cpu.{what}"));
    for (quantity, most) in [
        ("triangles", 10_000),
        ("instances", 1000),
        ("lights", 16),
        ("depth", 16),
        ("pixels", 64 * 48),
    ] {
        assert!(of(&format!("{quantity}.{most}.frame")) > 0.0, "{quantity}");
        assert!(
            of(&format!("{quantity}.exponent")).is_finite(),
            "{quantity}"
        );
        let chart = page.join(format!("growth_{quantity}.svg"));
        let chart = std::fs::read_to_string(chart).expect("a chart");
        assert!(chart.contains("cpu: ^") && chart.trim_end().ends_with("</svg>"));
    }
    // What grows is what is said to: a ray more a light, a mirror more a generation.
    let lights = [1, 16].map(|n| of(&format!("lights.{n}.rays")));
    assert!(lights[1] > 5.0 * lights[0], "{lights:?}");
    let depth = [1, 16].map(|n| of(&format!("depth.{n}.rays")));
    assert!(depth[1] > 5.0 * depth[0], "{depth:?}");
    let text = std::fs::read_to_string(page.join("growth.md")).expect("the page");
    assert!(text.contains("## triangles") && text.contains("| cpu | 10000 |"));
}

#[test]
fn skips_change_no_picture() {
    let folder = folder("bench_skips");
    let json = folder.join("report.json").display().to_string();
    let arguments = ["bench", "skips", "--small", "--backend", "gpu"];
    let arguments = [&arguments[..], &["--json", &json]].concat();
    expect(&arguments, 0, &["skips", "by_hand"]);
    let text = std::fs::read_to_string(&json).expect("the report was written");
    let report: Value = serde_json::from_str(&text).expect("the report is JSON");
    expect_proofs(&report, &["off"]);
    for kind in ["triangles", "spheres", "mirrors"] {
        for way in ["specialised", "by_hand", "general"] {
            assert!(value(&report, &format!("kind.{kind}.{way}")) > 0.0);
        }
    }
    for feature in ["transmission", "meshes", "textures"] {
        assert!(value(&report, &format!("without.{feature}.general")) > 0.0);
    }
    assert!(value(&report, "left_out.away.rays") > 0.0);
    expect(&["bench", "skips", "--backend", "cpu"], 2, &["GPU"]);
}

#[test]
fn structures_have_their_rows_and_one_picture() {
    let folder = folder("bench_structures");
    let report = report("structures", &folder, &["--repeat", "20"]);
    expect_proofs(&report, &["wrong", "invalid"]);
    let all = &["none", "spheres", "boxes2", "boxes4"][..];
    for (scene, structures) in [
        ("polygons_35", all),
        ("small_hills", all),
        ("hills", &all[1..]),
    ] {
        for structure in structures {
            for what in ["build", "refit", "nodes", "triangles", "cpu.frame"] {
                let name = format!("{scene}.{structure}.{what}");
                assert!(value(&report, &name) >= 0.0, "{name}");
            }
        }
    }
    let of = |structure: &str, what| value(&report, &format!("small_hills.{structure}.{what}"));
    assert!(
        of("boxes4", "nodes") < of("boxes2", "nodes"),
        "wider nodes are fewer"
    );
    assert!(
        of("boxes2", "nodes") < of("spheres", "nodes"),
        "boxes cull more"
    );
    assert!(
        of("none", "triangles") > 20.0 * of("spheres", "triangles"),
        "trees cull"
    );
}

#[test]
fn options_that_a_benchmark_does_not_know_are_usage() {
    expect(
        &["bench", "frame", "--rival", "x"],
        2,
        &["--rival", "motion"],
    );
    expect(
        &["bench", "structures", "--dump", "x"],
        2,
        &["--dump", "motion"],
    );
}

#[test]
fn a_rival_that_is_none_is_bad_input() {
    let rival = folder("bench_rival").join("no_such_program");
    let rival = rival.display().to_string();
    let arguments = [
        "bench",
        "motion",
        "--backend",
        "cpu",
        "--small",
        "--rival",
        &rival,
    ];
    expect(&arguments, 1, &["no_such_program", "key=value"]);
}

#[test]
fn accuracy_has_its_points_its_proofs_and_its_page() {
    let folder = folder("bench_accuracy");
    let page = folder.join("page");
    let more = ["--report", &page.display().to_string()];
    let report = report("accuracy", &folder, &more);
    let rows = report["rows"].as_array().expect("rows");
    // What leaving out rays cost a pixel is what it was allowed to, at most.
    let proofs = rows.iter().filter(|row| {
        let name = row["name"].as_str().expect("a name");
        name.ends_with(".worst_pixel")
    });
    let proofs: Vec<&Value> = proofs.collect();
    assert!(proofs.len() >= 30, "only {} cut-offs", proofs.len());
    for proof in proofs {
        assert_eq!(proof["met"], true, "{proof}");
    }
    let text = std::fs::read_to_string(page.join("accuracy.md")).expect("the page");
    for class in [
        "plain",
        "glass",
        "gears",
        "balls",
        "mount",
        "far",
        "huge",
        "deforming",
    ] {
        let error = |knob: &str| value(&report, &format!("{class}.cpu.{knob}.p99.9"));
        assert!(error("default") < 1e-3, "{class}");
        assert!(error("default") <= error("fixed offset"), "{class}");
        let aliased = value(&report, &format!("{class}.cpu.1 sample.relMSE"));
        let smooth = value(&report, &format!("{class}.cpu.16 samples.relMSE"));
        assert!(smooth < aliased * 0.01, "{class}: {smooth} of {aliased}");
        let at_edges = value(&report, &format!("{class}.cpu.16 at edges.relMSE"));
        assert!(at_edges < aliased, "{class}: {at_edges} of {aliased}");
        if class == "plain" {
            let camera_rays_alone = value(&report, "plain.cpu.depth 1.mismatch");
            assert!(
                camera_rays_alone > 1e4,
                "mirrors are missed: {camera_rays_alone}"
            );
        }
        let chart = format!("accuracy_{class}.svg");
        assert!(text.contains(&format!("]({chart})")), "{chart}");
        let chart = std::fs::read_to_string(page.join(chart)).expect("a chart");
        assert!(chart.contains("cpu: default") && chart.trim_end().ends_with("</svg>"));
    }
    let device = report["device"].as_str().expect("a device");
    assert!(text.contains(device) && text.contains("| reference |"));
}

/// Scenes of others, which do not come along: without them the benchmarks say where they looked.
#[test]
fn scenes_of_others_are_skipped_by_name() {
    for (bench, scenes) in [("spd", "balls_s4.nff"), ("bart", "kitchen")] {
        let folder = folder(bench);
        let nowhere = folder.display().to_string();
        let small = [
            "bench",
            bench,
            "--small",
            "--backend",
            "cpu",
            "--files",
            &nowhere,
        ];
        expect(&small, 1, &["skipped", "--files", scenes]);
    }
    expect(
        &["bench", "frame", "--files", "x"],
        2,
        &["--files", "`bench spd`"],
    );
}

#[test]
fn starts_are_timed_without_and_with_the_cache() {
    let report = report("start", &folder("bench_start"), &["--files", "nowhere"]);
    for what in ["first", "second", "ratio", "kept"] {
        assert!(value(&report, &format!("hills.{what}")) > 0.0, "{what}");
    }
    // Otherwise both starts are the first.
    assert_eq!(value(&report, "hills.second.found"), 1.0);
}

#[test]
fn rays_are_timed_by_kind_and_dumped_for_rivals() {
    let folder = folder("bench_trace");
    let dump = folder.join("dump");
    let dump_text = dump.display().to_string();
    let report = report(
        "trace",
        &folder,
        &["--suite", "mirrors_21", "--dump", &dump_text],
    );
    let of = |what: &str| value(&report, &format!("mirrors_21.cpu.{what}"));
    assert!(of("rays.rate") > 0.0 && of("whole.96x54") > 0.0);
    let scene = dump.join("mirrors_21");
    let manifest = std::fs::read_to_string(scene.join("manifest.json")).expect("a manifest");
    let manifest: Value = serde_json::from_str(&manifest).expect("JSON");
    let sets = manifest["rays"].as_array().expect("rays");
    let kinds: Vec<&str> = sets.iter().filter_map(|set| set["kind"].as_str()).collect();
    assert_eq!(
        kinds,
        ["primary", "shadow", "reflect", "reflect_shadow", "diffuse"]
    );
    for (set, kind) in sets.iter().zip(kinds) {
        // The f32 rays are the same in both tracers; where they graze an edge one may hit and one miss.
        assert!(of(&format!("{kind}.flips")) <= 2000.0, "{kind}");
        let rays = set["count"].as_u64().expect("a count");
        let bytes = |file: String| std::fs::metadata(scene.join(file)).expect("a file").len();
        assert_eq!(bytes(format!("rays_{kind}.bin")), 32 * rays);
        assert_eq!(bytes(format!("hits_{kind}.bin")), 12 * rays);
    }
    assert_eq!(sets[0]["count"], 96 * 54);
    // A shadow ray and a mirrored one from each primary hit.
    let hits = of("primary.hit_rate") * 0.01 * 96.0 * 54.0;
    assert!((hits - sets[1]["count"].as_f64().expect("a count")).abs() < 1e-6);
    assert_eq!(sets[1]["count"], sets[2]["count"]);
    expect(
        &["bench", "trace", "--suite", "mirror"],
        2,
        &["`mirror`", "mirrors_21"],
    );
}

#[test]
fn rays_on_the_processor_are_timed_on_one_thread_and_dumped() {
    let folder = folder("bench_cpu");
    let dump = folder.join("dump");
    let report = report("cpu", &folder, &["--dump", &dump.display().to_string()]);
    for kind in ["primary", "shadow", "reflect", "diffuse"] {
        assert!(
            value(&report, &format!("s0.1t.{kind}.rate")) > 0.0,
            "{kind}"
        );
        assert!(
            value(&report, &format!("s0.{kind}.flips")) <= 2000.0,
            "{kind}"
        );
        let file = dump.join("s0").join(format!("rays_{kind}.bin"));
        assert!(file.exists(), "{kind}");
    }
    assert!(value(&report, "s0.1t.primary.hit_rate") > 50.0);
    expect(&["bench", "cpu", "--suite", "s2"], 2, &["`s2`", "s0, s1"]);
}
