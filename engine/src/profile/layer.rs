//! The tracing layer that times systems, and the subscriber that carries it.
//!
//! bevy_ecs enters a span named `system`, with the system's path in its field `name`, around every run.
//! The frame's executor is single-threaded, so all runs of an engine happen on the thread that calls
//! `Engine::frame`: notes are kept per thread, need no lock, and engines on other threads do not mix in.

use std::cell::RefCell;
use std::fmt;
use std::sync::Arc;
use std::time::Instant;

use tracing::Subscriber;
use tracing::field::{Field, Visit};
use tracing::span::{Attributes, Id};
use tracing_subscriber::layer::{Context, Layer, SubscriberExt};
use tracing_subscriber::registry::LookupSpan;
use tracing_subscriber::{EnvFilter, fmt as log};

use super::frame::{Span, micros_between};

/// Runs kept when nobody collects them (an engine without the profile plugin): many frames' worth.
const RUNS_CAPACITY: usize = 4096;

/// Notes when systems run. Add it to any subscriber built on `tracing_subscriber::registry`.
#[derive(Clone, Copy, Debug, Default)]
pub struct SystemSpans;

/// Short name of a system, kept with its span.
struct SystemName(Arc<str>);

/// A finished run.
struct Run {
    name: Arc<str>,
    start: Instant,
    end: Instant,
}

/// Runs on this thread.
#[derive(Default)]
struct Runs {
    open: Vec<(Arc<str>, Instant)>,
    finished: Vec<Run>,
}

thread_local! {
    static RUNS: RefCell<Runs> = RefCell::default();
}

impl<S: Subscriber + for<'a> LookupSpan<'a>> Layer<S> for SystemSpans {
    fn on_new_span(&self, attributes: &Attributes<'_>, id: &Id, context: Context<'_, S>) {
        if attributes.metadata().name() != "system" {
            return;
        }
        let mut path = PathField(None);
        attributes.record(&mut path);
        if let (Some(path), Some(span)) = (path.0, context.span(id)) {
            let name = SystemName(short_name(&path).into());
            span.extensions_mut().insert(name);
        }
    }

    fn on_enter(&self, id: &Id, context: Context<'_, S>) {
        if let Some(name) = system_name(id, &context) {
            RUNS.with_borrow_mut(|runs| runs.open.push((name, Instant::now())));
        }
    }

    fn on_exit(&self, id: &Id, context: Context<'_, S>) {
        let end = Instant::now();
        if system_name(id, &context).is_none() {
            return;
        }
        RUNS.with_borrow_mut(|runs| {
            let Some((name, start)) = runs.open.pop() else {
                return;
            };
            if runs.finished.len() == RUNS_CAPACITY {
                runs.finished.clear();
            }
            runs.finished.push(Run { name, start, end });
        });
    }
}

fn system_name<S: Subscriber + for<'a> LookupSpan<'a>>(
    id: &Id,
    context: &Context<'_, S>,
) -> Option<Arc<str>> {
    let span = context.span(id)?;
    let extensions = span.extensions();
    extensions
        .get::<SystemName>()
        .map(|name| Arc::clone(&name.0))
}

/// Forgets what ran on this thread up to now: a frame begins, and what ran between two of them is of neither.
pub(crate) fn forget() {
    RUNS.with_borrow_mut(|runs| runs.finished.clear());
}

/// Takes the systems that ran since [`forget`], in order of start, into `spans`; times are from `start` on.
///
/// The calling system counts as run up to now. Those that ran ahead of the one that noted `start` begin at a negative time.
pub(super) fn drain(start: Instant, spans: &mut Vec<Span>) {
    let now = Instant::now();
    spans.clear();
    RUNS.with_borrow_mut(|runs| {
        let finished = runs.finished.drain(..);
        spans.extend(finished.map(|run| span(run.name, start, run.start, run.end)));
        if let Some((name, began)) = runs.open.last().cloned() {
            spans.push(span(name, start, began, now));
        }
    });
    spans.sort_by(|a, b| a.start_micros.total_cmp(&b.start_micros));
}

fn span(name: Arc<str>, frame: Instant, start: Instant, end: Instant) -> Span {
    Span {
        name,
        start_micros: micros_between(frame, start),
        // A clock tick is the least a system can be said to take.
        micros: micros_between(start, end).max(1e-3),
        depth: 0,
    }
}

/// Reads the field `name`.
struct PathField(Option<String>);

impl Visit for PathField {
    fn record_str(&mut self, field: &Field, value: &str) {
        if field.name() == "name" {
            self.0 = Some(value.to_owned());
        }
    }

    fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
        if field.name() == "name" {
            self.0 = Some(format!("{value:?}"));
        }
    }
}

/// A type path with every module left out: `a::b::f<c::D, e::F>` becomes `f<D, F>`.
pub(super) fn short_name(path: &str) -> String {
    let mut short = String::with_capacity(path.len());
    let mut word = 0;
    let mut characters = path.chars().peekable();
    while let Some(c) = characters.next() {
        if c == ':' && characters.peek() == Some(&':') {
            characters.next();
            short.truncate(word);
        } else {
            short.push(c);
            if !(c.is_alphanumeric() || c == '_') {
                word = short.len();
            }
        }
    }
    short
}

/// Sends log lines of `log_level` and worse to stderr and times systems, for the whole process. Call it
/// before the engine is built.
///
/// `log_level` is `error`, `warn`, `info`, `debug`, `trace`, `off`, or filters of the form
/// `orrery_engine::import=debug,warn`.
///
/// # Errors
/// A sentence, if the level is none of these or another subscriber is in place already.
pub fn install(log_level: &str) -> Result<(), String> {
    let filter = EnvFilter::try_new(log_level).map_err(|error| {
        format!("log level `{log_level}` is not understood ({error}); expected error, warn, info, debug, trace or off")
    })?;
    let log = log::layer()
        .with_writer(std::io::stderr)
        .without_time()
        .with_target(false)
        .with_filter(filter);
    let subscriber = tracing_subscriber::registry().with(SystemSpans).with(log);
    tracing::subscriber::set_global_default(subscriber)
        .map_err(|_| "logging is already set up".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_names_leave_modules_out() {
        for (path, short) in [
            ("a::b::f", "f"),
            ("f", "f"),
            ("a::f<b::C, (d::E, F)>", "f<C, (E, F)>"),
            ("a::plugin::{{closure}}", "{{closure}}"),
        ] {
            assert_eq!(short_name(path), short);
        }
    }

    #[test]
    fn runs_nobody_collects_are_bounded() {
        let subscriber = tracing_subscriber::registry().with(SystemSpans);
        tracing::subscriber::with_default(subscriber, || {
            let span = tracing::info_span!("system", name = "a::b");
            for _ in 0..3 * RUNS_CAPACITY {
                span.in_scope(|| ());
            }
        });
        RUNS.with_borrow(|runs| assert!(runs.finished.len() <= RUNS_CAPACITY));
    }
}
