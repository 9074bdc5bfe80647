//! `olema bench`: what it prints, and that every scene can be drawn.

mod common;

use std::time::{Duration, Instant};

use common::Bench;
use serde_json::Value;

#[test]
fn each_scene_is_quick_and_its_counts_are_plausible() {
    let bench = Bench::new();
    let began = Instant::now();
    let ran = bench.run(&["bench", "--quick", "--json", "--runs", "1", "-t", "1"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    let all: Value = serde_json::from_str(&ran.out).expect("JSON");
    let scenes = all["scenes"].as_array().expect("scenes");
    assert_eq!((all["runs"].as_u64(), scenes.len()), (Some(1), 23));
    for scene in scenes {
        let count = |field: &str| scene[field].as_u64().unwrap_or_else(|| panic!("{field} of {scene}"));
        let name = scene["scene"].as_str().expect("a name");
        assert!(count("grids") > 0 && count("micropolygons") > 300, "{name}: {scene}");
        let hits = count("sample_hits");
        // A third of the picture at the least, and no more tests than hits are worth.
        assert!(hits * 8 > count("samples") && hits < count("sample_tests"), "{name}: {scene}");
        let ste = scene["ste"].as_f64().expect("STE");
        assert!((0.005..1.0).contains(&ste), "{name}: {scene}");
        for stage in ["read", "connect", "split", "dice", "cull", "shade", "sample", "resolve", "total"] {
            assert!(scene["seconds"][stage].as_f64().expect("seconds") >= 0.0, "{name}: {stage}");
        }
        assert!(cfg!(not(target_os = "linux")) || count("peak_memory") > 1_000_000, "{name}");
    }
    assert!(bench.names().is_empty(), "no file is written");
    // Generous: other tests run beside this one, and the profile may be that of debugging.
    assert!(began.elapsed() < Duration::from_secs(120));
}

#[test]
fn runs_count_the_same() {
    let bench = Bench::new();
    let run = |threads| {
        let ran = bench.run(&["bench", "--quick", "--json", "--runs", "2", "-t", threads, "displaced"]);
        let mut all: Value = serde_json::from_str(&ran.out).expect("JSON");
        let scene = all["scenes"][0].as_object_mut().expect("a scene");
        for field in ["seconds", "peak_memory", "micropolygons_per_second", "samples_per_second", "threads"] {
            assert!(scene.remove(field).is_some(), "{field}");
        }
        all["scenes"].take()
    };
    assert_eq!(run("1"), run("2"));
}

#[test]
fn the_table_has_a_line_a_scene() {
    let ran = Bench::new().run(&["bench", "--quick", "--runs", "1", "teapot", "creased"]);
    let names: Vec<&str> = ran.out.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert_eq!(names, ["seconds", "teapot", "creased"], "{}", ran.out);
}

#[test]
fn an_unknown_scene_is_a_usage_error_that_lists_the_known_ones() {
    let ran = Bench::new().run(&["bench", "kettle"]);
    assert_eq!(ran.code, 2);
    for word in ["\"kettle\"", "teapot", "creature-blur", "torus-both-64-1600", "army"] {
        assert!(ran.err.contains(word), "{word}: {}", ran.err);
    }
    assert_eq!(Bench::new().run(&["bench", "--runs", "0"]).code, 2);
}
