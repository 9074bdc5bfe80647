//! Bound: where on the raster, how deep, and when a piece can be.
//!
//! In: `Piece`. Out: `Bound`, or the reason why nothing of it can be seen. The control points of the part of the
//! patch under the piece's (u, v) box are a hull of it; grown where a welded neighbour's border may differ, by
//! displacement, and by the largest circle of confusion at its depths. Each key has a box of its own: between two
//! keys a vertex moves on a straight line at constant speed, and so do the sides of the box that holds it.

use glam::Vec3;

use crate::geometry::RasterCamera;
use crate::geometry::hull::Hull;
use crate::math::lanes::Lanes;
use crate::math::simd::{LanesKernel, SimdLevel};
use crate::sampling::Region;

use super::key_extent::{KeyExtent, sweep};
use super::piece::{Piece, uv_box};
use super::split::SplitContext;
use super::sweep::{Sweep, grown, to_pixels};

/// Where a piece can be.
#[derive(Debug, Clone, PartialEq)]
pub struct Bound {
    /// Nearest depth.
    pub near: f32,
    /// At how many of its keys it reaches in front of the near plane, out of how many.
    pub at_eye: [u32; 2],
    /// When it can be where.
    pub sweep: Sweep,
}

impl Bound {
    /// Whether it is the same whatever region was asked for.
    pub fn is_for_all_regions(&self) -> bool {
        self.at_eye[0] == 0
    }

    /// Its largest width and height at any one time and in focus, in pixels; those of what of the region it can reach,
    /// where it passes the near plane.
    pub fn size_px(&self, region: &Region) -> [f32; 2] {
        if self.at_eye[0] == 0 {
            return self.sweep.size();
        }
        let (Region { x0, x1, y0, y1 }, whole) = (*region, to_pixels(self.sweep.whole()));
        let within = [whole[0].max(x0), whole[1].min(x1 - 1), whole[2].max(y0), whole[3].min(y1 - 1)];
        [within[1] - within[0], within[3] - within[2]].map(|size| size as f32)
    }
}

/// Why a piece cannot be seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unseen {
    /// In front of the near or beyond the far plane.
    Depth,
    /// Beside the frame.
    Frustum,
}

/// Bounds `piece`, or says why no sample of `region` (the pixels whose samples matter: the crop or tile, grown
/// by the filter) can see it.
///
/// # Errors
/// The cause, for the statistics.
pub fn bound(context: &SplitContext, piece: &Piece, region: &Region) -> Result<Bound, Unseen> {
    let patch = &context.patches.patches[piece.patch as usize];
    let (u, v) = uv_box(piece);
    let key_times = &context.patches.times.sets[patch.motion as usize];
    let mut hulls = context.hulls.borrow_mut();
    let Hulls { of_keys, keys } = &mut *hulls;
    of_keys.clear();
    context.surfaces.hulls(piece.patch, key_times.len(), u, v, of_keys);
    keys.clear();
    let reach = reach(context.surfaces.level, context.camera, region, of_keys, keys);
    let rounding = ROUNDING * reach.greatest;
    let view = View { camera: context.camera, region };
    let apart = patch.slack + rounding;
    view.finish(&reach, keys, key_times, apart + context.reach(piece, of_keys, apart))
}

/// Rounding of an evaluated point, relative to the largest coordinate around it.
const ROUNDING: f32 = 2e-6;

/// Lists to bound with; used again for every piece.
#[derive(Debug, Default)]
pub struct Hulls {
    /// Control points at each key.
    of_keys: Vec<Hull>,
    /// Where they are.
    keys: Vec<KeyExtent>,
}

/// What holds points at all keys.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Reach {
    depth: [f32; 2],
    /// Largest coordinate.
    greatest: f32,
    /// Largest signed distance to the planes through the region's left, right, top and bottom border, in
    /// pixels times depth, positive inside: all points negative means outside, in front of the eye or behind.
    inside: [f32; 4],
}

/// Finds where control points are, at each key and at all of them.
fn reach(
    level: SimdLevel,
    camera: &RasterCamera,
    region: &Region,
    hulls: &[Hull],
    keys: &mut Vec<KeyExtent>,
) -> Reach {
    level.run_lanes(ReachKernel { camera, region, hulls, keys })
}

