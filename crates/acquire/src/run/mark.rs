//! Markers of a trial: found among its samples, sent, and kept in the session's log.

use super::{Ran, Runner};
use crate::AcquireError;
use crate::markers::{Marker, Markers};
use zwidth_device::Moments;
use zwidth_study::{Event, Moment, Sample};

/// Finds the markers of a running trial and sends them; they are kept until it has ended.
pub(super) struct Marking<'a> {
    markers: &'a Markers,
    trial: u32,
    sent: Vec<Marker>,
    /// The last sample's times, s.
    last: Option<(f64, Option<f64>)>,
    moments: Moments,
}

impl<'a> Marking<'a> {
    pub(super) fn new(markers: &'a Markers, trial: u32) -> Self {
        Self { markers, trial, sent: Vec::new(), last: None, moments: Moments::default() }
    }

    pub(super) fn add(&mut self, sample: &Sample) {
        let Sample { t_s, t_device_s, .. } = *sample;
        self.last = Some((t_s, t_device_s));
        self.moments.of(sample.flags).for_each(|moment| self.send(moment, t_s, t_device_s));
    }

    /// After the last sample: its time, s, and the markers.
    pub(super) fn end(mut self) -> (Option<f64>, Vec<Marker>) {
        if let Some((end, (t_s, t_device_s))) = self.moments.end().zip(self.last) {
            self.send(end, t_s, t_device_s);
        }
        (self.last.map(|(t_s, _)| t_s), self.sent)
    }

    fn send(&mut self, moment: Moment, t_s: f64, t_device_s: Option<f64>) {
        if self.markers.are_on() {
            let marker = Marker { trial: self.trial, moment, t_s, t_device_s };
            self.markers.send(marker);
            self.sent.push(marker);
        }
    }
}

impl Runner<'_> {
    /// Keeps what was sent of a trial that began then by the machine's monotonic clock, s.
    pub(super) fn keep_markers(
        &mut self,
        sent: &[Marker],
        monotonic_s: Option<f64>,
    ) -> Result<(), AcquireError> {
        if sent.is_empty() {
            return Ok(());
        }
        let events: Vec<Event> = sent.iter().map(|marker| event(marker, monotonic_s)).collect();
        self.keep(&events)
    }

    /// The answer to the trial that ran last; one that is given later is no moment of a recording.
    pub(super) fn mark_answer(&mut self, trial: u32) -> Result<(), AcquireError> {
        let Some(Ran { ended_s, last_s, monotonic_s, .. }) =
            self.ran.filter(|ran| ran.trial == trial)
        else {
            return Ok(());
        };
        if !self.markers.are_on() {
            return Ok(());
        }
        if self.shows_moments() {
            // A device that is lost shows no more: the next trial finds it.
            let _ = self.attendant.ask(|station| station.device.mark(Moment::Answer));
        }
        let t_s = last_s + (self.attendant.now_s() - ended_s);
        let marker = Marker { trial, moment: Moment::Answer, t_s, t_device_s: None };
        self.markers.send(marker);
        self.keep_markers(&[marker], monotonic_s)
    }

    /// Tells what could not be sent, and keeps a note of it.
    pub(super) fn tell_unsent(&mut self) -> Result<(), AcquireError> {
        for text in self.markers.failures() {
            self.log(Event::Note { trial: None, text })?;
        }
        Ok(())
    }
}

fn event(marker: &Marker, begun_monotonic_s: Option<f64>) -> Event {
    let Marker { trial, moment, t_s, t_device_s } = *marker;
    Event::Marker {
        trial,
        moment,
        t_us: micros(t_s),
        device_us: t_device_s.map(micros),
        monotonic_us: begun_monotonic_s.map(|begun_s| micros(begun_s + t_s)),
    }
}

/// A time in whole microseconds. One below 0 or past every session has no place in a log: it is held
/// to the nearest.
fn micros(time_s: f64) -> u64 {
    (time_s * 1e6).round() as u64
}
