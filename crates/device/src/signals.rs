//! Signals that end the program: they end the trial first.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Signals that set the flag: Ctrl-C, a polite kill and, where there are such, the terminal that
/// hangs up and Ctrl-\.
const ENDING: &[i32] = &[
    signal_hook::consts::SIGINT,
    signal_hook::consts::SIGTERM,
    #[cfg(unix)]
    signal_hook::consts::SIGHUP,
    #[cfg(unix)]
    signal_hook::consts::SIGQUIT,
];

/// A flag that Ctrl-C, SIGTERM, SIGHUP and SIGQUIT set: the `stop` of [`crate::run_trial`]. The
/// program goes on until it looks.
///
/// # Errors
/// A system that does not take the handlers.
pub fn stop_on_signals() -> std::io::Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in ENDING {
        signal_hook::flag::register(*signal, Arc::clone(&stop))?;
    }
    Ok(stop)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::Ordering;

    #[test]
    fn each_of_the_signals_sets_the_flag() {
        for signal in ENDING {
            let stop = stop_on_signals().unwrap();
            assert!(!stop.load(Ordering::Relaxed));
            signal_hook::low_level::raise(*signal).unwrap();
            assert!(stop.load(Ordering::Relaxed));
        }
    }
}
