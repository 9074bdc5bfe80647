//! What shading and its arithmetic cost: a grid of plastic, displaced points, filter weights, powers.
#![allow(missing_docs)] // criterion_group! makes a public function without them.

use std::hint::black_box;
use std::sync::Arc;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::{DMat4, Vec3};
use olema::image::{Filter, FilterKind};
use olema::math::{Vec3s, function};
use olema::shading::{
    self, DisplacementPoints, PlacedLight, ShadedPoints, ShaderParam, ShadingPoints, TextureImage,
};

/// 17 x 17 vertices of a bowl in front of the eye.
fn grid() -> ShadingPoints {
    let mut points = ShadingPoints::default();
    for vertex in 0..289 {
        let (x, y) = ((vertex % 17) as f32 / 8.0 - 1.0, (vertex / 17) as f32 / 8.0 - 1.0);
        let p = Vec3::new(x, y, 5.0 + 0.3 * (x * x + y * y));
        let n = Vec3::new(0.6 * x, 0.6 * y, -1.0).normalize();
        for (array, value) in
            [(&mut points.p, p), (&mut points.i, p), (&mut points.n, n), (&mut points.ng, n)]
        {
            array.push(value);
        }
    }
    points.cs = Vec3s::splat(Vec3::new(0.8, 0.4, 0.2), 289);
    points.os = Vec3s::splat(Vec3::ONE, 289);
    points
}

fn lights(names: &[&str]) -> Vec<Arc<dyn PlacedLight>> {
    let place = |name: &&str| {
        let made = shading::light(name, &[ShaderParam::float("intensity", 2.0)]).expect("a standard light");
        made.shader.place(&DMat4::IDENTITY)
    };
    names.iter().map(place).collect()
}

fn surfaces(c: &mut Criterion) {
    let (points, all) = (grid(), (0..289).collect::<Vec<u32>>());
    let mut out = ShadedPoints { ci: Vec3s::splat(Vec3::ZERO, 289), oi: Vec3s::splat(Vec3::ZERO, 289) };
    let mut group = c.benchmark_group("shade");
    group.throughput(Throughput::Elements(289));
    for (name, names) in [
        ("plastic", &["ambientlight", "distantlight", "pointlight"][..]),
        ("plastic", &["distantlight", "pointlight", "spotlight"][..]),
        ("matte", &["ambientlight", "distantlight", "pointlight"][..]),
        ("defaultsurface", &[][..]),
    ] {
        let shader = shading::surface(name, &[]).expect("a standard surface").shader;
        let lights = lights(names);
        group.bench_function(format!("{name}/{}", names.join("+")), |b| {
            b.iter(|| shader.shade(black_box(&points), &all, &lights, &mut out));
        });
    }
    group.finish();
}

/// The bowl's points, about 0.1 apart: a width of 0.1 leaves three of six octaves.
fn displacements(c: &mut Criterion) {
    let shaded = grid();
    let (s, t) = (0..289).map(|n| ((n % 17) as f32 / 16.0, (n / 17) as f32 / 16.0)).unzip();
    let width = |width| DisplacementPoints {
        p: shaded.p.clone(),
        n: shaded.n.clone(),
        s: Vec::clone(&s),
        t: Vec::clone(&t),
        width: vec![width; 289],
        st_width: vec![width / 2.0; 289],
        ..DisplacementPoints::default()
    };
    let data: Vec<f32> = (0..512 * 512).map(|n| (n % 97) as f32 / 97.0).collect();
    let image = Arc::new(TextureImage::new(512, 512, &data).expect("an image"));
    let mut offset = Vec3s::splat(Vec3::ZERO, 289);
    let mut group = c.benchmark_group("displace");
    group.throughput(Throughput::Elements(289));
    for name in ["cells", "fractal", "image", "noise", "vector", "waves"] {
        let params = [ShaderParam::string("texturename", "an image")];
        let params = if name == "image" { &params[..] } else { &[] };
        let made = shading::displacement_with_images(name, params, &|_| Ok(image.clone()));
        let shader = made.expect("a known displacement").shader;
        for (scale, points) in [("fine", width(1e-3)), ("coarse", width(0.1))] {
            group.bench_function(format!("{name}/{scale}"), |b| {
                b.iter(|| shader.displace(black_box(&points), &mut offset));
            });
        }
    }
    group.finish();
}

fn filters(c: &mut Criterion) {
    let mut group = c.benchmark_group("filter");
    group.throughput(Throughput::Elements(256));
    for kind in [FilterKind::Box, FilterKind::CatmullRom, FilterKind::Gaussian, FilterKind::Sinc] {
        let filter = Filter { kind, width: [4.0, 4.0] };
        group.bench_function(format!("{kind:?}"), |b| {
            b.iter(|| {
                let at = |n: u32| (n as f32 - 7.5) * 0.25;
                (0..256).map(|n| black_box(&filter).weight(at(n % 16), at(n / 16))).sum::<f32>()
            });
        });
    }
    group.finish();
}

fn functions(c: &mut Criterion) {
    let xs: Vec<f32> = (0..1024).map(|n| n as f32 / 1024.0).collect();
    let mut group = c.benchmark_group("function");
    group.throughput(Throughput::Elements(1024));
    let mut each = |name: &str, f: &dyn Fn(&[f32]) -> f32| {
        group.bench_function(name, |b| b.iter(|| f(black_box(&xs))));
    };
    each("pow", &|xs| xs.iter().map(|x| function::pow(*x, 10.0)).sum());
    each("pow_std", &|xs| xs.iter().map(|x| x.powf(black_box(10.0))).sum());
    each("exp", &|xs| xs.iter().map(|x| function::exp(*x)).sum());
    each("exp_std", &|xs| xs.iter().map(|x| x.exp()).sum());
    each("sin", &|xs| xs.iter().map(|x| function::sin(*x)).sum());
    each("sin_std", &|xs| xs.iter().map(|x| x.sin()).sum());
    group.finish();
}

criterion_group!(benches, surfaces, displacements, filters, functions);
criterion_main!(benches);
