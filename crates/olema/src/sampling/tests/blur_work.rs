use super::blurred::{Blurred, How, NoHits, scalar};
use crate::sampling::auto::{INTERLEAVE_OPS, INTERVAL_OPS};
use crate::sampling::hash::Stream;
use crate::sampling::nomotion::SampleCounts;
use crate::sampling::{
    Kernels, Micropolygons, MovingDraw, Rasterizer, Region, RegionSamples, SamplePattern, TupleTimes,
};

/// Direction of motion.
#[derive(Clone, Copy)]
enum Along {
    X,
    Diagonal,
    Any,
}

/// Shape of the triangles of half a pixel.
#[derive(Clone, Copy)]
enum Shape {
    /// Right triangles with legs of 1 px.
    Half,
    /// Halves of parallelograms of 1 px area as dicing leaves them: sides in ratios of 1 to 2, at angles of 60
    /// to 120 degrees.
    Diced,
}

impl Shape {
    /// Sides of a cell.
    fn sides(self, stream: &mut Stream) -> [[f64; 2]; 2] {
        let turn = stream.next_unit() * std::f64::consts::TAU;
        let (stretch, angle) = match self {
            Shape::Half => (1.0, std::f64::consts::FRAC_PI_2),
            Shape::Diced => (
                2f64.powf(0.5 * (2.0 * stream.next_unit() - 1.0)),
                (1.0 + stream.next_unit()) * std::f64::consts::FRAC_PI_3,
            ),
        };
        let long = stretch / angle.sin().sqrt();
        let short = 1.0 / (stretch * angle.sin().sqrt());
        [(turn, long), (turn + angle, short)].map(|(turn, length)| [length * turn.cos(), length * turn.sin()])
    }
}

/// STE of triangles of half a pixel, anywhere and turned anyhow, that move by `motion` and have a circle of
/// confusion of `focus`, both in pixels.
fn ste(
    rasterizer: Rasterizer,
    pattern: &SamplePattern,
    shape: Shape,
    (motion, along): (f64, Along),
    focus: f64,
) -> f64 {
    let samples = RegionSamples::new(pattern, Region::new(-32, 96, -32, 96));
    let mut stream = Stream::new(11);
    let mut counts = SampleCounts::default();
    for _ in 0..2000 {
        let (x, y) = (stream.next_unit() * 32.0 + 16.0, stream.next_unit() * 32.0 + 16.0);
        let [a, b] = shape.sides(&mut stream);
        let turn = match along {
            Along::X => 0.0,
            Along::Diagonal => 0.125,
            Along::Any => stream.next_unit(),
        };
        let way = (turn * std::f64::consts::TAU).sin_cos();
        let grid = Blurred::from_fn([1, 1], &[0.0, 1.0], |key, i, j| {
            let (i, j) = (i as f64, j as f64);
            let far = motion * (key as f64 - 0.5);
            [x + i * a[0] + j * b[0] + far * way.1, y + i * a[1] + j * b[1] + far * way.0]
        });
        let grid = if focus > 0.0 { grid.defocused(focus) } else { grid };
        let how = How { micropolygons: Micropolygons::Triangles, ..scalar(rasterizer) };
        counts.add(grid.draw(how, pattern, &samples, &mut NoHits));
    }
    counts.ste()
}

#[test]
fn sample_test_efficiency_with_blur_on_and_nothing_moving_is_the_papers() {
    let pattern = super::pattern([4, 4], 2);
    let still = (0.0, Along::Any);
    for (rasterizer, published) in
        [(Rasterizer::NoMotion, 0.26), (Rasterizer::Interval, 0.10), (Rasterizer::InterleaveUvt, 0.05)]
    {
        let diced = ste(rasterizer, &pattern, Shape::Diced, still, 0.0);
        let half = ste(rasterizer, &pattern, Shape::Half, still, 0.0);
        eprintln!(
            "STE at 16 samples, nothing moves: {rasterizer:?} {diced:.4}, paper {published} \
             (right triangles {half:.4})"
        );
        assert!((diced / published - 1.0).abs() < 0.15, "{rasterizer:?}: {diced}");
        assert!((half / published - 1.0).abs() < 0.2, "{rasterizer:?}: {half}");
    }
}

