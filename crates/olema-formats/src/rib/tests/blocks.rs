//! Blocks, transforms, conditions.

use super::*;

#[test]
fn transforms_act_on_the_object_in_the_order_from_last_to_first() {
    let frame = world(&format!("Translate 1 0 0 Rotate 90 0 0 1 Scale 2 1 1 {PATCH}"));
    let p = to_world(&frame, 0).transform_point3(DVec3::new(1.0, 0.0, 0.0));
    assert!(near(p, DVec3::new(1.0, 2.0, 0.0)));
}

#[test]
fn transform_and_identity_in_a_world_lead_to_world() {
    let frame = frame(&format!(
        "Translate 0 0 9 WorldBegin Translate 1 0 0 Transform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 4 1] {PATCH} Identity {PATCH} WorldEnd"
    ));
    assert_eq!(to_world(&frame, 0), DMat4::from_translation(DVec3::new(0.0, 0.0, 4.0)));
    assert_eq!(to_world(&frame, 1), DMat4::IDENTITY);
    let camera = frame.scene.camera.world_to_camera.first();
    assert_eq!(camera, DMat4::from_translation(DVec3::new(0.0, 0.0, 9.0)));
}

#[test]
fn blocks_restore_what_they_save() {
    let frame = world(&format!(
        "Color 1 0 0
        AttributeBegin Color 0 1 0 Translate 1 0 0 {PATCH} AttributeEnd
        TransformBegin Color 0 0 1 Translate 2 0 0 {PATCH} TransformEnd
        {PATCH}"
    ));
    let of = |ix: usize| (frame.scene.primitives[ix].attributes.color, to_world(&frame, ix).w_axis.x);
    assert_eq!([of(0), of(1), of(2)], [([0., 1., 0.], 1.0), ([0., 0., 1.], 2.0), ([0., 0., 1.], 0.0)]);
}

#[test]
fn frames_are_numbered_and_do_not_leak() {
    let read = read(
        "Format 10 10 1 FrameBegin 1 Format 20 20 1 Translate 1 1 1 LightSource \"ambientlight\" 1
        WorldBegin WorldEnd FrameEnd FrameBegin 2 WorldBegin WorldEnd FrameEnd",
    );
    assert_eq!(read.said(), []);
    let of = |ix: usize| {
        (read.frames[ix].number, read.frames[ix].settings.resolution[0], read.frames[ix].scene.lights.len())
    };
    assert_eq!([of(0), of(1)], [(Some(1), 20, 1), (Some(2), 10, 0)]);
    assert_eq!(read.frames[1].scene.camera.world_to_camera.first(), DMat4::IDENTITY);
}

#[test]
fn blocks_that_do_not_match_are_told_and_mended() {
    let read1 = read(&format!("WorldBegin\nTransformEnd\n{PATCH} WorldEnd"));
    read1.says(Severity::Error, 2, 1, "TransformEnd without TransformBegin: WorldBegin of line 1 is open");
    assert_eq!(read1.frames[0].scene.primitives.len(), 1);
    let read2 = read("WorldBegin\nAttributeBegin\nTransformBegin\nAttributeEnd WorldEnd");
    read2.says(Severity::Error, 4, 1, "TransformBegin of line 3 is still open: expected TransformEnd");
    let read3 = read("WorldBegin\nAttributeBegin\nWorldEnd");
    read3.says(Severity::Error, 3, 1, "AttributeBegin of line 2 is still open");
    assert_eq!(read3.frames.len(), 1);
    read("WorldEnd").says(Severity::Error, 1, 1, "WorldEnd without WorldBegin");
    read("FrameBegin 1").says(Severity::Error, 1, 1, "FrameBegin is still open");
    read("WorldBegin WorldBegin WorldEnd").says(Severity::Warning, 1, 12, "before WorldBegin");
    read("AttributeBegin WorldBegin AttributeEnd WorldEnd AttributeEnd").says(
        Severity::Error,
        1,
        27,
        "AttributeEnd without AttributeBegin",
    );
}

#[test]
fn singular_transforms_are_refused() {
    for text in [
        "Scale 1 0 1",
        "Transform [0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0]",
        "Scale 1e-38 1e-38 1e-38 Scale 1e-38 1e-38 1e-38 Scale 1e-38 1e-38 1e-38",
    ] {
        let read = read(&format!("WorldBegin {text} {PATCH} WorldEnd"));
        assert!(read.diagnostics[0].message.contains("singular"), "{:?}", read.diagnostics);
        assert!(to_world(&read.frames[0], 0).inverse().is_finite());
    }
    read("Rotate 10 0 0 0").says(Severity::Error, 1, 8, "an axis longer than 0");
}

#[test]
fn named_spaces_can_be_returned_to() {
    let frame = frame(&format!(
        "Translate 0 0 5 CoordinateSystem \"rig\" WorldBegin Translate 1 0 0 CoordinateSystem \"a\"
        AttributeBegin ScopedCoordinateSystem \"b\" AttributeEnd
        Translate 5 5 5 CoordSysTransform \"a\" {PATCH} CoordSysTransform \"camera\" {PATCH}
        CoordSysTransform \"world\" {PATCH} CoordSysTransform \"rig\" {PATCH} WorldEnd"
    ));
    let at = |ix: usize| to_world(&frame, ix).w_axis.truncate();
    assert_eq!(at(0), DVec3::new(1.0, 0.0, 0.0));
    assert_eq!(at(1), DVec3::new(0.0, 0.0, -5.0));
    assert_eq!((at(2), at(3)), (DVec3::ZERO, DVec3::ZERO));
    let names: Vec<&str> = frame.scene.coordinate_systems.iter().map(|c| c.0.as_str()).collect();
    assert_eq!(names, ["rig", "a"]);
    read("WorldBegin CoordSysTransform \"none\" WorldEnd").says(
        Severity::Error,
        1,
        30,
        "\"none\" is unknown",
    );
}

#[test]
fn conditions_choose_one_branch() {
    let frame = frame(&format!(
        r#"Declare "pass" "string" Option "user" "pass" "beauty" "float level" 2
        FrameBegin 3 WorldBegin
        IfBegin "$user:pass == 'shadow'" Nonsense 1 2 [ "a" ] IfBegin "1" {PATCH} Else {PATCH} IfEnd
        ElseIf "$user:level > 1 && $Frame == 3" Color 0 1 0 {PATCH}
        ElseIf "1" {PATCH}
        Else {PATCH} IfEnd
        Attribute "user" "float level" 9
        IfBegin "user:level == 9" {PATCH} IfEnd
        WorldEnd FrameEnd"#
    ));
    assert_eq!(frame.scene.primitives.len(), 2);
    read("IfBegin \"$none\"\nIfEnd").says(Severity::Warning, 1, 9, "has no value");
    read("IfEnd").says(Severity::Error, 1, 1, "IfEnd without IfBegin");
    read("IfBegin \"1\"").says(Severity::Error, 1, 1, "IfBegin is still open");
    read("IfBegin \"1\" Else ElseIf \"1\" IfEnd").says(Severity::Error, 1, 18, "after Else");
}
