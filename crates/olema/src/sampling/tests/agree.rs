use std::sync::OnceLock;

use proptest::prelude::*;

use super::blurred::{AllHits, Blurred, How, brute_force, random_grid, with};
use crate::sampling::hash::Stream;
use crate::sampling::inside::GUARD_BAND;
use crate::sampling::moving::COC_LIMIT;
use crate::sampling::nomotion::{Facing, SampleCounts};
use crate::sampling::{
    Kernels, Micropolygons, MovingDraw, PatternSpec, Rasterizer, Region, RegionSamples, SamplePattern,
    TupleTimes, Unsuited,
};

const ALL: [Rasterizer; 6] = [
    Rasterizer::Auto,
    Rasterizer::NoMotion,
    Rasterizer::Interval,
    Rasterizer::InterleaveUvt,
    Rasterizer::BoundingBox,
    Rasterizer::Simple,
];

/// M of 1 to 64 with every K that InterleaveUvt takes, and K = 64 with the smaller M.
fn patterns() -> &'static [SamplePattern] {
    static PATTERNS: OnceLock<Vec<SamplePattern>> = OnceLock::new();
    PATTERNS.get_or_init(|| {
        let grids = [[1, 1], [2, 1], [2, 2], [7, 1], [3, 3], [4, 4], [5, 5], [8, 8]];
        let small = grids.iter().flat_map(|&samples| [1, 2, 3, 4, 8].map(|tile| (samples, tile)));
        let large = grids[..3].iter().map(|&samples| (samples, 64));
        small.chain(large).map(|(samples, tile)| super::pattern(samples, tile)).collect()
    })
}

fn check(grid: &Blurred, pattern: &SamplePattern, region: Region, facing: Facing) -> u64 {
    let samples = RegionSamples::new(pattern, region);
    let expected = brute_force(grid, facing, pattern, &samples);
    let times = TupleTimes::new(pattern, &grid.key_times);
    let is_still = grid.grid(&times).still().is_some();
    for rasterizer in ALL {
        let fits = pattern.tile() <= rasterizer.greatest_tile();
        if !fits || (rasterizer == Rasterizer::NoMotion && !is_still) {
            continue;
        }
        for micropolygons in [Micropolygons::Quads, Micropolygons::Triangles] {
            let mut sink = AllHits::default();
            let how = How { rasterizer, facing, micropolygons, kernels: Kernels::default() };
            let counts = grid.draw(how, pattern, &samples, &mut sink);
            assert!(
                sink.sorted() == expected,
                "{how:?}, M = {}, K = {}",
                samples.samples_per_pixel(),
                pattern.tile()
            );
            assert!(counts.hits <= counts.tests && counts.hits <= expected.len() as u64);
        }
    }
    expected.len() as u64
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, max_shrink_iters: 60, ..ProptestConfig::default() })]
    #[test]
    fn all_rasterizers_hit_the_samples_that_brute_force_hits(
        seed in any::<u32>(),
        which in 0usize..43,
        facing in prop::sample::select(vec![Facing::Any, Facing::Only(1), Facing::Only(-1)]),
        corner in (-6i32..2, -5i32..2),
    ) {
        let region = Region::new(corner.0, corner.0 + 9, corner.1, corner.1 + 7);
        let mut stream = Stream::new(seed);
        for _ in 0..3 {
            check(&random_grid(&mut stream), &patterns()[which], region, facing);
        }
    }
}

#[test]
fn random_grids_hit_something_in_every_pattern() {
    let mut stream = Stream::new(3);
    let region = Region::new(-6, 6, -5, 5);
    for pattern in patterns() {
        let hits: u64 = (0..8).map(|_| check(&random_grid(&mut stream), pattern, region, Facing::Any)).sum();
        assert!(hits > 5, "{hits} hits with M = {}", pattern.samples_per_pixel());
    }
}

#[test]
fn positions_at_their_limits_do_not_overflow() {
    let pattern = super::pattern([2, 2], 2);
    let far = GUARD_BAND;
    let grid = Blurred {
        m: 1,
        n: 1,
        key_times: vec![0.0, 1.0],
        x: vec![-far, far, -far, far, far, -far, far, -far],
        y: vec![-far, -far, far, far, -far, -far, far, far],
        depth: vec![f32::MIN_POSITIVE, f32::MAX, 1.0, 2.0, f32::INFINITY, 0.0, 3.0, 4.0],
        coc: vec![COC_LIMIT, -COC_LIMIT, COC_LIMIT, -COC_LIMIT, COC_LIMIT, COC_LIMIT, 0, -COC_LIMIT],
    };
    let samples = RegionSamples::new(&pattern, Region::new(-3, 3, -3, 3));
    for facing in [Facing::Any, Facing::Only(1), Facing::Only(-1)] {
        let hits = |rasterizer| {
            let mut sink = AllHits::default();
            grid.draw(How { facing, ..with(rasterizer) }, &pattern, &samples, &mut sink);
            sink.sorted()
        };
        let expected = brute_force(&grid, facing, &pattern, &samples);
        assert_eq!(hits(Rasterizer::Interval), expected);
        assert_eq!(hits(Rasterizer::InterleaveUvt), expected);
        assert_eq!(hits(Rasterizer::BoundingBox), expected);
    }
    // The whole frame is covered when the quad is not edge on.
    assert!(!brute_force(&grid, Facing::Any, &pattern, &samples).is_empty());
}

