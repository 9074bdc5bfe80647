//! `olema diff`: how far two pictures are apart.

use crate::args::DiffArgs;
use crate::exit::{self, Failure};
use crate::output;
use crate::picture::{self, Rgba8};
use crate::report::{self, Reporter};

/// How far two pictures of one size are apart.
#[derive(Debug, Clone, PartialEq)]
struct Comparison {
    /// Largest difference of a channel, 0 to 255.
    max: u8,
    /// A pixel that has it.
    worst: Option<[u32; 2]>,
    /// Peak signal-to-noise ratio over all four channels in dB, infinite for equal pictures.
    psnr: f64,
    /// Pixels with any difference.
    differing: u64,
}

/// Compares and tells. Returns the exit code.
pub fn run(args: &DiffArgs) -> u8 {
    match compare_files(args) {
        Ok(code) => code,
        Err(failure) => Reporter::new(report::Options::default()).failure(&failure),
    }
}

fn compare_files(args: &DiffArgs) -> Result<u8, Failure> {
    if let Some(path) = &args.output {
        output::check_target("-o", path)?;
    }
    let (a, b) = (picture::read(&args.a)?, picture::read(&args.b)?);
    if [a.width, a.height] != [b.width, b.height] {
        report::print(&format!("sizes differ: {}x{} and {}x{}\n", a.width, a.height, b.width, b.height))?;
        return Ok(exit::RENDER);
    }
    let found = compare(&a, &b);
    let place = found.worst.map(|[x, y]| format!(" at pixel {x},{y}")).unwrap_or_default();
    report::print(&format!(
        "max difference   {} of 255{place}\npsnr             {:.2} dB\ndiffering pixels {} of {}\n",
        found.max,
        found.psnr,
        found.differing,
        u64::from(a.width) * u64::from(a.height)
    ))?;
    if let Some(path) = &args.output {
        picture::write_rgba8(path, &difference(&a, &b, found.max))?;
        report::print(&format!("{}\n", path.display()))?;
    }
    Ok(if f64::from(found.max) > args.tolerance.0 { exit::RENDER } else { exit::OK })
}

/// Compares two pictures of one size.
fn compare(a: &Rgba8, b: &Rgba8) -> Comparison {
    let mut found = Comparison { max: 0, worst: None, psnr: f64::INFINITY, differing: 0 };
    let mut squares = 0u64;
    for (ix, (p, q)) in a.bytes.chunks_exact(4).zip(b.bytes.chunks_exact(4)).enumerate() {
        let steps = [0, 1, 2, 3].map(|c| p[c].abs_diff(q[c]));
        squares += steps.map(|s| u64::from(s) * u64::from(s)).iter().sum::<u64>();
        let largest = steps.into_iter().max().unwrap_or(0);
        found.differing += u64::from(largest > 0);
        if largest > found.max {
            found.max = largest;
            let width = a.width as usize;
            found.worst = Some([(ix % width) as u32, (ix / width) as u32]);
        }
    }
    if squares > 0 {
        let mean = squares as f64 / a.bytes.len() as f64;
        found.psnr = 10.0 * (255.0 * 255.0 / mean).log10();
    }
    found
}

/// Each pixel's largest difference as grey, 0 black and the picture's largest white, so that small ones show.
fn difference(a: &Rgba8, b: &Rgba8, max: u8) -> Rgba8 {
    let grey = |(p, q): (&[u8], &[u8])| {
        let largest = p.iter().zip(q).map(|(p, q)| p.abs_diff(*q)).max().unwrap_or(0);
        let value = (u32::from(largest) * 255 / u32::from(max.max(1))) as u8;
        [value, value, value, 255]
    };
    let bytes = a.bytes.chunks_exact(4).zip(b.bytes.chunks_exact(4)).flat_map(grey).collect();
    Rgba8 { width: a.width, height: a.height, bytes }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(bytes: &[u8]) -> Rgba8 {
        Rgba8 { width: bytes.len() as u32 / 4, height: 1, bytes: bytes.to_vec() }
    }

    #[test]
    fn equal_pictures_are_infinitely_close() {
        let a = picture(&[1, 2, 3, 4, 5, 6, 7, 8]);
        let found = compare(&a, &a);
        assert_eq!(found, Comparison { max: 0, worst: None, psnr: f64::INFINITY, differing: 0 });
    }

    #[test]
    fn one_channel_of_one_pixel_counts() {
        let (a, b) = (picture(&[0, 0, 0, 0, 10, 10, 10, 10]), picture(&[0, 0, 0, 0, 10, 10, 10, 7]));
        let found = compare(&a, &b);
        assert_eq!((found.max, found.worst, found.differing), (3, Some([1, 0]), 1));
        let expected = 10.0 * (255.0f64 * 255.0 / (9.0 / 8.0)).log10();
        assert!((found.psnr - expected).abs() < 1e-9);
        assert_eq!(difference(&a, &b, 3).bytes, [0, 0, 0, 255, 255, 255, 255, 255]);
    }
}
