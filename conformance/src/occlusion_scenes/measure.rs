//! What a moving scene is like: its depth complexity and motion.
//!
//! In: a scene. Out: [`Measured`], over the samples of a picture of any size; motion in pixels of 1080p.

use glam::{DMat4, DVec3, Vec3};
use olema::engine::grids;
use olema::geometry::RasterCamera;
use olema::sampling::inside::HitPoint;
use olema::sampling::nomotion::{Facing, GridView, HitSink, SampleCounts, rasterize_grid};
use olema::sampling::{PatternSpec, Region, RegionSamples, SamplePattern};
use olema::scene::{Geometry, Points, Primitive};
use olema::{Error, Scene, Settings};

use super::RESOLUTION;

/// What a scene is like at its first motion key.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Measured {
    /// Share of the samples that hit something.
    pub coverage: f64,
    /// Hits a sample, front and back, nothing culled, mean over the samples that hit something.
    pub depth_complexity: f64,
    /// Pixels at 1080p that what is hit moves from key to key, mean over all hits.
    pub motion_px: f64,
    /// Primitives.
    pub primitives: usize,
    /// Patches.
    pub patches: u64,
}

/// Counts the hits of all samples.
struct Hits(Vec<u32>);

impl HitSink for Hits {
    fn hit(&mut self, sample_ix: usize, _point: HitPoint, _triangle: u8, _sign: i8) {
        self.0[sample_ix] += 1;
    }
}

/// Measures `scene` on a picture of `resolution` with four samples a pixel.
///
/// # Errors
/// What the scene is wrong about.
pub fn measure(scene: &Scene, resolution: [u32; 2]) -> Result<Measured, Error> {
    let pattern = SamplePattern::new(PatternSpec { samples: [2, 2], ..PatternSpec::default() });
    let settings = Settings { resolution, samples: [2, 2], threads: 1, ..Settings::default() };
    let [width, height] = resolution.map(|px| px as i32);
    let samples = RegionSamples::new(&pattern, Region::new(0, width, 0, height));
    let motions: Vec<f64> = scene.primitives.iter().map(|primitive| motion_px(scene, primitive)).collect();
    let mut hits = Hits(vec![0; samples.len()]);
    let mut weighted_motion = 0.0;
    let mut num_hits = 0;
    let stats = grids(scene, &settings, None, |_, grid, _, _| {
        let view = GridView {
            m: grid.m as usize,
            n: grid.n as usize,
            x: &grid.on_raster.x,
            y: &grid.on_raster.y,
            depth: &grid.depth,
        };
        let skip = grid.has_slow().then_some(grid.slow.is_slow.as_slice());
        let mut counts = SampleCounts::default();
        rasterize_grid(view, Facing::Any, skip, &samples, &mut counts, &mut hits);
        weighted_motion += counts.hits as f64 * motions[grid.key.primitive as usize];
        num_hits += counts.hits;
    })?;
    let num_covered = hits.0.iter().filter(|&&hits| hits > 0).count().max(1) as f64;
    Ok(Measured {
        coverage: num_covered / hits.0.len() as f64,
        depth_complexity: num_hits as f64 / num_covered,
        motion_px: weighted_motion / num_hits.max(1) as f64,
        primitives: scene.primitives.len(),
        patches: stats.patches,
    })
}

/// How far the middle of a primitive's control points goes, in pixels at 1080p; 0 where it is behind the eye.
fn motion_px(scene: &Scene, primitive: &Primitive) -> f64 {
    let raster = RasterCamera::new(&scene.camera, RESOLUTION);
    let to_camera = scene.camera.world_to_camera.first();
    let middle = middle_of(&primitive.geometry);
    let place = |to_world: &DMat4| {
        let p: Vec3 = (to_camera * *to_world).transform_point3(middle).as_vec3();
        (p.z > raster.near).then(|| raster.project(p).map(f64::from))
    };
    let ends = scene.camera.shutter.map(|time| primitive.to_world.at(f64::from(time)));
    match (place(&ends[0]), place(&ends[1])) {
        (Some([x0, y0]), Some([x1, y1])) => (x1 - x0).hypot(y1 - y0),
        _ => 0.0,
    }
}

fn middle_of(geometry: &Geometry) -> DVec3 {
    let Geometry::Patches(mesh) = geometry else { return DVec3::ZERO };
    let points: Vec<DVec3> = match mesh.points.first() {
        Points::P(p) => p.iter().map(|p| DVec3::from(p.map(f64::from))).collect(),
        Points::Pw(p) => {
            p.iter().map(|p| DVec3::new(p[0].into(), p[1].into(), p[2].into()) / f64::from(p[3])).collect()
        }
    };
    points.iter().sum::<DVec3>() / points.len().max(1) as f64
}
