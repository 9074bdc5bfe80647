//! Transparent records: all hits of not quite opaque surfaces in front of the nearest opaque one.
//!
//! In: hits of a tile in any order, and the tile's [`SampleBuffer`]. Out: the records grouped by sample, in
//! order of depth and canonical key, in as many passes as the memory asks for. Source: peeling by depth is
//! Everitt 2001; here layers of any thickness are peeled, a different thickness for each sample.
//!
//! The store holds at most `capacity` records. When it is full it drops what lies behind the nearest opaque
//! record of its sample. If it is then still more than half full, it keeps of each sample only so many of the
//! nearest records that half the capacity suffices, and remembers per sample the first record that was
//! dropped: the *cutoff*. Records at or beyond the cutoff are refused for the rest of the pass. The next pass
//! takes only samples that have a cutoff, and of those the records at or beyond it. Each pass the same hits
//! have to be pushed, in any order; together the passes give exactly what an unlimited store would.
//!
//! ```text
//! loop {
//!     records.begin_pass();
//!     (draw the tile: opaque hits to the buffer, transparent ones to `push`)
//!     for record in records.sorted(..) { (composite it behind those of earlier passes) }
//!     if !records.needs_another_pass() { break }
//! }
//! ```
//!
//! A pass takes at least the nearest record that is left of the first sample that has one, so passes end; the
//! capacity should be twice the tile's samples or more to make them few. Payloads are compared across passes:
//! they must keep their meaning from the first pass of a tile to the last.

use std::cmp::Ordering;

use super::buffer::{Payload, Record, SampleBuffer};

/// A hit of a transparent surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransparentRecord {
    /// Sample of the region.
    pub sample_ix: u32,
    /// The hit.
    pub hit: Record,
}

/// The transparent records of a tile.
#[derive(Debug, Clone)]
pub struct TransparentRecords {
    capacity: usize,
    records: Vec<TransparentRecord>,
    /// Per sample the first record that this pass does not take, [`Record::NONE`] if it takes all; empty
    /// until one is needed.
    cutoffs: Vec<Record>,
    /// Per sample the first record that this pass takes: the last pass's cutoffs, which are
    /// [`Record::NONE`] where nothing is left. Empty in the first pass, which takes all.
    floors: Vec<Record>,
    /// Whether anything visible is left for another pass; known once the records are sorted.
    unfinished: bool,
}

impl TransparentRecords {
    /// A store of at most `capacity` records (at least 2).
    pub fn new(capacity: usize) -> Self {
        TransparentRecords {
            capacity: capacity.max(2),
            records: Vec::new(),
            cutoffs: Vec::new(),
            floors: Vec::new(),
            unfinished: false,
        }
    }

    /// Empties the store for another tile.
    pub fn renew(&mut self) {
        self.records.clear();
        self.cutoffs.clear();
        self.floors.clear();
        self.unfinished = false;
    }

    /// Begins a pass: the first one, or the next one where [`Self::needs_another_pass`] said so.
    pub fn begin_pass(&mut self) {
        self.records.clear();
        self.floors.clear();
        std::mem::swap(&mut self.floors, &mut self.cutoffs);
        self.unfinished = false;
    }

    /// The records held now, in no order.
    pub fn records(&self) -> &[TransparentRecord] {
        &self.records
    }

    /// Records held now.
    pub fn len(&self) -> usize {
        self.records.len()
    }

    /// Whether none is held.
    pub fn is_empty(&self) -> bool {
        self.records.is_empty()
    }

    /// Takes a hit, unless it is not of this pass or lies behind the sample's opaque record.
    ///
    /// `order` is the canonical order as in [`SampleBuffer::offer`]. A hit must not be pushed twice in a pass.
    pub fn push(
        &mut self,
        record: TransparentRecord,
        nearest: &SampleBuffer,
        order: &impl Fn(Payload, Payload) -> Ordering,
    ) {
        if self.is_of_this_pass(&record, order) && is_visible(&record, nearest, order) {
            if self.records.len() == self.capacity {
                self.make_room(nearest, order);
                if !self.is_of_this_pass(&record, order) {
                    return;
                }
            }
            self.records.push(record);
        }
    }

