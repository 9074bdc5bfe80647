//! Three moving scenes to measure occlusion culling on, at 1080p: an army (coarse occluders, much motion),
//! sticks (fine, some) and a city (of all sizes, little).
//!
//! In: nothing, or how far things move. Out: scenes with two motion keys a primitive, at times 0 and 1. They
//! stand for STICKS, ARMY and ZINKIA of Boulos 2010, figure 5, whose motion (350, 40 and 10 pixels) and depth
//! complexity (11, 4 and 6) they have, as a test of `conformance` measures:
//!
//! - *depth complexity*: surfaces that a sample hits, front and back, nothing culled, mean over the samples
//!   that hit any;
//! - *motion*: pixels between the places at times 0 and 1 of what a sample hits, mean over all hits.

use std::sync::Arc;

use glam::{DMat4, DVec3};

use super::build::{Random, add_lights, bilinear, camera, surface};
use crate::scene::{
    Attributes, Geometry, Keyed, Origin, PatchBasis, PatchKind, PatchMesh, Points, Primitive, Scene,
};
use crate::settings::Settings;

/// Width and height that motion is stated for.
pub const RESOLUTION: [u32; 2] = [1920, 1080];

/// 1080p, 16 samples a pixel, in tiles of 2 x 2.
pub fn settings() -> Settings {
    Settings { resolution: RESOLUTION, samples: [4, 4], pattern_tile: Some(2), ..Settings::default() }
}

/// Pixels of one unit across at distance 1, for a vertical field of view in degrees.
fn focal_px(fov: f64) -> f64 {
    f64::from(RESOLUTION[1]) / 2.0 / (fov.to_radians() / 2.0).tan()
}

/// Rows of soldiers that march across the picture, `motion_px` pixels on the mean while the shutter is open
/// (350 in the paper's table, up to 1300 elsewhere).
///
/// Fifteen rows, one behind the other; limbs are closed tubes, so that each soldier is hit twice or more.
pub fn army(motion_px: f64) -> Scene {
    const ROWS: u32 = 15;
    const FOV: f64 = 35.0;
    let mut random = Random::new(11);
    let mut scene = Scene::new(camera([0.0, -7.5, 2.3], [0.0, 6.0, 0.75], FOV as f32));
    scene.camera.shutter = [0.0, 1.0];
    let looks = looks(&mut scene, &[[0.6, 0.5, 0.4], [0.35, 0.4, 0.3], [0.5, 0.2, 0.15]]);
    let limbs = soldier();
    let mut places = Vec::new();
    for row in 0..ROWS {
        let depth = 0.95 * f64::from(row);
        // As wide as the frame, and a little more for what marches in.
        let half = 0.58 * (depth + 7.5) + 0.3;
        let mut x = -half + random.range(0.0, 0.5);
        while x < half {
            places.push([x + random.range(-0.1, 0.1), depth + random.range(-0.12, 0.12)]);
            x += 0.91;
        }
    }
    // Hits weigh a soldier by its area, which falls with the square of the distance.
    let weigh = |power: i32| places.iter().map(|p| (p[1] + 7.5).powi(-power)).sum::<f64>();
    // An eighth more, as the ground that is seen between them stands still.
    let step = 1.12 * motion_px / (focal_px(FOV) * weigh(3) / weigh(2));
    for (ix, [x, y]) in places.into_iter().enumerate() {
        let turn = DMat4::from_rotation_z(random.range(-0.2, 0.2)) * DMat4::from_scale(DVec3::splat(1.0));
        let at = |t: f64| DMat4::from_translation(DVec3::new(x + step * (t - 0.5), y, 0.0)) * turn;
        for (limb, geometry) in limbs.iter().enumerate() {
            add_moving(&mut scene, geometry.clone(), at, &looks[(ix + limb) % looks.len()]);
        }
    }
    add_ground(&mut scene, -7.5, 60.0, DVec3::ZERO, &looks[1]);
    scene
}

/// A ground of many patches that moves by 10 pixels, seen from above: nothing hides anything.
pub fn open() -> Scene {
    const FOV: f64 = 40.0;
    let mut scene = Scene::new(camera([0.0, -0.01, 10.0], [0.0; 3], FOV as f32));
    scene.camera.shutter = [0.0, 1.0];
    let looks = looks(&mut scene, &[[0.5, 0.6, 0.4], [0.6, 0.5, 0.4]]);
    let step = 10.0 * 10.0 / focal_px(FOV);
    for [i, j] in (0..24 * 14).map(|ix| [ix % 24, ix / 24]) {
        let corner = |a: u32, b: u32| [(i + a) as f32 * 0.6 - 7.2, (j + b) as f32 * 0.6 - 4.2, 0.0];
        let geometry = bilinear([corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)]);
        let at = |t: f64| DMat4::from_translation(DVec3::new(step * (t - 0.5), 0.0, 0.0));
        add_moving(&mut scene, geometry, at, &looks[(i + j) as usize % looks.len()]);
    }
    scene
}

