//! How fast pictures of what moves or is out of focus converge.

use std::f64::consts::TAU;

use conformance::blur::{Stage, alpha, boxed, disk_beyond, half_plane, over_pixel, over_time};
use conformance::closed::Random;
use conformance::moving::moving;
use olema::Settings;

/// An edge of random place and direction in a picture of 2 x 2 pixels.
struct Edge {
    through: [f64; 2],
    angle: f64,
    /// Pixels moved along its normal while the shutter is open.
    motion: f64,
    circle_px: f64,
}

impl Edge {
    fn random(random: &mut Random, motion: f64, circle_px: f64) -> Self {
        let through = [random.range(0.7, 1.3), random.range(0.7, 1.3)];
        let speed = motion * random.range(0.5, 1.0) * [-1.0, 1.0][random.below(2) as usize];
        Edge { through, angle: random.range(0.0, TAU), motion: speed, circle_px }
    }

    /// How far a place is beyond the edge at a time.
    fn beyond(&self, x: f64, y: f64, time: f64) -> f64 {
        let (sin, cos) = self.angle.sin_cos();
        (x - self.through[0]) * cos + (y - self.through[1]) * sin - self.motion * (time - 0.5)
    }

    fn truth(&self, x: f64, y: f64) -> f64 {
        let times = if self.motion == 0.0 { 1 } else { 32 };
        over_time(times, |t| {
            let beyond = self.beyond(x, y, t);
            if self.circle_px == 0.0 {
                f64::from(u8::from(beyond < 0.0))
            } else {
                disk_beyond(beyond / self.circle_px)
            }
        })
    }

    fn draw(&self, side: u32, seed: u32) -> Vec<f64> {
        let stage = Stage { circle_px: self.circle_px, ..Stage::sharp([2, 2]) };
        let mut scene = stage.scene();
        stage.add_quad(&mut scene, half_plane(self.through, self.angle), 1.0);
        let (sin, cos) = self.angle.sin_cos();
        let scene = moving(scene, &[0.0, 1.0], |t| {
            let along = self.motion * (f64::from(t) - 0.5);
            stage.shift([cos * along, sin * along])
        });
        let settings = Settings { seed, shading_rate_scale: 400.0, ..boxed(stage.size, [side, side]) };
        alpha(&scene, &settings)
    }

    /// The same with samples that know nothing of each other.
    fn draw_at_random(&self, side: u32, random: &mut Random) -> Vec<f64> {
        let num = side * side;
        let mut share = |[px, py]: [f64; 2]| {
            let hit = |_: &u32| {
                let (x, y, t) =
                    (px + random.range(0.0, 1.0), py + random.range(0.0, 1.0), random.range(0.0, 1.0));
                let (radius, turn) = (random.range(0.0, 1.0).sqrt(), random.range(0.0, TAU));
                self.beyond(x, y, t) < self.circle_px * radius * turn.cos()
            };
            f64::from((0..num).filter(hit).count() as u32) / f64::from(num)
        };
        [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(&mut share).to_vec()
    }
}

/// Least squares through the logarithms of (samples, error).
fn slope(points: &[(f64, f64)]) -> f64 {
    let points: Vec<_> = points.iter().map(|p| (p.0.ln(), p.1.ln())).collect();
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    mean(&|p| (p.0 - x) * (p.1 - y)) / mean(&|p| (p.0 - x) * (p.0 - x))
}

/// Slopes of the renderer's error and of that of independent samples, over 16 to 1024 samples a pixel.
fn slopes(name: &str, motion: f64, circle_px: f64) -> [f64; 2] {
    const EDGES: usize = 60;
    let mut random = Random::new(11);
    let edges: Vec<Edge> = (0..EDGES).map(|_| Edge::random(&mut random, motion, circle_px)).collect();
    let truths: Vec<[f64; 4]> = edges
        .iter()
        .map(|edge| [[0, 0], [1, 0], [0, 1], [1, 1]].map(|pixel| over_pixel(pixel, &|x, y| edge.truth(x, y))))
        .collect();
    let error = |draw: &mut dyn FnMut(&Edge, u32) -> Vec<f64>| {
        let mut squares = 0.0;
        for (ix, (edge, truth)) in edges.iter().zip(&truths).enumerate() {
            let found = draw(edge, ix as u32);
            squares += truth.iter().zip(found).map(|(t, f)| (t - f).powi(2)).sum::<f64>();
        }
        (squares / (4.0 * EDGES as f64)).sqrt()
    };
    let sides = [4u32, 8, 16, 32];
    let ours = sides.map(|side| (f64::from(side * side), error(&mut |edge, ix| edge.draw(side, ix % 8))));
    let control = sides
        .map(|side| (f64::from(side * side), error(&mut |edge, _| edge.draw_at_random(side, &mut random))));
    let found = [slope(&ours), slope(&control)];
    println!(
        "{name}: error {:.5?}, at random {:.5?}; slopes {found:.2?}",
        ours.map(|p| p.1),
        control.map(|p| p.1)
    );
    found
}

#[test]
fn the_error_falls_faster_than_that_of_independent_samples() {
    // An indicator over n dimensions that are stratified together has -(1 + 1/n) / 2: -0.67 with time, -0.62 with the
    // lens, -0.6 with both; independent samples have -0.5. With both the strata pair each time with one place of the
    // lens, and above 64 samples that pairing decides: the error stays well below that of independent samples, but does
    // not fall faster.
    for (name, motion, circle_px, limit) in
        [("moving", 3.0, 0.0, -0.6), ("out of focus", 0.0, 1.5, -0.55), ("both", 3.0, 1.5, -0.4)]
    {
        let [ours, control] = slopes(name, motion, circle_px);
        assert!(ours < limit, "{name}: {ours}");
        assert!(control > -0.6, "{name}: the comparison cannot fail: {control}");
    }
}
