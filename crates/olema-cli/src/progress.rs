//! Tells how far a render is: a bar with the time left on a terminal, lines or JSON objects elsewhere.
//!
//! The library calls [`Meter::update`] from any thread, perhaps thousands of times a second; what is printed is
//! limited here.

use std::io::{IsTerminal, Write};
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use olema::{Progress, Settings, Stats};
use serde_json::json;

use crate::args::ProgressKind;

/// Plain lines: at most one in this time, and only when another tenth is done.
const PLAIN_EVERY: Duration = Duration::from_secs(2);
/// JSON objects: at most one in this time.
const JSON_EVERY: Duration = Duration::from_millis(100);

/// The way it is told, with `auto` decided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Style {
    Bar,
    Plain,
    Json,
    None,
}

fn style(kind: ProgressKind, quiet: bool) -> Style {
    match kind {
        _ if quiet => Style::None,
        ProgressKind::None => Style::None,
        ProgressKind::Plain => Style::Plain,
        ProgressKind::Json => Style::Json,
        ProgressKind::Auto if std::io::stderr().is_terminal() => Style::Bar,
        ProgressKind::Auto => Style::Plain,
    }
}

/// The progress of one picture.
#[derive(Debug)]
pub struct Meter {
    style: Style,
    frame: i32,
    bar: ProgressBar,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    stage: &'static str,
    stage_began: Instant,
    last: Option<Instant>,
    /// Tenths of the stage that were told; JSON: whether the end was.
    tenths: u64,
}

impl Meter {
    /// A meter for that frame.
    pub fn new(kind: ProgressKind, quiet: bool, frame: i32) -> Self {
        let style = style(kind, quiet);
        let bar = if style == Style::Bar {
            let bar = ProgressBar::with_draw_target(Some(1), ProgressDrawTarget::stderr());
            let template = "{prefix} {msg:5} [{bar:40}] {percent:>3} % {elapsed}, {eta} left";
            // A wrong template shows as the plain bar.
            let looks =
                ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
            bar.with_style(looks.progress_chars("=> ")).with_prefix(format!("frame {frame}"))
        } else {
            ProgressBar::hidden()
        };
        let state = State { stage: "", stage_began: Instant::now(), last: None, tenths: 0 };
        Meter { style, frame, bar, state: Mutex::new(state) }
    }

    /// The renderer is this far.
    pub fn update(&self, progress: Progress) {
        if self.style == Style::None {
            return;
        }
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if state.stage != progress.stage {
            *state = State { stage: progress.stage, stage_began: Instant::now(), last: None, tenths: 0 };
            self.bar.set_length(progress.total);
            self.bar.reset();
            self.bar.set_message(progress.stage);
        }
        match self.style {
            Style::Bar => {
                self.bar.set_length(progress.total);
                self.bar.set_position(progress.done);
            }
            Style::Plain | Style::Json => {
                if let Some(line) = self.line(&mut state, progress, Instant::now()) {
                    // A closed standard error is no reason to stop rendering.
                    let _ = std::io::stderr().lock().write_all(line.as_bytes());
                }
            }
            Style::None => {}
        }
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }

    /// The picture is written.
    pub fn done(&self, path: &Path, settings: &Settings, stats: &Stats) {
        let ([x0, x1, y0, y1], samples) = (settings.window_px(), settings.samples_per_pixel());
        let (w, h, seconds) = (x1 - x0, y1 - y0, stats.seconds.total);
        let line = match self.style {
            Style::None => return,
            Style::Json => json!({
                "event": "picture", "frame": self.frame, "path": path.to_string_lossy(), "width": w, "height": h,
                "samples": samples, "seconds": seconds, "peak_memory": stats.peak_memory,
            })
            .to_string(),
            Style::Bar | Style::Plain => {
                let memory = match stats.peak_memory >> 20 {
                    0 => String::new(),
                    mib => format!(", {mib} MiB at most"),
                };
                format!("frame {}: {w}x{h}, {samples} samples a pixel, {seconds:.2} s{memory}", self.frame)
            }
        };
        let _ = writeln!(std::io::stderr().lock(), "{line}");
    }

