//! A trial in real time: the loop on a thread of its own, samples through a wait-free ring to the caller.

use super::{TrialEnd, TrialPlan, TrialRun, run_trial};
use crate::{Clock, Controller, Device, Guard, Priority, Timing, Trip};
use rtrb::{Consumer, Producer, RingBuffer};
use std::any::Any;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::Duration;
use zwidth_study::{Flags, Sample};

/// The caller may be busy for this long before samples are lost, s.
const RING_S: f64 = 10.0;

/// How often the caller is given what has come: no more is lost by a kill than this and one write of the journal.
const POLL: Duration = Duration::from_millis(5);

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

/// Runs [`run_trial`] on a thread of its own, at an elevated priority where that is allowed. Meanwhile the caller's
/// thread is given the samples that have come, every 5 ms; the batch may be empty. Files and screens are its
/// business: however long it takes, the loop does not wait for it. Should it fall 10 s behind, samples are lost,
/// counted, and the trial does not count as run to its end.
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
    let capacity = (RING_S * plan.rate_hz).ceil() as usize;
    let unwatched = guard.unwatched();
    let shared = Shared::default();
    let (producer, mut consumer) = RingBuffer::new(capacity);
    let outcome = thread::scope(|scope| {
        let running = scope.spawn(|| {
            let priority = Priority::raise();
            let mut sink = shared.sink(producer);
            (run_trial(device, clock, controller, guard, plan, stop, &mut sink), priority)
        });
        let _abandon = Abandon(&shared.abandoned);
        while !running.is_finished() {
            hand_over(&mut consumer, batch, &shared);
            thread::sleep(POLL);
        }
        hand_over(&mut consumer, batch, &shared);
        running.join()
    });
    shared.conclude(outcome, unwatched)
}

/// Runs `work` in real time, on a thread of its own at an elevated priority where that is allowed: what reads and writes a
/// device without keeping samples, as its check does.
///
/// # Errors
/// [`Trip::Panic`] if it panics.
pub fn in_real_time<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T, Trip> {
    let running = || {
        Priority::raise();
        work()
    };
    let outcome = thread::scope(|scope| scope.spawn(running).join());
    outcome.map_err(|panic| Trip::Panic { what: said(&*panic) })
}

/// What the two threads tell each other.
#[derive(Debug, Default)]
struct Shared {
    /// The caller can keep no more samples.
    abandoned: AtomicBool,
    /// Samples that found the ring full.
    lost: AtomicU64,
}

impl Shared {
    /// The loop's side of the ring. The sample after lost ones says that some are missing.
    fn sink(&self, mut ring: Producer<Sample>) -> impl FnMut(&Sample) -> ControlFlow<()> {
        let mut gap = false;
        move |sample| {
            let flags = sample.flags.with(Flags::DROPOUT, gap);
            gap = ring.push(Sample { flags, ..*sample }).is_err();
            self.lost.fetch_add(u64::from(gap), Ordering::Relaxed);
            if self.abandoned.load(Ordering::Relaxed) {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        }
    }

    fn conclude(&self, outcome: thread::Result<(TrialRun, Priority)>, unwatched: bool) -> LiveRun {
        let lost = self.lost.load(Ordering::Relaxed);
        let (mut run, priority) = outcome.unwrap_or_else(|panic| {
            let end = TrialEnd::Tripped(Trip::Panic { what: said(&*panic) });
            (TrialRun { end, timing: Timing::default(), unwatched }, Priority::Ordinary)
        });
        let tripped = matches!(run.end, TrialEnd::Tripped(_));
        if self.abandoned.load(Ordering::Relaxed) && !tripped {
            run.end = TrialEnd::Tripped(Trip::Storage); // it could not keep what came last
        } else if lost > 0 && !tripped {
            run.end = TrialEnd::Tripped(Trip::SamplesLost { lost });
        }
        LiveRun { run, lost, priority }
    }
}

/// Gives the caller what has come.
fn hand_over(ring: &mut Consumer<Sample>, batch: &mut BatchSink<'_>, shared: &Shared) {
    let Ok(chunk) = ring.read_chunk(ring.slots()) else { return };
    let (first, second) = chunk.as_slices();
    let kept = batch(first).is_continue() && (second.is_empty() || batch(second).is_continue());
    chunk.commit_all();
    if !kept {
        shared.abandoned.store(true, Ordering::Relaxed);
    }
}

/// Ends the trial if the caller's thread unwinds.
struct Abandon<'a>(&'a AtomicBool);

impl Drop for Abandon<'_> {
    fn drop(&mut self) {
        if thread::panicking() {
            self.0.store(true, Ordering::Relaxed);
        }
    }
}

/// The text of a panic.
fn said(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "it did not say why".to_owned())
}

#[cfg(test)]
mod tests {
    use super::super::tests::{bench, plan};
    use super::*;
    use crate::mock::{Fault, Mock};
    use crate::{RealClock, SimulatedClock};
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
    fn a_panic_in_real_time_is_a_trip_that_says_why() {
        assert_eq!(in_real_time(|| 7), Ok(7));
        let trip = in_real_time(|| -> u8 { panic!("out of cheese") }).unwrap_err();
        assert!(trip.to_string().contains("out of cheese"), "{trip}");
    }

    #[test]
    fn the_samples_are_those_of_the_loop_without_a_thread() {
        let mut samples = Vec::new();
        let (run, _) = live(Mock::default(), &mut collect(&mut samples));
        let (mut direct, mut bench) = (Vec::new(), bench(Mock::default()));
        let mut sink = |sample: &Sample| {
            direct.push(*sample);
            ControlFlow::Continue(())
        };
        let (plan, stop) = (plan(&bench.environment), AtomicBool::new(false));
        let mut clock = SimulatedClock::new(1);
        let expect = run_trial(
            &mut bench.device,
            &mut clock,
            &mut bench.controller,
            &mut bench.guard,
            &plan,
            &stop,
            &mut sink,
        );
        assert_eq!((run.run, run.lost), (expect, 0));
        assert_eq!(samples, direct);
    }

    #[test]
    fn real_time_on_a_thread_ends_at_0_v_and_loses_nothing() {
        let mut bench = bench(Mock::default());
        let (mut clock, stop) = (RealClock::faster(20.0).unwrap(), AtomicBool::new(false));
        let mut plan = plan(&bench.environment);
        (plan.rate_hz, plan.cue.limit_s) = (100.0, 0.5);
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
        let TrialEnd::Tripped(Trip::Panic { what }) = run.run.end else { panic!("{:?}", run.run.end) };
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
        let shared = Shared::default();
        let (producer, mut consumer) = RingBuffer::new(3);
        let mut sink = shared.sink(producer);
        let mut samples = Vec::new();
        live(Mock::default(), &mut collect(&mut samples));
        samples[..5].iter().for_each(|sample| assert!(sink(sample).is_continue()));
        let kept: Vec<_> = std::iter::from_fn(|| consumer.pop().ok()).collect();
        assert_eq!(kept, samples[..3]);
        assert!(sink(&samples[5]).is_continue());
        assert!(consumer.pop().unwrap().flags.has(Flags::DROPOUT));
        let run = TrialRun { end: TrialEnd::Limit, timing: Timing::default(), unwatched: false };
        let concluded = shared.conclude(Ok((run, Priority::Ordinary)), false);
        assert_eq!(concluded.lost, 2);
        assert_eq!(concluded.run.end, TrialEnd::Tripped(Trip::SamplesLost { lost: 2 }));
    }
}
