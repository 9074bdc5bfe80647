//! Throughput of the RIB reader: 10 MB of bicubic patches, from bytes to scene primitives.

// The macros make a public function without documentation.
#![allow(missing_docs)]

use std::fmt::Write;
use std::hint::black_box;
use std::io::Cursor;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use olema_formats::rib::{ReadOptions, RibReader};

/// A world of at least `bytes` bytes of patches with 48 numbers each, printed to six decimals.
fn patches(bytes: usize) -> String {
    let mut text = String::from("Projection \"perspective\" \"fov\" [40]\nWorldBegin\nSurface \"plastic\"\n");
    let mut seed = 1u32;
    let mut next = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed >> 8) / f64::from(1 << 24) * 20.0 - 10.0
    };
    while text.len() < bytes {
        text.push_str("Patch \"bicubic\" \"P\" [");
        for point in 0..16 {
            let _ = write!(text, "{:.6} {:.6} {:.6}", next(), next(), next());
            text.push(if point % 4 == 3 { '\n' } else { ' ' });
        }
        text.push_str("]\n");
    }
    text.push_str("WorldEnd\n");
    text
}

fn read(bytes: &'static [u8]) -> usize {
    let mut reader = RibReader::from_stream("bench", Box::new(Cursor::new(bytes)), ReadOptions::default());
    let mut primitives = 0;
    while let Ok(Some(frame)) = reader.next_frame() {
        primitives += black_box(frame).scene.primitives.len();
    }
    primitives
}

fn rib(c: &mut Criterion) {
    // The reader owns its stream, so the text lives as long as the bench.
    let bytes: &'static [u8] = Box::leak(patches(10_000_000).into_bytes().into_boxed_slice());
    assert!(read(bytes) > 10_000);
    let mut group = c.benchmark_group("rib");
    group.throughput(Throughput::Bytes(bytes.len() as u64));
    group.bench_function("10 MB of bicubic patches", |b| b.iter(|| read(bytes)));
    group.finish();
}

criterion_group!(benches, rib);
criterion_main!(benches);
