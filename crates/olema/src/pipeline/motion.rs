//! Motion: the times at which the surfaces of a frame are placed.
//!
//! In: the scene, and which primitives are welded to each other. Out: [`KeyTimes`], for each primitive the key
//! times of its welded surface: those of the file that lie within the shutter, those of the camera, and as many
//! more as curved paths need. Between two keys a vertex moves on a straight line over the raster at constant
//! speed. All that is welded has one set of key times, or shared edges would round differently.

use glam::{DMat4, DVec3, Vec3};

use crate::geometry::RasterCamera;
use crate::scene::{Between, Geometry, Keyed, Points, Primitive, Scene};
use crate::settings::Settings;

use super::connect::EdgeTable;
use super::patch::PatchTable;

/// Key times are halved so often at most between two of the file's.
const MOST_HALVINGS: u32 = 8;

/// Control points of a primitive whose paths are looked at.
const PROBES: usize = 1024;

/// Paths longer than this may be less exact along their direction, in proportion.
const LONG_PX: f32 = 8.0;

/// Parts of the shutter closer than this are one time.
const SAME_TIME: f32 = 1e-5;

/// Key times of all primitives.
#[derive(Debug, Clone, PartialEq)]
pub struct KeyTimes {
    /// Different sets, ascending from 0 (the shutter begins to open) to 1 (it is closed); the first is a single 0,
    /// for what stands still.
    pub sets: Vec<Vec<f32>>,
    /// The set of each primitive.
    pub of_primitive: Vec<u32>,
}

/// Where a primitive is at a key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Between which keys of its own points.
    pub points: Between,
    /// Object to camera space.
    pub to_camera: DMat4,
}

impl KeyTimes {
    /// Nothing moves.
    pub fn still(scene: &Scene) -> Self {
        KeyTimes { sets: vec![vec![0.0]], of_primitive: vec![0; scene.primitives.len()] }
    }

    /// The times of a primitive.
    pub fn of(&self, primitive: u32) -> &[f32] {
        &self.sets[self.of_primitive[primitive as usize] as usize]
    }

    /// Whether anything moves.
    pub fn any_moves(&self) -> bool {
        self.of_primitive.iter().any(|&set| set != 0)
    }

    /// The file's key times of what is welded together.
    pub fn of_file(scene: &Scene, welded: &[u32]) -> Self {
        let mut times = vec![Vec::new(); scene.primitives.len()];
        for (primitive, &first) in scene.primitives.iter().zip(welded) {
            let own = own_times(scene, primitive);
            merge(&mut times[first as usize], &own);
        }
        Self::with(welded.iter().map(|&first| times[first as usize].clone()))
    }

    /// Adds times where paths are curved by more than the settings allow, and says of which surfaces they are still
    /// (primitive and error in pixels).
    pub fn refined(
        &self,
        scene: &Scene,
        camera: &RasterCamera,
        settings: &Settings,
        welded: &[u32],
    ) -> (Self, Vec<(u32, f32)>) {
        let mut times = vec![Vec::new(); scene.primitives.len()];
        let mut coarse = Vec::new();
        for (ix, &first) in welded.iter().enumerate() {
            let given = self.of(ix as u32);
            if given.len() > 1 {
                let paths = Paths::new(scene, camera, settings, &scene.primitives[ix]);
                let (own, error) = paths.refine(given);
                merge(&mut times[first as usize], &own);
                if error > settings.motion_tolerance_px {
                    coarse.push((ix as u32, error));
                }
            }
        }
        (Self::with(welded.iter().map(|&first| times[first as usize].clone())), coarse)
    }

    fn with(times: impl Iterator<Item = Vec<f32>>) -> Self {
        let mut all = KeyTimes { sets: vec![vec![0.0]], of_primitive: Vec::new() };
        for own in times {
            let own = if own.len() > 1 { own } else { vec![0.0] };
            let known = all.sets.iter().position(|set| *set == own);
            all.of_primitive.push(known.unwrap_or_else(|| {
                all.sets.push(own);
                all.sets.len() - 1
            }) as u32);
        }
        all
    }
}

/// Adds times to ascending ones.
fn merge(times: &mut Vec<f32>, more: &[f32]) {
    times.extend_from_slice(more);
    times.sort_by(f32::total_cmp);
    times.dedup_by(|after, before| *after - *before < SAME_TIME);
    // The end stays exact where a time just before it came first.
    if let Some(last) = times.last_mut()
        && *last > 1.0 - SAME_TIME
    {
        *last = 1.0;
    }
}

/// The scene's time at part `t` of the shutter.
pub fn scene_time(scene: &Scene, t: f32) -> f64 {
    let [open, close] = scene.camera.shutter.map(f64::from);
    open + (close - open) * f64::from(t)
}

/// Where a primitive is at some key times.
pub fn placements(scene: &Scene, primitive: &Primitive, times: &[f32]) -> Vec<Placement> {
    times.iter().map(|&t| placement(scene, primitive, t)).collect()
}

/// Where a primitive is at part `t` of the shutter.
pub fn placement(scene: &Scene, primitive: &Primitive, t: f32) -> Placement {
    let time = scene_time(scene, t);
    let points = match &primitive.geometry {
        Geometry::Patches(mesh) => mesh.points.locate(time),
        Geometry::Subdivision(mesh) => mesh.points.locate(time),
    };
    let to_camera = scene.camera.world_to_camera.at(time) * primitive.to_world.at(time);
    Placement { points, to_camera }
}

