//! Options: format, camera, lens and shutter, settings, displays.

use olema::image::FilterKind;
use olema::sampling::Rasterizer;
use olema::scene::{Camera, Lens, Projection};

use super::*;

#[test]
fn the_standards_defaults_hold_where_nothing_is_said() {
    let frame = frame("WorldBegin WorldEnd");
    assert_eq!(frame.settings.resolution, [640, 480]);
    assert_eq!(frame.scene.camera.projection, Projection::Orthographic);
    assert_eq!(frame.scene.camera.screen_window, None);
    assert_eq!(frame.displays.len(), 1);
    assert_eq!(frame.number, None);
    frame.settings.validate().expect("valid settings");
}

#[test]
fn options_become_settings_and_the_camera() {
    let frame = frame(
        r#"##RenderMan RIB-Structure 1.1
        version 3.04
        Format 320 200 1.5 # a comment
        Projection "perspective" "fov" 45
        ScreenWindow [-2 2 -1 1] Clipping 0.5 1e38 Shutter 0 0.5
        PixelSamples 3 5 PixelFilter "mitchell" 4 3.5 Exposure 2 2.2
        Imager "background" "color" [0.1 0.2 0.3]
        Option "limits" "gridsize" [128] "bucketsize" [32 16] "eyesplits" 6
        Hider "hidden" "jitter" 0 PixelVariance 0.1 RelativeDetail 1 ErrorHandler "print"
        GeometricRepresentation "smooth"
        WorldBegin WorldEnd"#,
    );
    let (s, c) = (&frame.settings, &frame.scene.camera);
    assert_eq!((s.resolution, s.samples), ([320, 200], [3, 5]));
    assert_eq!((s.filter.kind, s.filter.width), (FilterKind::Mitchell, [4.0, 3.5]));
    assert_eq!((s.exposure, s.background), ([2.0, 2.2], Some([0.1, 0.2, 0.3])));
    assert_eq!((s.grid_size, s.bucket, s.eye_splits, s.jitter), (128, [32, 16], 6, false));
    assert_eq!(c.projection, Projection::Perspective { fov: 45.0 });
    assert_eq!((c.screen_window, c.pixel_aspect), (Some([-2.0, 2.0, -1.0, 1.0]), 1.5));
    assert_eq!((c.clipping, c.shutter), ([0.5, f32::INFINITY], [0.0, 0.5]));
}

#[test]
fn every_filter_of_the_standard_is_known() {
    for name in ["box", "triangle", "catmull-rom", "gaussian", "sinc", "mitchell", "blackman-harris"] {
        frame(&format!("PixelFilter \"{name}\" 2 2 WorldBegin WorldEnd"));
    }
    let read = read("PixelFilter \"disk\" 2 2 WorldBegin WorldEnd");
    read.says(Severity::Error, 1, 13, "expected box, triangle");
}

#[test]
fn crop_windows_that_share_a_side_share_no_pixel() {
    let crop = |x0: f64, x1: f64| {
        let text = format!("Format 100 50 1 CropWindow {x0} {x1} 0 1 WorldBegin WorldEnd");
        frame(&text).settings.crop_px.expect("a crop window")
    };
    assert_eq!(crop(0.0, 1.0), [0, 100, 0, 50]);
    for cut in [0.1, 0.333, 0.5, 0.705] {
        assert_eq!(crop(0.0, cut)[1], crop(cut, 1.0)[0]);
    }
    assert_eq!(crop(0.0, 0.333)[1], 34);
}

#[test]
fn the_frame_is_the_largest_part_of_the_format_with_its_aspect_ratio() {
    let frame = |text: &str| frame(&format!("{text} WorldBegin WorldEnd"));
    let wide = frame("Format 400 300 1 FrameAspectRatio 2");
    assert_eq!(wide.settings.resolution, [400, 200]);
    assert_eq!(wide.scene.camera.screen_window, Some([-2.0, 2.0, -1.0, 1.0]));
    let tall = frame("Format 400 300 1 FrameAspectRatio 0.5");
    assert_eq!(tall.settings.resolution, [150, 300]);
    assert_eq!(tall.scene.camera.screen_window, Some([-1.0, 1.0, -2.0, 2.0]));
}

