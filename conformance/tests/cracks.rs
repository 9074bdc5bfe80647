//! Closed surfaces made of patches have no cracks, at no sample.

use conformance::closed::{KINDS, Kind, Random, displace, mesh_scene, scene, subdivision_scene};
use conformance::cracks::signed_hits;
use conformance::scenes::small;

#[test]
fn closed_surfaces_are_hit_as_often_from_the_front_as_from_the_back() {
    let mut covered = 0;
    let mut welds = 0;
    for kind in KINDS {
        for seed in 0..40 {
            let report =
                signed_hits(&scene(kind, seed), &small(96, 96, [4, 4]), None).expect("a correct scene");
            assert_eq!(report.cracked, 0, "{kind:?} {seed}: {report:?}");
            assert!(report.covered > 1000, "{kind:?} {seed} is hardly in the picture: {report:?}");
            covered += report.covered;
            welds += report.welds;
        }
    }
    assert!(covered > 1_000_000 && welds > 1000, "{covered} samples, {welds} welds");
}

#[test]
fn closed_subdivision_surfaces_have_no_cracks() {
    let mut covered = 0;
    for seed in 0..60 {
        let report =
            signed_hits(&subdivision_scene(seed), &small(80, 80, [4, 4]), None).expect("a correct scene");
        assert_eq!(report.cracked, 0, "{seed}: {report:?}");
        covered += report.covered;
    }
    assert!(covered > 500_000, "{covered} samples");
}

#[test]
fn closed_named_meshes_have_no_cracks() {
    use conformance::shapes;
    use olema::scene::Scheme;
    let meshes = [
        ("cube", shapes::cube()),
        ("tetrahedron", shapes::tetrahedron(Scheme::CatmullClark)),
        ("loop tetrahedron", shapes::tetrahedron(Scheme::Loop)),
        ("bilinear tetrahedron", shapes::tetrahedron(Scheme::Bilinear)),
        ("icosahedron", shapes::icosahedron(Scheme::Loop)),
        ("torus", shapes::torus(5, 4)),
        ("pyramid", shapes::pyramid(2.5)),
        ("sharp pyramid", shapes::pyramid(10.0)),
        ("prism", shapes::prism(7)),
        ("poles", shapes::poles(50, Scheme::CatmullClark)),
    ];
    for (name, mesh) in meshes {
        let scene = mesh_scene(mesh, &mut Random::new(7));
        let report = signed_hits(&scene, &small(80, 80, [4, 4]), None).expect("a correct scene");
        assert_eq!(report.cracked, 0, "{name}: {report:?}");
        assert!(report.covered > 1000, "{name}: {report:?}");
    }
}

#[test]
fn displaced_surfaces_have_no_cracks() {
    let mut covered = 0;
    for seed in 0..40 {
        let mut scene = if seed % 2 == 0 {
            subdivision_scene(seed)
        } else {
            scene(KINDS[seed as usize / 2 % KINDS.len()], seed)
        };
        displace(&mut scene, seed, 0.4);
        let report = signed_hits(&scene, &small(72, 72, [4, 4]), None).expect("a correct scene");
        assert_eq!(report.cracked, 0, "{seed}: {report:?}");
        covered += report.covered;
    }
    assert!(covered > 300_000, "{covered} samples");
}

#[test]
fn moving_and_defocused_surfaces_have_no_cracks() {
    use conformance::closed_moving::moving_crack_scene;
    use conformance::cracks::CrackReport;
    use olema::Settings;
    use olema::sampling::Rasterizer;
    let rasterizers = [Rasterizer::Auto, Rasterizer::InterleaveUvt, Rasterizer::Interval];
    let mut total = CrackReport::default();
    for seed in 0..60 {
        let rasterizer = rasterizers[seed as usize % 3];
        let (samples, pattern_tile) =
            [([4, 4], None), ([3, 3], Some(3)), ([2, 2], Some(4))][seed as usize / 3 % 3];
        let settings = Settings { rasterizer, pattern_tile, ..small(64, 64, samples) };
        let report = signed_hits(&moving_crack_scene(seed), &settings, None).expect("a correct scene");
        assert_eq!(report.cracked, 0, "{seed}: {report:?}");
        assert!(report.covered > 300, "{seed} is hardly in the picture: {report:?}");
        total.add(&report);
    }
    println!("{total:?}");
    assert!(total.covered > 300_000, "{total:?}");
    assert!(total.moving > 3_000 && total.keys > 3 * total.moving && total.defocused > 1000, "{total:?}");
    assert!(total.by_interval > 1000 && total.by_interleave > 1000, "{total:?}");
}

#[test]
fn key_times_that_differ_along_an_edge_are_seen() {
    use conformance::closed_moving::moving_crack_scene;
    use conformance::cracks::Broken;
    use olema::pipeline::piece::Sabotage;
    // Every second surface is made of patches; of those, some are a single primitive.
    let cracked = |seed: &u32| {
        let broken = Some(Broken::Rule(Sabotage::KeyTimes));
        signed_hits(&moving_crack_scene(*seed), &small(64, 64, [4, 4]), broken).expect("a scene").cracked > 0
    };
    let seen = (0..80).step_by(2).filter(cracked).count();
    assert!(seen > 5, "{seen} of 40 crack");
}

/// Each rule is broken on scenes that need it; over a few of them cracks must show.
#[test]
fn every_broken_rule_is_seen() {
    use conformance::closed::crack_scene;
    use conformance::cracks::Broken;
    use olema::pipeline::piece::Sabotage;
    let rules = [
        Broken::Ties,
        Broken::Rule(Sabotage::Snap),
        Broken::Rule(Sabotage::Owner),
        Broken::Rule(Sabotage::Rate),
        Broken::Rule(Sabotage::Width),
        Broken::Rule(Sabotage::Normal),
        Broken::Rule(Sabotage::Middle),
        Broken::Rule(Sabotage::EstimatedNormals),
    ];
    for broken in rules {
        let cracked: u64 = (0..24)
            .map(|seed| {
                signed_hits(&crack_scene(seed), &small(64, 64, [4, 4]), Some(broken))
                    .expect("a scene")
                    .cracked
            })
            .sum();
        assert!(cracked > 0, "{broken:?} goes unnoticed");
    }
}

#[test]
fn a_missing_patch_is_seen() {
    let mut open = scene(Kind::Box, 1);
    open.primitives.pop();
    let report = signed_hits(&open, &small(96, 96, [4, 4]), None).expect("a correct scene");
    assert!(report.cracked > 0, "the test cannot fail: {report:?}");
}

#[test]
fn a_patch_that_is_a_little_off_is_seen() {
    // Farther than the weld tolerance: two edges that are diced on their own.
    let mut torn = scene(Kind::CubeOfPatches, 3);
    torn.primitives[0].to_world =
        olema::scene::Transform::still(glam::DMat4::from_translation(glam::DVec3::splat(2e-2)));
    let report = signed_hits(&torn, &small(96, 96, [4, 4]), None).expect("a correct scene");
    assert!(report.cracked > 0, "the test cannot fail: {report:?}");
}
