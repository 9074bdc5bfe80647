//! Vertices are shaded when something needs them, and have the same colours whoever asks and however often.

use std::sync::{Arc, Mutex};

use glam::Vec3;
use olema::engine::Bench;
use olema::pipeline::shade::{ShadeLists, ShadedGrid, Shader, VertexSet};
use olema::scene::{Attributes, Geometry, Keyed, Origin, PatchKind, PatchMesh, Points, Primitive, Transform};
use olema::shading::{
    Inputs, OpacityUse, PlacedLight, ShadedPoints, ShaderTraits, ShadingPoints, SurfaceShader,
};
use olema::{Scene, Settings};

/// Colours a vertex by its (u, v), and remembers what it was asked for.
#[derive(Debug)]
struct Recorder {
    needs_ring: bool,
    asked: Mutex<Vec<Vec<u32>>>,
}

impl SurfaceShader for Recorder {
    fn name(&self) -> &str {
        "recorder"
    }

    fn traits(&self) -> ShaderTraits {
        let inputs = Inputs { uv: true, ..Inputs::default() };
        ShaderTraits { opacity: OpacityUse::Keeps, pure: true, needs_ring: self.needs_ring, inputs }
    }

    fn shade(
        &self,
        points: &ShadingPoints,
        vertices: &[u32],
        _lights: &[Arc<dyn PlacedLight>],
        out: &mut ShadedPoints,
    ) {
        self.asked.lock().expect("no panic").push(vertices.to_vec());
        for &vertex in vertices {
            let vertex = vertex as usize;
            out.ci.set(vertex, Vec3::new(points.u[vertex], points.v[vertex], 1.0));
        }
    }
}

fn grid(shader: &Arc<Recorder>, opacity: f32) -> ShadedGrid {
    let points = vec![[-1.0, -1.0, 5.0], [1.0, -1.0, 5.0], [-1.0, 1.0, 5.0], [1.0, 1.0, 5.0]];
    let mesh = PatchMesh {
        kind: Arc::new(PatchKind::Bilinear),
        nu: 2,
        nv: 2,
        wrap_u: false,
        wrap_v: false,
        points: Keyed::still(Points::P(points)),
        vars: Vec::new(),
    };
    let mut scene = Scene::new(olema::scene::Camera::default());
    scene.primitives.push(Primitive {
        geometry: Geometry::Patches(Arc::new(mesh)),
        to_world: Transform::default(),
        attributes: Arc::new(Attributes {
            surface: shader.clone(),
            opacity: [opacity; 3],
            shading_rate: 20.0,
            ..Attributes::default()
        }),
        origin: Origin::default(),
    });
    let settings = Settings { resolution: [64, 64], ..Settings::default() };
    let bench = Bench::new(&scene, &settings).expect("a scene");
    let diced = bench.dice(&bench.split()).pop().expect("a grid");
    ShadedGrid::new(diced, shader.as_ref())
}

fn recorder(needs_ring: bool) -> Arc<Recorder> {
    Arc::new(Recorder { needs_ring, asked: Mutex::default() })
}

fn set(vertices: &[usize]) -> VertexSet {
    let mut set = VertexSet::default();
    vertices.iter().for_each(|&vertex| set.insert(vertex));
    set
}

#[test]
fn a_vertex_is_shaded_once_and_looks_as_if_all_were() {
    let (recorder, whole) = (recorder(false), recorder(false));
    let grid = grid(&recorder, 1.0);
    let shader = Shader { surface: recorder.as_ref(), lights: &[] };
    let (all, count) = self::grid(&whole, 1.0).shade_all(Shader { surface: whole.as_ref(), lights: &[] });
    assert_eq!(count.points as usize, grid.grid.num_vertices());

    let (first, count) = grid.shade_some(&set(&[3, 8, 9]), shader, &mut ShadeLists::default());
    assert_eq!((count.points, count.ring), (3, 0));
    let (second, count) = grid.shade_some(&set(&[8, 9, 10]), shader, &mut ShadeLists::default());
    assert_eq!((count.points, count.ring), (1, 0));
    assert_eq!(*recorder.asked.lock().expect("no panic"), [vec![3, 8, 9], vec![10]]);
    for vertex in [3, 8, 9] {
        assert_eq!(first.color[vertex], all.color[vertex]);
        assert_eq!(second.color[vertex], all.color[vertex]);
    }
    assert_eq!(second.color[10], all.color[10]);
    assert_ne!(first.color[10], all.color[10], "colours that were handed out do not change");
}

#[test]
fn a_grid_that_is_shaded_all_over_needs_no_more_than_its_colours() {
    let recorder = recorder(false);
    let grid = grid(&recorder, 1.0);
    let shader = Shader { surface: recorder.as_ref(), lights: &[] };
    let num = grid.grid.num_vertices();
    let (first, last) = ((0..num / 2).collect::<Vec<_>>(), (num / 2..num).collect::<Vec<_>>());
    let (_, count) = grid.shade_some(&set(&first), shader, &mut ShadeLists::default());
    assert_eq!(count.points as usize, num / 2);
    // Half of it is not shaded yet, which is not forgotten.
    grid.let_go_of_points();
    let (colors, count) = grid.shade_some(&set(&last), shader, &mut ShadeLists::default());
    assert_eq!(count.points as usize, num - num / 2);
    grid.let_go_of_points();
    let (again, count) = grid.shade_some(&set(&first), shader, &mut ShadeLists::default());
    assert_eq!((count.points, &again.color), (0, &colors.color));
}

#[test]
fn derivatives_of_computed_values_get_a_ring_that_is_counted_apart() {
    let recorder = recorder(true);
    let grid = grid(&recorder, 1.0);
    let shader = Shader { surface: recorder.as_ref(), lights: &[] };
    let step = grid.grid.m as usize + 1;
    // A corner has two neighbours, an inner vertex four.
    let inner = step + 1;
    let (_, count) = grid.shade_some(&set(&[0]), shader, &mut ShadeLists::default());
    assert_eq!((count.points, count.ring), (3, 2));
    let (_, count) = grid.shade_some(&set(&[inner]), shader, &mut ShadeLists::default());
    assert_eq!((count.points, count.ring), (5, 4));
    let asked = recorder.asked.lock().expect("no panic");
    assert_eq!(asked[0], [0, 1, step as u32]);
    assert_eq!(asked[1], [inner - step, inner - 1, inner, inner + 1, inner + step].map(|v| v as u32));
}

#[test]
fn only_what_is_opaque_by_declaration_waits_for_its_colours() {
    assert!(grid(&recorder(false), 1.0).surely_opaque);
    assert!(!grid(&recorder(false), 0.5).surely_opaque);
}

#[test]
fn what_is_seen_is_counted_once() {
    let grid = grid(&recorder(false), 1.0);
    assert_eq!(
        [
            grid.note_seen(&set(&[1, 70]), &mut ShadeLists::default()),
            grid.note_seen(&set(&[1, 2]), &mut ShadeLists::default()),
            grid.note_seen(&set(&[2]), &mut ShadeLists::default())
        ],
        [2, 1, 0]
    );
    let many = set(&[5, 64, 130]);
    assert_eq!(many.iter().collect::<Vec<_>>(), [5, 64, 130]);
    assert!(many.contains(64) && !many.contains(65) && many.len() == 3 && !many.is_empty());
}
