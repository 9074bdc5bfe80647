//! Subdivision meshes: faces, points, variables, and a test a tag and a mistake.

use std::sync::Arc;

use olema::scene::{
    BoundaryRule, Class, Crease, CreaseMethod, FaceVaryingRule, Geometry, Keyed, Scheme, SubdivisionMesh,
};

use super::*;

/// Two quads side by side and their points.
const FACES: &str = "[4 4] [0 1 4 3 1 2 5 4]";
const P: &str = "\"P\" [0 0 0 1 0 0 2 0 0 0 1 0 1 1 0 2 1 0]";

fn mesh(frame: &RibFrame, ix: usize) -> &Arc<SubdivisionMesh> {
    let Geometry::Subdivision(mesh) = &frame.scene.primitives[ix].geometry else { panic!("a mesh") };
    mesh
}

/// The mesh of two quads with these arrays of tags, about which there is nothing to say.
fn tagged(tags: &str) -> SubdivisionMesh {
    let frame = world(&format!("SubdivisionMesh \"catmull-clark\" {FACES} {tags} {P}"));
    SubdivisionMesh::clone(mesh(&frame, 0))
}

/// The mesh of two quads with these arrays of tags, and the one warning about them.
#[track_caller]
fn warned(tags: &str, part: &str) -> SubdivisionMesh {
    let read = read(&format!("WorldBegin SubdivisionMesh \"catmull-clark\" {FACES} {tags} {P} WorldEnd"));
    read.says(Severity::Warning, 1, 68, part);
    SubdivisionMesh::clone(mesh(&read.frames[0], 0))
}

#[test]
fn a_mesh_has_its_faces_points_and_variables() {
    let frame = world(&format!(
        r#"SubdivisionMesh "catmull-clark" {FACES} {P} "constant float a" 1 "uniform float b" [1 2]
        "varying float c" [1 2 3 4 5 6] "vertex color d" [1 1 1 2 2 2 3 3 3 4 4 4 5 5 5 6 6 6]
        "facevarying float[2] st" [0 0 1 0 1 1 0 1 0 0 1 0 1 1 0 1]"#
    ));
    let mesh = mesh(&frame, 0);
    assert_eq!(mesh.scheme, Scheme::CatmullClark);
    assert_eq!(mesh.face_vertex_counts, [4, 4]);
    assert_eq!(mesh.indices, [0, 1, 4, 3, 1, 2, 5, 4]);
    assert_eq!(mesh.points.first()[5], [2.0, 1.0, 0.0]);
    let classes: Vec<_> = mesh.vars.iter().map(|v| (v.name.as_str(), v.class)).collect();
    let expected = [
        ("a", Class::Constant),
        ("b", Class::Uniform),
        ("c", Class::Varying),
        ("d", Class::Vertex),
        ("st", Class::FaceVarying),
    ];
    assert_eq!(classes, expected);
    assert_eq!(frame.scene.primitives[0].origin.to_string(), "test.rib:2");
}

#[test]
fn the_scheme_has_these_names() {
    for (name, scheme) in [
        ("catmull-clark", Scheme::CatmullClark),
        ("catmull_clark", Scheme::CatmullClark),
        ("loop", Scheme::Loop),
        ("bilinear", Scheme::Bilinear),
    ] {
        let frame = world(&format!("SubdivisionMesh \"{name}\" {FACES} {P}"));
        assert_eq!(mesh(&frame, 0).scheme, scheme);
    }
    let read = read(&format!("WorldBegin SubdivisionMesh \"butterfly\" {FACES} {P} WorldEnd"));
    read.says(
        Severity::Error,
        1,
        28,
        "expected \"catmull-clark\", \"loop\" or \"bilinear\", found \"butterfly\"",
    );
}