/// The times at which a primitive or the camera may change its course while the shutter is open, from 0 to 1; none
/// for what stands still.
fn own_times(scene: &Scene, primitive: &Primitive) -> Vec<f32> {
    let [open, close] = scene.camera.shutter.map(f64::from);
    if open.partial_cmp(&close) != Some(std::cmp::Ordering::Less) {
        return Vec::new();
    }
    let (points_still, point_times) = match &primitive.geometry {
        Geometry::Patches(mesh) => (is_still(&mesh.points), &mesh.points.times),
        Geometry::Subdivision(mesh) => (is_still(&mesh.points), &mesh.points.times),
    };
    let mut times = vec![0.0, 1.0];
    let mut file: Vec<f32> = scene.camera.world_to_camera.times();
    file.extend(primitive.to_world.times());
    if !points_still {
        file.extend(point_times);
    }
    let inner = file.iter().map(|&time| ((f64::from(time) - open) / (close - open)) as f32);
    times.extend(inner.filter(|t| (SAME_TIME..1.0 - SAME_TIME).contains(t)));
    let mut ascending = Vec::new();
    merge(&mut ascending, &times);
    let placed = placements(scene, primitive, &ascending);
    let stands = |a: &Placement, b: &Placement| {
        a.to_camera == b.to_camera && (points_still || a.points.keys == b.points.keys && a.points == b.points)
    };
    if placed.iter().all(|at| stands(at, &placed[0])) { Vec::new() } else { ascending }
}

fn is_still<T: PartialEq>(points: &Keyed<T>) -> bool {
    points.is_still()
}

/// For each primitive the first of those that it is welded to, by corners that their patches share.
pub fn welded(scene: &Scene, patches: &PatchTable, edges: &EdgeTable) -> Vec<u32> {
    let mut parent: Vec<u32> = (0..scene.primitives.len() as u32).collect();
    fn root(parent: &mut [u32], mut ix: u32) -> u32 {
        while parent[ix as usize] != ix {
            parent[ix as usize] = parent[parent[ix as usize] as usize];
            ix = parent[ix as usize];
        }
        ix
    }
    for patch in &patches.patches {
        for &corner in &patch.corners {
            let owner = patches.patches[edges.corners[corner as usize].owner as usize].primitive;
            let (a, b) = (root(&mut parent, owner), root(&mut parent, patch.primitive));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    (0..parent.len() as u32).map(|ix| root(&mut parent, ix)).collect()
}

/// The paths of a primitive's control points over the raster.
struct Paths<'a> {
    scene: &'a Scene,
    camera: &'a RasterCamera,
    primitive: &'a Primitive,
    tolerance_px: f32,
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
    fn new(
        scene: &'a Scene,
        camera: &'a RasterCamera,
        settings: &Settings,
        primitive: &'a Primitive,
    ) -> Self {
        Paths { scene, camera, primitive, tolerance_px: settings.motion_tolerance_px }
    }

    /// Times with more between them where paths are curved, and the greatest error that is left.
    fn refine(&self, given: &[f32]) -> (Vec<f32>, f32) {
        let mut times = vec![given[0]];
        let mut error = 0.0f32;
        let mut from = self.at(given[0]);
        for &to in &given[1..] {
            let to = self.at(to);
            error = error.max(self.halve(&from, &to, MOST_HALVINGS, &mut times));
            times.push(to.t);
            from = to;
        }
        (times, error)
    }

    fn halve(&self, from: &Snapshot, to: &Snapshot, left: u32, times: &mut Vec<f32>) -> f32 {
        let middle = self.at(from.t + (to.t - from.t) * 0.5);
        let error = self.error(from, &middle, to);
        if error <= self.tolerance_px || left == 0 || to.t - from.t < 4.0 * SAME_TIME {
            return error;
        }
        let first = self.halve(from, &middle, left - 1, times);
        times.push(middle.t);
        first.max(self.halve(&middle, to, left - 1, times))
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
        let [x, y] = self.camera.fixed(p).and(Some(self.camera.project(p)))?;
        Some(([x, y, self.camera.lens.map_or(0.0, |lens| lens.coc_px(p.z))], p.z))
    }

    fn at(&self, t: f32) -> Snapshot {
        let Placement { points, to_camera } = placement(self.scene, self.primitive, t);
        let mut snapshot =
            Snapshot { t, places: Vec::new(), bounds: NOWHERE, depth: [f32::INFINITY, 0.0], to_camera };
        match &self.primitive.geometry {
            Geometry::Patches(mesh) => {
                let stride = mesh.points.first().len().div_ceil(PROBES).max(1);
                let len = points.keys.map(|key| mesh.points.values[key].len());
                for ix in (0..len[0].min(len[1])).step_by(stride) {
                    let p = blend_point(&mesh.points, &points, ix);
                    snapshot.add(self.place(&to_camera, p.truncate() / p.w));
                }
            }
            Geometry::Subdivision(mesh) => {
                let [from, to] = points.keys.map(|key| &mesh.points.values[key]);
                let stride = from.len().div_ceil(PROBES).max(1);
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

/// Control point `ix` between two keys, homogeneous; exact at a key.
pub fn blend_point(points: &Keyed<Points>, between: &Between, ix: usize) -> glam::DVec4 {
    let of = |key: usize| match &points.values[key] {
        Points::P(p) => DVec3::from_array(p[ix].map(f64::from)).extend(1.0),
        Points::Pw(p) => glam::DVec4::from_array(p[ix].map(f64::from)),
    };
    let from = of(between.keys[0]);
    if between.part == 0.0 { from } else { from + (of(between.keys[1]) - from) * between.part }
}
