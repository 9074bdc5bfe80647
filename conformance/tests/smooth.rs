//! Where a surface is said to go on smoothly, the normals of all patches that meet there agree.

use conformance::closed::{Kind, crack_scene, scene};
use conformance::creature::tube;
use olema::Scene;
use olema::pipeline::connect::connect;
use olema::pipeline::motion::KeyTimes;
use olema::pipeline::patch::{CORNER_UV, Surfaces, side_uv};
use olema::pipeline::patchify::patchify;
use olema::pipeline::piece::parameter;
use olema::pipeline::rate::Fineness;

/// Edges and corners that are smooth, and how many of those and of the others have normals more than a degree apart.
#[derive(Debug, Default)]
struct Found {
    smooth: [usize; 2],
    apart: [usize; 2],
    others_apart: [usize; 2],
}

impl Found {
    fn add(&mut self, kind: usize, is_smooth: bool, normals: &[[f32; 3]]) {
        let agree = |a: &[f32; 3], b: &[f32; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f32>() > 0.99985;
        let is_apart = normals.windows(2).any(|pair| !agree(&pair[0], &pair[1]));
        self.smooth[kind] += usize::from(is_smooth);
        self.apart[kind] += usize::from(is_smooth && is_apart);
        self.others_apart[kind] += usize::from(!is_smooth && is_apart);
    }

    fn look(&mut self, scene: &Scene) {
        let rate = Fineness { shading_rate: 1.0, motion_factor: 0.0, focus_factor: 0.0 };
        let (mut table, _) = patchify(scene, &KeyTimes::still(scene));
        let mut edges = connect(&mut table, &vec![rate; scene.primitives.len()]);
        edges.list_users(&table, |_| 1.0);
        let surfaces = Surfaces::new(&table);
        let (mut at_edges, mut at_corners) =
            (vec![Vec::new(); edges.edges.len()], vec![Vec::new(); edges.corners.len()]);
        for (ix, patch) in (0u32..).zip(&table.patches) {
            for (n, corner_uv) in CORNER_UV.into_iter().enumerate() {
                let (used, corner) = (patch.edges[n], patch.corners[n] as usize);
                for numerator in [3, 8, 13].into_iter().filter(|&n| used.along.has(n, 16)) {
                    let (along, denominator) = used.along.own(numerator, 16);
                    let uv = side_uv(n, parameter(along, denominator));
                    at_edges[used.edge as usize].push((numerator, surfaces.normal(ix, 0, uv).to_array()));
                }
                at_corners[corner].push(surfaces.normal(ix, 0, corner_uv).to_array());
            }
        }
        for (normals, edge) in at_edges.iter().zip(0..) {
            for place in [3, 8, 13] {
                let there: Vec<_> =
                    normals.iter().filter(|(n, _)| *n == place).map(|(_, normal)| *normal).collect();
                self.add(0, edges.edge_users(edge).is_none(), &there);
            }
        }
        for (normals, corner) in at_corners.iter().zip(0..) {
            self.add(1, edges.corner_users(corner).is_none(), normals);
        }
    }
}

#[test]
fn normals_agree_where_a_surface_is_smooth_and_elsewhere_some_do_not() {
    let mut meshes = Found::default();
    // Every third one is made of patches.
    (0..90).filter(|seed| seed % 3 != 2).for_each(|seed| meshes.look(&crack_scene(seed)));
    assert!(meshes.smooth[0] > 1000 && meshes.smooth[1] > 300, "{meshes:?}");
    assert_eq!(meshes.apart, [0, 0], "{meshes:?}");
    assert!(meshes.others_apart[0] > 100 && meshes.others_apart[1] > 15, "{meshes:?}");
}

#[test]
fn sheets_of_splines_are_smooth_and_bezier_patches_are_not_known_to_be() {
    let mut spline = Found::default();
    spline.look(&tube(24, 9));
    // Three places an edge; the tube has no border.
    assert_eq!((spline.smooth, spline.apart), ([3 * 2 * 24 * 9, 24 * 9], [0, 0]), "{spline:?}");
    let mut bezier = Found::default();
    (0..6).for_each(|seed| bezier.look(&scene(Kind::CubeOfPatches, seed)));
    assert_eq!(bezier.smooth, [0, 0], "{bezier:?}");
}
