//! Bound: where on the raster, how deep, and when a piece can be.
//!
//! In: `Piece`. Out: `Bound`, or the reason why nothing of it can be seen. The control points of the part of the
//! patch under the piece's (u, v) box are a hull of it; grown where a welded neighbour's border may differ, by
//! displacement, and by the largest circle of confusion at its depths. Each key has a box of its own: between two
//! keys a vertex moves on a straight line at constant speed, and so do the sides of the box that holds it.

use glam::Vec3;

use crate::geometry::RasterCamera;
use crate::geometry::camera::GUARD_BAND_PX;
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

/// A part of the shutter, both ends inclusive: 0 is open, 1 closed.
pub type TimeRange = [f32; 2];

/// The whole time.
pub const ALWAYS: TimeRange = [0.0, 1.0];

/// Boxes on the raster over the time, `[x0, x1, y0, y1]` in pixels.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sweep {
    segments: Vec<Segment>,
}

/// A box between two times, all of whose sides move evenly.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Segment {
    times: TimeRange,
    ends: [[f32; 4]; 2],
}

impl Sweep {
    /// One box a key time.
    pub fn of_boxes(boxes: &[[f32; 4]], key_times: &[f32]) -> Self {
        if let [only] = boxes {
            return Sweep { segments: vec![Segment { times: ALWAYS, ends: [*only; 2] }] };
        }
        let pairs = boxes.windows(2).zip(key_times.windows(2));
        // What is in front of the near plane at one of two keys only moves in no box from one to the other.
        let seen = pairs.filter(|(ends, _)| ends.iter().all(|end| end[0] <= end[1]));
        let segment = |(ends, times): (&[[f32; 4]], &[f32])| Segment {
            times: [times[0], times[1]],
            ends: [ends[0], ends[1]],
        };
        Sweep { segments: seen.map(segment).collect() }
    }

    /// Adds what moves on straight lines in camera space, not on the raster: what passes the near plane.
    fn add_slices(
        &mut self,
        [from, to]: [&KeyExtent; 2],
        camera: &RasterCamera,
        times: TimeRange,
        grow_px: f32,
    ) {
        for slice in 0..SLICES {
            let parts = [slice, slice + 1].map(|step| step as f32 / SLICES as f32);
            let [a, b] = parts.map(|part| from.between(to, part));
            let both = KeyExtent { least: a.least.min(b.least), most: a.most.max(b.most), raster: NOWHERE };
            if let Some(held) = both.project(camera) {
                let times = parts.map(|part| times[0] + (times[1] - times[0]) * part);
                self.segments.push(Segment { times, ends: [grown(held, grow_px); 2] });
            }
        }
    }

    /// The box that holds it at all times; upside down for one that is nowhere.
    pub fn whole(&self) -> [f32; 4] {
        let ends = self.segments.iter().flat_map(|segment| &segment.ends);
        ends.fold(NOWHERE, |all, b| union(&all, b))
    }

