//! Reads RIB files and prints what the reader says about them.

use olema_formats::rib::{ReadOptions, RibReader};

fn main() {
    for path in std::env::args_os().skip(1) {
        let path = std::path::Path::new(&path);
        let start = std::time::Instant::now();
        let mut reader = match RibReader::open(path, ReadOptions::default()) {
            Ok(reader) => reader,
            Err(e) => {
                println!("{e}");
                continue;
            }
        };
        let (mut frames, mut primitives) = (0, 0);
        let end = loop {
            match reader.next_frame() {
                Ok(Some(frame)) => {
                    frames += 1;
                    primitives += frame.scene.primitives.len();
                }
                Ok(None) => break String::new(),
                Err(e) => break format!("; ended by {e}"),
            }
        };
        let seconds = start.elapsed().as_secs_f64();
        for diagnostic in reader.take_diagnostics() {
            println!("  {diagnostic}");
        }
        println!("{}: {frames} frames, {primitives} primitives, {seconds:.4} s{end}", path.display());
    }
}
