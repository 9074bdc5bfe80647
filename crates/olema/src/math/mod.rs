//! Arithmetic that gives the same bits on every machine.

pub mod function;
mod function64;
pub mod hash;
pub mod lanes;
pub mod map;
pub mod matrix;
pub mod noise;
pub mod noise_lanes;
mod permute;
pub(crate) mod reduce;
mod scale_pairs;
pub mod simd;
pub mod transform;

use std::ops::Range;

use simd::{LANES, SimdLevel};

/// Vectors as a structure of arrays, in one piece of memory: grids hold a dozen such lists, and many live at a time.
#[derive(Debug, Clone, Default)]
pub struct Vec3s {
    /// First components, then second, then third, each from a multiple of [`Self::room`] on.
    floats: Vec<f32>,
    /// How many vectors there are room for: whole groups of [`LANES`].
    room: usize,
    len: usize,
}

impl PartialEq for Vec3s {
    fn eq(&self, other: &Self) -> bool {
        self.axes() == other.axes()
    }
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
    /// Vector `ix` of the part.
    #[inline(always)]
    pub fn get(&self, ix: usize) -> glam::Vec3 {
        glam::Vec3::new(self.x[ix], self.y[ix], self.z[ix])
    }

    /// Replaces vector `ix` of the part.
    #[inline(always)]
    pub fn set(&mut self, ix: usize, value: glam::Vec3) {
        (self.x[ix], self.y[ix], self.z[ix]) = (value.x, value.y, value.z);
    }
}

impl Vec3s {
    /// First components.
    #[inline(always)]
    pub fn x(&self) -> &[f32] {
        &self.floats[..self.len]
    }

    /// Second components.
    #[inline(always)]
    pub fn y(&self) -> &[f32] {
        &self.floats[self.room..self.room + self.len]
    }

    /// Third components.
    #[inline(always)]
    pub fn z(&self) -> &[f32] {
        &self.floats[2 * self.room..2 * self.room + self.len]
    }

    /// First, second and third components.
    #[inline(always)]
    pub fn axes(&self) -> [&[f32]; 3] {
        [self.x(), self.y(), self.z()]
    }

    /// First, second and third components, to write.
    #[inline(always)]
    pub fn axes_mut(&mut self) -> [&mut [f32]; 3] {
        let (x, rest) = self.floats.split_at_mut(self.room);
        let (y, z) = rest.split_at_mut(self.room);
        [&mut x[..self.len], &mut y[..self.len], &mut z[..self.len]]
    }

    /// [`Self::axes`] as whole groups of [`LANES`]: what stands behind the last vector means nothing. Kernels that go
    /// through all of it have no rest to copy.
    #[inline(always)]
    pub fn groups(&self) -> [&[f32]; 3] {
        let (room, len) = (self.room, self.len.next_multiple_of(LANES));
        [0, 1, 2].map(
            #[inline(always)]
            |axis| &self.floats[axis * room..axis * room + len],
        )
    }

    /// [`Self::groups`], to write.
    #[inline(always)]
    pub fn groups_mut(&mut self) -> [&mut [f32]; 3] {
        let len = self.len.next_multiple_of(LANES);
        let (x, rest) = self.floats.split_at_mut(self.room);
        let (y, z) = rest.split_at_mut(self.room);
        [&mut x[..len], &mut y[..len], &mut z[..len]]
    }