struct ReachKernel<'a> {
    camera: &'a RasterCamera,
    region: &'a Region,
    hulls: &'a [Hull],
    keys: &'a mut Vec<KeyExtent>,
}

impl LanesKernel for ReachKernel<'_> {
    type Output = Reach;

    // One lane per control point.
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Reach {
        let ReachKernel { camera, region, hulls, keys } = self;
        let (least, most) = (lanes.splat_f(f32::INFINITY), lanes.splat_f(f32::NEG_INFINITY));
        let (mut depth, mut greatest, mut inside) = ([least, most], lanes.splat_f(0.0), [most; 4]);
        let Region { x0, x1, y0, y1 } = *region;
        let borders = [
            lanes.splat_f((x0 - 1) as f32),
            lanes.splat_f((x1 + 1) as f32),
            lanes.splat_f((y0 - 1) as f32),
            lanes.splat_f((y1 + 1) as f32),
        ];
        let (scale_x, scale_y) = (lanes.splat_f(camera.scale[0]), lanes.splat_f(camera.scale[1]));
        let (center_x, center_y) = (lanes.splat_f(camera.center[0]), lanes.splat_f(camera.center[1]));
        let one = lanes.splat_f(1.0);
        for hull in hulls {
            let [x, y, z] = &hull.points;
            let (x, y, z) = (lanes.load_f(x, 0), lanes.load_f(y, 0), lanes.load_f(z, 0));
            depth = [lanes.lesser(z, depth[0]), lanes.greater(z, depth[1])];
            for at in [x, y, z] {
                greatest = lanes.greater(lanes.abs_f(at), greatest);
            }
            // Distances to the region's borders.
            let w = if camera.perspective { z } else { one };
            let along_x = lanes.add_f(lanes.mul_f(x, scale_x), lanes.mul_f(w, center_x));
            let along_y = lanes.sub_f(lanes.mul_f(w, center_y), lanes.mul_f(y, scale_y));
            let apart = [
                lanes.sub_f(along_x, lanes.mul_f(w, borders[0])),
                lanes.sub_f(lanes.mul_f(w, borders[1]), along_x),
                lanes.sub_f(along_y, lanes.mul_f(w, borders[2])),
                lanes.sub_f(lanes.mul_f(w, borders[3]), along_y),
            ];
            for side in 0..4 {
                inside[side] = lanes.greater(apart[side], inside[side]);
            }
            // What is in front of the near plane has a place on the raster.
            let inverse = if camera.perspective { lanes.div_f(one, z) } else { one };
            let px = lanes.add_f(lanes.mul_f(lanes.mul_f(x, inverse), scale_x), center_x);
            let py = lanes.sub_f(center_y, lanes.mul_f(lanes.mul_f(y, inverse), scale_y));
            let is_seen = lanes.le_f(lanes.splat_f(camera.near), z);
            let (x_seen, y_seen) = (ends(lanes, px, is_seen), ends(lanes, py, is_seen));
            keys.push(KeyExtent {
                least: Vec3::new(lanes.least_f(x), lanes.least_f(y), lanes.least_f(z)),
                most: Vec3::new(lanes.greatest_f(x), lanes.greatest_f(y), lanes.greatest_f(z)),
                raster: [x_seen[0], x_seen[1], y_seen[0], y_seen[1]],
            });
        }
        Reach {
            depth: [lanes.least_f(depth[0]), lanes.greatest_f(depth[1])],
            greatest: lanes.greatest_f(greatest),
            inside: [
                lanes.greatest_f(inside[0]),
                lanes.greatest_f(inside[1]),
                lanes.greatest_f(inside[2]),
                lanes.greatest_f(inside[3]),
            ],
        }
    }
}

/// Least and greatest of the values that are `counted`; infinite where none is.
#[inline(always)]
fn ends<L: Lanes>(lanes: L, values: L::F, counted: L::M) -> [f32; 2] {
    let (least, most) = (lanes.splat_f(f32::INFINITY), lanes.splat_f(f32::NEG_INFINITY));
    let (low, high) = (lanes.select_f(counted, values, least), lanes.select_f(counted, values, most));
    [lanes.least_f(lanes.lesser(low, least)), lanes.greatest_f(lanes.greater(high, most))]
}

/// What is looked at, from where.
struct View<'a> {
    camera: &'a RasterCamera,
    region: &'a Region,
}

