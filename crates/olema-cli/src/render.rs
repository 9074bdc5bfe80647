//! `olema render`: scenes in, pictures out, frame by frame.

mod overrides;

use std::path::Path;
use std::time::Instant;

use olema::{Error, Hooks, Image, Progress, Renderer, Stats};
use olema_formats::rib::{Display, RibFrame};

use crate::args::{ProgressKind, RenderArgs};
use crate::exit::{self, Failure};
use crate::interrupt::Interrupt;
use crate::memory::Budget;
use crate::output::{self, Names, Subject};
use crate::picture;
use crate::progress::Meter;
use crate::report::{self, Reporter};
use crate::source;
use crate::stats_file::{self, FrameRecord, SettingsRecord, StatsFile};

/// Renders what was asked for. Returns the exit code: that of the first thing that went wrong.
pub fn run(args: &RenderArgs) -> u8 {
    let json = args.progress == ProgressKind::Json;
    let options = report::Options { quiet: args.quiet, verbose: args.verbose, json };
    let mut reporter = Reporter::new(options);
    let code = match Job::new(args, &mut reporter) {
        Ok(mut job) => job.run(),
        Err(failure) => reporter.failure(&failure),
    };
    reporter.finish();
    code
}

/// One run of the command.
struct Job<'a> {
    args: &'a RenderArgs,
    reporter: &'a mut Reporter,
    interrupt: Interrupt,
    memory: Budget,
    names: Names,
    stats: StatsFile,
    /// Worlds met, in all files: the number of one that stands in no frame block.
    worlds: i32,
}

impl<'a> Job<'a> {
    /// Checks all that can be checked before work begins.
    fn new(args: &'a RenderArgs, reporter: &'a mut Reporter) -> Result<Self, Failure> {
        source::check_search_path(&args.search_path)?;
        if let Some(path) = &args.stats {
            output::check_place(path)
                .map_err(|e| Failure::new(exit::USAGE, format!("--stats {}: {e}", path.display())))?;
        }
        if args.files.iter().filter(|f| *f == Path::new("-")).count() > 1 {
            return Err(Failure::new(
                exit::USAGE,
                "- stands for standard input, which can be read only once",
            ));
        }
        let names = Names::new(args.output.as_deref())?;
        let interrupt = Interrupt::install();
        let memory = Budget::new(args.memory);
        Ok(Job { args, reporter, interrupt, memory, names, stats: StatsFile::new(), worlds: 0 })
    }

    /// Renders all files. A file that fails does not keep the others from being rendered.
    fn run(&mut self) -> u8 {
        let mut code = exit::OK;
        for file in &self.args.files {
            let this = self.file(file);
            code = first_of(code, this);
            if let Some(signal) = self.interrupt.exit_code() {
                return signal;
            }
        }
        if code == exit::OK && self.reporter.counts().errors > 0 {
            // Pictures were made, but not of all that the scenes say.
            code = exit::SCENE;
        }
        code
    }

    fn file(&mut self, file: &Path) -> u8 {
        let mut reader =
            match source::open(file, &self.args.search_path, self.args.model, self.memory.reader()) {
                Ok(reader) => reader,
                Err(error) => return self.reporter.read_error(error),
            };
        let (mut code, mut found, mut chosen) = (exit::OK, 0, 0);
        loop {
            let began = Instant::now();
            let next = reader.next_frame();
            let read_seconds = began.elapsed().as_secs_f64();
            self.reporter.diagnostics(reader.take_diagnostics());
            match next {
                Ok(None) => break,
                Err(error) => return first_of(code, self.reporter.read_error(error)),
                Ok(Some(frame)) => {
                    self.worlds = self.worlds.saturating_add(1);
                    found += 1;
                    let number = frame.number.unwrap_or(self.worlds);
                    if self.args.frames.as_ref().is_some_and(|frames| !frames.contains(number)) {
                        continue;
                    }
                    chosen += 1;
                    if let Err(failure) = self.frame(file, number, frame, read_seconds) {
                        if let Some(signal) = self.interrupt.exit_code() {
                            return signal;
                        }
                        code = first_of(code, self.reporter.failure(&failure));
                    }
                }
            }
        }
        if chosen == 0 {
            let problem = match found {
                0 => format!("nothing to render: expected {}", reader.expected()),
                n => format!("none of its {n} frames is among those of --frames"),
            };
            let failure = Failure::new(exit::SCENE, format!("{}: {problem}", file.display()));
            code = first_of(code, self.reporter.failure(&failure));
        }
        code
    }

