//! Coverage against closed forms, and how the error falls with the number of samples.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::SignedHits;
use super::blurred::{Blurred, with};
use crate::sampling::hash::Stream;
use crate::sampling::{PatternSpec, Rasterizer, Region, RegionSamples, SamplePattern, ShutterShape};

/// Part of each pixel's samples that are hit.
fn coverage(grid: &Blurred, pattern: &SamplePattern, region: Region) -> Vec<f64> {
    let samples = RegionSamples::new(pattern, region);
    let mut sink = SignedHits::new(samples.len());
    grid.draw(with(Rasterizer::Auto), pattern, &samples, &mut sink);
    let m = samples.samples_per_pixel();
    let share = |pixel: &[u32]| pixel.iter().filter(|&&n| n > 0).count() as f64 / m as f64;
    sink.counts.chunks(m).map(share).collect()
}

/// Greatest and root mean square difference of a pixel from the closed form, in standard errors of 4096
/// independent samples: 4 seeds of 1024.
fn errors(
    grid: &Blurred,
    region: Region,
    shutter: ShutterShape,
    truth: impl Fn(f64, f64) -> f64,
) -> [f64; 2] {
    let mut mean = vec![0.0; region.num_pixels()];
    for seed in 0..4 {
        let spec = PatternSpec { samples: [32, 32], tile: 1, seed, shutter, ..PatternSpec::default() };
        for (sum, share) in mean.iter_mut().zip(coverage(grid, &SamplePattern::new(spec), region)) {
            *sum += share / 4.0;
        }
    }
    let (mut worst, mut squares) = (0.0f64, 0.0);
    for py in region.y0..region.y1 {
        for px in region.x0..region.x1 {
            let expected = over_pixel(f64::from(px), f64::from(py), &truth);
            let sigma = (expected * (1.0 - expected) / 4096.0).sqrt().max(1.0 / 4096.0);
            let error = (mean[region.pixel_ix(px, py)] - expected).abs() / sigma;
            worst = worst.max(error);
            squares += error * error / region.num_pixels() as f64;
        }
    }
    [worst, squares.sqrt()]
}

/// Whether no pixel is off by more than chance allows among so many, and most are well below.
fn is_sampling_error([worst, mean]: [f64; 2]) -> bool {
    worst < 3.0 && mean < 0.75
}

/// Mean of a function over a pixel.
fn over_pixel(px: f64, py: f64, of: &impl Fn(f64, f64) -> f64) -> f64 {
    let n = 48;
    let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n);
    (0..n * n).map(|i| of(px + at(i % n), py + at(i / n))).sum::<f64>() / f64::from(n * n)
}

/// A half plane whose border goes along y, at x = `from` first and `to` last.
fn half_plane(from: f64, to: f64) -> Blurred {
    Blurred::from_fn([1, 1], &[0.0, 1.0], |key, i, j| {
        [if i == 0 { -60.0 } else { [from, to][key] }, -60.0 + 120.0 * j as f64]
    })
}

/// Part of the unit disk with u above `s`.
fn disk_beyond(s: f64) -> f64 {
    let s = s.clamp(-1.0, 1.0);
    0.5 - (s.asin() + s * (1.0 - s * s).sqrt()) / PI
}

/// Area that disks of radius a and b share, their centres d apart.
fn shared_area(a: f64, b: f64, d: f64) -> f64 {
    if d >= a + b {
        return 0.0;
    }
    if d <= (a - b).abs() {
        return PI * a.min(b).powi(2);
    }
    let angle = |a: f64, b: f64| ((d * d + a * a - b * b) / (2.0 * d * a)).clamp(-1.0, 1.0).acos();
    let segment = |a: f64, angle: f64| a * a * (angle - angle.sin() * angle.cos());
    segment(a, angle(a, b)) + segment(b, angle(b, a))
}

/// Part of time in which the edge is beyond x.
fn moving_edge(x: f64) -> f64 {
    let (from, to) = (0.13, 5.37);
    1.0 - ((x - from) / (to - from)).clamp(0.0, 1.0)
}

#[test]
fn a_moving_edge_covers_pixels_for_its_share_of_time_and_a_biased_shutter_does_not() {
    let region = Region::new(-1, 7, 0, 2);
    let error = |shutter| errors(&half_plane(0.13, 5.37), region, shutter, |x, _| moving_edge(x));
    let (even, biased) = (error(ShutterShape::Box), error(ShutterShape::Trapezoid { open: 0.1, close: 1.0 }));
    eprintln!(
        "moving edge: {even:.2?} standard errors of 4096 (worst pixel, mean); with a biased shutter {biased:.2?}"
    );
    assert!(is_sampling_error(even) && !is_sampling_error(biased), "{even:?} {biased:?}");
}

#[test]
fn a_rotating_square_covers_each_radius_for_its_share_of_a_turn() {
    let half = 4.0;
    let num_keys = 33;
    let key_times: Vec<f32> = (0..num_keys).map(|key| key as f32 / 32.0).collect();
    let square = Blurred::from_fn([1, 1], &key_times, |key, i, j| {
        let (sin, cos) = (FRAC_PI_2 * key as f64 / 32.0).sin_cos();
        let [a, b] = [i, j].map(|v| half * (2.0 * v as f64 - 1.0));
        [a * cos - b * sin, a * sin + b * cos]
    });
    // A circle of radius r above the half side is outside of the square in four arcs of 2 acos(half / r).
    let truth = |x: f64, y: f64| {
        let r = x.hypot(y);
        if r <= half { 1.0 } else { (1.0 - 4.0 / PI * (half / r).acos()).max(0.0) }
    };
    let error = errors(&square, Region::new(-6, 6, -6, 6), ShutterShape::Box, truth);
    eprintln!("rotating square: {error:.2?} standard errors of 4096");
    assert!(is_sampling_error(error), "{error:?}");
}

