//! Values of options: what a string means, and what to say when it means nothing.

use std::fmt;
use std::str::FromStr;

use clap::ValueEnum;
use olema::occlusion::CullSettings;
use olema::scene::Scheme;

/// A rule of subdivision, by the name that OBJ files begin with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SchemeName {
    /// Catmull and Clark's, smooth over quads
    Catmark,
    /// Loop's, smooth over triangles
    Loop,
    /// The faces as they are
    Bilinear,
}

impl From<SchemeName> for Scheme {
    fn from(name: SchemeName) -> Self {
        match name {
            SchemeName::Catmark => Scheme::CatmullClark,
            SchemeName::Loop => Scheme::Loop,
            SchemeName::Bilinear => Scheme::Bilinear,
        }
    }
}

impl fmt::Display for SchemeName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            SchemeName::Catmark => "catmark",
            SchemeName::Loop => "loop",
            SchemeName::Bilinear => "bilinear",
        })
    }
}

/// The axis of a model that points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum UpAxis {
    /// As in films and games
    Y,
    /// As in maps and machines
    Z,
}

impl fmt::Display for UpAxis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if *self == UpAxis::Y { "y" } else { "z" })
    }
}

/// Width and height, both at least 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size(pub [u32; 2]);

impl FromStr for Size {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        let expected = || "expected WIDTHxHEIGHT in pixels, each 1 to 65535, e.g. 640x480".to_owned();
        let (w, h) = s.split_once(['x', 'X']).ok_or_else(expected)?;
        let side = |s: &str| s.parse().ok().filter(|n| (1..=65_535).contains(n)).ok_or_else(expected);
        Ok(Size([side(w)?, side(h)?]))
    }
}

/// `NxM` samples with a product of at most 1024.
pub fn parse_samples(s: &str) -> Result<Size, String> {
    let expected = || "expected NxM with N times M from 1 to 1024, e.g. 4x4".to_owned();
    let size: Size = s.parse().map_err(|_| expected())?;
    if u64::from(size.0[0]) * u64::from(size.0[1]) > 1024 { Err(expected()) } else { Ok(size) }
}

/// `N` or `NxM` pixels.
pub fn parse_bucket(s: &str) -> Result<Size, String> {
    let expected = |_| "expected N or NxM pixels, each 1 to 65535, e.g. 64 or 64x16".to_owned();
    if s.contains(['x', 'X']) { s.parse() } else { format!("{s}x{s}").parse() }.map_err(expected)
}

/// A finite number above 0.
pub fn parse_shading_rate(s: &str) -> Result<f32, String> {
    s.parse()
        .ok()
        .filter(|r: &f32| *r > 0.0 && r.is_finite())
        .ok_or_else(|| "expected a number of pixels above 0, e.g. 0.25".to_owned())
}

/// A finite number of at least 0.
pub fn parse_factor(s: &str) -> Result<f32, String> {
    s.parse()
        .ok()
        .filter(|x: &f32| *x >= 0.0 && x.is_finite())
        .ok_or_else(|| "expected a number of at least 0, e.g. 1.5".to_owned())
}

/// Times at which the shutter opens and closes; the same for a still picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shutter(pub [f32; 2]);

impl FromStr for Shutter {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        let expected = || "expected OPEN,CLOSE with OPEN not after CLOSE, e.g. 0,0.5".to_owned();
        let (open, close) = s.split_once(',').ok_or_else(expected)?;
        let time = |s: &str| s.trim().parse::<f32>().map_err(|_| expected());
        let (open, close) = (time(open)?, time(close)?);
        // The difference of times that are infinite or not-a-number is not finite.
        if open <= close && (close - open).is_finite() { Ok(Shutter([open, close])) } else { Err(expected()) }
    }
}

/// When surfaces are shaded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ShadingTime {
    /// When the shutter opens
    Open,
    /// Half-way
    Middle,
    /// When it closes
    Close,
}

impl ShadingTime {
    /// The part of the shutter's time.
    pub fn part(self) -> f32 {
        match self {
            ShadingTime::Open => 0.0,
            ShadingTime::Middle => 0.5,
            ShadingTime::Close => 1.0,
        }
    }
}

/// A side of the sample pattern's tile that the library knows.
pub fn parse_pattern_tile(s: &str) -> Result<u32, String> {
    s.parse()
        .ok()
        .filter(|k| [1, 2, 3, 4, 8, 64].contains(k))
        .ok_or_else(|| "expected 1, 2, 3, 4, 8 or 64".to_owned())
}

/// One of [`CullSettings::LEAVES_PX`].
pub fn parse_cull_leaf(s: &str) -> Result<u32, String> {
    let leaf = s.parse().ok().filter(|px| CullSettings::LEAVES_PX.contains(px));
    leaf.ok_or_else(|| "expected 2, 4, 8 or 16 (pixels)".to_owned())
}

