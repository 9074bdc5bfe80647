//! Sweeps: where something can be, and how near, over the time of the shutter.
//!
//! In: its extent at the motion keys. Out: [`Sweep`], which tells when it meets a rectangle of the raster and bounds it
//! over ranges of time and lens places. Between two keys a vertex, its depth and its circle of confusion change evenly,
//! and so do the sides of the box that holds it, its nearest depth and its range of circles.

use glam::Vec4;

use crate::geometry::RasterCamera;
use crate::occlusion::Bounds;
use crate::sampling::Region;
use crate::sampling::pattern::StratumBounds;

use super::key_extent::KeyExtent;

/// A part of the shutter, both ends inclusive: 0 is open, 1 closed.
pub type TimeRange = [f32; 2];

/// The whole time.
pub const ALWAYS: TimeRange = [0.0, 1.0];

/// Where something is at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// Box on the raster in focus, `[x0, x1, y0, y1]` in pixels.
    pub in_focus: [f32; 4],
    /// Least and greatest signed radius of its circles of confusion, in pixels.
    pub coc: [f32; 2],
    /// Nearest depth.
    pub near: f32,
}

impl Extent {
    pub(super) const NOWHERE: Extent = Extent { in_focus: NOWHERE, coc: [0.0; 2], near: f32::INFINITY };

    /// The box that holds it for every place on the lens.
    fn blurred(&self) -> [f32; 4] {
        grown(self.in_focus, self.coc[0].abs().max(self.coc[1].abs()))
    }

    /// The box that holds it through a part of the lens, with the signs of [`SIGNS`].
    #[inline(always)]
    fn through(&self, lens: &LensPart) -> Vec4 {
        let in_focus = Vec4::from_array(self.in_focus) * SIGNS;
        if self.coc == [0.0; 2] {
            return in_focus;
        }
        let [least, most] = self.coc.map(Vec4::splat);
        // In each component the least of the four products.
        let ends = lesser(least * lens.from, least * lens.to);
        in_focus + lesser(ends, lesser(most * lens.from, most * lens.to))
    }

    /// Part of the way to another; every number is monotone in `part`.
    #[inline(always)]
    fn between(&self, to: &Extent, part: f32) -> Extent {
        let mix = |from: Vec4, to: Vec4| from + (to - from) * part;
        let rest = |extent: &Extent| Vec4::new(extent.coc[0], extent.coc[1], extent.near, 0.0);
        let in_focus = mix(Vec4::from_array(self.in_focus), Vec4::from_array(to.in_focus));
        let [least, most, near, _] = mix(rest(self), rest(to)).to_array();
        Extent { in_focus: in_focus.to_array(), coc: [least, most], near }
    }
}

/// What boxes `[x0, x1, y0, y1]` are multiplied by, so that the box that holds two of them is the lesser of both
/// throughout.
const SIGNS: Vec4 = Vec4::new(1.0, -1.0, 1.0, -1.0);

/// A part of the lens, for boxes with [`SIGNS`].
#[derive(Debug, Clone, Copy)]
struct LensPart {
    /// One end of it in each direction,
    from: Vec4,
    /// and the other.
    to: Vec4,
}

impl LensPart {
    #[inline(always)]
    fn new(range: &StratumBounds) -> Self {
        let [[u0, u1], [v0, v1]] = [range.u15, range.v15].map(|ends| ends.map(f32::from));
        let places = |u: f32, uu: f32, v: f32, vv: f32| Vec4::new(u, uu, v, vv) * (1.0 / 32_768.0) * SIGNS;
        LensPart { from: places(u0, u1, v0, v1), to: places(u1, u0, v1, v0) }
    }
}

/// In each component the lesser; that of `a` where `b` is not a number.
#[inline(always)]
fn lesser(a: Vec4, b: Vec4) -> Vec4 {
    Vec4::select(b.cmplt(a), b, a)
}

/// Where something can be over the time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sweep {
    /// The first stands here: nearly all have no more, and a list of them was asked for with every piece.
    first: Option<Segment>,
    more: Vec<Segment>,
}

/// An extent between two times, all of whose numbers change evenly.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Segment {
    times: TimeRange,
    ends: [Extent; 2],
}

impl Sweep {
    /// One extent a key time.
    pub fn of_keys(keys: &[Extent], key_times: &[f32]) -> Self {
        if let [only] = keys {
            return Sweep { first: Some(Segment { times: ALWAYS, ends: [*only; 2] }), more: Vec::new() };
        }
        let pairs = keys.windows(2).zip(key_times.windows(2));
        // What is in front of the near plane at one of two keys only moves in no box from one to the other.
        let seen = pairs.filter(|(ends, _)| ends.iter().all(|end| end.in_focus[0] <= end.in_focus[1]));
        let segment = |(ends, times): (&[Extent], &[f32])| Segment {
            times: [times[0], times[1]],
            ends: [ends[0], ends[1]],
        };
        let mut segments = seen.map(segment);
        let first = segments.next();
        // As many grids as wait for a tile have such lists: they hold no more than they need.
        let mut more = Vec::with_capacity(keys.len().saturating_sub(2));
        more.extend(segments);
        Sweep { first, more }
    }

