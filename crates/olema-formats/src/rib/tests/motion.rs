//! Motion blocks: keys, turns, and blocks with something wrong.

use olema::scene::{Geometry, Keyed, Points, Transform};

use super::*;

/// The same patch one further in z.
const PATCH_1: &str = "Patch \"bilinear\" \"P\" [0 0 1 1 0 1 0 1 1 1 1 1]";

/// A world whose first line is the motion block's.
fn read_world(text: &str) -> Read {
    let read = read(&format!("WorldBegin {text} WorldEnd"));
    assert!(read.error.is_none(), "{text}: {:?}", read.error);
    assert_eq!(read.frames.len(), 1, "{text}");
    read
}

fn points(read: &Read, ix: usize) -> &Keyed<Points> {
    let Geometry::Patches(mesh) = &read.frames[0].scene.primitives[ix].geometry else { panic!("a patch") };
    &mesh.points
}

fn num_primitives(read: &Read) -> usize {
    read.frames[0].scene.primitives.len()
}

/// The angle in degrees, from -180 to 180, by which x is turned about z.
fn angle(transform: &Transform, time: f64) -> f64 {
    let x = transform.at(time).transform_vector3(DVec3::X);
    x.y.atan2(x.x).to_degrees()
}

#[test]
fn motion_blocks_give_transforms_and_patches_keys() {
    let frame = frame(&format!(
        "Shutter 0 1 MotionBegin [0 1] Translate 0 0 5 Translate 1 0 5 MotionEnd
        WorldBegin MotionBegin [0 0.5 1] Rotate 0 0 0 1 Rotate 10 0 0 1 Rotate 20 0 0 1 MotionEnd
        MotionBegin [0 1] {PATCH} {PATCH_1} MotionEnd WorldEnd"
    ));
    let scene = &frame.scene;
    assert_eq!(scene.camera.world_to_camera.times(), [0.0, 1.0]);
    assert_eq!(scene.camera.world_to_camera.at(1.0).w_axis.x, 1.0);
    assert_eq!(scene.primitives[0].to_world.times(), [0.0, 0.5, 1.0]);
    let Geometry::Patches(mesh) = &scene.primitives[0].geometry else { panic!("a patch") };
    assert_eq!(mesh.points.times, [0.0, 1.0]);
    assert!(matches!(&mesh.points.values[1], Points::P(p) if p[0] == [0.0, 0.0, 1.0]));
}

#[test]
fn a_rotation_of_two_turns_turns_twice() {
    let frame = world(&format!(
        "MotionBegin [1 3] Rotate 30 0 0 2 Rotate 750 0 0 1 MotionEnd Translate 1 0 0 {PATCH}"
    ));
    let to_world = &frame.scene.primitives[0].to_world;
    assert_eq!(to_world.times().len(), 9);
    for step in 0..=200 {
        let time = 1.0 + f64::from(step) * 0.01;
        let expected = 30.0 + 720.0 * (time - 1.0) / 2.0;
        let error = (angle(to_world, time) - expected).rem_euclid(360.0);
        assert!(error.min(360.0 - error) < 1e-9, "{time}: {}", angle(to_world, time));
    }
    assert_eq!([0.0, 4.0].map(|time| angle(to_world, time).round()), [30.0, 30.0]);
}

#[test]
fn turns_keep_their_pace_where_times_are_rounded() {
    // A thousandth of a second far from 0, in which single precision tells 16 times apart.
    let frame =
        world(&format!("MotionBegin [1000 1000.001] Rotate 0 0 0 1 Rotate -900 0 0 1 MotionEnd {PATCH}"));
    let to_world = &frame.scene.primitives[0].to_world;
    let factor = &to_world.factors()[1];
    let [from, to] = [factor.times[0], factor.times[factor.times.len() - 1]].map(f64::from);
    for time in &factor.times {
        let part = (f64::from(*time) - from) / (to - from);
        let error = (angle(to_world, f64::from(*time)) + 900.0 * part).rem_euclid(360.0);
        assert!(error.min(360.0 - error) < 1e-9, "{time}");
    }
}

