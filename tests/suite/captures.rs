//! What the program writes of its frames, from outside: a trace for Perfetto, captures and their comparison.

use std::path::Path;

use serde_json::Value;

use crate::cli::{expect, folder};

/// Renders a few small frames with a profile.
fn profiled(folder: &Path, name: &str, backend: &str, more: &[&str]) -> String {
    let log = folder.join(name).display().to_string();
    let out = folder.join("f_####.exr").display().to_string();
    let mut arguments = vec!["render", "two_spheres", "--frames", "0..24", "--out", &out];
    arguments.extend(["--size", "32x24", "--backend", backend, "--profile", &log]);
    arguments.extend(more);
    expect(&arguments, 0, &["24 pictures"]);
    log
}

#[test]
fn a_trace_of_a_gpu_nests_and_both_sides_agree_on_frames() {
    let folder = folder("trace");
    let log = profiled(&folder, "trace.json", "gpu", &[]);
    let text = std::fs::read_to_string(log).expect("a trace");
    let events: Vec<Value> = serde_json::from_str(&text).expect("JSON");
    let number = |event: &Value, key: &str| event[key].as_f64().expect("a number");
    let of = |kind: &str| -> Vec<&Value> { events.iter().filter(|e| e["cat"] == kind).collect() };
    let (frames, passes) = (of("frame"), of("pass"));
    assert_eq!(frames.len(), 24);
    for kind in ["system", "step"] {
        for event in of(kind) {
            let id = &event["args"]["frame"];
            let frame = frames.iter().find(|frame| frame["args"]["frame"] == *id);
            let frame = frame.unwrap_or_else(|| panic!("{event} is of no frame"));
            let (start, length) = (number(event, "ts"), number(event, "dur"));
            let (first, whole) = (number(frame, "ts"), number(frame, "dur"));
            assert!(start >= first - 1e-3, "{event} begins before {frame}");
            assert!(
                start + length <= first + whole + 1e-3,
                "{event} ends after {frame}"
            );
        }
    }
    assert!(of("step").iter().any(|step| step["name"] == "upload"));
    // Every frame's picture was waited for, so its passes are known, and of that frame.
    for frame in frames {
        let id = &frame["args"]["frame"];
        let pass = passes.iter().find(|pass| pass["args"]["frame"] == *id);
        let pass = pass.unwrap_or_else(|| panic!("{frame} has no pass"));
        assert!(
            number(pass, "ts") >= number(frame, "ts") - 1e-3,
            "{pass} {frame}"
        );
        assert!(number(&pass["args"], "up_to_micros_later") >= 0.0, "{pass}");
    }
}

#[test]
fn captures_are_compared_and_a_regression_is_exit_code_1() {
    let folder = folder("compare");
    let few = profiled(&folder, "few.cap", "cpu", &["--depth", "1"]);
    let many = profiled(&folder, "many.cap", "cpu", &["--depth", "9"]);
    let itself = ["compare", few.as_str(), few.as_str()];
    expect(
        &itself,
        0,
        &["24 frames", "no regression past 10 %", "work"],
    );
    let worse = ["compare", few.as_str(), many.as_str(), "--limit", "5"];
    expect(&worse, 1, &["REGRESSION", "mirrored rays", "new"]);
}

#[test]
fn what_is_no_capture_is_bad_input_with_its_line() {
    let folder = folder("no_capture");
    let file = folder.join("x.cap");
    let name = file.display().to_string();
    std::fs::write(&file, "frame,kind\n").expect("writable");
    expect(
        &["compare", &name, &name],
        1,
        &["x.cap: line 1", "--profile NAME.cap"],
    );
    std::fs::write(&file, [0xff, 0, 0xfe, 10]).expect("writable");
    expect(&["compare", &name, &name], 1, &["line 1"]);
    expect(&["compare", &name, "no/such.cap"], 1, &["line 1"]);
    expect(
        &["compare", "no/such.cap", &name],
        1,
        &["no/such.cap: cannot be opened"],
    );
    expect(&["compare", "assets", &name], 1, &["folder"]);
    expect(
        &["compare", &name, &name, "--limit", "lots"],
        2,
        &["per cent"],
    );
    expect(
        &["compare", "--help"],
        0,
        &["Examples:", "regression", "--limit"],
    );
}

#[test]
fn a_spike_is_captured_and_who_made_it_is_named() {
    let folder = folder("spike");
    let log = folder.join("spike.cap").display().to_string();
    let out = folder.join("f_####.exr").display().to_string();
    // From its twelfth frame on every frame is one: nothing traces so many samples within a millisecond.
    let mut arguments = vec!["render", "two_spheres", "--frames", "0..14", "--out", &out];
    arguments.extend([
        "--size",
        "64x48",
        "--backend",
        "reference",
        "--samples",
        "16",
    ]);
    arguments.extend(["--profile", &log, "--capture-on-spike", "1"]);
    expect(
        &arguments,
        0,
        &["frame 11 worked", "more than 1", "spike.cap"],
    );
    expect(&["compare", &log, &log], 0, &["11 frames"]);
    let without = ["render", "two_spheres", "--capture-on-spike", "30"];
    expect(&without, 2, &["--profile FILE"]);
    let ending = ["render", "two_spheres", "--profile", "p.txt"];
    expect(&ending, 2, &[".csv", ".json", ".cap"]);
}
