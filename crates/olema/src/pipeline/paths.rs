//! Paths: where key times have to be added, as control points move on curves over the raster.
//!
//! In: a primitive and its key times. Out: these and as many more as keep its paths straight within a tolerance.

use glam::{DMat4, DVec3};

use crate::geometry::RasterCamera;
use crate::math::simd::SimdLevel;
use crate::scene::{Geometry, Primitive};

use super::camera_points::ToCamera;
use super::motion::{Placement, Placer, SAME_TIME, blend_point};
use super::raster_paths::{self, Place, Places, bend};

/// Key times are halved so often at most between two of the file's.
const MOST_HALVINGS: u32 = 8;

/// Control points of a primitive whose paths are looked at.
const PROBES: usize = 1024;

/// The paths of primitives' control points over the raster.
pub(super) struct Paths<'a> {
    placer: Placer<'a>,
    camera: &'a RasterCamera,
    /// How far off a point may be half-way between two keys.
    tolerance_px: f32,
    level: SimdLevel,
    /// Lists for snapshots to come.
    spare: Vec<Places>,
    /// Points that are looked at, at two keys, where these are not all of them.
    probes: [Vec<[f32; 3]>; 2],
}

/// A primitive at a time.
struct Snapshot {
    t: f32,
    /// Its control points.
    places: Places,
    to_camera: DMat4,
}

impl<'a> Paths<'a> {
    /// Those of primitives of `placer`'s scene.
    pub fn new(placer: Placer<'a>, camera: &'a RasterCamera, tolerance_px: f32) -> Self {
        let level = SimdLevel::best();
        Paths { placer, camera, tolerance_px, level, spare: Vec::new(), probes: Default::default() }
    }

    /// Times with more between them where paths are curved, and the greatest error that is left.
    pub fn refine(&mut self, primitive: &'a Primitive, given: &[f32]) -> (Vec<f32>, f32) {
        let mut times = vec![given[0]];
        let mut error = 0.0f32;
        let mut from = self.at(primitive, given[0]);
        for &to in &given[1..] {
            let to = self.at(primitive, to);
            error = error.max(self.halve(primitive, [&from, &to], MOST_HALVINGS, &mut times));
            times.push(to.t);
            self.spare.push(std::mem::replace(&mut from, to).places);
        }
        self.spare.push(from.places);
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
        let mut error = self.error(from, &middle, to);
        let is_fine = error <= self.tolerance_px;
        if !is_fine && left > 0 && to.t - from.t >= 4.0 * SAME_TIME {
            let first = self.halve(primitive, [from, &middle], left - 1, times);
            times.push(middle.t);
            error = first.max(self.halve(primitive, [&middle, to], left - 1, times));
        }
        self.spare.push(middle.places);
        error
    }

    /// Greatest distance of a point at the middle from the middle of its places before and after: of control points
    /// no farther than a frame's size from the frame, and of what may be seen of a surface that is larger than that.
    fn error(&self, from: &Snapshot, middle: &Snapshot, to: &Snapshot) -> f32 {
        let places = [from, middle, to].map(|snapshot| &snapshot.places);
        let of_points = raster_paths::greatest_bend(self.level, self.camera, places);
        of_points.max(self.error_in_frame(from, middle, to))
    }

    /// The same for nine places of the frame, of those between the control points, at the least and the greatest
    /// depth of these: all control points of a ground under a camera that rolls may be far beside the frame.
    fn error_in_frame(&self, from: &Snapshot, middle: &Snapshot, to: &Snapshot) -> f32 {
        let [x0, x1, y0, y1] = middle.places.bounds;
        let is_within = |at: &[f32; 2]| (x0..=x1).contains(&at[0]) && (y0..=y1).contains(&at[1]);
        let steps = (0..9).map(|ix| [ix % 3, ix / 3].map(|step| step as f32 * 0.5));
        let frame_px = self.camera.frame_px;
        let mut places = steps.map(|[a, b]| [a * frame_px[0], b * frame_px[1]]).filter(is_within).peekable();
        if places.peek().is_none() {
            return 0.0;
        }
        let to_object = middle.to_camera.inverse();
        let mut most = 0.0f32;
        for at in places {
            for z in middle.places.depth {
                let p = to_object.transform_point3(self.camera.point_at(at, z).as_dvec3());
                let places = [from, middle, to].map(|snapshot| self.place(&snapshot.to_camera, p));
                if let [Some(from), Some(place), Some(to)] = places {
                    most = most.max(bend(from, place, to));
                }
            }
        }
        most
    }

    /// Where a point of the object is, if it is in front of the near plane.
    fn place(&self, to_camera: &DMat4, p: DVec3) -> Option<Place> {
        raster_paths::place(self.camera, to_camera.transform_point3(p).as_vec3())
    }

    fn at(&mut self, primitive: &'a Primitive, t: f32) -> Snapshot {
        let Placement { points, to_camera } = self.placer.place(primitive, t);
        let mut places = self.spare.pop().unwrap_or_default();
        let all = match &primitive.geometry {
            Geometry::Patches(mesh) => match ToCamera::of_sheet(&mesh.points, &points, &to_camera) {
                Some(all) => all,
                None => {
                    let len = points.keys.map(|key| mesh.points.values[key].len());
                    let len = len[0].min(len[1]);
                    let place = |ix| {
                        let p = blend_point(&mesh.points, &points, ix);
                        let p = if p.w == 1.0 { p.truncate() } else { p.truncate() / p.w };
                        to_camera.transform_point3(p).as_vec3()
                    };
                    places.set(self.camera, (0..len).step_by(stride(mesh.points.first().len())).map(place));
                    return Snapshot { t, places, to_camera };
                }
            },
            Geometry::Subdivision(mesh) => ToCamera::new(
                points.keys.map(|key| &mesh.points.values[key][..]),
                Some(points.part),
                &to_camera,
            ),
        };
        let stride = stride(all.len());
        let all = if stride == 1 { all } else { all.picked(stride, &mut self.probes) };
        places.set_all(self.level, self.camera, &all);
        Snapshot { t, places, to_camera }
    }
}

/// Every how many points of so many are looked at.
fn stride(len: usize) -> usize {
    len.div_ceil(PROBES).max(1)
}
