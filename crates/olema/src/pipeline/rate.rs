//! Edge rates: how many segments an edge gets, from the edge alone.
//!
//! In: a curve, the camera, a shading rate. Out: `Rate`. Whoever asks, on whichever side of the edge, gets the
//! same answer, since nothing else is read. Source: DiagSplit (Fisher et al. 2009, section 3).

use glam::Vec3;

use crate::geometry::RasterCamera;

use super::sweep::{NOWHERE, grown, segment_meets, union};

/// Segments the projected curve is measured with.
pub const PROBES: usize = 8;

/// Longest probe over the mean one up to which equal parametric steps are even enough.
const EVENNESS: f32 = 1.3;

/// Edges are not halved for unevenness beyond this level.
pub const MAX_LEVEL: u8 = 16;

/// Most segments of one edge.
const MAX_SEGMENTS: f32 = 1_048_576.0;

/// Area in units of the shading rate of a micropolygon that faces the camera. Those at a slant have less, as their sides
/// keep their lengths on the raster but no longer meet at right angles: on closed surfaces 0.76 to 0.82 of it on average.
const FACING_AREA: f32 = 1.2;

/// How finely something is diced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fineness {
    /// Area of a micropolygon in pixels, on average over a surface that is seen at all slants.
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

    /// Side of a micropolygon in pixels on the raster, for points that move at least `motion_px` and whose circles of
    /// confusion have at least the diameter `focus_px`.
    fn side_px(&self, blur: Blur) -> f32 {
        let motion = 1.0 + self.motion_factor * blur.motion_px / BLUR_UNIT_PX;
        let focus = 1.0 + self.focus_factor * blur.focus_px / BLUR_UNIT_PX;
        (FACING_AREA * self.shading_rate * motion * focus).sqrt()
    }

    /// The same for points at several keys.
    fn side_px_of<const N: usize>(&self, camera: &RasterCamera, keys: &[[Vec3; N]]) -> f32 {
        let follows_blur = self.motion_factor > 0.0 || self.focus_factor > 0.0;
        self.side_px(if follows_blur { least_blur(camera, keys) } else { Blur::NONE })
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

impl Blur {
    const NONE: Blur = Blur { motion_px: 0.0, focus_px: 0.0 };
}

/// Motion keys at which sizes are measured: at most five, spread evenly over the time.
#[derive(Debug, Clone, Copy)]
pub struct MeasuredKeys {
    keys: [usize; Self::MOST],
    len: usize,
}

impl MeasuredKeys {
    /// As many as there are at most.
    pub const MOST: usize = 5;

    /// Of these key times, at least one.
    pub fn new(key_times: &[f32]) -> Self {
        let mut measured = MeasuredKeys { keys: [0; Self::MOST], len: 1 };
        for wanted in [0.25, 0.5, 0.75, 1.0] {
            let apart = |key: &usize| (key_times[*key] - wanted).abs();
            let nearest = (0..key_times.len()).min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap_or(0);
            if measured.keys[measured.len - 1] != nearest {
                measured.keys[measured.len] = nearest;
                measured.len += 1;
            }
        }
        measured
    }

    /// The keys.
    pub fn keys(&self) -> impl Iterator<Item = usize> + '_ {
        self.keys[..self.len].iter().copied()
    }

    /// The depths from which on lengths count, tried in turn. What moves past the eye is not diced for the moment in
    /// which it is closest; what is nowhere in front of the near plane is measured as if it stood still.
    fn least_depths(&self, camera: &RasterCamera) -> impl Iterator<Item = f32> {
        let visible = (self.len > 1 && camera.perspective).then_some(camera.near);
        visible.into_iter().chain([eye_depth(camera)])
    }

    /// The length to dice for: the largest that is seen, as long as it is not many times what it is at most keys.
    fn wanted(&self, camera: &RasterCamera, at_keys: &[Option<Measured>]) -> Option<f32> {
        let (mut sorted, mut num) = ([0.0f32; Self::MOST], 0);
        for measured in at_keys.iter().flatten() {
            sorted[num] = measured.length;
            num += 1;
        }
        sorted[..num].sort_by(f32::total_cmp);
        let largest = *sorted[..num].last()?;
        if at_keys.len() == 1 {
            return Some(largest);
        }
        let median = (sorted[(num - 1) / 2] + sorted[num / 2]) * 0.5;
        let most = (MOST_OVER_MEDIAN * median).max(MOST_OVER_SMALLEST * sorted[0]);
        Some(largest_seen(camera, at_keys).unwrap_or(sorted[0]).min(most))
    }
}

