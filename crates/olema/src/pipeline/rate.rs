//! Edge rates: how many segments an edge gets, from the edge alone.
//!
//! In: a curve, the camera, a shading rate. Out: `Rate`. Whoever asks, on whichever side of the edge, gets the
//! same answer, since nothing else is read. Source: DiagSplit (Fisher et al. 2009, section 3).

use glam::Vec3;

use crate::geometry::RasterCamera;

/// Segments the projected curve is measured with.
const PROBES: usize = 8;

/// Longest probe over the mean one up to which equal parametric steps are even enough.
const EVENNESS: f32 = 1.3;

/// Edges are not halved for unevenness beyond this level.
pub const MAX_LEVEL: u8 = 16;

/// Most segments of one edge.
const MAX_SEGMENTS: f32 = 1_048_576.0;

/// How finely something is diced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fineness {
    /// Area of a micropolygon in pixels.
    pub shading_rate: f32,
    /// How much motion coarsens it ([`crate::scene::Attributes::motion_factor`]).
    pub motion_factor: f32,
    /// How much defocus coarsens it.
    pub focus_factor: f32,
}

impl Fineness {
    /// Of each the finer.
    pub fn finest(self, other: Fineness) -> Self {
        Fineness {
            shading_rate: self.shading_rate.min(other.shading_rate),
            motion_factor: self.motion_factor.min(other.motion_factor),
            focus_factor: self.focus_factor.min(other.focus_factor),
        }
    }

    /// Side of a micropolygon in pixels, for points that move at least `motion_px` and whose circles of confusion
    /// have at least the diameter `focus_px`.
    fn side_px(&self, blur: Blur) -> f32 {
        let motion = 1.0 + self.motion_factor * blur.motion_px / BLUR_UNIT_PX;
        let focus = 1.0 + self.focus_factor * blur.focus_px / BLUR_UNIT_PX;
        (self.shading_rate * motion * focus).sqrt()
    }

    fn follows_blur(&self) -> bool {
        self.motion_factor > 0.0 || self.focus_factor > 0.0
    }
}

/// Blur that doubles a micropolygon's area at a factor of 1, in pixels.
const BLUR_UNIT_PX: f32 = 16.0;

/// Least blur of some points.
#[derive(Debug, Clone, Copy)]
struct Blur {
    motion_px: f32,
    focus_px: f32,
}

/// Keys at which sizes are measured, of `num_keys`: at most five, the first and the last among them.
pub fn measured_keys(num_keys: usize) -> impl Iterator<Item = usize> {
    let num = num_keys.min(5);
    (0..num).map(move |ix| if num == 1 { 0 } else { ix * (num_keys - 1) / (num - 1) })
}

/// How an edge is cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rate {
    /// Into k >= 1 equal parametric steps.
    Even(u32),
    /// At its middle first: its projected speed varies too much.
    Uneven,
    /// At its middle first: it reaches the eye plane, where its length is not defined.
    Eye,
}

/// Points on a line at one key.
type Probes = [Vec3; PROBES + 1];

/// Rate of a curve that is at `point(t, key)`, t in [0, 1], at `keys`, given how finely it is wanted: the finest that
/// any key asks for. Where the curve reaches the eye plane at some keys only, the others decide.
pub fn rate(
    camera: &RasterCamera,
    fineness: Fineness,
    keys: impl Iterator<Item = usize>,
    mut point: impl FnMut(f32, usize) -> Vec3,
) -> Rate {
    let mut at = |key: usize| -> Probes { std::array::from_fn(|ix| point(ix as f32 / PROBES as f32, key)) };
    let mut result = Rate::Eye;
    if !fineness.follows_blur() {
        let side_px = fineness.side_px(Blur { motion_px: 0.0, focus_px: 0.0 });
        keys.for_each(|key| result = result.finer(rate_at(camera, side_px, &at(key))));
        return result;
    }
    let probes: Vec<Probes> = keys.map(at).collect();
    let side_px = fineness.side_px(least_blur(camera, &probes));
    probes.iter().for_each(|points| result = result.finer(rate_at(camera, side_px, points)));
    result
}

impl Rate {
    /// The finer of two keys' rates; one that is not defined leaves it to the other.
    fn finer(self, other: Rate) -> Rate {
        match (self, other) {
            (Rate::Eye, rate) | (rate, Rate::Eye) => rate,
            (Rate::Even(a), Rate::Even(b)) => Rate::Even(a.max(b)),
            _ => Rate::Uneven,
        }
    }
}

