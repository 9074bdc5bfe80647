use crate::sampling::hash::{Stream, hash};
use crate::sampling::{PatternSpec, SamplePattern};

/// A sample as numbers: x, y in the pixel, time, lens.
type Point = [f64; 5];

/// Sample sets of many pixels, M points each.
fn pattern_pixels(spec: &PatternSpec, num: u32) -> Vec<Vec<Point>> {
    let pattern = SamplePattern::new(spec.clone());
    (0..num)
        .map(|i| {
            let (px, py) = ((i % 61) as i32 - 30, (i / 61) as i32 - 30);
            (0..pattern.samples_per_pixel())
                .map(|j| {
                    let t = pattern.tuples()[pattern.tuple_at(px, py, j) as usize];
                    let place = [t.x, t.y].map(|v| (f64::from(v) + 0.5) / 256.0);
                    let [u, v, time] = [t.u15, t.v15, t.t15].map(|v| (f64::from(v) + 0.5) / 32_768.0);
                    [place[0], place[1], time, u, v]
                })
                .collect()
        })
        .collect()
}

/// A place of the disk as a function of two numbers in [0, 1).
fn disk(p: f64, q: f64) -> [f64; 2] {
    let (sin, cos) = (q * std::f64::consts::TAU).sin_cos();
    [p.sqrt() * cos, p.sqrt() * sin]
}

/// Independent samples.
fn random_pixels(m: u32, num: u32, seed: u32) -> Vec<Vec<Point>> {
    let mut stream = Stream::new(hash(&[seed, 40]));
    let mut point = move || {
        let [u, v] = disk(stream.next_unit(), stream.next_unit());
        [stream.next_unit(), stream.next_unit(), stream.next_unit(), u, v]
    };
    (0..num).map(|_| (0..m).map(|_| point()).collect()).collect()
}

/// Stratified as a ray tracer does: a jittered n x n grid, jittered time and rings of the lens, each shuffled
/// on its own in each pixel.
fn jittered_pixels(n: u32, num: u32, seed: u32) -> Vec<Vec<Point>> {
    let mut stream = Stream::new(hash(&[seed, 41]));
    let m = n * n;
    (0..num)
        .map(|_| {
            let mut shuffled = || {
                let mut order: Vec<u32> = (0..m).collect();
                for i in (1..m).rev() {
                    order.swap(i as usize, stream.below(i + 1) as usize);
                }
                order
            };
            let (times, lens) = (shuffled(), shuffled());
            (0..m)
                .map(|j| {
                    let [jx, jy, jt, jp, jq] = std::array::from_fn(|_| stream.next_unit());
                    let (cell_p, cell_q) = (lens[j as usize] % n, lens[j as usize] / n);
                    let nf = f64::from(n);
                    let [u, v] = disk((f64::from(cell_p) + jp) / nf, (f64::from(cell_q) + jq) / nf);
                    let x = (f64::from(j % n) + jx) / nf;
                    let y = (f64::from(j / n) + jy) / nf;
                    [x, y, (f64::from(times[j as usize]) + jt) / f64::from(m), u, v]
                })
                .collect()
        })
        .collect()
}

/// How far edges move over the shutter and how large their circle of confusion is, in pixels.
#[derive(Clone, Copy)]
struct Blur {
    motion: f64,
    focus: f64,
}

/// Root mean square error of the coverage by half planes of random direction and place.
fn error(pixels: &[Vec<Point>], blur: Blur) -> f64 {
    let mut stream = Stream::new(77);
    let reference = &random_reference();
    let mut sum = 0.0;
    for points in pixels {
        let (sin, cos) = (stream.next_unit() * std::f64::consts::TAU).sin_cos();
        let (mx, my) = {
            let (s, c) = (stream.next_unit() * std::f64::consts::TAU).sin_cos();
            (c * blur.motion, s * blur.motion)
        };
        let offset = (stream.next_unit() - 0.5) * 0.9;
        let covers = |p: &Point| {
            let x = p[0] - 0.5 - mx * (p[2] - 0.5) - blur.focus * p[3];
            let y = p[1] - 0.5 - my * (p[2] - 0.5) - blur.focus * p[4];
            x * cos + y * sin < offset
        };
        let share =
            |points: &[Point]| points.iter().filter(|p| covers(p)).count() as f64 / points.len() as f64;
        sum += (share(points) - share(reference)).powi(2);
    }
    (sum / pixels.len() as f64).sqrt()
}

/// 4096 points of a rank-1 lattice: far below the errors measured.
fn random_reference() -> Vec<Point> {
    let n = 4096;
    (0..n)
        .map(|i| {
            let at = |a: f64| (f64::from(i) * a + 0.5).fract();
            let [u, v] = disk(at(0.790_021_098_857), at(0.702_224_149_1));
            [at(0.888_834_868_05), (f64::from(i) + 0.5) / f64::from(n), at(0.624_152_9), u, v]
        })
        .collect()
}

