//! Displacement shaders, their images and bounds.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use olema::Image;
use olema::math::Vec3s;
use olema::scene::Attributes;
use olema::shading::{DisplacementPoints, DisplacementShader};

use super::*;
use crate::image_file::{PngOptions, write_png};

fn attributes(frame: &RibFrame, ix: usize) -> &Attributes {
    &frame.scene.primitives[ix].attributes
}

fn shader(frame: &RibFrame, ix: usize) -> &Arc<dyn DisplacementShader> {
    attributes(frame, ix).displacement.as_ref().expect("a displacement shader")
}

/// What one point at `p` is moved by, at the middle of s and t.
fn offset(shader: &dyn DisplacementShader, p: Vec3) -> Vec3 {
    offset_at(shader, p, 0.5)
}

fn offset_at(shader: &dyn DisplacementShader, p: Vec3, s: f32) -> Vec3 {
    let points = DisplacementPoints {
        p: Vec3s::splat(p, 1),
        n: Vec3s::splat(Vec3::Z, 1),
        u: vec![0.5],
        v: vec![0.5],
        s: vec![s],
        t: vec![0.5],
        width: vec![1e-4],
        st_width: vec![1e-4],
    };
    let mut offset = Vec3s::splat(Vec3::ZERO, 1);
    shader.displace(&points, &mut offset);
    offset.get(0)
}

#[test]
fn a_displacement_goes_with_the_attributes() {
    let frame = world(&format!(
        "{PATCH} AttributeBegin Displacement \"fractal\" \"amplitude\" 0.25 \"octaves\" 3 \"vector offset\" [1 2 3] {PATCH}
        Displacement \"noise\" \"bump\" 1 {PATCH} Displacement \"null\" {PATCH} AttributeEnd {PATCH}"
    ));
    let names: Vec<_> =
        (0..5).map(|ix| attributes(&frame, ix).displacement.as_ref().map(|d| d.name().to_owned())).collect();
    assert_eq!(names, [None, Some("fractal".to_owned()), Some("noise".to_owned()), None, None]);
    assert_eq!(shader(&frame, 1).amplitude(), Some(0.25));
    assert!(shader(&frame, 2).is_bump() && !shader(&frame, 1).is_bump());
}

#[test]
fn an_unknown_displacement_leaves_the_surface_as_it_is() {
    let read = read(&format!(
        "WorldBegin Displacement \"noise\"\nDisplacement \"dents\" \"float Km\" 1 {PATCH} WorldEnd"
    ));
    read.says(Severity::Warning, 2, 1, "there is no displacement \"dents\": expected one of bumpy, cells");
    assert!(read.diagnostics[0].message.ends_with("drawn undisplaced"));
    assert!(attributes(&read.frames[0], 0).displacement.is_none());
    let told =
        super::read("WorldBegin Displacement \"noise\" \"float Km\" 1 \"octaves\" 40 WorldEnd").diagnostics;
    assert_eq!(told.len(), 2, "{told:?}");
}

#[test]
fn lengths_are_those_of_the_statements_space() {
    // The second patch is twice as large in its shader's space as in its own.
    let frame = world(&format!(
        "Displacement \"noise\" {PATCH} Scale 2 2 2 {PATCH} {PATCH} Displacement \"noise\" {PATCH}"
    ));
    assert!((shader(&frame, 1).amplitude().expect("known") - 0.05).abs() < 1e-6);
    assert!(Arc::ptr_eq(shader(&frame, 1), shader(&frame, 2)), "one space, one shader");
    assert_eq!(shader(&frame, 3).amplitude(), Some(0.1));
    let whole = offset(&**shader(&frame, 0), Vec3::new(0.6, 0.4, 0.2));
    let half = offset(&**shader(&frame, 1), Vec3::new(0.3, 0.2, 0.1));
    assert!(whole.z != 0.0 && (whole - 2.0 * half).length() < 1e-6, "{whole} {half}");
}

#[test]
fn bounds_are_carried_to_object_space() {
    let camera = "Scale 0.5 0.5 0.5 WorldBegin Scale 3 1 1 CoordinateSystem \"wide\" Displacement \"noise\" Scale 1 2 1";
    for (text, expected) in [
        ("\"float sphere\" [0.6]", 0.6),
        ("\"sphere\" 0.6 \"coordinatesystem\" \"object\"", 0.6),
        // y is halved, x stays.
        ("\"sphere\" 0.6 \"coordinatesystem\" \"shader\"", 0.6),
        ("\"sphere\" 0.6 \"coordinatesystem\" \"wide\"", 0.6),
        // z is not scaled on the way to world.
        ("\"sphere\" 0.6 \"coordinatesystem\" \"world\"", 0.6),
        ("\"sphere\" 0.6 \"string coordinatesystem\" [\"camera\"]", 1.2),
        ("\"sphere\" 0", 0.0),
    ] {
        let frame = frame(&format!("{camera} Attribute \"displacementbound\" {text} {PATCH} WorldEnd"));
        let found = attributes(&frame, 0).displacement_bound;
        assert!((found - expected).abs() < 1e-5, "{text}: {found}, not {expected}");
    }
    // The space is each primitive's own, whatever comes between.
    let frame = world(&format!(
        "Attribute \"displacementbound\" \"sphere\" 1 \"coordinatesystem\" \"world\" Scale 4 4 4 {PATCH} Scale 0.125 1 1 {PATCH}"
    ));
    let bounds = [0, 1].map(|ix| attributes(&frame, ix).displacement_bound);
    assert!((bounds[0] - 0.25).abs() < 1e-5 && (bounds[1] - 2.0).abs() < 1e-5, "{bounds:?}");
}

