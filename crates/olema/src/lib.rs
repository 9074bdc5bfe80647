//! Olema, a Reyes renderer.
//!
//! Surfaces are split until they are small, diced into grids of micropolygons about one pixel in size,
//! shaded at their vertices and sampled in screen, lens and time. This crate is the whole renderer:
//! scene description, geometry, the pipeline's stages, sampling, images, and the CPU engine that chains
//! them. It reads no files, prints nothing, reads no clock and holds no global state: progress,
//! cancellation, time and statistics are values passed in and out.
//!
//! # A picture
//! ```
//! use std::sync::Arc;
//!
//! use olema::scene::{
//!     Attributes, Camera, Geometry, Keyed, Light, Origin, PatchKind, PatchMesh, Points, Primitive, Transform,
//! };
//! use olema::{Hooks, Renderer, Scene, Settings, shading};
//!
//! # fn main() -> Result<(), olema::Error> {
//! // The default camera is orthographic, at the origin, looking along z; x and y span about -1 to 1.
//! let mut scene = Scene::new(Camera::default());
//! let sun = scene.add_light(Light {
//!     shader: shading::light("distantlight", &[])?.shader,
//!     to_world: Transform::default(),
//! });
//! let square = PatchMesh {
//!     kind: Arc::new(PatchKind::Bilinear),
//!     nu: 2,
//!     nv: 2,
//!     wrap_u: false,
//!     wrap_v: false,
//!     points: Keyed::still(Points::P(vec![
//!         [-0.5, -0.5, 5.0],
//!         [0.5, -0.5, 5.0],
//!         [-0.5, 0.5, 5.0],
//!         [0.5, 0.5, 5.0],
//!     ])),
//!     vars: Vec::new(),
//! };
//! scene.primitives.push(Primitive {
//!     geometry: Geometry::Patches(Arc::new(square)),
//!     to_world: Transform::default(),
//!     attributes: Arc::new(Attributes {
//!         color: [1.0, 0.5, 0.0],
//!         surface: shading::surface("matte", &[])?.shader,
//!         lights: Arc::from([sun]),
//!         ..Attributes::default()
//!     }),
//!     origin: Origin::default(),
//! });
//! let settings = Settings { resolution: [40, 30], ..Settings::default() };
//! let frame = Renderer::new(settings)?.render(&scene, &Hooks::default())?;
//! let red = frame.image.channel("r").expect("pictures have r, g, b, a and z");
//! assert_eq!(red.values.len(), 40 * 30);
//! assert!(red.values[15 * 40 + 20] > 0.9 && red.values[0] == 0.0);
//! assert_eq!(frame.stats.patches, 1);
//! # Ok(())
//! # }
//! ```
//!
//! Layers, each using only those below it: `engine` -> `pipeline` -> {`geometry`, `sampling`, `image`,
//! `shading`} -> {`scene`, `math`}.

pub mod engine;
pub mod error;
pub mod geometry;
pub mod image;
pub mod math;
pub mod occlusion;
pub mod pipeline;
pub mod sampling;
pub mod scene;
pub mod settings;
pub mod shading;
pub mod standard;
pub mod stats;

pub use engine::{CancelToken, Frame, Hooks, Progress, Renderer};
pub use error::Error;
pub use image::Image;
pub use scene::Scene;
pub use settings::Settings;
pub use stats::Stats;
