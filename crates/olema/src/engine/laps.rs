//! Laps: what of a worker's time each stage takes.
//!
//! A stage lasts until the next one is entered, so that one look at the clock tells when the one ends and the other begins,
//! and no time falls between them. There are some six changes of stage a grid.

use super::Hooks;
use crate::stats::Seconds;

/// What a worker is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stage {
    /// Nothing that is told.
    Other,
    Split,
    Dice,
    Cull,
    Shade,
    Sample,
    Resolve,
}

/// Measures with the caller's clock, or not at all.
pub(super) struct Laps<'a> {
    clock: Option<&'a (dyn Fn() -> f64 + Sync)>,
    since: f64,
    stage: Stage,
}

impl<'a> Laps<'a> {
    pub fn new(hooks: &Hooks<'a>) -> Self {
        Laps { clock: hooks.clock, since: 0.0, stage: Stage::Other }
    }

    /// Ends a stage and begins with the next one.
    pub fn enter(&mut self, stage: Stage, seconds: &mut Seconds) {
        let (Some(clock), true) = (self.clock, stage != self.stage) else { return };
        let now = clock();
        let ended = match self.stage {
            Stage::Other => None,
            Stage::Split => Some(&mut seconds.split),
            Stage::Dice => Some(&mut seconds.dice),
            Stage::Cull => Some(&mut seconds.cull),
            Stage::Shade => Some(&mut seconds.shade),
            Stage::Sample => Some(&mut seconds.sample),
            Stage::Resolve => Some(&mut seconds.resolve),
        };
        if let Some(ended) = ended {
            *ended += now - self.since;
        }
        (self.stage, self.since) = (stage, now);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;

    #[test]
    fn each_stage_lasts_until_the_next_one() {
        let ticks = AtomicU32::new(0);
        let clock = || f64::from(ticks.fetch_add(1, Ordering::Relaxed));
        let hooks = Hooks { clock: Some(&clock), ..Hooks::default() };
        let (mut laps, mut seconds) = (Laps::new(&hooks), Seconds::default());
        for stage in [Stage::Split, Stage::Split, Stage::Cull, Stage::Split, Stage::Dice, Stage::Other] {
            laps.enter(stage, &mut seconds);
        }
        laps.enter(Stage::Resolve, &mut seconds);
        let expected = Seconds { split: 2.0, cull: 1.0, dice: 1.0, ..Seconds::default() };
        assert_eq!((seconds, ticks.into_inner()), (expected, 6));
        let mut still = Laps::new(&Hooks::default());
        still.enter(Stage::Split, &mut seconds);
        still.enter(Stage::Other, &mut seconds);
        assert_eq!(seconds, expected, "without a clock");
    }
}
