//! Options: format, camera, settings, displays.

use olema::image::FilterKind;
use olema::scene::{Lens, Projection};

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
        GeometricApproximation "flatness" 0.5 GeometricRepresentation "smooth"
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

#[test]
fn the_lens_is_kept_and_said_not_to_be_drawn() {
    let read1 = read("DepthOfField 2.8 1 10 WorldBegin WorldEnd");
    read1.says(Severity::Note, 1, 1, "depth of field");
    let lens = Lens::new(2.8, 1.0, 10.0);
    assert_eq!(read1.frames[0].scene.camera.lens, Some(lens));
    let read2 = read("DepthOfField 2.8 1 10 DepthOfField - WorldBegin WorldEnd");
    assert_eq!(read2.frames[0].scene.camera.lens, None);
    assert_eq!(frame("DepthOfField WorldBegin WorldEnd").scene.camera.lens, None);
}

#[test]
fn values_out_of_range_are_refused_and_the_old_ones_stay() {
    for (text, part) in [
        ("Format 0 480 1", "expected 1 to 65535"),
        ("Format 100000000 480 1", "expected 1 to 65535"),
        ("PixelSamples 100 100", "expected 1 to 1024"),
        ("PixelSamples 0 1", "expected 1 to 1024"),
        ("PixelFilter \"box\" 0 1", "expected widths"),
        ("Clipping 2 1", "expected 0 < near < far"),
        ("Exposure 1 0", "expected a gain"),
        ("Shutter 1 0", "expected the opening"),
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
    ] {
        let read = read(&format!("{text} WorldBegin WorldEnd"));
        assert_eq!(read.diagnostics.len(), 1, "{text}: {:?}", read.diagnostics);
        assert_eq!(read.diagnostics[0].severity, Severity::Error);
        assert!(read.diagnostics[0].message.contains(part), "{text}: {:?}", read.diagnostics);
        assert_eq!(read.frames.len(), 1);
        read.frames[0].settings.validate().expect("valid settings");
    }
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
