//! Paths: where key times have to be added, as control points move on curves over the raster.
//!
//! In: a primitive and its key times. Out: these and as many more as keep its paths straight within a tolerance.

use glam::{DMat4, DVec3, Vec3};

use crate::geometry::RasterCamera;
use crate::scene::{Geometry, Primitive};

use super::motion::{Placement, Placer, SAME_TIME, blend_point};

/// Key times are halved so often at most between two of the file's.
const MOST_HALVINGS: u32 = 8;

/// Control points of a primitive whose paths are looked at.
const PROBES: usize = 1024;

/// Paths longer than this may be less exact along their direction, in proportion.
const LONG_PX: f32 = 8.0;

/// The paths of primitives' control points over the raster.
pub(super) struct Paths<'a> {
    pub placer: Placer<'a>,
    pub camera: &'a RasterCamera,
    /// How far off a point may be half-way between two keys.
    pub tolerance_px: f32,
}

/// Raster x and y and the circle of confusion of a point.
type Place = [f32; 3];

/// A primitive at a time.
struct Snapshot {
    t: f32,
    /// Its control points, where they are in front of the near plane.
    places: Vec<Option<Place>>,
    /// Box on the raster that holds them, `[x0, x1, y0, y1]`; all of it where one of them is not in front.
    bounds: [f32; 4],
    /// Depths of those in front.
    depth: [f32; 2],
    to_camera: DMat4,
}

impl<'a> Paths<'a> {
    /// Times with more between them where paths are curved, and the greatest error that is left.
    pub fn refine(&mut self, primitive: &'a Primitive, given: &[f32]) -> (Vec<f32>, f32) {
        let mut times = vec![given[0]];
        let mut error = 0.0f32;
        let mut from = self.at(primitive, given[0]);
        for &to in &given[1..] {
            let to = self.at(primitive, to);
            error = error.max(self.halve(primitive, [&from, &to], MOST_HALVINGS, &mut times));
            times.push(to.t);
            from = to;
        }
        (times, error)
    }

    fn halve(
        &mut self,
        primitive: &'a Primitive,
        [from, to]: [&Snapshot; 2],
        left: u32,
        times: &mut Vec<f32>,
    ) -> f32 {
        let middle = self.at(primitive, from.t + (to.t - from.t) * 0.5);
        let error = self.error(from, &middle, to);
        if error <= self.tolerance_px || left == 0 || to.t - from.t < 4.0 * SAME_TIME {
            return error;
        }
        let first = self.halve(primitive, [from, &middle], left - 1, times);
        times.push(middle.t);
        first.max(self.halve(primitive, [&middle, to], left - 1, times))
    }

    /// Greatest distance of a point at the middle from the middle of its places before and after: of control points
    /// no farther than a frame's size from the frame, and of what may be seen of a surface that is larger than that.
    fn error(&self, from: &Snapshot, middle: &Snapshot, to: &Snapshot) -> f32 {
        let mut most = self.error_in_frame(from, middle, to);
        for ((from, place), to) in from.places.iter().zip(&middle.places).zip(&to.places) {
            let (Some(from), Some(place), Some(to)) = (from, place, to) else { continue };
            let matters = (0..2).all(|c| {
                let size = self.camera.frame_px[c];
                place[c] + place[2].abs() >= -size && place[c] - place[2].abs() <= 2.0 * size
            });
            if matters {
                most = most.max(bend(from, place, to));
            }
        }
        most
    }

    /// The same for nine places of the frame, of those between the control points, at the least and the greatest
    /// depth of these: all control points of a ground under a camera that rolls may be far beside the frame.
    fn error_in_frame(&self, from: &Snapshot, middle: &Snapshot, to: &Snapshot) -> f32 {
        let to_object = middle.to_camera.inverse();
        let [x0, x1, y0, y1] = middle.bounds;
        let mut most = 0.0f32;
        for [a, b] in (0..9).map(|ix| [ix % 3, ix / 3].map(|step| step as f32 * 0.5)) {
            let at = [a * self.camera.frame_px[0], b * self.camera.frame_px[1]];
            if !((x0..=x1).contains(&at[0]) && (y0..=y1).contains(&at[1])) {
                continue;
            }
            for z in middle.depth {
                let p = to_object.transform_point3(self.camera.point_at(at, z).as_dvec3());
                let places = [from, middle, to].map(|snapshot| self.place(&snapshot.to_camera, p));
                if let [Some((from, _)), Some((place, _)), Some((to, _))] = places {
                    most = most.max(bend(&from, &place, &to));
                }
            }
        }
        most
    }

