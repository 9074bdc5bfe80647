//! Bound: where on the raster, how deep, and when a piece can be.
//!
//! In: `Piece`. Out: `Bound`, or the reason why nothing of it can be seen. The control points of the part of the
//! patch under the piece's (u, v) box are a hull of it; grown where a welded neighbour's border may differ, by
//! displacement, and by the largest circle of confusion at its depths. Each key has a box of its own: between two
//! keys a vertex moves on a straight line at constant speed, and so do the sides of the box that holds it.

use glam::Vec3;

use crate::geometry::RasterCamera;
use crate::sampling::Region;

use super::piece::{Piece, uv_box};
use super::split::SplitContext;
use super::sweep::{KeyExtent, Sweep, TimeRange, grown, sweep, to_pixels};

/// Where a piece can be.
#[derive(Debug, Clone, PartialEq)]
pub struct Bound {
    /// Pixels it can reach, `[x0, x1, y0, y1]`, inclusive, in full-frame raster space.
    pub pixels: [i32; 4],
    /// Nearest and farthest depth.
    pub depth: [f32; 2],
    /// At how many of its keys it reaches in front of the near plane, out of how many.
    pub at_eye: [u32; 2],
    /// Its largest width and height at any one time and in focus, in pixels; of the region where it
    /// passes the near plane.
    pub size_px: [f32; 2],
    /// When it can be where.
    pub sweep: Sweep,
    /// When it can be seen by a sample of the region that was asked for.
    pub times: TimeRange,
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
    let mut hull = Hull::new(context.camera, region);
    let key_times = &context.patches.times.sets[patch.motion as usize];
    let mut keys = Vec::with_capacity(key_times.len());
    for key in 0..key_times.len() {
        hull.begin_key();
        context.surfaces.hull(piece.patch, key, u, v, |p| hull.include(p));
        keys.push(hull.key);
    }
    let rounding = hull.rounding();
    hull.finish(&mut keys, key_times, patch.slack + rounding)
}

/// Rounding of an evaluated point, relative to the largest coordinate around it.
const ROUNDING: f32 = 2e-6;

/// Accumulates hull points.
struct Hull<'a> {
    camera: &'a RasterCamera,
    region: &'a Region,
    depth: [f32; 2],
    /// Largest coordinate.
    reach: f32,
    key: KeyExtent,
    /// Largest signed distance to the planes through the region's left, right, top and bottom border, in
    /// pixels times depth, positive inside: all points negative means outside, in front of the eye or behind.
    inside: [f32; 4],
}

impl<'a> Hull<'a> {
    fn new(camera: &'a RasterCamera, region: &'a Region) -> Self {
        let key = KeyExtent::EMPTY;
        let depth = [f32::INFINITY, f32::NEG_INFINITY];
        Hull { camera, region, depth, reach: 0.0, key, inside: [f32::NEG_INFINITY; 4] }
    }

    fn begin_key(&mut self) {
        self.key = KeyExtent::EMPTY;
    }

    #[inline(always)]
    fn include(&mut self, p: Vec3) {
        self.depth = [self.depth[0].min(p.z), self.depth[1].max(p.z)];
        self.key.include(self.camera, p);
        self.reach = self.reach.max(p.abs().max_element());
        let w = if self.camera.perspective { p.z } else { 1.0 };
        let x = p.x * self.camera.scale[0] + self.camera.center[0] * w;
        let y = self.camera.center[1] * w - p.y * self.camera.scale[1];
        let Region { x0, x1, y0, y1 } = *self.region;
        let [x0, x1, y0, y1] = [x0, x1, y0, y1].map(|px| px as f32);
        let inside = [x - (x0 - 1.0) * w, (x1 + 1.0) * w - x, y - (y0 - 1.0) * w, (y1 + 1.0) * w - y];
        self.inside = std::array::from_fn(|ix| self.inside[ix].max(inside[ix]));
    }

    fn rounding(&self) -> f32 {
        ROUNDING * self.reach
    }

    /// What the lens adds to distances to the region's borders, in pixels times depth: the circle of confusion times
    /// the depth is linear in the depth.
    fn lens_slack(&self, depth: [f32; 2]) -> f32 {
        let of =
            |z: f32, lens: crate::geometry::camera::RasterLens| lens.radius * (z / lens.focus - 1.0).abs();
        self.camera.lens.map_or(0.0, |lens| of(depth[0], lens).max(of(depth[1], lens)))
    }

    fn finish(&self, keys: &mut [KeyExtent], key_times: &[f32], slack: f32) -> Result<Bound, Unseen> {
        let depth = [self.depth[0] - slack, self.depth[1] + slack];
        if depth[1] < self.camera.near || depth[0] > self.camera.far {
            return Err(Unseen::Depth);
        }
        let slack_px = slack * self.camera.scale[0].abs().max(self.camera.scale[1].abs());
        let reach = slack_px + self.lens_slack(depth);
        if self.inside.iter().any(|&inside| inside < -reach) {
            return Err(Unseen::Frustum);
        }
        let crosses = depth[0] < self.camera.near;
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
        let rectangle = [x0, x1, y0, y1].map(|px| px as f32);
        let times = sweep.meets(rectangle).ok_or(Unseen::Frustum)?;
        let size = |key: &KeyExtent| [key.raster[1] - key.raster[0], key.raster[3] - key.raster[2]];
        let size_px = if crosses {
            let within = [whole[0].max(x0), whole[1].min(x1 - 1), whole[2].max(y0), whole[3].min(y1 - 1)];
            [0, 2].map(|axis| (within[axis + 1] - within[axis]) as f32)
        } else {
            keys.iter()
                .map(size)
                .fold([0.0; 2], |most: [f32; 2], size| [most[0].max(size[0]), most[1].max(size[1])])
        };
        let num_at_eye = keys.iter().filter(|key| key.least.z < self.camera.near).count();
        let at_eye = [num_at_eye as u32, keys.len() as u32];
        Ok(Bound { pixels: whole, depth, at_eye, size_px, sweep, times })
    }
}
