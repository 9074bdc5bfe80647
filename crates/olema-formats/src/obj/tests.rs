use olema::geometry::subdivision::LimitSurface;
use olema::scene::{BoundaryRule, CreaseMethod, FaceVaryingRule};
use proptest::prelude::*;

use super::*;

const QUADS: &str = "\
# two quads
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 2 0 0 1.0
v 2 1 \\
0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
g left
f 1/1 2/2 3/3 4/4
g right
usemtl red
f -5/1/1 -2/2 -1/3 -4/4
t crease 2/1/0 1 2 2.5
t corner 2/1/0 0 3 10
t hole 1/0/0 1
t interpolateboundary 1/0/0 1
t facevaryinginterpolateboundary 1/0/0 2
t facevaryingpropagatecorners 1/0/0 1
t creasemethod 0/0/1 chaikin
";

#[test]
fn reads_faces_groups_and_tags() {
    let (obj, diagnostics) = read("quads.obj", QUADS.as_bytes());
    assert_eq!(diagnostics.len(), 1, "{diagnostics:?}");
    assert_eq!((diagnostics[0].line, diagnostics[0].column), (17, 1), "the vn that is not there");
    assert_eq!(obj.positions[5], [2.0, 1.0, 0.0]);
    assert_eq!(obj.face_counts, [4, 4]);
    let positions: Vec<i32> = obj.corners.iter().map(|c| c.position).collect();
    assert_eq!(positions, [0, 1, 2, 3, 1, 4, 5, 2]);
    assert_eq!(obj.groups[1], Group { name: "right".into(), material: "red".into(), first_face: 1 });
    let mesh = obj.subdivision_mesh(Scheme::CatmullClark);
    assert_eq!(mesh.creases[0].vertices, [1, 2]);
    assert_eq!(mesh.corners, [(0, 10.0), (3, 10.0)]);
    assert_eq!((mesh.holes.as_slice(), mesh.boundary), ([1].as_slice(), BoundaryRule::EdgeAndCorner));
    assert_eq!(mesh.face_varying, FaceVaryingRule::CornersPlus2);
    assert_eq!(mesh.crease_method, CreaseMethod::Chaikin);
    assert_eq!(mesh.vars[0].name, "st");
}

#[test]
fn says_what_is_wrong_and_where() {
    let text = "v 1 x 3\nv 1\nf 1 2 9\nf 0 1 2\nt crease 2/1/0 0\nt vertexedit 0/0/0\ncurv 1\n";
    let (_, diagnostics) = read("bad.obj", text.as_bytes());
    let places: Vec<_> = diagnostics.iter().map(|d| (d.line, d.column)).collect();
    assert_eq!(places, [(1, 5), (2, 3), (4, 3), (5, 3), (6, 3), (7, 1), (3, 1)], "{diagnostics:#?}");
    assert_eq!(diagnostics[0].source_line.as_deref(), Some("v 1 x 3"));
}

#[test]
fn the_name_tells_the_scheme() {
    assert_eq!(scheme_of_name("models/loop_cube.obj"), Some(Scheme::Loop));
    assert_eq!(scheme_of_name("catmark_cube.obj"), Some(Scheme::CatmullClark));
    assert_eq!(scheme_of_name("bilinear_cube.obj"), Some(Scheme::Bilinear));
    assert_eq!(scheme_of_name("loophole.obj"), None);
}

/// Reads, builds and evaluates; returns the number of base quads.
fn exercise(name: &str, bytes: &[u8], scheme: Scheme) -> usize {
    let (obj, _) = read(name, bytes);
    let (surface, _) = LimitSurface::new(obj.subdivision_mesh(scheme).into());
    for quad in 0..surface.num_quads() as u32 {
        let mut evaluator = surface.evaluator(quad);
        let whole = evaluator.bounds(0, [0.0, 1.0], [0.0, 1.0]);
        for (u, v) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.31, 0.77), (0.01, 0.0)] {
            let point = evaluator.evaluate(0, u, v);
            assert!(point.p.is_finite() && point.dp_du.is_finite() && point.dp_dv.is_finite(), "{name}");
            assert!(point.p.cmpge(whole.min).all() && point.p.cmple(whole.max).all(), "{name} {quad}");
            evaluator.normal(0, u, v, &point);
            let mut st = [0.0; 2];
            for var in 0..surface.mesh().vars.len() {
                evaluator.var(var, u, v, &mut st);
            }
        }
    }
    surface.num_quads()
}

/// `OLEMA_OBJ_MODELS=<folder> cargo test -p olema-formats models` reads every OBJ file of a folder.
#[test]
fn every_model_of_a_folder_is_read_and_evaluated() {
    let Some(folder) = std::env::var_os("OLEMA_OBJ_MODELS") else {
        return;
    };
    for entry in std::fs::read_dir(folder).expect("the folder can be read").flatten() {
        let path = entry.path();
        if path.extension().is_none_or(|e| e != "obj") {
            continue;
        }
        let name = path.display().to_string();
        let bytes = std::fs::read(&path).expect("the model can be read");
        let (obj, diagnostics) = read(&name, &bytes);
        let scheme = scheme_of_name(&name).unwrap_or_default();
        let (_, warnings) = LimitSurface::new(obj.subdivision_mesh(scheme).into());
        println!("{name}: {} faces", obj.face_counts.len());
        diagnostics.iter().take(3).for_each(|d| println!("  {d}"));
        warnings.iter().take(3).for_each(|w| println!("  {w}"));
        println!("  {} base quads", exercise(&name, &bytes, scheme));
    }
}

/// Lines that look like OBJ more often than not.
fn line() -> impl Strategy<Value = String> {
    let word = prop_oneof![
        Just("v"),
        Just("vt"),
        Just("f"),
        Just("t"),
        Just("g"),
        Just("crease"),
        Just("corner"),
        Just("hole"),
        Just("1"),
        Just("2"),
        Just("3"),
        Just("-1"),
        Just("4/1"),
        Just("2/1/0"),
        Just("1/0/0"),
        Just("0.5"),
        Just("nan"),
        Just("1e30"),
        Just("99999999999999"),
        Just("\\"),
        Just("#"),
        Just("///"),
    ];
    prop::collection::vec(word, 0..8).prop_map(|words| words.join(" "))
}

proptest! {
    #[test]
    fn no_bytes_make_it_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let (obj, _) = read("x", &bytes);
        let _ = LimitSurface::new(obj.subdivision_mesh(Scheme::CatmullClark).into());
    }

    #[test]
    fn no_statements_make_it_panic(lines in prop::collection::vec(line(), 0..40)) {
        let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\nf 1 2 3\nf 1 3 4\n{}", lines.join("\n"));
        for scheme in [Scheme::CatmullClark, Scheme::Loop, Scheme::Bilinear] {
            let (obj, _) = read("x", text.as_bytes());
            let (surface, _) = LimitSurface::new(obj.subdivision_mesh(scheme).into());
            for quad in 0..surface.num_quads() as u32 {
                surface.evaluator(quad).evaluate(0, 0.3, 0.0);
            }
        }
    }
}
