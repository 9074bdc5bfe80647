use std::collections::HashSet;

use crate::sampling::hash::hash;
use crate::sampling::lens::LensShape;
use crate::sampling::pattern::{PatternSpec, SamplePattern, SetRule, Tuple};
use crate::sampling::shutter::ShutterShape;
use crate::sampling::strata::{Strata, cells_of_positions, factor_nearly_square, positions_of_cell};

/// Every grid a x b of m cells.
fn grids(m: u32) -> impl Iterator<Item = [u32; 2]> {
    (1..=m).filter(move |a| m.is_multiple_of(*a)).map(move |a| [a, m / a])
}

/// Of the wide tests: a grid of m cells, another kind for each m.
fn some_grid(m: u32) -> [u32; 2] {
    let all: Vec<_> = grids(m).collect();
    all[hash(&[m]) as usize % all.len()]
}

fn is_permutation(mut values: impl Iterator<Item = u32>, n: u32) -> bool {
    let mut seen = vec![false; n as usize];
    let all_new = values.all(|v| (v < n) && !std::mem::replace(&mut seen[v as usize], true));
    all_new && seen.iter().all(|&s| s)
}

/// The square (p, q) of a lens place (u, v), v up, by textbook functions, under the concentric map.
fn lens_square([u, v]: [f64; 2]) -> [f64; 2] {
    let radius = u.hypot(v);
    let eighths = v.atan2(u) / std::f64::consts::FRAC_PI_4;
    let [a, b] = if (-1.0..1.0).contains(&eighths) {
        [radius, radius * eighths]
    } else if (1.0..3.0).contains(&eighths) {
        [radius * (2.0 - eighths), radius]
    } else if (-3.0..-1.0).contains(&eighths) {
        [radius * (2.0 + eighths), -radius]
    } else {
        [-radius, -radius * (eighths - 4.0 * eighths.signum())]
    };
    [(a + 1.0) / 2.0, (b + 1.0) / 2.0]
}

/// The place on the lens, v up as [`LensShape`] has it.
fn lens_place(tuple: &Tuple) -> [f64; 2] {
    [f64::from(tuple.u15) / 32_768.0, -f64::from(tuple.v15) / 32_768.0]
}

fn check_cells(pattern: &SamplePattern) {
    let strata = pattern.strata();
    let (m, [a, b]) = (strata.num(), strata.grid);
    let num_ranks = pattern.tile() * pattern.tile();
    for (ix, tuple) in pattern.tuples().iter().enumerate() {
        let j = ix as u32 / num_ranks;
        let what = || format!("M {m} = {a} x {b}, K {}, stratum {j}: {tuple:?}", pattern.tile());
        for (place, cell, num) in [(tuple.x, j % a, a), (tuple.y, j / a, b)] {
            if num <= 256 {
                assert_eq!(u32::from(place) * num / 256, cell, "{}", what());
            } else {
                assert_eq!(u32::from(place), cell * 256 / num, "{}", what());
            }
        }
        assert_eq!(tuple.t15 as u32 * m / 32_768, strata.time_cell(j), "{}", what());
        let [u, v] = lens_place(tuple);
        assert!(u.hypot(v) <= 1.0, "{}", what());
        let [p, q] = if strata.rings {
            [u * u + v * v, (v.atan2(u) / std::f64::consts::TAU).rem_euclid(1.0)]
        } else {
            lens_square([u, v])
        };
        let cell = strata.lens_cell(j);
        for (axis, place) in [p, q].into_iter().enumerate() {
            if strata.rings && axis == 1 {
                continue;
            }
            let num = f64::from(strata.lens_grid[axis]);
            let off = (place * num - f64::from(cell[axis]) - 0.5).abs();
            assert!(off < 0.5 + 2e-4 * num, "axis {axis}: {place}, cell {cell:?}, {}", what());
        }
        let bounds = pattern.stratum_bounds(j);
        assert!(bounds.t15[0] <= tuple.t15 && tuple.t15 <= bounds.t15[1]);
        assert!(bounds.u15[0] <= tuple.u15 && tuple.u15 <= bounds.u15[1]);
        assert!(bounds.v15[0] <= tuple.v15 && tuple.v15 <= bounds.v15[1]);
    }
}