#[test]
fn a_plus_adds_a_display_and_quantization_is_that_of_the_mode() {
    let frame = frame(
        r#"Quantize "rgba" 1023 0 1023 1 Quantize "N" 127 -127 127 0
        Display "old.tif" "file" "rgb" Display "a.png" "file" "rgba" "compression" "lzw"
        Display "+n.tif" "tiff" "N" Display "+z.tif" "zfile" "z"
        Display "+q.tif" "file" "rgb" "quantize" [0 255 0 255] "dither" 0.25
        WorldBegin WorldEnd"#,
    );
    let names: Vec<&str> = frame.displays.iter().map(|d| d.name.as_str()).collect();
    assert_eq!(names, ["a.png", "n.tif", "z.tif", "q.tif"]);
    let quantize: Vec<_> =
        frame.displays.iter().map(|d| (d.quantize.one, d.quantize.min, d.quantize.dither)).collect();
    assert_eq!(quantize, [(1023, 0, 1.0), (127, -127, 0.0), (0, 0, 0.0), (255, 0, 0.25)]);
}

/// The camera of a text in front of a perspective world.
fn camera(text: &str) -> Camera {
    frame(&format!("Projection \"perspective\" {text} WorldBegin WorldEnd")).scene.camera
}

#[test]
fn depth_of_field_is_a_lens_or_a_pinhole() {
    let lens = Lens::new(2.8, 1.0, 10.0);
    assert_eq!(camera("DepthOfField 2.8 1 10").lens, Some(lens));
    for pinhole in ["", "-", "1e38 1 10", "1e30 1 10"] {
        assert_eq!(camera(&format!("DepthOfField 2.8 1 10 DepthOfField {pinhole}")).lens, None, "{pinhole}");
    }
    // What is refused leaves the lens as it was.
    let read =
        read("Projection \"perspective\"\nDepthOfField 2.8 1 10\nDepthOfField 2.8 1 -10 WorldBegin WorldEnd");
    read.says(Severity::Error, 3, 14, "expected an f-stop");
    assert_eq!(read.frames[0].scene.camera.lens, Some(lens));
}

#[test]
fn a_lens_in_front_of_parallel_rays_is_warned_about() {
    for projection in ["", "Projection \"orthographic\""] {
        let read = read(&format!("\nDepthOfField 2.8 1 10 {projection} WorldBegin WorldEnd"));
        read.says(Severity::Warning, 2, 1, "no effect with an orthographic projection");
        assert_eq!(read.frames[0].scene.camera.lens, None);
    }
    assert!(camera("DepthOfField 2.8 1 10").lens.is_some());
}

#[test]
fn a_shutter_that_does_not_open_for_long_is_still() {
    for (text, shutter) in [("0 0", [0.0, 0.0]), ("-2 0.5", [-2.0, 0.5]), ("3 3", [3.0, 3.0])] {
        assert_eq!(camera(&format!("Shutter {text}")).shutter, shutter);
    }
}

#[test]
fn hider_and_depth_of_field_come_in_any_order() {
    let hider = "Hider \"hidden\" \"float[4] aperture\" [6 15 0 0] \"float[2] shutteropening\" [0.25 0.5]";
    let lens = Lens { blades: 6, blade_angle: 15.0, ..Lens::new(4.0, 1.0, 5.0) };
    for text in [format!("{hider} DepthOfField 4 1 5"), format!("DepthOfField 4 1 5 {hider}")] {
        let camera = camera(&text);
        assert_eq!((camera.lens, camera.shutter_opening), (Some(lens), [0.25, 0.5]));
    }
    assert_eq!(camera(hider).lens, None);
    // The same without inline declarations.
    let bare = hider.replace("float[4] ", "").replace("float[2] ", "");
    assert_eq!(camera(&bare).shutter_opening, [0.25, 0.5]);
}

