//! Vertices onto the raster, in lanes.
//!
//! In: points in camera space. Out: their raster positions and circles of confusion in fixed point, and the box around all
//! of them. Twin: [`RasterCamera::fixed`] and [`RasterCamera::coc`], point by point.

use crate::math::Vec3Slice;
use crate::math::lanes::Lanes;
use crate::math::simd::{LANES, LanesKernel, SimdLevel, each_group};

use super::camera::{GUARD_BAND_PX, RasterCamera, SUBPIXELS};

/// Where points are put; each array as long as there are points.
pub struct OnRaster<'a> {
    /// x in 1/256 pixels.
    pub x: &'a mut [i32],
    /// y, down.
    pub y: &'a mut [i32],
    /// Signed radius of the circle of confusion in 1/256 pixels; left alone without a lens.
    pub coc: &'a mut [i32],
}

/// What holds all points of a list, in 1/256 pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    /// Least and greatest x.
    pub x: [i32; 2],
    /// Least and greatest y.
    pub y: [i32; 2],
    /// Least and greatest signed radius.
    pub coc: [i32; 2],
    /// Nearest depth.
    pub near: f32,
}

impl RasterCamera {
    /// Places a list of points on the raster. `None` if one of them takes the slow path: then nothing that was written
    /// means anything.
    pub fn place_list(&self, level: SimdLevel, p: Vec3Slice, to: OnRaster) -> Option<Reach> {
        level.run_lanes(PlaceKernel { camera: self, p, to })
    }
}

struct PlaceKernel<'a> {
    camera: &'a RasterCamera,
    p: Vec3Slice<'a>,
    to: OnRaster<'a>,
}

impl LanesKernel for PlaceKernel<'_> {
    type Output = Option<Reach>;

    // One lane per point.
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Self::Output {
        let PlaceKernel { camera, p, to } = self;
        let nothing = [lanes.splat(i32::MAX), lanes.splat(i32::MIN)];
        let (mut x, mut y, mut coc) = (nothing, nothing, nothing);
        let mut near = lanes.splat_f(f32::INFINITY);
        let mut fast = lanes.mask(u32::MAX >> (32 - LANES));
        each_group(
            p.x.len(),
            #[inline(always)]
            |group| {
                let (px, py) = (group.load_f(lanes, p.x), group.load_f(lanes, p.y));
                let pz = group.load_f(lanes, p.z);
                let placed = place(lanes, camera, [px, py, pz]);
                fast = lanes.both(fast, placed.is_fast);
                near = lanes.lesser(pz, near);
                (x, y) = (grown(lanes, x, placed.x), grown(lanes, y, placed.y));
                group.store(lanes, placed.x, to.x);
                group.store(lanes, placed.y, to.y);
                if let Some(radius) = placed.coc {
                    coc = grown(lanes, coc, radius);
                    group.store(lanes, radius, to.coc);
                }
            },
        );
        if lanes.bits(lanes.none(fast)) != 0 {
            return None;
        }
        let coc = if camera.lens.is_some() { ends(lanes, coc) } else { [0; 2] };
        Some(Reach { x: ends(lanes, x), y: ends(lanes, y), coc, near: lanes.least_f(near) })
    }
}

/// A range that holds values besides.
#[inline(always)]
fn grown<L: Lanes>(lanes: L, [least, most]: [L::I; 2], values: L::I) -> [L::I; 2] {
    [lanes.min(least, values), lanes.max(most, values)]
}

/// The least and the greatest of a range's lanes.
#[inline(always)]
fn ends<L: Lanes>(lanes: L, [least, most]: [L::I; 2]) -> [i32; 2] {
    [lanes.least(least), lanes.greatest(most)]
}

/// Pixels to 1/256 pixels, to nearest even.
#[inline(always)]
fn to_fixed<L: Lanes>(lanes: L, px: L::F) -> L::I {
    lanes.to_i(lanes.round_f(lanes.mul_f(px, lanes.splat_f(SUBPIXELS as f32))))
}

/// Whether something is within the guard band.
#[inline(always)]
fn is_small<L: Lanes>(lanes: L, px: L::F) -> L::M {
    lanes.le_f(lanes.abs_f(px), lanes.splat_f(GUARD_BAND_PX))
}

/// Points on the raster.
struct Placed<L: Lanes> {
    x: L::I,
    y: L::I,
    coc: Option<L::I>,
    is_fast: L::M,
}

