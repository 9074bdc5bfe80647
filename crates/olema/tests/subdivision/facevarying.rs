//! The rules of facevarying values, at the vertices where they differ.
//!
//! Each case says which values of a vertex are kept sharp under which rules. A value that is not is on a smooth border
//! of its values, and its limit is (a + 4 v + b) / 6, between the values a and b beside it on that border.

use std::sync::Arc;

use olema::geometry::subdivision::LimitSurface;
use olema::math::hash::{hash32, unit};
use olema::scene::{
    BoundaryRule, Class, Crease, FaceVaryingRule as Rule, PrimVar, Scheme, SubdivisionMesh, VarType,
    VarValues,
};

use super::shapes;

const RULES: [Rule; 5] =
    [Rule::Smooth, Rule::CornersOnly, Rule::CornersPlus1, Rule::CornersPlus2, Rule::Boundaries];

/// The value of a vertex in an island, at random, so that no border is straight.
fn value(vertex: i32, island: i32) -> f32 {
    unit(hash32((vertex * 16 + island) as u32))
}

/// The mesh with a variable whose value at a vertex of a face is that of the island which `island` names.
fn with_islands(mut mesh: SubdivisionMesh, island: impl Fn(usize, i32) -> i32) -> SubdivisionMesh {
    let counts = mesh.face_vertex_counts.iter().enumerate();
    let faces = counts.flat_map(|(face, count)| vec![face; *count as usize]);
    let values = faces.zip(&mesh.indices).map(|(face, vertex)| value(*vertex, island(face, *vertex)));
    let values = VarValues::Floats(values.collect());
    mesh.vars = vec![PrimVar {
        name: "islands".into(),
        class: Class::FaceVarying,
        ty: VarType::Float,
        array_len: 1,
        values,
    }];
    mesh
}

/// The limit of the variable at a vertex as a face has it.
fn limit(mesh: &SubdivisionMesh, rule: Rule, face: usize, vertex: i32) -> f32 {
    let (surface, warnings) =
        LimitSurface::new(Arc::new(SubdivisionMesh { face_varying: rule, ..mesh.clone() }));
    assert!(warnings.is_empty(), "{warnings:?}");
    let corner =
        mesh.indices[4 * face..][..4].iter().position(|v| *v == vertex).expect("a vertex of the face");
    let (u, v) = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)][corner];
    let mut out = [0.0];
    assert!(surface.evaluator(face as u32).var(0, u, v, &mut out));
    out[0]
}

/// A value at a vertex, and the two beside it on the border of its island, each as (vertex, island).
struct Place {
    face: usize,
    at: (i32, i32),
    beside: [(i32, i32); 2],
}

/// Asserts that the value is kept under the rules of `sharp` and is on a smooth border under the others.
#[track_caller]
fn assert_sharp_under(mesh: &SubdivisionMesh, place: &Place, sharp: &[Rule]) {
    let of = |(vertex, island): (i32, i32)| value(vertex, island);
    let smooth = (of(place.beside[0]) + 4.0 * of(place.at) + of(place.beside[1])) / 6.0;
    for rule in RULES {
        let expected = if sharp.contains(&rule) { of(place.at) } else { smooth };
        let found = limit(mesh, rule, place.face, place.at.0);
        assert!((found - expected).abs() < 2e-6, "{rule:?}: {found}, not {expected}");
    }
}

/// A flat sheet of 4 x 4 faces: face and vertex by column and row, vertices 5 a row.
fn sheet(boundary: BoundaryRule) -> SubdivisionMesh {
    shapes::open_sheet(4, 4, boundary, Scheme::CatmullClark)
}

const fn vertex(column: i32, row: i32) -> i32 {
    row * 5 + column
}

const fn face(column: usize, row: usize) -> usize {
    row * 4 + column
}

const MIDDLE: i32 = vertex(2, 2);

