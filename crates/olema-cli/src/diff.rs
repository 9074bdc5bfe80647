//! `olema diff`: how far two pictures are apart.

use olema::image::{Picture8, compare};

use crate::args::DiffArgs;
use crate::exit::{self, Failure};
use crate::output;
use crate::picture;
use crate::report::{self, Reporter};

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
    let found = match compare::compare(&a, &b) {
        Ok(found) => found,
        Err(error) => {
            report::print(&format!("{error}\n"))?;
            return Ok(exit::RENDER);
        }
    };
    let place = worst_pixel(&a, &b).map(|[x, y]| format!(" at pixel {x},{y}")).unwrap_or_default();
    report::print(&format!(
        "max difference   {} of 255{place}\npsnr             {:.2} dB\ndiffering pixels {} of {}\n",
        found.max, found.psnr, found.differing_pixels, found.num_pixels
    ))?;
    if let Some(path) = &args.output {
        // Small differences are to be seen as well: the largest gets as bright as a whole factor makes it.
        let gain = 255 / (found.max as u32).max(1);
        if let Ok(picture) = compare::difference_picture(&a, &b, gain) {
            picture::write_bytes(path, &picture)?;
            report::print(&format!("{}\n", path.display()))?;
        }
    }
    Ok(if found.max > args.tolerance.0 { exit::RENDER } else { exit::OK })
}

/// Column and row of the first pixel that has the largest difference of a channel; none for equal pictures.
fn worst_pixel(a: &Picture8, b: &Picture8) -> Option<[u32; 2]> {
    let mut worst = (0, None);
    for (ix, (p, q)) in a.rgba.chunks_exact(4).zip(b.rgba.chunks_exact(4)).enumerate() {
        let step = p.iter().zip(q).map(|(p, q)| p.abs_diff(*q)).max().unwrap_or(0);
        if step > worst.0 {
            let width = a.width as usize;
            worst = (step, Some([(ix % width) as u32, (ix / width) as u32]));
        }
    }
    worst.1
}
