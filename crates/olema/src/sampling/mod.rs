//! Sampling: where the samples of a picture are, and which micropolygons they hit.
//!
//! In: micropolygons in raster space. Out: visibility records, one a sample ([`buffer::SampleBuffer`]) and
//! any number for transparent surfaces ([`transparent::TransparentRecords`]).
//!
//! Raster space is full-frame, x right and y down, in 1/256 px as `i32`; pixel (px, py) covers
//! `[256 px, 256 px + 256) x [256 py, 256 py + 256)`, and pixels may be negative (filters reach beyond the
//! frame).
//!
//! - [`pattern`] is data that never changes once it is built: the tuples (lens, time, sub-pixel place) and
//!   how they are dealt out to pixels. It is built from [`strata`] (spread by `discrepancy`), [`lens`], [`shutter`] and
//!   [`hash`].
//! - [`inside`] is the one exact test and the one depth function that all rasterizers share.
//! - [`nomotion`] is the scalar rasterizer for micropolygons that stand still, written to be read.
//! - [`moving`] says where a vertex of a moving, defocused grid is for a tuple, exactly; [`draw`] is what the
//!   rasterizers of such grids share. Each of them is a file, named as its paper names it: [`interval`],
//!   [`interleave`], [`boundingbox`], [`simple`], and [`auto`] picks one. [`Rasterizer`] is the door to all.
//!   They test different samples and hit the same.
//! - `nomotion_lanes`, `interval_lanes` and `interleave_lanes` do the work of their scalar twins with vector instructions,
//!   on vertices in 16 bits (`packed`), strata and tuples as vectors (`stratum_lanes`, `in_order`) and pixels that hold
//!   a tuple as bits (`rows`);
//!   `test_lanes` is the exact test of the latter two, `nomotion_setup` what the first knows of 16 micropolygons at a time.
//!   [`Kernels`] says which are used.
//! - [`buffer`] and [`transparent`] keep what was hit.

pub mod auto;
pub mod boundingbox;
pub mod buffer;
mod cull;
mod discrepancy;
pub mod draw;
pub mod hash;
mod in_order;
pub mod inside;
pub mod interleave;
mod interleave_lanes;
pub mod interval;
mod interval_lanes;
pub mod lens;
pub mod moving;
pub mod nomotion;
mod nomotion_lanes;
mod nomotion_setup;
mod packed;
pub mod pattern;
pub mod rasterizer;
pub mod region;
mod rows;
pub mod shutter;
pub mod simple;
mod sobol;
pub mod strata;
mod stratum_lanes;
mod test_lanes;
pub mod transparent;

pub use buffer::{Payload, Record, SampleBuffer};
pub use draw::{Kernels, Micropolygon, Micropolygons, MovingDraw};
pub use lens::LensShape;
pub use moving::{MovingGrid, TupleTimes};
pub use pattern::{PatternSpec, SamplePattern, SetRule, Tuple};
pub use rasterizer::{Rasterizer, Unsuited};
pub use region::{Region, RegionSamples};
pub use shutter::ShutterShape;
pub use transparent::{TransparentRecord, TransparentRecords};

#[cfg(test)]
mod tests;
