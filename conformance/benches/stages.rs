//! One bench a stage, each on the input that the stage before it makes of the teapot at 640 x 480.
#![allow(missing_docs)] // criterion_group! makes a public function without them.

use conformance::scenes::teapot;
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use olema::engine::Bench;
use olema::sampling::Kernels;
use olema::{Hooks, Renderer, Settings};

fn settings() -> Settings {
    Settings { resolution: [640, 480], threads: 1, ..Settings::default() }
}

fn stages(c: &mut Criterion) {
    let scene = teapot();
    let settings = settings();
    let mut group = c.benchmark_group("stage");
    group.sample_size(20);
    let bench = Bench::new(&scene, &settings).expect("a correct scene");
    group.bench_function("patchify_connect", |b| b.iter(|| Bench::new(&scene, &settings)));
    let pieces = bench.split();
    group.throughput(Throughput::Elements(pieces.len() as u64));
    group.bench_function("split", |b| b.iter(|| bench.split()));
    group.bench_function("bound", |b| b.iter(|| bench.bound(&pieces)));
    let vertices = bench.dice(&pieces).iter().map(|d| d.grid.num_vertices() as u64).sum();
    group.throughput(Throughput::Elements(vertices));
    group.bench_function("dice", |b| b.iter(|| bench.dice(&pieces)));
    group.bench_function("shade", |b| {
        b.iter_batched(|| bench.dice(&pieces), |diced| bench.shade(diced), criterion::BatchSize::LargeInput);
    });
    let grids = bench.shade(bench.dice(&pieces));
    let micropolygons = grids.iter().map(|(g, _)| g.grid.num_micropolygons() as u64).sum();
    group.throughput(Throughput::Elements(micropolygons));
    group.bench_function("sample", |b| b.iter(|| bench.sample(&grids, Kernels::default())));
    let buffers = bench.sample(&grids, Kernels::default()).expect("few enough grids");
    group.throughput(Throughput::Elements(640 * 480));
    group.bench_function("resolve", |b| b.iter(|| bench.resolve(&buffers)));
    group.finish();
}

fn pictures(c: &mut Criterion) {
    let scene = teapot();
    let mut group = c.benchmark_group("teapot_640x480");
    group.sample_size(10);
    for samples in [[1, 1], [2, 2], [4, 4]] {
        let renderer = Renderer::new(Settings { samples, ..settings() }).expect("valid settings");
        let name = BenchmarkId::from_parameter(samples[0] * samples[1]);
        group.bench_function(name, |b| b.iter(|| renderer.render(&scene, &Hooks::default())));
    }
    group.finish();
}

criterion_group!(benches, stages, pictures);
criterion_main!(benches);