/// Least length of the path of any of the points, and least diameter of any of their circles of confusion; 0 where
/// one of them reaches the eye plane.
fn least_blur<const N: usize>(camera: &RasterCamera, keys: &[[Vec3; N]]) -> Blur {
    let is_defined = |p: &Vec3| p.z >= eye_depth(camera);
    if !keys.iter().flatten().all(is_defined) {
        return Blur { motion_px: 0.0, focus_px: 0.0 };
    }
    let path = |ix: usize| -> f32 {
        let places = keys.iter().map(|points| camera.project(points[ix]));
        places.clone().zip(places.skip(1)).map(|(a, b)| distance(a, b)).sum()
    };
    let coc = |p: &Vec3| camera.lens.map_or(0.0, |lens| lens.coc_px(p.z).abs());
    let blur = Blur {
        motion_px: (0..N).map(path).fold(f32::INFINITY, f32::min),
        focus_px: 2.0 * keys.iter().flatten().map(coc).fold(f32::INFINITY, f32::min),
    };
    if blur.motion_px.is_finite() && blur.focus_px.is_finite() {
        blur
    } else {
        Blur { motion_px: 0.0, focus_px: 0.0 }
    }
}

fn distance(a: [f32; 2], b: [f32; 2]) -> f32 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    (dx * dx + dy * dy).sqrt()
}

/// Rate at one key, for segments of `side_px` pixels.
fn rate_at(camera: &RasterCamera, side_px: f32, points: &Probes) -> Rate {
    let mut last: Option<[f32; 2]> = None;
    let (mut total, mut longest) = (0.0f32, 0.0f32);
    for &p in points {
        if p.z.is_nan() || p.z < eye_depth(camera) {
            return Rate::Eye;
        }
        let raster = camera.project(p);
        if let Some(last) = last {
            let length = distance(last, raster);
            total += length;
            longest = longest.max(length);
        }
        last = Some(raster);
    }
    if !total.is_finite() {
        return Rate::Eye;
    }
    let segments = total / side_px;
    // A curve of a segment or two is never worth halving.
    if segments > 2.0 && longest * PROBES as f32 > EVENNESS * total {
        return Rate::Uneven;
    }
    Rate::Even(segments.round().clamp(1.0, MAX_SEGMENTS) as u32)
}

/// Depth below which lengths are not measured. It lies well in front of the near plane, where nothing is drawn
/// but lengths are still defined, so that only what passes the eye itself is special. An orthographic picture
/// has no eye plane.
fn eye_depth(camera: &RasterCamera) -> f32 {
    if camera.perspective { (camera.near / 1024.0).max(f32::MIN_POSITIVE) } else { f32::NEG_INFINITY }
}

/// Points inside a piece at one key, row by row.
pub type Lattice = [Vec3; 25];

/// Segments along both axes that the inside of a piece asks for, given 5 x 5 points of it at each measured key:
/// projected length of its three inner lines, at least as long as their longest parts ask. Keys at which one of them
/// passes the eye do not count, unless all do.
pub fn inner_segments(camera: &RasterCamera, fineness: Fineness, keys: &[Lattice]) -> [u32; 2] {
    let side_px = fineness.side_px(if fineness.follows_blur() {
        least_blur(camera, keys)
    } else {
        Blur { motion_px: 0.0, focus_px: 0.0 }
    });
    let mut most = [0.0f32; 2];
    let mut is_defined = [false; 2];
    for points in keys {
        for (axis, step) in [1, 5].into_iter().enumerate() {
            let lines = (1..4)
                .map(|line| -> [Vec3; 5] { std::array::from_fn(|ix| points[line * (6 - step) + ix * step]) });
            let mut all = true;
            for polyline in lines {
                match polyline_segments(camera, side_px, &polyline) {
                    Some(wanted) => most[axis] = most[axis].max(wanted),
                    None => all = false,
                }
            }
            is_defined[axis] |= all;
        }
    }
    std::array::from_fn(|axis| {
        let least = if is_defined[axis] { 0.0 } else { UNDEFINED_SEGMENTS };
        most[axis].max(least).round() as u32
    })
}

/// Segments where no length is defined: as many as a grid allows.
const UNDEFINED_SEGMENTS: f32 = 16.0;

/// Projected length in segments of a polyline; `None` where a point is at or behind the eye plane.
fn polyline_segments(camera: &RasterCamera, side_px: f32, points: &[Vec3]) -> Option<f32> {
    let (mut total, mut longest) = (0.0f32, 0.0f32);
    for pair in points.windows(2) {
        if !(pair[0].z >= eye_depth(camera) && pair[1].z >= eye_depth(camera)) {
            return None;
        }
        let length = distance(camera.project(pair[0]), camera.project(pair[1]));
        total += length;
        longest = longest.max(length);
    }
    let even = longest * (points.len() - 1) as f32 / EVENNESS;
    let segments = total.max(even) / side_px;
    segments.is_finite().then_some(segments.min(MAX_SEGMENTS))
}
