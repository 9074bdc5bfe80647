//! Camera points: control points at a time, from object to camera space, in loops over points.
//!
//! In: points of a file at two keys, and a matrix. Out: their components in double, [`STEP`] points at a time. Twin:
//! [`blend_point`](super::motion::blend_point) and the matrix, point by point, which homogeneous points take.

use glam::DMat4;

use crate::scene::{Between, Keyed, Points};

/// Points that are placed at a time.
pub const STEP: usize = 16;

/// Points of a file, as many at both keys, on their way to camera space at a time.
#[derive(Debug, Clone, Copy)]
pub struct ToCamera<'a> {
    keys: [&'a [[f32; 3]]; 2],
    /// Part of the way from the first to the second; `None` where they are at the first.
    part: Option<f64>,
    /// Columns of the matrix.
    matrix: [f64; 16],
}

impl<'a> ToCamera<'a> {
    /// The points of a sheet; `None` for homogeneous ones.
    pub fn of_sheet(points: &'a Keyed<Points>, between: &Between, to_camera: &DMat4) -> Option<Self> {
        let [from, to] = between.keys.map(|key| &points.values[key]);
        let (Points::P(from), Points::P(to)) = (from, to) else { return None };
        Some(ToCamera::new([from, to], Some(between.part).filter(|&part| part != 0.0), to_camera))
    }

    /// As many points as there are at both keys.
    pub fn new([from, to]: [&'a [[f32; 3]]; 2], part: Option<f64>, to_camera: &DMat4) -> Self {
        let len = from.len().min(to.len());
        ToCamera { keys: [&from[..len], &to[..len]], part, matrix: to_camera.to_cols_array() }
    }

    /// How many points there are.
    pub fn len(&self) -> usize {
        self.keys[0].len()
    }

    /// Of each `stride` points the first, in other lists.
    pub fn picked<'b>(&self, stride: usize, lists: &'b mut [Vec<[f32; 3]>; 2]) -> ToCamera<'b> {
        for (list, key) in lists.iter_mut().zip(self.keys) {
            list.clear();
            list.extend(key.iter().step_by(stride));
        }
        let [from, to] = lists;
        ToCamera { keys: [from, to], part: self.part, matrix: self.matrix }
    }

    /// Components of points `first..first + STEP`; of any value beyond the end.
    #[inline(always)]
    pub fn step(&self, first: usize) -> [[f64; STEP]; 3] {
        let mut p = load(self.keys[0], first);
        if let Some(part) = self.part {
            let to = load(self.keys[1], first);
            for (p, to) in p.iter_mut().zip(&to) {
                for (p, to) in p.iter_mut().zip(to) {
                    *p += (to - *p) * part;
                }
            }
        }
        let ([x, y, z], m) = (&p, &self.matrix);
        let mut placed = [[0.0; STEP]; 3];
        for (axis, placed) in placed.iter_mut().enumerate() {
            for (ix, placed) in placed.iter_mut().enumerate() {
                *placed = m[axis] * x[ix] + m[4 + axis] * y[ix] + m[8 + axis] * z[ix] + m[12 + axis];
            }
        }
        placed
    }
}

/// Components of points from `first` on; zeros beyond the end.
#[inline(always)]
fn load(points: &[[f32; 3]], first: usize) -> [[f64; STEP]; 3] {
    let rest = &points[first..];
    let mut padded = [[0.0; 3]; STEP];
    let points: &[[f32; 3]; STEP] = match rest.first_chunk() {
        Some(all) => all,
        None => {
            padded[..rest.len()].copy_from_slice(rest);
            &padded
        }
    };
    let mut axes = [[0.0; STEP]; 3];
    for (ix, point) in points.iter().enumerate() {
        for axis in 0..3 {
            axes[axis][ix] = f64::from(point[axis]);
        }
    }
    axes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{hash_all, signed_unit};
    use crate::math::simd::SimdLevel;
    use crate::pipeline::motion::blend_point;

    #[test]
    fn steps_have_the_bits_of_single_points_at_every_level() {
        let of_key = |key: u32| {
            let point = |ix: u32| [0, 1, 2].map(|axis| signed_unit(hash_all([key, ix, axis])) * 7.0);
            Points::P((0..37).map(point).collect())
        };
        let points = Keyed { times: vec![0.0, 1.0], values: vec![of_key(0), of_key(1)] };
        let to_camera =
            DMat4::from_cols_array(&std::array::from_fn(|ix| f64::from(signed_unit(hash_all([ix as u32])))));
        for (part, level) in
            [0.0, 0.3].into_iter().flat_map(|part| SimdLevel::all().into_iter().map(move |l| (part, l)))
        {
            let between = Between { keys: [0, 1], part };
            let all = ToCamera::of_sheet(&points, &between, &to_camera).expect("not homogeneous");
            assert_eq!(all.len(), 37);
            for first in (0..37).step_by(STEP) {
                let step = level.run(
                    #[inline(always)]
                    || all.step(first),
                );
                for ix in first..37.min(first + STEP) {
                    let expected = to_camera.transform_point3(blend_point(&points, &between, ix).truncate());
                    let found = step.map(|axis| axis[ix - first]);
                    assert_eq!(found.map(f64::to_bits), expected.to_array().map(f64::to_bits), "{ix}");
                }
            }
        }
    }
}
