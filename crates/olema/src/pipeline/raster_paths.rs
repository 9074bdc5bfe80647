//! Raster paths: places of points over the raster at a time, and how far these are from straight paths, in loops over
//! points.
//!
//! In: points in camera space. Out: [`Places`], and of three of them the greatest distance of a path's middle from the
//! middle of its ends. Twins: [`place`] and [`bend`], point by point.

use glam::Vec3;

use crate::geometry::RasterCamera;
use crate::geometry::camera::GUARD_BAND_PX;
use crate::math::simd::SimdLevel;

use super::camera_points::{STEP, ToCamera};

/// Paths longer than this may be less exact along their direction, in proportion.
const LONG_PX: f32 = 8.0;

/// Raster x and y and the circle of confusion of a point.
pub type Place = [f32; 3];

/// Places of points at a time; numbers that are none where a point is not in front of the near plane.
#[derive(Debug, Default)]
pub struct Places {
    steps: Vec<[[f32; STEP]; 3]>,
    /// Box on the raster that holds them, `[x0, x1, y0, y1]`; all of it where one of them is not in front.
    pub bounds: [f32; 4],
    /// Depths of those in front.
    pub depth: [f32; 2],
}

const NOWHERE: [f32; 4] = [f32::INFINITY, f32::NEG_INFINITY, f32::INFINITY, f32::NEG_INFINITY];
const EVERYWHERE: [f32; 4] = [f32::NEG_INFINITY, f32::INFINITY, f32::NEG_INFINITY, f32::INFINITY];

/// Where a point is, if it is in front of the near plane.
pub fn place(camera: &RasterCamera, p: Vec3) -> Option<Place> {
    let [x, y] = camera.fast_px(p)?;
    Some([x, y, camera.lens.map_or(0.0, |lens| lens.coc_px(p.z))])
}

/// Distance of a place from the middle of those before and after, or the change of its circle of confusion alike.
/// Along a long path it counts for less: the farther something moves, the fainter is what it leaves anywhere.
#[inline(always)]
pub fn bend(from: Place, middle: Place, to: Place) -> f32 {
    let apart = |c: usize| middle[c] - (from[c] + to[c]) * 0.5;
    let (x, y, coc) = (apart(0), apart(1), apart(2).abs());
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let length = (dx * dx + dy * dy).sqrt();
    let (along, across) = ((x * dx + y * dy).abs() / length, (x * dy - y * dx).abs() / length);
    let of_long = greater(across, along * (LONG_PX / length));
    let of_short = (x * x + y * y).sqrt();
    greater(if length > LONG_PX { of_long } else { of_short }, coc)
}

/// `b` unless `a` is above it; no function of the library, which would be a call for each point.
#[inline(always)]
fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

impl Places {
    /// Takes the places of points in camera space.
    pub fn set(&mut self, camera: &RasterCamera, points: impl Iterator<Item = Vec3>) {
        (self.bounds, self.depth) = (NOWHERE, [f32::INFINITY, 0.0]);
        self.steps.clear();
        for (ix, p) in points.enumerate() {
            if ix % STEP == 0 {
                self.steps.push([[f32::NAN; STEP]; 3]);
            }
            let Some(place) = place(camera, p) else {
                self.bounds = EVERYWHERE;
                continue;
            };
            for (axis, value) in place.into_iter().enumerate() {
                self.steps[ix / STEP][axis][ix % STEP] = value;
            }
            let ([x0, x1, y0, y1], [x, y, _]) = (self.bounds, place);
            self.bounds = [x0.min(x), x1.max(x), y0.min(y), y1.max(y)];
            self.depth = [self.depth[0].min(p.z), self.depth[1].max(p.z)];
        }
    }

    /// The same for points of a file.
    pub fn set_all(&mut self, level: SimdLevel, camera: &RasterCamera, points: &ToCamera) {
        (self.bounds, self.depth) = (NOWHERE, [f32::INFINITY, 0.0]);
        self.steps.clear();
        for first in (0..points.len()).step_by(STEP) {
            let num = STEP.min(points.len() - first);
            level.run(
                #[inline(always)]
                || self.add_step(camera, points, first, num),
            );
        }
    }

