//! Bound: where on the raster, and how deep, a piece can be.
//!
//! In: `Piece`. Out: `Bound`, or the reason why nothing of it can be seen. The control points of the part of the
//! patch under the piece's (u, v) box are a hull of it; grown where a welded neighbour's border may differ.

use glam::Vec3;

use crate::geometry::RasterCamera;

use crate::sampling::Region;

use super::piece::{Piece, uv_box};
use super::split::SplitContext;

/// Where a piece can be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// Pixels it can reach, `[x0, x1, y0, y1]`, inclusive, in full-frame raster space.
    pub pixels: [i32; 4],
    /// Nearest and farthest depth.
    pub depth: [f32; 2],
    /// It reaches in front of the near plane, so that it may be anywhere on the raster.
    pub crosses: bool,
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
    for key in 0..context.patches.num_keys {
        context.surfaces.hull(piece.patch, key, u, v, |p| hull.include(p));
    }
    let rounding = hull.rounding();
    hull.finish(patch.slack + rounding)
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
    /// Raster box of the points in front of the near plane.
    raster: [f32; 4],
    /// Largest signed distance to the planes through the region's left, right, top and bottom border, in
    /// pixels times depth, positive inside: all points negative means outside, in front of the eye or behind.
    inside: [f32; 4],
}

impl<'a> Hull<'a> {
    fn new(camera: &'a RasterCamera, region: &'a Region) -> Self {
        Hull {
            camera,
            region,
            depth: [f32::INFINITY, f32::NEG_INFINITY],
            reach: 0.0,
            raster: [f32::INFINITY, f32::NEG_INFINITY, f32::INFINITY, f32::NEG_INFINITY],
            inside: [f32::NEG_INFINITY; 4],
        }
    }

    #[inline(always)]
    fn include(&mut self, p: Vec3) {
        let depth = [self.depth[0].min(p.z), self.depth[1].max(p.z)];
        self.depth = depth;
        self.reach = self.reach.max(p.abs().max_element());
        if p.z >= self.camera.near {
            let [x, y] = self.camera.project(p);
            let r = &mut self.raster;
            *r = [r[0].min(x), r[1].max(x), r[2].min(y), r[3].max(y)];
        }
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

    fn finish(&self, slack: f32) -> Result<Bound, Unseen> {
        let depth = [self.depth[0] - slack, self.depth[1] + slack];
        if depth[1] < self.camera.near || depth[0] > self.camera.far {
            return Err(Unseen::Depth);
        }
        let crosses = depth[0] < self.camera.near && self.camera.perspective;
        let slack_px = slack * self.camera.scale[0].abs().max(self.camera.scale[1].abs());
        if self.inside.iter().any(|&inside| inside < -slack_px) {
            return Err(Unseen::Frustum);
        }
        let Region { x0, x1, y0, y1 } = *self.region;
        let everywhere = [x0, x1 - 1, y0, y1 - 1];
        // An orthographic piece that reaches behind the near plane is bounded by all of its points; those in
        // front alone would miss the cut.
        if crosses || self.depth[0] < self.camera.near || !slack_px.is_finite() {
            return Ok(Bound { pixels: everywhere, depth, crosses: true });
        }
        let grow = 0.01 + if self.camera.perspective { slack_px / depth[0] } else { slack_px };
        let clamp = |px: f32| px.clamp(-2e9, 2e9) as i32;
        let r = self.raster;
        let pixels = [
            clamp((r[0] - grow).floor()),
            clamp((r[1] + grow).floor()),
            clamp((r[2] - grow).floor()),
            clamp((r[3] + grow).floor()),
        ];
        if pixels[0] >= x1 || pixels[1] < x0 || pixels[2] >= y1 || pixels[3] < y0 {
            return Err(Unseen::Frustum);
        }
        Ok(Bound { pixels, depth, crosses: false })
    }
}
