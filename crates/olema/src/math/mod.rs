//! Arithmetic that gives the same bits on every machine.

pub mod function;
mod function64;
pub mod hash;
pub mod lanes;
pub mod matrix;
pub mod noise;
pub mod noise_lanes;
mod permute;
mod reduce;
mod scale_pairs;
pub mod simd;
pub mod transform;

use std::ops::Range;

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

/// A part of the vectors of a list.
#[derive(Debug, Clone, Copy)]
pub struct Vec3Slice<'a> {
    /// First components.
    pub x: &'a [f32],
    /// Second components.
    pub y: &'a [f32],
    /// Third components.
    pub z: &'a [f32],
}

impl Vec3Slice<'_> {
    /// Vector `ix` of the part.
    #[inline(always)]
    pub fn get(&self, ix: usize) -> glam::Vec3 {
        glam::Vec3::new(self.x[ix], self.y[ix], self.z[ix])
    }
}

/// A part of the vectors of a list, to write.
#[derive(Debug)]
pub struct Vec3SliceMut<'a> {
    /// First components.
    pub x: &'a mut [f32],
    /// Second components.
    pub y: &'a mut [f32],
    /// Third components.
    pub z: &'a mut [f32],
}

impl Vec3SliceMut<'_> {
    /// Replaces vector `ix` of the part.
    #[inline(always)]
    pub fn set(&mut self, ix: usize, value: glam::Vec3) {
        (self.x[ix], self.y[ix], self.z[ix]) = (value.x, value.y, value.z);
    }
}

impl Vec3s {
    /// Vectors `range`.
    #[inline(always)]
    pub fn slice(&self, range: Range<usize>) -> Vec3Slice<'_> {
        Vec3Slice { x: &self.x[range.clone()], y: &self.y[range.clone()], z: &self.z[range] }
    }

    /// Vectors `range`, to write.
    #[inline(always)]
    pub fn slice_mut(&mut self, range: Range<usize>) -> Vec3SliceMut<'_> {
        Vec3SliceMut { x: &mut self.x[range.clone()], y: &mut self.y[range.clone()], z: &mut self.z[range] }
    }

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

    /// Makes it `len` long, with zeros where it was shorter.
    pub fn resize(&mut self, len: usize) {
        [&mut self.x, &mut self.y, &mut self.z].into_iter().for_each(|all| all.resize(len, 0.0));
    }

    /// Replaces all by vectors `range` of another list.
    pub fn assign(&mut self, from: &Vec3s, range: Range<usize>) {
        for (to, from) in [(&mut self.x, &from.x), (&mut self.y, &from.y), (&mut self.z, &from.z)] {
            to.clear();
            to.extend_from_slice(&from[range.clone()]);
        }
    }

    /// Replaces all by the vectors `picked` of another list.
    pub fn assign_picked(&mut self, from: &Vec3s, picked: &[usize]) {
        for (to, from) in [(&mut self.x, &from.x), (&mut self.y, &from.y), (&mut self.z, &from.z)] {
            to.clear();
            to.extend(picked.iter().map(|&ix| from[ix]));
        }
    }

    /// Replaces each component.
    pub fn each(&mut self, by: impl Fn(f32) -> f32) {
        for all in [&mut self.x, &mut self.y, &mut self.z] {
            all.iter_mut().for_each(|component| *component = by(*component));
        }
    }

    /// Adds each vector of another list of the same length.
    pub fn add(&mut self, other: &Vec3s) {
        for (to, other) in [(&mut self.x, &other.x), (&mut self.y, &other.y), (&mut self.z, &other.z)] {
            to.iter_mut().zip(other).for_each(|(to, other)| *to += other);
        }
    }

    /// Copies vectors `range` of another list to those from `first` on.
    pub fn copy(&mut self, first: usize, from: &Vec3s, range: Range<usize>) {
        let to = first..first + range.len();
        self.x[to.clone()].copy_from_slice(&from.x[range.clone()]);
        self.y[to.clone()].copy_from_slice(&from.y[range.clone()]);
        self.z[to].copy_from_slice(&from.z[range]);
    }

    /// Appends a vector.
    pub fn push(&mut self, value: glam::Vec3) {
        self.x.push(value.x);
        self.y.push(value.y);
        self.z.push(value.z);
    }
}
