//! What a buffer keeps, whatever the order of arrival.

use std::collections::BTreeSet;

use super::*;
use crate::math::hash::hash32;
use proptest::prelude::*;

/// A canonical order that is not the order of the bits.
fn order(a: Payload, b: Payload) -> Ordering {
    super::super::hash::mix(a.0).cmp(&super::super::hash::mix(b.0))
}

fn hit(depth: f32, payload: Payload) -> Record {
    Record { depth, payload, weights: Weights(payload.0) }
}

#[test]
fn payloads_unpack_to_what_was_packed() {
    for slot in [0, 1, 77_777, Payload::NUM_SLOTS - 1] {
        for micropolygon in [0, 1, 255, 4095] {
            for triangle in 0..2 {
                let payload = Payload::new(slot, micropolygon, triangle);
                assert_ne!(payload, Payload::NONE);
                assert_eq!(
                    (payload.slot(), payload.micropolygon(), payload.triangle()),
                    (slot, micropolygon, triangle)
                );
            }
        }
    }
}

#[test]
fn an_infinitely_far_hit_is_still_a_hit_and_nan_is_none() {
    let mut buffer = SampleBuffer::new(Region::new(-1, 0, 4, 5), 2);
    let [first, second] = [1, 2].map(|slot| Payload::new(slot, 0, 0));
    assert!(!buffer.offer(0, hit(f32::NAN, first), &order));
    assert!(buffer.offer(0, hit(f32::INFINITY, first), &order));
    assert!(buffer.offer(0, hit(3.0, second), &order));
    assert!(!buffer.offer(0, hit(3.0, second), &order));
    let records: Vec<Record> = buffer.pixel(-1, 4).collect();
    assert_eq!(records, [hit(3.0, second), Record { weights: records[1].weights, ..Record::NONE }]);
}

proptest! {
    #[test]
    fn hits_offered_as_lists_leave_what_single_ones_leave(
        hits in prop::collection::vec((0i32..6, 0u8..4, 0i32..4096, 0i32..4), 0..60),
    ) {
        let region = Region::new(0, 3, 0, 1);
        let (mut lists, mut single) = (SampleBuffer::new(region, 2), SampleBuffer::new(region, 2));
        for slot in [7, 3] {
            let samples: Vec<i32> = hits.iter().map(|hit| hit.0).collect();
            let codes: Vec<i32> = hits.iter().map(|hit| hit.2 << 2 | hit.3).collect();
            let depth_bits: Vec<i32> = hits.iter().map(|hit| f32::from(hit.1).to_bits() as i32).collect();
            let kept = lists.offer_apart(
                &HitsApart { samples: &samples, codes: &codes, depth_bits: &depth_bits, weights: &codes },
                slot,
                &order,
            );
            let mut any = false;
            for &(sample, depth, micropolygon, code) in &hits {
                let payload = Payload::new(slot, micropolygon as u32, (code >> 1) as u8);
                let weights = Weights((micropolygon << 2 | code) as u32);
                let hit = Record { depth: f32::from(depth), payload, weights };
                any |= single.offer(sample as usize, hit, &order);
            }
            prop_assert_eq!(kept, any);
        }
        prop_assert!(lists.records().eq(single.records()));
        prop_assert_eq!(lists.written(), single.written());
    }

    #[test]
    fn any_order_of_arrival_leaves_the_same_records(
        hits in prop::collection::vec((0usize..6, 0u8..4, 0u32..50), 0..60),
        swaps in prop::collection::vec((0usize..60, 0usize..60), 0..60),
    ) {
        let draw = |hits: &[(usize, u8, u32)]| {
            let mut buffer = SampleBuffer::new(Region::new(0, 3, 0, 1), 2);
            for &(sample_ix, depth, slot) in hits {
                buffer.offer(sample_ix, hit(f32::from(depth), Payload::new(slot, 0, 0)), &order);
            }
            buffer.records().collect::<Vec<_>>()
        };
        let mut shuffled = hits.clone();
        for (i, k) in swaps {
            if i < shuffled.len() && k < shuffled.len() {
                shuffled.swap(i, k);
            }
        }
        prop_assert_eq!(draw(&hits), draw(&shuffled));
    }
}

/// Payloads that come again at every distance up to a row of pixels, and samples that hit nothing.
#[test]
fn each_name_is_told() {
    for num in [1usize, 3, 16, 70] {
        let mut buffer = SampleBuffer::new(Region::new(0, num as i32, 0, 1), 3);
        for sample in 0..buffer.len() {
            let name = hash32(sample as u32 / 2) % 5;
            if name != 0 {
                buffer.offer(sample, hit(1.0, Payload::new(name, 7 * name, 1)), &order);
            }
        }
        let expected: BTreeSet<u32> =
            buffer.records().filter(|r| !r.is_none()).map(|r| r.payload.0).collect();
        let (mut named, mut times) = (BTreeSet::new(), 0);
        buffer.each_named(|payload| {
            named.insert(payload.0);
            times += 1;
        });
        assert_eq!(named, expected);
        assert!(num < 70 || (expected.len() == 4 && times < 200), "{times} times");
    }
}