/// The limbs of a soldier, 1.8 high, feet at the origin, broad along x.
fn soldier() -> Vec<Geometry> {
    let mut limbs = vec![
        // Torso and coat, head, helmet, shield.
        tube([0.0, 0.0], [[0.55, 0.34], [0.9, 0.33], [1.25, 0.42], [1.5, 0.12]], 0.62),
        tube([0.0, 0.0], [[1.46, 0.05], [1.52, 0.17], [1.72, 0.17], [1.8, 0.02]], 1.0),
        tube([0.0, 0.0], [[1.66, 0.2], [1.68, 0.18], [1.84, 0.14], [1.88, 0.01]], 1.0),
        tube([0.1, -0.3], [[0.35, 0.05], [0.5, 0.36], [1.1, 0.36], [1.3, 0.05]], 0.12),
    ];
    for side in [-1.0, 1.0] {
        limbs.push(tube([0.16 * side, 0.0], [[0.0, 0.12], [0.2, 0.1], [0.45, 0.15], [0.65, 0.13]], 1.0));
        limbs.push(tube([0.4 * side, 0.0], [[0.7, 0.07], [0.9, 0.08], [1.2, 0.11], [1.42, 0.06]], 1.0));
    }
    limbs
}

/// Thin upright sticks at many distances that all drift by `motion_px` pixels (40 in the paper's table).
pub fn sticks(motion_px: f64) -> Scene {
    const FOV: f64 = 40.0;
    let mut random = Random::new(23);
    let mut scene = Scene::new(camera([0.0, 0.0, 0.0], [0.0, 1.0, 0.0], FOV as f32));
    scene.camera.shutter = [0.0, 1.0];
    let looks = looks(&mut scene, &[[0.7, 0.55, 0.3], [0.4, 0.6, 0.3], [0.3, 0.4, 0.6], [0.8, 0.75, 0.7]]);
    let px = |distance: f64| distance / focal_px(FOV);
    for ix in 0..410 {
        let distance = random.range(6.0, 12.0);
        let (radius, length) = (21.0 * px(distance), 380.0 * px(distance));
        let reach = [1060.0, 640.0].map(|half| half * px(distance));
        let place =
            DVec3::new(random.range(-reach[0], reach[0]), distance, random.range(-reach[1], reach[1]));
        let heights = [-0.5, -0.48, 0.48, 0.5].map(|z| z * length);
        let shape = tube(
            [0.0; 2],
            [
                [heights[0], 0.3 * radius],
                [heights[1], radius],
                [heights[2], radius],
                [heights[3], 0.3 * radius],
            ],
            1.0,
        );
        let lean = DMat4::from_rotation_y(random.range(-0.06, 0.06));
        // One direction for all, with some of their own.
        let turn: f64 = 0.3 + random.range(-0.15, 0.15);
        let step = DVec3::new(turn.cos(), 0.0, turn.sin()) * px(distance) * motion_px;
        let at = |t: f64| DMat4::from_translation(place + step * (t - 0.5)) * lean;
        add_moving(&mut scene, shape, at, &looks[ix % looks.len()]);
    }
    scene
}

/// Blocks of houses of all heights with trees and posts before them, seen from above the street by a camera
/// that drives on: `motion_px` pixels on the mean (10 in the paper's table).
pub fn city(motion_px: f64) -> Scene {
    const FOV: f64 = 50.0;
    let mut random = Random::new(37);
    let mut scene = Scene::new(camera([1.0, -6.0, 3.3], [1.6, 20.0, 1.3], FOV as f32));
    scene.camera.shutter = [0.0, 1.0];
    let looks = looks(&mut scene, &[[0.6, 0.55, 0.5], [0.55, 0.35, 0.3], [0.5, 0.5, 0.6], [0.25, 0.4, 0.2]]);
    // The camera's way is put into the things: they come towards it and to the left.
    let step = DVec3::new(-0.007, -0.021, 0.0) * motion_px;
    let at = move |place: DVec3, size: DVec3| {
        move |t: f64| DMat4::from_translation(place + step * (t - 0.5)) * DMat4::from_scale(size)
    };
    for block in 0..30 * 21 {
        let (column, row) = (f64::from(block % 21) - 10.0, f64::from(block / 21));
        let place = DVec3::new(column * 3.0 + 0.6, row * 2.6 - 2.0, 0.0);
        // Squares, and what is out of sight.
        if random.below(20) < 8 || place.x.abs() > 0.75 * (place.y + 9.0) {
            continue;
        }
        let size = DVec3::new(random.range(1.5, 2.3), random.range(1.4, 2.1), random.range(1.0, 3.4));
        for face in house() {
            add_moving(&mut scene, face, at(place, size), &looks[block as usize % 3]);
        }
        for _ in 0..2 {
            let beside = DVec3::new(random.range(-1.3, -0.9), random.range(-1.2, 1.2), 0.0);
            let crown = DVec3::splat(random.range(0.6, 1.2));
            for part in tree() {
                add_moving(&mut scene, part, at(place + beside, crown), &looks[3]);
            }
        }
    }
    add_ground(&mut scene, -6.0, 150.0, step, &looks[0]);
    scene
}

