//! A class's chart: three panels of milliseconds against an error, both logarithmic, zero on a line of its own.

use std::path::Path;

use plotters::prelude::*;

use super::Measured;
use super::front::{Measure, is_beaten};
use super::point::Point;

type Problem = Box<dyn std::error::Error>;
/// An area of the picture.
type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

const SIZE: (u32, u32) = (1260, 420);
const GREY: RGBColor = RGBColor(190, 190, 190);
/// A step of a 16-bit picture: what the eye of a file cannot tell from nothing.
const FLOOR: f64 = 1.0 / 65535.0;

/// Draws a class.
///
/// # Errors
/// What kept the file from being written.
pub fn write(path: &Path, class: &Measured) -> Result<(), String> {
    draw(path, class).map_err(|problem| problem.to_string())
}

fn draw(path: &Path, class: &Measured) -> Result<(), Problem> {
    let whole = SVGBackend::new(path, SIZE).into_drawing_area();
    whole.fill(&WHITE)?;
    for (area, measure) in whole.split_evenly((1, 3)).iter().zip(Measure::ALL) {
        let points: Vec<&Point> = class
            .points
            .iter()
            .filter(|point| point.panel == measure.panel())
            .collect();
        panel(area, measure, &points)?;
    }
    whole.present()?;
    Ok(())
}

/// Whole decades around values.
fn decades(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let least = values.clone().fold(f64::MAX, f64::min);
    let most = values.fold(f64::MIN, f64::max);
    if least > most {
        return (1e-6, 1.0);
    }
    (
        10_f64.powf(least.log10().floor()),
        10_f64.powf((most * 1.01).log10().ceil()),
    )
}

fn panel(area: &Area, measure: Measure, points: &[&Point]) -> Result<(), Problem> {
    let (fast, slow) = decades(points.iter().flat_map(|p| [p.p05.max(1e-3), p.p95]));
    let errors = points.iter().map(|p| measure.of(p));
    let (least, most) = decades(errors.filter(|&e| e > 0.0));
    let zero = least / 10.0;
    let height = |point: &Point| measure.of(point).max(zero);
    let mut chart = ChartBuilder::on(area)
        .caption(measure.title(), ("sans-serif", 18))
        .margin(8)
        .margin_right(18)
        .x_label_area_size(40)
        .y_label_area_size(58)
        .build_cartesian_2d((fast..slow).log_scale(), (zero / 2.0..most).log_scale())?;
    let label = |y: &f64| {
        if *y <= zero * 1.5 {
            "0".to_owned()
        } else {
            format!("{y:.0e}")
        }
    };
    chart
        .configure_mesh()
        .x_desc("milliseconds of tracing")
        .x_label_formatter(&|x| format!("{x}"))
        .y_label_formatter(&label)
        .light_line_style(RGBColor(238, 238, 238))
        .draw()?;
    let across = |y: f64| [(fast, y), (slow, y)];
    chart.draw_series(LineSeries::new(across(zero), BLACK.stroke_width(1)))?;
    if measure == Measure::P999 && FLOOR > least && FLOOR < most {
        chart.draw_series(LineSeries::new(across(FLOOR), GREY.stroke_width(2)))?;
    }
    for point in points {
        let (beaten, color) = (is_beaten(point, measure), color(&point.backend));
        let shown = if beaten { GREY } else { color };
        let at = (point.median, height(point));
        let whisker = [(point.p05.max(fast), at.1), (point.p95, at.1)];
        chart.draw_series(LineSeries::new(whisker, shown.stroke_width(1)))?;
        let size = if point.is_default { 6 } else { 4 };
        chart.draw_series([Circle::new(at, size, shown.filled())])?;
        if point.is_default {
            chart.draw_series([Circle::new(at, size + 3, color.stroke_width(2))])?;
        }
    }
    for backend in backends(points) {
        let stairs = staircase(points, measure, backend, zero);
        let color = color(backend);
        chart.draw_series(LineSeries::new(stairs, color.stroke_width(1)))?;
        labels(&mut chart, points, measure, backend, zero)?;
    }
    Ok(())
}

/// The front of a backend from the fastest point on: each level lasts until the next point begins.
fn staircase(points: &[&Point], measure: Measure, backend: &str, zero: f64) -> Vec<(f64, f64)> {
    let mut corners: Vec<(f64, f64)> = Vec::new();
    for point in front(points, measure, backend) {
        let at = (point.median, measure.of(point).max(zero));
        if let Some(&(_, level)) = corners.last() {
            if at.1 >= level {
                continue;
            }
            corners.push((at.0, level));
        }
        corners.push(at);
    }
    corners
}

/// A backend's points that nothing beats, fastest first.
fn front<'a>(points: &[&'a Point], measure: Measure, backend: &str) -> Vec<&'a Point> {
    let mut front: Vec<&Point> = points
        .iter()
        .copied()
        .filter(|point| point.backend == backend && !is_beaten(point, measure))
        .collect();
    front.sort_by(|a, b| a.median.total_cmp(&b.median));
    front
}

/// Names of the default and of points on the front, where there is room.
fn labels<X, Y>(
    chart: &mut ChartContext<'_, SVGBackend<'_>, Cartesian2d<X, Y>>,
    points: &[&Point],
    measure: Measure,
    backend: &str,
    zero: f64,
) -> Result<(), Problem>
where
    X: Ranged<ValueType = f64>,
    Y: Ranged<ValueType = f64>,
{
    let mut taken: Vec<(i32, i32)> = Vec::new();
    let default = points
        .iter()
        .filter(|p| p.is_default && p.backend == backend);
    for point in default.copied().chain(front(points, measure, backend)) {
        let at = (point.median, measure.of(point).max(zero));
        let place = chart.backend_coord(&at);
        let meets = |&(x, y): &(i32, i32)| (x - place.0).abs() < 60 && (y - place.1).abs() < 12;
        if taken.iter().any(meets) {
            continue;
        }
        taken.push(place);
        let name = if point.is_default || backend == "reference" {
            format!("{backend}: {}", point.knob)
        } else {
            point.knob.clone()
        };
        let style = ("sans-serif", 11).into_font().color(&color(backend));
        let text = EmptyElement::at(at) + Text::new(name, (8, -12), style);
        chart.draw_series([text])?;
    }
    Ok(())
}

/// The backends in the points, each once.
fn backends<'a>(points: &[&'a Point]) -> Vec<&'a str> {
    let mut names: Vec<&str> = Vec::new();
    for point in points {
        if !names.contains(&point.backend.as_str()) {
            names.push(&point.backend);
        }
    }
    names
}

fn color(backend: &str) -> RGBColor {
    match backend {
        "gpu" => RGBColor(0, 120, 110),
        "cpu" => RGBColor(200, 90, 20),
        _ => RGBColor(70, 70, 150),
    }
}
