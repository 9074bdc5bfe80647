//! `olema render` and `olema info` on OBJ models and on subdivision meshes in scenes.

mod common;

use common::{Bench, png_size};

/// A cube with an infinitely sharp ring around its top.
const CUBE: &str = "\
o cube
v -1 -1 -1
v 1 -1 -1
v -1 1 -1
v 1 1 -1
v -1 -1 1
v 1 -1 1
v -1 1 1
v 1 1 1
f 1 3 4 2
f 5 6 8 7
f 1 2 6 5
f 3 7 8 4
f 1 5 7 3
f 2 4 8 6
t crease 5/1/0 2 6 7 3 2 10
";

const SMALL: [&str; 4] = ["--res", "64x48", "--progress", "none"];

fn render(bench: &Bench, args: &[&str]) -> common::Ran {
    bench.run(&[&["render"], args, &SMALL[..]].concat())
}

/// Samples that hit something, of the run that wrote `s.json`.
fn hits(bench: &Bench) -> u64 {
    let stats = std::fs::read_to_string(bench.path("s.json")).unwrap();
    let stats: serde_json::Value = serde_json::from_str(&stats).unwrap();
    stats["frames"][0]["stats"]["sample_hits"].as_u64().unwrap()
}

#[test]
fn a_model_becomes_a_picture_of_its_name() {
    let bench = Bench::new();
    bench.file("cube.v2.obj", CUBE);
    let ran = render(&bench, &["cube.v2.obj", "--stats", "s.json"]);
    assert_eq!((ran.code, ran.out.as_str()), (0, "cube.v2.png\n"), "{}", ran.err);
    assert_eq!(png_size(&bench.path("cube.v2.png")), [64, 48]);
    for words in [
        "note: no camera in cube.v2.obj: looking from (2.701, 2.196, 3.858) at (0.000, 0.000, 0.000), y up",
        "note: cube.v2.obj is drawn as catmark (it has subdivision tags)",
    ] {
        assert!(ran.err.contains(words), "{}", ran.err);
    }
    assert!(hits(&bench) > 1000);
}

