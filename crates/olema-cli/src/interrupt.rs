//! Ctrl-C and polite termination.
//!
//! The first signal lets the renderer stop at the next unit of work, so that nothing half-written stays; while
//! a scene is read (perhaps from a terminal that never ends) there is nothing to clean up, and the process
//! ends at once. A second signal always ends it at once.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use olema::CancelToken;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::exit;

/// What the process does, as far as a signal is concerned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// Nothing would be left behind.
    Idle,
    /// A picture is on its way: stop it through the token.
    Busy,
}

/// The state shared with the thread that waits for signals.
#[derive(Debug)]
struct Shared {
    /// Number of the signal that came first; 0 for none.
    signal: Arc<AtomicUsize>,
    token: CancelToken,
    phase: Mutex<Phase>,
}

/// Turns signals into cancellation.
#[derive(Debug, Clone)]
pub struct Interrupt(Arc<Shared>);

impl Interrupt {
    /// Takes over SIGINT and SIGTERM. Where the system refuses, signals keep their usual effect.
    pub fn install() -> Self {
        let shared = Arc::new(Shared {
            signal: Arc::new(AtomicUsize::new(0)),
            token: CancelToken::default(),
            phase: Mutex::new(Phase::Idle),
        });
        let once = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            let code = i32::from(exit::SIGNAL) + signal;
            // The order matters: the flag is still down when the first signal passes the shutdown.
            let _ = flag::register_conditional_shutdown(signal, code, Arc::clone(&once));
            let _ = flag::register(signal, Arc::clone(&once));
            let _ = flag::register_usize(signal, Arc::clone(&shared.signal), signal as usize);
        }
        let watched = Arc::clone(&shared);
        // Handlers may only set flags; this looks at them. It sleeps, and dies with the process.
        let _ = std::thread::Builder::new().name("signals".to_owned()).spawn(move || watch(&watched));
        Interrupt(shared)
    }

    /// The token to hand to the renderer.
    pub fn token(&self) -> &CancelToken {
        &self.0.token
    }

    /// From here to the end of the guard a signal goes through the token.
    pub fn busy(&self) -> Busy<'_> {
        *lock(&self.0.phase) = Phase::Busy;
        Busy(self)
    }

    /// The exit code of the signal that came, if one did.
    pub fn exit_code(&self) -> Option<u8> {
        match self.0.signal.load(Ordering::SeqCst) {
            0 => None,
            signal => Some(exit::SIGNAL.saturating_add(signal as u8)),
        }
    }
}

/// A picture is on its way.
#[derive(Debug)]
pub struct Busy<'a>(&'a Interrupt);

impl Drop for Busy<'_> {
    fn drop(&mut self) {
        *lock(&self.0.0.phase) = Phase::Idle;
    }
}

fn lock(phase: &Mutex<Phase>) -> MutexGuard<'_, Phase> {
    phase.lock().unwrap_or_else(PoisonError::into_inner)
}

fn watch(shared: &Shared) {
    loop {
        let signal = shared.signal.load(Ordering::SeqCst);
        if signal != 0 {
            shared.token.cancel();
            // Held while exiting, so that no picture can begin in between.
            let phase = lock(&shared.phase);
            if *phase == Phase::Idle {
                std::process::exit(i32::from(exit::SIGNAL) + signal as i32);
            }
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}