#[test]
fn borders_are_drawn_as_interpolateboundary_says() {
    assert_eq!(tagged("").boundary, BoundaryRule::None);
    assert_eq!(tagged("[] [] [] []").boundary, BoundaryRule::None);
    assert_eq!(tagged("[\"interpolateboundary\"] [0 0] [] []").boundary, BoundaryRule::EdgeAndCorner);
    assert_eq!(tagged("[\"interpolateboundary\"] [1 0] [0] []").boundary, BoundaryRule::None);
    assert_eq!(tagged("[\"interpolateboundary\"] [1 0] [1] []").boundary, BoundaryRule::EdgeAndCorner);
    assert_eq!(tagged("[\"interpolateboundary\"] [1 0] [2] []").boundary, BoundaryRule::EdgeOnly);
    let bilinear = world(&format!("SubdivisionMesh \"bilinear\" {FACES} {P}"));
    assert_eq!(mesh(&bilinear, 0).boundary, BoundaryRule::EdgeAndCorner);
    let mesh = warned("[\"interpolateboundary\"] [1 0] [3] []", "expected 0, 1, 2 or no integer, found 3");
    assert_eq!(mesh.boundary, BoundaryRule::None);
}

#[test]
fn creases_have_one_sharpness_or_one_an_edge() {
    let mesh = tagged("[\"crease\" \"crease\"] [2 1 3 2] [1 4 0 1 2] [2.5 1 3]");
    let expected = [
        Crease { vertices: vec![1, 4], sharpness: vec![2.5] },
        Crease { vertices: vec![0, 1, 2], sharpness: vec![1.0, 3.0] },
    ];
    assert_eq!(mesh.creases, expected);
    for wrong in
        ["[\"crease\"] [1 1] [1] [2]", "[\"crease\"] [3 3] [0 1 2] [1 2 3]", "[\"crease\"] [2 0] [1 4] []"]
    {
        assert!(warned(wrong, "tag 1 \"crease\": expected 2 or more vertices").creases.is_empty());
    }
}

#[test]
fn corners_have_one_sharpness_or_one_each() {
    assert_eq!(tagged("[\"corner\"] [2 1] [0 2] [4]").corners, [(0, 4.0), (2, 4.0)]);
    assert_eq!(tagged("[\"corner\"] [2 2] [0 2] [4 5]").corners, [(0, 4.0), (2, 5.0)]);
    for wrong in ["[\"corner\"] [0 1] [] [2]", "[\"corner\"] [3 2] [0 1 2] [1 2]"] {
        assert!(warned(wrong, "tag 1 \"corner\": expected vertices and one sharpness").corners.is_empty());
    }
}

#[test]
fn holes_are_faces() {
    assert_eq!(tagged("[\"hole\" \"hole\"] [1 0 1 0] [1 0] []").holes, [1, 0]);
}

#[test]
fn facevarying_rules_come_from_two_tags_in_any_order() {
    use FaceVaryingRule as R;
    let rule =
        |value: i32| tagged(&format!("[\"facevaryinginterpolateboundary\"] [1 0] [{value}] []")).face_varying;
    assert_eq!([0, 1, 2, 3].map(rule), [R::Linear, R::CornersPlus1, R::Smooth, R::Boundaries]);
    assert_eq!(tagged("").face_varying, R::Linear);
    let both = "[\"facevaryingpropagatecorners\" \"facevaryinginterpolateboundary\"] [1 0 1 0] [1 1] []";
    assert_eq!(tagged(both).face_varying, R::CornersPlus2);
    warned("[\"facevaryinginterpolateboundary\"] [1 0] [4] []", "expected 0, 1, 2 or 3, found 4");
    warned("[\"facevaryingpropagatecorners\"] [0 0] [] []", "expected 0 or 1");
}

#[test]
fn the_crease_method_is_a_string() {
    let method = |word: &str| tagged(&format!("[\"creasemethod\"] [0 0 1] [] [] [\"{word}\"]")).crease_method;
    assert_eq!(method("chaikin"), CreaseMethod::Chaikin);
    assert_eq!(method("normal"), CreaseMethod::Uniform);
    let wrong = "[\"creasemethod\"] [0 0 1] [] [] [\"round\"]";
    warned(wrong, "expected the string \"normal\" or \"chaikin\", found \"round\"");
}

#[test]
fn smoothtriangles_and_unknown_tags_are_warned_about_and_the_others_count() {
    tagged("[\"smoothtriangles\"] [1 0] [0] []");
    warned("[\"smoothtriangles\"] [1 0] [2] []", "tag 1 \"smoothtriangles\": has no effect");
    let mesh =
        warned("[\"wobble\" \"hole\"] [2 1 1 0] [7 8 1] [9]", "tag 1 \"wobble\": is unknown; left out");
    assert_eq!(mesh.holes, [1]);
}