/// Every pixel of a tile holds a tuple of each stratum, every tuple is used once.
fn check_tile(pattern: &SamplePattern, tx: i32, ty: i32) {
    let k = pattern.tile() as i32;
    let num_ranks = (k * k) as u32;
    let mut used = vec![false; pattern.tuples().len()];
    for py in ty * k..(ty + 1) * k {
        for px in tx * k..(tx + 1) * k {
            for j in 0..pattern.samples_per_pixel() {
                let tuple = pattern.tuple_at(px, py, j);
                assert_eq!(tuple / num_ranks, j);
                assert!(!std::mem::replace(&mut used[tuple as usize], true), "tuple {tuple} twice");
                let set = pattern.set_of_tile(tx, ty);
                let pixel = ((py - ty * k) * k + px - tx * k) as u32;
                assert_eq!(pattern.pixel_of_rank(set, j, tuple % num_ranks), pixel);
            }
        }
    }
}

#[test]
fn every_number_of_samples_keeps_its_cells_and_uses_each_tuple_once_a_tile() {
    for m in 1..=1024 {
        let strata = Strata::new(some_grid(m), m);
        for dim in 0..5 {
            assert!(is_permutation(strata.columns.iter().map(|c| u32::from(c[dim])), m), "M {m}, dim {dim}");
        }
        let lens_cells: HashSet<_> = (0..m).map(|j| strata.lens_cell(j)).collect();
        assert_eq!(lens_cells.len(), m as usize);
        let lens_is_ok = |[p, q]: [u32; 2]| p < strata.lens_grid[0] && q < strata.lens_grid[1];
        assert!(lens_cells.into_iter().all(lens_is_ok));
        for tile in [1, 2, 3, 4, 8] {
            // K = 8 takes most of the time: all up to 128 samples, every seventh above.
            if tile == 8 && m > 128 && m % 7 != 0 {
                continue;
            }
            let spec = PatternSpec { tile, permutations: 16, ..PatternSpec::default() };
            let pattern = SamplePattern::with_strata(spec, strata.clone());
            assert_eq!(pattern.tuples().len() as u32, m * tile * tile);
            check_cells(&pattern);
            check_tile(&pattern, -3, 5);
        }
    }
}

#[test]
fn large_tiles_work_at_both_ends() {
    for samples in [[1, 1], [4, 4], [32, 32]] {
        let pattern = super::pattern(samples, 64);
        check_cells(&pattern);
        check_tile(&pattern, -1, 0);
        assert_eq!(size_of_val(pattern.tuples()), (samples[0] * samples[1]) as usize * 4096 * 8);
    }
}

#[test]
fn the_columns_of_a_stratum_lie_in_its_sub_pixel_cell() {
    for m in [1, 2, 7, 12, 16, 30, 64, 97] {
        for [a, b] in grids(m) {
            let strata = Strata::new([a, b], 3);
            for (j, columns) in strata.columns.iter().enumerate() {
                assert_eq!(u32::from(columns[0]) / b, j as u32 % a);
                assert_eq!(u32::from(columns[1]) / a, j as u32 / a);
            }
        }
    }
}

#[test]
fn a_seven_by_one_grid_is_spread_in_y_too() {
    let pattern = super::pattern([7, 1], 2);
    for (px, py) in [(0, 0), (-5, 8)] {
        let rows = (0..7).map(|j| (pattern.position(px, py, j).1 - py * 256) as u32 * 7 / 256);
        assert!(is_permutation(rows, 7));
    }
}

#[test]
fn cells_and_positions_agree_for_every_grid() {
    for num in 1..=1024 {
        let mut hit = vec![0; 256];
        for cell in 0..num {
            let (first, last) = positions_of_cell(cell, num, 256);
            assert!(first <= last && last < 256);
            for position in first..=last {
                hit[position as usize] += 1;
                let (from, to) = cells_of_positions(position, position, num);
                assert!(
                    (from..=to).contains(&cell),
                    "cell {cell} of {num}, position {position}: {from}..={to}"
                );
            }
        }
        if num <= 256 {
            assert!(hit.iter().all(|&n| n == 1), "{num} cells");
        } else {
            assert_eq!(hit.iter().sum::<u32>(), num);
        }
        for (first, last) in [(0, 255), (3, 3), (17, 200)] {
            let (from, to) = cells_of_positions(first, last, num);
            let naive: Vec<u32> = (0..num)
                .filter(|&cell| {
                    let (least, most) = positions_of_cell(cell, num, 256);
                    least <= last && most >= first
                })
                .collect();
            assert_eq!((from..=to).collect::<Vec<_>>(), naive, "{num} cells, {first}..={last}");
        }
    }
}

