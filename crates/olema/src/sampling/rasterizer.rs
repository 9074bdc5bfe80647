//! The five rasterizers and Auto behind one door.
//!
//! In: a [`MovingDraw`] and the [`Rasterizer`] asked for. Out: hits and counts, and which one did the work.
//! They differ in the samples that they test, never in those that they hit. Sources: Fatahalian 2009, section
//! 3; Sattlecker 2015, section 3.3.

use std::fmt;
use std::str::FromStr;

use super::draw::{Kernels, Micropolygons, MovingDraw};
use super::inside::HitPoint;
use super::interval_lanes::Bounds;
use super::nomotion::{self, GridView, HitSink, SampleCounts};
use super::{
    auto, boundingbox, interleave, interleave_lanes, interval, interval_lanes, nomotion_lanes, simple,
};
use crate::error::Error;

/// A way to find the samples that micropolygons cover.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Rasterizer {
    /// Per grid the one of NoMotion, Interval and InterleaveUvt that should cost least ([`auto`]).
    #[default]
    Auto,
    /// For grids that stand still and are in focus ([`nomotion`]).
    NoMotion,
    /// Bounds per stratum ([`interval`]).
    Interval,
    /// Positions per tuple, K of at most 8 ([`interleave`]).
    InterleaveUvt,
    /// One box for all ([`boundingbox`]).
    BoundingBox,
    /// Accumulation, K = 1 ([`simple`]).
    Simple,
}

/// The rasterizer that was asked for cannot draw the grid; nothing was drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Unsuited {
    /// NoMotion, and the grid moves or is out of focus.
    #[error("NoMotion draws only what stands still and is in focus")]
    Blurred,
    /// InterleaveUvt or Simple, and the pattern's tile is too large.
    #[error("{rasterizer:?} needs a pattern tile of at most {most} x {most} pixels, not {tile} x {tile}")]
    Tile {
        /// The one that was asked for.
        rasterizer: Rasterizer,
        /// K of the pattern.
        tile: u32,
        /// Largest K that it takes.
        most: u32,
    },
}

impl fmt::Display for Rasterizer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Rasterizer {
    type Err = Error;

    /// The rasterizer of that [`Rasterizer::name`].
    ///
    /// # Errors
    /// [`Error::Setting`] where there is none.
    fn from_str(name: &str) -> Result<Self, Error> {
        let found = Rasterizer::ALL.into_iter().find(|rasterizer| rasterizer.name() == name);
        found.ok_or_else(|| Error::Setting {
            what: "rasterizer",
            found: format!("{name:?}"),
            expected: Rasterizer::ALL.map(Rasterizer::name).join(", "),
        })
    }
}

impl Rasterizer {
    /// All of them.
    pub const ALL: [Rasterizer; 6] = [
        Rasterizer::Auto,
        Rasterizer::NoMotion,
        Rasterizer::Interval,
        Rasterizer::InterleaveUvt,
        Rasterizer::BoundingBox,
        Rasterizer::Simple,
    ];