#[test]
fn wrong_bounds_are_told() {
    for (text, severity, part) in [
        ("\"coordinatesystem\" \"shader\"", Severity::Warning, "expected \"float sphere\""),
        ("\"sphere\" -1", Severity::Error, "sphere is -1: expected a radius of 0 or more"),
        ("\"sphere\" 1 \"coordinatesystem\" \"surface\"", Severity::Warning, "\"surface\" is unknown"),
    ] {
        let read = read(&format!("WorldBegin Attribute \"displacementbound\" {text} WorldEnd"));
        assert_eq!(read.diagnostics.len(), 1, "{:?}", read.said());
        assert_eq!(read.diagnostics[0].severity, severity);
        assert!(read.diagnostics[0].message.contains(part), "{:?}", read.said());
    }
}

/// A gray picture.
fn write_gray(path: &Path, size: u32, gray: f32) {
    let mut image = Image::new([size; 2], [0, size, 0, size], &["r", "g", "b", "a"]);
    for (ix, channel) in image.channels.iter_mut().enumerate() {
        channel.values.fill(if ix == 3 { 1.0 } else { gray });
    }
    write_png(path, &image, &PngOptions::default()).expect("a picture");
}

#[test]
fn images_are_found_beside_the_file_and_along_the_search_path() {
    let dir = tempfile::tempdir().expect("a directory");
    let path = |name: &str| dir.path().join(name);
    fs::create_dir_all(path("maps")).expect("a directory");
    write_gray(&path("white.png"), 4, 1.0);
    write_gray(&path("maps/black.png"), 5, 0.0);
    fs::write(path("maps/text.png"), "not a picture").expect("a file");
    let main = format!(
        "Option \"searchpath\" \"texture\" [\"maps\"]\nWorldBegin
        Displacement \"image\" \"texturename\" \"white.png\" {PATCH}
        Displacement \"bumpy\" \"texturename\" [\"black.png\"] {PATCH}
        Displacement \"image\" \"texturename\" \"text.png\" {PATCH}
        Displacement \"image\" \"texturename\" \"missing.png\" {PATCH}
        Displacement \"image\" {PATCH}
        WorldEnd"
    );
    fs::write(path("main.rib"), main).expect("a file");
    let mut reader = RibReader::open(&path("main.rib"), ReadOptions::default()).expect("the file");
    let read = read_all(&mut reader);
    let said = read.said();
    assert_eq!(
        said.iter().map(|s| (s.0, s.1)).collect::<Vec<_>>(),
        [5, 6, 7].map(|line| (Severity::Warning, line))
    );
    assert!(said[0].3.contains("text.png") && said[0].3.contains("not a readable PNG"), "{said:?}");
    assert!(said[1].3.contains("\"missing.png\" is not in any of the"), "{said:?}");
    assert!(said[2].3.contains("expected the name of an image"), "{said:?}");
    let frame = &read.frames[0];
    assert!((2..5).all(|ix| attributes(frame, ix).displacement.is_none()));
    assert!((offset(&**shader(frame, 0), Vec3::ZERO).z - 0.1).abs() < 1e-6);
    assert_eq!(offset(&**shader(frame, 1), Vec3::ZERO), Vec3::ZERO);
    assert!(shader(frame, 1).is_bump());
}

#[test]
fn a_ramp_of_16_bits_displaces_in_as_many_steps_as_it_has() {
    // Four steps of 8 bits.
    let samples: Vec<u8> = (0..1024u16).flat_map(u16::to_be_bytes).collect();
    let dir = tempfile::tempdir().expect("a directory");
    let path = dir.path().join("ramp.png");
    let mut encoder = png::Encoder::new(fs::File::create(&path).expect("a file"), 1024, 1);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    encoder.write_header().and_then(|mut writer| writer.write_image_data(&samples)).expect("a picture");
    let path = path.display();
    let frame = world(&format!("Displacement \"image\" \"texturename\" \"{path}\" \"amplitude\" 1 {PATCH}"));
    let at = |texel: u16| offset_at(&**shader(&frame, 0), Vec3::ZERO, (f32::from(texel) + 0.5) / 1024.0).z;
    for texel in 1..1022 {
        assert!((at(texel) - f32::from(texel) / 65535.0).abs() < 1e-6, "{texel}: {}", at(texel));
        assert!(at(texel) > at(texel - 1) || texel < 2, "{texel}");
    }
}

#[test]
fn an_image_that_does_not_fit_the_memory_is_left_out() {
    let dir = tempfile::tempdir().expect("a directory");
    let path = dir.path().join("map.png");
    write_gray(&path, 64, 0.5);
    let text =
        format!("WorldBegin Displacement \"image\" \"texturename\" \"{}\" {PATCH} WorldEnd", path.display());
    let read = read_with(text.as_bytes(), ReadOptions { memory: 128 << 10, ..ReadOptions::default() });
    assert!(read.diagnostics.is_empty(), "{:?}", read.said());
    let tight = ReadOptions { memory: 32 << 10, ..ReadOptions::default() };
    let read = read_with(text.as_bytes(), tight);
    assert!(read.diagnostics.iter().any(|d| d.message.contains("pixels are too many")), "{:?}", read.said());
}
