//! Pictures of what moves or is out of focus, a feature each, compared with those that were looked at once.

use conformance::goldens::{check, draw};
use conformance::moving::{camera_drives, defocused, deformed, driven};
use conformance::scenes::{self, small};
use olema::Scene;
use olema::scene::Lens;

fn golden(name: &str, scene: &Scene) {
    let image = draw(scene, &small(96, 72, [4, 4])).expect("a picture");
    check(name, &image).unwrap_or_else(|problem| panic!("{problem}"));
}

#[test]
fn what_moves() {
    golden("blur_driven", &driven(scenes::teapot(), [1.2, 0.0, 0.3], 0.0));
    golden("blur_turned", &driven(scenes::teapot(), [0.0; 3], 0.8));
    golden("blur_deformed", &deformed(scenes::teapot()));
    golden("blur_camera", &camera_drives(scenes::teapot(), [0.4, 0.0, -1.5]));
    golden("blur_displaced", &driven(scenes::displaced(), [0.3, 0.0, 0.2], 0.3));
    golden("blur_layers", &driven(scenes::layers(), [0.5, 0.0, 0.2], 0.0));
    golden("blur_near_plane", &driven(scenes::teapot_through_near_plane(), [0.5, -1.0, 0.2], 0.3));
    let mut slow = driven(scenes::teapot(), [2.0, 0.0, 0.0], 0.0);
    slow.camera.shutter_opening = [0.5, 0.5];
    golden("blur_slow_shutter", &slow);
}

#[test]
fn what_is_out_of_focus() {
    golden("focus_near", &defocused(scenes::teapot(), 0.7, 4.0));
    golden("focus_far", &defocused(scenes::teapot(), 0.7, 30.0));
    golden("focus_and_motion", &defocused(driven(scenes::teapot(), [0.6, 0.0, 0.2], 0.2), 1.0, 6.0));
    let mut bladed = defocused(scenes::layers(), 0.5, 12.0);
    bladed.camera.lens = Some(Lens { blades: 5, blade_angle: 90.0, ..Lens::new(0.5, 1.0, 12.0) });
    golden("focus_blades", &bladed);
}
