//! Occlusion: what lies behind everything that a tile has drawn so far, at all times and lens places at once.
//!
//! In: the records of a tile's [`SampleBuffer`](crate::sampling::SampleBuffer), and bounds of sub-patches per
//! range of time and lens. Out: whether a sub-patch is hidden for sure. Source: Boulos 2010, sections 3.2.1
//! (update) and 3.2.2 (query).
//!
//! - [`settings`] is what the user may choose.
//! - [`slices`] sorts a pattern's tuples into a tree of time, or of the lens. It is built once a frame.
//! - [`pyramid`] is the hierarchy over a region's samples: farthest kept depth by space and slice, computed where
//!   and when a query reads it.
//! - [`query`] asks it.
//! - [`occluders`] holds the one or two pyramids of a tile and picks the one that helps.
//!
//! What is said to be hidden has no sample at which it would win or tie; so culling changes no bit of a
//! picture. A pyramid that was not told of a write only knows less: its depths are too far, never too near.
//!
//! ```text
//! frame:  plan = CullPlan::new(settings, pattern, blur)
//! thread: occluders = Occluders::new(&plan)
//! tile:   occluders.renew(&samples)
//!         for each piece, nearest first:
//!             occluders.is_occluded(&samples, &mut nearest, |range| bounds of the piece, &mut reads) -> drop
//!             (draw its grid into nearest)
//!             occluders.drew(raster box of the grid in pixels)
//! ```

mod leaf;
mod leaf_lanes;
pub mod occluders;
pub mod pyramid;
pub mod query;
pub mod settings;
pub mod slices;
mod written;

pub use occluders::{Blurred, CullPlan, Occluders};
pub use pyramid::{Drawn, TzPyramid};
pub use query::{Bounds, DepthReads};
pub use settings::{CullKind, CullOrder, CullPlaces, CullSettings};
pub use slices::{SliceOrder, Slices};

#[cfg(test)]
mod tests;