fn decibels(error: f64, reference: f64) -> f64 {
    20.0 * (reference / error).log10()
}

#[test]
fn moving_edges_are_less_noisy_than_random_samples() {
    let num = 1500;
    let kinds = [
        ("still", Blur { motion: 0.0, focus: 0.0 }, 5.0, 0.5),
        ("moving 4 px", Blur { motion: 4.0, focus: 0.0 }, 4.0, 0.5),
        ("out of focus 2 px", Blur { motion: 0.0, focus: 2.0 }, 3.0, 0.3),
        ("both", Blur { motion: 4.0, focus: 2.0 }, 2.0, 0.3),
    ];
    for n in [2, 4, 8] {
        for (name, blur, above_random, above_jittered) in kinds {
            let mut errors = [0.0; 3];
            for seed in 0..4 {
                let spec = PatternSpec { samples: [n, n], seed, ..PatternSpec::default() };
                let sets = [
                    pattern_pixels(&spec, num),
                    random_pixels(n * n, num, seed),
                    jittered_pixels(n, num, seed),
                ];
                for (sum, pixels) in errors.iter_mut().zip(&sets) {
                    *sum += error(pixels, blur).powi(2) / 4.0;
                }
            }
            let [ours, random, jittered] = errors.map(f64::sqrt);
            let gains = [decibels(ours, random), decibels(ours, jittered)];
            eprintln!(
                "{:2} samples, {name}: error {ours:.4}, random {random:.4} (+{:.1} dB), jittered {jittered:.4} (+{:.1} dB)",
                n * n,
                gains[0],
                gains[1]
            );
            if n == 4 {
                assert!(gains[0] > above_random && gains[1] > above_jittered, "{name}: {gains:?} dB");
            }
        }
    }
}

/// Mixture discrepancy, squared (Zhou, Fang and Ning 2013), of points of the unit cube.
fn discrepancy(points: &[[f64; 5]]) -> f64 {
    let n = points.len() as f64;
    let mut sum = 0.0;
    for a in points {
        let off = |v: f64| (v - 0.5).abs();
        let own = a.iter().map(|&v| 5.0 / 3.0 - 0.25 * off(v) - 0.25 * off(v) * off(v)).product::<f64>();
        sum -= 2.0 * n * own;
        for b in points {
            let factor = |dim: usize| {
                let d = (a[dim] - b[dim]).abs();
                1.875 - 0.25 * off(a[dim]) - 0.25 * off(b[dim]) - 0.75 * d + 0.5 * d * d
            };
            sum += (0..5).map(factor).product::<f64>();
        }
    }
    sum / (n * n) + (19.0f64 / 12.0).powi(5)
}

#[test]
fn spread_figures() {
    let mut stream = Stream::new(5);
    for n in [2u32, 4, 8, 16] {
        let m = n * n;
        let (mut random, mut shuffled, mut ours) = (0.0, 0.0, 0.0);
        let num_seeds = 10;
        for seed in 0..num_seeds {
            let points: Vec<[f64; 5]> = (0..m).map(|_| std::array::from_fn(|_| stream.next_unit())).collect();
            random += discrepancy(&points) / f64::from(num_seeds);
            let strata = crate::sampling::strata::Strata::new([n, n], seed);
            let centres: Vec<[f64; 5]> = strata
                .columns
                .iter()
                .map(|c| c.map(|column| (f64::from(column) + 0.5) / f64::from(m)))
                .collect();
            ours += discrepancy(&centres) / f64::from(num_seeds);
            // The same sub-pixel, time and lens cells, paired by chance.
            let mut order = [(); 2].map(|()| (0..m as usize).collect::<Vec<_>>());
            for list in &mut order {
                for i in (1..m).rev() {
                    list.swap(i as usize, stream.below(i + 1) as usize);
                }
            }
            let paired: Vec<[f64; 5]> = (0..m as usize)
                .map(|j| {
                    let (t, lens) = (centres[order[0][j]], centres[order[1][j]]);
                    [centres[j][0], centres[j][1], t[2], lens[3], lens[4]]
                })
                .collect();
            shuffled += discrepancy(&paired) / f64::from(num_seeds);
        }
        eprintln!(
            "{m:3} samples, squared discrepancy x 1000: random {:.2}, shuffled {:.2}, here {:.2}",
            1e3 * random,
            1e3 * shuffled,
            1e3 * ours
        );
        assert!(ours < shuffled && shuffled < random);
    }
}