    /// Renders one frame and writes its picture.
    fn frame(&mut self, file: &Path, number: i32, frame: RibFrame, read_seconds: f64) -> Result<(), Failure> {
        let RibFrame { mut scene, settings, displays, .. } = frame;
        let mut settings = overrides::settings(self.args, settings)?;
        self.memory.limit(&mut settings);
        overrides::scene(self.args, &mut scene);
        let display = self.primary(number, &displays);
        let name = display.as_ref().map_or("", |d| d.name.as_str());
        let path = self.names.name(Subject { scene: file, display: name, frame: number })?;

        // Until the guard goes, a signal stops the renderer and lets a picture that is being written be finished.
        let busy = self.interrupt.busy();
        let renderer = Renderer::new(settings)?;
        let meter = Meter::new(self.args.progress, self.args.quiet, number);
        let mut picture = picture::begin(&path, renderer.settings(), display.as_ref())?;
        let mut pushed = Ok(());
        let drawn = draw(&renderer, scene, &meter, &self.interrupt, &mut |rows| {
            if pushed.is_ok() {
                pushed = picture.push(rows);
            }
        });
        meter.finish();
        let mut stats = drawn?;
        picture::finish(&picture, pushed)?;
        stats.seconds.read = read_seconds;
        stats.peak_memory = stats_file::peak_memory();
        for warning in &stats.warnings {
            self.reporter.warning(warning.as_str());
        }
        meter.done(&path, renderer.settings(), &stats);
        if !self.args.quiet {
            report::print(&format!("{}\n", path.display()))?;
        }
        self.stats.push(FrameRecord {
            scene: file.to_string_lossy().into_owned(),
            frame: number,
            picture: path.to_string_lossy().into_owned(),
            settings: SettingsRecord::new(renderer.settings(), self.args.shading_rate, self.memory.0),
            stats,
        });
        // After each picture, so that a run that is stopped leaves the figures of those it finished.
        if let Some(stats_path) = &self.args.stats {
            self.stats.write(stats_path)?;
        }
        drop(busy);
        Ok(())
    }

    /// The display that is written. Others, and channels that a PNG of colours cannot hold, are told about.
    fn primary(&mut self, number: i32, displays: &[Display]) -> Option<Display> {
        for other in displays.iter().skip(1) {
            self.reporter.warning(format!(
                "frame {number}: Display {:?} of {:?} is not written: only the first display is, so far",
                other.name, other.mode
            ));
        }
        let first = displays.first()?;
        if !matches!(first.mode.as_str(), "rgb" | "rgba") {
            self.reporter.warning(format!(
                "frame {number}: Display {:?} asks for {:?}; colour and alpha are written",
                first.name, first.mode
            ));
        }
        Some(first.clone())
    }
}

/// Calls the renderer with everything it may look at; `rows` gets the picture.
fn draw(
    renderer: &Renderer,
    scene: olema::Scene,
    meter: &Meter,
    interrupt: &Interrupt,
    rows: &mut (dyn FnMut(&Image) + Send),
) -> Result<Stats, Error> {
    let began = Instant::now();
    let clock = || began.elapsed().as_secs_f64();
    let progress = |p: Progress| meter.update(p);
    let hooks = Hooks {
        progress: Some(&progress),
        cancel: Some(interrupt.token()),
        clock: Some(&clock),
        bucket: None,
    };
    renderer.render_rows(scene, &hooks, rows)
}

fn first_of(code: u8, next: u8) -> u8 {
    if code == exit::OK { next } else { code }
}