/// One of [`CullSettings::SLICES`].
pub fn parse_cull_slices(s: &str) -> Result<u32, String> {
    let slices = s.parse().ok().filter(|num| CullSettings::SLICES.contains(num));
    slices.ok_or_else(|| "expected 64, 16, 4 or 1".to_owned())
}

/// The squarest grid of `n` samples: `[n / a, a]` for the largest divisor a of n with a * a <= n.
pub fn squarest(n: u32) -> [u32; 2] {
    let a = (1..=n).take_while(|a| a * a <= n).filter(|a| n.is_multiple_of(*a)).last().unwrap_or(1);
    [n / a, a]
}

/// Worker threads for `--threads`: 0 stays 0 (one per core), a negative number leaves that many cores alone.
pub fn threads(asked: i32, cores: usize) -> usize {
    match usize::try_from(asked) {
        Ok(n) => n,
        Err(_) => cores.saturating_sub(asked.unsigned_abs() as usize).max(1),
    }
}

/// Part of the frame, as it was written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Crop {
    /// `[x0, x1, y0, y1]`, 0 to 1.
    Fractions([f64; 4]),
    /// `[x0, x1, y0, y1]`, end exclusive.
    Pixels([u32; 4]),
}

impl FromStr for Crop {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        let expected = || {
            "expected x0,x1,y0,y1 with x0 < x1 and y0 < y1: fractions 0 to 1 of the frame, or whole pixels \
             (end exclusive), e.g. 0.25,0.75,0,0.5 or 160,480,0,240"
                .to_owned()
        };
        let numbers: Vec<f64> =
            s.split(',').map(|n| n.trim().parse().map_err(|_| expected())).collect::<Result<_, _>>()?;
        let crop: [f64; 4] = numbers.try_into().map_err(|_| expected())?;
        let [x0, x1, y0, y1] = crop;
        if !(x0 >= 0.0 && y0 >= 0.0 && x0 < x1 && y0 < y1) {
            return Err(expected());
        }
        if crop.iter().all(|c| *c <= 1.0) {
            return Ok(Crop::Fractions(crop));
        }
        if crop.iter().any(|c| c.fract() != 0.0 || *c > 65_535.0) {
            return Err(expected());
        }
        Ok(Crop::Pixels(crop.map(|c| c as u32)))
    }
}

impl Crop {
    /// The pixels of a frame of that size, `[x0, x1, y0, y1]`, end exclusive; `None` where not one is left.
    ///
    /// Fractions round as RenderMan's CropWindow does, so that windows that share a border share no pixel:
    /// the first pixel is ceil(x0 * width), the first one no longer in it ceil(x1 * width).
    pub fn pixels(self, [w, h]: [u32; 2]) -> Option<[u32; 4]> {
        let crop = match self {
            Crop::Fractions([x0, x1, y0, y1]) => {
                // 0.7 * 10 is a hair above 7 in binary and must not become 8.
                let pixel = |c: f64, size: u32| (c * f64::from(size) - 1e-6).ceil() as u32;
                [pixel(x0, w), pixel(x1, w), pixel(y0, h), pixel(y1, h)]
            }
            Crop::Pixels([x0, x1, y0, y1]) => [x0, x1.min(w), y0, y1.min(h)],
        };
        let [x0, x1, y0, y1] = crop;
        (x0 < x1 && y0 < y1).then_some(crop)
    }
}

/// Largest difference that passes, 0 to 255.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance(pub f64);

impl FromStr for Tolerance {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        s.parse()
            .ok()
            .filter(|t| (0.0..=255.0).contains(t))
            .map(Tolerance)
            .ok_or_else(|| "expected a number from 0 to 255".to_owned())
    }
}

/// Numbers of frames: ranges with a step. Nothing is enumerated, so that 1-2000000000 costs nothing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FrameSet(Vec<FrameRange>);

/// `first`, `first + step`, ... up to and including `last`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct FrameRange {
    first: i32,
    last: i32,
    step: i32,
}

impl FromStr for FrameSet {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        let expected = |part: &str| {
            format!(
                "{part:?} is no range of frames: expected N, FIRST-LAST or FIRST-LAST:STEP, e.g. 1-7:2,20-25"
            )
        };
        let range = |part: &str| {
            let number = |s: &str| s.parse().ok().filter(|n: &i32| *n >= 0);
            let (span, step) = match part.split_once(':') {
                Some((span, step)) => (span, number(step)?),
                None => (part, 1),
            };
            let (first, last) = span.split_once('-').unwrap_or((span, span));
            let range = FrameRange { first: number(first)?, last: number(last)?, step };
            (range.first <= range.last && range.step > 0).then_some(range)
        };
        s.split(',')
            .map(|p| range(p.trim()).ok_or_else(|| expected(p)))
            .collect::<Result<_, _>>()
            .map(FrameSet)
    }
}

