use super::SignedHits;
use crate::sampling::hash::Stream;
use crate::sampling::nomotion::{
    Facing, GridView, SampleCounts, rasterize_grid, rasterize_quad, rasterize_triangle,
};
use crate::sampling::{PatternSpec, Region, RegionSamples, SamplePattern};

/// Samples in the centres of their cells.
fn centred(samples: [u32; 2], region: Region) -> RegionSamples {
    let spec = PatternSpec { samples, jitter: false, ..PatternSpec::default() };
    RegionSamples::new(&SamplePattern::new(spec), region)
}

fn draw_quad(xy: [[i32; 2]; 4], facing: Facing, samples: &RegionSamples) -> (SampleCounts, SignedHits) {
    let mut counts = SampleCounts::default();
    let mut sink = SignedHits::new(samples.len());
    rasterize_quad(xy, [1.0; 4], facing, samples, &mut counts, &mut sink);
    (counts, sink)
}

fn rectangle(x0: i32, x1: i32, y0: i32, y1: i32) -> [[i32; 2]; 4] {
    [[x0, y0], [x1, y0], [x1, y1], [x0, y1]]
}

#[test]
fn micropolygons_worked_by_hand_have_exact_counts() {
    let four = centred([2, 2], Region::new(-2, 2, -2, 2));
    let sixteen = centred([4, 4], Region::new(-2, 2, -2, 2));
    // Quad, samples, tests, hits. Cells are 128 and 64 wide, their centres at 64 and 32.
    let table = [
        // A pixel, exactly: its own cells only.
        (rectangle(0, 256, 0, 256), &four, 4, 4),
        (rectangle(0, 256, 0, 256), &sixteen, 16, 16),
        // Shifted by half a pixel: across four pixels.
        (rectangle(-128, 128, -128, 128), &four, 4, 4),
        // Shifted by 1/256 px: three cells each way, of which the first two hold a centre inside.
        (rectangle(1, 257, 1, 257), &four, 9, 4),
        (rectangle(1, 257, 1, 257), &sixteen, 25, 16),
        // Thin, between centres, and thin through centres.
        (rectangle(70, 80, 0, 256), &four, 2, 0),
        (rectangle(64, 65, 0, 256), &four, 2, 2),
        (rectangle(63, 64, 0, 256), &four, 2, 0),
        // A diamond of half a pixel: eight centres lie on its sides, and the tie rule gives it half of those.
        ([[0, 128], [128, 0], [256, 128], [128, 256]], &sixteen, 16, 8),
        // Degenerate: nothing is tested.
        (rectangle(10, 10, 0, 256), &four, 0, 0),
        (rectangle(10, 200, 99, 99), &four, 0, 0),
        ([[5, 5]; 4], &four, 0, 0),
        // Partly outside the region, and all outside.
        (rectangle(-768, -384, -768, -384), &four, 1, 1),
        (rectangle(512, 768, 0, 256), &four, 0, 0),
        // One half degenerate: the box is that of the other.
        ([[0, 0], [256, 0], [256, 256], [0, 0]], &four, 4, 3),
    ];
    for (quad, samples, tests, hits) in table {
        let (counts, sink) = draw_quad(quad, Facing::Any, samples);
        assert_eq!((counts.tests, counts.hits), (tests, hits), "{quad:?}");
        assert_eq!(u64::from(sink.counts.iter().sum::<u32>()), hits);
    }
}

#[test]
fn one_sided_quads_are_tested_only_from_their_side() {
    let four = centred([2, 2], Region::new(-2, 2, -2, 2));
    let front = rectangle(0, 256, 0, 256);
    let back = [front[1], front[0], front[3], front[2]];
    assert_eq!(draw_quad(front, Facing::Only(1), &four).0, SampleCounts { tests: 4, hits: 4, backfacing: 0 });
    assert_eq!(draw_quad(back, Facing::Only(1), &four).0, SampleCounts { tests: 0, hits: 0, backfacing: 1 });
    assert_eq!(draw_quad(back, Facing::Only(-1), &four).0.hits, 4);
    // Folded along its diagonal: both halves cover the same two cells' samples, seen from either side.
    let folded = [[0, 0], [256, 0], [256, 256], [200, 10]];
    let (counts, sink) = draw_quad(folded, Facing::Any, &four);
    assert_eq!(counts.hits, u64::from(sink.counts.iter().map(|&n| n.min(1)).sum::<u32>()));
    assert!(sink.counts.contains(&2) && sink.sums.iter().all(|&sum| sum >= 0));
    let (counts, sink) = draw_quad(folded, Facing::Only(1), &four);
    assert_eq!((counts.hits, counts.backfacing), (3, 0));
    assert!(sink.sums.iter().all(|&sum| (0..=1).contains(&sum)));
}

/// Vertices of an n x n grid spread over a square of side `side_px`, turned by `angle`, about (x, y) px.
fn turned_square(n: usize, side_px: f64, angle: f64, centre_px: [f64; 2]) -> [Vec<i32>; 2] {
    let (sin, cos) = angle.sin_cos();
    let mut xy = [Vec::new(), Vec::new()];
    for j in 0..=n {
        for i in 0..=n {
            let [a, b] = [i, j].map(|k| (k as f64 / n as f64 - 0.5) * side_px);
            xy[0].push(((centre_px[0] + a * cos - b * sin) * 256.0).round() as i32);
            xy[1].push(((centre_px[1] + a * sin + b * cos) * 256.0).round() as i32);
        }
    }
    xy
}

fn draw_grid(n: usize, [x, y]: &[Vec<i32>; 2], samples: &RegionSamples) -> (SampleCounts, SignedHits) {
    let depth = vec![1.0; x.len()];
    let grid = GridView { m: n, n, x, y, depth: &depth };
    let mut counts = SampleCounts::default();
    let mut sink = SignedHits::new(samples.len());
    rasterize_grid(grid, Facing::Any, None, samples, &mut counts, &mut sink);
    (counts, sink)
}

