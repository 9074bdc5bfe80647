//! Written: which leaves of a pyramid have a record that was written.
//!
//! In: the marks of a [`SampleBuffer`]. Out: leaves, row by row.

use crate::sampling::SampleBuffer;

use super::pyramid::TzPyramid;

/// Leaves in which a record was written; used again for every update.
#[derive(Debug, Clone, Default)]
pub(super) struct WrittenLeaves {
    pub leaves: Vec<[u32; 2]>,
    /// Whether any sample of a column of blocks was written, over a row of leaves.
    any_row: Vec<bool>,
}

/// The blocks that samples are in.
#[inline(always)]
fn blocks(first: usize, len: usize) -> std::ops::Range<usize> {
    first / SampleBuffer::BLOCK..(first + len - 1) / SampleBuffer::BLOCK + 1
}

/// Whether any is set: without a branch for each.
#[inline(always)]
fn any(marks: &[bool]) -> bool {
    marks.iter().fold(false, |any, &mark| any | mark)
}

impl TzPyramid {
    /// Lists the leaves of `pixels`, `[x0, x1, y0, y1]`, inclusive, in which a record was written since the buffer's
    /// marks were cleared. The box may reach beyond the region. A large box costs little where few samples in it were
    /// hit, as those of fast things are.
    pub(super) fn list_written(&self, buffer: &SampleBuffer, pixels: [i32; 4], out: &mut WrittenLeaves) {
        debug_assert_eq!(buffer.region(), self.region);
        out.leaves.clear();
        let rect = self.leaves_of(pixels);
        if rect.is_empty() {
            return;
        }
        let samples_per_pixel = buffer.samples_per_pixel();
        // Rows of samples begin with a block, so that those of a row of leaves lie below each other.
        let are_aligned = (self.region.width() * samples_per_pixel).is_multiple_of(SampleBuffer::BLOCK);
        for y in rect.y[0]..=rect.y[1] {
            let [first, last] = rect.x.map(|x| self.samples_of_leaf([x, y], samples_per_pixel));
            let begin = first.first / SampleBuffer::BLOCK;
            if are_aligned {
                let len = blocks(last.first, last.len).end - begin;
                out.any_row.clear();
                out.any_row.extend_from_slice(&buffer.written()[begin..begin + len]);
                for row in 1..first.num {
                    let begin = begin + row * first.step / SampleBuffer::BLOCK;
                    for (any, &written) in out.any_row.iter_mut().zip(&buffer.written()[begin..begin + len]) {
                        *any |= written;
                    }
                }
            }
            for x in rect.x[0]..=rect.x[1] {
                let rows = self.samples_of_leaf([x, y], samples_per_pixel);
                let is_written = if are_aligned {
                    let blocks = blocks(rows.first, rows.len);
                    any(&out.any_row[blocks.start - begin..blocks.end - begin])
                } else {
                    rows.ranges().any(|row| any(&buffer.written()[blocks(row.start, row.len())]))
                };
                if is_written {
                    out.leaves.push([x, y]);
                }
            }
        }
    }
}
