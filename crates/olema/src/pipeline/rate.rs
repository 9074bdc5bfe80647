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

/// Rate of the curve `point(t)`, t in [0, 1], given the wanted length of a segment in pixels.
pub fn rate(camera: &RasterCamera, segment_px: f32, mut point: impl FnMut(f32) -> Vec3) -> Rate {
    let mut last: Option<[f32; 2]> = None;
    let (mut total, mut longest) = (0.0f32, 0.0f32);
    for probe in 0..=PROBES {
        let p = point(probe as f32 / PROBES as f32);
        if p.z.is_nan() || p.z < eye_depth(camera) {
            return Rate::Eye;
        }
        let raster = camera.project(p);
        if let Some([x, y]) = last {
            let (dx, dy) = (raster[0] - x, raster[1] - y);
            let length = (dx * dx + dy * dy).sqrt();
            total += length;
            longest = longest.max(length);
        }
        last = Some(raster);
    }
    if !total.is_finite() {
        return Rate::Eye;
    }
    let segments = total / segment_px;
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

/// Projected length in segments of a polyline, at least as long as its longest part asks; `None` where a point
/// is at or behind the eye plane.
pub fn polyline_segments(camera: &RasterCamera, segment_px: f32, points: &[Vec3]) -> Option<f32> {
    let (mut total, mut longest) = (0.0f32, 0.0f32);
    for pair in points.windows(2) {
        if !(pair[0].z >= eye_depth(camera) && pair[1].z >= eye_depth(camera)) {
            return None;
        }
        let (a, b) = (camera.project(pair[0]), camera.project(pair[1]));
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let length = (dx * dx + dy * dy).sqrt();
        total += length;
        longest = longest.max(length);
    }
    let even = longest * (points.len() - 1) as f32 / EVENNESS;
    let segments = total.max(even) / segment_px;
    segments.is_finite().then_some(segments.min(MAX_SEGMENTS))
}
