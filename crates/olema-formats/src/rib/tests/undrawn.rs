//! Primitives and statements that are not drawn yet.

use super::*;

/// A correct example of every primitive that is noted.
const EXAMPLES: [&str; 17] = [
    "Sphere 1 -1 1 360 \"Cs\" [1 0 0 0 1 0 0 0 1 1 1 1]",
    "Cone 1 1 360",
    "Cylinder [1 -1 1 360]",
    "Hyperboloid 1 0 0 1 0 1 360",
    "Paraboloid 1 0 1 360",
    "Disk 0 1 360",
    "Torus 1 0.2 0 360 360",
    "Polygon \"P\" [0 0 0 1 0 0 0 1 0]",
    "GeneralPolygon [3 3] \"P\" [0 0 0 1 0 0 0 1 0 0 0 0 1 0 0 0 1 0]",
    "PointsPolygons [3 3] [0 1 2 0 2 3] \"P\" [0 0 0 1 0 0 0 1 0 1 1 0] \"facevarying float s\" [1 2 3 4 5 6]",
    "PointsGeneralPolygons [2] [3 3] [0 1 2 0 1 3] \"P\" [0 0 0 1 0 0 0 1 0 1 1 0]",
    "Points \"P\" [0 0 0 1 1 1] \"constantwidth\" 0.1",
    "Curves \"cubic\" [4] \"nonperiodic\" \"P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"width\" [1 2]",
    "Curves \"linear\" [3 2] \"periodic\" \"P\" [0 0 0 1 0 0 2 0 0 3 0 0 4 0 0] \"width\" [1 2 3 4 5]",
    "NuPatch 3 3 [0 0 0 1 1 1] 0 1 2 2 [0 0 1 1] 0 1 \"Pw\" [0 0 0 1 1 0 0 1 2 0 0 1 0 1 0 1 1 1 0 1 2 1 0 1]",
    "Blobby 2 [1001 0 1001 16 0 2 0 1] [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1] [\"\"] \"vertex color Cs\" [1 0 0 0 1 0]",
    "Geometry \"teapot\"",
];

#[test]
fn every_primitive_is_read_and_noted_once() {
    for text in EXAMPLES {
        let name = text.split(' ').next().expect("a name");
        let read = read(&format!("WorldBegin\n{text}\n{text} WorldEnd"));
        read.says(Severity::Note, 2, 1, &format!("{name} is not drawn yet (2 times"));
        assert_eq!(read.frames.len(), 1);
    }
}

#[test]
fn their_counts_are_checked() {
    for (text, part) in [
        ("Sphere 1 -1 1", "expected 4 numbers"),
        ("Sphere [1 -1 1 360 5]", "found more"),
        ("Polygon \"P\" [0 0 0 1 0 0]", "expected at least 3 points"),
        ("Polygon \"P\" [0 0 0 1 0 0 1]", "with 7 numbers"),
        ("PointsPolygons [3] [0 1] \"P\" [0 0 0]", "has 2 values: expected 3"),
        ("PointsPolygons [3] [0 1 -2] \"P\" [0 0 0]", "indices of at least 0"),
        ("PointsPolygons [3] [0 1 5] \"P\" [0 0 0]", "has 3 numbers: expected 18"),
        ("PointsPolygons [-1] [] \"P\" []", "at least 1"),
        ("Curves \"cubic\" [3] \"nonperiodic\" \"P\" []", "at least 4"),
        ("Curves \"quintic\" [3] \"nonperiodic\" \"P\" []", "expected \"linear\" or \"cubic\""),
        ("NuPatch 3 3 [0 0 0 1 1] 0 1 2 2 [0 0 1 1] 0 1 \"P\" [0]", "has 5 values: expected 6"),
        ("NuPatch 3 3 [0 0 1 0 1 1] 0 1 2 2 [0 0 1 1] 0 1 \"P\" [0]", "do not descend"),
        ("TrimCurve [1] [2] [0 0 1 1] [0] [1] [2] [0 1] [0 1] [1]", "has 1 values: expected 2"),
        ("Blobby -1 [0] [] []", "count of leaves"),
    ] {
        let read = read(&format!("WorldBegin {text} WorldEnd"));
        assert!(read.diagnostics[0].message.contains(part), "{text}: {:?}", read.said());
        assert_eq!(read.diagnostics[0].severity, Severity::Error);
    }
}

#[test]
fn statements_without_effect_are_warned_about() {
    for text in [
        "MakeTexture \"a\" \"b\" \"black\" \"clamp\" \"box\" 1 1",
        "MakeBump \"a\" \"b\" \"black\" \"clamp\" \"box\" 1 1",
        "MakeLatLongEnvironment \"a\" \"b\" \"box\" 1 1",
        "MakeCubeFaceEnvironment \"a\" \"b\" \"c\" \"d\" \"e\" \"f\" \"g\" 90 \"box\" 1 1",
        "MakeShadow \"a\" \"b\"",
        "ClippingPlane 0 0 0 0 0 1",
        "ColorSamples [1 1 1] [1 1 1]",
    ] {
        let name = text.split(' ').next().expect("a name");
        read(text).says(Severity::Warning, 1, 1, &format!("{name} has no effect"));
    }
}

#[test]
fn other_shaders_and_solids_are_noted() {
    let read = read(&format!(
        "WorldBegin Atmosphere \"fog\" Interior \"x\" Exterior \"y\"
        Deformation \"bend\" AreaLightSource \"pointlight\" 1
        SolidBegin \"difference\" SolidBegin \"primitive\" {PATCH} SolidEnd SolidEnd WorldEnd"
    ));
    assert!(read.diagnostics.iter().all(|d| d.severity == Severity::Note), "{:?}", read.said());
    assert_eq!(read.diagnostics.len(), 6, "{:?}", read.said());
    assert_eq!(read.frames[0].scene.lights.len(), 1);
}
