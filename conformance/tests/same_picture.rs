//! Settings that must not matter do not matter, bit for bit.

use conformance::goldens::bits;
use conformance::scenes::{self, small};
use olema::settings::Memory;
use olema::{Hooks, Image, Renderer, Scene, Settings};

fn draw(scene: &Scene, settings: &Settings) -> Image {
    Renderer::new(settings.clone())
        .expect("valid settings")
        .render(scene, &Hooks::default())
        .expect("a picture")
        .image
}

/// Settings that change speed, memory and order only: a pairwise covering set.
fn variants(base: &Settings) -> Vec<Settings> {
    let row = |threads, bucket, tile, transparency_records, grid_cache| {
        (threads, bucket, tile, transparency_records, grid_cache)
    };
    [
        row(1, [64, 64], Some(64), 1 << 20, 1 << 30),
        row(2, [1, 1], Some(8), 1 << 20, 0),
        row(3, [7, 13], Some(6), 3000, 1 << 30),
        row(2, [1000, 3], Some(1000), 700, 0),
        row(1, [17, 1], Some(10), 3000, 1 << 18),
        row(4, [64, 64], None, 700, 1 << 18),
        row(3, [1, 31], Some(64), 700, 1 << 18),
        row(2, [5, 5], Some(2), 1 << 20, 1 << 18),
    ]
    .map(|(threads, bucket, tile, transparency_records, grid_cache)| Settings {
        threads,
        bucket,
        tile,
        transparency_records,
        grid_cache,
        ..base.clone()
    })
    .to_vec()
}

fn test_scenes() -> Vec<(&'static str, Scene)> {
    vec![
        ("teapot", scenes::teapot()),
        ("teapot through the near plane", scenes::teapot_through_near_plane()),
        ("teapot from inside", scenes::teapot_from_inside()),
        ("layers", scenes::layers()),
        ("ground to the horizon", scenes::ground()),
        ("coplanar", scenes::coplanar()),
        ("displaced", scenes::displaced()),
    ]
}

#[test]
fn threads_buckets_tiles_and_memory_do_not_change_the_picture() {
    for (name, scene) in test_scenes() {
        let base = small(64, 48, [3, 3]);
        let expected = bits(&draw(&scene, &base));
        for variant in variants(&base) {
            assert!(bits(&draw(&scene, &variant)) == expected, "{name}: {variant:?}");
        }
    }
}

#[test]
fn a_crop_is_that_part_of_the_whole() {
    for (name, scene) in test_scenes() {
        let base = small(64, 48, [2, 2]);
        let whole = draw(&scene, &base);
        for crop in [[0, 64, 0, 1], [13, 29, 7, 48], [63, 64, 47, 48], [31, 40, 20, 21]] {
            let part = draw(&scene, &Settings { crop_px: Some(crop), tile: Some(8), ..base.clone() });
            assert!(bits(&whole.part(crop)) == bits(&part), "{name}: {crop:?}");
        }
    }
}

#[test]
fn nothing_of_that_changes_a_blurred_picture() {
    for (name, scene) in conformance::moving::blurred() {
        let base = small(48, 36, [2, 2]);
        let expected = bits(&draw(&scene, &base));
        for variant in variants(&base).into_iter().step_by(2) {
            assert!(bits(&draw(&scene, &variant)) == expected, "{name}: {variant:?}");
        }
    }
}

#[test]
fn a_crop_is_that_part_of_a_blurred_whole() {
    for (name, scene) in conformance::moving::blurred() {
        let base = small(64, 48, [2, 2]);
        let whole = draw(&scene, &base);
        for crop in [[0, 64, 0, 1], [13, 29, 7, 48], [63, 64, 47, 48], [31, 40, 20, 21]] {
            let part = draw(&scene, &Settings { crop_px: Some(crop), tile: Some(8), ..base.clone() });
            assert!(bits(&whole.part(crop)) == bits(&part), "{name}: {crop:?}");
        }
    }
}

