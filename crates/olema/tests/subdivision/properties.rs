//! What holds for any mesh: boxes hold the surface, neighbours agree along edges, answers do not depend on
//! the order of questions, and bad input is named.

use std::collections::HashMap;
use std::sync::Arc;

use olema::geometry::SurfacePoint;
use olema::geometry::lanes::{self, SLACK, SurfacePoints};
use olema::geometry::subdivision::{CornerId, Evaluator, LimitSurface, MeshWarning, Piece};
use olema::math::simd::SimdLevel;
use olema::scene::{
    BoundaryRule, Class, Crease, CreaseMethod, FaceVaryingRule, PrimVar, Scheme, SubdivisionMesh, VarType,
    VarValues,
};
use proptest::prelude::*;

use super::shapes;

fn random_mesh(seed: u64) -> SubdivisionMesh {
    match seed % 4 {
        0 => shapes::random_closed_triangles(seed),
        1 => SubdivisionMesh { scheme: Scheme::Bilinear, ..shapes::random_closed(seed) },
        2 => SubdivisionMesh { crease_method: CreaseMethod::Chaikin, ..shapes::random_closed(seed) },
        _ => shapes::random_closed(seed),
    }
}

fn surface(mesh: SubdivisionMesh) -> LimitSurface {
    LimitSurface::new(Arc::new(mesh)).0
}

proptest! {
    #[test]
    fn boxes_hold_the_surface(
        seed in any::<u64>(), a in 0.0f32..1.0, b in 0.0f32..1.0, c in 0.0f32..1.0, scale in 0u32..20,
    ) {
        let surface = surface(random_mesh(seed));
        let quad = (seed >> 8) as u32 % surface.num_quads() as u32;
        let mut evaluator = surface.evaluator(quad);
        let size = 0.5f32.powi(scale as i32);
        let range = |x: f32| [x * (1.0 - size), (x * (1.0 - size) + size).min(1.0)];
        let (u, v) = (range(a), range(b));
        let bounds = evaluator.bounds(0, u, v);
        for i in 0..=8 {
            for j in 0..=8 {
                let at = |r: [f32; 2], i: i32| (r[0] + (r[1] - r[0]) * i as f32 / 8.0).clamp(r[0], r[1]);
                let p = evaluator.evaluate(0, at(u, i), at(v, j)).p;
                prop_assert!(p.cmpge(bounds.min).all() && p.cmple(bounds.max).all(), "{p} {bounds:?}");
            }
        }
        let again = surface.evaluator(quad).evaluate(0, c, a);
        prop_assert_eq!(evaluator.evaluate(0, c, a), again);
    }

    #[test]
    fn parts_are_splines_with_the_same_bits(
        seed in any::<u64>(), mut uv in prop::collection::vec([0.0f32..=1.0, 0.0f32..=1.0], 40),
    ) {
        let surface = surface(random_mesh(seed));
        uv.extend([[0.0, 0.0], [1.0, 0.5], [0.5, 0.0], [1.0, 1.0], [1e-30, 0.25], [0.5f32.next_down(), 0.5]]);
        let (u, v): (Vec<f32>, Vec<f32>) = uv.iter().map(|&[u, v]| (u, v)).unzip();
        for quad in 0..surface.num_quads() as u32 {
            let (mut evaluator, mut parts) = (surface.evaluator(quad), Vec::new());
            evaluator.parts([&u, &v], &mut parts);
            prop_assert_eq!(parts.len(), uv.len());
            let mut other = surface.evaluator(quad);
            for (found, [u, v]) in parts.into_iter().zip(&uv) {
                if let Some((part, within)) = found {
                    let at = evaluator.spline_of(part, 0).unwrap().evaluate(within[0], within[1]);
                    prop_assert_eq!(at, other.evaluate(0, *u, *v));
                }
            }
        }
    }

    #[test]
    fn faces_agree_along_their_edges(seed in any::<u64>(), t in 0.0f32..1.0) {
        let surface = surface(random_mesh(seed));
        let mut seen: HashMap<(u32, u32), glam::Vec3> = HashMap::new();
        let mut corners: HashMap<CornerId, glam::Vec3> = HashMap::new();
        for quad in 0..surface.num_quads() as u32 {
            let mut evaluator = surface.evaluator(quad);
            let base = surface.quad(quad);
            for (side, edge) in base.edges.iter().enumerate() {
                // The place at t of each half of the edge, as this side sees it.
                for half in 0..2 {
                    let along = match edge.piece {
                        Piece::Whole => 0.5 * (half as f32 + t),
                        Piece::FirstHalf if half == 0 => t,
                        Piece::SecondHalf if half == 1 => t,
                        _ => continue,
                    };
                    let p = on_side(&mut evaluator, side, if edge.reversed { 1.0 - along } else { along });
                    let other = *seen.entry((edge.edge, half)).or_insert(p);
                    prop_assert!((p - other).length() < 1e-5, "{p} {other} {edge:?}");
                }
                let p = on_side(&mut evaluator, side, 0.0);
                let other = *corners.entry(base.corners[side]).or_insert(p);
                prop_assert!((p - other).length() < 1e-5, "{p} {other} {:?}", base.corners[side]);
            }
        }
    }
}