    /// The visible records of this pass by sample, then depth, then canonical order.
    ///
    /// To be called when all hits of the pass, opaque ones too, have been seen.
    pub fn sorted(
        &mut self,
        nearest: &SampleBuffer,
        order: &impl Fn(Payload, Payload) -> Ordering,
    ) -> &[TransparentRecord] {
        self.prune_and_sort(nearest, order);
        self.unfinished = false;
        for (sample_ix, cutoff) in self.cutoffs.iter_mut().enumerate() {
            // What is cut off behind an opaque record is not missed.
            if !cutoff.is_none() && nearest.get(sample_ix).is_behind(cutoff.depth, cutoff.payload, order) {
                self.unfinished = true;
            } else {
                *cutoff = Record::NONE;
            }
        }
        &self.records
    }

    /// Whether records were refused that another pass has to bring.
    pub fn needs_another_pass(&self) -> bool {
        self.unfinished
    }

    fn is_of_this_pass(
        &self,
        record: &TransparentRecord,
        order: &impl Fn(Payload, Payload) -> Ordering,
    ) -> bool {
        let sample_ix = record.sample_ix as usize;
        let below_floor = self.floors.get(sample_ix).is_some_and(|floor| {
            floor.is_none() || floor.is_behind(record.hit.depth, record.hit.payload, order)
        });
        let below_cutoff = self
            .cutoffs
            .get(sample_ix)
            .is_none_or(|cutoff| cutoff.is_behind(record.hit.depth, record.hit.payload, order));
        below_cutoff && !below_floor && !record.hit.depth.is_nan()
    }

    fn prune_and_sort(&mut self, nearest: &SampleBuffer, order: &impl Fn(Payload, Payload) -> Ordering) {
        self.records.retain(|record| is_visible(record, nearest, order));
        self.records.sort_unstable_by(|a, b| {
            a.sample_ix
                .cmp(&b.sample_ix)
                .then(a.hit.depth.partial_cmp(&b.hit.depth).unwrap_or(Ordering::Equal))
                .then_with(|| order(a.hit.payload, b.hit.payload))
        });
    }

    /// Prunes, and cuts the samples off if more than half of the store is still in use.
    fn make_room(&mut self, nearest: &SampleBuffer, order: &impl Fn(Payload, Payload) -> Ordering) {
        self.prune_and_sort(nearest, order);
        let budget = self.capacity / 2;
        if self.records.len() <= budget {
            return;
        }
        let (quota, mut extra) = shares(&self.records, budget);
        self.cutoffs.resize(nearest.len(), Record::NONE);
        let mut kept = 0;
        let mut start = 0;
        while start < self.records.len() {
            let sample_ix = self.records[start].sample_ix;
            let end = start + self.records[start..].partition_point(|r| r.sample_ix == sample_ix);
            let mut keep = (end - start).min(quota);
            if end - start > quota && extra > 0 {
                keep += 1;
                extra -= 1;
            }
            if start + keep < end {
                self.cutoffs[sample_ix as usize] = self.records[start + keep].hit;
            }
            self.records.copy_within(start..start + keep, kept);
            kept += keep;
            start = end;
        }
        self.records.truncate(kept);
    }
}

/// Whether a record lies in front of the opaque one of its sample.
fn is_visible(
    record: &TransparentRecord,
    nearest: &SampleBuffer,
    order: &impl Fn(Payload, Payload) -> Ordering,
) -> bool {
    nearest.get(record.sample_ix as usize).is_behind(record.hit.depth, record.hit.payload, order)
}

/// How many records every sample may keep so that at most `budget` are kept, and how many of the samples
/// that have more may keep one more.
fn shares(sorted: &[TransparentRecord], budget: usize) -> (usize, usize) {
    let counts: Vec<usize> =
        sorted.chunk_by(|a, b| a.sample_ix == b.sample_ix).map(<[TransparentRecord]>::len).collect();
    let kept = |quota: usize| counts.iter().map(|&count| count.min(quota)).sum::<usize>();
    // The largest quota that fits; it is below the largest count, as not all fits.
    let (mut fits, mut too_many) = (0, budget + 1);
    while too_many - fits > 1 {
        let quota = fits + (too_many - fits) / 2;
        if kept(quota) <= budget { fits = quota } else { too_many = quota }
    }
    (fits, budget - kept(fits))
}

#[cfg(test)]
mod tests {
    use super::super::inside::Weights;
    use super::super::region::Region;
    use super::*;
    use proptest::prelude::*;