    /// What options and scenes call it.
    pub fn name(self) -> &'static str {
        match self {
            Rasterizer::Auto => "auto",
            Rasterizer::NoMotion => "nomotion",
            Rasterizer::Interval => "interval",
            Rasterizer::InterleaveUvt => "interleave",
            Rasterizer::BoundingBox => "boundingbox",
            Rasterizer::Simple => "simple",
        }
    }

    /// Largest K that it can do with.
    pub fn greatest_tile(self) -> u32 {
        match self {
            Rasterizer::Simple => 1,
            Rasterizer::InterleaveUvt => interleave::MAX_TILE,
            _ => u32::MAX,
        }
    }

    /// Rasterizes a grid; returns the one that did it, which is `self` unless that is [`Rasterizer::Auto`].
    ///
    /// # Errors
    /// [`Unsuited`] where it cannot draw this grid or use this pattern.
    pub fn rasterize<S: HitSink>(
        self,
        draw: &MovingDraw,
        counts: &mut SampleCounts,
        sink: &mut S,
    ) -> Result<Rasterizer, Unsuited> {
        let (tile, most) = (draw.pattern.tile(), self.greatest_tile());
        if tile > most {
            return Err(Unsuited::Tile { rasterizer: self, tile, most });
        }
        match self {
            Rasterizer::Auto => return auto::choose(draw).rasterize(draw, counts, sink),
            Rasterizer::NoMotion => {
                rasterize_still(draw, draw.grid.still().ok_or(Unsuited::Blurred)?, counts, sink);
            }
            Rasterizer::Interval => match draw.kernels {
                Kernels::Lanes(level) if interval_lanes::takes(draw) => {
                    interval_lanes::rasterize(level, draw, Bounds::Strata, counts, sink);
                }
                _ => interval::rasterize(draw, counts, sink),
            },
            Rasterizer::InterleaveUvt => match draw.kernels {
                Kernels::Lanes(level) if interleave_lanes::takes(draw) => {
                    interleave_lanes::rasterize(level, draw, counts, sink);
                }
                _ => interleave::rasterize(draw, counts, sink),
            },
            Rasterizer::BoundingBox => match draw.kernels {
                Kernels::Lanes(level) if interval_lanes::takes(draw) => {
                    interval_lanes::rasterize(level, draw, Bounds::Whole, counts, sink);
                }
                _ => boundingbox::rasterize(draw, counts, sink),
            },
            Rasterizer::Simple => match draw.kernels {
                // InterleaveUvt with K = 1.
                Kernels::Lanes(level) if interleave_lanes::takes(draw) => {
                    interleave_lanes::rasterize(level, draw, counts, sink);
                }
                _ => simple::rasterize(draw, counts, sink),
            },
        }
        Ok(self)
    }
}

/// NoMotion.
fn rasterize_still<S: HitSink>(draw: &MovingDraw, grid: GridView, counts: &mut SampleCounts, sink: &mut S) {
    let (facing, samples) = (draw.facing, draw.samples);
    if draw.micropolygons == Micropolygons::Quads {
        if let Kernels::Lanes(level) = draw.kernels
            && nomotion_lanes::takes(samples)
        {
            return nomotion_lanes::rasterize_grid(level, grid, facing, draw.skip, samples, counts, sink);
        }
        return nomotion::rasterize_grid(grid, facing, draw.skip, samples, counts, sink);
    }
    for quad in 0..grid.m * grid.n {
        let corners = grid.corners(quad % grid.m, quad / grid.m);
        if draw.is_skipped(corners) {
            continue;
        }
        sink.begin(quad as u32);
        for (number, triangle) in [[0, 1, 2], [0, 2, 3]].into_iter().enumerate() {
            let vertices = triangle.map(|corner: usize| corners[corner]);
            let xy = vertices.map(|vertex| [grid.x[vertex], grid.y[vertex]]);
            let depth = vertices.map(|vertex| grid.depth[vertex]);
            let mut sink = Numbered { number: number as u8, sink };
            nomotion::rasterize_triangle(xy, depth, facing, samples, counts, &mut sink);
        }
    }
}

/// Gives hits the number of their triangle.
struct Numbered<'a, S> {
    number: u8,
    sink: &'a mut S,
}

impl<S: HitSink> HitSink for Numbered<'_, S> {
    fn hit(&mut self, sample_ix: usize, point: HitPoint, _triangle: u8, sign: i8) {
        self.sink.hit(sample_ix, point, self.number, sign);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_back_to_their_rasterizers() {
        for rasterizer in Rasterizer::ALL {
            assert_eq!(rasterizer.to_string().parse(), Ok(rasterizer));
        }
        let error = "fast".parse::<Rasterizer>().expect_err("no rasterizer").to_string();
        assert_eq!(
            error,
            "rasterizer is \"fast\": expected auto, nomotion, interval, interleave, boundingbox, simple"
        );
    }
}