impl FrameSet {
    /// Whether the frame is asked for.
    pub fn contains(&self, frame: i32) -> bool {
        self.0.iter().any(|r| (r.first..=r.last).contains(&frame) && (frame - r.first) % r.step == 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_two_numbers_above_zero() {
        assert_eq!("640x480".parse(), Ok(Size([640, 480])));
        for bad in ["", "640", "0x5", "5x0", "-1x5", "640x480x3", "1e3x5", "65536x1", "99999999999x1"] {
            assert!(bad.parse::<Size>().unwrap_err().contains("WIDTHxHEIGHT"), "{bad:?}");
        }
    }

    #[test]
    fn samples_have_a_limit_in_all() {
        assert_eq!(parse_samples("32x32"), Ok(Size([32, 32])));
        assert!(parse_samples("33x32").is_err());
        assert!(parse_samples("65535x65535").is_err());
    }

    #[test]
    fn a_bucket_may_be_square() {
        assert_eq!(parse_bucket("16"), Ok(Size([16, 16])));
        assert_eq!(parse_bucket("64x16"), Ok(Size([64, 16])));
        assert!(parse_bucket("0").is_err());
        assert!(parse_bucket("").is_err());
    }

    #[test]
    fn shading_rates_are_finite_and_above_zero() {
        assert_eq!(parse_shading_rate("0.25"), Ok(0.25));
        for bad in ["0", "-1", "inf", "NaN", "1e60", "x"] {
            assert!(parse_shading_rate(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn factors_may_be_zero_but_not_below() {
        assert_eq!([parse_factor("0"), parse_factor("1.5")], [Ok(0.0), Ok(1.5)]);
        for bad in ["-0.1", "inf", "NaN", "1e60", ""] {
            assert!(parse_factor(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_shutter_does_not_close_before_it_opens() {
        assert_eq!("0,0".parse(), Ok(Shutter([0.0, 0.0])));
        assert_eq!("-1.5, 2".parse(), Ok(Shutter([-1.5, 2.0])));
        for bad in ["", "1", "1,0", "0,1,2", "0,inf", "-inf,0", "inf,inf", "0,nan", "-3e38,3e38"] {
            assert!(bad.parse::<Shutter>().unwrap_err().contains("OPEN,CLOSE"), "{bad:?}");
        }
    }

    #[test]
    fn sample_counts_become_the_squarest_grid() {
        for (n, grid) in [(1, [1, 1]), (4, [2, 2]), (7, [7, 1]), (12, [4, 3]), (16, [4, 4]), (1024, [32, 32])]
        {
            assert_eq!(squarest(n), grid);
        }
    }

    #[test]
    fn negative_threads_leave_cores_alone_but_never_all() {
        assert_eq!([threads(0, 8), threads(3, 8), threads(-2, 8), threads(-9, 8)], [0, 3, 6, 1]);
        assert_eq!(threads(i32::MIN, 8), 1);
    }

    #[test]
    fn crop_in_fractions_rounds_as_crop_window() {
        let crop = |s: &str| s.parse::<Crop>().unwrap().pixels([640, 480]);
        assert_eq!(crop("0,1,0,1"), Some([0, 640, 0, 480]));
        assert_eq!(crop("0,0.3333,0,0.5"), Some([0, 214, 0, 240]));
        assert_eq!(crop("0.3333,1,0,0.5"), Some([214, 640, 0, 240]));
        assert_eq!(crop("0.1,0.1001,0,1"), Some([64, 65, 0, 480]));
        assert_eq!("0,0.7,0,1".parse::<Crop>().unwrap().pixels([10, 10]), Some([0, 7, 0, 10]));
        assert_eq!(crop("0.1001,0.1002,0,1"), None);
    }

    #[test]
    fn crop_in_pixels_is_clamped_to_the_frame() {
        let crop = |s: &str| s.parse::<Crop>().unwrap().pixels([640, 480]);
        assert_eq!(crop("10,20,0,5"), Some([10, 20, 0, 5]));
        assert_eq!(crop("600,700,0,5"), Some([600, 640, 0, 5]));
        assert_eq!(crop("640,700,0,5"), None);
    }

    #[test]
    fn crops_that_make_no_sense_are_refused() {
        for bad in [
            "",
            "0,1,0",
            "0,1,0,1,2",
            "1,0,0,1",
            "0,0,0,1",
            "-1,1,0,1",
            "0,NaN,0,1",
            "0.5,2,0,1",
            "0,1e9,0,1",
        ] {
            assert!(bad.parse::<Crop>().is_err(), "{bad:?}");
        }
    }

    #[test]
    fn frames_are_ranges_with_steps() {
        let set: FrameSet = "1-7:2,20-25,40".parse().unwrap();
        let chosen: Vec<i32> = (0..50).filter(|f| set.contains(*f)).collect();
        assert_eq!(chosen, [1, 3, 5, 7, 20, 21, 22, 23, 24, 25, 40]);
        for bad in ["", "a", "7-1", "1-7:0", "1-", "-3", "1,,2", "99999999999"] {
            assert!(bad.parse::<FrameSet>().unwrap_err().contains("no range of frames"), "{bad:?}");
        }
    }
}
