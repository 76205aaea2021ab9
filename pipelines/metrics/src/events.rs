//! What happened in a trial, and when: what a reader of its curves wants marked.

use crate::MetricsError;
use crate::movement::Movement;
use crate::signals::Signals;
use crate::wall::contacts;
use zwidth_study::TrialMeta;
use zwidth_tables::{Column, Table, TableError, identity};

/// Something that happens in a trial.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum EventKind {
    /// The movement begins ([`Movement::onset_s`]).
    Onset,
    /// A contact with the wall begins: the first sample with θ > θ_wall after a retreat of more
    /// than 1 % of the angles travelled, as [`WallContact::rebounds`](crate::WallContact::rebounds)
    /// counts.
    Contact,
    /// The lever turns ([`Movement::reversal_s`]).
    Reversal,
    /// The brake goes off from one sample to the next, wherever the lever is.
    /// [`WallContact::brake_releases`](crate::WallContact::brake_releases) counts those past the
    /// wall.
    LetGo,
    /// The movement ends ([`Movement::end_s`]).
    End,
}

impl EventKind {
    /// Its word in tables.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Onset => "onset",
            Self::Contact => "contact",
            Self::Reversal => "reversal",
            Self::LetGo => "let_go",
            Self::End => "end",
        }
    }
}

/// One of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrialEvent {
    /// What happened.
    pub kind: EventKind,
    /// When, as the trial's samples count their time, s.
    pub t_s: f64,
}

/// In the order of time. Kinds that the recording does not tell are left out.
pub(crate) fn trial_events(
    signals: &Signals,
    movement: &Movement,
    wall_rad: Option<f64>,
) -> Result<Vec<TrialEvent>, MetricsError> {
    let moved = [
        (EventKind::Onset, movement.onset_s),
        (EventKind::Reversal, movement.reversal_s),
        (EventKind::End, movement.end_s),
    ];
    let moved = moved.into_iter().filter_map(|(kind, t_s)| Some(TrialEvent { kind, t_s: t_s? }));
    let touched = wall_rad.and_then(|wall| Some(contacts(&signals.theta()?, wall)));
    let t = signals.t()?;
    let at = |kind, i: usize| TrialEvent { kind, t_s: t[i] };
    let touched = touched.unwrap_or_default().into_iter();
    let on = signals.brake_on.as_deref().unwrap_or_default();
    let let_go = (1..on.len()).filter(|i| on[i - 1] && !on[*i]);
    let mut events: Vec<TrialEvent> = moved
        .chain(touched.map(|contact| at(EventKind::Contact, contact.first)))
        .chain(let_go.map(|i| at(EventKind::LetGo, i)))
        .collect();
    events.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
    Ok(events)
}

/// One row per event of trials, in the order given: which trial it is, `event`, `t_s`.
///
/// # Errors
/// A time that is not finite.
pub fn events_table(trials: &[(&TrialMeta, &[TrialEvent])]) -> Result<Table, TableError> {
    let each =
        || trials.iter().flat_map(|(meta, events)| events.iter().map(move |event| (*meta, event)));
    let mut columns = identity(&each().map(|(meta, _)| meta).collect::<Vec<_>>());
    let kind = each().map(|(_, event)| Some(event.kind.as_str().to_owned()));
    columns.push(Column::text("event", "onset, contact, reversal, let_go or end", kind));
    let time = each().map(|(_, event)| Some(event.t_s));
    columns.push(Column::float("t_s", "s", "when, as the trial's samples count time", time));
    Table::new("events", "What happened in each trial, one row per event", columns)
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

    fn kinds(events: &[TrialEvent]) -> Vec<&'static str> {
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
        let table = events_table(&[(&found.meta, &found.events)]).unwrap();
        assert_eq!(table.height(), 3);
        let words = table.texts("event").unwrap();
        assert_eq!(words[1].as_deref(), Some("reversal"));
    }
}