/// Four walls and a roof over [-0.5, 0.5]^2 x [0, 1].
fn house() -> [Geometry; 5] {
    let wall = |from: [f32; 2], to: [f32; 2]| {
        let corner = |p: [f32; 2], z: f32| [p[0], p[1], z];
        bilinear([corner(from, 0.0), corner(to, 0.0), corner(from, 1.0), corner(to, 1.0)])
    };
    let [a, b, c, d] = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
    let roof = bilinear([[-0.5, -0.5, 1.0], [0.5, -0.5, 1.0], [-0.5, 0.5, 1.0], [0.5, 0.5, 1.0]]);
    [wall(a, b), wall(b, c), wall(c, d), wall(d, a), roof]
}

/// A trunk and a crown, about 1.2 high.
fn tree() -> [Geometry; 2] {
    [
        tube([0.0; 2], [[0.0, 0.06], [0.2, 0.05], [0.4, 0.05], [0.5, 0.05]], 1.0),
        tube([0.0; 2], [[0.4, 0.02], [0.45, 0.6], [1.1, 0.5], [1.25, 0.02]], 1.0),
    ]
}

/// A tube around the line (x, y): four bicubic patches whose profile has the given heights and radii; `flat` is
/// its depth over its width.
fn tube([x, y]: [f64; 2], profile: [[f64; 2]; 4], flat: f64) -> Geometry {
    /// Control points of a quarter circle, the last left to the next quarter.
    const ARC: [[f64; 2]; 3] = [[1.0, 0.0], [1.0, 0.552_284_749_831], [0.552_284_749_831, 1.0]];
    let mut points = Vec::with_capacity(48);
    for [height, radius] in profile {
        for quarter in 0..4 {
            for [a, b] in ARC {
                let [a, b] = [[a, b], [-b, a], [-a, -b], [b, -a]][quarter];
                points.push([x + radius * a, y + radius * b * flat, height].map(|c| c as f32));
            }
        }
    }
    Geometry::Patches(Arc::new(PatchMesh {
        kind: Arc::new(PatchKind::Bicubic { u: PatchBasis::BEZIER, v: PatchBasis::BEZIER }),
        nu: 12,
        nv: 4,
        wrap_u: true,
        wrap_v: false,
        points: Keyed::still(Points::P(points)),
        vars: Vec::new(),
    }))
}

fn looks(scene: &mut Scene, colors: &[[f32; 3]]) -> Vec<Arc<Attributes>> {
    let lights = add_lights(scene, [3.0, -4.0, 6.0]);
    let look = |&color: &[f32; 3]| {
        Arc::new(Attributes {
            color,
            surface: surface("matte"),
            lights: Arc::clone(&lights),
            ..Attributes::default()
        })
    };
    colors.iter().map(look).collect()
}

fn add_moving(scene: &mut Scene, geometry: Geometry, at: impl Fn(f64) -> DMat4, look: &Arc<Attributes>) {
    scene.primitives.push(Primitive {
        geometry,
        to_world: Keyed { times: vec![0.0, 1.0], values: vec![at(0.0), at(1.0)] }.into(),
        attributes: Arc::clone(look),
        origin: Origin::default(),
    });
}

/// A plane at height 0 that moves by `step`, as strips as wide as what a camera `eye_y` before the origin sees.
fn add_ground(scene: &mut Scene, eye_y: f32, far: f32, step: DVec3, look: &Arc<Attributes>) {
    let near = eye_y + 3.5;
    for strip in 0..8 {
        let at = |n: u8| near + (far - near) * (f32::from(n) / 8.0).powi(2);
        let (y0, y1) = (at(strip), at(strip + 1));
        let wide = |y: f32| 0.95 * (y - eye_y);
        let corners = [[-wide(y0), y0, 0.0], [wide(y0), y0, 0.0], [-wide(y1), y1, 0.0], [wide(y1), y1, 0.0]];
        let at = |t: f64| DMat4::from_translation(step * (t - 0.5));
        add_moving(scene, bilinear(corners), at, look);
    }
}
