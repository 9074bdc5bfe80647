//! How much memory the input may make us use.
//!
//! Two sums against one limit: what is *held* for the frame (geometry, recorded objects), and the *scratch* of
//! the statement that is being read. Work that holds nothing (an archive that is opened, a statement that is
//! replayed) is charged too, so that archives that name each other twice cannot keep the reader busy for ever.

/// Bytes that opening an archive counts for.
pub const ARCHIVE_COST: u64 = 16 << 10;
/// Bytes that replaying one recorded statement counts for.
pub const REPLAY_COST: u64 = 512;

/// The account.
#[derive(Debug, Clone)]
pub struct Room {
    limit: u64,
    held: u64,
    scratch: u64,
}

/// The limit would be passed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Full {
    /// The limit in bytes.
    pub limit: u64,
}

impl Room {
    /// An empty account of `limit` bytes.
    pub fn new(limit: u64) -> Self {
        Room { limit, held: 0, scratch: 0 }
    }

    /// Holds `bytes` more.
    pub fn hold(&mut self, bytes: u64) -> Result<(), Full> {
        let sum = self.held.saturating_add(bytes);
        if sum.saturating_add(self.scratch) > self.limit {
            return Err(Full { limit: self.limit });
        }
        self.held = sum;
        Ok(())
    }

    /// Bytes that are left.
    pub fn left(&self) -> u64 {
        self.limit.saturating_sub(self.held).saturating_sub(self.scratch)
    }

    /// Makes room for at least one more element in `values`, doubling it.
    #[cold]
    pub fn grow<T>(&mut self, values: &mut Vec<T>) -> Result<(), Full> {
        let more = values.capacity().max(256);
        self.reserve(values, more)
    }

    /// Makes room for `more` elements.
    pub fn reserve<T>(&mut self, values: &mut Vec<T>, more: usize) -> Result<(), Full> {
        let full = Full { limit: self.limit };
        self.use_scratch((more as u64).saturating_mul(size_of::<T>() as u64))?;
        values.try_reserve_exact(more).map_err(|_| full)
    }

    /// Uses `bytes` more of scratch.
    pub fn use_scratch(&mut self, bytes: u64) -> Result<(), Full> {
        let sum = self.scratch.saturating_add(bytes);
        if sum.saturating_add(self.held) > self.limit {
            return Err(Full { limit: self.limit });
        }
        self.scratch = sum;
        Ok(())
    }

    /// Whether the scratch buffers are better given back than kept for the next statement.
    pub fn is_scratch_large(&self) -> bool {
        self.scratch > (4 << 20).min(self.limit / 4)
    }

    /// All scratch was given back.
    pub fn clear_scratch(&mut self) {
        self.scratch = 0;
    }

    /// What is held belongs to someone else now; `kept` bytes stay.
    pub fn release(&mut self, kept: u64) {
        self.held = kept;
    }
}