    /// Appends the extents at `key_times` to `extents` if [`Self::of_keys`] makes the same of them again; whether it does.
    pub fn list_keys(&self, key_times: &[f32], extents: &mut Vec<Extent>) -> bool {
        let first = extents.len();
        extents.extend(self.first.iter().map(|segment| segment.ends[0]));
        if key_times.len() > 1 {
            extents.extend(self.segments().map(|segment| segment.ends[1]));
        }
        let listed = &extents[first..];
        let is_same = listed.len() == key_times.len() && Sweep::of_keys(listed, key_times) == *self;
        if !is_same {
            extents.truncate(first);
        }
        is_same
    }

    #[inline(always)]
    fn segments(&self) -> impl Iterator<Item = &Segment> {
        self.first.iter().chain(&self.more)
    }

    fn push(&mut self, segment: Segment) {
        match self.first {
            Some(_) => self.more.push(segment),
            None => self.first = Some(segment),
        }
    }

    /// Where it can be for a range of times and lens places. Bounds of a part of a range lie within those of the
    /// range, as every number below is monotone in its ends.
    pub fn over(&self, range: &StratumBounds) -> Bounds {
        let [from, to] = range.t15.map(|t15| f32::from(t15) * (1.0 / 32_768.0));
        let (from, to) = (from - ROUNDING_TIME, to + ROUNDING_TIME);
        let (mut held, mut near) = (Vec4::INFINITY, f32::INFINITY);
        let mut still = self.more.is_empty();
        let lens = LensPart::new(range);
        for Segment { times, ends: [a, b] } in self.segments() {
            if to < times[0] || from > times[1] {
                continue;
            }
            let part = |time: f32| ((time - times[0]) / (times[1] - times[0])).clamp(0.0, 1.0);
            let stands = a == b;
            still &= stands && a.coc == [0.0; 2];
            // Where it stands, both ends are `a`.
            let ends = if stands { [*a; 2] } else { [a.between(b, part(from)), a.between(b, part(to))] };
            for extent in &ends[usize::from(stands)..] {
                held = lesser(held, extent.through(&lens));
                let least = extent.near - extent.near.abs() * ROUNDING_DEPTH;
                near = if least < near { least } else { near };
            }
        }
        Bounds { pixels: to_pixels((held * SIGNS).to_array()), near, still }
    }

