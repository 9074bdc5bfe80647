//! The crack test: on a closed surface every sample is hit from the front as often as from the back.
//!
//! In: a scene whose surfaces are closed and consistently oriented, in front of the camera; they may move and be
//! out of focus. Out: for every sample of the picture the signed count of hits at its time and lens place, which
//! must be zero. Folds, self-intersections and double hits cannot fool it.

use olema::engine::grids;
use olema::geometry::subdivision::{EdgeKind, LimitSurface};
use olema::pipeline::piece::{PieceKind, Sabotage};
use olema::pipeline::sample::DrawContext;
use olema::pipeline::waiting::RasterLists;
use olema::pipeline::{Grid, Piece};
use olema::sampling::inside::edge;
use olema::sampling::inside::{HitPoint, Weights};
use olema::sampling::moving::Extent;
use olema::sampling::nomotion::{Facing, HitSink, SampleCounts};
use olema::sampling::{Kernels, Micropolygons, MovingDraw, Rasterizer, Region, RegionSamples};
use olema::scene::Geometry;
use olema::{Error, Scene, Settings};

/// What the test saw.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct CrackReport {
    /// Samples that something hit.
    pub covered: u64,
    /// Samples whose signed count is not zero.
    pub cracked: u64,
    /// Grids drawn.
    pub grids: u64,
    /// Edges that two or more patches share.
    pub welds: u64,
    /// Sides of grids with another number of segments than their edge has.
    pub unequal: u64,
    /// Corners of base quads where other than four of them meet.
    pub extraordinary: u64,
    /// Sides of base quads that are creases, of any sharpness.
    pub creases: u64,
    /// Sides of grids that are a single point.
    pub poles: u64,
    /// Grids that are blocks of a larger lattice.
    pub blocks: u64,
    /// Grids with more than one motion key.
    pub moving: u64,
    /// Motion keys of those.
    pub keys: u64,
    /// Grids that are out of focus.
    pub defocused: u64,
    /// Grids that Interval drew.
    pub by_interval: u64,
    /// Grids that InterleaveUvt drew.
    pub by_interleave: u64,
}

impl CrackReport {
    /// Adds another report to this one.
    pub fn add(&mut self, other: &CrackReport) {
        self.covered += other.covered;
        self.cracked += other.cracked;
        self.grids += other.grids;
        self.welds += other.welds;
        self.unequal += other.unequal;
        self.extraordinary += other.extraordinary;
        self.creases += other.creases;
        self.poles += other.poles;
        self.blocks += other.blocks;
        self.moving += other.moving;
        self.keys += other.keys;
        self.defocused += other.defocused;
        self.by_interval += other.by_interval;
        self.by_interleave += other.by_interleave;
    }

    fn count_piece(&mut self, piece: &Piece, grid: &Grid) {
        let PieceKind::Lattice { m, n, i, j } = piece.kind else { return };
        self.grids += 1;
        self.blocks += u64::from(i != [0, m] || j != [0, n]);
        if grid.keys > 1 {
            self.moving += 1;
            self.keys += u64::from(grid.keys);
        }
        self.defocused += u64::from(!grid.on_raster.coc.is_empty());
        let lines = [m, n, m, n];
        self.unequal += piece
            .sides
            .iter()
            .zip(lines)
            .filter(|(side, lines)| side.segments() != u32::from(*lines))
            .count() as u64;
        let (columns, rows) = (grid.m as usize, grid.n as usize);
        let at = |i: usize, j: usize| j * (columns + 1) + i;
        let RasterLists { x, y, .. } = &grid.on_raster;
        let is_point =
            |vertices: Vec<usize>| vertices.windows(2).all(|v| x[v[0]] == x[v[1]] && y[v[0]] == y[v[1]]);
        let sides = [
            (0..=columns).map(|i| at(i, 0)).collect(),
            (0..=rows).map(|j| at(columns, j)).collect(),
            (0..=columns).map(|i| at(i, rows)).collect(),
            (0..=rows).map(|j| at(0, j)).collect::<Vec<usize>>(),
        ];
        self.poles +=
            sides.into_iter().filter(|side| side.len() > 2 && is_point(side.clone())).count() as u64;
    }

    fn count_meshes(&mut self, scene: &Scene) {
        for primitive in &scene.primitives {
            let Geometry::Subdivision(mesh) = &primitive.geometry else { continue };
            let (surface, _) = LimitSurface::new(mesh.clone());
            let mut meets = std::collections::HashMap::new();
            for quad in 0..surface.num_quads() as u32 {
                let quad = surface.quad(quad);
                quad.corners.iter().for_each(|corner| *meets.entry(*corner).or_insert(0) += 1);
                let sharp = |e: &&olema::geometry::subdivision::EdgeRef| e.kind != EdgeKind::Smooth;
                self.creases += quad.edges.iter().filter(sharp).count() as u64;
            }
            self.extraordinary += meets.values().filter(|count| **count != 4).count() as u64;
        }
    }
}

/// What is broken on purpose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Broken {
    /// A rule of the pipeline.
    Rule(Sabotage),
    /// Samples on an edge count for both of its sides.
    Ties,
}

struct SignedCounts {
    sum: Vec<i32>,
    hits: Vec<u32>,
}

impl HitSink for SignedCounts {
    fn hit(&mut self, sample_ix: usize, _point: HitPoint, _triangle: u8, sign: i8) {
        self.sum[sample_ix] += i32::from(sign);
        self.hits[sample_ix] += 1;
    }
}

