//! Olema, a Reyes renderer.
//!
//! Surfaces are split until they are small, diced into grids of micropolygons about one pixel in size,
//! shaded at their vertices and sampled in screen, lens and time. This crate is the whole renderer:
//! scene description, geometry, the pipeline's stages, sampling, images, and the CPU engine that chains
//! them. It reads no files, prints nothing, reads no clock and holds no global state: progress,
//! cancellation, time and statistics are values passed in and out.
//!
//! Layers, each using only those below it: `engine` -> `pipeline` -> {`geometry`, `sampling`, `image`,
//! `shading`} -> {`scene`, `math`}.

pub mod engine;
pub mod error;
pub mod geometry;
pub mod image;
pub mod math;
pub mod pipeline;
pub mod sampling;
pub mod scene;
pub mod settings;
pub mod shading;
pub mod stats;

pub use engine::{CancelToken, Frame, Hooks, Progress, Renderer};
pub use error::Error;
pub use image::Image;
pub use scene::Scene;
pub use settings::Settings;
pub use stats::Stats;
