//! The model to be fitted: answers grouped by participant and mode.

use crate::answers::{Answers, Column};
use crate::error::same_length;
use crate::logistic::by_threshold;
use crate::tested::{Unestimable, at_least};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// The answers of a study, one row each; all slices are of one length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ratings<'a> {
    /// The answers, from 1 to `points`.
    pub answers: &'a [u8],
    /// Points of the scale.
    pub points: u8,
    /// The fixed effects.
    pub columns: &'a [Column],
    /// The participant of each answer: any numbers that tell participants apart.
    pub participants: &'a [usize],
    /// The mode of each answer: any numbers that tell modes apart.
    pub modes: &'a [usize],
}

/// The random effects of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Terms {
    /// u per participant.
    Participant,
    /// u per participant and w per participant and mode: people differ in their mode effects too.
    ParticipantAndMode,
}

/// Grouped answers with their random effects.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    pub(super) answers: Answers,
    pub(super) terms: Terms,
    /// In the order of their numbers.
    pub(super) participants: Vec<Cells>,
    /// Participant and mode of each row, as indices of `participants` and of its groups.
    pub(super) places: Vec<(usize, usize)>,
    /// Number of modes.
    modes: usize,
    /// The values at which coefficients are held, one per column; `None` for those that are
    /// estimated.
    pub(super) held: Vec<Option<f64>>,
}

/// One participant's answers. A cell counts those that share mode and columns: their linear
/// predictor is one number, whatever the random effects.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Cells {
    /// The cells of each mode.
    pub(super) groups: Vec<Range<usize>>,
    /// Values of the columns, cell by cell.
    pub(super) x: Vec<Vec<f64>>,
    /// Answers just below each threshold (nⱼ), cell by cell.
    pub(super) below: Vec<Vec<f64>>,
    /// Answers on either side of each threshold (Nⱼ).
    pub(super) beside: Vec<Vec<f64>>,
}

impl Model {
    /// The model of `ratings` with random effects `terms`.
    ///
    /// # Errors
    /// As [`crate::clm::Model::new`]; besides, fewer than two participants, and participants who
    /// answered in one mode each if both terms are requested. What separates the answers of all
    /// together leaves no finite estimate here either: along such a direction the likelihood rises
    /// for any value of the random effects.
    pub fn new(ratings: &Ratings, terms: Terms) -> Result<Self, Unestimable> {
        let answers = Answers::new(ratings.answers, ratings.points, ratings.columns)?;
        for labels in [ratings.participants, ratings.modes] {
            same_length("a column", ratings.answers.len(), labels.len())?;
        }
        answers.screen()?;
        Self::unscreened(ratings.participants, ratings.modes, answers, terms)
    }

    /// [`Model::new`] for answers that may be separated along columns whose coefficients are then
    /// held.
    pub(super) fn unscreened(
        participants: &[usize],
        modes: &[usize],
        answers: Answers,
        terms: Terms,
    ) -> Result<Self, Unestimable> {
        let places = places(participants, modes);
        let modes = modes.iter().collect::<BTreeSet<_>>().len();
        let model = Self::of(answers, places, terms, modes);
        at_least("participants", model.participants.len(), 2)?;
        // With one mode each, both effects would be one: nothing tells their SDs apart.
        let alone = model.participants.iter().all(|cells| cells.groups.len() == 1);
        if alone && terms == Terms::ParticipantAndMode {
            let what = "participants and their modes".to_owned();
            return Err(Unestimable::Confounded { what });
        }
        Ok(model)
    }

    /// The model of answers whose places are known, unscreened.
    pub(super) fn of(
        answers: Answers,
        places: Vec<(usize, usize)>,
        terms: Terms,
        modes: usize,
    ) -> Self {
        let mut rows: Vec<Vec<Vec<usize>>> = Vec::new();
        for (row, &(participant, group)) in places.iter().enumerate() {
            // Rows come in any order: the lists grow up to the numbers that occur.
            rows.resize_with(rows.len().max(participant + 1), Vec::new);
            let groups = &mut rows[participant];
            groups.resize_with(groups.len().max(group + 1), Vec::new);
            groups[group].push(row);
        }
        let participants = rows.iter().map(|groups| Cells::new(&answers, groups)).collect();
        let held = vec![None; answers.columns.len()];
        Self { answers, terms, participants, places, modes, held }
    }

    /// The same model without some columns.
    pub(super) fn without(&self, columns: &[usize]) -> Self {
        let kept = self.answers.columns.iter().enumerate();
        let kept = kept.filter(|(j, _)| !columns.contains(j)).map(|(_, c)| c.clone());
        let answers = Answers { columns: kept.collect(), ..self.answers.clone() };
        let held = self.held.iter().enumerate();
        let held = held.filter(|(j, _)| !columns.contains(j)).map(|(_, value)| *value);
        Self { held: held.collect(), ..self.with(answers) }
    }

    /// The same model of other answers, all of its coefficients free.
    pub(super) fn with(&self, answers: Answers) -> Self {
        Self::of(answers, self.places.clone(), self.terms, self.modes)
    }

    /// (n − 1)(m − 1) for n participants and m modes: the degrees of freedom of their interaction,
    /// and so of the error of a mode effect where people differ in it.
    pub fn mode_df(&self) -> f64 {
        (self.participants.len() as f64 - 1.0) * (self.modes as f64 - 1.0)
    }

    /// Number of participants.
    pub fn participants(&self) -> usize {
        self.participants.len()
    }

    /// Number of thresholds.
    pub(super) fn thresholds(&self) -> usize {
        self.answers.categories() - 1
    }

    /// Number of columns.
    pub(super) fn columns(&self) -> usize {
        self.answers.columns.len()
    }
}

impl Cells {
    fn new(answers: &Answers, groups: &[Vec<usize>]) -> Self {
        let mut cells = Self { groups: vec![], x: vec![], below: vec![], beside: vec![] };
        for rows in groups {
            let first = cells.x.len();
            for pattern in answers.patterns(rows.iter().copied()) {
                let (below, beside) = by_threshold(&pattern.counts);
                cells.x.push(pattern.x);
                cells.below.push(below);
                cells.beside.push(beside);
            }
            cells.groups.push(first..cells.x.len());
        }
        cells
    }
}

/// Participants and the modes of each, numbered in the order of their labels.
fn places(participants: &[usize], modes: &[usize]) -> Vec<(usize, usize)> {
    let mut seen: BTreeMap<usize, BTreeMap<usize, usize>> = BTreeMap::new();
    for (participant, mode) in participants.iter().zip(modes) {
        seen.entry(*participant).or_default().insert(*mode, 0);
    }
    for groups in seen.values_mut() {
        groups.values_mut().zip(0..).for_each(|(place, number)| *place = number);
    }
    let number: BTreeMap<usize, usize> = seen.keys().copied().zip(0..).collect();
    let rows = participants.iter().zip(modes);
    rows.map(|(participant, mode)| (number[participant], seen[participant][mode])).collect()
}
