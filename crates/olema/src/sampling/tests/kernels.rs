//! Kernels in lanes against their scalar twins: the same hits at every level, and the same counts, but for the tests that
//! InterleaveUvt leaves out.

use proptest::prelude::*;

use super::blurred::{AllHits, Blurred, FullHit, How, random_grid};
use crate::math::simd::SimdLevel;
use crate::sampling::hash::Stream;
use crate::sampling::nomotion::{Facing, SampleCounts};
use crate::sampling::{
    Kernels, Micropolygons, MovingDraw, PatternSpec, Rasterizer, Region, RegionSamples, SamplePattern,
    TupleTimes,
};

const GRIDS: [[u32; 2]; 8] = [[1, 1], [3, 1], [2, 2], [7, 1], [4, 4], [5, 5], [8, 8], [16, 1]];

/// Hits in order, and counts.
type Work = (Vec<FullHit>, SampleCounts);

fn work(grid: &Blurred, how: How, times: [i16; 2], pattern: &SamplePattern, samples: &RegionSamples) -> Work {
    let table = TupleTimes::new(pattern, &grid.key_times);
    let How { rasterizer, facing, micropolygons, kernels } = how;
    let grid = grid.grid(&table);
    let draw = MovingDraw { grid, pattern, samples, facing, skip: None, micropolygons, times, kernels };
    let (mut sink, mut counts) = (AllHits::default(), SampleCounts::default());
    rasterizer.rasterize(&draw, &mut counts, &mut sink).expect("suited");
    (sink.sorted(), counts)
}

/// Draws with every rasterizer that can, in scalar code and in lanes; the number of hits.
fn compare(
    grid: &Blurred,
    facing: Facing,
    times: [i16; 2],
    pattern: &SamplePattern,
    region: Region,
) -> usize {
    let samples = RegionSamples::new(pattern, region);
    let table = TupleTimes::new(pattern, &grid.key_times);
    let mut num_hits = 0;
    for rasterizer in Rasterizer::ALL {
        let cannot = rasterizer == Rasterizer::NoMotion && grid.grid(&table).still().is_none();
        if cannot || pattern.tile() > rasterizer.greatest_tile() || rasterizer == Rasterizer::Auto {
            continue;
        }
        for micropolygons in [Micropolygons::Quads, Micropolygons::Triangles] {
            let how = How { rasterizer, facing, micropolygons, kernels: Kernels::Scalar };
            let expected = work(grid, how, times, pattern, &samples);
            num_hits += expected.0.len();
            for level in SimdLevel::all() {
                let how = How { kernels: Kernels::Lanes(level), ..how };
                let found = work(grid, how, times, pattern, &samples);
                let (m, k) = (pattern.samples_per_pixel(), pattern.tile());
                let leaves_out = matches!(rasterizer, Rasterizer::InterleaveUvt | Rasterizer::Simple)
                    && (found.1.hits..=expected.1.tests).contains(&found.1.tests);
                let tests = if leaves_out { found.1.tests } else { expected.1.tests };
                let expected_counts = SampleCounts { tests, ..expected.1 };
                assert_eq!(found.1, expected_counts, "{how:?}, M = {m}, K = {k}, {region:?}");
                assert!(found.0 == expected.0, "hits: {how:?}, M = {m}, K = {k}, {region:?}");
            }
        }
    }
    num_hits
}

/// What [`random_grid`] does not make: far away, as large as 16 bits hold or larger, fast, and on pixel borders.
fn stretched(mut grid: Blurred, stream: &mut Stream) -> Blurred {
    let factor = [1, 1, 1, 4, 30, 300][stream.below(6) as usize];
    let [dx, dy] = match stream.below(5) {
        0 => [1 << 28, -(1 << 28)],
        1 => [40_000, 3000],
        _ => [0, 0],
    };
    let snap = if stream.below(4) == 0 { !0xff } else { !0 };
    let place = |v: i32, by: i32| ((v * factor) & snap) + by;
    grid.x.iter_mut().for_each(|x| *x = place(*x, dx));
    grid.y.iter_mut().for_each(|y| *y = place(*y, dy));
    let coc_factor = [1, 1, 1, 20, 2000][stream.below(5) as usize];
    grid.coc.iter_mut().for_each(|c| *c *= coc_factor);
    match stream.below(4) {
        0 => grid.depth.iter_mut().for_each(|z| *z = 2.0),
        1 => grid.depth[0] = f32::INFINITY,
        _ => {}
    }
    // Some vertices in one place.
    if stream.below(3) == 0 {
        let [from, to] = [0, 1].map(|_| stream.below(grid.x.len() as u32) as usize);
        (grid.x[to], grid.y[to]) = (grid.x[from], grid.y[from]);
    }
    grid
}