/// How much longer than most of the time something may be and still be diced for that: beyond it it is blurred so
/// much that nothing finer shows. What grows evenly is at most twice the median.
const MOST_OVER_MEDIAN: f32 = 2.0;

/// The same over its smallest length: what grows by more is blurred by nearly its own size.
const MOST_OVER_SMALLEST: f32 = 4.0;

/// The largest length while it may be in the frame, if it ever is: what leaves the frame at a slant may be drawn out to
/// any length beside it. Between keys length and place change evenly.
fn largest_seen(camera: &RasterCamera, at_keys: &[Option<Measured>]) -> Option<f32> {
    let [width, height] = camera.frame_px;
    let frame = [-BESIDE_PX, width + BESIDE_PX, -BESIDE_PX, height + BESIDE_PX];
    let mut largest: Option<f32> = None;
    for pair in at_keys.windows(2) {
        let seen = match (&pair[0], &pair[1]) {
            (Some(from), Some(to)) => {
                let Some(part) = segment_meets([&from.reach, &to.reach], frame) else { continue };
                let at = |part: f32| from.length + (to.length - from.length) * part;
                at(part[0]).max(at(part[1]))
            }
            // On its way past the eye.
            (Some(known), None) | (None, Some(known)) => known.length,
            (None, None) => continue,
        };
        largest = Some(largest.unwrap_or(0.0).max(seen));
    }
    largest
}

/// What is so near the frame counts as if it were in it: filters are wide, and keys between those that are measured
/// may be elsewhere.
const BESIDE_PX: f32 = 64.0;

/// A polyline at one key.
#[derive(Debug, Clone, Copy)]
struct Measured {
    /// Projected length.
    length: f32,
    /// Length of its longest part.
    longest: f32,
    /// Box on the raster that holds it, circles of confusion included.
    reach: [f32; 4],
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

/// Rate of a curve, given points of it in equal parametric steps at each measured key and how finely it is wanted, for
/// the size that it has at its largest. Where it reaches the eye plane at some keys only, the others decide.
pub fn rate(
    camera: &RasterCamera,
    fineness: Fineness,
    keys: &MeasuredKeys,
    probes: &[[Vec3; PROBES + 1]],
) -> Rate {
    let side_px = fineness.side_px_of(camera, probes);
    let mut placed = [[Placed::default(); PROBES + 1]; MeasuredKeys::MOST];
    place_all(camera, probes, &mut placed);
    for least_depth in keys.least_depths(camera) {
        let mut at_keys = [None; MeasuredKeys::MOST];
        for (measured, points) in at_keys.iter_mut().zip(&placed[..probes.len()]) {
            *measured = measure(camera, least_depth, points.iter());
        }
        let at_keys = &at_keys[..probes.len()];
        let Some(wanted) = keys.wanted(camera, at_keys) else {
            continue;
        };
        // A curve of a segment or two is never worth halving.
        let is_uneven = |line: &Measured| {
            line.length.min(wanted) / side_px > 2.0 && line.longest * PROBES as f32 > EVENNESS * line.length
        };
        if at_keys.iter().flatten().any(is_uneven) {
            return Rate::Uneven;
        }
        return Rate::Even((wanted / side_px).round().clamp(1.0, MAX_SEGMENTS) as u32);
    }
    Rate::Eye
}

/// Least length of the path of any of the points, and least diameter of any of their circles of confusion; 0 where
/// one of them reaches the eye plane.
fn least_blur<const N: usize>(camera: &RasterCamera, keys: &[[Vec3; N]]) -> Blur {
    let is_defined = |p: &Vec3| p.z >= eye_depth(camera);
    if !keys.iter().flatten().all(is_defined) {
        return Blur::NONE;
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
    if blur.motion_px.is_finite() && blur.focus_px.is_finite() { blur } else { Blur::NONE }
}

fn distance(a: [f32; 2], b: [f32; 2]) -> f32 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    (dx * dx + dy * dy).sqrt()
}

/// A point that is measured.
#[derive(Debug, Clone, Copy, Default)]
struct Placed {
    raster: [f32; 2],
    depth: f32,
}

/// Projects points at all keys.
fn place_all<const N: usize>(camera: &RasterCamera, keys: &[[Vec3; N]], placed: &mut [[Placed; N]]) {
    for (&p, placed) in keys.iter().flatten().zip(placed.iter_mut().flatten()) {
        *placed = Placed { raster: camera.project(p), depth: p.z };
    }
}

/// Measures a polyline; `None` where a point is less deep than `least_depth`.
fn measure<'p>(
    camera: &RasterCamera,
    least_depth: f32,
    points: impl Iterator<Item = &'p Placed>,
) -> Option<Measured> {
    let mut last: Option<[f32; 2]> = None;
    let mut measured = Measured { length: 0.0, longest: 0.0, reach: NOWHERE };
    let mut range = [f32::INFINITY, f32::NEG_INFINITY];
    for &Placed { raster, depth } in points {
        if depth.is_nan() || depth < least_depth {
            return None;
        }
        range = [range[0].min(depth), range[1].max(depth)];
        measured.reach = union(&measured.reach, &[raster[0], raster[0], raster[1], raster[1]]);
        if let Some(last) = last {
            let length = distance(last, raster);
            measured.length += length;
            measured.longest = measured.longest.max(length);
        }
        last = Some(raster);
    }
    measured.reach = grown(measured.reach, camera.greatest_coc_px(range));
    measured.length.is_finite().then_some(measured)
}