/// [`RasterCamera::fixed`] and [`RasterCamera::coc`], operation by operation.
#[inline(always)]
fn place<L: Lanes>(lanes: L, camera: &RasterCamera, [x, y, z]: [L::F; 3]) -> Placed<L> {
    let one = lanes.splat_f(1.0);
    let inverse = if camera.perspective { lanes.div_f(one, z) } else { one };
    let [scale_x, scale_y] = [lanes.splat_f(camera.scale[0]), lanes.splat_f(camera.scale[1])];
    let [center_x, center_y] = [lanes.splat_f(camera.center[0]), lanes.splat_f(camera.center[1])];
    let px = lanes.add_f(lanes.mul_f(lanes.mul_f(x, inverse), scale_x), center_x);
    let py = lanes.sub_f(center_y, lanes.mul_f(lanes.mul_f(y, inverse), scale_y));
    let (near, far) = (lanes.splat_f(camera.near), lanes.splat_f(camera.far));
    let in_range = lanes.both(lanes.le_f(near, z), lanes.le_f(z, far));
    let mut is_fast = lanes.both(in_range, lanes.both(is_small(lanes, px), is_small(lanes, py)));
    let mut coc = None;
    if let Some(lens) = camera.lens {
        let apart = lanes.sub_f(lanes.splat_f(1.0 / lens.focus), lanes.div_f(one, z));
        let radius = lanes.mul_f(lanes.splat_f(lens.radius), apart);
        is_fast = lanes.both(is_fast, is_small(lanes, radius));
        coc = Some(to_fixed(lanes, radius));
    }
    Placed { x: to_fixed(lanes, px), y: to_fixed(lanes, py), coc, is_fast }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::geometry::camera::RasterLens;
    use crate::math::Vec3s;
    use crate::math::hash::{hash32, signed_unit};
    use crate::scene::{Camera, Projection};

    fn cameras() -> Vec<RasterCamera> {
        let seen = |projection| {
            let camera = Camera { projection, clipping: [0.5, 100.0], ..Camera::default() };
            RasterCamera::new(&camera, [640, 480])
        };
        let plain = seen(Projection::Perspective { fov: 40.0 });
        let lens = Some(RasterLens { radius: 37.0, focus: 5.5 });
        vec![RasterCamera { lens, ..plain.clone() }, plain, seen(Projection::Orthographic)]
    }

    fn points(len: usize) -> Vec3s {
        let random = |n: usize| signed_unit(hash32(n as u32));
        let mut points = Vec3s::default();
        for n in 0..len {
            points.push(Vec3::new(random(3 * n), random(3 * n + 1), 3.0 + random(3 * n + 2)) * 2.0);
        }
        points
    }

    fn place(camera: &RasterCamera, level: SimdLevel, p: &Vec3s) -> (Option<Reach>, [Vec<i32>; 3]) {
        let mut out = [0, 1, 2].map(|_| vec![7; p.len()]);
        let [x, y, coc] = &mut out;
        let reach = camera.place_list(level, p.slice(0..p.len()), OnRaster { x, y, coc });
        (reach, out)
    }

    #[test]
    fn lists_are_the_twin_on_every_level() {
        let range = |values: &[i32]| [*values.iter().min().unwrap(), *values.iter().max().unwrap()];
        for (camera, len) in
            cameras().iter().flat_map(|camera| [1, 5, 15, 16, 17, 40, 64].map(|n| (camera, n)))
        {
            let p = points(len);
            let fixed: Vec<[i32; 2]> = (0..len).map(|ix| camera.fixed(p.get(ix)).unwrap()).collect();
            let x: Vec<i32> = fixed.iter().map(|at| at[0]).collect();
            let y: Vec<i32> = fixed.iter().map(|at| at[1]).collect();
            let coc: Vec<i32> =
                p.z().iter().map(|&z| if camera.lens.is_some() { camera.coc(z) } else { 7 }).collect();
            let near = p.z().iter().copied().fold(f32::INFINITY, f32::min);
            let of_coc = if camera.lens.is_some() { range(&coc) } else { [0; 2] };
            let twin = Reach { x: range(&x), y: range(&y), coc: of_coc, near };
            for level in SimdLevel::all() {
                let (reach, out) = place(camera, level, &p);
                assert_eq!(reach, Some(twin), "{len} {level:?}");
                assert_eq!(out, [x.clone(), y.clone(), coc.clone()], "{len} {level:?}");
            }
        }
    }

    #[test]
    fn a_single_slow_point_is_noticed_wherever_it_stands() {
        let slow = [
            Vec3::new(0.0, 0.0, 0.4),
            Vec3::new(0.0, 0.0, 101.0),
            Vec3::new(1e9, 0.0, 5.0),
            Vec3::new(0.0, f32::NAN, 5.0),
            Vec3::new(0.0, 0.0, f32::NAN),
        ];
        for (camera, slow) in cameras().iter().flat_map(|camera| slow.map(|p| (camera, p))) {
            for (len, at) in [(1, 0), (20, 0), (20, 19), (33, 16)] {
                let mut p = points(len);
                p.set(at, slow);
                for level in SimdLevel::all() {
                    assert_eq!(place(camera, level, &p).0, None, "{slow} {at} {level:?}");
                }
            }
        }
    }
}
