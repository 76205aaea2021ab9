//! How well a loop kept its time.

use crate::Clock;

/// Buckets to each doubling: a value is known to one part in 32.
const PER_OCTAVE: u64 = 32;
/// Doublings beyond the first buckets: up to 2³⁶ ns, a minute.
const OCTAVES: u64 = 31;
const BUCKETS: usize = (PER_OCTAVE * (OCTAVES + 1)) as usize;

/// Durations counted in fixed buckets, each 3 % wide (the first ones 1 ns), as HdrHistogram does:
/// counting one allocates nothing and takes the same few nanoseconds always.
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
    counts: Vec<u64>,
    count: u64,
    max_s: f64,
}

impl Default for Histogram {
    fn default() -> Self {
        Self { counts: vec![0; BUCKETS], count: 0, max_s: 0.0 }
    }
}

impl Histogram {
    /// Counts a duration, s. Below 0 counts as 0, above a minute as a minute.
    pub fn add(&mut self, duration_s: f64) {
        // A float to an integer saturates, and NaN is 0.
        self.counts[bucket((duration_s * 1e9) as u64)] += 1;
        self.count += 1;
        self.max_s = self.max_s.max(duration_s);
    }

    /// The longest, s; 0 if none was counted.
    pub fn max_s(&self) -> f64 {
        self.max_s
    }

    /// The duration that `percent` % of all do not exceed, s: the upper end of its bucket, at most
    /// 3 % too long; 0 if none was counted.
    pub fn percentile_s(&self, percent: f64) -> f64 {
        // At least the first one, where `percent` is 0 or next to it.
        let rank = (percent / 100.0 * self.count as f64).ceil().max(1.0) as u64;
        let mut seen = 0;
        let reached = self.counts.iter().position(|count| {
            seen += count;
            seen >= rank
        });
        // A bucket ends above its values: the longest duration is the better bound where it is less.
        reached.map_or(0.0, |bucket| (upper_ns(bucket) * 1e-9).min(self.max_s))
    }

    /// Takes in another's counts.
    pub(crate) fn merge(&mut self, other: &Self) {
        self.counts.iter_mut().zip(&other.counts).for_each(|(mine, others)| *mine += others);
        self.count += other.count;
        self.max_s = self.max_s.max(other.max_s);
    }
}

/// The bucket of a duration: one each below `PER_OCTAVE` ns, then `PER_OCTAVE` to each doubling.
fn bucket(ns: u64) -> usize {
    let octave = (ns / PER_OCTAVE).checked_ilog2().map_or(0, |log| u64::from(log) + 1);
    let within = if octave == 0 { ns } else { (ns >> (octave - 1)) - PER_OCTAVE };
    ((octave * PER_OCTAVE + within) as usize).min(BUCKETS - 1)
}

/// Where a bucket ends, ns.
fn upper_ns(bucket: usize) -> f64 {
    let octave = bucket as u64 / PER_OCTAVE;
    let within = bucket as u64 % PER_OCTAVE;
    if octave == 0 { within as f64 } else { ((PER_OCTAVE + within + 1) << (octave - 1)) as f64 }
}

/// How well a loop kept its time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Timing {
    /// Ticks that ran.
    pub ticks: u64,
    /// Deadlines that passed without a tick, because the one before was too late or took too long.
    pub missed: u64,
    /// How late the ticks woke.
    pub lateness: Histogram,
    /// How long a tick's own work took, from reading to writing; nothing on a simulated clock.
    pub work: Histogram,
}

impl Timing {
    /// Counts the start of a tick.
    pub(crate) fn woke(&mut self, tick: &Tick) {
        self.missed += tick.missed;
        self.lateness.add(tick.late_s);
    }

    /// Counts the tick that then ran and took so long, s.
    pub(crate) fn ran(&mut self, work_s: f64) {
        self.ticks += 1;
        self.work.add(work_s);
    }

    /// Takes in the timing of another stretch.
    pub fn merge(&mut self, other: &Self) {
        self.ticks += other.ticks;
        self.missed += other.missed;
        self.lateness.merge(&other.lateness);
        self.work.merge(&other.work);
    }
}

