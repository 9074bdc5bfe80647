//! PNG files read, cut short and made up.

use std::io::Cursor;

use super::*;

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
    decode_picture(Path::new("a.png"), Cursor::new(bytes))
}

fn decode_heights_of(bytes: &[u8]) -> Result<Heights, ImageError> {
    decode_heights(Path::new("a.png"), Cursor::new(bytes), MAX_PIXELS)
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
fn every_kind_of_png_is_read_as_heights_with_all_its_bits() {
    use png::{BitDepth::*, ColorType::*};
    let (byte, word) = (|n: f32| n / 255.0, |n: f32| n / 65535.0);
    let cases: [(png::ColorType, png::BitDepth, &[u8], [f32; 2]); 9] = [
        (Grayscale, One, &[0b0100_0000], [0.0, 1.0]),
        (Grayscale, Eight, &[9, 200], [byte(9.0), byte(200.0)]),
        (Grayscale, Sixteen, &[0, 9, 200, 1], [word(9.0), word(51201.0)]),
        (GrayscaleAlpha, Eight, &[9, 8, 200, 199], [byte(9.0), byte(200.0)]),
        (GrayscaleAlpha, Sixteen, &[0, 9, 1, 1, 200, 1, 1, 1], [word(9.0), word(51201.0)]),
        (Rgb, Eight, &[1, 2, 6, 4, 5, 12], [byte(3.0), byte(7.0)]),
        (Rgb, Sixteen, &[0, 1, 0, 2, 0, 6, 1, 0, 2, 0, 3, 0], [word(3.0), word(512.0)]),
        (Rgba, Sixteen, &[0, 1, 0, 2, 0, 6, 9, 9, 1, 0, 2, 0, 3, 0, 0, 0], [word(3.0), word(512.0)]),
        (Indexed, Two, &[0b0100_0000], [byte(50.0), byte(20.0)]),
    ];
    for (color, depth, samples, values) in cases {
        let heights = decode_heights_of(&made(color, depth, [2, 1], samples)).unwrap();
        let expected = Heights { width: 2, height: 1, values: values.to_vec() };
        assert_eq!(heights, expected, "{color:?} {depth:?}");
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
        assert!(decode_heights_of(&whole[..len]).is_err());
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