    // One lane per point.
    #[inline(always)]
    fn add_step(&mut self, camera: &RasterCamera, points: &ToCamera, first: usize, num: usize) {
        let p = points.step(first);
        let mut step = [[f32::NAN; STEP]; 3];
        // x and -x, y and -y, z and -z: the least of each.
        let mut least = [[f32::INFINITY; STEP]; 6];
        let mut is_slow = [false; STEP];
        let (perspective, lens) = (camera.perspective, camera.lens);
        for ix in 0..STEP {
            let [x, y, z] = [p[0][ix] as f32, p[1][ix] as f32, p[2][ix] as f32];
            let inverse = if perspective { 1.0 / z } else { 1.0 };
            let px = x * inverse * camera.scale[0] + camera.center[0];
            let py = camera.center[1] - y * inverse * camera.scale[1];
            let coc = match lens {
                Some(lens) => lens.coc_px(z),
                None => 0.0,
            };
            let in_depth = (z >= camera.near) & (z <= camera.far);
            let is_near = (px.abs() <= GUARD_BAND_PX) & (py.abs() <= GUARD_BAND_PX);
            let is_wide = coc.abs() > GUARD_BAND_PX;
            let is_fast = in_depth & is_near & !is_wide;
            let none = f32::NAN;
            step[0][ix] = if is_fast { px } else { none };
            step[1][ix] = if is_fast { py } else { none };
            step[2][ix] = if is_fast { coc } else { none };
            let counts = is_fast & (ix < num);
            is_slow[ix] = !is_fast & (ix < num);
            let values = [px, -px, py, -py, z, -z];
            for c in 0..6 {
                least[c][ix] = if counts { values[c] } else { f32::INFINITY };
            }
        }
        for values in &mut step {
            values[num..].fill(f32::NAN);
        }
        self.steps.push(step);
        let mut all = [f32::INFINITY; 6];
        for (all, least) in all.iter_mut().zip(&least) {
            for &value in least {
                *all = lesser(value, *all);
            }
        }
        let ([x0, x1, y0, y1], [near, far]) = (self.bounds, self.depth);
        self.bounds = [lesser(all[0], x0), greater(-all[1], x1), lesser(all[2], y0), greater(-all[3], y1)];
        self.depth = [lesser(all[4], near), greater(-all[5], far)];
        if is_slow.iter().any(|&is_slow| is_slow) {
            self.bounds = EVERYWHERE;
        }
    }
}

/// The greatest [`bend`] of points that are no farther than a frame's size from the frame in the middle; 0 without any.
pub fn greatest_bend(level: SimdLevel, camera: &RasterCamera, [from, middle, to]: [&Places; 3]) -> f32 {
    let mut most = [0.0f32; STEP];
    level.run(
        #[inline(always)]
        || {
            for ((from, middle), to) in from.steps.iter().zip(&middle.steps).zip(&to.steps) {
                for ix in 0..STEP {
                    let place = [middle[0][ix], middle[1][ix], middle[2][ix]];
                    let mut matters = true;
                    for c in 0..2 {
                        let (size, coc) = (camera.frame_px[c], place[2].abs());
                        matters &= (place[c] + coc >= -size) & (place[c] - coc <= 2.0 * size);
                    }
                    let bend = bend(
                        [from[0][ix], from[1][ix], from[2][ix]],
                        place,
                        [to[0][ix], to[1][ix], to[2][ix]],
                    );
                    most[ix] = if matters & (bend > most[ix]) { bend } else { most[ix] };
                }
            }
        },
    );
    most.into_iter().fold(0.0, f32::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{hash_all, signed_unit};
    use crate::scene::{Camera, Lens, Projection};
    use glam::{DMat4, DVec3};

    /// Points about a camera, of which some are behind it where `depth` is small, at three times.
    fn points(depth: f32) -> [Vec<[f32; 3]>; 3] {
        [0u32, 1, 2].map(|time| {
            let at = |ix: u32, axis: u32| {
                signed_unit(hash_all([ix, axis])) * 2.0 + signed_unit(hash_all([time, ix, axis])) * 0.3
            };
            (0..37).map(|ix| [at(ix, 0), at(ix, 1), at(ix, 2) + depth]).collect()
        })
    }

    #[test]
    fn loops_have_the_bits_of_single_points_at_every_level() {
        let lens = Some(Lens::new(2.0, 0.5, 3.0));
        let perspective = Projection::Perspective { fov: 60.0 };
        for (depth, lens) in [(4.0, None), (4.0, lens), (1.0, lens)] {
            let camera =
                Camera { projection: perspective, clipping: [0.5, 100.0], lens, ..Camera::default() };
            let camera = RasterCamera::new(&camera, [64, 48]);
            let lists = points(depth);
            let single = lists.each_ref().map(|list| {
                let mut places = Places::default();
                places.set(&camera, list.iter().map(|&p| Vec3::from_array(p)));
                places
            });
            let [from, middle, to] = lists
                .each_ref()
                .map(|list| list.iter().map(|&p| place(&camera, Vec3::from_array(p))).collect::<Vec<_>>());
            let near = |c: usize, [x, y, coc]: Place| {
                let (at, size) = ([x, y][c], camera.frame_px[c]);
                at + coc.abs() >= -size && at - coc.abs() <= 2.0 * size
            };
            let bends = (0..37).filter_map(|ix| {
                let [from, middle, to] = [from[ix]?, middle[ix]?, to[ix]?];
                (near(0, middle) && near(1, middle)).then(|| bend(from, middle, to))
            });
            let expected = bends.fold(0.0, f32::max);
            assert!(expected > 0.1 && (middle.contains(&None)) == (depth < 2.0));
            let matrix = DMat4::from_translation(DVec3::ZERO);
            for level in SimdLevel::all() {
                let all = lists.each_ref().map(|list| {
                    let mut places = Places::default();
                    places.set_all(level, &camera, &ToCamera::new([list, list], None, &matrix));
                    places
                });
                for (found, expected) in all.iter().zip(&single) {
                    assert_eq!((found.bounds, found.depth), (expected.bounds, expected.depth));
                    let bits = |places: &Places| {
                        let floats = places.steps.as_flattened().as_flattened();
                        floats.iter().map(|x| x.to_bits()).collect::<Vec<_>>()
                    };
                    assert_eq!(bits(found), bits(expected), "{}", level.name());
                }
                let found = greatest_bend(level, &camera, all.each_ref());
                assert_eq!(found.to_bits(), expected.to_bits(), "{}", level.name());
            }
        }
    }
}
