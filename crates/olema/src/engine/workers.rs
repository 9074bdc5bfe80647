//! Workers: the threads that draw a frame.
//!
//! One alone is the caller's own: allocators give a thread memory of its own, and what the caller's thread took for the
//! scene is of use to another one only once it is back with the system.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::ThreadPool;
use rayon::prelude::*;

use crate::error::Error;

/// The threads of a frame.
pub(super) enum Workers {
    /// The one that asked for the frame.
    Caller,
    /// Others.
    Pool(ThreadPool),
}

impl Workers {
    /// So many; 0 for as many as the machine has.
    ///
    /// # Errors
    /// [`Error::Threads`].
    pub fn new(num: usize) -> Result<Self, Error> {
        if num == 1 {
            return Ok(Workers::Caller);
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(num).start_handler(|_| make_room()).build();
        Ok(Workers::Pool(pool.map_err(|e| Error::Threads(e.to_string()))?))
    }

    /// How many there are.
    pub fn num(&self) -> usize {
        match self {
            Workers::Caller => 1,
            Workers::Pool(pool) => pool.current_num_threads(),
        }
    }

    /// What `work` makes of 0 to `num`, in their order.
    pub fn map<R: Send>(&self, num: u32, work: impl Fn(u32) -> R + Sync + Send) -> Vec<R> {
        match self {
            Workers::Caller => (0..num).map(work).collect(),
            Workers::Pool(pool) => pool.install(|| (0..num).into_par_iter().map(work).collect()),
        }
    }

    /// Lets each of them do the same.
    pub fn each(&self, work: impl Fn() + Sync) {
        match self {
            Workers::Caller => work(),
            Workers::Pool(pool) => {
                pool.broadcast(|_| work());
            }
        }
    }
}

/// Room that a thread asks for at once, in bytes.
const ROOM: usize = 8 << 20;

/// Has the allocator make room for the thread that calls. glibc enlarges a thread's memory by what is asked for and no
/// more, each time with a call to the system, for which threads wait for each other: 2,300 of them in a frame of 0.2 s.
/// What was enlarged at once stays, and is not used before it is needed.
fn make_room() {
    // Blocks of this size come from the system; one that was given back is the sign that they should not.
    for _ in 0..2 {
        let mut room = Vec::<u8>::new();
        // Where there is none a frame may do with less.
        let _ = room.try_reserve_exact(ROOM);
        drop(std::hint::black_box(room));
    }
}

/// Work that is dealt out in order, in runs that become shorter towards the end.
pub(super) struct Runs {
    next: AtomicUsize,
    num: usize,
    num_workers: usize,
}

impl Runs {
    /// The longest run.
    const MOST: usize = 32;

    /// Of 0 to `num`.
    pub fn new(num: usize, num_workers: usize) -> Self {
        Runs { next: AtomicUsize::new(0), num, num_workers }
    }

    /// The next run; `None` where all are dealt out.
    pub fn take(&self) -> Option<Range<usize>> {
        let end = |first: usize| first + ((self.num - first) / (8 * self.num_workers)).clamp(1, Self::MOST);
        let take = |first: usize| (first < self.num).then(|| end(first));
        let first = self.next.fetch_update(Ordering::Relaxed, Ordering::Relaxed, take).ok()?;
        Some(first..end(first))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_all_of_it_once_and_end_with_single_ones() {
        for num in [0, 1, 7, 300] {
            let runs = Runs::new(num, 3);
            let taken: Vec<_> = std::iter::from_fn(|| runs.take()).collect();
            assert!(taken.iter().cloned().flatten().eq(0..num), "{taken:?}");
            assert!(taken.iter().all(|run| !run.is_empty() && run.len() <= Runs::MOST), "{taken:?}");
            assert!(taken.last().is_none_or(|run| run.len() == 1), "{taken:?}");
        }
    }
}
