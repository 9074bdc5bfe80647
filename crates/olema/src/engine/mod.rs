//! Engines chain the stages of the pipeline. [`Renderer`] is the door for everyone else.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::Error;
use crate::image::Image;
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
    pub fn render(&self, _scene: &Scene, _hooks: &Hooks) -> Result<Frame, Error> {
        Err(Error::Cancelled)
    }
}