    /// Vectors `range`.
    #[inline(always)]
    pub fn slice(&self, range: Range<usize>) -> Vec3Slice<'_> {
        let [x, y, z] = self.axes();
        Vec3Slice { x: &x[range.clone()], y: &y[range.clone()], z: &z[range] }
    }

    /// Vectors `range`, to write.
    #[inline(always)]
    pub fn slice_mut(&mut self, range: Range<usize>) -> Vec3SliceMut<'_> {
        let [x, y, z] = self.axes_mut();
        Vec3SliceMut { x: &mut x[range.clone()], y: &mut y[range.clone()], z: &mut z[range] }
    }

    /// `len` copies of a vector.
    pub fn splat(value: glam::Vec3, len: usize) -> Self {
        let mut all = Vec3s::with_capacity(len);
        all.len = len;
        for (axis, component) in all.axes_mut().into_iter().zip(value.to_array()) {
            axis.fill(component);
        }
        all
    }

    /// From components, all as many.
    pub fn from_axes(axes: [&[f32]; 3]) -> Self {
        debug_assert!(axes.iter().all(|axis| axis.len() == axes[0].len()), "as many of each");
        let mut all = Vec3s::with_capacity(axes[0].len());
        all.len = axes[0].len();
        for (to, from) in all.axes_mut().into_iter().zip(axes) {
            to.copy_from_slice(from);
        }
        all
    }

    /// None yet, with room for `len`.
    pub fn with_capacity(len: usize) -> Self {
        let room = len.next_multiple_of(LANES);
        Vec3s { floats: vec![0.0; 3 * room], room, len: 0 }
    }

    /// Bytes that they take, with those there is room for.
    pub fn bytes(&self) -> usize {
        4 * self.floats.capacity()
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Number of vectors.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Vector `ix`.
    #[inline(always)]
    pub fn get(&self, ix: usize) -> glam::Vec3 {
        glam::Vec3::new(self.x()[ix], self.y()[ix], self.z()[ix])
    }

    /// Replaces vector `ix`.
    #[inline(always)]
    pub fn set(&mut self, ix: usize, value: glam::Vec3) {
        assert!(ix < self.len, "it has to be there");
        self.floats[ix] = value.x;
        self.floats[self.room + ix] = value.y;
        self.floats[2 * self.room + ix] = value.z;
    }

    /// Forgets all, and makes room for `room`.
    fn renew(&mut self, room: usize) {
        self.len = 0;
        if self.room < room {
            self.room = room.next_multiple_of(LANES);
            self.floats.clear();
            self.floats.resize(3 * self.room, 0.0);
        }
    }

    /// Makes room for `room` and keeps what there is.
    fn grow(&mut self, room: usize) {
        if self.room >= room {
            return;
        }
        let room = room.max(2 * self.room).next_multiple_of(LANES);
        let mut floats = vec![0.0; 3 * room];
        for (to, from) in floats.chunks_exact_mut(room).zip(self.axes()) {
            to[..from.len()].copy_from_slice(from);
        }
        (self.floats, self.room) = (floats, room);
    }

    /// Makes it `len` long, with zeros where it was shorter.
    pub fn resize(&mut self, len: usize) {
        self.grow(len);
        let before = self.len.min(len);
        self.len = len;
        self.axes_mut().into_iter().for_each(|all| all[before..].fill(0.0));
    }

    /// Makes it `len` long, with anything in it.
    pub fn set_len(&mut self, len: usize) {
        self.grow(len);
        self.len = len;
    }

    /// Makes it at least `len` long.
    pub fn make_room(&mut self, len: usize) {
        if self.len < len {
            self.resize(len);
        }
    }

    /// Appends vectors `range` of another list.
    pub fn append(&mut self, from: &Vec3s, range: Range<usize>) {
        let before = self.len;
        self.grow(before + range.len());
        self.len += range.len();
        for (to, from) in self.axes_mut().into_iter().zip(from.axes()) {
            to[before..].copy_from_slice(&from[range.clone()]);
        }
    }

    /// Replaces all by vectors `range` of another list.
    pub fn assign(&mut self, from: &Vec3s, range: Range<usize>) {
        self.renew(range.len());
        self.append(from, range);
    }

    /// Vectors `range`, on their own.
    pub fn copied(&self, range: Range<usize>) -> Self {
        let Vec3Slice { x, y, z } = self.slice(range);
        Vec3s::from_axes([x, y, z])
    }

    /// Replaces all by the vectors `picked` of another list.
    pub fn assign_picked(&mut self, from: &Vec3s, picked: &[usize]) {
        self.renew(picked.len());
        self.len = picked.len();
        for (to, from) in self.axes_mut().into_iter().zip(from.axes()) {
            to.iter_mut().zip(picked).for_each(|(to, &ix)| *to = from[ix]);
        }
    }

    /// Replaces each component.
    pub fn each(&mut self, by: impl Fn(f32) -> f32) {
        for all in self.axes_mut() {
            all.iter_mut().for_each(|component| *component = by(*component));
        }
    }

    /// Adds each vector of another list of the same length.
    pub fn add(&mut self, level: SimdLevel, other: &Vec3s) {
        level.run(
            #[inline(always)]
            || {
                for (to, other) in self.groups_mut().into_iter().zip(other.groups()) {
                    to.iter_mut().zip(other).for_each(
                        #[inline(always)]
                        |(to, other)| *to += other,
                    );
                }
            },
        );
    }

    /// Copies vectors `range` of another list to those from `first` on.
    pub fn copy(&mut self, first: usize, from: &Vec3s, range: Range<usize>) {
        for (to, from) in self.axes_mut().into_iter().zip(from.axes()) {
            to[first..first + range.len()].copy_from_slice(&from[range.clone()]);
        }
    }

    /// Appends a vector.
    pub fn push(&mut self, value: glam::Vec3) {
        self.grow(self.len + 1);
        self.len += 1;
        self.set(self.len - 1, value);
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn lists_grow_and_shrink_and_keep_what_they_hold() {
        let vector = |n: usize| Vec3::new(n as f32, n as f32 + 0.25, -(n as f32));
        let mut list = Vec3s::default();
        (0..37).for_each(|n| list.push(vector(n)));
        list.resize(20);
        list.resize(90);
        let expected = |ix: usize| if ix < 20 { vector(ix) } else { Vec3::ZERO };
        assert!((0..90).all(|ix| list.get(ix) == expected(ix)));
        let mut other = Vec3s::splat(Vec3::ONE, 3);
        other.append(&list, 4..9);
        assert_eq!(
            (other.len(), other.get(2), other.get(3), other.get(7)),
            (8, Vec3::ONE, vector(4), vector(8))
        );
        other.assign(&list, 1..3);
        assert_eq!(other, list.copied(1..3));
        other.assign_picked(&list, &[7, 2, 7]);
        assert_eq!(other.axes(), [&[7.0, 2.0, 7.0][..], &[7.25, 2.25, 7.25], &[-7.0, -2.0, -7.0]]);
        other.copy(1, &list, 10..12);
        assert_eq!((other.get(0), other.get(2)), (vector(7), vector(11)));
        other.add(SimdLevel::best(), &list.copied(0..3));
        assert_eq!(other.get(2), vector(11) + vector(2));
        assert_ne!(other, list);
    }
}
