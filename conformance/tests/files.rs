//! Pictures of files, compared with those that were looked at once: a model, and the scenes that come with Olema.

use std::path::Path;
use std::sync::Arc;

use conformance::goldens::{check, draw};
use conformance::scenes::{self, small};
use glam::DMat4;
use olema::scene::{Geometry, Scheme};
use olema::{Scene, Settings};
use olema_formats::obj;
use olema_formats::rib::{ReadOptions, RibFrame, RibReader};

/// An angle with a semi-sharp upper edge and one sharp corner, and an open sheet with a rounded border and a hole beside
/// it. Faces count vertices from the front or from the end, and one comes before its vertices.
const MODEL: &str = "\
f 1 2 8 7
v -1 -1 -0.6
v 1 -1 -0.6
v 1 0 -0.6
v 0 0 -0.6
v 0 1 -0.6
v -1 1 -0.6
v -1 -1 0.6
v 1 -1 0.6
v 1 0 0.6
v 0 0 0.6
v 0 1 0.6
v -1 1 0.6
g angle
f 6 5 4 3 2 1
f 7 8 9 10 11 12
f -11 -10 -4 -5
f 3 4 10 9
f 4 5 11 10
f 5 6 12 11
f 6 1 7 12
t crease 7/1/0 6 7 8 9 10 11 6 2.5
t corner 1/1/0 7 10
o sheet
v 0.3 0.3 -0.4
v 1.5 0.3 -0.5
v 1.5 1.5 0.9
v 0.3 1.5 0.4
v 0.9 0.2 -0.6
v 1.6 0.9 0.1
v 0.9 1.6 0.9
v 0.2 0.9 0
v 0.9 0.9 0.4
f 13 17 21 20
f 17 14 18 21
f 21 18 15 19
f 20 21 19 16
t hole 1/0/0 9
t interpolateboundary 1/0/0 2
";

fn golden(name: &str, scene: &Scene, settings: &Settings) {
    let image = draw(scene, settings).expect("a picture");
    check(name, &image).unwrap_or_else(|problem| panic!("{problem}"));
}

/// All parts of the model.
fn model(scheme: Scheme) -> Scene {
    let (obj, said) = obj::read("model.obj", MODEL.as_bytes(), obj::MEMORY).expect("a model");
    assert_eq!(said, []);
    let mut parts = obj.parts(scheme).into_iter();
    let mut scene = scenes::mesh(parts.next().expect("the angle").mesh);
    let attributes = Arc::clone(&scene.primitives[0].attributes);
    for part in parts {
        let sheet = Geometry::Subdivision(Arc::new(part.mesh));
        scenes::add(&mut scene, sheet, DMat4::IDENTITY, &attributes);
    }
    assert_eq!(scene.primitives.len(), 2);
    scene
}

#[test]
fn a_model_is_drawn_by_the_scheme_that_is_asked_for() {
    let settings = small(96, 72, [4, 4]);
    golden("file_obj_catmark", &model(Scheme::CatmullClark), &settings);
    golden("file_obj_bilinear", &model(Scheme::Bilinear), &settings);
}

/// A scene of the repository, small.
fn scene_file(name: &str, resolution: [u32; 2]) -> RibFrame {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(name);
    let mut reader = RibReader::open(&path, ReadOptions::default()).expect("the scene");
    let mut frame = reader.next_frame().expect("a scene that can be read").expect("a frame");
    assert_eq!(reader.take_diagnostics(), []);
    frame.settings = Settings { resolution, threads: 1, ..frame.settings };
    frame
}

#[test]
fn the_scenes_of_the_repository() {
    for (name, resolution) in [("subdivision", [128, 96]), ("displaced", [128, 80]), ("teapot", [128, 96])] {
        let frame = scene_file(&format!("{name}.rib"), resolution);
        golden(&format!("file_rib_{name}"), &frame.scene, &frame.settings);
    }
}
