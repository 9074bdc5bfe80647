//! The shutter's opening over time.
//!
//! In: a stratified time in [0, 1). Out: a time in [0, 1) with the density of the opening. The strata are
//! cut before the warp, which is monotone, so a stratum stays an interval of time.

/// How the shutter opens and closes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum ShutterShape {
    /// Open at once for the whole time.
    #[default]
    Box,
    /// Opens evenly until `open`, is fully open until `close`, and closes evenly until 1;
    /// 0 <= open <= close <= 1, other values are clamped to that.
    Trapezoid {
        /// Time at which it is fully open.
        open: f64,
        /// Time at which it begins to close.
        close: f64,
    },
}

impl ShutterShape {
    /// The time at which the shutter has let through the part `fraction` (in [0, 1]) of all light.
    pub fn warp(self, fraction: f64) -> f64 {
        let ShutterShape::Trapezoid { open, close } = self else { return fraction };
        let open = open.clamp(0.0, 1.0);
        let close = close.clamp(open, 1.0);
        let closing = 1.0 - close;
        // Light let through in the three phases: two triangles and a rectangle of height 1.
        let total = 0.5 * open + (close - open) + 0.5 * closing;
        let light = fraction * total;
        if light < 0.5 * open {
            (2.0 * light * open).sqrt()
        } else if light <= 0.5 * open + (close - open) {
            open + (light - 0.5 * open)
        } else {
            1.0 - (2.0 * (total - light).max(0.0) * closing).sqrt()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn opening(open: f64, close: f64, t: f64) -> f64 {
        if t < open {
            t / open
        } else if t <= close {
            1.0
        } else {
            (1.0 - t) / (1.0 - close)
        }
    }

    #[test]
    fn warped_times_have_the_density_of_the_opening() {
        for (open, close) in [(0.0, 1.0), (0.2, 0.7), (0.5, 0.5), (0.0, 0.3), (1.0, 1.0), (0.0, 0.0)] {
            let shape = ShutterShape::Trapezoid { open, close };
            let total = 0.5 * open + (close - open) + 0.5 * (1.0 - close);
            let mut sum = 0.0;
            let steps = 20_000;
            let mut next = 0;
            // Integrate the opening numerically and compare the fraction let through by each warped time.
            for step in 0..=steps {
                let fraction = f64::from(step) / f64::from(steps);
                let t = shape.warp(fraction);
                assert!((0.0..=1.0).contains(&t));
                while f64::from(next) / f64::from(steps) < t {
                    sum +=
                        opening(open, close, (f64::from(next) + 0.5) / f64::from(steps)) / f64::from(steps);
                    next += 1;
                }
                assert!((sum / total - fraction).abs() < 3e-4, "{open} {close}: {fraction} -> {t}, {sum}");
            }
        }
    }

    #[test]
    fn the_box_leaves_time_alone() {
        assert_eq!(ShutterShape::Box.warp(0.3), 0.3);
    }
}
