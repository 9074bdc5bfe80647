//! `olema diff`.

mod common;

use common::{Bench, png_size};

fn ramp(x: u32, y: u32) -> [u8; 4] {
    [x as u8, y as u8, 100, 255]
}

/// The ramp with one channel of pixel 3,2 changed by 5.
fn spotted(x: u32, y: u32) -> [u8; 4] {
    let [r, g, b, a] = ramp(x, y);
    if (x, y) == (3, 2) { [r, g, b + 5, a] } else { [r, g, b, a] }
}

#[test]
fn equal_pictures_pass() {
    let bench = Bench::new();
    bench.png("a.png", 8, 6, ramp);
    bench.png("b.png", 8, 6, ramp);
    let ran = bench.run(&["diff", "a.png", "b.png"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    assert!(ran.out.contains("max difference   0 of 255\n"), "{}", ran.out);
    assert!(ran.out.contains("psnr             inf dB\n"), "{}", ran.out);
    assert!(ran.out.contains("differing pixels 0 of 48\n"), "{}", ran.out);
}

#[test]
fn one_changed_channel_fails_and_is_found() {
    let bench = Bench::new();
    bench.png("a.png", 8, 6, ramp);
    bench.png("b.png", 8, 6, spotted);
    let ran = bench.run(&["diff", "a.png", "b.png"]);
    assert_eq!(ran.code, 1);
    assert!(ran.out.contains("max difference   5 of 255 at pixel 3,2\n"), "{}", ran.out);
    // Mean square 25 / 192 over all channels.
    assert!(ran.out.contains("psnr             56.98 dB\n"), "{}", ran.out);
    assert!(ran.out.contains("differing pixels 1 of 48\n"), "{}", ran.out);
}

#[test]
fn the_tolerance_is_inclusive() {
    let bench = Bench::new();
    bench.png("a.png", 8, 6, ramp);
    bench.png("b.png", 8, 6, spotted);
    for (tolerance, code) in [("4", 1), ("4.99", 1), ("5", 0), ("255", 0)] {
        let ran = bench.run(&["diff", "a.png", "b.png", "--tolerance", tolerance]);
        assert_eq!(ran.code, code, "{tolerance}");
    }
}

#[test]
fn a_difference_in_alpha_alone_counts() {
    let bench = Bench::new();
    bench.png("a.png", 2, 2, |_, _| [0, 0, 0, 0]);
    bench.png("b.png", 2, 2, |_, _| [0, 0, 0, 255]);
    let ran = bench.run(&["diff", "a.png", "b.png", "--tolerance", "254"]);
    assert_eq!(ran.code, 1);
    assert!(ran.out.contains("max difference   255 of 255 at pixel 0,0\n"), "{}", ran.out);
}

#[test]
fn the_difference_picture_shows_where() {
    let bench = Bench::new();
    bench.png("a.png", 8, 6, ramp);
    bench.png("b.png", 8, 6, spotted);
    let ran = bench.run(&["diff", "a.png", "b.png", "-o", "d.png"]);
    assert_eq!(ran.code, 1);
    assert!(ran.out.ends_with("d.png\n"), "{}", ran.out);
    assert_eq!(png_size(&bench.path("d.png")), [8, 6]);
    bench.png("expected.png", 8, 6, |x, y| if (x, y) == (3, 2) { [0, 0, 255, 255] } else { [0, 0, 0, 255] });
    assert_eq!(bench.run(&["diff", "d.png", "expected.png"]).code, 0);
    assert_eq!(bench.names(), ["a.png", "b.png", "d.png", "expected.png"]);
}

#[test]
fn pictures_of_different_sizes_differ_whatever_the_tolerance() {
    let bench = Bench::new();
    bench.png("a.png", 8, 6, ramp);
    bench.png("b.png", 6, 8, ramp);
    let ran = bench.run(&["diff", "a.png", "b.png", "--tolerance", "255", "-o", "d.png"]);
    assert_eq!(ran.code, 1);
    assert_eq!(ran.out, "the pictures differ in size: 8x6 and 6x8 pixels\n");
    assert_eq!(bench.names(), ["a.png", "b.png"]);
}

#[test]
fn pictures_that_cannot_be_read_exit_3_and_are_named() {
    let bench = Bench::new();
    let good = std::fs::read(bench.png("a.png", 8, 6, ramp)).unwrap();
    bench.file("text.png", "no picture");
    bench.file("empty.png", "");
    bench.file("cut.png", &good[..good.len() / 2]);
    for bad in ["missing.png", "text.png", "empty.png", "cut.png"] {
        for args in [["diff", "a.png", bad], ["diff", bad, "a.png"]] {
            let ran = bench.run(&args);
            assert_eq!(ran.code, 3, "{bad}: {}", ran.out);
            assert!(ran.err.contains(bad), "{}", ran.err);
        }
    }
}

#[test]
fn a_png_that_claims_a_huge_size_is_refused_without_the_memory() {
    let bench = Bench::new();
    let mut bytes = std::fs::read(bench.png("a.png", 8, 6, ramp)).unwrap();
    bytes[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
    bench.file("huge.png", &bytes);
    let ran = bench.run(&["diff", "a.png", "huge.png"]);
    assert_eq!(ran.code, 3, "{}", ran.err);
}