/// Draws all of `scene` without culling, as the engine does, and counts signed hits.
///
/// # Errors
/// What the scene or the settings are wrong about.
///
/// # Panics
/// Where something reaches the near plane or the guard band: the test is for what is seen whole.
pub fn signed_hits(scene: &Scene, settings: &Settings, broken: Option<Broken>) -> Result<CrackReport, Error> {
    let [width, height] = settings.resolution.map(|px| px as i32);
    let region = Region::new(0, width, 0, height);
    let mut drawn: Option<(RegionSamples, SignedCounts)> = None;
    let mut report = CrackReport::default();
    let sabotage = if let Some(Broken::Rule(rule)) = broken { Some(rule) } else { None };
    let stats = grids(scene, settings, sabotage, |piece, grid, _, context| {
        assert!(!grid.has_slow(), "a vertex at the near plane or beyond the guard band");
        report.count_piece(piece, grid);
        let (samples, counts) = drawn.get_or_insert_with(|| {
            let samples = RegionSamples::new(context.pattern, region);
            let counts = SignedCounts { sum: vec![0; samples.len()], hits: vec![0; samples.len()] };
            (samples, counts)
        });
        if broken == Some(Broken::Ties) {
            rasterize_inclusive(context, grid, samples, counts);
            return;
        }
        let mut room = RasterLists::default();
        let draw = MovingDraw {
            grid: context.moving(grid, &mut room),
            pattern: context.pattern,
            samples,
            facing: Facing::Any,
            skip: None,
            micropolygons: Micropolygons::Quads,
            times: MovingDraw::ALL_TIMES,
            kernels: Kernels::default(),
        };
        let by = context.rasterizer.rasterize(&draw, &mut SampleCounts::default(), counts);
        report.by_interval += u64::from(by == Ok(Rasterizer::Interval));
        report.by_interleave += u64::from(by == Ok(Rasterizer::InterleaveUvt));
    })?;
    report.count_meshes(scene);
    report.welds = stats.welds;
    if let Some((_, counts)) = drawn {
        report.covered = counts.hits.iter().filter(|&&h| h > 0).count() as u64;
        report.cracked = counts.sum.iter().filter(|&&s| s != 0).count() as u64;
    }
    Ok(report)
}

/// Whether a mesh is closed and consistently oriented: every edge has a face on either side, in opposite
/// directions, and none is a hole.
pub fn is_closed(mesh: &olema::scene::SubdivisionMesh) -> bool {
    let mut directions = std::collections::HashMap::new();
    let mut corners = mesh.indices.iter();
    for &count in &mesh.face_vertex_counts {
        let face: Vec<i32> = corners.by_ref().take(usize::try_from(count).unwrap_or(0)).copied().collect();
        for (ix, &from) in face.iter().enumerate() {
            let to = face[(ix + 1) % face.len()];
            let sign = if from < to { 1 } else { -1 };
            let entry: &mut [i32; 2] = directions.entry((from.min(to), from.max(to))).or_default();
            *entry = [entry[0] + 1, entry[1] + sign];
        }
    }
    mesh.holes.is_empty() && !directions.is_empty() && directions.values().all(|d| *d == [2, 0])
}

/// A rasterizer without a tie rule: a sample on an edge is inside of both triangles.
fn rasterize_inclusive(
    context: &DrawContext,
    grid: &Grid,
    samples: &RegionSamples,
    counts: &mut SignedCounts,
) {
    let mut room = RasterLists::default();
    let moving = context.moving(grid, &mut room);
    let per_pixel = samples.samples_per_pixel();
    let last_time = context.pattern.tuples().iter().map(|tuple| tuple.t15).max().unwrap_or(0);
    let all_times = [0, last_time].map(|t15| moving.times.locate(t15));
    for micropolygon in 0..grid.num_micropolygons() {
        let corners = grid.corners(micropolygon);
        let mut reach = Extent::EMPTY;
        for stratum in 0..context.pattern.samples_per_pixel() {
            let lens = context.pattern.stratum_bounds(stratum);
            corners.iter().for_each(|&v| reach.add(moving.extent(v, all_times, &lens)));
        }
        let pixels = |axis: usize| reach.least[axis] >> 8..=reach.most[axis] >> 8;
        let pixels = pixels(1).flat_map(|py| pixels(0).map(move |px| (px, py)));
        for (px, py) in pixels.filter(|&(px, py)| samples.region.contains(px, py)) {
            let first = samples.region.pixel_ix(px, py) * per_pixel;
            for ix in first..first + per_pixel {
                let tuple_ix = samples.tuples[ix];
                let (tuple, time) =
                    (&context.pattern.tuples()[tuple_ix as usize], moving.times.of_tuple(tuple_ix));
                let [v0, v1, v2, v3] = corners.map(|v| moving.position(v, tuple, time));
                for triangle in [[v0, v1, v2], [v0, v2, v3]] {
                    count_inclusive(triangle, ix, samples, counts);
                }
            }
        }
    }
}

/// Counts sample `ix` where it is inside of a triangle or on its border.
fn count_inclusive([a, b, c]: [[i32; 2]; 3], ix: usize, samples: &RegionSamples, counts: &mut SignedCounts) {
    let s = samples.position(ix);
    let w = [edge(b, c, s), edge(c, a, s), edge(a, b, s)];
    let sign = w.iter().sum::<i64>().signum();
    if sign != 0 && w.iter().all(|w| w * sign >= 0) {
        counts.hit(ix, HitPoint { depth: 0.0, weights: Weights(0) }, 0, sign as i8);
    }
}
