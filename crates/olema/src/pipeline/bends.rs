//! Bends: control points at keys half-way between others, a byte a float.
//!
//! In: floats of a patch at all keys. Out: those of every other key, and how far the rest is from the middle of its
//! neighbours in steps of a float, where a byte holds that.

use super::patch::PatchTable;

/// For a patch all of whose floats are listed.
pub const NOT_BENT: u32 = u32::MAX;

/// Floats of a patch at a key, at most.
pub(super) const MOST_FLOATS: usize = 64;

/// Floats that are so many steps from the middle of others.
pub(super) fn bent([from, to]: [&[f32]; 2], bends: &[i8], out: &mut [f32; MOST_FLOATS]) {
    for (((out, from), to), bend) in out.iter_mut().zip(from).zip(to).zip(bends) {
        *out = f32::from_bits(((from + to) * 0.5).to_bits().wrapping_add_signed(i32::from(*bend)));
    }
}

impl PatchTable {
    /// Puts every other key of the last patch, whose floats, `len` a key, begin at `first_float`, into `bends` if that can be
    /// done to the last bit. Returns the first of these or [`NOT_BENT`].
    pub(super) fn bend_last(&mut self, first_float: usize, len: usize) -> u32 {
        let num_keys = (self.floats.len() - first_float) / len.max(1);
        let first_bend = self.bends.len();
        if num_keys < 3 || num_keys.is_multiple_of(2) || first_bend + num_keys * len >= NOT_BENT as usize {
            return NOT_BENT;
        }
        let floats = &mut self.floats[first_float..];
        for key in (1..num_keys).step_by(2) {
            let at_key = |key: usize| &floats[key * len..][..len];
            let [from, middle, to] = [key - 1, key, key + 1].map(at_key);
            let step = |((from, middle), to): ((&f32, &f32), &f32)| {
                let straight = (from + to) * 0.5;
                middle.to_bits().wrapping_sub(straight.to_bits()) as i32
            };
            let steps = from.iter().zip(middle).zip(to).map(step);
            let mut fits = true;
            self.bends.extend(steps.map(|step| {
                fits &= i8::try_from(step).is_ok();
                step as i8
            }));
            if !fits {
                self.bends.truncate(first_bend);
                return NOT_BENT;
            }
        }
        for key in 1..=num_keys / 2 {
            floats.copy_within(2 * key * len..(2 * key + 1) * len, key * len);
        }
        self.floats.truncate(first_float + (num_keys / 2 + 1) * len);
        first_bend as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{hash_all, signed_unit};
    use crate::pipeline::motion::KeyTimes;
    use crate::pipeline::patch::Surface;
    use crate::pipeline::patchify::patchify;
    use crate::standard::teapot::teapot;

    /// Five keys of a patch, of which two are not quite or not at all in the middle of others.
    #[test]
    fn bent_keys_have_the_bits_that_they_had() {
        for (off, is_bent) in [(0.0, true), (1e-6, true), (0.1, false)] {
            let scene = teapot();
            let mut times = KeyTimes::still(&scene);
            times.sets[0] = vec![0.0, 0.25, 0.5, 0.75, 1.0];
            let (mut table, _) = patchify(&scene, &times);
            let mut patch = table.patches[3];
            let even = |key: u32, ix: u32| 1.5 + signed_unit(hash_all([key, ix])) * 0.4;
            let keys: Vec<[f32; 48]> = (0..5u32)
                .map(|key| {
                    std::array::from_fn(|ix| match (key % 2, ix as u32) {
                        (0, ix) => even(key, ix),
                        (_, ix) => (even(key - 1, ix) + even(key + 1, ix)) * 0.5 + off * even(key, ix),
                    })
                })
                .collect();
            table.floats = keys.as_flattened().to_vec();
            table.bends.clear();
            (patch.first_float, patch.first_bend) = (0, table.bend_last(0, 48));
            assert_eq!(patch.first_bend != NOT_BENT, is_bent, "{off}");
            assert_eq!(table.floats.len(), if is_bent { 3 * 48 } else { 5 * 48 });
            for (key, floats) in keys.iter().enumerate() {
                let Some(Surface::Bicubic(found)) = table.control_surface(&patch, key) else {
                    panic!("bicubic")
                };
                let found = found.0.iter().flat_map(|p| p.to_array().map(f32::to_bits));
                assert!(found.eq(floats.map(f32::to_bits)), "{off} {key}");
            }
        }
    }
}
