//! Time as the control loop sees it.

use crate::digits::{next_tick, on_ticks};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::time::{Duration, Instant};

/// A monotonic clock with a deadline timer. Seconds since some fixed moment, in ticks of 2⁻³⁰ s.
pub trait Clock: Send {
    /// Now, s.
    fn now_s(&mut self) -> f64;

    /// Waits for a deadline, s, and returns when it really woke: not before the deadline, and later
    /// by the jitter. A deadline that is past returns at once.
    fn wait_until(&mut self, deadline_s: f64) -> f64;

    /// A moment of this clock by the machine's monotonic clock, s, if it runs with one that other programs can read.
    fn monotonic_s(&self, at_s: f64) -> Option<f64> {
        let _ = at_s;
        None
    }
}

/// The last stretch before a deadline is spent looking at the clock, s: a sleeping thread wakes
/// some 50 µs late (the timer slack of an ordinary Linux thread) and now and then later.
const SPIN_S: f64 = 200e-6;

/// The machine's monotonic clock; 0 where it was made.
#[derive(Debug, Clone, Copy)]
pub struct RealClock {
    origin: Instant,
    /// The origin by the machine's monotonic clock, s.
    monotonic_s: Option<f64>,
}

/// The clock that Linux calls monotonic, which `Instant` reads too, s. Nobody can say what another system's counts from.
#[cfg(target_os = "linux")]
fn monotonic_s() -> Option<f64> {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    Some(now.tv_sec as f64 + now.tv_nsec as f64 * 1e-9)
}
#[cfg(not(target_os = "linux"))]
fn monotonic_s() -> Option<f64> {
    None
}

impl RealClock {
    /// Begins at 0 now.
    #[must_use]
    #[expect(
        clippy::new_without_default,
        reason = "a clock begins when it is asked to, not by default"
    )]
    pub fn new() -> Self {
        Self { origin: Instant::now(), monotonic_s: monotonic_s() }
    }
}

impl Clock for RealClock {
    fn now_s(&mut self) -> f64 {
        on_ticks(self.origin.elapsed().as_secs_f64())
    }

    fn wait_until(&mut self, deadline_s: f64) -> f64 {
        let asleep_s = deadline_s - self.now_s() - SPIN_S;
        if asleep_s > 0.0 {
            std::thread::sleep(Duration::from_secs_f64(asleep_s));
        }
        loop {
            let now_s = self.now_s();
            if now_s >= deadline_s {
                return now_s;
            }
            std::hint::spin_loop();
        }
    }

    fn monotonic_s(&self, at_s: f64) -> Option<f64> {
        self.monotonic_s.map(|origin_s| origin_s + at_s)
    }
}

/// Jitter of the simulated clock, mean, s: what a loop of its own thread shows on an idle machine.
const JITTER_S: f64 = 20e-6;

/// The simulated jitter ends at so many times its mean, so that no deadline is missed by chance.
const JITTER_MOST: f64 = 10.0;

/// A clock that is never waited for: each deadline is met at once, late by a jitter drawn from a
/// seed (exponential, mean 20 µs, at most 200 µs). The work between two deadlines takes no time.
#[derive(Debug, Clone)]
pub struct SimulatedClock {
    now_s: f64,
    jitter: ChaCha8Rng,
}

impl SimulatedClock {
    /// Begins at 0, with the jitter of a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { now_s: 0.0, jitter: ChaCha8Rng::seed_from_u64(seed) }
    }
}

impl Clock for SimulatedClock {
    fn now_s(&mut self) -> f64 {
        self.now_s
    }

    fn wait_until(&mut self, deadline_s: f64) -> f64 {
        // An exponential variate by its inverse distribution: the upper 53 bits are a number in
        // (0, 1], never 0, whose logarithm is not finite.
        let uniform = ((self.jitter.next_u64() >> 11) as f64 + 1.0) / (1_u64 << 53) as f64;
        let late_s = JITTER_S * (-libm::log(uniform)).min(JITTER_MOST);
        self.now_s = self.now_s.max(next_tick(deadline_s + late_s));
        self.now_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_clock_wakes_before_its_deadline_or_runs_back() {
        for clock in [&mut SimulatedClock::new(1) as &mut dyn Clock, &mut RealClock::new()] {
            let mut last_s = clock.now_s();
            for i in 1..20 {
                let deadline_s = f64::from(i) * 1e-4;
                let woke_s = clock.wait_until(deadline_s);
                assert!(woke_s >= deadline_s && woke_s >= last_s);
                last_s = woke_s;
            }
            assert!(clock.wait_until(0.0) >= last_s);
        }
    }

    #[test]
    fn clocks_count_whole_ticks() {
        for clock in [&mut SimulatedClock::new(1) as &mut dyn Clock, &mut RealClock::new()] {
            let woke_s = clock.wait_until(1.3e-4);
            assert!(woke_s > 0.0);
            assert_eq!(on_ticks(woke_s).to_bits(), woke_s.to_bits());
        }
    }

    #[test]
    fn another_seed_gives_another_jitter_of_the_same_mean() {
        let late = |seed| {
            let mut clock = SimulatedClock::new(seed);
            (1..2000).map(|i| clock.wait_until(f64::from(i)) - f64::from(i)).collect::<Vec<_>>()
        };
        assert_ne!(late(7), late(8));
        let mean_s = late(7).iter().sum::<f64>() / 1999.0;
        assert!((mean_s - JITTER_S).abs() < 0.1 * JITTER_S, "{mean_s}");
        assert!(late(7).iter().all(|s| *s <= JITTER_S * JITTER_MOST + 1e-9));
    }
}
