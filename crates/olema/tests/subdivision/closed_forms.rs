//! Limits at one vertex against formulas: eigenvectors at extraordinary vertices, crease and corner rules.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use olema::geometry::subdivision::LimitSurface;
use olema::scene::{BoundaryRule, Crease, Scheme, SubdivisionMesh};

use super::angle;
use super::shapes::{Random, mesh};

/// A vertex (0) with `n` faces around it, or a border through it: neighbours e at 1 + 2k, quads' far corners
/// at 2 + 2k, at random heights above a disk.
fn fan(n: usize, closed: bool, scheme: Scheme) -> SubdivisionMesh {
    let mut random = Random::new(n as u64);
    let spokes = if closed { n } else { n + 1 };
    let mut points = vec![[0.1, -0.2, 0.3]];
    for k in 0..2 * spokes {
        let turn = if closed { 2.0 * PI / n as f64 } else { 1.5 * PI / n as f64 };
        let a = turn * k as f64 / 2.0;
        let r = 1.0 + f64::from(random.unit());
        points.push([(r * a.cos()) as f32, (r * a.sin()) as f32, random.unit()]);
    }
    let faces: Vec<Vec<i32>> = (0..n)
        .map(|k| {
            let (e0, far, e1) = (1 + 2 * k, 2 + 2 * k, 1 + 2 * ((k + 1) % spokes));
            match scheme {
                Scheme::Loop => vec![0, e0 as i32, e1 as i32],
                _ => vec![0, e0 as i32, far as i32, e1 as i32],
            }
        })
        .collect();
    mesh(scheme, points, &faces)
}

fn points(mesh: &SubdivisionMesh) -> Vec<DVec3> {
    mesh.points.first().iter().map(|&p| Vec3::from(p).as_dvec3()).collect()
}

/// Place of the base quad at the vertex in the fan's face `k`.
fn quad(scheme: Scheme, k: usize) -> u32 {
    if scheme == Scheme::Loop { 3 * k as u32 } else { k as u32 }
}

#[test]
fn extraordinary_vertices_have_the_eigenvectors_limit() {
    for n in [3, 4, 5, 7, 50] {
        for scheme in [Scheme::CatmullClark, Scheme::Loop] {
            let mesh = fan(n, true, scheme);
            let p = points(&mesh);
            let e = |k: usize| p[1 + 2 * (k % n)];
            let f = |k: usize| p[2 + 2 * (k % n)];
            let nf = n as f64;
            let cos = |k: usize| (2.0 * PI * k as f64 / nf).cos();
            let (edges, far): (DVec3, DVec3) = ((0..n).map(e).sum(), (0..n).map(f).sum());
            let (limit, tangent): (DVec3, Box<dyn Fn(usize) -> DVec3>) = if scheme == Scheme::Loop {
                let beta = (0.625 - (0.375 + 0.25 * cos(1)).powi(2)) / nf;
                let w = 1.0 / (nf + 3.0 / (8.0 * beta));
                let t = move |k: usize| (0..n).map(|i| e(i + k) * cos(i)).sum();
                (p[0] * (1.0 - nf * w) + edges * w, Box::new(t))
            } else {
                let a = 1.0 + cos(1) + (PI / nf).cos() * (2.0 * (9.0 + cos(1))).sqrt();
                let t = move |k: usize| {
                    (0..n).map(|i| e(i + k) * (a * cos(i)) + f(i + k) * (cos(i) + cos(i + 1))).sum()
                };
                ((p[0] * nf * nf + edges * 4.0 + far) / (nf * (nf + 5.0)), Box::new(t))
            };
            let (surface, _) = LimitSurface::new(Arc::new(mesh));
            for k in 0..n {
                let at = surface.evaluator(quad(scheme, k)).evaluate(0, 0.0, 0.0);
                assert!((at.p.as_dvec3() - limit).length() < 1e-6, "{scheme:?} {n}: {} {limit}", at.p);
                let normal = tangent(0).cross(tangent(1)).normalize();
                let turned = angle(at.normal().unwrap().as_dvec3(), normal);
                assert!(turned < 0.01, "{scheme:?} {n}: {turned} degrees");
            }
        }
    }
}