#[test]
fn quiet_makes_the_camera_without_a_word() {
    let bench = Bench::new();
    bench.file("cube.obj", CUBE);
    let ran = render(&bench, &["cube.obj", "-q"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
}

#[test]
fn tags_and_schemes_change_the_picture() {
    let bench = Bench::new();
    bench.file("cube.obj", CUBE);
    bench.file("smooth.obj", CUBE.replace("t crease", "# crease"));
    for (file, scheme, out) in [
        ("cube.obj", "catmark", "creased.png"),
        ("smooth.obj", "catmark", "smooth.png"),
        ("cube.obj", "bilinear", "bilinear.png"),
        ("smooth.obj", "bilinear", "smooth_bilinear.png"),
        ("cube.obj", "loop", "loop.png"),
    ] {
        let ran = render(&bench, &[file, "--subdivide", scheme, "-o", out]);
        assert_eq!(ran.code, 0, "{}", ran.err);
        assert!(ran.err.contains(&format!("drawn as {scheme} (as asked)")), "{}", ran.err);
    }
    let differ = |a: &str, b: &str| bench.run(&["diff", a, b, "--tolerance", "8"]).code;
    assert_eq!(differ("creased.png", "smooth.png"), 1);
    assert_eq!(differ("creased.png", "bilinear.png"), 1);
    assert_eq!(differ("creased.png", "loop.png"), 1);
    assert_eq!(differ("bilinear.png", "smooth_bilinear.png"), 0, "faces are flat, creased or not");
    // Without tags a model is drawn as its faces are.
    assert_eq!(render(&bench, &["smooth.obj", "-o", "default.png"]).code, 0);
    assert_eq!(bench.run(&["diff", "smooth_bilinear.png", "default.png"]).code, 0);
    assert_eq!(render(&bench, &["cube.obj", "--subdivide", "butterfly"]).code, 2);
    assert_eq!(render(&bench, &["cube.obj", "--up", "z", "-o", "z.png"]).code, 0);
    assert_eq!(differ("z.png", "creased.png"), 1);
}

#[test]
fn indices_that_name_nothing_are_warned_about_with_their_line() {
    let bench = Bench::new();
    let wrong = CUBE.replace("f 2 4 8 6", "f 2 4 8 66").replace("crease 5/1/0 2 6", "crease 5/1/0 2 60");
    bench.file("cube.obj", wrong);
    let ran = render(&bench, &["cube.obj"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    for words in [
        "cube.obj:15:1",
        "15 | f 2 4 8 66",
        "the face names v 66 of 8; face left out",
        "cube.obj:16:1",
        "the crease names vertex 60 of 8; left out",
    ] {
        assert!(ran.err.contains(words), "{words}: {}", ran.err);
    }
}

#[test]
fn what_is_wrong_with_the_surface_names_object_and_line() {
    let bench = Bench::new();
    bench.file("cube.obj", format!("{CUBE}t crease 2/1/0 0 7 2\n"));
    let ran = render(&bench, &["cube.obj"]);
    assert_eq!(ran.code, 0);
    assert!(ran.err.contains("warning: cube (cube.obj:1): crease 1 names edge 0-7"), "{}", ran.err);
}

#[test]
fn files_without_faces_or_that_are_missing_exit_3() {
    let bench = Bench::new();
    bench.file("points.obj", "v 0 0 0\nv 1 0 0\n");
    let ran = render(&bench, &["points.obj"]);
    assert_eq!(ran.code, 3);
    assert!(ran.err.contains("points.obj: nothing to render: expected faces (f)"), "{}", ran.err);
    let ran = render(&bench, &["no.obj"]);
    assert_eq!(ran.code, 3);
    assert!(ran.err.contains("no.obj"), "{}", ran.err);
    bench.file("wrong.obj", "v 0 0 0\nf 1 2 3\n");
    assert_eq!(render(&bench, &["wrong.obj"]).code, 3);
    assert_eq!(bench.names(), ["points.obj", "wrong.obj"]);
}

#[test]
fn info_tells_what_is_in_a_model() {
    let bench = Bench::new();
    bench.file("cube.obj", CUBE);
    let ran = bench.run(&["info", "cube.obj"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    for words in
        ["1 catmull-clark meshes", "faces           6", "control points  8", "1 plastic", "perspective, 40"]
    {
        assert!(ran.out.contains(words), "{words}: {}", ran.out);
    }
    let ran = bench.run(&["info", "cube.obj", "--json", "--subdivide", "loop", "-q"]);
    let info: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
    let frame = &info["frames"][0];
    assert_eq!(frame["primitives"]["loop meshes"], 1);
    assert_eq!(frame["bounding_box"], serde_json::json!([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]]));
    assert_eq!(bench.names(), ["cube.obj"]);
}

#[test]
fn a_mesh_in_a_scene_is_drawn() {
    let bench = Bench::new();
    let hits = |tags: &str| {
        let scene = format!(
            "Display \"m.png\" \"file\" \"rgba\" Projection \"perspective\" \"fov\" 40\n\
             WorldBegin Surface \"constant\" SubdivisionMesh \"catmull-clark\" [4] [0 1 2 3] {tags}\n\
             \"P\" [-1 -1 4 1 -1 4 1 1 4 -1 1 4] WorldEnd\n"
        );
        bench.file("m.rib", scene);
        let ran = render(&bench, &["m.rib", "--stats", "s.json"]);
        assert_eq!((ran.code, ran.out.as_str()), (0, "m.png\n"), "{}", ran.err);
        hits(&bench)
    };
    let square = hits("[\"interpolateboundary\"] [1 0] [1] []");
    let round = hits("[\"interpolateboundary\"] [1 0] [2] []");
    assert!(0 < round && round < square, "{round} of {square}");
    assert_eq!(hits(""), 0, "border faces are not drawn unless the file says so");
}
