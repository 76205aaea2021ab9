//! What happened in a trial, and when: the marks for readers of its curves.

use crate::MetricsError;
use crate::movement::Movement;
use crate::signals::Signals;
use crate::wall::contacts;
use zwidth_results::{EventKind, TrialEvent, TrialKey};
use zwidth_study::TrialMeta;

/// Something that happened, and when.
///
/// [`EventKind::Onset`], [`EventKind::Reversal`] and [`EventKind::End`] are
/// [`Movement::onset_s`], [`Movement::reversal_s`] and [`Movement::end_s`]; contacts are counted as
/// [`WallContact::rebounds`](crate::WallContact::rebounds) are, and of the times at which the brake
/// goes off those past the wall are
/// [`WallContact::brake_releases`](crate::WallContact::brake_releases).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimedEvent {
    /// What happened.
    pub kind: EventKind,
    /// When, as the trial's samples count their time, s.
    pub t_s: f64,
}

impl TimedEvent {
    /// The event of a trial.
    pub fn of(self, trial: &TrialMeta) -> TrialEvent {
        let TrialKey { participant, session, trial, repeat, environment, mode, source } =
            trial.into();
        let Self { kind: event, t_s } = self;
        TrialEvent { participant, session, trial, repeat, environment, mode, source, event, t_s }
    }
}

/// In the order of time. Kinds that the recording does not tell are left out.
pub(crate) fn trial_events(
    signals: &Signals,
    movement: &Movement,
    wall_rad: Option<f64>,
) -> Result<Vec<TimedEvent>, MetricsError> {
    let moved = [
        (EventKind::Onset, movement.onset_s),
        (EventKind::Reversal, movement.reversal_s),
        (EventKind::End, movement.end_s),
    ];
    let moved = moved.into_iter().filter_map(|(kind, t_s)| Some(TimedEvent { kind, t_s: t_s? }));
    let touched = wall_rad.and_then(|wall| Some(contacts(&signals.theta()?, wall)));
    let t = signals.t()?;
    let touched = touched.unwrap_or_default().into_iter();
    let touched =
        touched.map(|contact| TimedEvent { kind: EventKind::Contact, t_s: t[contact.first] });
    let on = signals.brake_on.as_deref().unwrap_or_default();
    let let_go = (1..on.len()).filter(|i| on[i - 1] && !on[*i]);
    let let_go = let_go.map(|i| TimedEvent { kind: EventKind::LetGo, t_s: t[i] });
    let mut events: Vec<TimedEvent> = moved.chain(touched).chain(let_go).collect();
    // Stable: of one time, the order above.
    events.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
    Ok(events)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{REST_RAD, at_wall, in_spring, stroke, trial};
    use crate::trial_metrics;
    use zwidth_store::Signal;

    /// A stroke of 1 rad in 2 s from the rest, its brake on while `on`.
    fn braked(on: impl Fn(f64) -> bool) -> zwidth_store::Trial {
        let mut trial = trial(&stroke(1.0, 2.0), |theta, _| 4.0 * (theta - REST_RAD));
        let times = trial.samples.get(Signal::Time).unwrap().to_vec();
        let bits = times.iter().map(|t| if on(*t) { 128.0 } else { 0.0 }).collect();
        trial.samples.set(Signal::StateBits, bits);
        trial
    }

    fn kinds(events: &[TimedEvent]) -> Vec<&'static str> {
        events.iter().map(|event| event.kind.as_str()).collect()
    }

    #[test]
    fn a_stroke_through_the_wall_begins_touches_turns_lets_go_and_ends() {
        let trial = braked(|t| (0.6..1.7).contains(&t));
        let highest =
            trial.samples.get(Signal::Theta).unwrap().iter().copied().fold(-9.0, f64::max);
        let row = trial_metrics(&trial, &at_wall(4.0, REST_RAD, highest - 0.1)).unwrap();
        assert_eq!(kinds(&row.events), ["onset", "contact", "reversal", "let_go", "end"]);
        let times: Vec<f64> = row.events.iter().map(|event| event.t_s).collect();
        assert_eq!(row.movement.onset_s, Some(times[0]));
        assert_eq!(row.movement.reversal_s, Some(times[2]));
        assert!((times[3] - 1.7).abs() < 2e-3, "{times:?}");
        let [t, theta] =
            [Signal::Time, Signal::Theta].map(|signal| trial.samples.get(signal).unwrap());
        let first = theta.iter().position(|theta| *theta > highest - 0.1).unwrap();
        assert!((t[first] - times[1]).abs() < 1e-12, "the first sample past the wall");
    }

    #[test]
    fn without_a_wall_and_a_brake_a_stroke_has_no_contact_and_lets_nothing_go() {
        let found = trial_metrics(&braked(|_| false), &in_spring(4.0, REST_RAD)).unwrap();
        assert_eq!(kinds(&found.events), ["onset", "reversal", "end"]);
        let row = found.events[1].of(&found.meta);
        assert_eq!((row.trial, row.event), (found.meta.trial, EventKind::Reversal));
    }
}