#[test]
fn the_sheet_is_numbered_as_these_tests_think() {
    let mesh = sheet(BoundaryRule::EdgeOnly);
    assert_eq!(mesh.face_vertex_counts, [4; 16]);
    for (column, row) in [(0, 0), (2, 1), (3, 3)] {
        let [c, r] = [column as i32, row as i32];
        let mut corners = mesh.indices[4 * face(column, row)..][..4].to_vec();
        corners.sort_unstable();
        assert_eq!(corners, [vertex(c, r), vertex(c + 1, r), vertex(c, r + 1), vertex(c + 1, r + 1)]);
    }
}

#[test]
fn a_corner_of_an_island_is_sharp_and_around_it_with_corners_plus_2() {
    // An island of two by two faces whose upper right corner is the middle.
    let inside = |face: usize| face % 4 < 2 && face / 4 < 2;
    let mesh = with_islands(sheet(BoundaryRule::EdgeOnly), |face, _| i32::from(inside(face)));
    let beside = |island| [(vertex(1, 2), island), (vertex(2, 1), island)];
    let corner = Place { face: face(1, 1), at: (MIDDLE, 1), beside: beside(1) };
    assert_sharp_under(
        &mesh,
        &corner,
        &[Rule::CornersOnly, Rule::CornersPlus1, Rule::CornersPlus2, Rule::Boundaries],
    );
    let around = Place { face: face(2, 2), at: (MIDDLE, 0), beside: beside(0) };
    assert_sharp_under(&mesh, &around, &[Rule::CornersPlus2, Rule::Boundaries]);
    // Along the side of the island nothing is sharp but borders that always are.
    let side = Place { face: face(1, 0), at: (vertex(2, 1), 1), beside: [(vertex(2, 0), 1), (MIDDLE, 1)] };
    assert_sharp_under(&mesh, &side, &[Rule::Boundaries]);
}

#[test]
fn three_islands_at_a_vertex_are_sharp_from_corners_plus_1_on() {
    // Six quads around vertex 0, two an island.
    let ring = |ix: i32| 1 + ix.rem_euclid(12);
    let indices = (0..6).flat_map(|ix| [0, ring(2 * ix), ring(2 * ix + 1), ring(2 * ix + 2)]).collect();
    let angle = |ix: i32| std::f32::consts::TAU * ix as f32 / 12.0;
    let points = (0..12).map(|ix| [angle(ix).cos(), angle(ix).sin(), 0.0]);
    let points = std::iter::once([0.0; 3]).chain(points).collect();
    let mesh = SubdivisionMesh::new(Scheme::CatmullClark, vec![4; 6], indices, points);
    let mesh = with_islands(mesh, |face, _| face as i32 / 2);
    for island in 0..3 {
        let beside = [(ring(4 * island), island), (ring(4 * island + 4), island)];
        let place = Place { face: 2 * island as usize, at: (0, island), beside };
        assert_sharp_under(&mesh, &place, &[Rule::CornersPlus1, Rule::CornersPlus2, Rule::Boundaries]);
    }
}

#[test]
fn a_seam_that_ends_inside_is_sharp_there_with_corners_plus_2() {
    // A cut from below to the middle: left and right of it values differ.
    let right = |face: usize| i32::from(face % 4 >= 2);
    let on_cut = |vertex: i32| vertex % 5 == 2 && vertex < MIDDLE;
    let mesh = with_islands(
        sheet(BoundaryRule::EdgeOnly),
        |face, vertex| {
            if on_cut(vertex) { right(face) } else { 0 }
        },
    );
    for face in [face(1, 1), face(2, 1), face(1, 2), face(2, 2)] {
        let beside = [(vertex(2, 1), 0), (vertex(2, 1), 1)];
        let end = Place { face, at: (MIDDLE, 0), beside };
        assert_sharp_under(&mesh, &end, &[Rule::CornersPlus2, Rule::Boundaries]);
    }
    for (face, side) in [(face(1, 1), 0), (face(2, 1), 1)] {
        let along = Place { face, at: (vertex(2, 1), side), beside: [(vertex(2, 0), side), (MIDDLE, 0)] };
        assert_sharp_under(&mesh, &along, &[Rule::Boundaries]);
    }
}