fn on_side(evaluator: &mut Evaluator<'_>, side: usize, t: f32) -> glam::Vec3 {
    let (u, v) = [(t, 0.0), (1.0, t), (1.0 - t, 1.0), (0.0, 1.0 - t)][side];
    evaluator.evaluate(0, u, v).p
}

#[test]
fn boxes_are_tight() {
    for mesh in [shapes::torus(8, 6), shapes::random_closed(3), shapes::icosahedron(Scheme::Loop)] {
        let surface = surface(mesh);
        let (mut boxes, mut exact) = (0.0, 0.0);
        for quad in 0..surface.num_quads() as u32 {
            let mut evaluator = surface.evaluator(quad);
            let bounds = evaluator.bounds(0, [0.0, 1.0], [0.0, 1.0]);
            let (mut min, mut max) = (glam::Vec3::MAX, glam::Vec3::MIN);
            for i in 0..=16 {
                for j in 0..=16 {
                    let p = evaluator.evaluate(0, i as f32 / 16.0, j as f32 / 16.0).p;
                    (min, max) = (min.min(p), max.max(p));
                }
            }
            boxes += (bounds.max - bounds.min).length();
            exact += (max - min).length();
        }
        assert!(boxes < 1.12 * exact, "{boxes} {exact}");
    }
}

#[test]
fn what_is_wrong_is_named_and_the_rest_is_drawn() {
    let mut mesh = shapes::cube();
    mesh.face_vertex_counts.extend([4, 3, 3, 4, 2, 9]);
    mesh.indices.extend([0, 1, 99, 2]);
    mesh.indices.extend([1, 1, 2]);
    mesh.indices.extend([0, 3, 5]);
    mesh.indices.extend([4, 6, 2, 0]);
    mesh.indices.extend([1, 2]);
    mesh.creases.push(Crease { vertices: vec![0, 7], sharpness: vec![2.0] });
    mesh.creases.push(Crease { vertices: vec![0, 1], sharpness: vec![f32::NAN] });
    mesh.creases.push(Crease { vertices: vec![0], sharpness: vec![] });
    mesh.corners.push((-1, 2.0));
    mesh.holes.push(100);
    let (surface, warnings) = LimitSurface::new(Arc::new(mesh));
    let found = |f: fn(&MeshWarning) -> bool| warnings.iter().any(f);
    use MeshWarning as W;
    assert!(found(|w| matches!(w, W::FaceIndex { face: 6, index: 99, .. })));
    assert!(found(|w| matches!(w, W::DegenerateFace { face: 7, distinct: 2 })));
    assert!(found(|w| matches!(w, W::DuplicateFace { face: 9, of: 0 })));
    assert!(found(|w| matches!(w, W::DegenerateFace { face: 10, .. })));
    assert!(found(|w| matches!(w, W::MissingIndices { face: 11, expected: 9, found: 0 })));
    assert!(found(|w| matches!(w, W::CreaseEdge { crease: 0, .. })));
    assert!(found(|w| matches!(w, W::Sharpness { what: "crease", index: 1, .. })));
    assert!(found(|w| matches!(w, W::CreaseShape { crease: 2, .. })));
    assert!(found(|w| matches!(w, W::CornerIndex { vertex: -1, .. })));
    assert!(found(|w| matches!(w, W::HoleIndex { face: 100, .. })));
    assert!(warnings.iter().all(|w| !w.to_string().is_empty()));
    // The six faces of the cube, and three quads of the triangle across it.
    assert_eq!(surface.num_quads(), 9);
    let p = surface.evaluator(0).evaluate(0, 0.5, 0.5).p;
    assert!(p.is_finite());
}