#[test]
fn buckets_that_are_delivered_make_up_the_picture() {
    let scene = scenes::teapot();
    let settings = Settings { bucket: [11, 7], threads: 2, tile: Some(10), ..small(64, 48, [2, 2]) };
    let collected = std::sync::Mutex::new(Image::new([64, 48], [0, 64, 0, 48], &["r", "g", "b", "a", "z"]));
    let take = |bucket: &Image| {
        let [x0, x1, y0, y1] = bucket.window_px;
        let mut all = collected.lock().expect("no panic");
        for (c, channel) in bucket.channels.iter().enumerate() {
            for (row, y) in (y0..y1).enumerate() {
                let width = (x1 - x0) as usize;
                let first = y as usize * 64 + x0 as usize;
                all.channels[c].values[first..first + width]
                    .copy_from_slice(&channel.values[row * width..(row + 1) * width]);
            }
        }
    };
    let hooks = Hooks { bucket: Some(&take), ..Hooks::default() };
    let frame = Renderer::new(settings).expect("valid").render(&scene, &hooks).expect("a picture");
    assert!(bits(&collected.into_inner().expect("no panic")) == bits(&frame.image));
}

#[test]
fn rows_that_are_handed_out_make_up_the_picture() {
    let scene = scenes::teapot();
    for (threads, tile, crop_px) in [(1, 16, None), (2, 10, None), (2, 7, Some([5, 60, 11, 40]))] {
        let settings = Settings { threads, tile: Some(tile), crop_px, ..small(64, 48, [2, 2]) };
        let expected = draw(&scene, &settings);
        let mut collected = Image { channels: Vec::new(), ..expected.clone() };
        let mut next = expected.window_px[2];
        let mut take = |rows: &Image| {
            assert_eq!(
                (rows.window_px[2], rows.width()),
                (next, expected.width()),
                "from the top, whole rows"
            );
            next = rows.window_px[3];
            collected.channels.resize_with(rows.channels.len(), || rows.channels[0].clone());
            for (all, more) in collected.channels.iter_mut().zip(&rows.channels) {
                if rows.window_px[2] == expected.window_px[2] {
                    all.values.clear();
                    all.name.clone_from(&more.name);
                }
                all.values.extend(&more.values);
            }
        };
        let renderer = Renderer::new(settings).expect("valid");
        renderer.render_rows(scene.clone(), &Hooks::default(), &mut take).expect("rows");
        assert!(next == expected.window_px[3] && bits(&collected) == bits(&expected), "tiles of {tile}");
    }
}

#[test]
fn another_seed_is_another_picture() {
    let scene = scenes::teapot();
    let base = small(64, 48, [2, 2]);
    let other = Settings { seed: 1, ..base.clone() };
    assert!(bits(&draw(&scene, &base)) != bits(&draw(&scene, &other)), "the comparison cannot fail");
}

#[test]
fn counts_do_not_depend_on_threads() {
    let scene = scenes::teapot();
    let count = |threads| {
        let settings = Settings { threads, tile: Some(16), ..small(64, 48, [2, 2]) };
        let frame =
            Renderer::new(settings).expect("valid").render(&scene, &Hooks::default()).expect("a picture");
        frame.stats
    };
    let (one, three) = (count(1), count(3));
    assert_eq!(one, three);
    assert!(one.sample_hits > 0 && one.grids > 0);
}

#[test]
fn a_render_can_be_cancelled() {
    let cancel = olema::CancelToken::default();
    cancel.cancel();
    let hooks = Hooks { cancel: Some(&cancel), ..Hooks::default() };
    let result = Renderer::new(small(64, 48, [2, 2])).expect("valid").render(&scenes::teapot(), &hooks);
    assert_eq!(result.err(), Some(olema::Error::Cancelled));
}

#[test]
fn a_budget_of_memory_changes_the_work_and_not_the_picture() {
    let drawn = |scene: &Scene, budget: u64| {
        let mut settings = Settings { tile: Some(8), ..small(64, 48, [3, 3]) };
        Memory::divide(budget).limit(&mut settings, 1);
        let frame = Renderer::new(settings).expect("valid settings").render(scene, &Hooks::default());
        let frame = frame.expect("a picture");
        (bits(&frame.image), frame.stats)
    };
    let (mut again, mut peels) = (0, 0);
    for (name, scene) in test_scenes() {
        // The least that the picture itself fits in.
        let ((tiny, made), (large, kept)) = (drawn(&scene, 256 << 10), drawn(&scene, 1 << 30));
        assert!(tiny == large, "{name}");
        assert_eq!((kept.grids_again, kept.peels), (0, 0), "{name}");
        (again, peels) = (again + made.grids_again, peels + made.peels);
    }
    assert!(again > 0 && peels > 0, "{again} grids again, {peels} passes");
}
