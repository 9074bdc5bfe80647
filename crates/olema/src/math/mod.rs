//! Arithmetic that gives the same bits on every machine.

pub mod function;
mod function64;
pub mod hash;
pub mod lanes;
pub mod matrix;
pub mod noise;
pub mod noise_lanes;
mod reduce;
mod scale_pairs;
pub mod simd;

/// Vectors as a structure of arrays.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Vec3s {
    /// First components.
    pub x: Vec<f32>,
    /// Second components.
    pub y: Vec<f32>,
    /// Third components.
    pub z: Vec<f32>,
}

impl Vec3s {
    /// `len` copies of a vector.
    pub fn splat(value: glam::Vec3, len: usize) -> Self {
        Vec3s { x: vec![value.x; len], y: vec![value.y; len], z: vec![value.z; len] }
    }

    /// None yet, with room for `len`.
    pub fn with_capacity(len: usize) -> Self {
        Vec3s { x: Vec::with_capacity(len), y: Vec::with_capacity(len), z: Vec::with_capacity(len) }
    }

    /// Number of vectors.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Vector `ix`.
    #[inline(always)]
    pub fn get(&self, ix: usize) -> glam::Vec3 {
        glam::Vec3::new(self.x[ix], self.y[ix], self.z[ix])
    }

    /// Replaces vector `ix`.
    #[inline(always)]
    pub fn set(&mut self, ix: usize, value: glam::Vec3) {
        self.x[ix] = value.x;
        self.y[ix] = value.y;
        self.z[ix] = value.z;
    }

    /// Appends a vector.
    pub fn push(&mut self, value: glam::Vec3) {
        self.x.push(value.x);
        self.y.push(value.y);
        self.z.push(value.z);
    }
}