#[test]
fn fans_of_many_faces_share_a_non_manifold_edge() {
    // Three sheets along the edges 0-1-2.
    let mut points: Vec<[f32; 3]> = (0..3).map(|i| [i as f32, 0.0, 0.0]).collect();
    let mut faces = Vec::new();
    for k in 0..3 {
        let first = points.len() as i32;
        let (y, z) = [(1.0, 0.0), (-0.5, 0.9), (-0.5, -0.9)][k];
        points.extend((0..3).map(|i| [i as f32, y, z]));
        for i in 0..2 {
            faces.push(vec![i, i + 1, first + i + 1, first + i]);
        }
    }
    let (surface, warnings) = LimitSurface::new(Arc::new(shapes::mesh(Scheme::CatmullClark, points, &faces)));
    let edges = warnings.iter().filter(|w| matches!(w, MeshWarning::NonManifoldEdge { faces: 3, .. }));
    assert_eq!(edges.count(), 2, "{warnings:?}");
    for i in 0..=10 {
        let u = i as f32 / 10.0;
        let at: Vec<_> = [0, 2, 4].map(|q| surface.evaluator(q).evaluate(0, u, 0.0).p).to_vec();
        assert!((at[0] - at[1]).length() < 1e-6 && (at[0] - at[2]).length() < 1e-6, "{at:?}");
    }
}

#[test]
fn two_hundred_faces_meet_in_a_vertex() {
    for scheme in [Scheme::CatmullClark, Scheme::Loop] {
        let surface = surface(shapes::poles(200, scheme));
        let mut evaluator = surface.evaluator(0);
        let point = evaluator.evaluate(0, 0.0, 0.0);
        assert!(point.normal().unwrap().z < -0.99, "{point:?}");
    }
}

#[test]
fn border_faces_are_not_drawn_under_rule_0() {
    let surface = surface(shapes::open_sheet(4, 4, BoundaryRule::None, Scheme::CatmullClark));
    assert_eq!(surface.num_quads(), 4);
}

/// A variable that repeats the positions.
fn positions_as(class: Class, mesh: &SubdivisionMesh) -> PrimVar {
    let points = mesh.points.first();
    let values: Vec<f32> = match class {
        Class::FaceVarying => mesh.indices.iter().flat_map(|&v| points[v as usize]).collect(),
        _ => points.iter().flatten().copied().collect(),
    };
    let values = VarValues::Floats(values.into());
    PrimVar { name: format!("{class:?}"), class, ty: VarType::Point, array_len: 1, values }
}

#[test]
fn variables_follow_the_position_or_the_faces() {
    for mut mesh in [shapes::random_closed(7), shapes::random_closed_triangles(7)] {
        mesh.face_varying = FaceVaryingRule::Smooth;
        mesh.vars = vec![
            positions_as(Class::Vertex, &mesh),
            positions_as(Class::FaceVarying, &mesh),
            positions_as(Class::Varying, &mesh),
        ];
        let surface = surface(mesh);
        for quad in 0..surface.num_quads() as u32 {
            let mut evaluator = surface.evaluator(quad);
            let mut linear = [[0.0f32; 3]; 4];
            for (out, (u, v)) in linear.iter_mut().zip([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]) {
                assert!(evaluator.var(2, u, v, out));
            }
            for (u, v) in [(0.0, 0.0), (0.3, 0.2), (0.5, 1.0), (0.97, 0.02)] {
                let p = evaluator.evaluate(0, u, v).p;
                for var in 0..2 {
                    let mut value = [0.0; 3];
                    assert!(evaluator.var(var, u, v, &mut value));
                    assert!((glam::Vec3::from(value) - p).length() < 1e-5, "{var}: {value:?} {p}");
                }
                let mut value = [0.0; 3];
                evaluator.var(2, u, v, &mut value);
                let c = linear.map(glam::Vec3::from);
                let expected = c[0].lerp(c[1], u).lerp(c[3].lerp(c[2], u), v);
                assert!((glam::Vec3::from(value) - expected).length() < 1e-5);
            }
        }
    }
}

