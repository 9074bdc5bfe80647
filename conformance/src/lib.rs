//! Scenes, comparisons, goldens and benches shared by the tests of all engines.

pub mod bad_shaders;
pub mod blur;
pub mod closed;
pub mod closed_moving;
pub mod cracks;
pub mod creature;
pub mod goldens;
pub mod kernels;
pub mod moving;
pub mod occlusion_scenes;
pub mod scenes;
pub mod shapes;
pub mod sizes;
pub mod torus;