/// The blur at which Interval's STE falls to `interleaved`, by interpolation.
fn crossing(interleaved: f64, steps: &[f64], interval: impl Fn(f64) -> f64) -> f64 {
    let mut before: Option<(f64, f64)> = None;
    for &blur in steps {
        let lead = interval(blur) / interleaved - 1.0;
        if let (Some((at, was)), true) = (before, lead <= 0.0) {
            return at + (blur - at) * was / (was - lead);
        }
        before = Some((blur, lead));
    }
    f64::INFINITY
}

#[test]
fn interleaving_overtakes_interval_where_the_paper_says() {
    let pattern = super::pattern([4, 4], 2);
    let none = (0.0, Along::Any);
    let interleaved = ste(Rasterizer::InterleaveUvt, &pattern, Shape::Half, none, 0.0);
    // Interval bounds the tuples that a stratum holds. With K = 2 they are 4, which span three quarters of it
    // on average; with K = 8 they are 64 and span it all, as the paper's do. Of its cell of the lens, a stratum
    // takes up only what the pattern's columns leave it, so that defocus widens the bounds less than the
    // paper's, which is met at 2 px.
    let whole_strata = super::pattern([4, 4], 8);
    for (name, pattern, [axis_px, diagonal_px]) in [
        ("all of a stratum", &whole_strata, [34.0..46.0, 18.0..26.0]),
        ("its 4 tuples", &pattern, [45.0..62.0, 25.0..35.0]),
    ] {
        let motions: Vec<f64> = (4..16).map(|i| f64::from(i) * 4.0).collect();
        let of_motion = |along| {
            crossing(interleaved, &motions, |motion| {
                ste(Rasterizer::Interval, pattern, Shape::Half, (motion, along), 0.0)
            })
        };
        let (diagonal, any, axis) = (of_motion(Along::Diagonal), of_motion(Along::Any), of_motion(Along::X));
        let focus = crossing(
            interleaved,
            &[1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0, 8.0, 10.0, 12.0, 14.0, 16.0],
            |focus| ste(Rasterizer::Interval, pattern, Shape::Half, none, focus),
        );
        eprintln!(
            "N = 64 meets Interval's STE, bounds of {name}, at {diagonal:.1} px (diagonal), {any:.1} px (any \
             way), {axis:.1} px (axis) of motion, paper 21 to 40; at {focus:.2} px of defocus, paper 2"
        );
        assert!(diagonal_px.contains(&diagonal) && axis_px.contains(&axis), "{diagonal} {axis}");
        assert!(diagonal < any && any < axis);
        assert!(focus > 1.5, "{focus}");
    }
}

#[test]
fn only_interval_and_boundingbox_lose_to_blur() {
    let pattern = super::pattern([4, 4], 2);
    let fall = |rasterizer| {
        let at = |motion| ste(rasterizer, &pattern, Shape::Half, (motion, Along::Any), 0.0);
        at(40.0) / at(0.0)
    };
    assert!((fall(Rasterizer::InterleaveUvt) - 1.0).abs() < 0.1);
    assert!(fall(Rasterizer::Interval) < 0.6);
    assert!(fall(Rasterizer::BoundingBox) < 0.1);
}