#[test]
fn a_hider_parameter_without_effect_is_noted_and_one_that_is_wrong_leaves_the_others() {
    let read1 = read("Hider \"hidden\" \"aperture\" [5 0 0.5 0] \"int sigma\" 1 WorldBegin WorldEnd");
    let notes: Vec<_> = read1.said().iter().map(|said| (said.0, said.3.to_owned())).collect();
    assert_eq!(notes.len(), 2, "{notes:?}");
    assert!(notes[0].1.contains("roundness") && notes[1].1.contains("\"sigma\" has no effect"), "{notes:?}");
    assert!(notes.iter().all(|note| note.0 == Severity::Note));
    let read2 = read("Hider \"hidden\" \"tile\" 5 \"jitter\" 0 WorldBegin WorldEnd");
    assert_eq!((read2.diagnostics.len(), read2.frames[0].settings.jitter), (1, false));
}

#[test]
fn the_hider_picks_rasterizer_and_pattern() {
    let settings = |text: &str| frame(&format!("Hider \"hidden\" {text} WorldBegin WorldEnd")).settings;
    for rasterizer in Rasterizer::ALL {
        assert_eq!(settings(&format!("\"string rasterizer\" \"{rasterizer}\"")).rasterizer, rasterizer);
    }
    let pattern = settings("\"int tile\" [8] \"permutations\" 16");
    assert_eq!((pattern.pattern_tile, pattern.permutations), (Some(8), 16));
    assert_eq!(settings("\"rasterizer\" \"simple\"").pattern_tile_side(), 1);
}

#[test]
fn blur_coarsens_dicing_by_factors_of_the_primitive() {
    let read = read(&format!(
        "WorldBegin GeometricApproximation \"motionfactor\" 1.5 AttributeBegin
        GeometricApproximation \"focusfactor\" 2 {PATCH} AttributeEnd {PATCH}
        GeometricApproximation \"flatness\" 0.5 GeometricApproximation \"deviation\" 1 WorldEnd"
    ));
    read.says(Severity::Note, 3, 9, "only motionfactor and focusfactor have an effect");
    let factors = read.frames[0].scene.primitives.iter().map(|primitive| {
        let look = &primitive.attributes;
        (look.motion_factor, look.focus_factor)
    });
    assert_eq!(factors.collect::<Vec<_>>(), [(1.5, 2.0), (1.5, 0.0)]);
}

/// Asserts that each text is an error whose message has that part, and leaves lens and shutter as they were.
#[track_caller]
fn assert_refused(cases: &[(&str, &str)]) {
    for (text, part) in cases {
        let read = read(&format!("{text} WorldBegin WorldEnd"));
        assert_eq!(read.diagnostics.len(), 1, "{text}: {:?}", read.diagnostics);
        assert_eq!((read.diagnostics[0].severity, read.diagnostics[0].line), (Severity::Error, 1));
        assert!(read.diagnostics[0].message.contains(part), "{text}: {:?}", read.diagnostics);
        let camera = &read.frames[0].scene.camera;
        assert_eq!((camera.shutter, camera.shutter_opening, camera.lens), ([0.0; 2], [0.0, 1.0], None));
        assert_eq!(read.frames.len(), 1);
        read.frames[0].settings.validate().expect("valid settings");
    }
}

#[test]
fn values_out_of_range_are_refused_and_the_old_ones_stay() {
    assert_refused(&[
        ("Format 0 480 1", "expected 1 to 65535"),
        ("Format 100000000 480 1", "expected 1 to 65535"),
        ("PixelSamples 100 100", "expected 1 to 1024"),
        ("PixelSamples 0 1", "expected 1 to 1024"),
        ("PixelFilter \"box\" 0 1", "expected widths"),
        ("Clipping 2 1", "expected 0 < near < far"),
        ("Exposure 1 0", "expected a gain"),
        ("CropWindow 0.5 0.2 0 1", "expected 0 <= xmin"),
        ("ScreenWindow 1 1 0 1", "to differ"),
        ("FrameAspectRatio -1", "expected a ratio"),
        ("Projection \"perspective\" \"fov\" 180", "below 180"),
        ("Quantize \"rgba\" -1 0 255 0", "expected one of at least 0"),
        ("ShadingRate 0", "above 0"),
        ("Sides 3", "expected 1 or 2"),
        ("Basis \"bezier\" 5 \"bezier\" 3", "step from 1 to 4"),
        ("Orientation \"up\"", "expected \"outside\""),
        ("DetailRange 3 2 1 0", "expected 0 <= minvisible"),
        ("ShadingInterpolation \"none\"", "expected \"constant\""),
    ]);
}