    /// The line to print, if it is time for one. A stage that is done at once needs no plain line.
    fn line(&self, state: &mut State, progress: Progress, now: Instant) -> Option<String> {
        let Progress { stage, done, total } = progress;
        let tenths = (done.saturating_mul(10)).checked_div(total).unwrap_or(0).min(10);
        let ended = total > 0 && done >= total;
        let since = now - state.last.unwrap_or(state.stage_began);
        let due = match self.style {
            Style::Json => state.last.is_none() || since >= JSON_EVERY || ended && state.tenths < 10,
            _ => tenths > state.tenths && (since >= PLAIN_EVERY || ended && state.last.is_some()),
        };
        if !due {
            return None;
        }
        state.last = Some(now);
        state.tenths = tenths;
        let elapsed = now - state.stage_began;
        let left = time_left(elapsed, done, total);
        Some(if self.style == Style::Json {
            let (frame, seconds, left) = (self.frame, elapsed.as_secs_f64(), left.map(|l| l.as_secs_f64()));
            let object = json!({
                "event": "progress", "frame": frame, "stage": stage, "done": done, "total": total,
                "seconds": seconds, "seconds_left": left,
            });
            format!("{object}\n")
        } else {
            let left = match left {
                Some(left) if !ended => format!(", {:.0} s left", left.as_secs_f64()),
                _ => String::new(),
            };
            let percent = (done.saturating_mul(100)).checked_div(total).unwrap_or(0);
            format!("frame {}: {stage} {percent} % ({:.1} s{left})\n", self.frame, elapsed.as_secs_f64())
        })
    }
}

/// Time left at the pace so far.
fn time_left(elapsed: Duration, done: u64, total: u64) -> Option<Duration> {
    if done == 0 {
        return None;
    }
    let seconds = elapsed.as_secs_f64() * total.saturating_sub(done) as f64 / done as f64;
    Duration::try_from_secs_f64(seconds).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is printed for steps (done, total) of a stage, each at its second.
    fn lines(kind: ProgressKind, steps: impl IntoIterator<Item = (f64, u64, u64)>) -> Vec<String> {
        let meter = Meter::new(kind, false, 3);
        let began = Instant::now();
        let mut state = State { stage: "draw", stage_began: began, last: None, tenths: 0 };
        let step = |(seconds, done, total)| {
            let now = began + Duration::from_secs_f64(seconds);
            meter.line(&mut state, Progress { stage: "draw", done, total }, now)
        };
        steps.into_iter().filter_map(step).collect()
    }

    #[test]
    fn plain_lines_are_few_and_the_end_is_told_once() {
        let steps = (0..=1000).map(|n| (n as f64 * 0.01, n, 1000)).chain([(10.0, 1000, 1000)]);
        let lines = lines(ProgressKind::Plain, steps);
        assert_eq!(
            lines,
            [
                "frame 3: draw 20 % (2.0 s, 8 s left)\n",
                "frame 3: draw 40 % (4.0 s, 6 s left)\n",
                "frame 3: draw 60 % (6.0 s, 4 s left)\n",
                "frame 3: draw 80 % (8.0 s, 2 s left)\n",
                "frame 3: draw 100 % (10.0 s)\n",
            ]
        );
    }

    #[test]
    fn a_stage_that_is_done_at_once_needs_no_plain_line() {
        assert!(lines(ProgressKind::Plain, (0..=1000).map(|n| (n as f64 * 1e-3, n, 1000))).is_empty());
    }

    #[test]
    fn json_lines_are_objects() {
        let lines = lines(ProgressKind::Json, [(0.0, 0, 4), (0.01, 1, 4), (0.02, 4, 4), (0.03, 4, 4)]);
        assert_eq!(lines.len(), 2, "{lines:?}");
        for line in &lines {
            let object: serde_json::Value = serde_json::from_str(line).unwrap();
            assert_eq!(object["event"], "progress");
            assert_eq!(object["frame"], 3);
        }
    }

    #[test]
    fn an_unknown_total_divides_by_nothing() {
        assert!(lines(ProgressKind::Plain, [(9.0, 5, 0)]).is_empty());
        assert_eq!(time_left(Duration::from_secs(1), 0, 0), None);
        assert_eq!(time_left(Duration::from_secs(2), 1, 4), Some(Duration::from_secs(6)));
    }

    #[test]
    fn quiet_wins() {
        assert_eq!(style(ProgressKind::Json, true), Style::None);
        assert_eq!(style(ProgressKind::None, false), Style::None);
    }
}