impl View<'_> {
    /// What the lens adds to distances to the region's borders, in pixels times depth: the circle of confusion times
    /// the depth is linear in the depth.
    fn lens_slack(&self, depth: [f32; 2]) -> f32 {
        let of =
            |z: f32, lens: crate::geometry::camera::RasterLens| lens.radius * (z / lens.focus - 1.0).abs();
        self.camera.lens.map_or(0.0, |lens| of(depth[0], lens).max(of(depth[1], lens)))
    }

    fn finish(
        &self,
        held: &Reach,
        keys: &mut [KeyExtent],
        key_times: &[f32],
        slack: f32,
    ) -> Result<Bound, Unseen> {
        let depth = [held.depth[0] - slack, held.depth[1] + slack];
        if depth[1] < self.camera.near || depth[0] > self.camera.far {
            return Err(Unseen::Depth);
        }
        let slack_px = slack * self.camera.scale[0].abs().max(self.camera.scale[1].abs());
        let reach = slack_px + self.lens_slack(depth);
        if held.inside.iter().any(|&inside| inside < -reach) {
            return Err(Unseen::Frustum);
        }
        let grow =
            0.01 + if self.camera.perspective { slack_px / depth[0].max(self.camera.near) } else { slack_px };
        for key in keys.iter_mut() {
            (key.least, key.most) = (key.least - slack, key.most + slack);
            key.raster = grown(key.raster, grow);
        }
        // What passes the near plane is bounded by its box in camera space, which holds the slack already.
        let sweep = sweep(self.camera, keys, key_times, 0.01);
        let Region { x0, x1, y0, y1 } = *self.region;
        let whole = to_pixels(sweep.whole());
        if whole[0] >= x1 || whole[1] < x0 || whole[2] >= y1 || whole[3] < y0 {
            return Err(Unseen::Frustum);
        }
        sweep.meets_region(self.region).ok_or(Unseen::Frustum)?;
        let num_at_eye = keys.iter().filter(|key| key.least.z < self.camera.near).count();
        let at_eye = [num_at_eye as u32, keys.len() as u32];
        Ok(Bound { near: depth[0], at_eye, sweep })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{hash32, signed_unit};
    use crate::scene::{Camera, Projection};

    #[test]
    fn what_holds_control_points_is_the_same_point_by_point() {
        let region = Region::new(-3, 61, 20, 90);
        for projection in [Projection::Perspective { fov: 50.0 }, Projection::Orthographic] {
            let camera = Camera { projection, clipping: [2.0, f32::INFINITY], ..Camera::default() };
            let camera = RasterCamera::new(&camera, [640, 480]);
            // Some of them in front of the near plane.
            let point =
                |n: u32| Vec3::from([0, 1, 2].map(|a| signed_unit(hash32(3 * n + a)))) * 2.0 + Vec3::Z * 2.5;
            let points: Vec<[Vec3; 16]> =
                (0..3).map(|key| std::array::from_fn(|ix| point(16 * key + ix as u32))).collect();
            let hulls: Vec<Hull> = points.iter().map(|points| Hull::of(*points)).collect();
            let (mut depth, mut greatest) = ([f32::INFINITY, f32::NEG_INFINITY], 0.0f32);
            let mut inside = [f32::NEG_INFINITY; 4];
            for p in points.iter().flatten() {
                depth = [depth[0].min(p.z), depth[1].max(p.z)];
                greatest = greatest.max(p.abs().max_element());
                let w = if camera.perspective { p.z } else { 1.0 };
                let x = p.x * camera.scale[0] + w * camera.center[0];
                let y = w * camera.center[1] - p.y * camera.scale[1];
                let apart = [x - w * -4.0, w * 62.0 - x, y - w * 19.0, w * 91.0 - y];
                (0..4).for_each(|side| inside[side] = inside[side].max(apart[side]));
            }
            for level in SimdLevel::all() {
                let mut keys = Vec::new();
                let found = reach(level, &camera, &region, &hulls, &mut keys);
                assert_eq!(found, Reach { depth, greatest, inside }, "{level:?}");
                for (key, points) in keys.iter().zip(&points) {
                    let mut twin = KeyExtent::EMPTY;
                    points.iter().for_each(|&p| twin.include(&camera, p));
                    assert_eq!((key.least, key.most, key.raster), (twin.least, twin.most, twin.raster));
                }
            }
        }
    }
}