/// Depth below which lengths are not measured. It lies well in front of the near plane, where nothing is drawn
/// but lengths are still defined, so that only what passes the eye itself is special. An orthographic picture
/// has no eye plane.
fn eye_depth(camera: &RasterCamera) -> f32 {
    if camera.perspective { (camera.near / 1024.0).max(f32::MIN_POSITIVE) } else { f32::NEG_INFINITY }
}

/// Points inside a piece, five rows of five.
pub const INNER_POINTS: usize = 25;

/// Segments along both axes that the inside of a piece asks for, given 5 x 5 points of it at each measured key:
/// projected length of its three inner lines, at least as long as their longest parts ask. Keys at which one of them
/// passes the eye do not count, unless all do.
pub fn inner_segments(
    camera: &RasterCamera,
    fineness: Fineness,
    keys: &MeasuredKeys,
    points: &[[Vec3; INNER_POINTS]],
) -> [u32; 2] {
    let side_px = fineness.side_px_of(camera, points);
    let mut placed = [[Placed::default(); INNER_POINTS]; MeasuredKeys::MOST];
    place_all(camera, points, &mut placed);
    let placed = &placed[..points.len()];
    let along = |step: usize| {
        for least_depth in keys.least_depths(camera) {
            let mut at_keys = [None; MeasuredKeys::MOST];
            for (measured, points) in at_keys.iter_mut().zip(placed) {
                let line = |line: usize| measure_evenly(camera, least_depth, points, line * (6 - step), step);
                *measured =
                    line(1).and_then(|first| longer(first, line(2))).and_then(|two| longer(two, line(3)));
            }
            if let Some(wanted) = keys.wanted(camera, &at_keys[..points.len()]) {
                return (wanted / side_px).min(MAX_SEGMENTS).round() as u32;
            }
        }
        UNDEFINED_SEGMENTS
    };
    [along(1), along(5)]
}

/// The longer of two lines, and the reach of both.
fn longer(a: Measured, b: Option<Measured>) -> Option<Measured> {
    let b = b?;
    let longer = if b.length > a.length { b } else { a };
    Some(Measured { reach: union(&a.reach, &b.reach), ..longer })
}

/// Segments where no length is defined: as many as a grid allows.
const UNDEFINED_SEGMENTS: u32 = 16;

/// Measures a line of a lattice, five points from `first` on, as at least as long as its longest part asks.
fn measure_evenly(
    camera: &RasterCamera,
    least_depth: f32,
    lattice: &[Placed; INNER_POINTS],
    first: usize,
    step: usize,
) -> Option<Measured> {
    let line = measure(camera, least_depth, lattice[first..].iter().step_by(step).take(5))?;
    let length = line.length.max(line.longest * 4.0 / EVENNESS);
    length.is_finite().then_some(Measured { length, ..line })
}
