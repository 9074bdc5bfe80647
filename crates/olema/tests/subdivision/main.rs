//! The limit surface against an independent uniform subdivision and against closed forms.

mod closed_forms;
mod facevarying;
mod properties;
#[path = "../../../../conformance/src/shapes.rs"]
#[allow(dead_code)]
mod shapes;
mod uniform;

use std::sync::Arc;

use glam::{DVec3, Vec3};
use olema::geometry::subdivision::LimitSurface;
use olema::scene::{BoundaryRule, Crease, Scheme, SubdivisionMesh};

use uniform::Uniform;

/// Largest errors found: of positions, by the size of the mesh, and of normals in degrees.
#[derive(Debug, Default)]
struct Errors {
    position: f64,
    normal: f64,
    num_points: usize,
    num_normals: usize,
}

fn size(points: &[[f32; 3]]) -> f64 {
    let p = || points.iter().map(|&p| Vec3::from(p));
    let (min, max) = (p().fold(Vec3::MAX, Vec3::min), p().fold(Vec3::MIN, Vec3::max));
    f64::from((max - min).max_element())
}

fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b)).to_degrees()
}

/// Base quad corner, u, v of a barycentric place in a triangle.
fn in_triangle(b: [f64; 3]) -> (u32, f32, f32) {
    let k = (0..3).max_by(|&i, &j| b[i].total_cmp(&b[j])).unwrap();
    let (next, prev) = (b[(k + 1) % 3], b[(k + 2) % 3]);
    let d = next - prev;
    let v = ((3.0 - 2.0 * d) - ((3.0 - 2.0 * d).powi(2) - 24.0 * prev).max(0.0).sqrt()) / 2.0;
    (k as u32, (v + 2.0 * d).clamp(0.0, 1.0) as f32, v.clamp(0.0, 1.0) as f32)
}

/// Compares `mesh` with `plain` at all vertices of the latter subdivided `levels` times.
fn compare(mesh: &SubdivisionMesh, plain: &SubdivisionMesh, levels: u32) -> Errors {
    let (surface, warnings) = LimitSurface::new(Arc::new(mesh.clone()));
    assert!(warnings.is_empty(), "{warnings:?}");
    let mut reference = Uniform::new(plain);
    for _ in 0..levels {
        reference = reference.refine();
    }
    let size = size(mesh.points.first());
    let mut errors = Errors::default();
    let mut evaluators: Vec<_> = (0..surface.num_quads() as u32).map(|q| surface.evaluator(q)).collect();
    for face in &reference.faces {
        for (&vertex, &place) in face.vertices.iter().zip(&face.place) {
            // The masks published for smooth vertices do not hold where one infinite crease ends.
            let sharp = reference.sharp_edges(vertex);
            if sharp.len() == 1 && reference.vertex_sharpness.get(&vertex).is_none_or(|&s| s == 0.0) {
                continue;
            }
            let (quad, u, v) = match reference.is_loop {
                true => {
                    let (k, u, v) = in_triangle(place);
                    (face.domain as u32 * 3 + k, u, v)
                }
                false => (face.domain as u32, place[0] as f32, place[1] as f32),
            };
            let point = evaluators[quad as usize].evaluate(0, u, v);
            let error = (point.p.as_dvec3() - reference.limit(vertex)).length() / size;
            if error > errors.position {
                errors.position = error;
            }
            errors.num_points += 1;
            if let Some(expected) = reference.regular_normal(vertex)
                && let Some(found) = evaluators[quad as usize].normal(0, u, v, &point)
            {
                let error = angle(expected, found.as_dvec3());
                if error > errors.normal {
                    errors.normal = error;
                }
                errors.num_normals += 1;
            }
        }
    }
    errors
}

fn check(name: &str, mesh: &SubdivisionMesh, levels: u32) {
    let errors = compare(mesh, mesh, levels);
    println!("{name}: {errors:?}");
    assert!(errors.position <= 1e-5 && errors.normal <= 0.01, "{name}: {errors:?}");
}

fn creased_cube(sharpness: f32) -> SubdivisionMesh {
    let mut cube = shapes::cube();
    cube.creases.push(Crease { vertices: vec![0, 1, 3, 2, 0], sharpness: vec![sharpness] });
    cube.creases.push(Crease { vertices: vec![1, 5], sharpness: vec![sharpness + 0.7] });
    cube.corners.push((6, sharpness));
    cube
}

#[test]
fn smooth_meshes_agree_with_uniform_subdivision() {
    check("cube", &shapes::cube(), 7);
    check("torus", &shapes::torus(5, 4), 5);
    check("prism 5", &shapes::prism(5), 6);
    check("tetrahedron", &shapes::tetrahedron(Scheme::CatmullClark), 7);
    check("poles 12", &shapes::poles(12, Scheme::CatmullClark), 5);
}

#[test]
fn creases_and_corners_agree_with_uniform_subdivision() {
    for sharpness in [0.4, 1.0, 2.3, 10.0] {
        check("cube", &creased_cube(sharpness), 7);
        check("pyramid", &shapes::pyramid(sharpness), 7);
    }
}

#[test]
fn the_comparison_sees_a_sharpness_that_is_off_by_a_hundredth() {
    let errors = compare(&creased_cube(2.31), &creased_cube(2.3), 4);
    assert!(errors.position > 1e-5 && errors.normal > 0.01, "{errors:?}");
}

#[test]
fn borders_agree_with_uniform_subdivision() {
    for boundary in [BoundaryRule::EdgeOnly, BoundaryRule::EdgeAndCorner] {
        for scheme in [Scheme::CatmullClark, Scheme::Loop] {
            check("sheet", &shapes::open_sheet(3, 2, boundary, scheme), 5);
        }
    }
}

#[test]
fn loop_agrees_with_uniform_subdivision() {
    check("tetrahedron", &shapes::tetrahedron(Scheme::Loop), 7);
    check("icosahedron", &shapes::icosahedron(Scheme::Loop), 6);
    check("poles 9", &shapes::poles(9, Scheme::Loop), 5);
}

#[test]
fn random_meshes_agree_with_uniform_subdivision() {
    for seed in 0..40 {
        check(&format!("quads {seed}"), &shapes::random_closed(seed), 5);
        check(&format!("triangles {seed}"), &shapes::random_closed_triangles(seed), 5);
    }
}

#[test]
fn the_end_of_a_crease_is_where_its_neighbourhood_leads() {
    for mut mesh in [shapes::cube(), shapes::poles(9, Scheme::Loop), shapes::poles(6, Scheme::CatmullClark)] {
        let first = &mesh.indices[..mesh.face_vertex_counts[0] as usize];
        mesh.creases.push(Crease { vertices: first[..2].to_vec(), sharpness: vec![10.0] });
        let (surface, _) = LimitSurface::new(Arc::new(mesh));
        let mut evaluator = surface.evaluator(0);
        let corner = evaluator.evaluate(0, 0.0, 0.0);
        let normal = corner.normal().unwrap();
        let near = evaluator.evaluate(0, 1e-9, 1e-9);
        assert!((corner.p - near.p).length() < 2e-5, "{corner:?} {near:?}");
        let turned = angle(normal.as_dvec3(), near.normal().unwrap().as_dvec3());
        // Around a crease's end under Loop the normal settles slowly, by a factor of 0.95 a level.
        assert!(turned < 0.3, "{turned} degrees");
    }
}
