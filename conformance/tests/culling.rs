//! What is hidden is not drawn, and no bit of a picture tells.

use std::sync::Arc;

use conformance::closed::crack_scene;
use conformance::closed_moving::moving_crack_scene;
use conformance::goldens::bits;
use conformance::moving::{blurred, defocused, driven};
use conformance::occlusion_scenes::{army, city, sticks};
use conformance::scenes::{self, small};
use olema::occlusion::{CullKind, CullOrder, CullPlaces, CullSettings};
use olema::scene::Attributes;
use olema::settings::Shade;
use olema::{Frame, Hooks, Renderer, Scene, Settings};

fn draw(scene: &Scene, settings: &Settings) -> Frame {
    Renderer::new(settings.clone()).expect("valid").render(scene, &Hooks::default()).expect("a picture")
}

fn cull(kind: CullKind, at: &str, leaf_px: u32, slices: u32, order: CullOrder) -> CullSettings {
    CullSettings { kind, at: at.parse().expect("places"), leaf_px, slices, order }
}

/// Nothing is culled, all is shaded.
fn plain(base: Settings) -> Settings {
    Settings {
        cull: CullSettings { kind: CullKind::None, ..CullSettings::default() },
        shade: Shade::All,
        ..base
    }
}

/// Every kind of culling at every place, with other tiles, threads and memory each.
fn variants(base: &Settings) -> Vec<Settings> {
    use CullKind::{None, Slice, Tz, Z};
    use CullOrder::{Auto, Lens, Time};
    let row = |cull, shade, tile, threads, transparency_records, grid_cache| Settings {
        cull,
        shade,
        tile: Some(tile),
        // Odd, prime, 1.
        bucket: [[64, 64], [7, 13], [1, 1]][tile as usize % 3],
        threads,
        transparency_records,
        grid_cache,
        ..base.clone()
    };
    vec![
        row(cull(Tz, "split,dice,shade", 2, 64, Auto), Shade::Visible, 64, 1, 1 << 20, 1 << 28),
        row(cull(Tz, "split", 4, 16, Time), Shade::All, 31, 2, 700, 0),
        row(cull(Tz, "dice", 8, 4, Lens), Shade::Gelato, 17, 1, 1 << 20, 1 << 17),
        row(cull(Tz, "shade", 16, 64, Auto), Shade::Visible, 40, 3, 1 << 20, 1 << 28),
        row(cull(Z, "split,dice,shade", 4, 64, Time), Shade::Gelato, 64, 2, 3000, 1 << 17),
        row(cull(Z, "dice,shade", 2, 1, Auto), Shade::All, 5, 1, 1 << 20, 1 << 28),
        row(cull(Slice, "split,dice,shade", 8, 64, Lens), Shade::All, 64, 1, 700, 1 << 28),
        row(cull(Slice, "split,shade", 2, 16, Auto), Shade::Visible, 23, 2, 3000, 0),
        row(cull(None, "split,dice,shade", 2, 64, Auto), Shade::Visible, 37, 2, 700, 1 << 28),
        row(cull(None, "split,dice,shade", 2, 64, Auto), Shade::Gelato, 1, 1, 1 << 20, 1 << 17),
    ]
}

/// A teapot behind a wall that covers most of it, and in front of a ground.
fn walled() -> Scene {
    let mut scene = scenes::teapot();
    let wall: [[f32; 3]; 4] = [[-3.5, -4.0, -1.0], [2.5, -4.0, -1.0], [-3.5, -4.0, 3.0], [2.5, -4.0, 3.0]];
    scenes::add(&mut scene, scenes::bilinear(wall), glam::DMat4::IDENTITY, &Arc::new(Attributes::default()));
    scene
}

fn all_scenes() -> Vec<(String, Scene)> {
    let mut all: Vec<(String, Scene)> = vec![
        ("walled".into(), walled()),
        ("walled, driven".into(), driven(walled(), [0.4, 0.0, 0.1], 0.2)),
        ("walled, defocused".into(), defocused(walled(), 4.0, 6.0)),
        ("walled, both".into(), defocused(driven(walled(), [0.4, 0.0, 0.1], 0.2), 4.0, 6.0)),
        ("layers, still".into(), scenes::layers()),
        ("coplanar".into(), scenes::coplanar()),
        ("ground".into(), scenes::ground()),
        ("teapot from inside".into(), scenes::teapot_from_inside()),
        ("displaced, still".into(), scenes::displaced()),
    ];
    all.extend(blurred().into_iter().map(|(name, scene)| (name.to_owned(), scene)));
    all.extend((0..3).map(|seed| (format!("closed {seed}"), crack_scene(seed))));
    all.extend((0..4).map(|seed| (format!("closed and moving {seed}"), moving_crack_scene(seed))));
    all
}