/// Cost in the paper's operations of a grid with each of Interval and InterleaveUvt, and what Auto takes.
fn costs(
    grid: &Blurred,
    pattern: &SamplePattern,
    samples: &RegionSamples,
    micropolygons: Micropolygons,
) -> [f64; 3] {
    let times = TupleTimes::new(pattern, &grid.key_times);
    let facing = crate::sampling::nomotion::Facing::Any;
    let draw = MovingDraw {
        grid: grid.grid(&times),
        pattern,
        samples,
        facing,
        skip: None,
        micropolygons,
        times: MovingDraw::ALL_TIMES,
        // Costs are in the paper's operations, which only the scalar code does.
        kernels: Kernels::Scalar,
    };
    let of = |rasterizer: Rasterizer, ops: [f64; 2], setups: usize| {
        let mut counts = SampleCounts::default();
        rasterizer.rasterize(&draw, &mut counts, &mut NoHits).expect("suited");
        (setups * grid.m * grid.n) as f64 * ops[0] + counts.tests as f64 * ops[1]
    };
    let interval = of(Rasterizer::Interval, INTERVAL_OPS, samples.samples_per_pixel());
    let interleave = of(Rasterizer::InterleaveUvt, INTERLEAVE_OPS, pattern.tuples().len());
    let auto = match crate::sampling::auto::choose(&draw) {
        Rasterizer::InterleaveUvt => interleave,
        Rasterizer::NoMotion => of(Rasterizer::NoMotion, [38.0, 53.0], 1),
        _ => interval,
    };
    [interval, interleave, auto]
}

fn turned_grid(side: usize, stream: &mut Stream, motion: f64, focus: f64, key_times: &[f32]) -> Blurred {
    let (x, y) = (40.0 + stream.next_unit(), 40.0 + stream.next_unit());
    let (sin, cos) = (stream.next_unit() * std::f64::consts::TAU).sin_cos();
    let way = (stream.next_unit() * std::f64::consts::TAU).sin_cos();
    let grid = Blurred::from_fn([side, side], key_times, |key, i, j| {
        let (a, b) = (i as f64, j as f64);
        let far = motion * (f64::from(key_times[key]) - 0.5);
        [x + a * cos - b * sin + far * way.1, y + a * sin + b * cos + far * way.0]
    });
    grid.defocused(focus)
}

#[test]
fn auto_costs_little_more_than_the_better_one() {
    let motions = [0.0, 1.0, 2.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0, 60.0, 80.0, 100.0];
    let focuses = [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0, 10.0, 20.0];
    let mut stream = Stream::new(23);
    let (mut worst, mut num_interval) = ([0.0f64; 2], 0);
    // Whole, and a tile that the blur crosses.
    for (case, region) in
        [Region::new(-60, 140, -60, 140), Region::new(32, 64, 32, 64)].into_iter().enumerate()
    {
        for (samples, tile) in [([4, 4], 2), ([2, 2], 4), ([8, 8], 1)] {
            let pattern = super::pattern(samples, tile);
            let samples = RegionSamples::new(&pattern, region);
            for motion in motions {
                for focus in focuses {
                    if samples.samples_per_pixel() != 16 && motion > 0.0 && focus > 0.0 {
                        continue;
                    }
                    let key_times: &[f32] = if motion == 15.0 { &[0.0, 0.3, 1.0] } else { &[0.0, 1.0] };
                    let grid = turned_grid(6, &mut stream, motion, focus, key_times);
                    let [interval, interleave, auto] = costs(&grid, &pattern, &samples, Micropolygons::Quads);
                    let above = auto / interval.min(interleave) - 1.0;
                    num_interval += i32::from(interval < interleave);
                    worst[case] = worst[case].max(above);
                    assert!(
                        above <= 0.05 || case == 1,
                        "{motion} px, {focus} px, K = {tile}: {interval:.0} {interleave:.0} {auto:.0}"
                    );
                }
            }
        }
    }
    eprintln!(
        "Auto above the better one: at most {:.1} %; in a tile that the blur crosses {:.1} %",
        100.0 * worst[0],
        100.0 * worst[1]
    );
    assert!(worst[1] < 0.3, "{worst:?}");
    assert!(num_interval > 20);
}