#[test]
fn rotations_about_other_axes_and_matrices_keep_the_keys_of_the_file() {
    for text in [
        "Rotate 0 0 0 1 Rotate 170 0 1 0",
        "Rotate 0 0 0 1 Rotate 170 0 0 -1",
        "Rotate 0 0 0 1 Rotate 90 0 0 1",
        "Skew 0 0 1 0 1 0 0 Skew 80 0 1 0 1 0 0",
        "Identity Identity",
        "CoordSysTransform \"world\" CoordSysTransform \"camera\"",
        "ConcatTransform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1] ConcatTransform [-1 0 0 0 0 -1 0 0 0 0 1 0 0 0 0 1]",
    ] {
        let frame = world(&format!("MotionBegin [0 1] {text} MotionEnd {PATCH}"));
        assert_eq!(frame.scene.primitives[0].to_world.times(), [0.0, 1.0], "{text}");
    }
}

#[test]
fn turns_beyond_the_limit_are_warned_about_and_end_where_they_should() {
    let text = |angle: &str, times: &str| {
        read_world(&format!("MotionBegin [{times}] Rotate 0 0 0 1\nRotate {angle} 0 0 1\nMotionEnd {PATCH}"))
    };
    let most = text("368550", "0 1");
    assert_eq!(most.said(), []);
    assert_eq!(most.frames[0].scene.primitives[0].to_world.times().len(), 4096);
    for (angle, times, part) in [
        ("368551", "0 1", "about 1024 turns in a motion block: expected at most 1024"),
        ("3e38", "0 1", "turns in a motion block: expected at most 1024; between its keys"),
        ("900", "1 1.0000001", "times 1 and 1.0000001 are too close together for the turns"),
    ] {
        let read = text(angle, times);
        read.says(Severity::Warning, 3, 1, part);
        assert_eq!(read.frames[0].scene.primitives[0].to_world.times().len(), 2);
    }
    let read = text("inf", "0 1");
    assert!(read.diagnostics[0].message.contains("not a finite number"), "{:?}", read.said());
}

#[test]
fn what_moves_around_an_object_is_bounded() {
    let block = "MotionBegin [0 1] Rotate 0 0 0 1 Rotate 1 0 0 1 MotionEnd Translate 1 0 0\n";
    let many = read_world(&format!("{}{PATCH}", block.repeat(300)));
    assert!(many.diagnostics[0].message.contains("expected at most 256 with 8192"), "{:?}", many.said());
    assert_eq!((many.diagnostics.len(), many.diagnostics[0].line), (44, 257));
    assert_eq!(many.frames[0].scene.primitives[0].to_world.factors().len(), 513);
    let turns = "MotionBegin [0 1] Rotate 0 0 0 1 Rotate 360000 0 0 1 MotionEnd\n";
    let turning = read_world(&format!("{}{PATCH}", turns.repeat(4)));
    assert_eq!(turning.diagnostics.len(), 2, "{:?}", turning.said());
}

#[test]
fn copies_of_what_moves_take_no_room_of_their_own() {
    let turns = "MotionBegin [0 1] Rotate 0 0 0 1 Rotate 360000 0 0 1 MotionEnd";
    let parts = format!("AttributeBegin Translate 1 0 0 {PATCH} AttributeEnd\n").repeat(1000);
    let options = ReadOptions { memory: 4 << 20, ..ReadOptions::default() };
    let shared = read_with(format!("WorldBegin {turns} {parts} WorldEnd").as_bytes(), options.clone());
    assert_eq!((shared.said(), num_primitives(&shared)), (vec![], 1000));
    let own = format!("AttributeBegin {turns} {PATCH} AttributeEnd\n").repeat(100);
    let own = read_with(format!("WorldBegin {own} WorldEnd").as_bytes(), options);
    assert!(own.diagnostics[0].message.contains("are used up"), "{:?}", own.said());
}