/// Draws all scenes with all variants, and adds up what was hidden at the places that each variant asks at.
fn compare(scenes: &[(String, Scene)], size: [u32; 2], samples: [u32; 2], step: usize) -> Vec<[u64; 3]> {
    let base = small(size[0], size[1], samples);
    let mut hidden = vec![[0; 3]; variants(&base).len()];
    for (number, (name, scene)) in scenes.iter().enumerate() {
        let expected = bits(&draw(scene, &plain(base.clone())).image);
        for (ix, variant) in variants(&base).iter().enumerate().skip(number % step).step_by(step) {
            let frame = draw(scene, variant);
            assert!(bits(&frame.image) == expected, "{name}: {:?} {}", variant.cull, variant.shade);
            let occlusion = frame.stats.occlusion;
            let here = [occlusion.split.hidden, occlusion.dice.hidden, occlusion.shade.hidden];
            hidden[ix].iter_mut().zip(here).for_each(|(sum, here)| *sum += here);
        }
    }
    hidden
}

fn check_hidden(hidden: &[[u64; 3]], size: [u32; 2]) {
    for (variant, hidden) in variants(&small(size[0], size[1], [2, 2])).iter().zip(hidden) {
        let CullPlaces { split, dice, shade } = variant.cull.at;
        let asked = variant.cull.kind != CullKind::None;
        // Large pieces are only met in large tiles.
        let may_split = split && variant.tile.is_some_and(|tile| tile >= 31);
        // What is asked for twice is rarely hidden the second time only.
        let expected = [asked && may_split, asked && dice, asked && shade && !dice];
        for (place, (expected, &hidden)) in expected.into_iter().zip(hidden).enumerate() {
            assert!(!expected || hidden > 0, "nothing hidden at place {place}: {:?}", variant.cull);
        }
        assert!(asked || hidden == &[0; 3]);
    }
}

#[test]
fn culling_changes_no_bit() {
    let hidden = compare(&all_scenes(), [48, 36], [2, 2], 3);
    println!("{hidden:?}");
    check_hidden(&hidden, [48, 36]);
}

#[test]
fn culling_changes_no_bit_of_crowds_in_motion() {
    let crowds = [("army", army(350.0)), ("sticks", sticks(40.0)), ("city", city(10.0))];
    let crowds: Vec<(String, Scene)> = crowds.map(|(name, scene)| (name.to_owned(), scene)).into();
    let hidden = compare(&crowds, [48, 27], [4, 4], 5);
    println!("{hidden:?}");
    assert!(hidden.iter().map(|at| at.iter().sum::<u64>()).sum::<u64>() > 0);
}

/// The comparison would notice what is wrongly hidden.
#[test]
fn a_picture_without_its_wall_is_another() {
    let base = small(64, 48, [2, 2]);
    assert!(bits(&draw(&walled(), &base).image) != bits(&draw(&scenes::teapot(), &base).image));
}

#[test]
fn only_what_is_visible_is_shaded() {
    let base = Settings { tile: Some(16), threads: 2, ..small(64, 48, [3, 3]) };
    for (name, scene) in [("still", walled()), ("driven", driven(walled(), [0.4, 0.0, 0.1], 0.2))] {
        let counts = |shade| draw(&scene, &Settings { shade, ..base.clone() }).stats;
        let [visible, gelato, all] = [Shade::Visible, Shade::Gelato, Shade::All].map(counts);
        assert_eq!(visible.shaded_points, visible.visible_points, "{name}: tiles share what they shade");
        assert_eq!(visible.visible_points, all.visible_points, "{name}");
        assert_eq!(visible.visible_points, gelato.visible_points, "{name}");
        assert!(visible.shaded_points < gelato.shaded_points && gelato.shaded_points <= all.shaded_points);
        assert!(all.shaded_points <= all.diced_points, "{name}");
    }
}

#[test]
fn what_is_hidden_is_not_diced() {
    let base = Settings { tile: Some(32), ..small(64, 48, [2, 2]) };
    let none = draw(&walled(), &plain(base.clone())).stats;
    let culled = draw(&walled(), &base).stats;
    assert!(
        culled.diced_points * 10 < none.diced_points * 9,
        "{} of {}",
        culled.diced_points,
        none.diced_points
    );
    assert!(culled.occlusion.pyramid_bytes > 0 && none.occlusion == Default::default());
}
