//! Archives, objects, procedurals, compressed files.

use std::fs;
use std::io::Write;
use std::sync::Arc;

use flate2::Compression;
use flate2::write::GzEncoder;
use olema::scene::Geometry;

use super::*;

fn gzip(text: &str) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(text.as_bytes()).expect("in memory");
    encoder.finish().expect("in memory")
}

#[test]
fn gzip_is_recognised_and_members_are_joined() {
    let mut bytes = gzip("WorldBegin Pat");
    bytes.extend(gzip(&PATCH[3..]));
    bytes.extend(gzip(" WorldEnd"));
    let read1 = read_with(&bytes, ReadOptions::default());
    assert_eq!(read1.frames[0].scene.primitives.len(), 1);
    bytes.truncate(bytes.len() - 12);
    let read2 = read_with(&bytes, ReadOptions::default());
    assert!(matches!(read2.error, Some(ReadError::Fatal(_))), "{:?}", read2.error);
}

#[test]
fn instances_share_geometry_and_take_the_state_they_find() {
    let frame = world(&format!(
        "ObjectBegin 1 Translate 0 1 0 {PATCH} {PATCH} Color 0 0 1 ObjectEnd
        ObjectBegin \"named\" ObjectInstance 1 ObjectEnd
        Color 1 0 0 ObjectInstance 1 Translate 5 0 0 Color 0 1 0 ObjectInstance \"named\" {PATCH}"
    ));
    let p = &frame.scene.primitives;
    assert_eq!(p.len(), 5);
    let mesh = |ix: usize| match &p[ix].geometry {
        Geometry::Patches(mesh) => mesh,
        _ => panic!("a patch"),
    };
    assert!(Arc::ptr_eq(mesh(0), mesh(2)) && Arc::ptr_eq(mesh(1), mesh(3)));
    assert_eq!((p[0].attributes.color, p[2].attributes.color), ([1., 0., 0.], [0., 1., 0.]));
    assert_eq!(to_world(&frame, 2).w_axis.truncate(), DVec3::new(5.0, 1.0, 0.0));
    // What the object did to the state stays with it.
    assert_eq!(p[4].attributes.color, [0., 1., 0.]);
    assert_eq!(to_world(&frame, 4).w_axis.y, 0.0);
    read("WorldBegin ObjectInstance 4 WorldEnd").says(Severity::Error, 1, 27, "object 4 is unknown");
}

#[test]
fn a_bicubic_instance_follows_its_basis() {
    let patch = format!("Patch \"bicubic\" \"P\" [{}]", "0 1 2 ".repeat(16));
    let frame = world(&format!(
        "ObjectBegin 1 {patch} ObjectEnd ObjectInstance 1 Basis \"b-spline\" 1 \"b-spline\" 1 ObjectInstance 1"
    ));
    let kind = |ix: usize| match &frame.scene.primitives[ix].geometry {
        Geometry::Patches(mesh) => *mesh.kind,
        _ => panic!("a patch"),
    };
    assert_ne!(kind(0), kind(1));
}

#[test]
fn objects_cannot_close_what_they_did_not_open() {
    let read = read(&format!(
        "WorldBegin ObjectBegin 1 WorldEnd\n AttributeEnd {PATCH} AttributeBegin ObjectEnd
        AttributeBegin ObjectInstance 1 Translate 1 0 0 AttributeEnd {PATCH} WorldEnd"
    ));
    assert_eq!(read.diagnostics.len(), 2, "{:?}", read.said());
    assert_eq!(read.frames[0].scene.primitives.len(), 2);
    assert_eq!(to_world(&read.frames[0], 1), DMat4::IDENTITY);
}

#[test]
fn inline_archives_are_run_as_if_written_out() {
    let frame = frame(&format!(
        "ArchiveBegin \"a\" Declare \"fuzz\" \"float\" Translate 1 0 0 ArchiveBegin \"b\" {PATCH} ArchiveEnd
            IfBegin \"$Frame == 1\" ReadArchive \"b\" IfEnd ArchiveEnd
        FrameBegin 1 WorldBegin ReadArchive \"a\" ReadArchive \"a\" WorldEnd FrameEnd"
    ));
    let x: Vec<f64> = (0..2).map(|ix| to_world(&frame, ix).w_axis.x).collect();
    assert_eq!(x, [1.0, 2.0]);
}

