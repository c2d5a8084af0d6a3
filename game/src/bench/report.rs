//! Rows of a benchmark: printed for people, as JSON for charts and comparisons.

use std::path::Path;
use std::process::Command;

use orrery_engine::profile::percentile_of_sorted;
use serde::Serialize;

use crate::failure::Failure;
use crate::output::say;

/// The unit of rows whose value is how many of their trial's tries went wrong.
pub const FAILURES: &str = "failures";

/// What a benchmark found. The JSON form is the same for every benchmark.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The benchmark's name.
    pub bench: &'static str,
    /// Commit of the working tree, `+` if it has changes; `unknown` outside of one.
    pub commit: String,
    /// What traced; several in their order, with `; ` between.
    pub device: String,
    /// Drivers of those that have one, likewise; empty for the processor alone.
    pub driver: String,
    /// The numbers.
    pub rows: Vec<Row>,
    /// Sentences for the reader, not part of the JSON.
    #[serde(skip)]
    pub remarks: Vec<String>,
}

/// Which way is good.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Better {
    /// Less is better.
    Lower,
    /// More is better.
    Higher,
}

/// A number.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// What, as `backend.what`.
    pub name: String,
    /// The median, or the one value there is.
    pub value: f64,
    /// Of `value`, `p05` and `p95`.
    pub unit: &'static str,
    /// 5th percentile; none: not sampled.
    pub p05: Option<f64>,
    /// 95th percentile; none: not sampled.
    pub p95: Option<f64>,
    /// What it should be at most or at least; none: there is no target.
    pub target: Option<f64>,
    /// Which way is good.
    pub better: Better,
    /// Whether it is as it should be; none: there is no target.
    pub met: Option<bool>,
    /// Of a row that counts what went wrong: out of how many, and how far.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub trial: Option<Trial>,
}

/// What a count of failures is a part of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Trial {
    /// How many there were.
    pub tried: u64,
    /// The same figure in the literature or measured before, per million.
    pub known_ppm: Option<f64>,
    /// The largest error in units in the last place of the exact result.
    pub worst_ulp: Option<f64>,
    /// Tried a second.
    pub per_sec: Option<f64>,
}

impl Row {
    /// The median and spread of samples; 0 without any.
    pub fn sampled(
        name: impl Into<String>,
        unit: &'static str,
        better: Better,
        samples: &[f64],
    ) -> Self {
        let mut sorted = samples.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        Self {
            p05: Some(percentile_of_sorted(&sorted, 0.05)),
            p95: Some(percentile_of_sorted(&sorted, 0.95)),
            ..Self::single(name, unit, better, percentile_of_sorted(&sorted, 0.5))
        }
    }

    /// One value.
    pub fn single(name: impl Into<String>, unit: &'static str, better: Better, value: f64) -> Self {
        Self {
            name: name.into(),
            value,
            unit,
            p05: None,
            p95: None,
            target: None,
            better,
            met: None,
            trial: None,
        }
    }

    /// The target, and whether it is met.
    fn verdict(&self) -> String {
        match (self.target, self.met) {
            (Some(target), Some(met)) => {
                format!("{} {}", short(target), if met { "met" } else { "MISSED" })
            }
            _ => String::new(),
        }
    }

    /// With what it should be.
    pub fn with_target(self, target: f64) -> Self {
        let met = match self.better {
            Better::Lower => self.value <= target,
            Better::Higher => self.value >= target,
        };
        Self {
            target: Some(target),
            met: Some(met),
            ..self
        }
    }
}

impl Report {
    /// A report without rows, of devices as their tracers call them: "NAME, API, driver VERSION".
    pub fn new(bench: &'static str, devices: &[String]) -> Self {
        let (names, drivers): (Vec<&str>, Vec<Option<&str>>) = devices
            .iter()
            .map(|device| match device.split_once(", driver ") {
                Some((name, driver)) => (name, Some(driver)),
                None => (device.as_str(), None),
            })
            .unzip();
        let drivers: Vec<&str> = drivers.into_iter().flatten().collect();
        Self {
            bench,
            commit: commit(),
            device: names.join("; "),
            driver: drivers.join("; "),
            rows: Vec::new(),
            remarks: Vec::new(),
        }
    }

    /// Prints the rows as a table.
    pub fn print(&self) {
        self.print_head();
        if self.rows.iter().any(|row| row.trial.is_some()) {
            self.print_trials();
        } else {
            self.print_samples();
        }
    }

    fn print_head(&self) {
        say(format_args!("{} at {}", self.bench, self.commit));
        say(format_args!("on {}", self.device));
        if !self.driver.is_empty() {
            say(format_args!("driver {}", self.driver));
        }
        for remark in &self.remarks {
            say(remark);
        }
    }

    /// Columns of the names.
    fn widest_name(&self) -> usize {
        let names = self.rows.iter().map(|row| row.name.len() + 2);
        names.max().unwrap_or(0).max(28)
    }

