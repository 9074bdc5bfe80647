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

/// Where a piece can be.
#[derive(Debug, Clone, PartialEq)]
pub struct Bound {
    /// Pixels it can reach, `[x0, x1, y0, y1]`, inclusive, in full-frame raster space.
    pub pixels: [i32; 4],
    /// Nearest and farthest depth.
    pub depth: [f32; 2],
    /// It reaches in front of the near plane at some time, so that it may be anywhere on the raster.
    pub crosses: bool,
    /// Its largest width and height at any one time and in focus, in pixels; 0 where it crosses.
    pub size_px: [f32; 2],
    /// When it can be where; everywhere at all times where it crosses.
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

/// A part of the shutter, both ends inclusive: 0 is open, 1 closed.
pub type TimeRange = [f32; 2];

/// The whole time.
pub const ALWAYS: TimeRange = [0.0, 1.0];

/// Boxes on the raster at key times, `[x0, x1, y0, y1]`; between keys all sides move evenly. None at all are
/// everywhere.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sweep {
    boxes: Vec<[f32; 4]>,
}

impl Sweep {
    /// The sweep of one box a key time.
    pub fn new(boxes: Vec<[f32; 4]>) -> Self {
        Sweep { boxes }
    }

    /// The time in which it can meet the closed rectangle `[x0, x1, y0, y1]`, if it does.
    pub fn meets(&self, key_times: &[f32], rectangle: [f32; 4]) -> Option<TimeRange> {
        match self.boxes.as_slice() {
            [] => Some(ALWAYS),
            [only] => segment_meets([only, only], rectangle).map(|_| ALWAYS),
            boxes => {
                let mut range: Option<TimeRange> = None;
                for (ends, times) in boxes.windows(2).zip(key_times.windows(2)) {
                    let Some(part) = segment_meets([&ends[0], &ends[1]], rectangle) else { continue };
                    let at = |part: f32| times[0] + (times[1] - times[0]) * part;
                    // Rounding of the division, and of times to 1/32768.
                    let (from, to) = (at(part[0]) - ROUNDING_TIME, at(part[1]) + ROUNDING_TIME);
                    let [first, last] = range.unwrap_or([from, to]);
                    range = Some([first.min(from).max(0.0), last.max(to).min(1.0)]);
                }
                range
            }
        }
    }
}

/// A little more than 1/32768 of the shutter.
const ROUNDING_TIME: f32 = 1e-4;

/// The part of a segment in which a box meets a rectangle.
fn segment_meets([from, to]: [&[f32; 4]; 2], [x0, x1, y0, y1]: [f32; 4]) -> Option<TimeRange> {
    let mut range = ALWAYS;
    // Each gap has to be at least 0.
    let gaps = |b: &[f32; 4]| [x1 - b[0], b[1] - x0, y1 - b[2], b[3] - y0];
    for (start, end) in gaps(from).into_iter().zip(gaps(to)) {
        let zero = start / (start - end);
        match (start >= 0.0, end >= 0.0) {
            (true, true) => {}
            (true, false) => range[1] = range[1].min(zero),
            (false, true) => range[0] = range[0].max(zero),
            (false, false) => return None,
        }
    }
    (range[0] <= range[1]).then_some(range)
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
    hull.finish(&keys, key_times, patch.slack + rounding)
}

/// Rounding of an evaluated point, relative to the largest coordinate around it.
const ROUNDING: f32 = 2e-6;

/// What is known of one key.
#[derive(Debug, Clone, Copy)]
struct Key {
    depth: [f32; 2],
    /// Raster box of the points in front of the near plane.
    raster: [f32; 4],
}

/// Accumulates hull points.
struct Hull<'a> {
    camera: &'a RasterCamera,
    region: &'a Region,
    depth: [f32; 2],
    /// Largest coordinate.
    reach: f32,
    key: Key,
    /// Largest signed distance to the planes through the region's left, right, top and bottom border, in
    /// pixels times depth, positive inside: all points negative means outside, in front of the eye or behind.
    inside: [f32; 4],
}

const NOTHING: [f32; 2] = [f32::INFINITY, f32::NEG_INFINITY];

impl<'a> Hull<'a> {
    fn new(camera: &'a RasterCamera, region: &'a Region) -> Self {
        let key = Key { depth: NOTHING, raster: [NOTHING[0], NOTHING[1], NOTHING[0], NOTHING[1]] };
        Hull { camera, region, depth: NOTHING, reach: 0.0, key, inside: [f32::NEG_INFINITY; 4] }
    }

    fn begin_key(&mut self) {
        self.key = Key { depth: NOTHING, raster: [NOTHING[0], NOTHING[1], NOTHING[0], NOTHING[1]] };
    }

