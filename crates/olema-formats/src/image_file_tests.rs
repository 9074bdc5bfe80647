//! PNG files written, read back, cut short and made up.

use std::io::Cursor;

use olema::image::srgb_decode;

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

/// PNG bytes of that kind with the given samples.
fn made(color: png::ColorType, depth: png::BitDepth, size: [u32; 2], samples: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
    encoder.set_color(color);
    encoder.set_depth(depth);
    if color == png::ColorType::Indexed {
        encoder.set_palette(vec![10, 20, 30, 40, 50, 60]);
        encoder.set_trns(vec![255, 7]);
    }
    encoder.write_header().unwrap().write_image_data(samples).unwrap();
    bytes
}

fn decode_bytes(bytes: &[u8]) -> Result<Picture8, ImageError> {
    decode(Path::new("a.png"), Cursor::new(bytes), MAX_PIXELS)
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

#[test]
fn every_kind_of_png_is_read_as_rgba() {
    use png::{BitDepth::*, ColorType::*};
    let cases: [(png::ColorType, png::BitDepth, &[u8], [u8; 8]); 8] = [
        (Grayscale, One, &[0b0100_0000], [0, 0, 0, 255, 255, 255, 255, 255]),
        (Grayscale, Eight, &[9, 200], [9, 9, 9, 255, 200, 200, 200, 255]),
        (Grayscale, Sixteen, &[9, 9, 200, 255], [9, 9, 9, 255, 200, 200, 200, 255]),
        (GrayscaleAlpha, Eight, &[9, 8, 200, 199], [9, 9, 9, 8, 200, 200, 200, 199]),
        (Rgb, Eight, &[1, 2, 3, 4, 5, 6], [1, 2, 3, 255, 4, 5, 6, 255]),
        (Rgba, Eight, &[1, 2, 3, 4, 5, 6, 7, 8], [1, 2, 3, 4, 5, 6, 7, 8]),
        (Rgba, Sixteen, &[1, 0, 2, 0, 3, 0, 4, 0, 5, 255, 6, 255, 7, 255, 8, 255], [1, 2, 3, 4, 5, 6, 7, 8]),
        (Indexed, Two, &[0b0100_0000], [40, 50, 60, 7, 10, 20, 30, 255]),
    ];
    for (color, depth, samples, rgba) in cases {
        let picture = decode_bytes(&made(color, depth, [2, 1], samples)).unwrap();
        assert_eq!(picture, Picture8 { width: 2, height: 1, rgba: rgba.to_vec() }, "{color:?} {depth:?}");
    }
}

#[test]
fn a_file_cut_short_anywhere_is_an_error() {
    let samples: Vec<u8> = (0..4 * 16 * 16).map(|n| (n * 31 % 256) as u8).collect();
    let whole = made(png::ColorType::Rgba, png::BitDepth::Eight, [16, 16], &samples);
    assert_eq!(decode_bytes(&whole).unwrap().rgba, samples);
    for len in 0..whole.len() {
        let error = decode_bytes(&whole[..len]).unwrap_err();
        assert!(error.to_string().starts_with("a.png: not a readable PNG file: "), "{len}: {error}");
    }
}

#[test]
fn a_flipped_bit_is_an_error_or_a_picture_but_no_panic() {
    let whole = made(png::ColorType::Rgb, png::BitDepth::Eight, [4, 4], &[77; 48]);
    for bit in 0..8 * whole.len() {
        let mut bytes = whole.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        if let Ok(picture) = decode_bytes(&bytes) {
            assert_eq!(picture.rgba.len(), 4 * picture.width as usize * picture.height as usize);
        }
    }
}

#[test]
fn a_file_that_claims_too_much_is_refused_before_it_costs_memory() {
    let mut bytes = made(png::ColorType::Rgba, png::BitDepth::Eight, [1, 1], &[1, 2, 3, 4]);
    let claim = |bytes: &mut Vec<u8>, width: u32, height: u32, interlace: u8| {
        bytes[16..20].copy_from_slice(&width.to_be_bytes());
        bytes[20..24].copy_from_slice(&height.to_be_bytes());
        bytes[28] = interlace;
        let crc = crc32(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&crc.to_be_bytes());
    };
    for interlace in [0, 1] {
        claim(&mut bytes, 1, 1, interlace);
        assert_eq!(decode_bytes(&bytes).unwrap().rgba, [1, 2, 3, 4]);
    }
    for (width, height, interlace) in [(65_536, 65_536, 0), (16_384, 16_384, 1), (16, 0x7fff_ffff, 0)] {
        claim(&mut bytes, width, height, interlace);
        let error = decode_bytes(&bytes).unwrap_err();
        assert!(matches!(error, ImageError::TooLarge { .. }), "{error}");
    }
    // Within the limit, but the rows are not there.
    claim(&mut bytes, 16_384, 16_384, 0);
    assert!(matches!(decode_bytes(&bytes), Err(ImageError::Decode { .. })));
    claim(&mut bytes, 0x7fff_ffff, 1, 0);
    assert!(decode_bytes(&bytes).is_err());
}

/// PNG's checksum, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 };
    !bytes.iter().fold(u32::MAX, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), step))
}
