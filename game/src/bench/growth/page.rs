//! The page: a chart a quantity, both axes logarithmic, and the numbers under it, as Markdown with SVG pictures beside it.

use std::fmt::Write;
use std::path::Path;

use plotters::prelude::*;

use super::fit::{exponent, upper};
use super::{Curve, Point, Quantity};
use crate::bench::report::{Report, Row, short};
use crate::bench::timing::millis_row;
use crate::failure::Failure;

type Problem = Box<dyn std::error::Error>;

const SIZE: (u32, u32) = (640, 440);
/// Of backends in order: whole frames.
const COLORS: [RGBColor; 2] = [RGBColor(0, 120, 110), RGBColor(200, 90, 20)];

/// Writes `growth.md` and a chart a quantity into a folder, which is made if it is not there.
pub fn write(folder: &Path, report: &Report, curves: &[Curve]) -> Result<(), Failure> {
    let unwritable = |path: &Path, why: String| {
        Failure::Input(format!("{}: cannot write the page: {why}", path.display()))
    };
    std::fs::create_dir_all(folder).map_err(|error| unwritable(folder, error.to_string()))?;
    for quantity in Quantity::ALL {
        let path = folder.join(chart_name(quantity));
        draw(&path, quantity, &of(curves, quantity))
            .map_err(|why| unwritable(&path, why.to_string()))?;
    }
    let path = folder.join("growth.md");
    std::fs::write(&path, text(report, curves))
        .map_err(|error| unwritable(&path, error.to_string()))
}

fn chart_name(quantity: Quantity) -> String {
    format!("growth_{}.svg", quantity.name())
}

fn of(curves: &[Curve], quantity: Quantity) -> Vec<&Curve> {
    let curves = curves.iter();
    curves.filter(|curve| curve.quantity == quantity).collect()
}

fn text(report: &Report, curves: &[Curve]) -> String {
    let mut text = String::from("# How frame time grows\n\n");
    let _ = writeln!(
        text,
        "Measured by `orrery bench growth` at commit {} on {}.\n",
        report.commit, report.device
    );
    for remark in &report.remarks {
        let _ = writeln!(text, "- {remark}");
    }
    for quantity in Quantity::ALL {
        let name = quantity.name();
        let _ = writeln!(text, "\n## {name}\n\n{}.\n", quantity.about());
        let _ = writeln!(text, "![{name}]({})\n", chart_name(quantity));
        let _ = writeln!(
            text,
            "| device | {name} | frame, ms | 5 % to 95 % | tracing, ms | rays a pixel |\n|---|---|---|---|---|---|"
        );
        for curve in of(curves, quantity) {
            for point in &curve.points {
                text.push_str(&line(&curve.backend, point));
            }
        }
        text.push('\n');
        for curve in of(curves, quantity) {
            let _ = writeln!(text, "{}", law(curve));
        }
    }
    text
}

fn line(backend: &str, point: &Point) -> String {
    let row: Row = millis_row(String::new(), &point.frames);
    format!(
        "| {backend} | {} | {} | {} to {} | {} | {} |\n",
        point.count,
        short(row.value),
        short(row.p05.unwrap_or_default()),
        short(row.p95.unwrap_or_default()),
        short(millis_row(String::new(), &point.rays).value),
        short(point.rays_a_pixel)
    )
}

fn law(curve: &Curve) -> String {
    let points = curve.medians(|point| &point.frames);
    let number = |fitted: Option<f64>| fitted.map_or("none".into(), |e| format!("{e:.2}"));
    format!(
        "- {}: exponent {}, of the upper half {}",
        curve.backend,
        number(exponent(&points)),
        number(exponent(upper(&points)))
    )
}

/// Whole decades around values.
fn decades(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let positive = values.filter(|value| *value > 0.0);
    let least = positive.clone().fold(f64::MAX, f64::min);
    let most = positive.fold(f64::MIN_POSITIVE, f64::max).max(least);
    let power = |log: f64| 10_f64.powf(log);
    (
        power(least.min(most).log10().floor()),
        power((most * 1.01).log10().ceil()),
    )
}

fn draw(path: &Path, quantity: Quantity, curves: &[&Curve]) -> Result<(), Problem> {
    let whole = SVGBackend::new(path, SIZE).into_drawing_area();
    whole.fill(&WHITE)?;
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let (few, many) = decades(points().map(|point| point.count as f64));
    let (fast, slow) = decades(
        points()
            .flat_map(|point| &point.frames)
            .copied()
            .map(|millis| millis.max(1e-3)),
    );
    let mut chart = ChartBuilder::on(&whole)
        .caption(
            format!("frame time against {}", quantity.name()),
            ("sans-serif", 18),
        )
        .margin(8)
        .margin_right(18)
        .x_label_area_size(40)
        .y_label_area_size(58)
        .build_cartesian_2d((few..many).log_scale(), (fast..slow).log_scale())?;
    chart
        .configure_mesh()
        .x_desc(quantity.name())
        .y_desc("milliseconds")
        .x_label_formatter(&|x| format!("{x}"))
        .y_label_formatter(&|y| format!("{y}"))
        .light_line_style(RGBColor(238, 238, 238))
        .draw()?;
    for (curve, color) in curves.iter().zip(COLORS.into_iter().cycle()) {
        let medians = curve.medians(|point| &point.frames);
        chart.draw_series(LineSeries::new(medians.clone(), color.stroke_width(2)))?;
        for point in &curve.points {
            let row = millis_row(String::new(), &point.frames);
            let at = |millis: Option<f64>| (point.count as f64, millis.unwrap_or(row.value));
            chart.draw_series(LineSeries::new(
                [at(row.p05), at(row.p95)],
                color.stroke_width(1),
            ))?;
            chart.draw_series([Circle::new(at(None), 4, color.filled())])?;
        }
        if let (Some(&last), Some(fitted)) = (medians.last(), exponent(upper(&medians))) {
            let style = ("sans-serif", 12).into_font().color(&color);
            let words = format!("{}: ^{fitted:.2}", curve.backend);
            let label = EmptyElement::at(last) + Text::new(words, (-70, -16), style);
            chart.draw_series([label])?;
        }
    }
    whole.present()?;
    Ok(())
}
