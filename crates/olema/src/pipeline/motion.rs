//! Motion: the times at which the surfaces of a frame are placed.
//!
//! In: the scene, and which primitives are welded to each other. Out: [`KeyTimes`], for each primitive the key
//! times of its welded surface: those of the file that lie within the shutter, those of the camera, and as many
//! more as curved paths need. Between two keys a vertex moves on a straight line over the raster at constant
//! speed. All that is welded has one set of key times, or shared edges would round differently.

use std::sync::Arc;

use glam::{DMat4, DVec3};

use crate::geometry::RasterCamera;
use crate::scene::{Between, Geometry, Keyed, Points, Primitive, Scene, Transform};
use crate::settings::Settings;

use super::edges::EdgeTable;
use super::patch::PatchTable;
use super::paths::Paths;

/// Parts of the shutter closer than this are one time.
pub(super) const SAME_TIME: f32 = 1e-5;

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

    /// The file's key times, `own` of each primitive, of what is welded together.
    pub fn of_file(own: &[Arc<[f32]>], welded: &[u32]) -> Self {
        let mut times = vec![Vec::new(); own.len()];
        for (own, &first) in own.iter().zip(welded) {
            merge(&mut times[first as usize], own);
        }
        Self::with(&times, welded)
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
        let mut paths = Paths::new(Placer::new(scene), camera, settings.motion_tolerance_px);
        for (ix, &first) in welded.iter().enumerate() {
            let given = self.of(ix as u32);
            if given.len() > 1 {
                let (own, error) = paths.refine(&scene.primitives[ix], given);
                merge(&mut times[first as usize], &own);
                if error > settings.motion_tolerance_px {
                    coarse.push((ix as u32, error));
                }
            }
        }
        (Self::with(&times, welded), coarse)
    }

    /// Of the times of what is welded to each primitive.
    fn with(times: &[Vec<f32>], welded: &[u32]) -> Self {
        let mut sets = vec![vec![0.0]];
        let mut set_of: Vec<Option<u32>> = vec![None; times.len()];
        let mut find = |first: u32| {
            let own = &times[first as usize];
            if own.len() <= 1 {
                return 0;
            }
            let known = sets.iter().position(|set| set == own);
            known.unwrap_or_else(|| {
                sets.push(own.clone());
                sets.len() - 1
            }) as u32
        };
        let of = |&first: &u32| *set_of[first as usize].get_or_insert_with(|| find(first));
        let of_primitive = welded.iter().map(of).collect();
        KeyTimes { sets, of_primitive }
    }
}

/// Adds times to ascending ones.
fn merge(times: &mut Vec<f32>, more: &[f32]) {
    // What is welded mostly has the same.
    if times == more {
        return;
    }
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
    let mut placer = Placer::new(scene);
    times.iter().map(|&t| placer.place(primitive, t)).collect()
}

/// Where a primitive is at part `t` of the shutter.
pub fn placement(scene: &Scene, primitive: &Primitive, t: f32) -> Placement {
    Placer::new(scene).place(primitive, t)
}

/// Finds where primitives are. Those that follow each other mostly share their transformation, which is looked up then.
pub struct Placer<'a> {
    scene: &'a Scene,
    /// The last transformation,
    to_world: Option<&'a Transform>,
    /// and what it is, in camera space, at a few times.
    to_camera: Vec<(f32, DMat4)>,
}

impl<'a> Placer<'a> {
    /// Knows no transformation yet.
    pub fn new(scene: &'a Scene) -> Self {
        Placer { scene, to_world: None, to_camera: Vec::new() }
    }