#[test]
fn a_defocused_edge_has_the_profile_of_the_disk() {
    for radius in [0.7, 3.0] {
        let edge = half_plane(0.3, 0.3).defocused(radius);
        let truth = |x: f64, _| disk_beyond((x - 0.3) / radius);
        let error = errors(&edge, Region::new(-4, 5, -1, 1), ShutterShape::Box, truth);
        eprintln!("edge out of focus by {radius} px: {error:.2?} standard errors of 4096");
        assert!(is_sampling_error(error), "{error:?}");
    }
}

#[test]
fn a_defocused_disk_has_the_profile_of_two_disks() {
    let (disk, circle, sides) = (1.5, 3.5, 48);
    // The polygon has the disk's area.
    let step = TAU / f64::from(sides);
    let rim = disk * (step / step.sin()).sqrt();
    let polygon = Blurred::from_fn([sides as usize, 1], &[0.0], |_, i, j| {
        let (sin, cos) = ((i % sides as usize) as f64 * step).sin_cos();
        [0.2 + rim * cos * j as f64, -0.1 + rim * sin * j as f64]
    });
    let truth = |x: f64, y: f64| shared_area(disk, circle, (x - 0.2).hypot(y + 0.1)) / (PI * circle * circle);
    let error = errors(&polygon.defocused(circle), Region::new(-6, 6, -6, 6), ShutterShape::Box, truth);
    eprintln!("disk out of focus: {error:.2?} standard errors of 4096");
    assert!(is_sampling_error(error), "{error:?}");
}

/// Root mean square error, with M = side^2, of the pixel that edges of random place and direction cross, which
/// move by up to `motion` px and are out of focus by `radius` px.
fn edge_error(side: u32, motion: f64, radius: f64) -> f64 {
    let num = 120;
    let mut stream = Stream::new(4);
    let mut sum = 0.0;
    for case in 0..num {
        let pattern = SamplePattern::new(PatternSpec {
            samples: [side, side],
            tile: if side < 32 { 2 } else { 1 },
            seed: case % 12,
            ..PatternSpec::default()
        });
        let (sin, cos) = (stream.next_unit() * TAU).sin_cos();
        let (offset, speed) = (stream.next_unit() - 0.5, motion * (2.0 * stream.next_unit() - 1.0));
        // The border goes through (a, b) along (-sin, cos) and moves along (cos, sin).
        let edge = Blurred::from_fn([1, 1], &[0.0, 1.0], |key, i, j| {
            let along = 60.0 * (2.0 * j as f64 - 1.0);
            let far = if i == 0 { -60.0 } else { offset + speed * (key as f64 - 0.5) };
            [0.5 + cos * far - sin * along, 0.5 + sin * far + cos * along]
        })
        .defocused(radius);
        // The vertices are rounded to 1/256 px: so is the truth, from those of the border's ends.
        let at = |key: usize| {
            let [b, d] = [key * 4 + 1, key * 4 + 3].map(|ix| [edge.x[ix], edge.y[ix]].map(f64::from));
            let way = [d[0] - b[0], d[1] - b[1]];
            let normal = [way[1], -way[0]].map(|v| v / way[0].hypot(way[1]));
            (normal, (b[0] * normal[0] + b[1] * normal[1]) / 256.0)
        };
        let ((normal, from), (_, to)) = (at(0), at(1));
        let times = 32;
        let truth = |x: f64, y: f64| {
            let place = x * normal[0] + y * normal[1];
            let at_time = |t: i32| from + (to - from) * (f64::from(t) + 0.5) / f64::from(times);
            (0..times).map(|t| disk_beyond((place - at_time(t)) / radius)).sum::<f64>() / f64::from(times)
        };
        let expected = over_pixel(0.0, 0.0, &truth);
        sum += (coverage(&edge, &pattern, Region::new(0, 1, 0, 1))[0] - expected).powi(2);
    }
    (sum / f64::from(num)).sqrt()
}

/// Independent samples have a slope of -0.5. An indicator over n dimensions, all stratified together, has
/// -(1 + 1/n) / 2: -0.75 in the plane, -0.67 with time, -0.62 with the lens, -0.6 with both; the pattern
/// stratifies place, time and lens each, and all five together only as far as they are well paired.
#[test]
fn the_error_falls_with_the_number_of_samples_as_stratified_sampling_does() {
    for (name, motion, radius, limit) in [
        ("still", 0.0, 1e-9, -0.65),
        ("moving", 3.0, 1e-9, -0.6),
        ("out of focus", 0.0, 1.0, -0.6),
        ("both", 3.0, 1.0, -0.5),
    ] {
        let points = [2u32, 4, 8, 16, 32]
            .map(|side| (f64::from(side * side).ln(), edge_error(side, motion, radius).ln()));
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
        let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
        let slope = mean(&|p| (p.0 - x) * (p.1 - y)) / mean(&|p| (p.0 - x) * (p.0 - x));
        let errors = points.map(|p| format!("{:.5}", p.1.exp())).join(" ");
        eprintln!("edges, {name}, 4 to 1024 samples: error {errors}, slope {slope:.2}");
        assert!(slope < limit, "{name}: {slope}");
    }
}
