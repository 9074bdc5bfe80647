//! `olema render` and `olema info` on scenes.

mod common;

use common::{Bench, SQUARE, png_size, signal, three_frames, wait_until};

/// A picture of the square that takes long enough to be stopped.
const SLOW: [&str; 6] = ["--res", "8000x6000", "--spp", "256", "--threads", "1"];

#[test]
fn a_missing_scene_exits_3_and_is_named() {
    let bench = Bench::new();
    for command in ["render", "info"] {
        let ran = bench.run(&[command, "no.rib"]);
        assert_eq!(ran.code, 3, "{}", ran.err);
        assert!(ran.err.contains("no.rib"), "{}", ran.err);
        assert!(ran.out.is_empty() || command == "info");
    }
    assert!(bench.names().is_empty());
}

#[test]
fn the_scenes_display_names_the_picture() {
    let bench = Bench::new();
    bench.file("a.rib", SQUARE);
    let ran = bench.run(&["render", "a.rib"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    assert_eq!(ran.out, "square.png\n");
    assert_eq!(bench.names(), ["a.rib", "square.png"]);
    assert_eq!(png_size(&bench.path("square.png")), [32, 24]);
}

#[test]
fn a_scene_cannot_write_outside_the_current_directory() {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("victim")).unwrap();
    let absolute = bench.path("victim").join("x.png");
    for display in ["../x.png", "victim/x.png", absolute.to_str().unwrap()] {
        bench.file("a.rib", SQUARE.replace("square.tif", display));
        let ran = bench.run(&["render", "a.rib"]);
        assert_eq!((ran.code, ran.out.as_str()), (0, "x.png\n"), "{}", ran.err);
    }
    assert_eq!(bench.names(), ["a.rib", "victim", "x.png"]);
    assert_eq!(std::fs::read_dir(bench.path("victim")).unwrap().count(), 0);
}

#[cfg(unix)]
#[test]
fn a_scene_cannot_write_through_a_link() {
    let bench = Bench::new();
    bench.file("a.rib", SQUARE);
    bench.file("precious", "mine");
    std::os::unix::fs::symlink("precious", bench.path("square.png")).unwrap();
    let ran = bench.run(&["render", "a.rib"]);
    assert_eq!(ran.code, 1);
    assert!(ran.err.contains("is a link"), "{}", ran.err);
    assert_eq!(std::fs::read_to_string(bench.path("precious")).unwrap(), "mine");
    // Named by the user it is written.
    assert_eq!(bench.run(&["render", "a.rib", "-o", "square.png"]).code, 0);
    assert_eq!(png_size(&bench.path("precious")), [32, 24]);
}

#[cfg(unix)]
#[test]
fn a_device_is_written_to_and_stays() {
    let bench = Bench::new();
    bench.file("a.rib", SQUARE);
    let ran = bench.run(&["render", "a.rib", "-o", "/dev/null"]);
    assert_eq!((ran.code, ran.out.as_str()), (0, "/dev/null\n"), "{}", ran.err);
    assert!(!std::path::Path::new("/dev/null").is_file());
}

#[test]
fn a_render_again_replaces_the_picture() {
    let bench = Bench::new();
    bench.file("a.rib", SQUARE);
    bench.file("out.png", "old");
    let ran = bench.run(&["render", "a.rib", "-o", "out.png", "--res", "16x12"]);
    assert_eq!((ran.code, ran.out.as_str()), (0, "out.png\n"), "{}", ran.err);
    assert_eq!(png_size(&bench.path("out.png")), [16, 12]);
}

#[test]
fn frames_fill_the_pattern_and_are_chosen() {
    let bench = Bench::new();
    bench.file("a.rib", three_frames());
    let ran = bench.run(&["render", "a.rib", "-o", "a.####.png", "--frames", "1-9:2"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    assert_eq!(ran.out, "a.0001.png\na.0003.png\n");
    assert_eq!(bench.run(&["render", "a.rib", "-o", "b.%d.png"]).out, "b.1.png\nb.2.png\nb.3.png\n");
}

#[test]
fn frames_that_are_not_there_exit_3() {
    let bench = Bench::new();
    bench.file("a.rib", three_frames());
    let ran = bench.run(&["render", "a.rib", "--frames", "7"]);
    assert_eq!(ran.code, 3);
    assert!(ran.err.contains("none of its 3 frames"), "{}", ran.err);
}

#[test]
fn a_second_frame_never_replaces_the_first() {
    let bench = Bench::new();
    bench.file("a.rib", three_frames());
    let ran = bench.run(&["render", "a.rib", "-o", "one.png"]);
    assert_eq!(ran.code, 2);
    assert!(ran.err.contains("####"), "{}", ran.err);
    assert_eq!(bench.names(), ["a.rib", "one.png"]);
    let ran = bench.run(&["render", "a.rib"]);
    assert_eq!(ran.out, "square.png\nsquare.0002.png\nsquare.0003.png\n", "{}", ran.err);
}

#[test]
fn standard_input_is_a_scene() {
    let bench = Bench::new();
    let ran = bench.run_with_input(&["render", "-", "-o", "a.png"], SQUARE);
    assert_eq!((ran.code, ran.out.as_str()), (0, "a.png\n"), "{}", ran.err);
}

#[test]
fn a_picture_beyond_memory_exits_4() {
    let bench = Bench::new();
    bench.file("a.rib", SQUARE);
    let ran = bench.run(&["render", "a.rib", "--res", "65535x65535"]);
    assert_eq!(ran.code, 4, "{}", ran.err);
    assert!(ran.err.contains("out of memory"), "{}", ran.err);
    assert_eq!(bench.names(), ["a.rib"]);
}

#[test]
fn crops_have_the_size_of_the_window() {
    let bench = Bench::new();
    bench.file("a.rib", SQUARE);
    for (crop, size) in [("0.25,0.75,0,0.5", [16, 12]), ("4,20,3,9", [16, 6])] {
        let ran = bench.run(&["render", "a.rib", "-o", "a.png", "--crop", crop]);
        assert_eq!(ran.code, 0, "{}", ran.err);
        assert_eq!(png_size(&bench.path("a.png")), size);
    }
}

#[test]
fn quiet_says_nothing_when_all_is_well() {
    let bench = Bench::new();
    bench.file("a.rib", SQUARE);
    let ran = bench.run(&["render", "a.rib", "-q"]);
    assert_eq!((ran.code, ran.out.as_str(), ran.err.as_str()), (0, "", ""));
}

#[test]
fn options_that_must_not_matter_do_not() {
    let bench = Bench::new();
    bench.file("a.rib", SQUARE);
    assert_eq!(bench.run(&["render", "a.rib", "-o", "a.png"]).code, 0);
    for options in [
        &["-t", "1"][..],
        &["-t", "-1"],
        &["--bucket", "5x3"],
        &["--raster-tile", "8"],
        &["--rasterizer", "nomotion"],
        &["--rasterizer", "interleave"],
        &["--shutter", "0,0"],
        &["--motion-factor", "2"],
        &["--focus-factor", "2"],
    ] {
        let args = [&["render", "a.rib", "-o", "b.png"], options].concat();
        assert_eq!(bench.run(&args).code, 0);
        assert_eq!(bench.run(&["diff", "a.png", "b.png"]).code, 0, "{options:?}");
    }
    assert_eq!(bench.run(&["render", "a.rib", "-o", "b.png", "--seed", "1"]).code, 0);
    assert_eq!(bench.run(&["diff", "a.png", "b.png"]).code, 1, "the seed must matter");
}

#[test]
fn a_coarser_shading_rate_dices_fewer_points() {
    let bench = Bench::new();
    bench.file("a.rib", SQUARE);
    let points = |rate: &str| {
        let ran = bench.run(&["render", "a.rib", "--shading-rate", rate, "--stats", "s.json"]);
        assert_eq!(ran.code, 0, "{}", ran.err);
        stats(&bench)["frames"][0]["stats"]["diced_points"].as_u64().unwrap()
    };
    assert!(points("0.25") > 2 * points("4"));
}

#[test]
fn stats_hold_a_record_a_picture() {
    let bench = Bench::new();
    bench.file("a.rib", three_frames());
    let ran = bench.run(&["render", "a.rib", "-o", "a.#.png", "--spp", "12", "--stats", "s.json"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    let stats = stats(&bench);
    let frames = stats["frames"].as_array().unwrap();
    assert_eq!(frames.len(), 3);
    for (ix, frame) in frames.iter().enumerate() {
        assert_eq!(frame["frame"], ix + 1);
        assert_eq!(frame["picture"], format!("a.{}.png", ix + 1));
        assert_eq!(frame["settings"]["samples"], serde_json::json!([4, 3]));
        assert_eq!(frame["stats"]["patches"], 1);
        assert!(frame["stats"]["sample_hits"].as_u64().unwrap() > 0);
    }
}

#[test]
fn stats_name_the_options_that_were_given() {
    let bench = Bench::new();
    bench.file("a.rib", SQUARE.replace("WorldBegin", "Hider \"hidden\" \"int permutations\" 9 WorldBegin"));
    let options = ["--rasterizer", "interval", "--motion-factor", "1.5", "--shading-time", "open"];
    let ran = bench.run(&[&["render", "a.rib", "--stats", "s.json"][..], &options].concat());
    assert_eq!(ran.code, 0, "{}", ran.err);
    let settings = &stats(&bench)["frames"][0]["settings"];
    assert_eq!((&settings["rasterizer"], &settings["permutations"]), (&"interval".into(), &9.into()));
    assert_eq!((&settings["motion_factor"], &settings["shading_time"]), (&1.5.into(), &0.0.into()));
    assert_eq!(settings["focus_factor"], serde_json::Value::Null);
}

#[test]
fn progress_lines_are_json_on_request() {
    let bench = Bench::new();
    bench.file("a.rib", format!("Nonsense 1 2\n{SQUARE}"));
    let ran = bench.run(&["render", "a.rib", "--progress", "json"]);
    let events: Vec<serde_json::Value> = ran.err.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    for event in ["message", "progress", "picture"] {
        assert!(events.iter().any(|e| e["event"] == event), "{event}: {}", ran.err);
    }
}

#[test]
fn messages_show_the_source_line_and_point_into_it() {
    let bench = Bench::new();
    bench.file("a.rib", SQUARE.replace("\"bilinear\"", "\"trilinear\""));
    let ran = bench.run(&["render", "a.rib"]);
    assert!(ran.err.contains("a.rib:8:"), "{}", ran.err);
    assert!(ran.err.contains("8 | Patch \"trilinear\""), "{}", ran.err);
    assert_eq!(ran.code, 3);
}

#[test]
fn messages_that_repeat_are_counted() {
    let bench = Bench::new();
    bench.file("a.rib", format!("{}{SQUARE}", "Nonsense\n".repeat(1000)));
    let ran = bench.run(&["render", "a.rib"]);
    assert!(ran.err.matches("Nonsense").count() < 20, "{}", ran.err);
    assert!(ran.err.contains("not shown"), "{}", ran.err);
    let all = bench.run(&["render", "a.rib", "--verbose"]);
    assert!(all.err.matches("Nonsense").count() >= 1000);
}

#[test]
fn a_file_without_a_world_exits_3() {
    let bench = Bench::new();
    bench.file("a.rib", "# nothing\n");
    let ran = bench.run(&["render", "a.rib"]);
    assert_eq!(ran.code, 3);
    assert!(ran.err.contains("WorldBegin"), "{}", ran.err);
}

#[test]
fn one_bad_file_does_not_keep_the_others_from_being_rendered() {
    let bench = Bench::new();
    bench.file("a.rib", SQUARE);
    let ran = bench.run(&["render", "no.rib", "a.rib", "-o", "a.png"]);
    assert_eq!((ran.code, ran.out.as_str()), (3, "a.png\n"), "{}", ran.err);
}

#[cfg(unix)]
#[test]
fn signals_stop_cleanly_and_finished_pictures_stay() {
    for (name, code) in [("INT", 130), ("TERM", 143)] {
        let bench = Bench::new();
        bench.file("quick.rib", SQUARE.replace("square", "quick"));
        let slow = format!("FrameBegin 1\n{SQUARE}FrameEnd\nFrameBegin 2\n{SQUARE}FrameEnd\n");
        bench.file("slow.rib", slow);
        let args = [&["render", "slow.rib", "-o", "#.png", "--progress", "json"], &SLOW[..]].concat();
        bench.run(&["render", "quick.rib"]);
        let mut child = bench.spawn(&args);
        // Into the middle of the first picture.
        let mut lines = std::io::BufRead::lines(std::io::BufReader::new(child.stderr.take().unwrap()));
        assert!(lines.any(|line| line.unwrap().contains("draw")));
        signal(&child, name);
        // Kept open, so that the child's words find a reader.
        let drain = std::thread::spawn(move || lines.map_while(Result::ok).count());
        assert_eq!(child.wait().unwrap().code(), Some(code));
        drain.join().unwrap();
        assert_eq!(bench.names(), ["quick.png", "quick.rib", "slow.rib"]);
    }
}

#[cfg(unix)]
#[test]
fn a_signal_ends_a_wait_for_standard_input() {
    let bench = Bench::new();
    let mut child = bench.spawn(&["render", "-", "-o", "a.png", "--stats", "s.json"]);
    let mut input = child.stdin.take().unwrap();
    // More than a reader may want to look ahead before it draws the first world.
    let scene = format!("{SQUARE}{}", "\n".repeat(1 << 20));
    std::io::Write::write_all(&mut input, scene.as_bytes()).unwrap();
    // The first picture is there, and the command waits for more.
    wait_until(|| bench.path("s.json").exists());
    signal(&child, "INT");
    assert_eq!(child.wait().unwrap().code(), Some(130));
    drop(input);
    assert_eq!(bench.names(), ["a.png", "s.json"]);
}

#[test]
fn info_tells_what_is_in_the_scene() {
    let bench = Bench::new();
    bench.file("a.rib", SQUARE);
    let ran = bench.run(&["info", "a.rib"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    for words in ["1 frame", "32x24", "1 bilinear patches", "control points  4", "1 constant", "0 errors"] {
        assert!(ran.out.contains(words), "{words}: {}", ran.out);
    }
    let ran = bench.run(&["info", "a.rib", "--json"]);
    let info: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
    let frame = &info["frames"][0];
    assert_eq!(frame["resolution"], serde_json::json!([32, 24]));
    assert_eq!(frame["primitives"]["bilinear patches"], 1);
    assert_eq!(frame["bounding_box"], serde_json::json!([[-1.0, -1.0, 5.0], [1.0, 1.0, 5.0]]));
    assert_eq!(bench.names(), ["a.rib"]);
}

#[test]
fn info_tells_what_moves_and_what_is_in_focus() {
    let bench = Bench::new();
    bench.file("still.rib", SQUARE);
    let ran = bench.run(&["info", "still.rib"]);
    for words in ["shutter         at 0, still", "lens            pinhole", "motion          none"] {
        assert!(ran.out.contains(words), "{words}: {}", ran.out);
    }
    let moving = "Attribute \"identifier\" \"name\" \"wheel\"
        MotionBegin [0 1] Rotate 0 0 0 1 Rotate 30 0 0 1 MotionEnd Patch \"bilinear\"";
    let scene = SQUARE.replace(
        "Patch \"bilinear\"",
        &format!("Patch \"bilinear\" \"P\" [0 0 9 1 0 9 0 1 9 1 1 9] {moving}"),
    );
    bench.file("a.rib", format!("Shutter 0 0.5 DepthOfField 4 0.5 5 {scene}"));
    let ran = bench.run(&["info", "a.rib"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    for words in [
        "shutter         0 to 0.5",
        "lens            f/4, focal length 0.5, focused at 5, round",
        "motion          1 of 2 primitives; wheel; keys at 0, 1",
    ] {
        assert!(ran.out.contains(words), "{words}: {}", ran.out);
    }
    let ran = bench.run(&["info", "a.rib", "--json"]);
    let info: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
    let frame = &info["frames"][0];
    assert_eq!((&frame["shutter"]["close"], &frame["lens"]["fstop"]), (&0.5.into(), &4.0.into()));
    assert_eq!(
        (&frame["motion"]["objects"]["wheel"], &frame["motion"]["primitives"]),
        (&1.into(), &1.into())
    );
}

fn stats(bench: &Bench) -> serde_json::Value {
    serde_json::from_str(&std::fs::read_to_string(bench.path("s.json")).unwrap()).unwrap()
}

#[test]
fn memory_is_paid_for_in_time_and_recorded() {
    let bench = Bench::new();
    bench.file("a.rib", include_str!("../../../scenes/teapot.rib"));
    let drawn = |memory: &str| {
        let out = format!("{memory}.png");
        let ran = bench.run(&[
            "render",
            "a.rib",
            "-o",
            &out,
            "--res",
            "96x72",
            "--raster-tile",
            "8",
            "--stats",
            "s.json",
            "--memory",
            memory,
        ]);
        assert_eq!(ran.code, 0, "{}", ran.err);
        (std::fs::read(bench.path(&out)).unwrap(), stats(&bench)["frames"][0].take())
    };
    let ((tiny, made), (large, kept)) = (drawn("1M"), drawn("1G"));
    assert!(tiny == large, "memory changed the picture");
    assert!(made["stats"]["grids_again"].as_u64() > Some(0), "{made}");
    assert_eq!(kept["stats"]["grids_again"], 0);
    assert_eq!(kept["settings"]["memory"], 1u64 << 30);
    assert_eq!(kept["settings"]["grid_cache"], 192u64 << 20);
    assert_eq!(kept["settings"]["picture_memory"], 256u64 << 20);
    let refused = bench.run(&["render", "a.rib", "--res", "640x480", "--memory", "1M"]);
    assert_eq!(refused.code, 4, "{}", refused.err);
    assert_eq!(bench.run(&["render", "a.rib", "--memory", "lots"]).code, 2);
}
