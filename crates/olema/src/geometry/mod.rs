//! Surfaces that can be evaluated at (u, v) and bounded over a part of their domain.

pub mod bezier;
pub mod camera;
pub mod hull;
pub mod lanes;
pub mod place_lanes;
pub mod subdivision;

pub use bezier::{Bicubic, SurfacePoint};
pub use camera::RasterCamera;

use glam::Vec3;

/// An axis-aligned box; empty where a minimum exceeds its maximum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aabb {
    /// Smallest coordinates.
    pub min: Vec3,
    /// Largest coordinates.
    pub max: Vec3,
}

impl Aabb {
    /// Holds nothing.
    pub const EMPTY: Aabb = Aabb { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// Grows to hold `p`.
    pub fn include(&mut self, p: Vec3) {
        self.min = self.min.min(p);
        self.max = self.max.max(p);
    }

    /// Length of the diagonal; 0 where empty.
    pub fn diagonal(&self) -> f32 {
        if self.min.x > self.max.x { 0.0 } else { (self.max - self.min).length() }
    }
}