/// Deadlines on a grid: `start + k·period`. A deadline that cannot be met any more is left out and
/// counted; ticks are never bunched up to catch up.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Pace {
    start_s: f64,
    period_s: f64,
    next: u64,
}

/// When a tick runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tick {
    /// Host time, s.
    pub(crate) now_s: f64,
    /// How late, s.
    pub(crate) late_s: f64,
    /// Deadlines missed since the tick before.
    pub(crate) missed: u64,
    /// The time that makes, s.
    pub(crate) missed_s: f64,
}

impl Pace {
    /// The first deadline is `start_s`.
    pub(crate) fn new(start_s: f64, period_s: f64) -> Self {
        Self { start_s, period_s, next: 0 }
    }

    /// Waits for the next deadline.
    pub(crate) fn wait(&mut self, clock: &mut dyn Clock) -> Tick {
        let deadline_s = self.start_s + self.next as f64 * self.period_s;
        let now_s = clock.wait_until(deadline_s);
        let late_s = now_s - deadline_s;
        // Whole periods: a tick that is late by less still runs as its own.
        let missed = (late_s / self.period_s) as u64;
        self.next += 1 + missed;
        Tick { now_s, late_s, missed, missed_s: missed as f64 * self.period_s }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_duration_lies_in_a_bucket_no_wider_than_one_part_in_32() {
        for ns in (0..40).map(|i| 3_u64.pow(i / 2) + u64::from(i)).filter(|ns| *ns < 60_000_000_000)
        {
            let upper = upper_ns(bucket(ns));
            assert!(
                upper >= ns as f64
                    && upper <= (ns as f64 * (1.0 + 1.0 / 32.0)).max(ns as f64 + 1.0),
                "{ns}"
            );
        }
        assert_eq!(bucket(u64::MAX), BUCKETS - 1);
    }

    #[test]
    fn percentiles_of_a_thousand_known_durations() {
        let mut histogram = Histogram::default();
        (1..=1000).for_each(|us| histogram.add(f64::from(us) * 1e-6));
        for (percent, expect_s) in
            [(50.0, 500e-6), (99.0, 990e-6), (99.9, 999e-6), (100.0, 1000e-6)]
        {
            let found_s = histogram.percentile_s(percent);
            assert!(found_s >= expect_s && found_s <= expect_s * 1.032, "{percent}: {found_s}");
        }
        assert!((histogram.max_s() - 1e-3).abs() < 1e-15);
    }

    #[test]
    fn two_halves_merged_are_the_whole() {
        let of = |range: std::ops::Range<u32>| {
            let mut histogram = Histogram::default();
            range.for_each(|i| histogram.add(f64::from(i) * 1.7e-6));
            histogram
        };
        let mut both = of(0..300);
        both.merge(&of(300..700));
        assert_eq!(both, of(0..700));
    }

    #[test]
    fn nothing_counted_is_nothing_and_nonsense_is_counted_as_nothing() {
        let mut histogram = Histogram::default();
        assert!(histogram.percentile_s(99.0) == 0.0);
        [f64::NAN, -1.0].into_iter().for_each(|s| histogram.add(s));
        assert!(histogram.percentile_s(100.0) == 0.0);
    }

    /// A clock that wakes as late as it is told.
    struct Late(Vec<f64>);
    impl Clock for Late {
        fn now_s(&mut self) -> f64 {
            0.0
        }
        fn wait_until(&mut self, deadline_s: f64) -> f64 {
            deadline_s + self.0.remove(0)
        }
    }

    #[test]
    fn deadlines_that_passed_are_counted_and_not_made_up_for() {
        let mut clock = Late(vec![0.0, 0.000_9, 0.003_5, 0.0]);
        let mut pace = Pace::new(10.0, 0.001);
        let ticks: Vec<_> = (0..4).map(|_| pace.wait(&mut clock)).collect();
        assert_eq!(ticks.iter().map(|t| t.missed).collect::<Vec<_>>(), [0, 0, 3, 0]);
        assert!((ticks[3].now_s - 10.006).abs() < 1e-9); // not 10.003
    }
}