#[test]
fn times_that_make_no_sense_leave_the_first_statement() {
    let many = (0..129).map(|n| format!("{n} ")).collect::<String>();
    for (times, part) in [
        ("1 0", "time 0 comes after 1: expected times in ascending order; the block's first"),
        ("0.5 0.5", "time 0.5 comes after 0.5: expected times in ascending"),
        ("0 1 1", "time 1 comes after 1: expected"),
        ("", "0 times: expected 1 to 128 times; the block's first"),
        (&many, "129 times: expected 1 to 128 times"),
        ("0 inf", "not a finite number"),
        ("nan 1", "not a finite number"),
        ("0 1e39", "not a finite number"),
        ("0 \"1\"", "expected numbers or \"]\""),
    ] {
        let moved =
            read_world(&format!("\nMotionBegin [{times}] Translate 1 0 0 Translate 2 0 0 MotionEnd {PATCH}"));
        assert_eq!(moved.diagnostics.len(), 1, "{times}: {:?}", moved.said());
        assert_eq!((moved.diagnostics[0].severity, moved.diagnostics[0].line), (Severity::Error, 2));
        assert!(moved.diagnostics[0].message.contains(part), "{times}: {:?}", moved.said());
        assert_eq!(to_world(&moved.frames[0], 0), DMat4::from_translation(DVec3::X), "{times}");
        let drawn = read_world(&format!("\nMotionBegin [{times}] {PATCH} {PATCH_1} MotionEnd {PATCH}"));
        assert_eq!((drawn.diagnostics.len(), num_primitives(&drawn)), (1, 2), "{times}: {:?}", drawn.said());
        assert!(
            matches!(points(&drawn, 0), Keyed { times, values } if times.is_empty() && values.len() == 1)
        );
    }
    // In an object, too.
    let read = read_world(&format!(
        "ObjectBegin 1 MotionBegin [0 nan] Translate 1 0 0 Translate 2 0 0 MotionEnd {PATCH} ObjectEnd ObjectInstance 1"
    ));
    read.says(Severity::Error, 1, 41, "not a finite number");
    assert_eq!(to_world(&read.frames[0], 0), DMat4::from_translation(DVec3::X));
}

#[test]
fn times_outside_the_shutter_are_fine() {
    let frame = world(&format!("MotionBegin [-5 7.5] {PATCH} {PATCH_1} MotionEnd"));
    assert_eq!(frame.scene.camera.shutter, [0.0, 0.0]);
    let Geometry::Patches(mesh) = &frame.scene.primitives[0].geometry else { panic!("a patch") };
    assert_eq!(mesh.points.times, [-5.0, 7.5]);
}

#[test]
fn too_few_too_many_and_other_statements_are_told_and_drawn_still() {
    for (statements, severity, part) in [
        (
            PATCH.to_owned(),
            Severity::Error,
            "expected 2 statements, one a time, found 1; the first alone counts",
        ),
        (
            format!("{PATCH}\n{PATCH_1}\n{PATCH}\n{PATCH}"),
            Severity::Warning,
            "expected 2 statements, one a time, found more; ignored",
        ),
        (
            format!("{PATCH} Sphere 1 -1 1 360 Color 1 1 1"),
            Severity::Warning,
            "Sphere in a motion block of Patch: expected the same",
        ),
        (
            format!("{PATCH} Patch \"bicubic\" \"P\" [{}]", "0 ".repeat(48)),
            Severity::Warning,
            "expected the same shape; the first is drawn still",
        ),
        (
            format!("{PATCH} Patch \"bilinear\" \"Pw\" [{}]", "1 ".repeat(16)),
            Severity::Warning,
            "expected the same shape",
        ),
        (
            format!(
                "{PATCH} PatchMesh \"bilinear\" 2 \"nonperiodic\" 3 \"nonperiodic\" \"P\" [{}]",
                "1 ".repeat(18)
            ),
            Severity::Warning,
            "PatchMesh in a motion block of Patch",
        ),
    ] {
        let read = read_world(&format!("MotionBegin [0 1] {statements} MotionEnd"));
        assert_eq!(read.diagnostics.len(), 1, "{statements}: {:?}", read.said());
        assert_eq!(read.diagnostics[0].severity, severity);
        assert!(read.diagnostics[0].message.contains(part), "{statements}: {:?}", read.said());
        let moves = part.contains("found more");
        assert_eq!((num_primitives(&read), points(&read, 0).values.len()), (1, if moves { 2 } else { 1 }));
    }
    let mesh = |indices: &str, points: &str| {
        format!("SubdivisionMesh \"bilinear\" [3] [{indices}] \"P\" [{points}]")
    };
    for other in [mesh("0 2 1", "0 0 0 1 0 0 0 1 0"), mesh("0 1 2", "0 0 0 1 0 0 0 1 0 1 1 1")] {
        let first = mesh("0 1 2", "0 0 0 1 0 0 0 1 0");
        let read = read_world(&format!("MotionBegin [0 1]\n{first}\n{other} MotionEnd"));
        read.says(Severity::Warning, 3, 1, "expected the same shape");
        let Geometry::Subdivision(mesh) = &read.frames[0].scene.primitives[0].geometry else {
            panic!("a mesh")
        };
        assert_eq!(mesh.points.values.len(), 1);
    }
}

