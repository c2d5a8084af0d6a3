//! The page: charts of the fronts, and the numbers under them, as Markdown with SVG pictures beside it.

use std::fmt::Write;
use std::path::Path;

use super::Measured;
use super::chart;
use super::front::{Measure, is_beaten};
use super::knobs::Panel;
use super::point::Point;
use crate::bench::report::{Report, short};
use crate::failure::Failure;

/// Writes `accuracy.md` and a chart a class into a folder, which is made if it is not there.
pub fn write(folder: &Path, report: &Report, measured: &[Measured]) -> Result<(), Failure> {
    let unwritable = |path: &Path, why: String| {
        Failure::Input(format!("{}: cannot write the page: {why}", path.display()))
    };
    std::fs::create_dir_all(folder).map_err(|error| unwritable(folder, error.to_string()))?;
    for class in measured {
        let path = folder.join(chart_name(class));
        chart::write(&path, class).map_err(|why| unwritable(&path, why))?;
    }
    let path = folder.join("accuracy.md");
    std::fs::write(&path, text(report, measured))
        .map_err(|error| unwritable(&path, error.to_string()))
}

fn chart_name(class: &Measured) -> String {
    format!("accuracy_{}.svg", class.name)
}

fn text(report: &Report, measured: &[Measured]) -> String {
    let mut text = String::from("# Run time against error\n\n");
    let _ = writeln!(
        text,
        "Measured by `orrery bench accuracy` at commit {} on {}{}.\n",
        report.commit,
        report.device,
        if report.driver.is_empty() {
            String::new()
        } else {
            format!(" (driver {})", report.driver)
        }
    );
    for remark in &report.remarks {
        let _ = writeln!(text, "- {remark}");
    }
    text.push_str(
        "- each knob is turned by itself from the engine's defaults; grey: beaten, on the same device something else errs no more and is faster; zero has a line of its own\n",
    );
    for class in measured {
        let _ = writeln!(text, "\n## {}\n\n{}.\n", class.name, class.about);
        let _ = writeln!(text, "![{}]({})\n", class.name, chart_name(class));
        text.push_str("| device | setting | ms | 5 % to 95 % | pictures | mismatch, ppm | p99.9 | relMSE | on the front of |\n|---|---|---|---|---|---|---|---|---|\n");
        for point in &class.points {
            text.push_str(&line(point));
        }
    }
    text
}

fn line(point: &Point) -> String {
    let fronts: Vec<&str> = Measure::ALL
        .into_iter()
        .filter(|m| m.panel() == point.panel && !is_beaten(point, *m))
        .map(Measure::title)
        .collect();
    let of = |panel, value| {
        if point.panel == panel {
            short(value)
        } else {
            String::new()
        }
    };
    let setting = if point.is_default {
        format!("**{}**", point.knob)
    } else {
        point.knob.clone()
    };
    format!(
        "| {} | {setting} | {} | {} to {} | {} | {} | {} | {} | {} |\n",
        point.backend,
        short(point.median),
        short(point.p05),
        short(point.p95),
        point.pictures,
        of(Panel::Arithmetic, point.error.mismatch_ppm),
        of(Panel::Arithmetic, point.error.p999),
        of(Panel::Sampling, point.error.relative_mse),
        fronts.join(", ")
    )
}
