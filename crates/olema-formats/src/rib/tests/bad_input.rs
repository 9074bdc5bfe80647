//! Wrong files: what is said, and where reading goes on.

use super::*;

#[test]
fn a_wrong_statement_is_told_with_its_line_and_skipped() {
    for (text, line, column, part) in [
        ("Sphre 1 -1 1 360", 2, 1, "unknown statement \"Sphre\""),
        ("Color 1 0", 3, 1, "expected 3 numbers for color, found"),
        ("Color \"red\"", 2, 7, "expected color (3 numbers), found a string"),
        ("Color 1 0 0 0", 2, 13, "too many arguments"),
        ("Sides 1.5", 2, 10, "expected an integer"),
        ("Color 1 nan 0", 2, 9, "not a finite number"),
        ("Color 1 -inf 0", 2, 9, "not a finite number"),
        ("Color 1 1.#INF 0", 2, 9, "not a finite number"),
        ("Color 1 1e39 0", 2, 9, "not a finite number"),
        ("Color 1 1e999999999 0", 2, 9, "not a finite number"),
        ("Color 1 12abc 0", 2, 9, "\"12abc\" is not"),
        ("Patch \"bilinear\" \"P\" [1 2 nan 4]", 2, 27, "(not a finite number)"),
        ("Patch \"bilinear\" \"P\" [1 2 \"3\" 4]", 2, 27, "expected numbers or \"]\""),
        ("Patch \"bilinear\" \"P\" [1 2 [3] 4]", 2, 27, "expected numbers or \"]\""),
        ("Patch \"bilinear\" \"P\" \"Q\"", 2, 22, "expected numbers (vertex point), found a string"),
        ("Patch \"bilinear\" \"P\"", 3, 1, "expected numbers (vertex point), found \"Patch\""),
        ("Surface \"matte\" \"string x\" 3", 2, 28, "expected a string"),
        ("Surface \"matte\" \"integer x\" [1.5]", 2, 30, "32-bit integer"),
        ("Surface \"matte\" \"uniform x\" 3", 2, 17, "expected [class] type"),
        ("Surface 3", 2, 9, "expected \"shader\", found a number"),
        ("PointsPolygons [3.5] [] \"P\" []", 2, 17, "32-bit integer"),
        ("Declare \"x\" \"flaot\"", 2, 13, "expected [class] type"),
        ("] 3 4", 2, 1, "expected the next statement (too many arguments?), found \"]\""),
        ("@", 2, 1, "(too many arguments?), found \"@\""),
        ("Patch \"bilinear\" \"P\" [0 0 0 1 0 0 0 1 0 1 1 0", 3, 1, "expected numbers or \"]\""),
    ] {
        let read = read(&format!("WorldBegin\n{text}\n{PATCH} WorldEnd"));
        assert!(read.diagnostics.len() == 1, "{text}: {:#?}", read.said());
        let d = &read.diagnostics[0];
        assert_eq!((d.severity, d.file.as_str()), (Severity::Error, "test.rib"));
        assert_eq!((d.line, d.column), (line, column), "{text}: {}", d.message);
        assert!(d.message.contains(part), "{text}: {}", d.message);
        let shown = if line == 2 { text } else { PATCH };
        assert!(d.source_line.as_deref().is_some_and(|l| l.starts_with(shown)), "{:?}", d.source_line);
        assert_eq!(read.frames[0].scene.primitives.len(), 1, "{text}");
    }
}

#[test]
fn a_file_that_is_cut_off_is_given_up() {
    for (text, part) in [
        ("WorldBegin\nColor 1 1 1", "expected WorldEnd"),
        ("WorldBegin\nSurface \"mat", "expected a closing quote"),
        ("ObjectBegin 1\nColor 1 1 1", "expected ObjectEnd"),
        ("ArchiveBegin \"a\"\nColor 1 1 1", "expected ArchiveEnd"),
    ] {
        let read = read(text);
        let Some(ReadError::Fatal(d)) = read.error else { panic!("{text}") };
        assert!(d.message.contains(part) && d.line == 2, "{d}");
        assert!(read.frames.is_empty());
    }
}

#[test]
fn after_the_end_nothing_comes() {
    let mut reader =
        RibReader::from_stream("-", Box::new(Cursor::new(b"WorldBegin")), ReadOptions::default());
    assert!(reader.next_frame().is_err());
    assert!(matches!(reader.next_frame(), Ok(None)));
}

#[test]
fn binary_rib_is_refused() {
    let read = read_with(b"version 3\n\xa6\x01", ReadOptions::default());
    let Some(ReadError::Fatal(d)) = read.error else { panic!("fatal") };
    assert_eq!((d.line, d.column), (2, 1));
    assert!(d.message.contains("binary RIB"), "{d}");
}

#[test]
fn bytes_that_are_not_utf8_are_replaced_in_strings_and_skipped_in_comments() {
    let read =
        read_with(b"# \xa9 1999\nAttribute \"identifier\" \"name\" \"\xff\"\n", ReadOptions::default());
    read.says(Severity::Warning, 2, 31, "not UTF-8");
}

