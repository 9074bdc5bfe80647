//! Patches, their parameters, attributes, orientation, lights.

use std::sync::Arc;

use olema::scene::{
    Class, Geometry, PatchBasis, PatchKind, PatchMesh, Points, ShadingInterpolation, Sides, VarType,
    VarValues,
};

use super::*;

fn mesh(frame: &RibFrame, ix: usize) -> &PatchMesh {
    let Geometry::Patches(mesh) = &frame.scene.primitives[ix].geometry else { panic!("a patch") };
    mesh
}

#[test]
fn a_patch_has_its_points_and_variables() {
    let frame = world(
        r#"Declare "heat" "uniform float[2]"
        Patch "bilinear" "P" [0 0 0 1 0 0 0 1 0 1 1 0] "st" [0 0 1 0 0 1 1 1]
            "heat" [3 4] "varying color tint" [1 0 0 0 1 0 0 0 1 1 1 1] "uniform string tag" "x""#,
    );
    let mesh = mesh(&frame, 0);
    assert_eq!((*mesh.kind, mesh.nu, mesh.nv), (PatchKind::Bilinear, 2, 2));
    let p = Points::P(vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [1., 1., 0.]]);
    assert_eq!(mesh.points.first(), &p);
    let vars: Vec<_> = mesh.vars.iter().map(|v| (v.name.as_str(), v.class, v.ty, v.array_len)).collect();
    assert_eq!(
        vars,
        [
            ("st", Class::Varying, VarType::Float, 2),
            ("heat", Class::Uniform, VarType::Float, 2),
            ("tint", Class::Varying, VarType::Color, 1),
            ("tag", Class::Uniform, VarType::String, 1),
        ]
    );
    assert_eq!(mesh.vars[1].values, VarValues::Floats([3.0, 4.0].into()));
    assert_eq!(mesh.vars[3].values, VarValues::Strings(["x".to_owned()].into()));
}

#[test]
fn meshes_wrap_and_have_a_basis_in_each_direction() {
    let points = "0 1 2 ".repeat(6 * 4);
    let frame = world(&format!(
        r#"Basis "b-spline" 1 "bezier" 3
        PatchMesh "bicubic" 6 "periodic" 4 "nonperiodic" "P" [{points}] "uniform float u" [1 2 3 4 5 6]
            "varying float v" [1 2 3 4 5 6 7 8 9 10 11 12]"#
    ));
    let mesh = mesh(&frame, 0);
    assert_eq!(mesh.num_patches(), Some([6, 1]));
    let PatchKind::Bicubic { u, v } = *mesh.kind else { panic!("bicubic") };
    assert_eq!((u.step, v), (1, PatchBasis::BEZIER));
    assert_eq!(u.matrix[3], [1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0, 0.0]);
}

#[test]
fn counts_that_do_not_fit_are_told() {
    let one = |text: &str, part: &str| {
        let read = read(&format!("WorldBegin {text} WorldEnd"));
        assert_eq!(read.diagnostics.len(), 1, "{text}: {:?}", read.diagnostics);
        assert!(read.diagnostics[0].message.contains(part), "{text}: {:?}", read.diagnostics);
        read.frames[0].scene.primitives.len()
    };
    assert_eq!(one("Patch \"bilinear\" \"P\" [0 0 0]", "has 3 numbers: expected 12"), 0);
    assert_eq!(one("Patch \"bilinear\"", "expected control points"), 0);
    assert_eq!(one("Patch \"cubic\" \"P\" [0]", "expected \"bilinear\" or \"bicubic\""), 0);
    assert_eq!(one("Patch \"bilinear\" \"float P\" [0 0 0 0]", "expected \"vertex point\""), 0);
    assert_eq!(one(&format!("{PATCH} \"Cs\" [1 1 1]"), "has 3 numbers: expected 12; left out"), 1);
    assert_eq!(one(&format!("{PATCH} \"s\" [0 1 0 1 9]"), "the rest is ignored"), 1);
    let bad = "PatchMesh \"bicubic\" 5 \"nonperiodic\" 4 \"nonperiodic\" \"P\" []";
    assert_eq!(one(bad, "expected along u 4 and then 3"), 0);
    let huge = "PatchMesh \"bilinear\" 2147483647 \"periodic\" 2147483647 \"periodic\" \"P\" [1]";
    assert_eq!(one(huge, "has 1 numbers"), 0);
    let negative = "PatchMesh \"bilinear\" -3 \"periodic\" 2 \"periodic\" \"P\" [1]";
    assert_eq!(one(negative, "expected a count, found -3"), 0);
}