#[test]
fn a_value_in_two_parts_is_sharp_under_every_rule() {
    // As on a chessboard about the middle.
    let mesh =
        with_islands(sheet(BoundaryRule::EdgeOnly), |face, _| i32::from((face % 4 < 2) == (face / 4 < 2)));
    for (face, island) in [(face(1, 1), 1), (face(2, 1), 0), (face(1, 2), 0), (face(2, 2), 1)] {
        let place = Place { face, at: (MIDDLE, island), beside: [(MIDDLE, island); 2] };
        assert_sharp_under(&mesh, &place, &RULES);
    }
}

/// The sheet in two islands, left and right, with a crease in the left one that ends at the middle.
fn creased(sharpness: f32) -> SubdivisionMesh {
    let mut mesh = with_islands(sheet(BoundaryRule::EdgeOnly), |face, _| i32::from(face % 4 >= 2));
    mesh.creases.push(Crease { vertices: vec![vertex(1, 2), MIDDLE], sharpness: vec![sharpness] });
    mesh
}

#[test]
fn a_crease_that_ends_at_a_seam_keeps_both_sides_sharp_from_corners_plus_1_on() {
    let mesh = creased(10.0);
    let beside = |island| [(vertex(2, 1), island), (vertex(2, 3), island)];
    let left = Place { face: face(1, 1), at: (MIDDLE, 0), beside: beside(0) };
    assert_sharp_under(&mesh, &left, &RULES);
    let right = Place { face: face(2, 1), at: (MIDDLE, 1), beside: beside(1) };
    assert_sharp_under(&mesh, &right, &[Rule::CornersPlus1, Rule::CornersPlus2, Rule::Boundaries]);
}

#[test]
fn a_semi_sharp_crease_keeps_the_other_side_sharp_as_long() {
    for sharpness in [0.75, 1.0, 2.5] {
        let mesh = creased(sharpness);
        // What a corner of that sharpness makes of the right side.
        let mut corner = creased(0.0);
        corner.corners.push((MIDDLE, sharpness));
        let at = |mesh: &SubdivisionMesh, rule| limit(mesh, rule, face(2, 1), MIDDLE);
        let as_corner = at(&corner, Rule::CornersOnly);
        let smooth = at(&mesh, Rule::CornersOnly);
        assert!((as_corner - smooth).abs() > 1e-3);
        for rule in [Rule::CornersPlus1, Rule::CornersPlus2] {
            assert!((at(&mesh, rule) - as_corner).abs() < 2e-6, "{sharpness} {rule:?}");
        }
    }
}

#[test]
fn borders_of_the_mesh_are_borders_of_its_values() {
    let round = with_islands(sheet(BoundaryRule::EdgeOnly), |_, _| 0);
    let side =
        Place { face: face(1, 0), at: (vertex(2, 0), 0), beside: [(vertex(1, 0), 0), (vertex(3, 0), 0)] };
    assert_sharp_under(&round, &side, &[Rule::Boundaries]);
    let corner =
        Place { face: face(0, 0), at: (vertex(0, 0), 0), beside: [(vertex(1, 0), 0), (vertex(0, 1), 0)] };
    assert_sharp_under(&round, &corner, &RULES[1..]);
    // Where positions are kept, values are, too.
    let sharp = with_islands(sheet(BoundaryRule::EdgeAndCorner), |_, _| 0);
    assert_sharp_under(&sharp, &corner, &RULES);
}

#[test]
fn linear_values_are_those_of_the_faces() {
    let mesh = with_islands(sheet(BoundaryRule::EdgeOnly), |face, _| face as i32 % 3);
    for (column, row) in [(0, 0), (1, 2), (3, 3)] {
        let island = face(column, row) as i32 % 3;
        for (c, r) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let at = vertex(column as i32 + c, row as i32 + r);
            assert_eq!(limit(&mesh, Rule::Linear, face(column, row), at), value(at, island));
        }
    }
}
