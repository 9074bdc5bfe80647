//! What a render did, counted where it happens.

use serde::{Deserialize, Serialize};

use crate::occlusion::DepthReads;

/// Counters and times of one render. Counts do not depend on the number of threads.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Stats {
    /// Primitives in the scene.
    pub primitives: u64,
    /// Patches they became.
    pub patches: u64,
    /// Distinct edges of those patches.
    pub edges: u64,
    /// Edges shared by two or more patches.
    pub welds: u64,
    /// Sub-patches cut in two.
    pub splits: u64,
    /// Sub-patches and micropolygons that were dropped before sampling, by cause.
    pub culled: Culled,
    /// Edges through the eye plane that were given one segment after the last split.
    pub eye_edges: u64,
    /// Grids diced.
    pub grids: u64,
    /// Grids that were diced again because they were not kept.
    pub grids_again: u64,
    /// Micropolygons (quads) in those grids.
    pub micropolygons: u64,
    /// Micropolygon areas in pixels: bin `i` counts areas in `[2^(i - 8), 2^(i - 7))`, the first and the
    /// last bin also what lies beyond.
    pub area_histogram: [u64; 16],
    /// Vertices diced, those diced again included.
    pub diced_points: u64,
    /// Of these, vertices diced again because their grids were not kept.
    pub diced_points_again: u64,
    /// Vertices shaded, those shaded again included.
    pub shaded_points: u64,
    /// Of these, vertices shaded only since the derivatives of a neighbour need them.
    pub ring_points: u64,
    /// Vertices of which the colour of a visible micropolygon is made.
    pub visible_points: u64,
    /// What occlusion culling did at its three places.
    pub occlusion: Occlusion,
    /// Sample positions tested against a micropolygon.
    pub sample_tests: u64,
    /// Tests that hit.
    pub sample_hits: u64,
    /// Sample test efficiency, hits / tests.
    pub ste: f64,
    /// Times a tile was sampled again because its transparent records were peeled by depth.
    pub peels: u64,
    /// Things that were limited, with the object's name.
    pub warnings: Vec<String>,
    /// Seconds per stage, summed over threads (0 where no clock was given).
    pub seconds: Seconds,
    /// Peak resident memory of the process in bytes, filled in by whoever can ask the system; 0 = unknown.
    pub peak_memory: u64,
}

/// Dropped before sampling, by cause.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Culled {
    /// Outside the frame.
    pub frustum: u64,
    /// In front of the near or beyond the far plane.
    pub depth: u64,
    /// One-sided and facing away.
    pub backface: u64,
}

/// Occlusion culling.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Occlusion {
    /// Before a sub-patch is split.
    pub split: OcclusionAt,
    /// Before one is diced.
    pub dice: OcclusionAt,
    /// Before a grid is shaded.
    pub shade: OcclusionAt,
    /// Most bytes that the pyramids of one tile took.
    pub pyramid_bytes: u64,
}

/// Occlusion culling at one place.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct OcclusionAt {
    /// Questions.
    pub queries: u64,
    /// Those answered with "hidden".
    pub hidden: u64,
    /// Depths read to answer them.
    pub reads: DepthReads,
}

impl std::ops::AddAssign for OcclusionAt {
    fn add_assign(&mut self, other: Self) {
        self.queries += other.queries;
        self.hidden += other.hidden;
        self.reads += other.reads;
    }
}

/// Seconds per stage.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Seconds {
    /// Reading files (filled in by the reader's caller).
    pub read: f64,
    /// Patchify and connect.
    pub connect: f64,
    /// Bound and split.
    pub split: f64,
    /// Dice.
    pub dice: f64,
    /// Ask what is hidden.
    pub cull: f64,
    /// Shade.
    pub shade: f64,
    /// Sample.
    pub sample: f64,
    /// Resolve and filter.
    pub resolve: f64,
    /// The whole render, wall time.
    pub total: f64,
}

impl Stats {
    /// Adds another thread's counts to these. `ste` is renewed.
    pub fn add(&mut self, other: &Stats) {
        let Stats {
            primitives,
            patches,
            edges,
            welds,
            splits,
            culled,
            eye_edges,
            grids,
            grids_again,
            micropolygons,
            area_histogram,
            diced_points,
            diced_points_again,
            shaded_points,
            ring_points,
            visible_points,
            occlusion,
            sample_tests,
            sample_hits,
            ste: _,
            peels,
            warnings,
            seconds,
            peak_memory,
        } = other;
        self.primitives += primitives;
        self.patches += patches;
        self.edges += edges;
        self.welds += welds;
        self.splits += splits;
        self.culled.frustum += culled.frustum;
        self.culled.depth += culled.depth;
        self.culled.backface += culled.backface;
        self.eye_edges += eye_edges;
        self.grids += grids;
        self.grids_again += grids_again;
        self.micropolygons += micropolygons;
        for (mine, theirs) in self.area_histogram.iter_mut().zip(area_histogram) {
            *mine += theirs;
        }
        self.diced_points += diced_points;
        self.diced_points_again += diced_points_again;
        self.shaded_points += shaded_points;
        self.ring_points += ring_points;
        self.visible_points += visible_points;
        self.occlusion.split += occlusion.split;
        self.occlusion.dice += occlusion.dice;
        self.occlusion.shade += occlusion.shade;
        self.occlusion.pyramid_bytes = self.occlusion.pyramid_bytes.max(occlusion.pyramid_bytes);
        self.sample_tests += sample_tests;
        self.sample_hits += sample_hits;
        self.peels += peels;
        self.warnings.extend(warnings.iter().cloned());
        self.seconds.read += seconds.read;
        self.seconds.connect += seconds.connect;
        self.seconds.split += seconds.split;
        self.seconds.dice += seconds.dice;
        self.seconds.cull += seconds.cull;
        self.seconds.shade += seconds.shade;
        self.seconds.sample += seconds.sample;
        self.seconds.resolve += seconds.resolve;
        self.seconds.total += seconds.total;
        self.peak_memory = self.peak_memory.max(*peak_memory);
        self.ste =
            if self.sample_tests == 0 { 0.0 } else { self.sample_hits as f64 / self.sample_tests as f64 };
    }
}
