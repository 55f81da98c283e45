//! Progress on stderr: a bar on a terminal, plain lines every ten seconds elsewhere, or JSON lines for
//! programs.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use adumbra_bake::Progress;
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};
use schemars::JsonSchema;
use serde::Serialize;

/// How progress is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Style {
    /// A bar on a terminal, plain lines elsewhere.
    Auto,
    /// A line every ten seconds.
    Plain,
    /// JSON lines, at most ten per second:
    /// {"event","done","total","texels_per_second","eta_seconds","result_bytes"}.
    Json,
    /// Nothing.
    None,
}

/// A line of [`Style::Json`].
#[derive(Serialize, JsonSchema)]
pub struct Line {
    /// `bake`, or `trace` where points are traced.
    event: &'static str,
    /// Number of units that are done: root blocks of a bake, 512 equal cubes of a tree, or blocks of points.
    done: usize,
    /// Total number of units.
    total: usize,
    /// Texels per second since the bake began. Of a tree, these are voxels, and of points themselves.
    texels_per_second: f64,
    /// Estimated seconds until the bake is done, extrapolated from the time so far. Null at first.
    eta_seconds: Option<f64>,
    /// Bytes of memory that the result takes so far.
    result_bytes: u64,
}

/// Share of the units below which no remaining time is estimated.
const WARM_UP_SHARE: f64 = 0.03;

/// The units that progress is counted in.
#[derive(Clone, Copy)]
pub struct Units {
    event: &'static str,
    doing: &'static str,
    parts: &'static str,
    millions: &'static str,
}

impl Units {
    /// Root blocks and texels, for light-aligned bakes.
    pub const TEXELS: Self =
        Self { event: "bake", doing: "baking", parts: "root blocks", millions: "Mtexel" };
    /// Cubes and voxels, for world-aligned bakes.
    pub const VOXELS: Self = Self { event: "bake", doing: "baking", parts: "cubes", millions: "Mvoxel" };
    /// Blocks of points, for rays from points.
    pub const POINTS: Self =
        Self { event: "trace", doing: "tracing", parts: "blocks of points", millions: "Mpoint" };
}

/// Shows the progress of a bake.
pub struct Reporter {
    style: Style,
    units: Units,
    start: Instant,
    state: Mutex<State>,
}

struct State {
    bar: Option<ProgressBar>,
    last: Option<Instant>,
}

impl Reporter {
    /// Creates a reporter and starts its clock.
    pub fn new(style: Style, units: Units) -> Self {
        let style = match style {
            Style::Auto if !std::io::stderr().is_terminal() => Style::Plain,
            other => other,
        };
        Self { style, units, start: Instant::now(), state: Mutex::new(State { bar: None, last: None }) }
    }

    /// Shows the progress if an update is due.
    pub fn update(&self, p: Progress) {
        let mut state = self.state.lock().unwrap_or_else(|e| e.into_inner());
        let seconds = self.start.elapsed().as_secs_f64();
        let share = p.done as f64 / p.total as f64;
        let rate = p.done as f64 * p.texels_per_unit as f64 / seconds.max(1e-9);
        // Points come by thousands a second, texels by millions.
        let decimals = if rate < 1e7 { 2 } else { 0 };
        let eta = (share >= WARM_UP_SHARE).then(|| seconds * (1.0 - share) / share);
        let format_eta = eta.map_or("warming up".to_owned(), |s| format!("{s:.0} s left"));
        let finished = p.done == p.total;
        let due = |last: Option<Instant>, gap: Duration| last.is_none_or(|t| t.elapsed() >= gap) || finished;
        match self.style {
            Style::Auto => {
                let bar = state.bar.get_or_insert_with(|| new_bar(p.total as u64, self.units));
                bar.set_position(p.done as u64);
                bar.set_message(format!(
                    "{:.*} {}/s, {:.1} MB, {format_eta}",
                    decimals,
                    rate / 1e6,
                    self.units.millions,
                    p.result_bytes as f64 / 1e6
                ));
                if finished {
                    bar.finish_and_clear();
                }
            }
            Style::Plain => {
                let long = seconds >= 10.0 || state.last.is_some();
                if long && due(state.last, Duration::from_secs(10)) {
                    state.last = Some(Instant::now());
                    crate::note!(
                        "{}: {} of {} {}, {:.*} {}/s, {:.1} MB, {format_eta}",
                        self.units.doing,
                        p.done,
                        p.total,
                        self.units.parts,
                        decimals,
                        rate / 1e6,
                        self.units.millions,
                        p.result_bytes as f64 / 1e6
                    );
                }
            }
            Style::Json => {
                if due(state.last, Duration::from_millis(100)) {
                    state.last = Some(Instant::now());
                    let line = Line {
                        event: self.units.event,
                        done: p.done,
                        total: p.total,
                        texels_per_second: rate,
                        eta_seconds: eta,
                        result_bytes: p.result_bytes,
                    };
                    if let Ok(line) = serde_json::to_value(&line) {
                        crate::note!("{line}");
                    }
                }
            }
            Style::None => {}
        }
    }
}

fn new_bar(count: u64, Units { doing, parts, .. }: Units) -> ProgressBar {
    let bar = ProgressBar::new(count);
    let template = format!("{{spinner}} {doing} [{{wide_bar}}] {{pos}}/{{len}} {parts}, {{msg}}");
    if let Ok(style) = ProgressStyle::with_template(&template) {
        bar.set_style(style);
    }
    bar
}
