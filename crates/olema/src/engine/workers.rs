//! Workers: the threads that draw a frame.
//!
//! One alone is the caller's own: allocators give a thread memory of its own, and what the caller's thread took for the
//! scene is of use to another one only once it is back with the system.

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
        let pool = rayon::ThreadPoolBuilder::new().num_threads(num).build();
        Ok(Workers::Pool(pool.map_err(|e| Error::Threads(e.to_string()))?))
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