    fn order(a: Payload, b: Payload) -> Ordering {
        super::super::hash::mix(a.0).cmp(&super::super::hash::mix(b.0))
    }

    fn record(sample_ix: u32, depth: f32, payload: Payload) -> TransparentRecord {
        TransparentRecord { sample_ix, hit: Record { depth, payload, weights: Weights(payload.0) } }
    }

    /// A hit, opaque or not.
    type Hit = (bool, TransparentRecord);

    /// Every transparent record in front of the nearest opaque one, sorted.
    fn naive(hits: &[Hit], nearest: &SampleBuffer) -> Vec<TransparentRecord> {
        let mut all: Vec<TransparentRecord> =
            hits.iter().filter(|(opaque, _)| !opaque).map(|h| h.1).collect();
        all.retain(|r| {
            let front = nearest.get(r.sample_ix as usize);
            front.is_none()
                || r.hit.depth < front.depth
                || (r.hit.depth == front.depth && order(r.hit.payload, front.payload) == Ordering::Less)
        });
        all.sort_by(|a, b| {
            (a.sample_ix.cmp(&b.sample_ix))
                .then(a.hit.depth.total_cmp(&b.hit.depth))
                .then(order(a.hit.payload, b.hit.payload))
        });
        all
    }

    /// What all passes bring, sample by sample in the order they brought it, and the number of passes.
    fn peeled(hits: &[Hit], capacity: usize, num_samples: usize) -> (Vec<TransparentRecord>, usize) {
        let mut nearest = SampleBuffer::new(Region::new(0, num_samples as i32, 0, 1), 1);
        let mut store = TransparentRecords::new(capacity);
        let mut per_sample = vec![Vec::new(); num_samples];
        let mut passes = 0;
        loop {
            passes += 1;
            assert!(passes <= hits.len() + 1, "passes do not end");
            store.begin_pass();
            // Each pass draws in another order.
            let turned = hits.iter().cycle().skip(passes * 7 % hits.len().max(1)).take(hits.len());
            for (opaque, r) in turned {
                if *opaque {
                    nearest.offer(r.sample_ix as usize, r.hit, &order);
                } else {
                    store.push(*r, &nearest, &order);
                }
                assert!(store.len() <= capacity.max(2));
            }
            for record in store.sorted(&nearest, &order) {
                per_sample[record.sample_ix as usize].push(*record);
            }
            if !store.needs_another_pass() {
                return (per_sample.concat(), passes);
            }
        }
    }

    proptest! {
        #[test]
        fn peeling_brings_what_an_unlimited_list_holds(
            raw in prop::collection::vec((0u8..10, 0u32..7, 0u8..12), 0..150),
            capacity in 0usize..40,
        ) {
            let hits: Vec<Hit> = raw
                .iter()
                .enumerate()
                .map(|(slot, &(kind, sample_ix, depth))| {
                    let payload = Payload::new(slot as u32, 0, 0);
                    (kind == 0, record(sample_ix, f32::from(depth), payload))
                })
                .collect();
            let mut nearest = SampleBuffer::new(Region::new(0, 7, 0, 1), 1);
            for (_, r) in hits.iter().filter(|hit| hit.0) {
                nearest.offer(r.sample_ix as usize, r.hit, &order);
            }
            let (found, passes) = peeled(&hits, capacity, 7);
            prop_assert_eq!(found, naive(&hits, &nearest));
            if capacity >= hits.len() {
                prop_assert_eq!(passes, 1);
            }
        }
    }

    #[test]
    fn passes_are_about_as_many_as_half_capacities() {
        let hits: Vec<Hit> = (0..4000u32)
            .map(|i| {
                let depth = super::super::hash::mix(i) as f32;
                let payload = Payload::new(i, 0, 0);
                (false, record(i % 40, depth, payload))
            })
            .collect();
        let (found, passes) = peeled(&hits, 400, 40);
        assert_eq!(found.len(), 4000);
        assert!((10..=20).contains(&passes), "{passes} passes");
    }

    #[test]
    fn layers_behind_an_opaque_one_cost_no_pass() {
        let mut hits: Vec<Hit> = (1..1000u32)
            .map(|i| {
                let payload = Payload::new(i, 0, 0);
                (false, record(0, i as f32, payload))
            })
            .collect();
        hits.push((true, record(0, 2.5, Payload::new(1000, 0, 0))));
        assert_eq!(peeled(&hits, 8, 1).1, 1);
    }
}