    fn print_samples(&self) {
        let wide = self.widest_name();
        say(format_args!(
            "{:<wide$}{:>12}{:>12}{:>12}  {:<9}target",
            "", "median", "p05", "p95", "unit"
        ));
        for row in &self.rows {
            let target = row.verdict();
            say(format_args!(
                "{:<wide$}{:>12}{:>12}{:>12}  {:<9}{target}",
                row.name,
                short(row.value),
                number(row.p05),
                number(row.p95),
                row.unit
            ));
        }
    }

    fn print_trials(&self) {
        let wide = self.widest_name();
        say(format_args!(
            "{:<wide$}{:>11}{:>11}{:>11}{:>11}{:>11}{:>11}  {:<9}target",
            "", "tried", "value", "ppm", "known ppm", "worst ULP", "a second", "unit"
        ));
        for row in &self.rows {
            let trial = row.trial.unwrap_or_default();
            let counts = row.unit == FAILURES && trial.tried > 0;
            let ppm = counts.then(|| row.value * 1e6 / trial.tried as f64);
            say(format_args!(
                "{:<wide$}{:>11}{:>11}{:>11}{:>11}{:>11}{:>11}  {:<9}{}",
                row.name,
                trial.tried,
                short(row.value),
                number(ppm),
                number(trial.known_ppm),
                number(trial.worst_ulp),
                number(trial.per_sec),
                row.unit,
                row.verdict()
            ));
        }
    }

    /// Rows that are not as they should be, of those whose name says that they must.
    pub fn missed(&self, must: fn(&str) -> bool) -> usize {
        let missed = |row: &&Row| row.met == Some(false) && must(&row.name);
        self.rows.iter().filter(missed).count()
    }

    /// Writes the rows as JSON.
    pub fn write_json(&self, path: &Path) -> Result<(), Failure> {
        let unwritable = |error: String| {
            Failure::Input(format!(
                "{}: cannot write the report: {error}",
                path.display()
            ))
        };
        let mut text =
            serde_json::to_string_pretty(self).map_err(|error| unwritable(error.to_string()))?;
        text.push('\n');
        std::fs::write(path, text).map_err(|error| unwritable(error.to_string()))
    }
}

fn number(x: Option<f64>) -> String {
    x.map_or(String::new(), short)
}

/// Four digits that count.
pub fn short(x: f64) -> String {
    match x.abs() {
        0.0 => "0".into(),
        a if !(1e-3..1e5).contains(&a) => format!("{x:.2e}"),
        a if a >= 100.0 => format!("{x:.1}"),
        a if a >= 1.0 => format!("{x:.3}"),
        _ => format!("{x:.4}"),
    }
}

/// The commit of the source tree that the program lies in, else of the current folder.
fn commit() -> String {
    let program = std::env::current_exe().ok();
    let folders = [
        program.as_deref().and_then(Path::parent),
        Some(Path::new(".")),
    ];
    let git = |folder: &Path, arguments: &[&str]| {
        let output = Command::new("git")
            .arg("-C")
            .arg(folder)
            .args(arguments)
            .output();
        let output = output.ok().filter(|o| o.status.success())?;
        Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    for folder in folders.into_iter().flatten() {
        if let Some(commit) = git(folder, &["rev-parse", "--short=12", "HEAD"]) {
            let changes = git(folder, &["status", "--porcelain", "--untracked-files=no"]);
            let has_changes = changes.is_some_and(|c| !c.is_empty());
            return commit + if has_changes { "+" } else { "" };
        }
    }
    "unknown".into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_have_the_agreed_form() {
        let row = Row::sampled("cpu.frame", "ms", Better::Lower, &[3.0, 1.0, 2.0]).with_target(2.5);
        let json = serde_json::to_value(&row).unwrap();
        let expected = serde_json::json!({
            "name": "cpu.frame", "value": 2.0, "unit": "ms", "p05": 1.1, "p95": 2.9,
            "target": 2.5, "better": "lower", "met": true
        });
        for (key, value) in expected.as_object().unwrap() {
            match (value.as_f64(), json[key].as_f64()) {
                (Some(a), Some(b)) => assert!((a - b).abs() < 1e-12, "{key}: {b} != {a}"),
                _ => assert_eq!(&json[key], value, "{key}"),
            }
        }
        let plain = serde_json::to_value(Row::single("x", "1", Better::Higher, 1.0)).unwrap();
        assert!(plain["target"].is_null() && plain["met"].is_null());
    }

    #[test]
    fn devices_and_drivers_are_kept_apart() {
        let devices = ["H200, Vulkan, driver 580.1", "Xeon, 16 threads"].map(str::to_owned);
        let report = Report::new("frame", &devices);
        assert_eq!(report.device, "H200, Vulkan; Xeon, 16 threads");
        assert_eq!(report.driver, "580.1");
    }

    #[test]
    fn higher_is_better_where_it_says_so() {
        let row = Row::single("x", "1", Better::Higher, 3.0);
        assert_eq!(row.clone().with_target(4.0).met, Some(false));
        assert_eq!(row.with_target(2.0).met, Some(true));
    }
}