#[test]
fn lenses_shutters_and_hiders_that_make_no_sense_are_refused() {
    assert_refused(&[
        ("Shutter 1 0", "Shutter: expected the opening"),
        ("Shutter -3e38 3e38", "Shutter: expected times"),
        ("Shutter 0 nan", "not a finite number"),
        (
            "DepthOfField 0 1 1",
            "DepthOfField: expected an f-stop, a focal length and a focal distance above 0",
        ),
        ("DepthOfField 2.8 -1 1", "expected an f-stop"),
        ("DepthOfField 2.8 1 0", "expected an f-stop"),
        ("DepthOfField 1e-50 1 1", "expected an f-stop"),
        ("DepthOfField 1e-30 1e30 1", "expected an f-stop"),
        ("DepthOfField nan 1 1", "not a finite number"),
        ("GeometricApproximation \"motionfactor\" -1", "expected a factor of at least 0"),
        ("GeometricApproximation \"focusfactor\" -0.1", "expected a factor of at least 0"),
        (
            "Hider \"hidden\" \"float[4] aperture\" [65 0 0 0]",
            "65 sides: expected a whole number from 0 to 64",
        ),
        ("Hider \"hidden\" \"float[4] aperture\" [-3 0 0 0]", "-3 sides: expected"),
        ("Hider \"hidden\" \"float[4] aperture\" [5.5 0 0 0]", "5.5 sides: expected"),
        ("Hider \"hidden\" \"float aperture\" [5]", "expected 4 numbers, found 1"),
        ("Hider \"hidden\" \"float[2] shutteropening\" [0.6 0.5]", "0.6 0.5: expected the parts"),
        ("Hider \"hidden\" \"float[2] shutteropening\" [-0.1 1]", "-0.1 1: expected the parts"),
        ("Hider \"hidden\" \"float[2] shutteropening\" [0 1.5]", "0 1.5: expected the parts"),
        ("Hider \"hidden\" \"shutteropening\" \"late\"", "expected 2 numbers, found 1"),
        ("Hider \"hidden\" \"jitter\" []", "expected one number, found 0"),
        (
            "Hider \"hidden\" \"string rasterizer\" \"fast\"",
            "expected auto, nomotion, interval, interleave, boundingbox",
        ),
        ("Hider \"hidden\" \"rasterizer\" 3", "expected a string"),
        ("Hider \"hidden\" \"int tile\" 5", "pattern tile is 5: expected 1, 2, 3, 4, 8 or 64"),
        ("Hider \"hidden\" \"tile\" 1.5", "1.5: expected a whole number"),
        ("Hider \"hidden\" \"int permutations\" 0", "permutations is 0: expected 1 to 65536"),
        ("Hider \"hidden\" \"int permutations\" -1", "-1: expected a whole number"),
        (
            "Hider \"hidden\" \"rasterizer\" \"interleave\" \"tile\" 64",
            "\"tile\" 64: expected at most 8 with rasterizer \"interleave\"; auto",
        ),
    ]);
}

#[test]
fn options_within_the_world_come_too_late() {
    let read1 = read("WorldBegin\n Format 10 10 1\nWorldEnd");
    read1.says(Severity::Warning, 2, 2, "before WorldBegin");
    assert_eq!(read1.frames[0].settings.resolution, [640, 480]);
    let read2 = read("WorldBegin\nImager \"background\" \"color\" [1 1 1]\nWorldEnd");
    read2.says(Severity::Note, 2, 1, "Imager in a world");
    assert_eq!(read2.frames[0].settings.background, Some([1.0; 3]));
}
