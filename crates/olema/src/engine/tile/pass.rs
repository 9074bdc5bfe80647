//! A pass over a tile: its pieces nearest first, each hidden, cut or drawn.

use crate::occlusion::CullPlan;
use crate::pipeline::Grid;
use crate::pipeline::bound::{Bound, bound};
use crate::pipeline::piece::Piece;
use crate::pipeline::sample::TileBuffers;
use crate::pipeline::split::Fate;
use crate::pipeline::sweep::Sweep;
use crate::sampling::Region;
use crate::stats::{Occlusion, OcclusionAt};

use super::super::filed::Source;
use super::super::frame::{MOST_AT_EYE, count_unseen, weight_at_eye};
use super::super::laps::Stage;
use super::super::queue::{Queue, Work};
use super::{Stop, TileWorker};

/// Grids drawn between two looks for grids that nothing needs any more.
const DRAWN_BETWEEN_CLEANUPS: usize = 4096;

/// A grid whose box takes this part of its piece's may be hidden where the piece was not.
const CLEARLY_LESS: f32 = 0.75;

impl TileWorker<'_> {
    /// Takes the tile's pieces nearest first, and cuts or draws each.
    pub(super) fn pass(&mut self, tile: usize, region: Region) -> Result<(), Stop> {
        let mut queue = Queue::new(self.filed, tile);
        let (mut drawn, mut at_eye) = (0, 0);
        while let Some(work) = queue.pop() {
            self.enter(Stage::Split);
            if self.hooks.is_cancelled() {
                return Err(Stop::Cancelled);
            }
            let of_filed;
            let (bounds, is_surely_split) = match &work {
                Work::Piece(bounded) => (&bounded.1, self.context.is_surely_split(&bounded.0)),
                Work::Filed(ix) => {
                    let Some(found) = self.bounds_of_filed(*ix, &region) else { continue };
                    of_filed = found;
                    (&of_filed, self.filed.entry(*ix).is_surely_split)
                }
            };
            if self.is_hidden_before_cut(&bounds.sweep, is_surely_split) {
                continue;
            }
            at_eye += weight_at_eye(bounds);
            if at_eye > MOST_AT_EYE {
                let warning =
                    "too many pieces pass the eye in one tile; the rest of them is not drawn".to_owned();
                if !self.stats.warnings.contains(&warning) {
                    self.stats.warnings.push(warning);
                }
                continue;
            }
            self.enter(Stage::Split);
            let fate = match &work {
                Work::Filed(ix) => self.context.fate(&self.filed_piece(*ix)),
                Work::Piece(bounded) => self.context.fate(&bounded.0),
            };
            match fate {
                Fate::Split(halves) => {
                    self.stats.splits += 1;
                    for half in halves {
                        let bounds = bound(&self.context, &half, &region);
                        if let Some(bounds) = count_unseen(bounds, &mut self.stats) {
                            queue.push(half, bounds);
                        }
                    }
                }
                Fate::Dice(piece) => {
                    self.draw_piece(&piece, &bounds.sweep)?;
                    drawn += 1;
                    if drawn % DRAWN_BETWEEN_CLEANUPS == 0 {
                        self.buffers.drop_hidden_grids();
                    }
                }
            }
        }
        Ok(())
    }

    fn filed_piece(&self, entry: u32) -> Piece {
        match self.filed.entry(entry).source {
            Source::Patch(patch) => self.context.whole(patch),
            Source::Piece(ix) => self.filed.pieces[ix as usize],
        }
    }

    /// Where a filed piece can be, if it can be seen in `region`.
    fn bounds_of_filed(&mut self, ix: u32, region: &Region) -> Option<Bound> {
        let entry = self.filed.entry(ix);
        let patch = match entry.source {
            Source::Patch(patch) => patch,
            Source::Piece(piece) => self.filed.pieces[piece as usize].patch,
        };
        let patches = &self.frame.patches;
        let key_times = &patches.times.sets[patches.patches[patch as usize].motion as usize];
        let Some(sweep) = self.filed.sweep(entry, key_times) else {
            return count_unseen(bound(&self.context, &self.filed_piece(ix), region), &mut self.stats);
        };
        // A part of a tile may not see it.
        sweep.meets_region(region)?;
        Some(Bound { near: entry.near, at_eye: [0, key_times.len() as u32], sweep })
    }

    /// Whether a piece is hidden before it is split (where that is what surely comes) or diced.
    fn is_hidden_before_cut(&mut self, sweep: &Sweep, is_surely_split: bool) -> bool {
        let Some(places) = self.frame.cull.as_ref().map(|plan: &CullPlan| plan.settings().at) else {
            return false;
        };
        if is_surely_split {
            places.split && self.is_hidden(sweep, |occlusion| &mut occlusion.split)
        } else {
            places.dice && self.is_hidden(sweep, |occlusion| &mut occlusion.dice)
        }
    }

    /// Whether a grid is hidden before it is shaded, now that it is known where its vertices are. Where that is about as
    /// much as was known of its piece, which was found to be seen just before, nobody asks again: of the torus one grid of
    /// 400 was hidden then.
    pub(super) fn is_hidden_before_shading(&mut self, grid: &Grid, of_piece: &Sweep) -> bool {
        let Some(places) = self.frame.cull.as_ref().map(|plan| plan.settings().at) else {
            return false;
        };
        let area = |sweep: &Sweep| {
            let [x0, x1, y0, y1] = sweep.whole();
            (x1 - x0) * (y1 - y0)
        };
        let knows_more = || area(&grid.sweep) < CLEARLY_LESS * area(of_piece);
        places.shade
            && (!places.dice || knows_more())
            && self.is_hidden(&grid.sweep, |occlusion| &mut occlusion.shade)
    }

    fn is_hidden(&mut self, sweep: &Sweep, place: fn(&mut Occlusion) -> &mut OcclusionAt) -> bool {
        let Some(occluders) = &mut self.occluders else { return false };
        self.laps.enter(Stage::Cull, &mut self.stats.seconds);
        let at = place(&mut self.stats.occlusion);
        let TileBuffers { samples, nearest, .. } = &mut self.buffers;
        let is_hidden = occluders.is_occluded(samples, nearest, |range| sweep.over(range), &mut at.reads);
        at.queries += 1;
        at.hidden += u64::from(is_hidden);
        is_hidden
    }
}