#[test]
fn creases_have_the_limit_of_their_curve_and_one_tangent_plane_a_side() {
    for m in [1, 2, 3, 4, 7, 50] {
        for scheme in [Scheme::CatmullClark, Scheme::Loop] {
            let mesh = fan(m, false, scheme);
            let p = points(&mesh);
            let (first, last) = (p[1], p[1 + 2 * m]);
            let limit = (p[0] * 4.0 + first + last) / 6.0;
            let (surface, _) = LimitSurface::new(Arc::new(mesh));
            let mut normals = Vec::new();
            for k in 0..m {
                let mut evaluator = surface.evaluator(quad(scheme, k));
                let at = evaluator.evaluate(0, 0.0, 0.0);
                assert!((at.p.as_dvec3() - limit).length() < 1e-6, "{scheme:?} {m}: {} {limit}", at.p);
                let normal = at.normal().unwrap().as_dvec3();
                if m > if scheme == Scheme::Loop { 5 } else { 3 } {
                    continue;
                }
                assert!(normal.dot((first - last).normalize()).abs() < 1e-6, "{scheme:?} {m}");
                // At a rounded corner of one face the derivatives become parallel, and the normal settles as
                // slowly as 1 / level.
                let (h, tolerance) = if m == 1 { (1e-4, 8.0) } else { (1e-9, 0.2) };
                let near = evaluator.evaluate(0, h, h);
                let turned = angle(normal, near.normal().unwrap().as_dvec3());
                assert!(turned < tolerance, "{scheme:?} {m} {k}: {turned} degrees from the normal nearby");
                normals.push(normal);
            }
            let spread = normals.iter().map(|n| angle(*n, normals[0])).fold(0.0, f64::max);
            assert!(spread < 0.01, "{scheme:?} {m}: {spread} degrees between the faces");
        }
    }
}

#[test]
fn sharp_corners_stay_where_they_are() {
    for m in [1, 2, 3, 8] {
        for scheme in [Scheme::CatmullClark, Scheme::Loop] {
            let mut mesh = fan(m, false, scheme);
            mesh.corners.push((0, 10.0));
            let p = points(&mesh);
            let (surface, _) = LimitSurface::new(Arc::new(mesh));
            for k in 0..m {
                let mut evaluator = surface.evaluator(quad(scheme, k));
                let at = evaluator.evaluate(0, 0.0, 0.0);
                assert_eq!(at.p.as_dvec3(), p[0], "{scheme:?} {m}");
                let normal = at.normal().unwrap().as_dvec3();
                let near = evaluator.evaluate(0, 1e-3, 1e-3).normal().unwrap().as_dvec3();
                assert!(angle(normal, near) < 20.0, "{scheme:?} {m}: {}", angle(normal, near));
            }
        }
    }
}

#[test]
fn a_border_of_rule_1_keeps_the_corners_of_single_faces() {
    let mut mesh = fan(1, false, Scheme::CatmullClark);
    mesh.boundary = BoundaryRule::EdgeAndCorner;
    let corners = mesh.points.first().clone();
    let (surface, _) = LimitSurface::new(Arc::new(mesh));
    let mut evaluator = surface.evaluator(0);
    for (i, (u, v)) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].into_iter().enumerate() {
        let p = evaluator.evaluate(0, u, v).p;
        assert!((p - Vec3::from(corners[i])).length() < 1e-6, "{p}");
    }
}

#[test]
fn an_infinite_crease_does_not_round_off_however_near() {
    let mut mesh = super::shapes::cube();
    mesh.creases.push(Crease { vertices: vec![0, 1, 3, 2, 0], sharpness: vec![10.0] });
    let (surface, _) = LimitSurface::new(Arc::new(mesh));
    let (mut a, mut b) = (None, None);
    // Two faces along the edge 0-1 have normals far apart on it, all along.
    for quad in 0..surface.num_quads() as u32 {
        for (side, edge) in surface.quad(quad).edges.iter().enumerate() {
            if edge.edge == 0 {
                let (u, v) = [(0.5, 0.0), (1.0, 0.5), (0.5, 1.0), (0.0, 0.5)][side];
                let point = surface.evaluator(quad).evaluate(0, u, v);
                let to = if a.is_none() { &mut a } else { &mut b };
                *to = Some((point.p, point.normal().unwrap()));
            }
        }
    }
    let (a, b) = (a.unwrap(), b.unwrap());
    assert!((a.0 - b.0).length() < 1e-6);
    assert!(a.1.dot(b.1) < 0.8, "{} {}", a.1, b.1);
}
