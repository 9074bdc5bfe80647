//! Engines chain the stages of the pipeline. [`Renderer`] is the door for everyone else.
//!
//! The CPU engine patchifies and connects the scene, splits all patches to about the size of a raster tile
//! (parallel over patches), then draws the tiles (parallel over tiles), each in buffers that stay in cache.

mod bench;
mod cache;
mod filed;
mod frame;
mod laps;
mod output;
mod queue;
mod tile;
mod tiles;
mod workers;

pub use bench::{Bench, grids};

use std::borrow::Cow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use crate::error::Error;
use crate::image::Image;
use crate::pipeline::displace::Corrections;
use crate::sampling::Rasterizer;
use crate::scene::Scene;
use crate::settings::Settings;
use crate::stats::Stats;

/// Tells a render to stop; clones share one flag.
#[derive(Debug, Clone, Default)]
pub struct CancelToken(Arc<AtomicBool>);

impl CancelToken {
    /// Asks for the stop.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether the stop was asked for.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// How far a render is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// What is being done: "split" or "draw".
    pub stage: &'static str,
    /// Units done of this stage.
    pub done: u64,
    /// Units in all.
    pub total: u64,
}

/// What a render may call while it runs. All may be called from any worker thread.
#[derive(Default, Clone, Copy)]
pub struct Hooks<'a> {
    /// Called as work is finished.
    pub progress: Option<&'a (dyn Fn(Progress) + Sync)>,
    /// Looked at between units of work.
    pub cancel: Option<&'a CancelToken>,
    /// Seconds from any fixed point, for [`Stats::seconds`].
    pub clock: Option<&'a (dyn Fn() -> f64 + Sync)>,
    /// Called with each finished output bucket (channels "r", "g", "b", "a", "z").
    pub bucket: Option<&'a (dyn Fn(&Image) + Sync)>,
}

impl Hooks<'_> {
    fn is_cancelled(&self) -> bool {
        self.cancel.is_some_and(CancelToken::is_cancelled)
    }

    fn report(&self, stage: &'static str, done: u64, total: u64) {
        if let Some(progress) = self.progress {
            progress(Progress { stage, done, total });
        }
    }
}

/// Measures with the caller's clock, or not at all.
struct Stopwatch<'a> {
    clock: Option<&'a (dyn Fn() -> f64 + Sync)>,
    start: f64,
}

impl<'a> Stopwatch<'a> {
    fn new(hooks: &Hooks<'a>) -> Self {
        Stopwatch { clock: hooks.clock, start: hooks.clock.map_or(0.0, |now| now()) }
    }

    fn seconds(&self) -> f64 {
        self.clock.map_or(0.0, |now| now() - self.start)
    }
}

/// A finished picture and what it took.
#[derive(Debug, Clone)]
pub struct Frame {
    /// Channels "r", "g", "b", "a", "z" of the window that was asked for.
    pub image: Image,
    /// Counters and times.
    pub stats: Stats,
}

/// Renders scenes on the CPU.
#[derive(Debug, Clone)]
pub struct Renderer {
    settings: Settings,
}