    #[inline(always)]
    fn include(&mut self, p: Vec3) {
        self.depth = [self.depth[0].min(p.z), self.depth[1].max(p.z)];
        self.key.depth = [self.key.depth[0].min(p.z), self.key.depth[1].max(p.z)];
        self.reach = self.reach.max(p.abs().max_element());
        if p.z >= self.camera.near {
            let [x, y] = self.camera.project(p);
            let r = &mut self.key.raster;
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

    /// What the lens adds to distances to the region's borders, in pixels times depth: the circle of confusion times
    /// the depth is linear in the depth.
    fn lens_slack(&self, depth: [f32; 2]) -> f32 {
        let of =
            |z: f32, lens: crate::geometry::camera::RasterLens| lens.radius * (z / lens.focus - 1.0).abs();
        self.camera.lens.map_or(0.0, |lens| of(depth[0], lens).max(of(depth[1], lens)))
    }

    fn finish(&self, keys: &[Key], key_times: &[f32], slack: f32) -> Result<Bound, Unseen> {
        let depth = [self.depth[0] - slack, self.depth[1] + slack];
        if depth[1] < self.camera.near || depth[0] > self.camera.far {
            return Err(Unseen::Depth);
        }
        let crosses = depth[0] < self.camera.near && self.camera.perspective;
        let slack_px = slack * self.camera.scale[0].abs().max(self.camera.scale[1].abs());
        let reach = slack_px + self.lens_slack(depth);
        if self.inside.iter().any(|&inside| inside < -reach) {
            return Err(Unseen::Frustum);
        }
        let Region { x0, x1, y0, y1 } = *self.region;
        // An orthographic piece that reaches behind the near plane is bounded by all of its points; those in
        // front alone would miss the cut.
        if crosses || self.depth[0] < self.camera.near || !slack_px.is_finite() {
            let pixels = [x0, x1 - 1, y0, y1 - 1];
            let sweep = Sweep::default();
            return Ok(Bound { pixels, depth, crosses: true, size_px: [0.0; 2], sweep, times: ALWAYS });
        }
        let mut size_px = [0.0f32; 2];
        let boxes: Vec<[f32; 4]> = keys
            .iter()
            .map(|key| {
                let grow = 0.01 + if self.camera.perspective { slack_px / depth[0] } else { slack_px };
                let r = key.raster;
                size_px =
                    [size_px[0].max(r[1] - r[0] + 2.0 * grow), size_px[1].max(r[3] - r[2] + 2.0 * grow)];
                let grow = grow + self.camera.greatest_coc_px([key.depth[0] - slack, key.depth[1] + slack]);
                [r[0] - grow, r[1] + grow, r[2] - grow, r[3] + grow]
            })
            .collect();
        let all = boxes.iter().fold([NOTHING[0], NOTHING[1], NOTHING[0], NOTHING[1]], |all, b| {
            [all[0].min(b[0]), all[1].max(b[1]), all[2].min(b[2]), all[3].max(b[3])]
        });
        let pixels = all.map(|px| px.floor().clamp(-2e9, 2e9) as i32);
        let sweep = Sweep::new(boxes);
        let rectangle = [x0, x1, y0, y1].map(|px| px as f32);
        if pixels[0] >= x1 || pixels[1] < x0 || pixels[2] >= y1 || pixels[3] < y0 {
            return Err(Unseen::Frustum);
        }
        let times = match keys.len() {
            1 => ALWAYS,
            _ => sweep.meets(key_times, rectangle).ok_or(Unseen::Frustum)?,
        };
        Ok(Bound { pixels, depth, crosses: false, size_px, sweep, times })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_that_passes_meets_a_rectangle_for_a_while() {
        let sweep = Sweep::new(vec![[0.0, 1.0, 0.0, 1.0], [100.0, 101.0, 0.0, 1.0]]);
        let [from, to] = sweep.meets(&[0.0, 1.0], [50.0, 60.0, 0.0, 8.0]).expect("it passes");
        assert!((from - 0.49).abs() < 2e-3 && (to - 0.6).abs() < 2e-3, "{from} {to}");
        assert_eq!(sweep.meets(&[0.0, 1.0], [50.0, 60.0, 2.0, 8.0]), None);
        assert_eq!(sweep.meets(&[0.0, 1.0], [-5.0, 200.0, -1.0, 8.0]), Some(ALWAYS));
    }

    #[test]
    fn a_box_on_a_diagonal_misses_the_corners_of_its_path() {
        let sweep = Sweep::new(vec![[0.0, 1.0, 0.0, 1.0], [100.0, 101.0, 100.0, 101.0]]);
        assert_eq!(sweep.meets(&[0.0, 1.0], [80.0, 90.0, 10.0, 20.0]), None);
        assert!(sweep.meets(&[0.0, 1.0], [40.0, 50.0, 40.0, 50.0]).is_some());
    }

    #[test]
    fn keys_divide_the_time() {
        let boxes = vec![[0.0, 1.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0], [10.0, 11.0, 0.0, 1.0]];
        let [from, to] =
            Sweep::new(boxes).meets(&[0.0, 0.75, 1.0], [10.0, 12.0, 0.0, 1.0]).expect("at the end");
        assert!((from - 0.975).abs() < 1e-3 && to == 1.0, "{from} {to}");
    }
}
