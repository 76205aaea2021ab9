//! The mixed model of a study: participants who did repeated trials in modes, in one or more
//! sessions.
//!
//! The fixed effects are the means of the cells (session × mode), so nothing is assumed about how
//! sessions and modes combine; a contrast of modes averages the sessions' contrasts equally. The
//! random effects are those of participants and of their combinations with mode and session, as
//! many as the design can separate: repeats of one person are not people, and neither are sessions.

use super::fit::{Criterion, Fit, fit};
use super::model::{Column, Model, RandomTerm};
use crate::error::StatsError;
use crate::tested::Unestimable;
use std::collections::{BTreeMap, BTreeSet};
use zwidth_numerics::NumericsError;

/// Trials as columns of a tidy table. Participants, sessions and modes are any numbers.
#[derive(Debug, Clone, Copy)]
pub struct Trials<'a> {
    /// The participant of each trial.
    pub participant: &'a [usize],
    /// The session of each trial.
    pub session: &'a [usize],
    /// The mode of each trial.
    pub mode: &'a [usize],
    /// The metric of each trial.
    pub value: &'a [f64],
}

/// A random term of a study, beside the residual.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Term {
    /// A participant's own level.
    Participant,
    /// A participant's own effect of a mode.
    ParticipantMode,
    /// A participant's own level in a session.
    ParticipantSession,
    /// A participant's own effect of a mode in a session.
    ParticipantSessionMode,
}

impl Term {
    /// Its name, as in a table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Participant => "participant",
            Self::ParticipantMode => "participant × mode",
            Self::ParticipantSession => "participant × session",
            Self::ParticipantSessionMode => "participant × session × mode",
        }
    }

    /// Whether its levels differ by mode, by session.
    fn varies(self) -> (bool, bool) {
        match self {
            Self::Participant => (false, false),
            Self::ParticipantMode => (true, false),
            Self::ParticipantSession => (false, true),
            Self::ParticipantSessionMode => (true, true),
        }
    }
}

/// Structures from the largest on.
const STRUCTURES: [&[Term]; 5] = [
    &[
        Term::Participant,
        Term::ParticipantMode,
        Term::ParticipantSession,
        Term::ParticipantSessionMode,
    ],
    &[Term::Participant, Term::ParticipantMode, Term::ParticipantSession],
    &[Term::Participant, Term::ParticipantMode],
    &[Term::Participant, Term::ParticipantSession],
    &[Term::Participant],
];

/// The fitted model of a study's trials.
#[derive(Debug, Clone)]
pub struct TrialFit {
    /// The fit; its coefficients are the means of `cells`.
    pub fit: Fit,
    /// Session and mode of each coefficient, sorted.
    pub cells: Vec<(usize, usize)>,
    /// The random terms of the largest structure that the design supports.
    pub structure: &'static [Term],
}

/// Fits the largest structure that the design supports, by REML.
///
/// # Errors
/// As [`fit()`]: columns of different lengths, fewer than two participants, a participant's effect
/// that cannot be told from the residual (one trial each).
pub fn fit_trials(trials: Trials<'_>) -> Result<TrialFit, Unestimable> {
    check(trials)?;
    let people: BTreeSet<usize> = trials.participant.iter().copied().collect();
    if people.len() < 2 {
        return Err(Unestimable::TooFew { units: "participants", found: people.len(), needed: 2 });
    }
    let cells: Vec<(usize, usize)> =
        trials.session.iter().copied().zip(trials.mode.iter().copied()).collect();
    let cells: Vec<(usize, usize)> =
        cells.into_iter().collect::<BTreeSet<_>>().into_iter().collect();
    let mut refused = None;
    for structure in STRUCTURES.into_iter().filter(|terms| may_support(trials, terms)) {
        match fit(&model(trials, &cells, structure), Criterion::Reml) {
            Ok(fit) => return Ok(TrialFit { fit, cells, structure }),
            Err(Unestimable::Confounded { what }) => {
                refused = Some(Unestimable::Confounded { what });
            }
            Err(other) => return Err(other),
        }
    }
    let what = "participants from the residual".to_owned();
    Err(refused.unwrap_or(Unestimable::Confounded { what }))
}

fn check(trials: Trials<'_>) -> Result<(), StatsError> {
    let expected = trials.value.len();
    for (what, found) in [
        ("the participants", trials.participant.len()),
        ("the sessions", trials.session.len()),
        ("the modes", trials.mode.len()),
    ] {
        if found != expected {
            return Err(NumericsError::LengthMismatch { what, expected, found }.into());
        }
    }
    Ok(())
}

