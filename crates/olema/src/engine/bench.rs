//! The stages one by one, for benches and experiments: each as the engine runs it, on one thread.

use std::borrow::Cow;
use std::cell::RefCell;
use std::sync::Arc;

use crate::error::Error;
use crate::pipeline::Grid;
use crate::pipeline::bound::{Bound, bound};
use crate::pipeline::dice::{Diced, dice};
use crate::pipeline::piece::{Piece, Sabotage};
use crate::pipeline::resolve::{Pixel, SampleColors};
use crate::pipeline::sample::{DrawContext, TileBuffers};
use crate::pipeline::shade::{Colors, ShadedGrid};
use crate::pipeline::slots::{GridSlots, SlotsFull, UsedVertices};
use crate::pipeline::split::{Fate, SplitContext};
use crate::pipeline::waiting::RasterLists;
use crate::sampling::nomotion::SampleCounts;
use crate::sampling::{Kernels, RegionSamples, SampleBuffer, TransparentRecords};
use crate::scene::Scene;
use crate::settings::Settings;
use crate::stats::Stats;

use super::frame::FrameData;

/// A frame whose stages can be run apart.
pub struct Bench<'a> {
    frame: FrameData<'a>,
    /// What patchify and connect counted.
    pub stats: Stats,
}

impl<'a> Bench<'a> {
    /// Patchifies and connects.
    ///
    /// # Errors
    /// As [`super::Renderer::new`] and [`super::Renderer::render`].
    pub fn new(scene: &'a Scene, settings: &'a Settings) -> Result<Self, Error> {
        Self::broken(scene, settings, None)
    }

    /// The same, with a rule broken on purpose.
    fn broken(scene: &'a Scene, settings: &'a Settings, sabotage: Option<Sabotage>) -> Result<Self, Error> {
        settings.validate()?;
        scene.validate()?;
        let mut stats = Stats::default();
        let frame = FrameData::new(Cow::Borrowed(scene), settings, sabotage, &mut stats);
        Ok(Bench { frame, stats })
    }

    /// All pieces that are diced, in canonical order, whether they can be seen or not.
    pub fn split(&self) -> Vec<Piece> {
        let mut pieces = Vec::new();
        self.each_piece(&self.frame.context(), |piece| pieces.push(*piece));
        pieces
    }

    fn each_piece(&self, context: &SplitContext, mut visit: impl FnMut(&Piece)) {
        for patch in 0..self.frame.patches.patches.len() as u32 {
            let mut stack = vec![context.whole(patch)];
            while let Some(piece) = stack.pop() {
                match context.fate(&piece) {
                    Fate::Split([first, second]) => stack.extend([second, first]),
                    Fate::Dice(piece) => visit(&piece),
                }
            }
        }
    }

    /// Bounds of those that can be seen.
    pub fn bound(&self, pieces: &[Piece]) -> Vec<Bound> {
        let frame = &self.frame;
        let region = frame.tiles.sample_region(frame.tiles.window);
        let context = frame.context();
        pieces.iter().filter_map(|piece| bound(&context, piece, &region).ok()).collect()
    }

    /// Dices pieces.
    pub fn dice(&self, pieces: &[Piece]) -> Vec<Diced> {
        let (context, corrections, workspace) =
            (self.frame.context(), RefCell::default(), RefCell::default());
        let context = self.frame.displace_context(&context, &corrections, &workspace);
        pieces.iter().map(|piece| dice(&context, piece)).collect()
    }

    fn shade_one(&self, diced: Diced) -> (Arc<ShadedGrid>, Arc<Colors>) {
        let ix = diced.grid.key.primitive as usize;
        let surface = self.frame.scene.primitives[ix].attributes.surface.as_ref();
        let grid = Arc::new(ShadedGrid::new(diced, surface));
        let (colors, _) = grid.shade_all(self.frame.shader(ix));
        (grid, colors)
    }

    /// Shades grids.
    pub fn shade(&self, diced: Vec<Diced>) -> Vec<(Arc<ShadedGrid>, Arc<Colors>)> {
        diced.into_iter().map(|diced| self.shade_one(diced)).collect()
    }

    /// Draws opaque grids, the whole frame as one tile.
    ///
    /// # Errors
    /// [`SlotsFull`] where there are more grids than a tile can name.
    pub fn sample(
        &self,
        grids: &[(Arc<ShadedGrid>, Arc<Colors>)],
        kernels: Kernels,
    ) -> Result<TileBuffers, SlotsFull> {
        let frame = &self.frame;
        let region = frame.tiles.sample_region(frame.tiles.window);
        let mut buffers = TileBuffers {
            samples: RegionSamples::new(&frame.pattern, region),
            nearest: SampleBuffer::new(region, frame.pattern.samples_per_pixel() as usize),
            transparent: TransparentRecords::new(frame.settings.transparency_records),
            slots: GridSlots::default(),
            used: UsedVertices::default(),
            counts: SampleCounts::default(),
            room: RasterLists::default(),
        };
        let context = DrawContext { kernels, ..frame.draw_context() };
        for (grid, colors) in grids {
            buffers.draw(&context, grid, Some(colors))?;
        }
        Ok(buffers)
    }

    /// Composites and filters what `sample` drew.
    pub fn resolve(&self, buffers: &TileBuffers) -> Vec<Pixel> {
        let frame = &self.frame;
        let mut colors = SampleColors::default();
        let mut pixels = Vec::new();
        colors.resolve(buffers, &frame.filter, frame.tiles.window, &mut pixels);
        pixels
    }
}

/// Hands every grid of a scene, with the piece that it was diced from, to `visit`: shaded, in canonical order,
/// and whether it can be seen or not; and what the engine draws it with. For tests and experiments that look at grids
/// themselves, and that break a rule on purpose.
///
/// # Errors
/// As [`super::Renderer::new`] and [`super::Renderer::render`].
pub fn grids(
    scene: &Scene,
    settings: &Settings,
    sabotage: Option<Sabotage>,
    mut visit: impl FnMut(&Piece, &Grid, &Colors, &DrawContext),
) -> Result<Stats, Error> {
    let bench = Bench::broken(scene, settings, sabotage)?;
    let mut stats = bench.stats.clone();
    let (context, draw) = (bench.frame.context(), bench.frame.draw_context());
    let (corrections, workspace) = (RefCell::default(), RefCell::default());
    let displace = bench.frame.displace_context(&context, &corrections, &workspace);
    bench.each_piece(&context, |piece| {
        let (shaded, colors) = bench.shade_one(dice(&displace, piece));
        stats.grids += 1;
        stats.micropolygons += shaded.grid.num_micropolygons() as u64;
        visit(piece, &shaded.grid, &colors, &draw);
    });
    Ok(stats)
}