#[test]
fn heights_and_homogeneous_points_are_control_points_too() {
    let frame = world(
        r#"Patch "bilinear" "Pz" [5 6 7 8]
        Patch "bilinear" "Pw" [0 0 0 1 2 0 0 2 0 1 0 1 1 1 0 1]
        Patch "bicubic" "Pz" [0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 9]"#,
    );
    let flat = Points::P(vec![[0., 0., 5.], [1., 0., 6.], [0., 1., 7.], [1., 1., 8.]]);
    assert_eq!(mesh(&frame, 0).points.first(), &flat);
    let Points::Pw(p) = mesh(&frame, 1).points.first() else { panic!("Pw") };
    assert_eq!(p[1], [2.0, 0.0, 0.0, 2.0]);
    let Points::P(p) = mesh(&frame, 2).points.first() else { panic!("P") };
    assert_eq!((p[5], p[15]), ([1.0 / 3.0, 1.0 / 3.0, 0.0], [1.0, 1.0, 9.0]));
    let read = read("WorldBegin Patch \"bilinear\" \"Pw\" [0 0 0 1 2 0 0 0 0 1 0 1 1 1 0 1] WorldEnd");
    read.says(Severity::Error, 1, 29, "weights above 0");
}

#[test]
fn attributes_go_with_the_primitives_that_follow() {
    let frame = world(&format!(
        r#"Attribute "identifier" "string name" "lid" Color [0.1 0.2 0.3] Opacity 0.5 0.5 0.5 Sides 1 Matte 1
        ShadingRate 4 ShadingInterpolation "smooth" TextureCoordinates 0 0 2 0 0 2 2 2 Surface "plastic" "Ka" 1
        Attribute "displacementbound" "sphere" 0.1 "coordinatesystem" "shader"
        {PATCH}"#
    ));
    let a = &frame.scene.primitives[0].attributes;
    assert_eq!(
        (a.name.as_str(), frame.scene.primitives[0].origin.to_string().as_str()),
        ("lid", "test.rib:5")
    );
    assert_eq!((a.color, a.opacity, a.sides, a.matte), ([0.1, 0.2, 0.3], [0.5; 3], Sides::One, true));
    assert_eq!((a.shading_rate, a.shading_interpolation), (4.0, ShadingInterpolation::Smooth));
    assert_eq!(a.texture_coordinates[3], [2.0, 2.0]);
    assert_eq!(a.surface.name(), "plastic");
}