    /// Where a primitive is at part `t` of the shutter.
    pub fn place(&mut self, primitive: &'a Primitive, t: f32) -> Placement {
        let time = scene_time(self.scene, t);
        let points = match &primitive.geometry {
            Geometry::Patches(mesh) => mesh.points.locate(time),
            Geometry::Subdivision(mesh) => mesh.points.locate(time),
        };
        if !self.to_world.is_some_and(|known| known.is_shared_with(&primitive.to_world)) {
            self.to_world = Some(&primitive.to_world);
            self.to_camera.clear();
        }
        if let Some(&(_, to_camera)) = self.to_camera.iter().find(|known| known.0 == t) {
            return Placement { points, to_camera };
        }
        let to_camera = self.scene.camera.world_to_camera.at(time) * primitive.to_world.at(time);
        if self.to_camera.len() < MOST_PLACED {
            self.to_camera.push((t, to_camera));
        }
        Placement { points, to_camera }
    }
}

/// Times at which a transformation is kept.
const MOST_PLACED: usize = 16;

/// The times at which each primitive or the camera may change its course while the shutter is open, from 0 to 1; none for
/// what stands still.
pub fn own_times(scene: &Scene) -> Vec<Arc<[f32]>> {
    let mut all: Vec<Arc<[f32]>> = Vec::with_capacity(scene.primitives.len());
    let mut before: Option<(&Primitive, Course)> = None;
    for primitive in &scene.primitives {
        let course = Course::of(primitive);
        let is_like = |(other, known): &(&Primitive, Course)| {
            primitive.to_world.is_shared_with(&other.to_world) && *known == course
        };
        all.push(match all.last() {
            Some(last) if before.as_ref().is_some_and(is_like) => Arc::clone(last),
            _ => own_times_of(scene, primitive, course).into(),
        });
        before = Some((primitive, course));
    }
    all
}

/// When the points of a primitive may change their course: at so many keys at these times, or never.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Course<'a>(Option<(&'a [f32], usize)>);

impl<'a> Course<'a> {
    fn of(primitive: &'a Primitive) -> Self {
        fn of<T: PartialEq>(points: &Keyed<T>) -> Course<'_> {
            Course((!points.is_still()).then_some((&points.times, points.values.len())))
        }
        match &primitive.geometry {
            Geometry::Patches(mesh) => of(&mesh.points),
            Geometry::Subdivision(mesh) => of(&mesh.points),
        }
    }
}

fn own_times_of(scene: &Scene, primitive: &Primitive, Course(course): Course) -> Vec<f32> {
    let [open, close] = scene.camera.shutter.map(f64::from);
    if open.partial_cmp(&close) != Some(std::cmp::Ordering::Less) {
        return Vec::new();
    }
    let mut times = vec![0.0, 1.0];
    let mut file: Vec<f32> = scene.camera.world_to_camera.times();
    file.extend(primitive.to_world.times());
    if let Some((point_times, _)) = course {
        file.extend(point_times);
    }
    let inner = file.iter().map(|&time| ((f64::from(time) - open) / (close - open)) as f32);
    times.extend(inner.filter(|t| (SAME_TIME..1.0 - SAME_TIME).contains(t)));
    let mut ascending = Vec::new();
    merge(&mut ascending, &times);
    let placed = placements(scene, primitive, &ascending);
    let stands = |a: &Placement, b: &Placement| {
        a.to_camera == b.to_camera
            && (course.is_none() || a.points.keys == b.points.keys && a.points == b.points)
    };
    if placed.iter().all(|at| stands(at, &placed[0])) { Vec::new() } else { ascending }
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

/// Control point `ix` between two keys, homogeneous; exact at a key.
pub fn blend_point(points: &Keyed<Points>, between: &Between, ix: usize) -> glam::DVec4 {
    let of = |key: usize| match &points.values[key] {
        Points::P(p) => DVec3::from_array(p[ix].map(f64::from)).extend(1.0),
        Points::Pw(p) => glam::DVec4::from_array(p[ix].map(f64::from)),
    };
    let from = of(between.keys[0]);
    if between.part == 0.0 { from } else { from + (of(between.keys[1]) - from) * between.part }
}