#[test]
fn strings_know_escapes() {
    let frame = world(&format!("Attribute \"identifier\" \"name\" \"a\\\"b\\\\\\101\\n\\\nc\" {PATCH}"));
    assert_eq!(frame.scene.primitives[0].attributes.name, "a\"b\\A\nc");
}

#[test]
fn an_array_that_is_too_large_is_an_error_and_the_rest_is_read() {
    let mut text = String::from("WorldBegin\nPatch \"bilinear\" \"P\" [");
    text += &"0.5 ".repeat(200_000);
    text += &format!("]\n{PATCH} WorldEnd");
    let options = ReadOptions { memory: 200_000, ..ReadOptions::default() };
    let read = read_with(text.as_bytes(), options);
    assert_eq!(read.said().len(), 1, "{:?}", read.said());
    assert!(read.diagnostics[0].message.contains("200000 bytes granted"), "{:?}", read.said());
    assert_eq!(read.frames[0].scene.primitives.len(), 1);
}

#[test]
fn the_memory_of_a_frame_is_free_for_the_next() {
    let patches = format!("{PATCH}\n").repeat(100);
    let text = format!("WorldBegin\n{patches}WorldEnd\n").repeat(10);
    let options = ReadOptions { memory: 100_000, ..ReadOptions::default() };
    let read = read_with(text.as_bytes(), options);
    assert_eq!(read.said(), []);
    assert_eq!(read.frames.len(), 10);
}

#[test]
fn of_very_many_messages_the_first_are_kept() {
    let read = read(&"Nonsense 1\n".repeat(5000));
    assert_eq!(read.diagnostics.len(), 1001);
    assert!(read.diagnostics[1000].message.contains("4000 further messages"));
}

#[test]
fn long_tokens_are_cut_not_kept() {
    let word = "x".repeat(1 << 20);
    assert_eq!(read(&word).diagnostics.len(), 1);
    let number = "1".repeat(1 << 20);
    assert!(!read(&format!("ShadingRate {number}")).diagnostics.is_empty());
    let comment = format!("#{}\nWorldBegin WorldEnd", "é".repeat(1 << 20));
    assert_eq!(read(&comment).frames.len(), 1);
    let blank = format!("WorldBegin{}WorldEnd", " \n".repeat(1 << 20));
    assert_eq!(read(&blank).frames.len(), 1);
}

#[test]
fn deep_blocks_and_conditions_are_refused() {
    let blocks = "AttributeBegin ".repeat(20_000);
    assert!(read(&blocks).diagnostics[0].message.contains("1000 blocks"));
    let conditions = "IfBegin \"1\" ".repeat(2000);
    assert!(read(&conditions).diagnostics[0].message.contains("1000 conditions"));
}

/// A stream that gives one byte at a time.
struct Drip(Cursor<Vec<u8>>);

impl std::io::Read for Drip {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        let len = out.len().min(1);
        self.0.read(&mut out[..len])
    }
}

#[test]
fn a_slow_stream_reads_like_a_fast_one() {
    let text = format!("WorldBegin # world\n{}\nSphre WorldEnd", format!("{PATCH}\n").repeat(2000));
    let mut reader = RibReader::from_stream(
        "test.rib",
        Box::new(Drip(Cursor::new(text.clone().into_bytes()))),
        ReadOptions::default(),
    );
    let (slow, fast) = (read_all(&mut reader), read(&text));
    assert_eq!(slow.frames[0].scene.primitives.len(), 2000);
    assert_eq!(slow.diagnostics, fast.diagnostics);
    let last = |r: &Read| r.frames[0].scene.primitives[1999].origin.to_string();
    assert_eq!((last(&slow), last(&fast)), ("test.rib:2001".to_owned(), "test.rib:2001".to_owned()));
}

#[test]
fn lists_that_every_frame_or_primitive_carries_are_bounded() {
    let spaces: String = (0..5000).map(|n| format!("CoordinateSystem \"c{n}\" ")).collect();
    assert!(read(&spaces).diagnostics[0].message.contains("4096 named spaces"));
    let displays = "Display \"+a\" \"file\" \"rgb\" ".repeat(300);
    let read1 = read(&format!("{displays} WorldBegin WorldEnd"));
    assert_eq!(read1.frames[0].displays.len(), 256);
    let times: String = (0..200).map(|n| format!("{n} ")).collect();
    assert!(read(&format!("MotionBegin [{times}]")).diagnostics[0].message.contains("1 to 128 times"));
    // Each patch has its own list of lights: together they are charged.
    let lights = format!("LightSource \"ambientlight\" 1 {PATCH}\n").repeat(1000);
    let options = ReadOptions { memory: 2 << 20, ..ReadOptions::default() };
    let read2 = read_with(format!("WorldBegin {lights} WorldEnd").as_bytes(), options);
    assert!(read2.diagnostics[0].message.contains("are used up"), "{:?}", read2.said());
}
