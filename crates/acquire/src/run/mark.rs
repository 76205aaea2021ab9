//! Markers of a trial: found among its samples, sent, and kept in the session's log.

use super::Runner;
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
        let at = (sample.t_s, sample.t_device_s);
        self.last = Some(at);
        self.moments.of(sample.flags).for_each(|moment| self.send(moment, at));
    }

    /// After the last sample: its time, s, and the markers.
    pub(super) fn end(mut self) -> (Option<f64>, Vec<Marker>) {
        if let Some((end, at)) = self.moments.end().zip(self.last) {
            self.send(end, at);
        }
        (self.last.map(|(t_s, _)| t_s), self.sent)
    }

    fn send(&mut self, moment: Moment, (t_s, t_device_s): (f64, Option<f64>)) {
        if self.markers.are_on() {
            let marker = Marker { trial: self.trial, moment, t_s, t_device_s };
            self.markers.send(marker);
            self.sent.push(marker);
        }
    }
}

impl Runner<'_> {
    /// Keeps what was sent of a trial.
    pub(super) fn keep_markers(&mut self, sent: &[Marker]) -> Result<(), AcquireError> {
        if sent.is_empty() {
            return Ok(());
        }
        let events: Vec<Event> = sent.iter().map(event).collect();
        self.keep(&events)
    }

    /// The answer to the trial that ran last; one that is given later is no moment of a recording.
    pub(super) fn mark_answer(&mut self, trial: u32) -> Result<(), AcquireError> {
        let Some((_, ended_s, t_s)) = self.ran.filter(|(ran, ..)| *ran == trial) else {
            return Ok(());
        };
        if !self.markers.are_on() {
            return Ok(());
        }
        if self.shows_moments() {
            // A device that is lost shows no more: the next trial finds it.
            let _ = self.attendant.ask(|station| station.device.mark(Moment::Answer));
        }
        let t_s = t_s + (self.attendant.now_s() - ended_s);
        let marker = Marker { trial, moment: Moment::Answer, t_s, t_device_s: None };
        self.markers.send(marker);
        self.keep_markers(&[marker])
    }

    /// Tells what could not be sent, and keeps a note of it.
    pub(super) fn tell_unsent(&mut self) -> Result<(), AcquireError> {
        let note = |text| Event::Note { trial: None, text };
        self.markers.failures().into_iter().try_for_each(|what| self.log(note(what)))
    }
}

fn event(marker: &Marker) -> Event {
    // A time below 0 or past every session has no place in a log: it is held to the nearest.
    let us = |s: f64| (s * 1e6).round() as u64;
    let Marker { trial, moment, t_s, t_device_s } = *marker;
    Event::Marker { trial, moment, t_us: us(t_s), device_us: t_device_s.map(us) }
}
