//! Signals that end zwidth, held back until the programs that it started are ended.
//!
//! A program in a process group of its own does not get the terminal's Ctrl-C: zwidth gets it, ends
//! the program's group, and then ends as it would have.

#[cfg(unix)]
use signal_hook::consts::{SIGHUP, SIGQUIT};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag::{register_conditional_default, register_usize};
use signal_hook::low_level::emulate_default_handler;
use std::io;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

/// Signals that end the program.
const ENDING: &[i32] = &[
    SIGINT,
    SIGTERM,
    #[cfg(unix)]
    SIGHUP,
    #[cfg(unix)]
    SIGQUIT,
];

/// What the handlers share. They stay: a handler that is taken out again leaves a signal without
/// effect.
struct Handlers {
    /// Whether a signal ends zwidth at once.
    nothing_runs: Arc<AtomicBool>,
    /// The signal that came, or 0.
    came: Arc<AtomicUsize>,
    /// How many programs hold signals back.
    holders: Mutex<usize>,
}

static HANDLERS: OnceLock<Handlers> = OnceLock::new();

impl Handlers {
    fn of_process() -> io::Result<&'static Self> {
        static INSTALLING: Mutex<()> = Mutex::new(());
        let _one_at_a_time = INSTALLING.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(handlers) = HANDLERS.get() {
            return Ok(handlers);
        }
        let nothing_runs = Arc::new(AtomicBool::new(true));
        let came = Arc::new(AtomicUsize::new(0));
        for signal in ENDING.iter().copied().filter(|signal| !is_ignored(*signal)) {
            register_conditional_default(signal, nothing_runs.clone())?;
            let number = usize::try_from(signal).map_err(io::Error::other)?;
            register_usize(signal, came.clone(), number)?;
        }
        Ok(HANDLERS.get_or_init(|| Handlers { nothing_runs, came, holders: Mutex::new(0) }))
    }

    fn holders(&self) -> MutexGuard<'_, usize> {
        self.holders.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Whether whoever started zwidth had it ignore a signal, as `nohup` does with SIGHUP. Where that
/// cannot be found out, no.
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    mask >> (signal - 1) & 1 == 1
}

/// While this lives, a signal that would end zwidth is only noted. When the last one is gone, zwidth
/// ends by it.
pub struct HeldSignals(&'static Handlers);

impl HeldSignals {
    /// Holds signals back.
    ///
    /// # Errors
    /// A system that does not take the handlers.
    pub fn hold() -> io::Result<Self> {
        let handlers = Handlers::of_process()?;
        let mut holders = handlers.holders();
        *holders += 1;
        handlers.nothing_runs.store(false, Ordering::SeqCst);
        drop(holders);
        Ok(Self(handlers))
    }

    /// Whether such a signal has come.
    pub fn have_come(&self) -> bool {
        self.0.came.load(Ordering::SeqCst) != 0
    }
}

impl Drop for HeldSignals {
    fn drop(&mut self) {
        let mut holders = self.0.holders();
        *holders -= 1;
        if *holders > 0 {
            return;
        }
        self.0.nothing_runs.store(true, Ordering::SeqCst);
        if let Ok(signal @ 1..) = i32::try_from(self.0.came.load(Ordering::SeqCst)) {
            // It ends here, as if nobody had held the signal back.
            let _ = emulate_default_handler(signal);
        }
    }
}