#[test]
fn a_hierarchical_mesh_is_drawn_without_its_edits() {
    let read = read(&format!(
        "WorldBegin HierarchicalSubdivisionMesh \"catmull-clark\" {FACES}
        [\"vertexedit\" \"interpolateboundary\"] [3 3 3 1 0 0] [2 1 0 1] [0 0 1] [\"add\" \"P\" \"value\"] {P} WorldEnd"
    ));
    read.says(Severity::Warning, 2, 9, "tag 1 \"vertexedit\": has no effect");
    assert_eq!(mesh(&read.frames[0], 0).boundary, BoundaryRule::EdgeAndCorner);
}

#[test]
fn counts_that_do_not_fit_are_told() {
    let one = |text: &str, column: u32, part: &str| {
        let read = read(&format!("WorldBegin\nSubdivisionMesh \"catmull-clark\" {text}\nWorldEnd"));
        read.says(Severity::Error, 2, column, part);
        read.frames[0].scene.primitives.len()
    };
    assert_eq!(one("[4] [0 1 2] \"P\" []", 37, "has 3 values: expected 4"), 0);
    assert_eq!(one("[-4] [0 1 2 3] \"P\" []", 33, "expected counts of at least 0, found -4"), 0);
    assert_eq!(one("[3] [0 1 2]", 1, "expected control points: \"P\""), 0);
    assert_eq!(one("[3] [0 1 2] \"P\" [0 0 0 1]", 45, "has 4 numbers: expected 3 a point"), 0);
    assert_eq!(one("[3] [0 1 2] \"varying point P\" [0 0 0]", 45, "expected \"vertex point\""), 0);
    assert_eq!(one(&format!("{FACES} [\"hole\"] [1] [0] [] {P}"), 66, "has 1 values: expected 2"), 0);
    assert_eq!(one(&format!("{FACES} [\"hole\"] [2 0] [0] [] {P}"), 72, "has 1 values: expected 2"), 0);
    assert_eq!(one(&format!("{FACES} [\"hole\"] [1 1] [0] [] {P}"), 76, "has 0 values: expected 1"), 0);
    assert_eq!(one(&format!("{FACES} [\"hole\"] [1 0 1] [0] [] [] {P}"), 81, "has 0 values: expected 1"), 0);
    assert_eq!(
        one(&format!("{FACES} {P} \"uniform float b\" 1"), 99, "has 1 numbers: expected 2; left out"),
        1
    );
    assert_eq!(one(&format!("{FACES} {P} \"facevarying float b\" [1]"), 99, "expected 8; left out"), 1);
}

/// The limit surface tells of them, with the object's name and line.
#[test]
fn indices_without_a_point_are_kept() {
    let frame = world("SubdivisionMesh \"loop\" [3 3] [0 1 2 0 2 9] \"P\" [0 0 0 1 0 0 1 1 0]");
    assert_eq!(mesh(&frame, 0).indices[5], 9);
}

#[test]
fn instances_share_their_mesh() {
    let frame = world(&format!(
        "ObjectBegin 1 SubdivisionMesh \"catmull-clark\" {FACES} {P} ObjectEnd
        ObjectInstance 1 Translate 0 0 1 ObjectInstance 1"
    ));
    assert!(Arc::ptr_eq(mesh(&frame, 0), mesh(&frame, 1)));
}

#[test]
fn a_motion_block_gives_a_mesh_its_keys() {
    let moved = P.replace("2 1 0]", "2 1 5]");
    let read = read(&format!(
        "WorldBegin MotionBegin [0 1] SubdivisionMesh \"loop\" {FACES} {P} SubdivisionMesh \"loop\" {FACES} {moved}
        MotionEnd MotionBegin [0 1] SubdivisionMesh \"loop\" {FACES} {P}
        SubdivisionMesh \"loop\" [4] [0 1 2 3] {P} MotionEnd WorldEnd"
    ));
    let points = &mesh(&read.frames[0], 0).points;
    assert_eq!((points.times.as_slice(), points.values[1][5]), (&[0.0, 1.0][..], [2.0, 1.0, 5.0]));
    let said = read.said();
    assert!(
        said.iter().any(|s| (s.0, s.1) == (Severity::Warning, 3) && s.3.contains("the same shape")),
        "{said:?}"
    );
    assert_eq!(mesh(&read.frames[0], 1).points, Keyed::still(points.first().clone()));
}