fn random_case(seed: u32) -> usize {
    let mut stream = Stream::new(seed);
    let samples = GRIDS[stream.below(GRIDS.len() as u32) as usize];
    let tile = 1 + stream.below(8);
    let pattern = super::pattern(samples, tile);
    let corner = [0, 1].map(|_| stream.below(12) as i32 - 8);
    let size = [0, 1].map(|_| 1 + stream.below(14) as i32);
    let region = Region::new(corner[0], corner[0] + size[0], corner[1], corner[1] + size[1]);
    let facing = [Facing::Any, Facing::Only(1), Facing::Only(-1)][stream.below(3) as usize];
    let times = match stream.below(3) {
        0 => [stream.below(20_000) as i16, 12_000 + stream.below(20_000) as i16],
        _ => MovingDraw::ALL_TIMES,
    };
    let mut num_hits = 0;
    for _ in 0..4 {
        let grid = random_grid(&mut stream);
        let grid = stretched(grid, &mut stream);
        num_hits += compare(&grid, facing, times, &pattern, region);
    }
    num_hits
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, max_shrink_iters: 0, ..ProptestConfig::default() })]
    #[test]
    fn lanes_hit_and_count_what_their_twins_do(seed: u32) {
        random_case(seed);
    }
}

#[test]
fn fixed_seeds_hit_something_and_agree() {
    let hits: usize = (0..400).chain([1_628_938_411, 4_047_488_089]).map(random_case).sum();
    assert!(hits > 50_000, "{hits}");
}

/// Scalar code draws a grid, lanes one whose first vertex is 1/256 px to the right: how often that shows.
#[test]
fn a_kernel_that_is_off_by_the_least_step_is_noticed() {
    for rasterizer in Rasterizer::ALL.into_iter().filter(|rasterizer| *rasterizer != Rasterizer::Auto) {
        let pattern = super::pattern([4, 4], 2.min(rasterizer.greatest_tile()));
        let samples = RegionSamples::new(&pattern, Region::new(-6, 6, -5, 5));
        let (mut seen, mut noticed) = (0, 0);
        for seed in 0..300 {
            let mut grid = random_grid(&mut Stream::new(seed));
            if rasterizer == Rasterizer::NoMotion {
                grid.key_times = vec![0.0];
                grid.coc.clear();
                let num = (grid.m + 1) * (grid.n + 1);
                grid.x.truncate(num);
                grid.y.truncate(num);
                grid.depth.truncate(num);
            }
            let how = How { rasterizer, ..super::blurred::with(rasterizer) };
            let of = |grid: &Blurred, kernels: Kernels| {
                work(grid, How { kernels, ..how }, MovingDraw::ALL_TIMES, &pattern, &samples)
            };
            let expected = of(&grid, Kernels::Scalar);
            grid.x[0] += 1;
            let found = of(&grid, Kernels::default());
            seen += u32::from(!expected.0.is_empty());
            noticed += u32::from(found.0 != expected.0);
        }
        assert!(noticed * 4 > seen && seen > 100, "{rasterizer:?}: {noticed} of {seen}");
    }
}

/// Further than 16 bits reach (125 px), and back within the region at different times for different quads.
#[test]
fn what_moves_fast_is_hit_as_by_scalar_code() {
    for (speed, radius) in [(130.0, 0.0), (900.0, 5.0), (20_000.0, 30.0)] {
        let pattern = SamplePattern::new(PatternSpec { samples: [4, 4], tile: 2, ..PatternSpec::default() });
        let at = |key: usize, i: usize, j: usize| {
            let time = key as f64 - 0.4;
            [3.0 + 0.9 * i as f64 + 0.1 * j as f64 + speed * time, 5.0 + 0.8 * j as f64 - 0.3 * speed * time]
        };
        let grid = Blurred::from_fn([7, 5], &[0.0, 1.0], at).defocused(radius);
        let num = compare(&grid, Facing::Any, MovingDraw::ALL_TIMES, &pattern, Region::new(-20, 44, -30, 30));
        assert!(num > 0 || speed > 10_000.0, "{speed} px: nothing is hit");
    }
}

/// Grids of as many quads as frames have them, up to many more rows and columns than a vector and a word hold.
#[test]
fn grids_of_all_widths_are_hit_as_by_scalar_code() {
    let pattern = super::pattern([4, 4], 2);
    for (size, turn) in [(0.6, 0.0), (0.9, 0.8), (1.3, 0.1), (1.9, 2.5), (2.4, 4.0), (3.1, 1.6), (5.0, 0.4)] {
        let (sin, cos) = f64::sin_cos(turn);
        let at = |key: usize, i: usize, j: usize| {
            let [a, b] = [i, j].map(|n| (n as f64 - 8.0) * size);
            [7.3 + 2.0 * key as f64 + a * cos - b * sin, 11.9 + a * sin + b * cos]
        };
        let grid = Blurred::from_fn([16, 16], &[0.0, 1.0], at).defocused(1.5);
        let num = compare(&grid, Facing::Any, MovingDraw::ALL_TIMES, &pattern, Region::new(-31, 41, -25, 47));
        assert!(num > 1000, "{size} px: {num} hits");
    }
}
