//! Reconstruction filters.

/// Shape of a filter, as RenderMan names them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FilterKind {
    /// 1 inside.
    Box,
    /// A tent.
    Triangle,
    /// Catmull-Rom cubic.
    CatmullRom,
    /// Gaussian.
    Gaussian,
    /// Windowed sinc.
    Sinc,
    /// Mitchell-Netravali with B = C = 1/3.
    Mitchell,
    /// Blackman-Harris window.
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
}