#[test]
fn an_empty_block_is_told() {
    read_world("MotionBegin [0 1]\nMotionEnd").says(
        Severity::Error,
        2,
        1,
        "expected 2 statements, one a time, found 0",
    );
}

#[test]
fn a_key_that_is_not_finite_is_told_and_the_others_are_drawn_still() {
    for bad in ["inf", "-inf", "nan", "1e39"] {
        let read = read_world(&format!(
            "MotionBegin [0 1]\n{PATCH}\nPatch \"bilinear\" \"P\" [0 0 {bad} 1 0 0 0 1 0 1 1 0]\nMotionEnd {PATCH}"
        ));
        let lines: Vec<_> =
            read.said().iter().map(|said| (said.1, said.3.contains("not a finite"))).collect();
        assert_eq!(lines, [(3, true), (4, false)], "{:?}", read.said());
        assert_eq!((num_primitives(&read), points(&read, 0).values.len()), (2, 1));
    }
    let read = read_world(&format!("MotionBegin [0 1] Translate 1 0 0\nTranslate nan 0 0 MotionEnd {PATCH}"));
    assert_eq!(to_world(&read.frames[0], 0), DMat4::from_translation(DVec3::X));
    // The largest numbers that there are, moving as fast as they can.
    let fast = "Patch \"bilinear\" \"P\" [-3e38 0 0 1 0 0 0 1 0 1 1 0] Patch \"bilinear\" \"P\" [3e38 0 0 1 0 0 0 1 0 1 1 0]";
    assert_eq!(read_world(&format!("MotionBegin [0 1e-30] {fast} MotionEnd")).said(), []);
}

#[test]
fn blocks_in_a_block_are_passed_over_as_a_whole() {
    let nested = read_world(&format!(
        "MotionBegin [0 1]\nMotionBegin [0 1] Scale 2 2 2 Scale 3 3 3 MotionEnd\nTranslate 1 0 0 Translate 2 0 0 MotionEnd {PATCH}"
    ));
    nested.says(
        Severity::Error,
        2,
        1,
        "MotionBegin in a motion block: expected MotionEnd; ignored up to its end",
    );
    assert_eq!(nested.frames[0].scene.primitives[0].to_world.at(0.5).w_axis.x, 1.5);
    let attribute = read_world(&format!(
        "MotionBegin [0 1] {PATCH}\nAttributeBegin TransformBegin {PATCH} TransformEnd {PATCH} AttributeEnd\n{PATCH_1} MotionEnd"
    ));
    attribute.says(Severity::Error, 2, 1, "AttributeBegin in a motion block");
    assert_eq!((num_primitives(&attribute), points(&attribute, 0).values.len()), (1, 2));
    let unclosed = read_world(&format!("MotionBegin [0 1] {PATCH}\nSolidBegin \"union\" {PATCH}"));
    let said: Vec<_> = unclosed.said().iter().map(|said| (said.1, said.3.to_owned())).collect();
    assert_eq!(said.len(), 2, "{said:?}");
    assert!(said[1].1.contains("MotionBegin of line 1 is still open"), "{said:?}");
}