#[test]
fn a_sample_is_the_same_whoever_asks_also_at_negative_pixels() {
    let spec = PatternSpec { samples: [3, 2], tile: 3, seed: 9, ..PatternSpec::default() };
    let (one, other) = (SamplePattern::new(spec.clone()), SamplePattern::new(spec.clone()));
    let another_seed = SamplePattern::new(PatternSpec { seed: 10, ..spec });
    let mut same = 0;
    for py in -20..20 {
        for px in -20..20 {
            for j in 0..6 {
                assert_eq!(one.position(px, py, j), other.position(px, py, j));
                let (x, y) = one.position(px, py, j);
                assert_eq!((x.div_euclid(256), y.div_euclid(256)), (px, py));
                same += usize::from(one.position(px, py, j) == another_seed.position(px, py, j));
            }
        }
    }
    assert!(same < 100, "{same} of 9600 alike under another seed");
}

#[test]
fn stored_and_computed_permutations_are_the_same() {
    // With more sets than can be stored, the first sets still are what they were.
    let few = super::pattern([2, 2], 4);
    let spec = PatternSpec { samples: [2, 2], tile: 4, permutations: 65_536, ..PatternSpec::default() };
    let many = SamplePattern::new(spec);
    for set in 0..64 {
        for stratum in 0..4 {
            for pixel in 0..16 {
                let rank = few.rank_of_pixel(set, stratum, pixel);
                assert_eq!(many.rank_of_pixel(set, stratum, pixel), rank);
                assert_eq!(many.pixel_of_rank(set, stratum, rank), pixel);
            }
        }
    }
}

#[test]
fn sets_are_used_about_as_often_and_the_published_rule_is_the_formula() {
    let pattern = super::pattern([1, 1], 2);
    let mut counts = vec![0u32; 64];
    for ty in -80..80 {
        for tx in -80..80 {
            counts[pattern.set_of_tile(tx, ty) as usize] += 1;
        }
    }
    assert!(counts.iter().all(|&n| (300..500).contains(&n)), "{counts:?}");
    let set_rule = SetRule::Published { width: 641 };
    let published = SamplePattern::new(PatternSpec { set_rule, ..PatternSpec::default() });
    assert_eq!(published.set_of_tile(5, 7), (7 * 320 + 5 + 5 + 7) % 64);
    assert_eq!(published.set_of_tile(-1, 0), 62);
}

#[test]
fn without_jitter_samples_sit_in_the_centres_of_their_cells() {
    let spec = PatternSpec { samples: [2, 2], jitter: false, ..PatternSpec::default() };
    let pattern = SamplePattern::new(spec);
    let places: Vec<_> = (0..4).map(|j| pattern.position(-1, 2, j)).collect();
    assert_eq!(places, [(-192, 576), (-64, 576), (-192, 704), (-64, 704)]);
    let times: HashSet<_> = pattern.tuples().iter().map(|t| t.t15).collect();
    assert_eq!(times.len(), 16, "times stay different");
    let one = SamplePattern::new(PatternSpec { samples: [1, 1], jitter: false, ..PatternSpec::default() });
    assert_eq!(one.position(0, 0, 0), (128, 128));
}

#[test]
fn a_tile_has_as_many_times_as_tuples() {
    for (samples, tile) in [([4, 4], 2), ([4, 4], 3), ([8, 8], 2), ([1, 1], 8), ([7, 1], 3)] {
        let pattern = super::pattern(samples, tile);
        let n = pattern.tuples().len() as u32;
        let intervals = pattern.tuples().iter().map(|t| t.t15 as u32 * n / 32_768);
        // Rounding to 1/32768 may move a time over the border of its interval.
        let distinct: HashSet<_> = intervals.collect();
        assert!(distinct.len() as u32 + 1 >= n, "{n} tuples, {} times", distinct.len());
    }
}

/// Correlation coefficient of two lists.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len() as f64;
    let mean = |v: &[f64]| v.iter().sum::<f64>() / n;
    let (ma, mb) = (mean(a), mean(b));
    let product = |a: &[f64], ma: f64, b: &[f64], mb: f64| {
        a.iter().zip(b).map(|(a, b)| (a - ma) * (b - mb)).sum::<f64>()
    };
    product(a, ma, b, mb) / (product(a, ma, a, ma) * product(b, mb, b, mb)).sqrt()
}