    /// The time in which it can meet the closed rectangle `[x0, x1, y0, y1]`, if it does.
    pub fn meets(&self, rectangle: [f32; 4]) -> Option<TimeRange> {
        let mut range: Option<TimeRange> = None;
        for Segment { times, ends } in &self.segments {
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

/// A box that holds nothing.
pub(super) const NOWHERE: [f32; 4] = [f32::INFINITY, f32::NEG_INFINITY, f32::INFINITY, f32::NEG_INFINITY];

/// The box that holds both.
pub(super) fn union(a: &[f32; 4], b: &[f32; 4]) -> [f32; 4] {
    [a[0].min(b[0]), a[1].max(b[1]), a[2].min(b[2]), a[3].max(b[3])]
}

/// A box larger by so much on each side.
pub(super) fn grown(b: [f32; 4], by: f32) -> [f32; 4] {
    [b[0] - by, b[1] + by, b[2] - by, b[3] + by]
}

/// Something at one key.
#[derive(Debug, Clone, Copy)]
pub struct KeyExtent {
    /// Box in camera space.
    pub least: Vec3,
    /// Its other corner.
    pub most: Vec3,
    /// Box on the raster of what is in front of the near plane.
    pub raster: [f32; 4],
}

impl KeyExtent {
    /// Around nothing.
    pub const EMPTY: KeyExtent =
        KeyExtent { least: Vec3::INFINITY, most: Vec3::NEG_INFINITY, raster: NOWHERE };

    /// Grows to hold a point.
    #[inline(always)]
    pub fn include(&mut self, camera: &RasterCamera, p: Vec3) {
        self.least = self.least.min(p);
        self.most = self.most.max(p);
        if p.z >= camera.near {
            let [x, y] = camera.project(p);
            self.raster = union(&self.raster, &[x, x, y, y]);
        }
    }

    /// Whether a vertex within may take the slow path.
    fn may_be_slow(&self, camera: &RasterCamera) -> bool {
        let is_near = self.raster.iter().all(|px| px.abs() <= GUARD_BAND_PX);
        let depth = [self.least.z, self.most.z];
        !(depth[0] >= camera.near && depth[1] <= camera.far && is_near)
            || camera.greatest_coc_px(depth) > GUARD_BAND_PX
    }

    /// The box on the raster of the part of the camera-space box that is in front of the near plane, if there is any.
    fn project(&self, camera: &RasterCamera) -> Option<[f32; 4]> {
        let [near, far] = [self.least.z.max(camera.near), self.most.z];
        if far.is_nan() || far < camera.near {
            return None;
        }
        let along = |least: f32, most: f32, scale: f32, center: f32| {
            let ends = if camera.perspective {
                [
                    if least < 0.0 { least / near } else { least / far },
                    if most > 0.0 { most / near } else { most / far },
                ]
            } else {
                [least, most]
            };
            let [a, b] = ends.map(|end| end * scale + center);
            [a.min(b), a.max(b)]
        };
        let [x0, x1] = along(self.least.x, self.most.x, camera.scale[0], camera.center[0]);
        let [y0, y1] = along(self.least.y, self.most.y, -camera.scale[1], camera.center[1]);
        let coc = camera.greatest_coc_px([near, far]);
        Some(grown([x0, x1, y0, y1], coc))
    }

    /// Part of the way to another.
    fn between(&self, to: &KeyExtent, part: f32) -> KeyExtent {
        let mix = |from: Vec3, to: Vec3| from + (to - from) * part;
        KeyExtent { least: mix(self.least, to.least), most: mix(self.most, to.most), raster: NOWHERE }
    }
}

/// Parts into which the time between two keys is cut for what passes the near plane.
const SLICES: usize = 16;

/// Where something is over the time, given where it is at the keys; `grow_px` is added to all sides.
pub fn sweep(camera: &RasterCamera, keys: &[KeyExtent], key_times: &[f32], grow_px: f32) -> Sweep {
    let box_of = |key: &KeyExtent| {
        if key.may_be_slow(camera) {
            return key.project(camera).unwrap_or(NOWHERE);
        }
        grown(key.raster, camera.greatest_coc_px([key.least.z, key.most.z]))
    };
    let boxes: Vec<[f32; 4]> = keys.iter().map(|key| grown(box_of(key), grow_px)).collect();
    let mut swept = Sweep::of_boxes(&boxes, key_times);
    for (ends, times) in keys.windows(2).zip(key_times.windows(2)) {
        if ends.iter().any(|key| key.may_be_slow(camera)) {
            swept.add_slices([&ends[0], &ends[1]], camera, [times[0], times[1]], grow_px);
        }
    }
    swept
}

/// A little more than 1/32768 of the shutter.
const ROUNDING_TIME: f32 = 1e-4;

/// The part of a segment in which a box meets a rectangle.
pub(super) fn segment_meets([from, to]: [&[f32; 4]; 2], [x0, x1, y0, y1]: [f32; 4]) -> Option<TimeRange> {
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
        let whole = sweep.whole().map(|px| px.floor().clamp(-2e9, 2e9) as i32);
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

#[cfg(test)]
mod tests {
    use super::*;

    fn sweep_of(boxes: &[[f32; 4]], key_times: &[f32]) -> Sweep {
        Sweep::of_boxes(boxes, key_times)
    }

    #[test]
    fn a_box_that_passes_meets_a_rectangle_for_a_while() {
        let sweep = sweep_of(&[[0.0, 1.0, 0.0, 1.0], [100.0, 101.0, 0.0, 1.0]], &[0.0, 1.0]);
        let [from, to] = sweep.meets([50.0, 60.0, 0.0, 8.0]).expect("it passes");
        assert!((from - 0.49).abs() < 2e-3 && (to - 0.6).abs() < 2e-3, "{from} {to}");
        assert_eq!(sweep.meets([50.0, 60.0, 2.0, 8.0]), None);
        assert_eq!(sweep.meets([-5.0, 200.0, -1.0, 8.0]), Some(ALWAYS));
    }

    #[test]
    fn a_box_on_a_diagonal_misses_the_corners_of_its_path() {
        let sweep = sweep_of(&[[0.0, 1.0, 0.0, 1.0], [100.0, 101.0, 100.0, 101.0]], &[0.0, 1.0]);
        assert_eq!(sweep.meets([80.0, 90.0, 10.0, 20.0]), None);
        assert!(sweep.meets([40.0, 50.0, 40.0, 50.0]).is_some());
    }

    #[test]
    fn keys_divide_the_time() {
        let boxes = [[0.0, 1.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0], [10.0, 11.0, 0.0, 1.0]];
        let sweep = sweep_of(&boxes, &[0.0, 0.75, 1.0]);
        let [from, to] = sweep.meets([10.0, 12.0, 0.0, 1.0]).expect("at the end");
        assert!((from - 0.975).abs() < 1e-3 && to == 1.0, "{from} {to}");
    }
}