/// Whether some participant has two levels of each term that has levels, and some level two trials:
/// without that the design cannot support it (the information on the variances is asked later).
fn may_support(trials: Trials<'_>, terms: &[Term]) -> bool {
    terms.iter().all(|term| {
        let mut trials_of: BTreeMap<(usize, usize), usize> = BTreeMap::new();
        let levels = level(trials, *term);
        for (participant, level) in trials.participant.iter().zip(&levels) {
            *trials_of.entry((*participant, *level)).or_default() += 1;
        }
        let repeated = trials_of.values().any(|trials| *trials > 1);
        let mut levels_of: BTreeMap<usize, usize> = BTreeMap::new();
        trials_of
            .keys()
            .for_each(|(participant, _)| *levels_of.entry(*participant).or_default() += 1);
        let varied = *term == Term::Participant || levels_of.values().any(|levels| *levels > 1);
        repeated && varied
    })
}

/// The level of each trial within its participant.
fn level(trials: Trials<'_>, term: Term) -> Vec<usize> {
    let (by_mode, by_session) = term.varies();
    let number = |values: &[usize], varies: bool| -> (Vec<usize>, usize) {
        let sorted: Vec<usize> =
            values.iter().copied().collect::<BTreeSet<_>>().into_iter().collect();
        let places = values.iter().map(|value| match varies {
            true => sorted.partition_point(|s| s < value),
            false => 0,
        });
        (places.collect(), sorted.len())
    };
    let (modes, count) = number(trials.mode, by_mode);
    let (sessions, _) = number(trials.session, by_session);
    modes.iter().zip(&sessions).map(|(mode, session)| session * count + mode).collect()
}

fn model(trials: Trials<'_>, cells: &[(usize, usize)], structure: &[Term]) -> Model {
    let fixed = cells.iter().map(|(session, mode)| {
        let of_trials = trials.session.iter().zip(trials.mode);
        let values = of_trials.map(|cell| if cell == (session, mode) { 1.0 } else { 0.0 });
        Column { name: format!("session {session}, mode {mode}"), values: values.collect() }
    });
    let random =
        structure.iter().map(|term| RandomTerm::intercept(term.name(), level(trials, *term)));
    Model {
        response: trials.value.to_vec(),
        fixed: fixed.collect(),
        group: trials.participant.to_vec(),
        random: random.collect(),
    }
}

impl TrialFit {
    /// Weights per coefficient of (mean in mode `a` − mean in mode `b`), averaged equally over the
    /// sessions in which both modes were measured.
    ///
    /// # Errors
    /// No session has both modes.
    pub fn difference(&self, a: usize, b: usize) -> Result<Vec<f64>, Unestimable> {
        let has = |session: usize, mode: usize| self.cells.contains(&(session, mode));
        let sessions: BTreeSet<usize> =
            self.cells.iter().map(|(s, _)| *s).filter(|s| has(*s, a) && has(*s, b)).collect();
        if sessions.is_empty() || a == b {
            let what = format!("mode {a} from mode {b} within a session");
            return Err(Unestimable::Confounded { what });
        }
        let share = 1.0 / sessions.len() as f64;
        let weights = self.cells.iter().map(|(session, mode)| match sessions.contains(session) {
            true if *mode == a => share,
            true if *mode == b => -share,
            _ => 0.0,
        });
        Ok(weights.collect())
    }

    /// Weights per coefficient of the mean in a mode, averaged equally over its sessions.
    ///
    /// # Errors
    /// No session has the mode.
    pub fn mean(&self, mode: usize) -> Result<Vec<f64>, Unestimable> {
        let sessions = self.cells.iter().filter(|(_, m)| *m == mode).count();
        if sessions == 0 {
            return Err(Unestimable::TooFew { units: "trials of the mode", found: 0, needed: 1 });
        }
        let share = 1.0 / sessions as f64;
        Ok(self.cells.iter().map(|(_, m)| if *m == mode { share } else { 0.0 }).collect())
    }

    /// Contrasts of each mode with the first: together they are zero if no modes differ.
    ///
    /// # Errors
    /// Fewer than two modes, or modes that share no session.
    pub fn differences(&self) -> Result<Vec<Vec<f64>>, Unestimable> {
        let modes: BTreeSet<usize> = self.cells.iter().map(|(_, mode)| *mode).collect();
        let modes: Vec<usize> = modes.into_iter().collect();
        match modes.split_first() {
            Some((first, others)) if !others.is_empty() => {
                others.iter().map(|mode| self.difference(*mode, *first)).collect()
            }
            _ => Err(Unestimable::TooFew { units: "modes", found: modes.len(), needed: 2 }),
        }
    }
}
