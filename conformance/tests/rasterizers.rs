//! All rasterizers draw the same picture, bit for bit, whatever moves and however blurred it is.

use conformance::moving::{blurred, driven};
use conformance::scenes::{self, small};
use olema::sampling::Rasterizer;
use olema::{Error, Frame, Hooks, Renderer, Scene, Settings};

fn draw(scene: &Scene, settings: &Settings) -> Frame {
    let renderer = Renderer::new(settings.clone()).expect("valid settings");
    renderer.render(scene, &Hooks::default()).expect("a picture")
}

fn bits(frame: &Frame) -> Vec<u32> {
    conformance::goldens::bits(&frame.image)
}

const BLURRED: [Rasterizer; 3] = [Rasterizer::Interval, Rasterizer::InterleaveUvt, Rasterizer::BoundingBox];

#[test]
fn blurred_scenes_are_the_same_picture() {
    for (name, scene) in blurred() {
        let base = small(64, 48, [2, 2]);
        let expected = draw(&scene, &base);
        assert!(expected.stats.sample_hits > 0, "{name}");
        for (ix, rasterizer) in BLURRED.into_iter().enumerate() {
            let settings = Settings {
                rasterizer,
                threads: ix + 1,
                tile: [None, Some(6), Some(64)][ix],
                bucket: [[64, 64], [7, 5], [1, 64]][ix],
                grid_cache: [0, 1 << 18, 1 << 28][ix],
                ..base.clone()
            };
            assert!(bits(&draw(&scene, &settings)) == bits(&expected), "{name}: {settings:?}");
        }
    }
}

#[test]
fn with_one_tuple_a_stratum_simple_is_the_same_picture_too() {
    for (name, scene) in blurred() {
        let base = Settings { pattern_tile: Some(1), ..small(48, 36, [2, 2]) };
        let expected = draw(&scene, &Settings { rasterizer: Rasterizer::Interval, ..base.clone() });
        let simple = draw(&scene, &Settings { rasterizer: Rasterizer::Simple, tile: Some(7), ..base });
        assert!(bits(&simple) == bits(&expected), "{name}");
    }
}

#[test]
fn still_scenes_are_the_same_picture_for_all() {
    for (name, scene) in [("teapot", scenes::teapot()), ("layers", scenes::layers())] {
        let base = small(64, 48, [2, 2]);
        let expected = draw(&scene, &Settings { rasterizer: Rasterizer::NoMotion, ..base.clone() });
        for rasterizer in BLURRED {
            let drawn = draw(&scene, &Settings { rasterizer, ..base.clone() });
            assert!(bits(&drawn) == bits(&expected), "{name}: {rasterizer:?}");
        }
    }
}

#[test]
fn nomotion_refuses_what_moves() {
    let scene = driven(scenes::teapot(), [1.0, 0.0, 0.0], 0.0);
    let settings = Settings { rasterizer: Rasterizer::NoMotion, ..small(16, 12, [1, 1]) };
    let refused = Renderer::new(settings).expect("valid").render(&scene, &Hooks::default());
    assert!(matches!(refused, Err(Error::Setting { what: "rasterizer", .. })));
}

#[test]
fn another_path_is_another_picture() {
    let of = |x: f64| bits(&draw(&driven(scenes::teapot(), [x, 0.0, 0.0], 0.0), &small(64, 48, [2, 2])));
    assert!(of(0.5) != of(0.51), "the comparison cannot fail");
}
