//! Reconstruction filters.
//!
//! In: the offset of a sample from a pixel's centre. Out: its weight, not normalised. Source: RenderMan
//! Interface 3.2, appendix E, which defines box, triangle, Catmull-Rom, Gaussian and sinc; Mitchell and
//! Netravali 1988; Harris 1978. Where the appendix's code and its words disagree, the words are followed: the
//! triangle reaches 0 at the support's edge for any width, and sinc has its zeros at whole pixels.

use crate::math::function;

/// Shape of a filter, as RenderMan names them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FilterKind {
    /// 1 inside.
    Box,
    /// A tent, 0 at the support's edge.
    Triangle,
    /// Catmull-Rom cubic of the distance from the centre (round, as RenderMan has it), 0 from 2 pixels on; the
    /// width only cuts it off.
    CatmullRom,
    /// exp(-2 (x^2 + y^2)) with x and y 1 at the support's edge.
    Gaussian,
    /// sin(pi x) / (pi x) in each direction, cut off at the support's edge and not windowed otherwise.
    Sinc,
    /// Mitchell-Netravali with B = C = 1/3 in each direction, stretched to the width.
    Mitchell,
    /// The four-term Blackman-Harris window in each direction, stretched to the width.
    BlackmanHarris,
}

/// A filter and its full width in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Filter {
    /// Shape.
    pub kind: FilterKind,
    /// Full widths in x and y, above 0 and at most 64 pixels.
    pub width: [f32; 2],
}

impl Default for Filter {
    fn default() -> Self {
        Filter { kind: FilterKind::Gaussian, width: [2.0, 2.0] }
    }
}

impl Filter {
    /// Whether both widths are in range.
    pub fn is_valid(&self) -> bool {
        self.width.iter().all(|w| *w > 0.0 && *w <= 64.0)
    }

    /// Weight of a sample at (`dx`, `dy`) pixels from a pixel's centre: 0 outside the support
    /// [-width/2, width/2), which is half open so that boxes of width 1 tile the plane. May be negative inside
    /// for Catmull-Rom, sinc and Mitchell. Not normalised: the pixel's sum of weights is to divide by.
    #[inline]
    pub fn weight(&self, dx: f32, dy: f32) -> f32 {
        let [wx, wy] = self.width;
        let inside = |d: f32, w: f32| d >= -0.5 * w && d < 0.5 * w;
        if !(inside(dx, wx) && inside(dy, wy)) {
            return 0.0;
        }
        // 1 at the support's edge.
        let (x, y) = (2.0 * dx / wx, 2.0 * dy / wy);
        match self.kind {
            FilterKind::Box => 1.0,
            FilterKind::Triangle => (1.0 - x.abs()) * (1.0 - y.abs()),
            FilterKind::CatmullRom => catmull_rom((dx * dx + dy * dy).sqrt()),
            FilterKind::Gaussian => function::exp(-2.0 * (x * x + y * y)),
            FilterKind::Sinc => sinc(dx) * sinc(dy),
            FilterKind::Mitchell => mitchell(2.0 * x.abs()) * mitchell(2.0 * y.abs()),
            FilterKind::BlackmanHarris => blackman_harris(x) * blackman_harris(y),
        }
    }

    /// How many pixels to each side, in x and y, hold samples that a pixel's support can reach, when a
    /// pixel's samples lie in [0, 1) of it: the greatest whole number below width/2 + 1/2.
    pub fn radius_px(&self) -> [u32; 2] {
        self.width.map(|w| ((0.5 * w + 0.5).ceil() as u32).saturating_sub(1))
    }
}

/// Catmull-Rom cubic of a distance r >= 0, twice its usual height.
fn catmull_rom(r: f32) -> f32 {
    let r2 = r * r;
    if r >= 2.0 {
        0.0
    } else if r < 1.0 {
        3.0 * r * r2 - 5.0 * r2 + 2.0
    } else {
        -r * r2 + 5.0 * r2 - 8.0 * r + 4.0
    }
}

/// sin(pi x) / (pi x).
fn sinc(x: f32) -> f32 {
    let angle = std::f32::consts::PI * x;
    if angle.abs() < 1e-3 { 1.0 } else { function::sin(angle) / angle }
}

/// Mitchell-Netravali cubic of a distance from 0 to 2.
fn mitchell(r: f32) -> f32 {
    const B: f32 = 1.0 / 3.0;
    const C: f32 = 1.0 / 3.0;
    if r < 1.0 {
        (((12.0 - 9.0 * B - 6.0 * C) * r + (-18.0 + 12.0 * B + 6.0 * C)) * r * r + (6.0 - 2.0 * B)) / 6.0
    } else {
        let cubic = (-B - 6.0 * C) * r + (6.0 * B + 30.0 * C);
        ((cubic * r + (-12.0 * B - 48.0 * C)) * r + (8.0 * B + 24.0 * C)) / 6.0
    }
}

/// Blackman-Harris window over [-1, 1].
fn blackman_harris(x: f32) -> f32 {
    // Multiples of the angle from its cosine.
    let c = function::cos(std::f32::consts::PI * x);
    let c2 = 2.0 * c * c - 1.0;
    let c3 = 2.0 * c * c2 - c;
    0.35875 + 0.48829 * c + 0.14128 * c2 + 0.01168 * c3
}

#[cfg(test)]
mod tests {
    use super::*;

