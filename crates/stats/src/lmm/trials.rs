//! The mixed model of a study: participants who did repeated trials in modes, in one or more
//! sessions.
//!
//! The fixed effects are the means of the cells (session × mode), so nothing is assumed about how
//! sessions and modes combine; a contrast of modes averages the sessions' contrasts equally. The
//! random effects are those of participants and of their combinations with mode and session, as
//! many as the design can separate: repeats of one person are not people, and neither are sessions.

use super::fit::{Criterion, Fit, fit};
use super::model::{Model, RandomTerm};
use crate::answers::Column;
use crate::error::same_length;
use crate::tested::{Unestimable, at_least};
use std::collections::{BTreeMap, BTreeSet};
use zwidth_study::worded;

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

worded! {
    /// A random term of a study, beside the residual.
    Term {
        /// A participant's own level.
        Participant = "participant",
        /// A participant's own effect of a mode.
        ParticipantMode = "participant × mode",
        /// A participant's own level in a session.
        ParticipantSession = "participant × session",
        /// A participant's own effect of a mode in a session.
        ParticipantSessionMode = "participant × session × mode",
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
    let rows = trials.value.len();
    same_length("the participants", rows, trials.participant.len())?;
    same_length("the sessions", rows, trials.session.len())?;
    same_length("the modes", rows, trials.mode.len())?;
    let people: BTreeSet<usize> = trials.participant.iter().copied().collect();
    at_least("participants", people.len(), 2)?;
    let cells: BTreeSet<(usize, usize)> =
        trials.session.iter().copied().zip(trials.mode.iter().copied()).collect();
    let cells: Vec<(usize, usize)> = cells.into_iter().collect();
    // A structure may pass the count of trials and fail at the information on its variances: then
    // the next smaller one is tried, and the last refusal is the answer.
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

/// Trials of participants at the levels of a dose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dosed<'a> {
    /// The participant of each trial, any numbers.
    pub participant: &'a [usize],
    /// The level of each trial, likewise.
    pub level: &'a [usize],
    /// Its dose.
    pub dose: &'a [f64],
    /// The metric of each trial.
    pub value: &'a [f64],
}

/// Fits y = β₀ + β₁ dose with everybody's own line, and their own deviation from it at each level, by REML. Without the
/// slopes of people one of a line is wrong in 14 to 61 of 100 studies without a slope. The second coefficient is the slope.
///
/// # Errors
/// As [`fit()`]: columns of different lengths, variances that cannot be told apart.
pub fn fit_doses(trials: Dosed<'_>) -> Result<Fit, Unestimable> {
    let Dosed { participant, level, dose, value } = trials;
    let ones = vec![1.0; value.len()];
    // About its mean: the criterion is the same, and its entries do not hang together.
    let mean = dose.iter().sum::<f64>() / dose.len().max(1) as f64;
    let centred: Vec<f64> = dose.iter().map(|dose| dose - mean).collect();
    let model = Model {
        response: value.to_vec(),
        fixed: vec![
            Column { name: "level".to_owned(), values: ones.clone() },
            Column { name: "slope".to_owned(), values: centred.clone() },
        ],
        group: participant.to_vec(),
        random: vec![
            RandomTerm {
                name: "participant, level and slope".to_owned(),
                columns: vec![ones, centred],
                level: vec![0; value.len()],
            },
            RandomTerm::intercept("participant × dose", level.to_vec()),
        ],
    };
    fit(&model, Criterion::Reml)
}

/// Whether some participant has two levels of each term that has levels, and some level two trials:
/// without that the design cannot support it (the information on the variances is tested later).
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
    let by_mode = matches!(term, Term::ParticipantMode | Term::ParticipantSessionMode);
    let by_session = matches!(term, Term::ParticipantSession | Term::ParticipantSessionMode);
    let [modes, sessions] = [trials.mode, trials.session].map(|values| {
        values.iter().copied().collect::<BTreeSet<_>>().into_iter().collect::<Vec<usize>>()
    });
    let mut levels = Vec::with_capacity(trials.mode.len());
    for (mode, session) in trials.mode.iter().zip(trials.session) {
        let mode = if by_mode { modes.partition_point(|m| m < mode) } else { 0 };
        let session = if by_session { sessions.partition_point(|s| s < session) } else { 0 };
        levels.push(session * modes.len() + mode);
    }
    levels
}

/// The model of the trials with the means of `cells` and the random terms of `structure`.
fn model(trials: Trials<'_>, cells: &[(usize, usize)], structure: &[Term]) -> Model {
    let fixed = cells.iter().map(|(session, mode)| {
        let of_trials = trials.session.iter().zip(trials.mode);
        let values = of_trials.map(|cell| if cell == (session, mode) { 1.0 } else { 0.0 });
        Column { name: format!("session {session}, mode {mode}"), values: values.collect() }
    });
    let random =
        structure.iter().map(|term| RandomTerm::intercept(term.as_str(), level(trials, *term)));
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
        let sessions = self.cells.iter().map(|(session, _)| *session);
        let sessions: BTreeSet<usize> = sessions
            .filter(|session| [a, b].iter().all(|mode| self.cells.contains(&(*session, *mode))))
            .collect();
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
        at_least("trials of the mode", sessions, 1)?;
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
