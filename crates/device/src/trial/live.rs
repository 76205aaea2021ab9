//! A trial in real time: the loop on a thread of its own, samples through a wait-free ring to the
//! caller.

use super::{Sink, TrialEnd, TrialPlan, TrialRun, run_trial};
use crate::{Clock, Controller, Device, Guard, Priority, Trip};
use rtrb::{Consumer, Producer, RingBuffer};
use std::any::Any;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::Duration;
use zwidth_study::{Flags, Sample};

/// The caller may be busy for this long before samples are lost, s.
const RING_S: f64 = 10.0;

/// How often the caller is given what has come: no more is lost by a kill than this and one write
/// of the journal.
pub(crate) const POLL: Duration = Duration::from_millis(5);

/// Where samples go, in batches, on the caller's thread. Break: they cannot be kept any more.
pub type BatchSink<'a> = dyn FnMut(&[Sample]) -> ControlFlow<()> + 'a;

/// A trial that has run in real time.
#[derive(Debug, Clone, PartialEq)]
pub struct LiveRun {
    /// As [`run_trial`] gives it.
    pub run: TrialRun,
    /// Samples that found the ring full. Above 0 the trial's end is [`Trip::SamplesLost`].
    pub lost: u64,
    /// Whether the loop's thread came before others.
    pub priority: Priority,
}

/// Runs [`run_trial`] on a thread of its own, at an elevated priority where that is allowed.
/// Meanwhile the caller's thread is given the samples that have come, every 5 ms; the batch may be
/// empty. It handles files and screens: however long it takes, the loop does not wait for it.
/// Should it fall 10 s behind, samples are lost, counted, and the trial does not count as run to
/// its end. Nobody reads the device before or after: a session of trials is run by
/// [`crate::Attendant`].
///
/// A panic of the loop is a [`Trip::Panic`]; a panic of `batch` stops the trial and goes on.
pub fn run_live(
    device: &mut dyn Device,
    clock: &mut dyn Clock,
    controller: &mut Controller,
    guard: &mut Guard,
    plan: &TrialPlan<'_>,
    stop: &AtomicBool,
    batch: &mut BatchSink<'_>,
) -> LiveRun {
    let (mut collected, mut ring) = Collected::new(plan.rate_hz);
    let outcome = thread::scope(|scope| {
        let running = scope.spawn(|| {
            let priority = Priority::raise();
            let mut sink = |sample: &Sample| ring.push(sample);
            (run_caught(device, clock, controller, guard, plan, stop, &mut sink), priority)
        });
        // A panic of `batch` ends the trial; without this the scope would wait for its limit.
        let _abandon = collected.abandon_on_panic();
        while !running.is_finished() {
            collected.hand_over(batch);
            thread::sleep(POLL);
        }
        collected.hand_over(batch);
        running.join()
    });
    let (run, priority) = outcome
        .unwrap_or_else(|panic| (TrialRun::tripped(panic_trip(&*panic)), Priority::Ordinary));
    let run = collected.conclude(run);
    LiveRun { run, lost: collected.lost(), priority }
}

/// [`run_trial`], of which a panic is a [`Trip::Panic`].
pub(crate) fn run_caught(
    device: &mut dyn Device,
    clock: &mut dyn Clock,
    controller: &mut Controller,
    guard: &mut Guard,
    plan: &TrialPlan<'_>,
    stop: &AtomicBool,
    sink: &mut Sink<'_>,
) -> TrialRun {
    // Asked now: the end of a trial disarms the guard, which then allows no motor.
    let unwatched = guard.unwatched();
    catch_unwind(AssertUnwindSafe(|| run_trial(device, clock, controller, guard, plan, stop, sink)))
        .unwrap_or_else(|panic| TrialRun { unwatched, ..TrialRun::tripped(panic_trip(&*panic)) })
}