    const KINDS: [FilterKind; 7] = [
        FilterKind::Box,
        FilterKind::Triangle,
        FilterKind::CatmullRom,
        FilterKind::Gaussian,
        FilterKind::Sinc,
        FilterKind::Mitchell,
        FilterKind::BlackmanHarris,
    ];

    fn filter(kind: FilterKind, x: f32, y: f32) -> Filter {
        Filter { kind, width: [x, y] }
    }

    #[track_caller]
    fn assert_weight(kind: FilterKind, width: [f32; 2], at: [f32; 2], wanted: f64) {
        let found = f64::from(filter(kind, width[0], width[1]).weight(at[0], at[1]));
        assert!((found - wanted).abs() < 1e-6, "{kind:?} {width:?} at {at:?}: {found}, not {wanted}");
    }

    #[test]
    fn weights_are_the_formulas() {
        use std::f64::consts::PI;
        assert_weight(FilterKind::Box, [3.0, 1.0], [-1.5, 0.25], 1.0);
        assert_weight(FilterKind::Triangle, [4.0, 2.0], [1.0, -0.25], 0.5 * 0.75);
        assert_weight(FilterKind::CatmullRom, [4.0, 4.0], [0.0, 0.0], 2.0);
        assert_weight(FilterKind::CatmullRom, [4.0, 4.0], [0.5, 0.0], 3.0 / 8.0 - 5.0 / 4.0 + 2.0);
        // At a distance of 1.5, along a diagonal of 0.9 and 1.2.
        assert_weight(FilterKind::CatmullRom, [4.0, 4.0], [0.9, 1.2], -3.375 + 11.25 - 12.0 + 4.0);
        assert_weight(FilterKind::CatmullRom, [6.0, 6.0], [2.5, 0.0], 0.0);
        assert_weight(FilterKind::Gaussian, [2.0, 2.0], [0.5, 0.25], (-2.0f64 * 0.3125).exp());
        assert_weight(FilterKind::Gaussian, [4.0, 8.0], [1.0, 1.0], (-2.0f64 * 0.3125).exp());
        assert_weight(FilterKind::Sinc, [4.0, 4.0], [0.5, 0.0], 2.0 / PI);
        assert_weight(FilterKind::Sinc, [8.0, 8.0], [1.5, 0.5], -4.0 / (3.0 * PI * PI));
        assert_weight(FilterKind::Sinc, [8.0, 8.0], [3.0, 0.0], 0.0);
        assert_weight(FilterKind::Mitchell, [4.0, 4.0], [0.0, 0.0], (8.0f64 / 9.0).powi(2));
        assert_weight(FilterKind::Mitchell, [4.0, 4.0], [1.0, 0.0], 1.0 / 18.0 * 8.0 / 9.0);
        // Stretched: half way out of width 2 is as half way out of width 4.
        assert_weight(FilterKind::Mitchell, [2.0, 4.0], [0.5, 0.0], 1.0 / 18.0 * 8.0 / 9.0);
        assert_weight(FilterKind::BlackmanHarris, [3.0, 3.0], [0.0, 0.0], 1.0);
        assert_weight(FilterKind::BlackmanHarris, [3.0, 3.0], [0.75, 0.0], 0.35875 - 0.14128);
        assert_weight(FilterKind::BlackmanHarris, [3.0, 3.0], [-1.5, 0.0], 6e-5);
    }

    #[test]
    fn supports_are_half_open() {
        for kind in KINDS {
            for width in [0.1, 1.0, 2.0, 3.0, 4.5, 64.0] {
                let f = filter(kind, width, 1.0);
                for outside in [0.5 * width, 0.5 * width + 1.0, f32::INFINITY, f32::NAN] {
                    assert_eq!(f.weight(outside, 0.0), 0.0, "{f:?} at {outside}");
                    assert_eq!(f.weight(-outside - 1e-3, 0.0), 0.0, "{f:?} at -{outside}");
                }
                assert_eq!(f.weight(0.0, 0.5), 0.0);
            }
        }
        assert_eq!(filter(FilterKind::Box, 1.0, 1.0).weight(-0.5, -0.5), 1.0);
    }

    #[test]
    fn filters_are_even() {
        for kind in KINDS {
            let f = filter(kind, 3.0, 5.0);
            for n in 0..100 {
                let (x, y) = (n as f32 * 0.0149, (99 - n) as f32 * 0.025);
                let w = f.weight(x, y);
                assert_eq!([f.weight(-x, y), f.weight(x, -y), f.weight(-x, -y)], [w; 3], "{f:?} {x} {y}");
                assert!(w.is_finite() && w.abs() <= 2.0);
            }
        }
    }

    #[test]
    fn radius_is_the_farthest_pixel_in_reach() {
        for (width, radius) in
            [(0.01, 0), (0.99, 0), (1.0, 0), (1.01, 1), (2.0, 1), (3.0, 1), (3.5, 2), (5.0, 2), (64.0, 32)]
        {
            let f = filter(FilterKind::Box, width, 1.0);
            assert_eq!(f.radius_px(), [radius, 0], "width {width}");
            // Samples on a grid of 1/256 pixel: some of that pixel's are in the support, none farther out.
            let reaches = |pixel: i32| {
                (0..256).any(|sub| f.weight(pixel as f32 + sub as f32 / 256.0 - 0.5, 0.0) != 0.0)
            };
            let r = radius as i32;
            assert!(reaches(r) || reaches(-r), "width {width}");
            assert!(!reaches(r + 1) && !reaches(-r - 1), "width {width}");
        }
    }
}