impl Renderer {
    /// A renderer with these settings.
    ///
    /// # Errors
    /// [`Error::Setting`] where one is outside its range.
    pub fn new(settings: Settings) -> Result<Self, Error> {
        settings.validate()?;
        Ok(Renderer { settings })
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Renders `scene`.
    ///
    /// # Errors
    /// [`Error::Scene`] where the scene contradicts itself, [`Error::Cancelled`] where the token was set,
    /// [`Error::Memory`] where the picture does not fit.
    pub fn render(&self, scene: &Scene, hooks: &Hooks) -> Result<Frame, Error> {
        scene.validate()?;
        let output = output::Whole::new(&self.settings)?;
        let (output, stats) =
            self.render_to(Cow::Borrowed(scene), hooks, |_| output::Output::Whole(output))?;
        let output::Output::Whole(whole) = output else { unreachable!("what goes in comes out") };
        Ok(Frame { image: whole.into_image(), stats })
    }

    /// Renders `scene` without holding the picture: `rows` is given it from the top, as many whole rows at a time as are
    /// finished, each once, with the channels of [`Frame::image`]. [`Hooks::bucket`] is not called.
    ///
    /// What of the scene is no longer needed once its patches are made is let go of, unless a copy of it shares it.
    ///
    /// # Errors
    /// As [`Self::render`]; the rows that were finished until then were given.
    pub fn render_rows(
        &self,
        scene: Scene,
        hooks: &Hooks,
        rows: &mut (dyn FnMut(&Image) + Send),
    ) -> Result<Stats, Error> {
        scene.validate()?;
        let (_, stats) = self.render_to(Cow::Owned(scene), hooks, |side| {
            output::Output::Rows(output::Rows::new(&self.settings, side, rows))
        })?;
        Ok(stats)
    }

    /// Renders to what `output` makes for tiles of a size.
    fn render_to<'o>(
        &self,
        scene: Cow<Scene>,
        hooks: &Hooks,
        output: impl FnOnce(u32) -> output::Output<'o>,
    ) -> Result<(output::Output<'o>, Stats), Error> {
        let workers = workers::Workers::new(self.settings.threads)?;
        let watch = Stopwatch::new(hooks);
        let (output, mut stats) = self.render_with(&workers, scene, hooks, output)?;
        stats.seconds.total = watch.seconds();
        Ok((output, stats))
    }

    fn render_with<'o>(
        &self,
        workers: &workers::Workers,
        scene: Cow<Scene>,
        hooks: &Hooks,
        output: impl FnOnce(u32) -> output::Output<'o>,
    ) -> Result<(output::Output<'o>, Stats), Error> {
        let mut stats = Stats::default();
        let watch = Stopwatch::new(hooks);
        let data = frame::FrameData::new(scene, &self.settings, None, &mut stats);
        stats.seconds.connect = watch.seconds();
        if self.settings.rasterizer == Rasterizer::NoMotion && data.is_blurred() {
            return Err(Error::Setting {
                what: "rasterizer",
                found: "NoMotion".to_owned(),
                expected:
                    "one for motion and defocus (Auto, Interval, InterleaveUvt, BoundingBox or Simple), as \
                           something in the scene moves or the camera has a lens"
                        .to_owned(),
            });
        }
        hooks.report("split", 0, 1);
        let filed = data.file(workers, hooks, &mut stats).ok_or(Error::Cancelled)?;
        hooks.report("split", 1, 1);
        let cache = cache::GridCache::new(self.settings.grid_cache, data.tiles.len());
        let shared = Mutex::new((output(data.tiles.side), stats, None, Corrections::default()));
        let (runs, num_tiles) = (workers::Runs::new(data.tiles.len(), workers.num()), data.tiles.len());
        let done = AtomicUsize::new(0);
        // Tiles are taken in order, so that grids on the border of two tiles do not wait long for the second, and several at
        // a time, so that most of these are drawn by who made them.
        workers.each(|| {
            let (mut worker, mut pixels) = (tile::TileWorker::new(&data, &filed, &cache, hooks), Vec::new());
            for tile in std::iter::from_fn(|| runs.take()).flatten() {
                let result = worker.draw(tile, &mut pixels);
                let mut all = shared.lock().unwrap_or_else(PoisonError::into_inner);
                match result {
                    // Another one could not draw its tile.
                    _ if all.2.is_some() => break,
                    Ok(()) => {
                        let finished = all.0.put(data.tiles.interior(tile), &pixels);
                        if let Some(bucket) = hooks.bucket {
                            finished.iter().for_each(bucket);
                        }
                    }
                    Err(error) => {
                        all.2 = Some(error);
                        break;
                    }
                }
                drop(all);
                hooks.report("draw", done.fetch_add(1, Ordering::Relaxed) as u64 + 1, num_tiles as u64);
            }
            let mut all = shared.lock().unwrap_or_else(PoisonError::into_inner);
            all.1.add(&worker.stats);
            all.3.add(&worker.corrections.borrow());
        });
        let (output, mut stats, error, corrections) =
            shared.into_inner().unwrap_or_else(PoisonError::into_inner);
        match error {
            Some(error) => Err(error),
            None => {
                stats.warnings.extend(corrections.warnings(&data.scene, &data.infos));
                Ok((output, stats))
            }
        }
    }
}
