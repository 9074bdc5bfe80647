//! Scenes that move, are out of focus, or both.

use glam::{DMat4, DVec3};
use olema::Scene;
use olema::scene::{Geometry, Keyed, Lens, Points, Transform};

use crate::scenes;

/// Gives every primitive of a scene a motion: `at` is put next to the world.
pub fn moving(mut scene: Scene, times: &[f32], at: impl Fn(f32) -> DMat4) -> Scene {
    scene.camera.shutter = [0.0, 1.0];
    let keyed = Keyed { times: times.to_vec(), values: times.iter().map(|&t| at(t)).collect() };
    for primitive in &mut scene.primitives {
        primitive.to_world = Transform::from(keyed.clone()).then_of(&primitive.to_world);
    }
    scene
}

/// Puts a lens in front of a scene.
pub fn defocused(mut scene: Scene, fstop: f32, focal_distance: f32) -> Scene {
    scene.camera.lens = Some(Lens::new(fstop, 1.0, focal_distance));
    scene
}

/// A scene that moves by `offset` and turns about z by `turn` radians in the shutter.
pub fn driven(scene: Scene, offset: [f64; 3], turn: f64) -> Scene {
    moving(scene, &[0.0, 1.0], |t| {
        let t = f64::from(t);
        DMat4::from_translation(DVec3::from_array(offset) * t) * DMat4::from_rotation_z(turn * t)
    })
}

/// A scene whose patches change their shape on uneven keys.
pub fn deformed(mut scene: Scene) -> Scene {
    scene.camera.shutter = [0.0, 1.0];
    for primitive in &mut scene.primitives {
        let Geometry::Patches(mesh) = &mut primitive.geometry else { continue };
        let mesh = std::sync::Arc::make_mut(mesh);
        let Points::P(points) = mesh.points.first().clone() else { continue };
        let bent = |amount: f32| {
            Points::P(
                points.iter().map(|&[x, y, z]| [x + amount * z * z * 0.1, y, z + amount * 0.2 * x]).collect(),
            )
        };
        mesh.points = Keyed { times: vec![0.0, 0.3, 1.0], values: vec![bent(0.0), bent(1.0), bent(-0.5)] };
    }
    scene
}

/// A scene seen by a camera that drives by.
pub fn camera_drives(mut scene: Scene, offset: [f64; 3]) -> Scene {
    scene.camera.shutter = [0.0, 1.0];
    let to_camera = scene.camera.world_to_camera.first();
    let at = |t: f64| DMat4::from_translation(DVec3::from_array(offset) * t) * to_camera;
    scene.camera.world_to_camera = Keyed { times: vec![0.0, 1.0], values: vec![at(0.0), at(1.0)] }.into();
    scene
}

/// Scenes in which everything is that rasterizers may disagree about.
pub fn blurred() -> Vec<(&'static str, Scene)> {
    vec![
        ("driven", driven(scenes::teapot(), [0.8, 0.0, 0.1], 0.4)),
        ("deformed", deformed(scenes::teapot())),
        ("defocused", defocused(scenes::teapot(), 2.0, 8.0)),
        ("driven and defocused", defocused(driven(scenes::teapot(), [0.3, 0.2, 0.0], -0.3), 3.0, 9.0)),
        ("layers", defocused(driven(scenes::layers(), [0.4, 0.1, 0.3], 0.2), 2.0, 4.0)),
        ("displaced", defocused(driven(scenes::displaced(), [0.2, 0.0, 0.1], 0.3), 4.0, 5.0)),
        ("through the near plane", driven(scenes::teapot_through_near_plane(), [0.5, -1.0, 0.2], 0.3)),
        ("camera through it all", defocused(camera_drives(scenes::teapot(), [0.0, 0.0, -9.0]), 4.0, 6.0)),
    ]
}