#[test]
fn a_blurred_grid_and_a_large_tile_are_refused() {
    let refusal = |tile, rasterizer: Rasterizer, moves: bool| {
        let pattern = SamplePattern::new(PatternSpec { tile, ..PatternSpec::default() });
        let samples = RegionSamples::new(&pattern, Region::new(0, 1, 0, 1));
        let times = TupleTimes::new(&pattern, &[0.0, 1.0]);
        let grid = Blurred::from_fn([1, 1], &[0.0, 1.0], |key, i, j| {
            [i as f64, j as f64 + if moves { key as f64 } else { 0.0 }]
        });
        let draw = MovingDraw {
            grid: grid.grid(&times),
            pattern: &pattern,
            samples: &samples,
            facing: Facing::Any,
            skip: None,
            micropolygons: Micropolygons::Quads,
            times: MovingDraw::ALL_TIMES,
            kernels: Kernels::default(),
        };
        rasterizer.rasterize(&draw, &mut SampleCounts::default(), &mut AllHits::default())
    };
    assert_eq!(refusal(2, Rasterizer::NoMotion, true), Err(Unsuited::Blurred));
    assert_eq!(refusal(2, Rasterizer::NoMotion, false), Ok(Rasterizer::NoMotion));
    assert_eq!(refusal(2, Rasterizer::Auto, false), Ok(Rasterizer::NoMotion));
    let tile = |rasterizer, tile, most| Err(Unsuited::Tile { rasterizer, tile, most });
    assert_eq!(refusal(2, Rasterizer::Simple, true), tile(Rasterizer::Simple, 2, 1));
    assert_eq!(refusal(9, Rasterizer::InterleaveUvt, true), tile(Rasterizer::InterleaveUvt, 9, 8));
    assert_eq!(refusal(64, Rasterizer::Auto, true), Ok(Rasterizer::Interval));
    assert_eq!(refusal(1, Rasterizer::Simple, true), Ok(Rasterizer::Simple));
}

#[test]
fn back_faces_are_culled_only_where_no_tuple_sees_their_front() {
    let pattern = super::pattern([4, 4], 2);
    let samples = RegionSamples::new(&pattern, Region::new(-8, 8, -8, 8));
    let front = Facing::Only(1);
    let counts = |grid: &Blurred| {
        let how = How { facing: front, ..with(Rasterizer::Interval) };
        grid.draw(how, &pattern, &samples, &mut AllHits::default())
    };
    // Seen from behind, drifting and out of focus: culled.
    let away = |key: usize, i: usize, j: usize| [-(i as f64) + 2.0 * key as f64, j as f64];
    assert_eq!(counts(&Blurred::from_fn([1, 1], &[0.0, 1.0], away)).backfacing, 1);
    let circles = Blurred::from_fn([1, 1], &[0.0, 1.0], away).defocused(3.0);
    assert_eq!((counts(&circles).backfacing, counts(&circles).tests), (1, 0));
    // Turning over in the last tenth of the shutter: kept, and only those samples hit.
    let turns = |key: usize, i: usize, j: usize| [i as f64 * [-9.0, 1.0][key], j as f64 * 4.0];
    let turned = counts(&Blurred::from_fn([1, 1], &[0.0, 1.0], turns));
    assert!(turned.backfacing == 0 && turned.hits > 0 && turned.hits * 20 < turned.tests, "{turned:?}");
    // A front at the middle key alone.
    let flips = |key: usize, i: usize, j: usize| [i as f64 * [-1.0, 1.0, -1.0][key], j as f64];
    assert_eq!(counts(&Blurred::from_fn([1, 1], &[0.0, 0.5, 1.0], flips)).backfacing, 0);
    // Circles of confusion that differ can turn a micropolygon over.
    let mut bent = Blurred::from_fn([1, 1], &[0.0], |_, i, j| [-(i as f64), j as f64]);
    bent.coc = vec![0, 700, 0, 700];
    assert_eq!(counts(&bent).backfacing, 0);
}