    /// Where a point of the object is and how deep, if it is in front of the near plane.
    fn place(&self, to_camera: &DMat4, p: DVec3) -> Option<(Place, f32)> {
        let p: Vec3 = to_camera.transform_point3(p).as_vec3();
        let [x, y] = self.camera.fast_px(p)?;
        Some(([x, y, self.camera.lens.map_or(0.0, |lens| lens.coc_px(p.z))], p.z))
    }

    fn at(&mut self, primitive: &'a Primitive, t: f32) -> Snapshot {
        let Placement { points, to_camera } = self.placer.place(primitive, t);
        let mut snapshot =
            Snapshot { t, places: Vec::new(), bounds: NOWHERE, depth: [f32::INFINITY, 0.0], to_camera };
        match &primitive.geometry {
            Geometry::Patches(mesh) => {
                let stride = mesh.points.first().len().div_ceil(PROBES).max(1);
                let len = points.keys.map(|key| mesh.points.values[key].len());
                let len = len[0].min(len[1]);
                snapshot.places.reserve_exact(len.div_ceil(stride));
                for ix in (0..len).step_by(stride) {
                    let p = blend_point(&mesh.points, &points, ix);
                    let p = if p.w == 1.0 { p.truncate() } else { p.truncate() / p.w };
                    snapshot.add(self.place(&to_camera, p));
                }
            }
            Geometry::Subdivision(mesh) => {
                let [from, to] = points.keys.map(|key| &mesh.points.values[key]);
                let stride = from.len().div_ceil(PROBES).max(1);
                snapshot.places.reserve_exact(from.len().div_ceil(stride));
                for (from, to) in from.iter().zip(to).step_by(stride) {
                    let [from, to] = [from, to].map(|p| DVec3::from_array(p.map(f64::from)));
                    snapshot.add(self.place(&to_camera, from + (to - from) * points.part));
                }
            }
        }
        snapshot
    }
}

const NOWHERE: [f32; 4] = [f32::INFINITY, f32::NEG_INFINITY, f32::INFINITY, f32::NEG_INFINITY];
const EVERYWHERE: [f32; 4] = [f32::NEG_INFINITY, f32::INFINITY, f32::NEG_INFINITY, f32::INFINITY];

impl Snapshot {
    fn add(&mut self, point: Option<(Place, f32)>) {
        self.places.push(point.map(|(place, _)| place));
        let Some(([x, y, _], z)) = point else {
            self.bounds = EVERYWHERE;
            return;
        };
        let [x0, x1, y0, y1] = self.bounds;
        self.bounds = [x0.min(x), x1.max(x), y0.min(y), y1.max(y)];
        self.depth = [self.depth[0].min(z), self.depth[1].max(z)];
    }
}

/// Distance of a place from the middle of those before and after, or the change of its circle of confusion alike.
/// Along a long path it counts for less: the farther something moves, the fainter is what it leaves anywhere.
fn bend(from: &Place, middle: &Place, to: &Place) -> f32 {
    let [x, y, coc]: [f32; 3] = std::array::from_fn(|c| middle[c] - (from[c] + to[c]) * 0.5);
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let length = (dx * dx + dy * dy).sqrt();
    let apart = if length > LONG_PX {
        let (along, across) = ((x * dx + y * dy).abs() / length, (x * dy - y * dx).abs() / length);
        across.max(along * (LONG_PX / length))
    } else {
        (x * x + y * y).sqrt()
    };
    apart.max(coc.abs())
}