    /// Adds what moves on straight lines in camera space, not on the raster: what passes the near plane.
    pub(super) fn add_slices(
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
                let near = both.least.z;
                let held = Extent { in_focus: grown(held, grow_px), coc: [0.0; 2], near };
                self.push(Segment { times, ends: [held; 2] });
            }
        }
    }

    /// The box on the raster that holds it in focus at first, where it is not in front of the near plane.
    pub fn first(&self) -> [f32; 4] {
        self.first.as_ref().map_or(NOWHERE, |segment| segment.ends[0].in_focus)
    }

    /// Its largest width and height at any one time and in focus.
    pub fn size(&self) -> [f32; 2] {
        let ends = self.segments().flat_map(|segment| &segment.ends);
        ends.fold([0.0; 2], |most: [f32; 2], Extent { in_focus: [x0, x1, y0, y1], .. }| {
            [most[0].max(x1 - x0), most[1].max(y1 - y0)]
        })
    }

    /// The box that holds it at all times; upside down for one that is nowhere.
    pub fn whole(&self) -> [f32; 4] {
        let ends = self.segments().flat_map(|segment| &segment.ends);
        ends.fold(NOWHERE, |all, end| union(&all, &end.blurred()))
    }

    /// The time in which it can meet a region of pixels, if it does.
    pub fn meets_region(&self, region: &Region) -> Option<TimeRange> {
        let Region { x0, x1, y0, y1 } = *region;
        self.meets([x0, x1, y0, y1].map(|px| px as f32))
    }

    /// The time in which it can meet the closed rectangle `[x0, x1, y0, y1]`, if it does.
    pub fn meets(&self, rectangle: [f32; 4]) -> Option<TimeRange> {
        let mut range: Option<TimeRange> = None;
        for Segment { times, ends } in self.segments() {
            let Some(part) = segment_meets([&ends[0].blurred(), &ends[1].blurred()], rectangle) else {
                continue;
            };
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

/// The pixels that a box touches, `[x0, x1, y0, y1]`, inclusive.
#[inline(always)]
pub fn to_pixels(b: [f32; 4]) -> [i32; 4] {
    // Not floor(), which is a call where the processor is not known.
    b.map(|px| {
        let px = px.clamp(-2e9, 2e9);
        let whole = px as i32;
        whole - i32::from(whole as f32 > px)
    })
}

/// The box that holds both.
pub(super) fn union(a: &[f32; 4], b: &[f32; 4]) -> [f32; 4] {
    [a[0].min(b[0]), a[1].max(b[1]), a[2].min(b[2]), a[3].max(b[3])]
}

/// A box larger by so much on each side.
pub(super) fn grown(b: [f32; 4], by: f32) -> [f32; 4] {
    [b[0] - by, b[1] + by, b[2] - by, b[3] + by]
}

/// Parts into which the time between two keys is cut for what passes the near plane.
const SLICES: usize = 16;

/// A little more than 1/32768 of the shutter.
const ROUNDING_TIME: f32 = 1e-4;

/// More than the rounding of a depth between two others, relative to it.
const ROUNDING_DEPTH: f32 = 1e-6;

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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn sweep_of(boxes: &[[f32; 4]], key_times: &[f32]) -> Sweep {
        let extent = |&in_focus: &[f32; 4]| Extent { in_focus, coc: [0.0; 2], near: 1.0 };
        Sweep::of_keys(&boxes.iter().map(extent).collect::<Vec<_>>(), key_times)
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
    fn pixels_are_floors() {
        for px in
            [0.0, -0.0, 0.5, -0.5, -1.0, 1.0, 7.999, -8.001, 1e8, -1e8, 3e9, -3e9, f32::INFINITY, f32::NAN]
        {
            assert_eq!(to_pixels([px; 4]), [px.floor().clamp(-2e9, 2e9) as i32; 4], "{px}");
        }
    }

    #[test]
    fn keys_divide_the_time() {
        let boxes = [[0.0, 1.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0], [10.0, 11.0, 0.0, 1.0]];
        let sweep = sweep_of(&boxes, &[0.0, 0.75, 1.0]);
        let [from, to] = sweep.meets([10.0, 12.0, 0.0, 1.0]).expect("at the end");
        assert!((from - 0.975).abs() < 1e-3 && to == 1.0, "{from} {to}");
    }

    fn range(t15: [i16; 2], u15: [i16; 2]) -> StratumBounds {
        StratumBounds { t15, u15, v15: u15 }
    }

    #[test]
    fn a_range_of_time_and_lens_is_bounded_by_its_ends() {
        let end = |x: f32, coc: [f32; 2], near: f32| Extent { in_focus: [x, x + 1.0, 0.0, 1.0], coc, near };
        let sweep = Sweep::of_keys(&[end(0.0, [-4.0, 1.5], 5.0), end(100.0, [0.0, 1.5], 3.0)], &[0.0, 1.0]);
        let open = sweep.over(&range([0, 0], [0, 0]));
        assert_eq!((open.pixels, open.still), ([0, 1, 0, 1], false));
        assert!((open.near - 5.0).abs() < 1e-3);
        // Behind the focus to the right, in front of it to the left.
        let right = sweep.over(&range([0, 0], [16_384, 32_767]));
        assert_eq!(right.pixels, [-4, 2, -4, 2]);
        let late = sweep.over(&range([16_384, 32_767], [0, 0]));
        assert_eq!(late.pixels, [49, 101, 0, 1]);
        assert!((late.near - 3.0).abs() < 1e-3);
    }

    proptest! {
        #[test]
        fn bounds_of_a_part_lie_within_those_of_the_whole(
            keys in prop::collection::vec((-50.0f32..50.0, 0.0f32..9.0, -3.0f32..3.0, 0.0f32..3.0, 0.1f32..9.0), 1..5),
            outer in (0i16..=32_767, 0i16..=32_767, -32_767i16..=32_767, -32_767i16..=32_767),
            inner in (0.0f64..1.0, 0.0f64..1.0, 0.0f64..1.0, 0.0f64..1.0),
        ) {
            let extent = |&(x, size, coc, more, near): &(f32, f32, f32, f32, f32)| {
                Extent { in_focus: [x, x + size, -x, size - x], coc: [coc, coc + more], near }
            };
            let extents: Vec<Extent> = keys.iter().map(extent).collect();
            let last = (extents.len().max(2) - 1) as f32;
            let times: Vec<f32> = (0..extents.len()).map(|key| key as f32 / last).collect();
            let sweep = Sweep::of_keys(&extents, &times);
            let sorted = |a: i16, b: i16| [a.min(b), a.max(b)];
            let whole = range(sorted(outer.0, outer.1), sorted(outer.2, outer.3));
            let part = |[from, to]: [i16; 2], a: f64, b: f64| {
                let at = |t: f64| (f64::from(from) + (f64::from(to) - f64::from(from)) * t) as i16;
                sorted(at(a), at(b))
            };
            let part = range(part(whole.t15, inner.0, inner.1), part(whole.u15, inner.2, inner.3));
            let (whole, part) = (sweep.over(&whole), sweep.over(&part));
            for side in [0, 2] {
                prop_assert!(whole.pixels[side] <= part.pixels[side]);
                prop_assert!(whole.pixels[side + 1] >= part.pixels[side + 1]);
            }
            prop_assert!(whole.near <= part.near);
            prop_assert!(!whole.still || part.still);
        }
    }
}
