//! Rotations in motion blocks: keys in between where one turns far.
//!
//! In: the times and numbers of a block of `Rotate`s. Out: their matrices, and more at times in between, so that from
//! key to key nothing turns by more than a quarter. The path between two matrices goes the shorter way round and would
//! lose whole turns; a statement's numbers go evenly from key to key. Source: The RenderMan Interface 3.2, section 3.

use glam::{DMat4, DVec3};
use olema::scene::Keyed;

use super::super::transform;

/// Farthest turn from key to key, in degrees.
const MAX_STEP: f64 = 90.0;

/// Most keys of a block.
const MAX_KEYS: usize = 4096;

/// Keys of rotations, an angle in degrees and an axis a time; `None` where none turns far about an axis that stays.
///
/// # Errors
/// A sentence, where there are too many keys or too little time between two.
pub(super) fn spin(times: &[f32], rotations: &[[f64; 4]]) -> Result<Option<Keyed<DMat4>>, String> {
    let steps: Vec<f64> = rotations.windows(2).map(|pair| num_steps(&pair[0], &pair[1])).collect();
    if steps.iter().all(|steps| *steps == 1.0) {
        return Ok(None);
    }
    let num_keys = 1.0 + steps.iter().sum::<f64>();
    if num_keys > MAX_KEYS as f64 {
        let turns = steps.iter().sum::<f64>() * MAX_STEP / 360.0;
        let most = MAX_KEYS as f64 * MAX_STEP / 360.0;
        return Err(format!("about {turns:.0} turns in a motion block: expected at most {most}"));
    }
    let mut keys = Keyed { times: Vec::new(), values: Vec::new() };
    let pairs = times.windows(2).zip(rotations.windows(2)).zip(&steps);
    for ((time, rotation), &steps) in pairs {
        let [from, to] = [time[0], time[1]].map(f64::from);
        let [angle, x, y, z] = rotation[0];
        for step in 0..steps as u32 {
            // Rounded as keys are, so that the angle is that of the key's own time.
            let at = (from + (to - from) * (f64::from(step) / steps)) as f32;
            if at >= time[1] || keys.times.last().is_some_and(|last| *last >= at) {
                let [from, to] = [time[0], time[1]];
                return Err(format!(
                    "times {from} and {to} are too close together for the turns between them"
                ));
            }
            let part = (f64::from(at) - from) / (to - from);
            let angle = angle + (rotation[1][0] - angle) * part;
            keys.times.push(at);
            keys.values.extend(transform::rotate([angle, x, y, z]));
        }
    }
    keys.times.extend(times.last());
    keys.values.extend(rotations.last().and_then(|last| transform::rotate(*last)));
    Ok((keys.values.len() == keys.times.len()).then_some(keys))
}

/// Equal parts of at most [`MAX_STEP`] from one rotation to the next; 1 where the axis changes.
fn num_steps(from: &[f64; 4], to: &[f64; 4]) -> f64 {
    let axis = |rotation: &[f64; 4]| DVec3::new(rotation[1], rotation[2], rotation[3]).normalize();
    // The axes' lengths say nothing.
    if (axis(from) - axis(to)).length() > 1e-9 {
        return 1.0;
    }
    ((to[0] - from[0]).abs() / MAX_STEP).ceil().max(1.0)
}