#[test]
fn seams_part_facevarying_values() {
    // Values that are a constant a face: smooth inside nothing, so every face keeps its own.
    for rule in [FaceVaryingRule::Smooth, FaceVaryingRule::Boundaries, FaceVaryingRule::Linear] {
        let mut mesh = shapes::cube();
        mesh.face_varying = rule;
        let values: Vec<f32> = (0..24).map(|c| (c / 4) as f32).collect();
        mesh.vars.push(PrimVar {
            name: "face".into(),
            class: Class::FaceVarying,
            ty: VarType::Float,
            array_len: 1,
            values: VarValues::Floats(values.into()),
        });
        let surface = surface(mesh);
        for quad in 0..6 {
            let mut value = [0.0];
            assert!(surface.evaluator(quad).var(0, 0.2, 1.0, &mut value));
            assert_eq!(value[0], quad as f32, "{rule:?}");
        }
    }
}

#[test]
fn keys_are_evaluated_alike() {
    let mut mesh = shapes::random_closed(11);
    let still = mesh.points.first().clone();
    let moved = still.iter().map(|p| [p[0] + 1.0, p[1] * 2.0, p[2]]).collect();
    mesh.points = olema::scene::Keyed { times: vec![0.0, 1.0], values: vec![still, moved] };
    let surface = surface(mesh);
    let mut points = Vec::new();
    surface.evaluator(2).evaluate_keys(0.3, 0.6, &mut points);
    let expected = points[0].p * glam::Vec3::new(1.0, 2.0, 1.0) + glam::Vec3::X;
    assert!((points[1].p - expected).length() < 1e-6);
}

#[test]
fn chaikin_changes_nothing_where_sharpness_is_even() {
    let loop_of = |method: CreaseMethod, sharpness: Vec<f32>| {
        let mut mesh = shapes::cube();
        mesh.crease_method = method;
        mesh.creases.push(Crease { vertices: vec![0, 1, 3, 2, 0], sharpness });
        surface(mesh).evaluator(2).evaluate(0, 0.4, 0.05)
    };
    use CreaseMethod::{Chaikin, Uniform};
    assert_eq!(loop_of(Chaikin, vec![2.5]), loop_of(Uniform, vec![2.5]));
    let uneven = vec![4.0, 1.0, 1.0, 2.0];
    assert_ne!(loop_of(Chaikin, uneven.clone()), loop_of(Uniform, uneven));
}

#[test]
fn edges_beside_polygons_are_split_on_both_sides() {
    let surface = surface(shapes::prism(5));
    // Base quads: five of each end, then the sides, whose edges 0 and 2 lie along the ends.
    for quad in 0..surface.num_quads() as u32 {
        let base = surface.quad(quad);
        for (side, edge) in base.edges.iter().enumerate() {
            let along_end = quad < 10 && (side == 0 || side == 3) || quad >= 10 && side % 2 == 0;
            assert_eq!(edge.split, along_end, "{quad} {side}");
            assert_eq!(edge.piece == Piece::Whole, quad >= 10 || side == 1 || side == 2);
        }
    }
}

#[test]
fn splines_in_lanes_are_what_the_evaluator_says_on_every_level() {
    let surface = surface(shapes::torus(5, 4));
    let len = 29;
    let place = |ix: usize, of: usize| (ix % of) as f32 / (of - 1) as f32;
    let u: Vec<f32> = (0..len + SLACK).map(|ix| place(ix, 7)).collect();
    let v: Vec<f32> = (0..len + SLACK).map(|ix| place(ix, 11)).collect();
    for quad in 0..surface.num_quads() as u32 {
        let mut evaluator = surface.evaluator(quad);
        for level in SimdLevel::all() {
            let mut points = SurfacePoints::default();
            points.resize(len + SLACK);
            let spline = evaluator.spline(0).expect("a torus of quads is regular");
            lanes::evaluate(
                level,
                [&u, &v],
                0..len,
                &mut points,
                #[inline(always)]
                |u, v| {
                    let at = spline.evaluate(u, v);
                    SurfacePoint { p: at.p, du: at.dp_du, dv: at.dp_dv }
                },
            );
            for ix in 0..len {
                let twin = evaluator.evaluate(0, u[ix], v[ix]);
                assert_eq!(points.get(ix), SurfacePoint { p: twin.p, du: twin.dp_du, dv: twin.dp_dv });
            }
        }
    }
    let irregular = LimitSurface::new(Arc::new(shapes::cube())).0;
    assert!(irregular.evaluator(0).spline(0).is_none(), "three faces meet at a corner");
}
