//! Speed of subdivision surfaces: making the tables, beginning a base quad, points, boxes.
#![allow(missing_docs)] // criterion_group! makes a public function without them.

use std::hint::black_box;
use std::sync::Arc;

use conformance::shapes;
use criterion::{Criterion, criterion_group, criterion_main};
use olema::geometry::subdivision::LimitSurface;
use olema::scene::{Crease, SubdivisionMesh};

/// 1,600 quads with 300 creased edges, semi-sharp and infinite.
fn creased_torus() -> SubdivisionMesh {
    let mut mesh = shapes::torus(40, 40);
    for i in 0..300i32 {
        let (x, y) = (i % 40, i / 40 * 5);
        let sharpness = vec![[1.5, 3.0, 10.0][i as usize % 3]];
        mesh.creases.push(Crease { vertices: vec![y * 40 + x, y * 40 + (x + 1) % 40], sharpness });
    }
    mesh
}

/// Evaluates a grid of 16 x 16 on a base quad; returns the evaluator's bytes.
fn evaluate(surface: &LimitSurface, quad: u32) -> usize {
    let mut evaluator = surface.evaluator(quad);
    for j in 0..=15u8 {
        for i in 0..=15u8 {
            black_box(evaluator.evaluate(0, f32::from(i) / 15.0, f32::from(j) / 15.0));
        }
    }
    evaluator.num_bytes()
}

fn subdivision(c: &mut Criterion) {
    let torus = Arc::new(shapes::torus(100, 100));
    let creased = Arc::new(creased_torus());
    let extraordinary = Arc::new(shapes::poles(400, olema::scene::Scheme::CatmullClark));
    c.bench_function("tables of 10,000 quads", |b| b.iter(|| LimitSurface::new(Arc::clone(&torus))));
    for (name, mesh) in [("regular", &torus), ("creased", &creased), ("extraordinary", &extraordinary)] {
        let surface = LimitSurface::new(Arc::clone(mesh)).0;
        let largest = (0..surface.num_quads() as u32).map(|quad| evaluate(&surface, quad)).max();
        println!("{name}: {} quads, {} bytes", surface.num_quads(), surface.num_bytes());
        println!("{name}: largest evaluator {largest:?} bytes");
        c.bench_function(&format!("{name}: 256 points on each base quad"), |b| {
            b.iter(|| (0..surface.num_quads() as u32).map(|q| evaluate(&surface, q)).sum::<usize>())
        });
        c.bench_function(&format!("{name}: begin each base quad, box of a quarter"), |b| {
            b.iter(|| {
                for quad in 0..surface.num_quads() as u32 {
                    black_box(surface.evaluator(quad).bounds(0, [0.0, 0.5], [0.5, 1.0]));
                }
            });
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10);
    targets = subdivision
}
criterion_main!(benches);