#[test]
fn time_lens_and_place_are_not_correlated() {
    let mut bad = false;
    for (samples, bound) in [([3, 3], 0.25), ([4, 4], 0.15), ([8, 8], 0.1), ([8, 16], 0.08), ([32, 32], 0.08)]
    {
        let (mut worst, mut mean) = (0.0f64, 0.0);
        for seed in 0..20 {
            let pattern = SamplePattern::new(PatternSpec { samples, seed, ..PatternSpec::default() });
            let column = |of: fn(&Tuple) -> f64| pattern.tuples().iter().map(of).collect::<Vec<_>>();
            let (x, y) = (column(|t| f64::from(t.x)), column(|t| f64::from(t.y)));
            let (u, v) = (column(|t| f64::from(t.u15)), column(|t| f64::from(t.v15)));
            let t = column(|t| f64::from(t.t15));
            for (a, b) in [(&t, &u), (&t, &v), (&t, &x), (&t, &y), (&u, &x), (&u, &y), (&v, &x), (&v, &y)] {
                worst = worst.max(correlation(a, b).abs());
                mean += correlation(a, b).powi(2) / 160.0;
            }
        }
        eprintln!("{samples:?}: correlation {:.3}, worst {worst:.3}", mean.sqrt());
        bad |= worst >= bound;
    }
    assert!(!bad);
}

#[test]
fn shapes_of_lens_and_shutter_reach_the_tuples() {
    let spec = PatternSpec {
        samples: [16, 16],
        lens: LensShape::Blades { num: 4, rotation: 0.0 },
        shutter: ShutterShape::Trapezoid { open: 0.5, close: 0.5 },
        ..PatternSpec::default()
    };
    let pattern = SamplePattern::new(spec);
    let inner = pattern.tuples().iter().filter(|t| (8192..24_576).contains(&t.t15)).count();
    let share = inner as f64 / pattern.tuples().len() as f64;
    assert!((share - 0.75).abs() < 0.01, "{share} of the times in the middle half of a triangle");
    for tuple in pattern.tuples() {
        assert!(i32::from(tuple.u15).abs() + i32::from(tuple.v15).abs() <= 32_768);
    }
}

#[test]
fn grids_are_as_near_square_as_divides() {
    let expected = [(1, [1, 1]), (2, [2, 1]), (12, [4, 3]), (16, [4, 4]), (97, [97, 1]), (1000, [40, 25])];
    for (m, grid) in expected {
        assert_eq!(factor_nearly_square(m), grid);
    }
}

/// What defocus shows of a highlight: a copy for each tuple, at its place on the lens.
#[test]
fn the_tuples_of_a_tile_fill_the_lens() {
    let shares = |tile, parts: f64| {
        let pattern = super::pattern([4, 4], tile);
        let part = |tuple: &Tuple| lens_square(lens_place(tuple)).map(|v| (v * parts) as usize);
        pattern.tuples().iter().map(part).collect::<HashSet<_>>().len() as f64 / (parts * parts)
    };
    // Of 8 x 8 and 16 x 16 parts of equal area, 64 tuples can take each; 256 and 1024 should take nearly all.
    // Columns of width 1/M along p and q alone would leave them in 1/16 of the lens.
    let [two, four, eight] = [(2, 8.0), (4, 8.0), (8, 16.0)].map(|(tile, parts)| shares(tile, parts));
    eprintln!("lens taken by the tuples of a tile: K = 2 {two:.2}, K = 4 {four:.2}, K = 8 {eight:.2}");
    assert!(two > 0.6 && four > 0.95 && eight > 0.95, "{two} {four} {eight}");
}

/// A highlight behind the focus shows the opening as it is: blades turned counter-clockwise are so in the picture.
#[test]
fn blades_turn_counter_clockwise_in_the_picture() {
    // A triangle with a corner to the right, an eighth of a turn on: a corner up and right.
    let lens = LensShape::Blades { num: 3, rotation: 0.125 };
    let pattern = SamplePattern::new(PatternSpec { samples: [16, 16], lens, ..PatternSpec::default() });
    let reach = |right: bool, up: bool| {
        let seen = pattern.tuples().iter().filter(|t| (t.u15 > 0) == right && (t.v15 < 0) == up);
        seen.map(|t| f64::from(t.u15).hypot(f64::from(t.v15))).fold(0.0, f64::max) / 32_768.0
    };
    assert!(reach(true, true) > 0.95, "a corner");
    assert!(reach(false, false) < 0.75, "the middle of a side, 0.71 at most");
}

#[test]
fn a_lens_scale_makes_ellipses() {
    let spec = PatternSpec { samples: [16, 16], ..PatternSpec::default() };
    let round = SamplePattern::new(spec.clone());
    let flat = SamplePattern::new(PatternSpec { lens_scale: [1.0, 0.5], ..spec });
    for (flat, round) in flat.tuples().iter().zip(round.tuples()) {
        assert_eq!((flat.u15, flat.t15, flat.x, flat.y), (round.u15, round.t15, round.x, round.y));
        assert!((2 * i32::from(flat.v15) - i32::from(round.v15)).abs() <= 1);
    }
}
