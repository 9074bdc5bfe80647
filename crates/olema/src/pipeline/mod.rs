//! The stages of the pipeline and the data that passes between them.
//!
//! ```text
//! Primitive -patchify-> Patch -connect-> EdgeTable -bound, split-> Piece -dice-> Grid -shade-> Grid
//!                                                      -sample-> SampleBuffer -resolve-> Image
//! ```
//!
//! A stage takes the data types of its neighbours and never calls another stage; only an engine chains them.
//! Nothing here does I/O, and nothing depends on tiles, buckets or threads.

pub mod areas;
mod bends;
pub mod border;
pub mod bound;
mod by_topology;
mod camera_points;
pub mod clip;
pub mod connect;
pub mod dice;
pub mod displace;
pub mod edges;
pub mod grid;
pub mod key_extent;
pub mod known;
pub mod lattice;
pub mod limit;
pub mod measure;
pub mod motion;
pub mod moving;
pub mod normals;
pub mod patch;
pub mod patchify;
mod paths;
pub mod piece;
pub mod points;
pub mod primvar;
mod raster_paths;
pub mod rate;
pub mod reach;
pub mod recall;
pub mod recent;
pub mod resolve;
pub mod sample;
pub mod shade;
pub mod slots;
pub mod smooth;
pub mod spare;
pub mod split;
mod surface_lists;
pub mod sweep;
pub mod waiting;
pub mod weld;
pub mod workspace;

pub use bound::Bound;
pub use edges::{Edge, EdgeTable, EdgeUse};
pub use grid::{Grid, GridKey};
pub use patch::{Patch, PatchTable, Shape, Surface};
pub use piece::{Piece, PieceKind};
