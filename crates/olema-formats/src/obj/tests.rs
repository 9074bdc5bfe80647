use olema::geometry::subdivision::LimitSurface;
use olema::scene::{BoundaryRule, CreaseMethod, FaceVaryingRule};
use proptest::prelude::*;

use super::*;

/// What a text that can be read holds.
fn read(name: &str, bytes: &[u8]) -> (Obj, Vec<Diagnostic>) {
    super::read(name, bytes, MEMORY).expect("a file that can be read")
}

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
    assert_eq!(
        obj.groups[1],
        Group { name: "right".into(), material: "red".into(), first_face: 1, line: 16 }
    );
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
fn tags_that_name_nothing_are_left_out_with_their_line() {
    let text = "t crease 2/1/0 0 9 1\nt crease 2/1/0 0 1 1\nt corner 2/1/0 -1 2 1\nt hole 2/0/0 0 5\n\
                v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let (obj, diagnostics) = read("tags.obj", text.as_bytes());
    let said: Vec<_> = diagnostics.iter().map(|d| (d.line, d.message.as_str())).collect();
    let expected = [
        (1, "the crease names vertex 9 of 3; left out"),
        (3, "the corner names vertex -1 of 3; left out"),
        (4, "the hole names face 5 of 1; left out"),
    ];
    assert_eq!(said, expected);
    assert_eq!(obj.tags.creases[0].vertices, [0, 1]);
    assert_eq!((obj.tags.corners.as_slice(), obj.tags.holes.as_slice()), (&[(2, 1.0)][..], &[0][..]));
}

#[test]
fn faces_may_come_before_what_they_name() {
    let text = "f 1/1 2/1 3/2\nf 1 2 4\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n";
    let (obj, diagnostics) = read("early.obj", text.as_bytes());
    let said: Vec<_> =
        diagnostics.iter().map(|d| (d.line, d.message.as_str(), d.source_line.as_deref())).collect();
    let expected = [
        (1, "the face names vt 2 of 1", Some("f 1/1 2/1 3/2")),
        (2, "the face names v 4 of 3; face left out", Some("f 1 2 4")),
    ];
    assert_eq!(said, expected);
    assert_eq!(obj.corners[2], Corner { position: 2, texcoord: -1, normal: -1 });
    assert_eq!(obj.parts(Scheme::Bilinear)[0].mesh.indices, [0, 1, 2]);
}

/// A text, again and again.
struct Endless<'a> {
    text: &'a [u8],
    at: usize,
}

impl std::io::Read for Endless<'_> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        for byte in out.iter_mut() {
            *byte = self.text[self.at];
            self.at = (self.at + 1) % self.text.len();
        }
        Ok(out.len())
    }
}

#[test]
fn files_without_end_are_given_up_at_the_memory_granted() {
    for text in
        ["v 1 2 3\n", "f 1 2 3\n", "vt 0 0\n", "g a\nf 1\n", "usemtl long name\nf 1 1\n", "t hole 1/0/0 1\n"]
    {
        let input = std::io::BufReader::new(Endless { text: text.as_bytes(), at: 0 });
        let Err(ReadError::Fatal(said)) = super::read("endless.obj", input, 1 << 20) else {
            panic!("{text}")
        };
        assert!(
            said.message.contains("the 1048576 bytes granted for a model are used up here"),
            "{text}: {said}"
        );
        assert!(said.line > 100, "{text}: {said}");
    }
    for text in ["1 ", "f 1 2 3 \\\n", "\0"] {
        let input = std::io::BufReader::new(Endless { text: text.as_bytes(), at: 0 });
        let Err(ReadError::Fatal(said)) = super::read("endless.obj", input, MEMORY) else { panic!("{text}") };
        assert!(said.message.contains("has more than 16777216 bytes") && said.line == 1, "{text}: {said}");
    }
}

#[test]
fn a_stream_that_fails_is_told() {
    struct Broken;
    impl std::io::Read for Broken {
        fn read(&mut self, _: &mut [u8]) -> std::io::Result<usize> {
            Err(std::io::Error::other("the cable is cut"))
        }
    }
    let error = super::read("broken.obj", std::io::BufReader::new(Broken), MEMORY).expect_err("an error");
    assert_eq!(error.to_string(), "broken.obj: the cable is cut");
}

#[test]
fn groups_that_share_no_vertex_are_parts() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 0 5\nv 1 0 5\nv 1 1 5\nv 0 1 5\nvt 0 0\nvt 1 1\n\
                o low\nf 1/1 2/2 3/2\ng high\nf 4 5 6\ng rest\nf 4 6 7\ng wrong\nf 4 6 8\n\
                t crease 2/1/0 3 5 2\nt corner 1/1/0 2 3\nt hole 1/0/0 2\n";
    let (obj, diagnostics) = read("parts.obj", text.as_bytes());
    assert_eq!(diagnostics.len(), 1);
    assert_eq!(
        (diagnostics[0].line, &*diagnostics[0].message),
        (17, "the face names v 8 of 7; face left out")
    );
    let parts = obj.parts(Scheme::CatmullClark);
    let names: Vec<_> = parts.iter().map(|p| (p.name.as_str(), p.line)).collect();
    assert_eq!(names, [("low", 10), ("high, rest", 12)]);
    let [low, high] = [&parts[0].mesh, &parts[1].mesh];
    assert_eq!((low.indices.as_slice(), high.indices.as_slice()), (&[0, 1, 2][..], &[0, 1, 2, 0, 2, 3][..]));
    assert_eq!(high.points.first()[3], [0.0, 1.0, 5.0]);
    assert_eq!((low.vars.len(), high.vars.len()), (1, 0));
    assert_eq!((low.corners.as_slice(), high.holes.as_slice()), (&[(2, 3.0)][..], &[1][..]));
    assert_eq!((low.creases.len(), high.creases[0].vertices.as_slice()), (0, &[0, 2][..]));
}

#[test]
fn one_part_keeps_its_numbers() {
    let text = "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\ng a\nf 2 3 4\ng b\nf 2 4 5\n";
    let (obj, _) = read("one.obj", text.as_bytes());
    let parts = obj.parts(Scheme::Loop);
    assert_eq!(parts.len(), 1);
    assert_eq!((parts[0].name.as_str(), &parts[0].mesh), ("a, b", &obj.subdivision_mesh(Scheme::Loop)));
    assert!(read("none.obj", b"v 0 0 0\n").0.parts(Scheme::Loop).is_empty());
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
            obj.parts(scheme);
            let (surface, _) = LimitSurface::new(obj.subdivision_mesh(scheme).into());
            for quad in 0..surface.num_quads() as u32 {
                surface.evaluator(quad).evaluate(0, 0.3, 0.0);
            }
        }
    }
}