#[test]
fn primitives_share_what_nothing_changed_between_them() {
    let frame = world(&format!(
        r#"{PATCH} {PATCH} Color [1 0 0] {PATCH} AttributeBegin {PATCH} Color [0 1 0] {PATCH} AttributeEnd {PATCH}
        Translate 1 0 0 {PATCH}"#
    ));
    let all = &frame.scene.primitives;
    let is_shared: Vec<bool> =
        all.windows(2).map(|two| Arc::ptr_eq(&two[0].attributes, &two[1].attributes)).collect();
    assert_eq!(is_shared, [true, false, true, false, false, true]);
    let colors: Vec<[f32; 3]> = all[2..6].iter().map(|primitive| primitive.attributes.color).collect();
    assert_eq!(colors, [[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]);
    assert!(all[4].to_world.is_shared_with(&all[5].to_world) && all[6].to_world != all[5].to_world);
    assert!((1..all.len()).all(|ix| Arc::ptr_eq(&mesh(&frame, 0).kind, &mesh(&frame, ix).kind)));
}

#[test]
fn a_shader_that_is_unknown_gives_way_to_the_default_one() {
    let read = read(&format!("WorldBegin\nSurface \"velvet\" \"float fuzz\" 1\n{PATCH} WorldEnd"));
    read.says(Severity::Warning, 2, 1, "velvet");
    assert_eq!(read.frames[0].scene.primitives[0].attributes.surface.name(), "defaultsurface");
}

#[test]
fn undeclared_parameters_are_guessed_with_a_warning() {
    let read = read("WorldBegin Displacement \"dents\"\n \"glow\" [1 2] WorldEnd");
    let said = read.said();
    assert_eq!((said[0].0, said[0].1, said[0].2), (Severity::Warning, 2, 2));
    assert!(said[0].3.contains("\"glow\" is not declared: taken as \"uniform float\""), "{said:?}");
}

#[test]
fn the_normal_is_turned_when_the_orientation_is_not_the_objects_own() {
    let reversed =
        |text: &str| world(&format!("{text} {PATCH}")).scene.primitives[0].attributes.reverse_orientation;
    assert!(!reversed(""));
    assert!(!reversed("Orientation \"outside\""));
    assert!(reversed("Orientation \"inside\""));
    // Camera and object are left-handed.
    assert!(!reversed("Orientation \"lh\""));
    assert!(reversed("Orientation \"rh\""));
    assert!(reversed("ReverseOrientation"));
    // The object is right-handed.
    assert!(reversed("Scale -1 1 1 Orientation \"lh\""));
    assert!(!reversed("Scale -1 1 1 Orientation \"rh\""));
    // A mirroring transform takes the orientation along.
    assert!(reversed("Orientation \"rh\" Scale -1 1 1"));
    assert!(!reversed("Scale -1 1 1"));
    assert!(!reversed("Orientation \"rh\" ReverseOrientation"));
}

#[test]
fn a_camera_that_mirrors_makes_the_world_right_handed() {
    let frame = frame(&format!("Scale 1 1 -1 WorldBegin Orientation \"rh\" {PATCH} WorldEnd"));
    assert!(!frame.scene.primitives[0].attributes.reverse_orientation);
}

/// The rule behind `reverse_orientation`, for both handednesses and orientations: in a left-handed orientation
/// the normal is the numeric product of the tangents in camera space, else its opposite.
#[test]
fn the_turned_normal_is_the_one_of_camera_space() {
    for (scale, orientation, sign) in
        [(1.0, "lh", 1.0), (1.0, "rh", -1.0), (-1.0, "lh", 1.0), (-1.0, "rh", -1.0)]
    {
        let frame =
            world(&format!("Scale {scale} 1 1 Rotate 30 1 2 3 Orientation \"{orientation}\" {PATCH}"));
        let m = to_world(&frame, 0);
        let wanted = m.transform_vector3(DVec3::X).cross(m.transform_vector3(DVec3::Y)) * sign;
        let carried = m.inverse().transpose().transform_vector3(DVec3::Z);
        let turned =
            if frame.scene.primitives[0].attributes.reverse_orientation { -carried } else { carried };
        assert!(near(turned.normalize(), wanted.normalize()), "{scale} {orientation}");
    }
}

#[test]
fn lights_are_switched_on_and_off() {
    let frame = frame(&format!(
        r#"Translate 0 0 5 LightSource "ambientlight" 1 "intensity" 0.1
        WorldBegin LightSource "pointlight" "key" "from" [0 1 0]
        {PATCH}
        AttributeBegin Illuminate 1 0 Illuminate "key" 1 Translate 1 2 3 LightSource "distantlight" 7 {PATCH} AttributeEnd
        {PATCH} Illuminate 7 1 {PATCH} WorldEnd"#
    ));
    let on: Vec<_> = frame.scene.primitives.iter().map(|p| p.attributes.lights.to_vec()).collect();
    assert_eq!(on, [vec![0, 1], vec![1, 2], vec![0, 1], vec![0, 1, 2]]);
    let place = |ix: usize| frame.scene.lights[ix].to_world.first().transform_point3(DVec3::ZERO);
    // The first one stands in camera space where the transformation was; in world that is the origin.
    assert_eq!((place(0), place(2)), (DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0)));
    let read = read("WorldBegin Illuminate 3 1 WorldEnd");
    read.says(Severity::Error, 1, 23, "light 3 is unknown");
}

#[test]
fn one_level_of_detail_is_drawn() {
    // A unit square is 100 x 100 pixels: 10,000.
    let levels = |factor: f64| {
        let text = format!(
            "Format 200 200 1 RelativeDetail {factor} WorldBegin Detail [0 1 0 1 0 1]
            DetailRange 0 0 4000 6000 Color 1 0 0 {PATCH}
            DetailRange 4000 6000 1e38 1e38 Color 0 1 0 {PATCH} WorldEnd"
        );
        frame(&text).scene.primitives.iter().map(|p| p.attributes.color[1]).collect::<Vec<_>>()
    };
    assert_eq!(levels(1.0), [1.0]);
    assert_eq!(levels(0.51), [1.0]);
    assert_eq!(levels(0.49), [0.0]);
}
