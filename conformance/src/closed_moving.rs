//! Closed surfaces that move and are out of focus, for the crack test.
//!
//! The surfaces of [`crate::closed`], driven, turned, deformed on uneven keys, before a camera that moves, with a
//! lens or without. Where a surface is made of several primitives, one of them has more key times than the others,
//! and the same path: they touch at all times.

use std::sync::Arc;

use glam::{DMat4, DVec3};
use olema::Scene;
use olema::scene::{Geometry, Keyed, Lens, Points, Transform};

use crate::closed::{KINDS, Random, displace, scene, subdivision_scene};

/// Scene `seed` of the crack test of moving surfaces: meshes and patches, every third one displaced.
pub fn moving_crack_scene(seed: u32) -> Scene {
    let mut made = match seed % 2 {
        0 => scene(KINDS[seed as usize / 2 % KINDS.len()], seed),
        _ => subdivision_scene(seed),
    };
    if seed / 2 % 3 == 2 {
        displace(&mut made, seed, 0.3);
    }
    set_in_motion(&mut made, seed);
    made
}

/// Gives a scene random motions and a random lens; something of it at least.
fn set_in_motion(scene: &mut Scene, seed: u32) {
    let mut random = Random::new(seed ^ 0x0710_0710);
    let open = random.range(-0.5, 0.5) as f32;
    scene.camera.shutter = [open, open + random.range(0.2, 1.0) as f32];
    let which = 1 + random.below(31);
    let has = |bit: u32| which >> bit & 1 == 1;
    // One primitive has keys more than the others.
    let odd = random.below(scene.primitives.len() as u32) as usize;
    let more = [random.range(-0.2, 0.5) as f32, random.range(0.5, 1.2) as f32];
    let mut motion = Transform::default();
    if has(0) {
        motion.concat(&drive(&mut random));
    }
    if has(1) {
        motion.concat(&turn(&mut random, 3.0));
    }
    let finer = refined(&motion, &more);
    for (ix, primitive) in scene.primitives.iter_mut().enumerate() {
        primitive.to_world = if ix == odd { &finer } else { &motion }.then_of(&primitive.to_world);
    }
    if has(2) {
        deform(scene, &mut random, odd, more[0]);
    }
    if has(3) {
        let mut camera = Transform::from(drive(&mut random));
        camera.concat(&turn(&mut random, 0.2));
        scene.camera.world_to_camera = camera.then_of(&scene.camera.world_to_camera);
    }
    if has(4) {
        let (fstop, distance) = (random.range(0.7, 5.0) as f32, random.range(3.0, 12.0) as f32);
        let blades = [0, 5][random.below(2) as usize];
        scene.camera.lens = Some(Lens { blades, ..Lens::new(fstop, 1.0, distance) });
    }
}

/// A translation on two or three keys, some of which may lie outside of the shutter.
fn drive(random: &mut Random) -> Keyed<DMat4> {
    let times = [vec![-0.3, 1.7], vec![0.0, 0.3, 1.0]][random.below(2) as usize].clone();
    let size = [0.05, 0.9][random.below(2) as usize];
    let mut place = |_: &f32| DMat4::from_translation(DVec3::from_array(random.jitter(size)));
    Keyed { values: times.iter().map(&mut place).collect(), times }
}

/// A turn of up to `most` radians about an axis through the origin.
fn turn(random: &mut Random, most: f64) -> Keyed<DMat4> {
    let axis = DVec3::from_array(random.jitter(1.0)).normalize_or(DVec3::Z);
    let turned = DMat4::from_axis_angle(axis, random.range(-most, most));
    Keyed { times: vec![-0.5, 1.5], values: vec![DMat4::IDENTITY, turned] }
}

/// The same path with keys at more times.
fn refined(motion: &Transform, more: &[f32]) -> Transform {
    let mut finer = Transform::default();
    for factor in motion.factors().iter().filter(|factor| !factor.times.is_empty()) {
        let (first, last) = (factor.times[0], factor.times[factor.times.len() - 1]);
        let mut times = factor.times.clone();
        times.extend(more.iter().filter(|time| (first..=last).contains(time)));
        times.sort_by(f32::total_cmp);
        times.dedup();
        let alone = Transform::from((**factor).clone());
        finer.concat(&Keyed { values: times.iter().map(|&t| alone.at(f64::from(t))).collect(), times });
    }
    finer
}

/// Bends all control points on uneven keys, as functions of where they are: what touches goes on touching.
fn deform(scene: &mut Scene, random: &mut Random, odd: usize, more: f32) {
    let bends: [[[f64; 3]; 3]; 3] = std::array::from_fn(|_| std::array::from_fn(|_| random.jitter(0.2)));
    let bent = |key: usize, p: [f32; 3]| {
        let along = DVec3::from_array(p.map(f64::from));
        let offset = bends[key].map(|row| DVec3::from_array(row).dot(along + 0.1 * along * along));
        [0, 1, 2].map(|c| (along[c] + offset[c]) as f32)
    };
    for (ix, primitive) in scene.primitives.iter_mut().enumerate() {
        let more = if ix == odd { &[more][..] } else { &[] };
        match &mut primitive.geometry {
            Geometry::Patches(mesh) => {
                let mesh = Arc::make_mut(mesh);
                let Points::P(points) = mesh.points.first().clone() else { continue };
                let Keyed { times, values } = keyed(&points, bent, more);
                mesh.points = Keyed { times, values: values.into_iter().map(Points::P).collect() };
            }
            Geometry::Subdivision(mesh) => {
                let mesh = Arc::make_mut(mesh);
                mesh.points = keyed(&mesh.points.first().clone(), bent, more);
            }
            _ => {}
        }
    }
}

/// Points on uneven keys, and on one more that lies on their path.
fn keyed(
    points: &[[f32; 3]],
    bent: impl Fn(usize, [f32; 3]) -> [f32; 3],
    more: &[f32],
) -> Keyed<Vec<[f32; 3]>> {
    let mut keyed = Keyed {
        times: vec![-0.6, 0.1, 1.3],
        values: (0..3).map(|key| points.iter().map(|&p| bent(key, p)).collect()).collect(),
    };
    for &time in more {
        let at = keyed.locate(f64::from(time));
        let [from, to]: [&Vec<[f32; 3]>; 2] = at.keys.map(|key| &keyed.values[key]);
        let between = |(a, b): (&[f32; 3], &[f32; 3])| {
            [0, 1, 2].map(|c| (f64::from(a[c]) + f64::from(b[c] - a[c]) * at.part) as f32)
        };
        let value = from.iter().zip(to).map(between).collect();
        if at.part > 0.0 {
            keyed.times.insert(at.keys[1], time);
            keyed.values.insert(at.keys[1], value);
        }
    }
    keyed
}
