//! PNG files written, read back, cut short and made up.

use std::io::BufReader;

use olema::image::{Picture8, srgb_decode};

use super::*;

/// A picture of the frame's part from (2, 1) on; channel values as functions of the place.
fn image(size: [u32; 2], pixel: impl Fn(u32, u32) -> [f32; 4]) -> Image {
    let mut image = Image::new([100, 100], [2, 2 + size[0], 1, 1 + size[1]], &["r", "g", "b", "a"]);
    for ix in 0..(size[0] * size[1]) {
        for (channel, value) in image.channels.iter_mut().zip(pixel(ix % size[0], ix / size[0])) {
            channel.values[ix as usize] = value;
        }
    }
    image
}

fn exact() -> PngOptions {
    PngOptions { quantize: Quantize { one: 255, min: 0, max: 255, dither: 0.0 }, ..PngOptions::default() }
}

/// Writes, reads back and returns the picture.
fn round_trip(image: &Image, options: &PngOptions) -> Picture8 {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.png");
    write_png(&path, image, options).unwrap();
    assert_eq!(names(dir.path()), ["a.png"]);
    read_png(&path).unwrap()
}

fn names(dir: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(dir).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn every_byte_survives_the_way_there_and_back() {
    // Any straight colour of 8 bits, multiplied by its alpha in linear light, comes back as it was.
    let wanted =
        |x: u32, y: u32| [x as u8, (x * 7 + y) as u8, (255 - x) as u8, [1, 30, 128, 255][y as usize]];
    let source = image([256, 4], |x, y| {
        let [r, g, b, a] = wanted(x, y).map(|byte| f32::from(byte) / 255.0);
        [srgb_decode(r) * a, srgb_decode(g) * a, srgb_decode(b) * a, a]
    });
    let picture = round_trip(&source, &exact());
    assert_eq!((picture.width, picture.height), (256, 4));
    for (x, y) in (0..256).flat_map(|x| (0..4).map(move |y| (x, y))) {
        assert_eq!(picture.pixel(x, y), wanted(x, y), "at {x}, {y}");
    }
}

#[test]
fn rgb_is_the_picture_over_black() {
    let source = image([3, 1], |x, _| [0.5, 0.0, 1.0, [0.0, 0.5, 1.0][x as usize]]);
    let picture = round_trip(&source, &PngOptions { mode: PngMode::Rgb, ..exact() });
    assert!(picture.rgba.chunks_exact(4).all(|p| p == [188, 0, 255, 255]));
    // With alpha the same light is divided by it, and without any alpha there is nothing to see.
    let picture = round_trip(&source, &exact());
    assert_eq!(picture.rgba, [0, 0, 0, 0, 255, 0, 255, 128, 188, 0, 255, 255]);
}

#[test]
fn a_gamma_of_the_scene_is_not_encoded_again() {
    let options = PngOptions { gamma: 2.0, ..exact() };
    // Light 0.25 at half coverage after Exposure 1 2: sqrt(0.125), sqrt(0.25) once alpha is divided out.
    let source = image([1, 1], |_, _| [0.125f32.sqrt(), 0.0, 0.5f32.sqrt(), 0.5]);
    assert_eq!(round_trip(&source, &options).pixel(0, 0), [128, 0, 255, 128]);
    let tags = |options: &PngOptions| {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        write_png(&path, &source, options).unwrap();
        let reader = png::Decoder::new(BufReader::new(File::open(path).unwrap())).read_info().unwrap();
        (reader.info().srgb.is_some(), reader.info().gama_chunk.map(|g| g.into_scaled()))
    };
    assert_eq!(tags(&options), (false, Some(50_000)));
    assert!(tags(&exact()).0);
    assert_eq!(tags(&PngOptions { gamma: 1e9, ..exact() }), (false, None));
}

#[test]
fn values_that_are_no_colours_become_bytes() {
    let source = image([6, 1], |x, _| match x {
        0 => [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.0],
        1 => [-1.0, 2.0, -0.0, 1.0],
        2 => [1.0, 1.0, 1.0, f32::NAN],
        3 => [1.0, 1.0, 1.0, -0.5],
        4 => [1.25, 0.0, 0.0, 1.25],
        _ => [1.0, 0.0, 0.0, f32::INFINITY],
    });
    let picture = round_trip(&source, &exact());
    let wanted =
        [[0, 255, 0, 255], [0, 255, 0, 255], [0, 0, 0, 0], [0, 0, 0, 0], [255, 0, 0, 255], [0, 0, 0, 255]];
    assert_eq!(picture.rgba, wanted.concat());
}

#[test]
fn dither_follows_the_frame_not_the_window() {
    let gray = |_: u32, _: u32| [0.2138, 0.2138, 0.2138, 1.0];
    let whole = round_trip(&image([16, 16], gray), &PngOptions::default());
    let mut crop = image([8, 8], gray);
    crop.window_px = [6, 14, 5, 13];
    let part = round_trip(&crop, &PngOptions::default());
    for (x, y) in (0..8).flat_map(|x| (0..8).map(move |y| (x, y))) {
        assert_eq!(part.pixel(x, y), whole.pixel(x + 4, y + 4));
    }
    let mut bytes: Vec<u8> = whole.rgba.chunks_exact(4).flat_map(|p| p[..3].to_vec()).collect();
    bytes.sort_unstable();
    bytes.dedup();
    assert_eq!(bytes, [127, 128]);
    assert!(whole.rgba.iter().skip(3).step_by(4).all(|alpha| *alpha == 255));
}

#[test]
fn quantize_is_heeded_as_far_as_bytes_go() {
    let source = image([2, 1], |x, _| [x as f32, 0.0, 0.0, 1.0]);
    let with = |one, min, max| {
        let quantize = Quantize { one, min, max, dither: 0.0 };
        round_trip(&source, &PngOptions { quantize, ..exact() }).rgba
    };
    assert_eq!(with(100, 10, 90), [10, 10, 10, 90, 90, 10, 10, 90]);
    for (one, max) in [(0, 0), (65_535, 65_535)] {
        assert_eq!(with(one, 0, max), [0, 0, 0, 255, 255, 0, 0, 255]);
    }
    assert_eq!(with(255, -300, 255), [0, 0, 0, 255, 255, 0, 0, 255]);
}

#[test]
fn failing_leaves_nothing_behind_and_names_the_file() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.png");
    let source = image([2, 2], |_, _| [1.0; 4]);
    fs::write(&path, b"older").unwrap();

    let mut lacking = source.clone();
    lacking.channels.remove(1);
    let said = write_png(&path, &lacking, &exact()).unwrap_err().to_string();
    assert!(said.contains("a.png: the image has no channel \"g\" of 4 values"), "{said}");
    let mut empty = source.clone();
    empty.window_px = [0; 4];
    empty.channels.iter_mut().for_each(|c| c.values.clear());
    assert!(matches!(write_png(&path, &empty, &exact()), Err(ImageError::Encode { .. })));
    assert_eq!((names(dir.path()), fs::read(&path).unwrap()), (vec!["a.png".to_owned()], b"older".to_vec()));

    let said = write_png(&dir.path().join("none/b.png"), &source, &exact()).unwrap_err().to_string();
    assert!(said.contains("b.png: cannot create: "), "{said}");
    let said = write_png(dir.path(), &source, &exact()).unwrap_err().to_string();
    assert!(said.contains(": cannot write: is a directory"), "{said}");
    let said = read_png(&dir.path().join("c.png")).unwrap_err().to_string();
    assert!(said.contains("c.png: cannot open: "), "{said}");

    // And a longest name still works, an older file is replaced.
    let long = dir.path().join("n".repeat(251) + ".png");
    write_png(&long, &source, &exact()).unwrap();
    write_png(&path, &source, &exact()).unwrap();
    assert_eq!(read_png(&path).unwrap(), read_png(&long).unwrap());
    assert_eq!(names(dir.path()).len(), 2);
}

#[cfg(unix)]
#[test]
fn links_and_devices_stay_what_they_are() {
    let dir = tempfile::tempdir().unwrap();
    let (file, link) = (dir.path().join("file.png"), dir.path().join("link.png"));
    fs::write(&file, b"older").unwrap();
    std::os::unix::fs::symlink(&file, &link).unwrap();
    let source = image([2, 2], |_, _| [1.0; 4]);
    write_png(&link, &source, &exact()).unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(read_png(&file).unwrap(), Picture8::filled(2, 2, [255; 4]));

    // Renaming over it would have made the device a file.
    use std::os::unix::fs::FileTypeExt;
    write_png(Path::new("/dev/null"), &source, &exact()).unwrap();
    assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
}