#[test]
fn a_turned_square_covers_its_area_within_a_thousandth() {
    let samples = RegionSamples::new(&super::pattern([32, 32], 2), Region::new(-22, 22, -22, 22));
    let mut worst: f64 = 0.0;
    for step in 0..48 {
        let angle = f64::from(step) * 0.1309;
        let xy = turned_square(28, 28.0, angle, [0.37, -0.21]);
        let (_, sink) = draw_grid(28, &xy, &samples);
        assert!(sink.counts.iter().all(|&n| n < 2), "a sample was hit twice at {angle}");
        let covered = f64::from(sink.counts.iter().sum::<u32>()) / 1024.0;
        worst = worst.max((covered / (28.0 * 28.0) - 1.0).abs());
    }
    eprintln!("turned squares: within {worst:.2e} of their area");
    assert!(worst < 1e-3, "{worst}");
}

#[test]
fn skipped_vertices_take_their_quads_out() {
    let samples = centred([1, 1], Region::new(0, 4, 0, 4));
    let [x, y] = turned_square(4, 4.0, 0.0, [2.0, 2.0]);
    let mut skip = vec![false; 25];
    skip[6] = true;
    let depth = vec![1.0; 25];
    let grid = GridView { m: 4, n: 4, x: &x, y: &y, depth: &depth };
    let (mut counts, mut sink) = (SampleCounts::default(), SignedHits::new(16));
    rasterize_grid(grid, Facing::Any, Some(&skip), &samples, &mut counts, &mut sink);
    let missing: Vec<usize> = (0..16).filter(|&i| sink.counts[i] == 0).collect();
    assert_eq!(missing, [0, 1, 4, 5]);
}

#[test]
fn clipping_to_a_region_drops_hits_and_changes_none() {
    let pattern = super::pattern([3, 3], 2);
    let whole = RegionSamples::new(&pattern, Region::new(-9, 9, -9, 9));
    let part = RegionSamples::new(&pattern, Region::new(-4, 3, -1, 8));
    let xy = turned_square(5, 13.0, 0.4, [0.2, 0.1]);
    let (all, some) = (draw_grid(5, &xy, &whole).1, draw_grid(5, &xy, &part).1);
    for py in -1..8 {
        for px in -4..3 {
            for j in 0..9 {
                let [a, b] = [&whole, &part].map(|s| s.region.pixel_ix(px, py) * 9 + j);
                assert_eq!(whole.position(a), part.position(b));
                assert_eq!(whole.tuples[a], part.tuples[b]);
                assert_eq!(all.counts[a], some.counts[b]);
            }
        }
    }
}

#[test]
fn every_sample_in_a_micropolygon_is_tested_whatever_the_grid_of_cells() {
    let mut stream = Stream::new(5);
    for samples in [[1, 1], [2, 3], [7, 1], [1, 13], [16, 16], [300, 1], [1, 1024]] {
        let samples = RegionSamples::new(&super::pattern(samples, 2), Region::new(-3, 3, -3, 3));
        for _ in 0..40 {
            let mut at = || [stream.below(1536) as i32 - 768, stream.below(1536) as i32 - 768];
            let triangle = [at(), at(), at()];
            let (mut counts, mut sink) = (SampleCounts::default(), SignedHits::new(samples.len()));
            rasterize_triangle(triangle, [1.0; 3], Facing::Any, &samples, &mut counts, &mut sink);
            for ix in 0..samples.len() {
                let hit = crate::sampling::inside::triangle_hit(triangle, samples.position(ix)).is_some();
                assert_eq!(sink.counts[ix], u32::from(hit));
            }
        }
    }
}

/// STE of triangles of half a pixel: right triangles with legs of 1 px, anywhere and turned anyhow.
fn ste_of_half_pixel_triangles(samples: [u32; 2], quads: bool) -> f64 {
    let samples = RegionSamples::new(&super::pattern(samples, 2), Region::new(-2, 66, -2, 66));
    let mut stream = Stream::new(11);
    let mut counts = SampleCounts::default();
    let mut sink = SignedHits::new(samples.len());
    for _ in 0..20_000 {
        let (x, y) = (stream.next_unit() * 64.0, stream.next_unit() * 64.0);
        let (sin, cos) = (stream.next_unit() * std::f64::consts::TAU).sin_cos();
        let at = |a: f64, b: f64| [x + a * cos - b * sin, y + a * sin + b * cos].map(|v| (v * 256.0) as i32);
        let [v0, v1, v2, v3] = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
        if quads {
            rasterize_quad([v0, v1, v2, v3], [1.0; 4], Facing::Any, &samples, &mut counts, &mut sink);
        } else {
            for triangle in [[v0, v1, v2], [v0, v2, v3]] {
                rasterize_triangle(triangle, [1.0; 3], Facing::Any, &samples, &mut counts, &mut sink);
            }
        }
    }
    counts.ste()
}

#[test]
fn sample_test_efficiency_is_near_the_papers() {
    for (samples, published) in [([2, 2], 0.18), ([4, 4], 0.26)] {
        let ste = ste_of_half_pixel_triangles(samples, false);
        let quads = ste_of_half_pixel_triangles(samples, true);
        eprintln!("STE {samples:?}: triangles {ste:.3} (paper {published}), quads {quads:.3}");
        assert!((ste / published - 1.0).abs() < 0.15, "{samples:?}: {ste}");
        assert!((1.4..2.1).contains(&(quads / ste)), "quads up to twice the triangles': {quads} {ste}");
    }
}
