//! Random input: the reader ends, and does not panic.

use proptest::prelude::*;

use super::super::statements::TABLE;
use super::*;

/// A file with a bit of everything.
const SEED: &str = r#"##RenderMan RIB
Declare "pass" "uniform string" Option "user" "pass" "a" Format 64 48 1
Hider "hidden" "float[4] aperture" [5 18 0 0] "rasterizer" "simple" "permutations" 4 DepthOfField 2.8 1 5 Shutter 0 1
Projection "perspective" "fov" [40] Translate 0 0 5 Display "a.png" "file" "rgba"
FrameBegin 1 WorldBegin LightSource "ambientlight" 1 "intensity" 0.5
ObjectBegin 1 Patch "bilinear" "P" [0 0 0 1 0 0 0 1 0 1 1 0] ObjectEnd
AttributeBegin Scale 1 2 -3e-1 ObjectInstance 1 Color [1 .5 0] AttributeEnd
MotionBegin [0 1] Rotate 0 0 0 1 Rotate 720 0 0 1 MotionEnd GeometricApproximation "motionfactor" 1
MotionBegin [0 .5] Patch "bilinear" "P" [0 0 0 1 0 0 0 1 0 1 1 0] Patch "bilinear" "P" [0 0 0 1 0 0 0 1 0 1 1 1] MotionEnd
IfBegin "$user:pass == 'a'" Sphere 1 -1 1 360 Else Surface "matte" IfEnd
ArchiveBegin "b" PatchMesh "bilinear" 2 "nonperiodic" 2 "periodic" "Pz" [1 2 3 4] ArchiveEnd ReadArchive "b"
SubdivisionMesh "catmull-clark" [4] [0 1 2 3] ["hole"] [1 0] [0] [] "P" [0 0 0 1 0 0 1 1 0 0 1 0]
WorldEnd FrameEnd
"#;

fn survives(bytes: &[u8]) -> Read {
    let read = read_with(bytes, ReadOptions { memory: 1 << 20, archive_depth: 8, ..ReadOptions::default() });
    for diagnostic in &read.diagnostics {
        assert!(diagnostic.source_line.as_ref().is_none_or(|l| l.len() <= 600));
    }
    for frame in &read.frames {
        frame.settings.validate().expect("settings that can be rendered");
        frame.scene.validate().expect("a scene that can be rendered");
    }
    read
}

fn token() -> impl Strategy<Value = String> {
    let names: Vec<&str> = TABLE.iter().map(|s| s.name).collect();
    let strings = [
        "P",
        "Pw",
        "Pz",
        "Cs",
        "bilinear",
        "bicubic",
        "b-spline",
        "float[3] x",
        "matte",
        "1",
        "a",
        "periodic",
        "hidden",
        "float[4] aperture",
        "float[2] shutteropening",
        "rasterizer",
        "tile",
        "permutations",
        "interleave",
        "motionfactor",
        "perspective",
    ];
    // Motion blocks are rare among all names.
    let motion =
        ["MotionBegin [0 1]", "MotionBegin [0 0.5 1]", "Rotate 0 0 0 1", "Rotate 1e6 0 0 1", "MotionEnd"];
    prop_oneof![
        2 => prop::sample::select(motion.to_vec()).prop_map(str::to_owned),
        6 => prop::sample::select(names).prop_map(str::to_owned),
        4 => (-3i32..300).prop_map(|n| n.to_string()),
        2 => any::<f32>().prop_map(|n| n.to_string()),
        3 => prop::sample::select(strings.to_vec()).prop_map(|s| format!("\"{s}\"")),
        2 => prop::collection::vec(-2i8..9, 0..20).prop_map(|v| format!("{v:?}").replace(',', " ")),
        1 => Just("[".to_owned()),
        1 => Just("]".to_owned()),
        1 => Just("# x\n".to_owned()),
        1 => Just("\"".to_owned()),
    ]
}

#[test]
fn the_seed_itself_is_correct() {
    let read = survives(SEED.as_bytes());
    assert!(read.diagnostics.iter().all(|d| d.severity == Severity::Note), "{:?}", read.said());
    assert_eq!(read.frames[0].scene.primitives.len(), 4);
}

#[test]
fn every_beginning_of_a_file_ends() {
    for len in 0..SEED.len() {
        survives(&SEED.as_bytes()[..len]);
    }
}

proptest! {
    #[test]
    fn random_bytes_end(bytes in prop::collection::vec(any::<u8>(), 0..2000)) {
        survives(&bytes);
    }

    #[test]
    fn random_ascii_ends(text in "[ -~\n]{0,2000}") {
        survives(text.as_bytes());
    }

    #[test]
    fn random_tokens_end(tokens in prop::collection::vec(token(), 0..200)) {
        survives(tokens.join(" ").as_bytes());
        survives(format!("WorldBegin {} WorldEnd", tokens.join(" ")).as_bytes());
    }

    #[test]
    fn changed_files_end(changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0u8..3), 1..12)) {
        let mut bytes = SEED.as_bytes().to_vec();
        for (at, byte, kind) in changes {
            let at = at.index(bytes.len());
            match kind {
                0 => bytes[at] = byte,
                1 => bytes.insert(at, byte),
                _ => { bytes.remove(at); }
            }
            if bytes.is_empty() {
                bytes.push(b' ');
            }
        }
        survives(&bytes);
    }
}