/// What the two threads tell each other.
#[derive(Debug, Default)]
struct Shared {
    /// The caller can keep no more samples.
    abandoned: AtomicBool,
    /// Samples that found the ring full.
    lost: AtomicU64,
}

/// The loop's side of the ring that samples go through.
pub(crate) struct SampleRing {
    ring: Producer<Sample>,
    shared: Arc<Shared>,
    /// The sample before found the ring full.
    gap: bool,
}

impl SampleRing {
    /// Hands a sample over; the one after lost ones says that some are missing. Break: nobody can
    /// keep it.
    pub(crate) fn push(&mut self, sample: &Sample) -> ControlFlow<()> {
        let flags = sample.flags.with(Flags::DROPOUT, self.gap);
        self.gap = self.ring.push(Sample { flags, ..*sample }).is_err();
        self.shared.lost.fetch_add(u64::from(self.gap), Ordering::Relaxed);
        if self.shared.abandoned.load(Ordering::Relaxed) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

/// The caller's side of that ring.
pub(crate) struct Collected {
    ring: Consumer<Sample>,
    shared: Arc<Shared>,
}

impl Collected {
    /// A ring for [`RING_S`] of samples, both its sides.
    pub(crate) fn new(rate_hz: f64) -> (Self, SampleRing) {
        Self::with_room((RING_S * rate_hz).ceil() as usize)
    }

    fn with_room(samples: usize) -> (Self, SampleRing) {
        let shared = Arc::<Shared>::default();
        let (producer, consumer) = RingBuffer::new(samples);
        let loop_side = SampleRing { ring: producer, shared: Arc::clone(&shared), gap: false };
        (Self { ring: consumer, shared }, loop_side)
    }

    /// Gives `batch` what has come.
    pub(crate) fn hand_over(&mut self, batch: &mut BatchSink<'_>) {
        let Ok(chunk) = self.ring.read_chunk(self.ring.slots()) else { return };
        let (first, second) = chunk.as_slices();
        // The first part may be empty; the caller has its turn all the same.
        let kept = batch(first).is_continue() && (second.is_empty() || batch(second).is_continue());
        chunk.commit_all();
        if !kept {
            self.shared.abandoned.store(true, Ordering::Relaxed);
        }
    }

    /// Ends the trial if the caller's thread unwinds while this lives.
    pub(crate) fn abandon_on_panic(&self) -> Abandon {
        Abandon(Arc::clone(&self.shared))
    }

    fn lost(&self) -> u64 {
        self.shared.lost.load(Ordering::Relaxed)
    }

    /// The run, tripped if its samples did not get through.
    pub(crate) fn conclude(&self, mut run: TrialRun) -> TrialRun {
        let lost = self.lost();
        // What tripped it is the cause; samples that are missing follow from it.
        let tripped = matches!(run.end, TrialEnd::Tripped(_));
        if self.shared.abandoned.load(Ordering::Relaxed) && !tripped {
            run.end = TrialEnd::Tripped(Trip::Storage); // it could not keep what came last
        } else if lost > 0 && !tripped {
            run.end = TrialEnd::Tripped(Trip::SamplesLost { lost });
        }
        run
    }
}

/// Ends the trial if the caller's thread unwinds.
pub(crate) struct Abandon(Arc<Shared>);

impl Drop for Abandon {
    fn drop(&mut self) {
        if thread::panicking() {
            self.0.abandoned.store(true, Ordering::Relaxed);
        }
    }
}

/// The trip that a panic stands for.
pub(crate) fn panic_trip(panic: &(dyn Any + Send)) -> Trip {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let text = text.or_else(|| panic.downcast_ref::<String>().cloned());
    Trip::Panic { what: text.unwrap_or_else(|| "it did not say why".to_owned()) }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{bench, plan};
    use super::*;
    use crate::mock::{Fault, Mock};
    use crate::{RealClock, SimulatedClock, Timing};
    use zwidth_study::Voltages;

    fn live(device: Mock, batch: &mut BatchSink<'_>) -> (LiveRun, Mock) {
        let mut bench = bench(device);
        let (mut clock, stop) = (SimulatedClock::new(1), AtomicBool::new(false));
        let plan = plan(&bench.environment);
        let run = run_live(
            &mut bench.device,
            &mut clock,
            &mut bench.controller,
            &mut bench.guard,
            &plan,
            &stop,
            batch,
        );
        assert!(!bench.guard.is_armed());
        (run, bench.device)
    }

    fn collect(samples: &mut Vec<Sample>) -> impl FnMut(&[Sample]) -> ControlFlow<()> {
        |batch| {
            samples.extend_from_slice(batch);
            ControlFlow::Continue(())
        }
    }

    #[test]
    fn the_samples_are_those_of_the_loop_without_a_thread() {
        let mut samples = Vec::new();
        let (run, _) = live(Mock::default(), &mut collect(&mut samples));
        let (expect, direct) = bench(Mock::default()).run();
        assert_eq!((run.run, run.lost), (expect, 0));
        assert_eq!(samples, direct);
    }

    #[test]
    fn real_time_on_a_thread_ends_at_0_v_and_loses_nothing() {
        let mut bench = bench(Mock::default());
        let (mut clock, stop) = (RealClock::new(), AtomicBool::new(false));
        let mut plan = plan(&bench.environment);
        (plan.rate_hz, plan.cue.limit_s) = (1000.0, 0.05);
        let mut samples = Vec::new();
        let run = run_live(
            &mut bench.device,
            &mut clock,
            &mut bench.controller,
            &mut bench.guard,
            &plan,
            &stop,
            &mut collect(&mut samples),
        );
        assert_eq!((run.lost, run.run.timing.ticks), (0, samples.len() as u64));
        assert!(samples.windows(2).all(|pair| pair[1].t_s > pair[0].t_s));
        assert_eq!(bench.device.writes.last().unwrap().1, Voltages::OFF);
    }

    #[test]
    fn a_panic_of_the_loop_ends_at_0_v_and_says_what_it_was() {
        let (run, device) =
            live(Mock::default().failing(0.6, Fault::Panic), &mut |_| ControlFlow::Continue(()));
        let TrialEnd::Tripped(Trip::Panic { what }) = run.run.end else {
            panic!("{:?}", run.run.end)
        };
        assert!(what.contains("asked to"));
        assert_eq!(device.writes.last().unwrap().1, Voltages::OFF);
    }

    #[test]
    fn a_caller_that_can_keep_no_more_ends_the_trial() {
        let (run, device) = live(Mock::default(), &mut |batch| {
            if batch.is_empty() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        assert_eq!(run.run.end, TrialEnd::Tripped(Trip::Storage));
        assert_eq!(device.writes.last().unwrap().1, Voltages::OFF);
    }

    #[test]
    fn samples_that_find_the_ring_full_are_counted_flagged_and_an_error_at_the_end() {
        let (mut collected, mut ring) = Collected::with_room(3);
        let mut samples = Vec::new();
        live(Mock::default(), &mut collect(&mut samples));
        samples[..5].iter().for_each(|sample| assert!(ring.push(sample).is_continue()));
        let mut kept = Vec::new();
        collected.hand_over(&mut collect(&mut kept));
        assert_eq!(kept, samples[..3]);
        assert!(ring.push(&samples[5]).is_continue());
        collected.hand_over(&mut collect(&mut kept));
        assert!(kept[3].flags.has(Flags::DROPOUT));
        let run = TrialRun {
            end: TrialEnd::Limit,
            begun_s: None,
            timing: Timing::default(),
            unwatched: false,
        };
        assert_eq!(collected.lost(), 2);
        assert_eq!(collected.conclude(run).end, TrialEnd::Tripped(Trip::SamplesLost { lost: 2 }));
    }
}