#[test]
fn ends_without_their_beginning_are_told() {
    let none = read_world(&format!("\nMotionEnd {PATCH}"));
    none.says(Severity::Error, 2, 1, "MotionEnd without MotionBegin");
    assert_eq!(num_primitives(&none), 1);
    // What a block has gathered is drawn, even where its end is missing.
    for (text, open) in [
        (format!("AttributeBegin MotionBegin [0 1] {PATCH} {PATCH_1}\nAttributeEnd"), "before AttributeEnd"),
        (format!("MotionBegin [0 1] {PATCH} {PATCH_1}\n"), "before WorldEnd"),
        (
            format!("ObjectBegin 1\nMotionBegin [0 1] {PATCH} {PATCH_1} ObjectEnd ObjectInstance 1"),
            "still open where its object ends",
        ),
    ] {
        let read = read_world(&text);
        assert_eq!((read.diagnostics.len(), read.diagnostics[0].line), (1, 2), "{:?}", read.said());
        assert!(read.diagnostics[0].message.contains(open), "{:?}", read.said());
        assert_eq!((num_primitives(&read), points(&read, 0).values.len()), (1, 2), "{text}");
    }
    let stray = read_world(&format!("MotionBegin [0 1] {PATCH}\nAttributeEnd {PATCH_1} MotionEnd"));
    stray.says(Severity::Error, 2, 1, "AttributeEnd without AttributeBegin: MotionBegin of line 1 is open");
    assert_eq!((num_primitives(&stray), points(&stray, 0).values.len()), (1, 2));
}

#[test]
fn statements_that_read_others_cannot_move() {
    for text in [
        "ObjectInstance 1 ObjectInstance 1",
        "ReadArchive \"a\"",
        "Procedural \"DelayedReadArchive\" [\"a\"] [0 1 0 1 0 1]",
    ] {
        let read = read_world(&format!(
            "ObjectBegin 1 {PATCH} ObjectEnd ArchiveBegin \"a\" {PATCH} ArchiveEnd\nMotionBegin [0 1] {text} MotionEnd"
        ));
        let first = &read.diagnostics[0];
        assert!(
            first.message.contains("in a motion block: expected MotionEnd; ignored"),
            "{:?}",
            read.said()
        );
        assert_eq!((first.line, num_primitives(&read)), (2, 0));
    }
}

#[test]
fn attributes_do_not_move_and_that_is_noted_once() {
    let read = read_world(&format!(
        "MotionBegin [0 1] Color 1 0 0 Color 0 1 0 MotionEnd
        MotionBegin [0 1] Surface \"matte\" Surface \"plastic\" MotionEnd {PATCH}"
    ));
    read.says(Severity::Note, 1, 30, "only transforms and points move");
    assert!(read.diagnostics[0].message.contains("(2 times, here first)"));
    let look = &read.frames[0].scene.primitives[0].attributes;
    assert_eq!((look.color, look.surface.name()), ([1.0, 0.0, 0.0], "matte"));
}

#[test]
fn variables_that_differ_from_key_to_key_are_noted_once() {
    let block =
        |first: &str, next: &str| format!("MotionBegin [0 1] {PATCH} {first} {PATCH_1} {next} MotionEnd\n");
    let colours = ["\"Cs\" [1 0 0 0 1 0 0 0 1 1 1 1]", "\"Cs\" [1 1 0 0 1 0 0 0 1 1 1 1]"];
    assert_eq!(read_world(&block(colours[0], colours[0])).said(), []);
    for next in [colours[1], ""] {
        let read = read_world(&block(colours[0], next).repeat(3));
        read.says(Severity::Note, 1, 108, "only points move from key to key");
        assert!(read.diagnostics[0].message.contains("(3 times, here first)"));
        assert_eq!(points(&read, 2).values.len(), 2);
    }
    let mesh =
        |tags: &str| format!("SubdivisionMesh \"bilinear\" [3] [0 1 2] {tags} \"P\" [0 0 0 1 0 0 0 1 0]");
    let crease = "[\"crease\"] [2 1] [0 1] [2]";
    let read = read_world(&format!("MotionBegin [0 1] {}\n{} MotionEnd", mesh(crease), mesh("")));
    read.says(Severity::Note, 2, 1, "primitive variables and tags are those of the first");
}