#[test]
fn archives_are_found_beside_the_file_and_along_the_search_path() {
    let dir = tempfile::tempdir().expect("a directory");
    let path = |name: &str| dir.path().join(name);
    fs::create_dir_all(path("lib/deep")).expect("a directory");
    fs::write(path("beside.rib"), "AttributeBegin ReadArchive \"found.rib.gz\" AttributeEnd")
        .expect("a file");
    fs::write(path("lib/deep/found.rib.gz"), gzip(PATCH)).expect("a file");
    let main = format!(
        "Option \"searchpath\" \"string archive\" \"@:lib/deep:&\" WorldBegin ReadArchive \"beside.rib\"\n{PATCH}
        Procedural \"DelayedReadArchive\" [\"beside.rib\"] [0 1 0 1 0 1]
        ReadArchive \"missing.rib\" WorldEnd"
    );
    fs::write(path("main.rib"), main).expect("a file");
    let mut reader = RibReader::open(&path("main.rib"), ReadOptions::default()).expect("the file");
    let read = read_all(&mut reader);
    read.says(Severity::Warning, 4, 9, "missing.rib");
    let origins: Vec<String> = read.frames[0]
        .scene
        .primitives
        .iter()
        .map(|p| p.origin.to_string().rsplit('/').next().unwrap_or_default().to_owned())
        .collect();
    assert_eq!(origins, ["found.rib.gz:1", "main.rib:2", "found.rib.gz:1"]);
}

#[test]
fn archives_that_read_themselves_end() {
    let dir = tempfile::tempdir().expect("a directory");
    let path = |name: &str| dir.path().join(name);
    fs::write(path("a.rib"), "ReadArchive \"b.rib\"").expect("a file");
    fs::write(path("b.rib"), format!("{PATCH} ReadArchive \"./a.rib\"")).expect("a file");
    fs::write(path("main.rib"), "WorldBegin ReadArchive \"a.rib\" WorldEnd").expect("a file");
    let mut reader = RibReader::open(&path("main.rib"), ReadOptions::default()).expect("the file");
    let read1 = read_all(&mut reader);
    assert_eq!(read1.frames[0].scene.primitives.len(), 1);
    assert!(read1.diagnostics[0].message.contains("reads itself"));
    let read2 = read("ArchiveBegin \"a\" ReadArchive \"a\" ArchiveEnd WorldBegin ReadArchive \"a\" WorldEnd");
    assert!(read2.diagnostics[0].message.contains("nested deeper than 64"), "{:?}", read2.said());
    assert_eq!(read2.frames.len(), 1);
}

#[test]
fn archives_that_double_are_stopped_by_the_memory_limit() {
    let mut text = String::from("ArchiveBegin \"a0\" Color 1 1 1 ArchiveEnd\n");
    for level in 1..60 {
        let below = level - 1;
        text += &format!(
            "ArchiveBegin \"a{level}\" ReadArchive \"a{below}\" ReadArchive \"a{below}\" ArchiveEnd\n"
        );
    }
    text += "WorldBegin ReadArchive \"a59\" WorldEnd";
    let options = ReadOptions { memory: 1 << 20, ..ReadOptions::default() };
    let read = read_with(text.as_bytes(), options);
    assert!(read.diagnostics.iter().any(|d| d.message.contains("used up by instances")), "{:?}", read.said());
}

#[test]
fn procedurals_that_would_run_code_are_refused() {
    for kind in ["RunProgram", "DynamicLoad"] {
        let read = read(&format!("WorldBegin Procedural \"{kind}\" [\"x\" \"y\"] [0 1 0 1 0 1] WorldEnd"));
        read.says(Severity::Warning, 1, 12, "is refused");
    }
}
