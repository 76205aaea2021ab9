//! The people of a study by their groups, and when a group is too small.

use crate::cells::Cells;
use crate::{Groups, Parameters};
use std::fmt;
use zwidth_results::UnitOfAnalysis;
use zwidth_stats::groups::{LEAST_FOR_A_CLAIM, LEAST_FOR_A_P};
use zwidth_stats::over_trials::{MOST_INFLATED, WeighedCondition};
use zwidth_study::counted;

/// The people of a study by their groups.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Split<'a> {
    /// How they are compared.
    pub(crate) groups: &'a Groups,
    /// The group of each of [`Cells::participants`], by its place among the levels.
    of: Vec<Option<usize>>,
    /// The block of the drawing of each; one for all where labels may be any.
    blocks: Vec<usize>,
}

impl<'a> Split<'a> {
    /// How people are split; not at all if the study has no groups, or one participant.
    pub(crate) fn of(cells: &Cells, parameters: &'a Parameters) -> Option<Self> {
        let groups = parameters.groups.as_ref()?;
        let of = cells.participants.iter().map(|who| groups.levels_of.get(who).copied()).collect();
        let block = |who| groups.blocks.get(who).map_or(0, |block| *block as usize);
        let blocks = cells.participants.iter().map(block).collect();
        (cells.unit() == UnitOfAnalysis::Participants).then_some(Self { groups, of, blocks })
    }

    /// The block of the drawing in which chance gave a participant their group.
    pub(crate) fn block(&self, participant: usize) -> usize {
        self.blocks[participant]
    }

    /// The group of a participant.
    pub(crate) fn level(&self, participant: usize) -> Option<usize> {
        self.of[participant]
    }

    /// Values of people, group by group in the order of the levels; some may have none.
    pub(crate) fn by_level<T>(&self, values: impl Iterator<Item = (usize, T)>) -> Vec<Vec<T>> {
        let mut levels: Vec<Vec<T>> =
            self.groups.compared.levels.iter().map(|_| Vec::new()).collect();
        for (participant, value) in values {
            if let Some(level) = self.of[participant] {
                levels[level].push(value);
            }
        }
        levels
    }

    /// The smallest of the groups that have somebody, with its name.
    pub(crate) fn smallest(&self, people: impl Iterator<Item = usize>) -> Option<(usize, String)> {
        let levels = self.by_level(people.map(|participant| (participant, ())));
        let with =
            levels.iter().zip(&self.groups.compared.levels).filter(|(level, _)| !level.is_empty());
        with.map(|(level, id)| (level.len(), id.to_string())).min()
    }
}

/// How many times the lines over trials make the variance of a weighted sum of conditions larger: of each group in the order
/// of the levels, because orders could balance each other over groups alone; of all people if there are no groups. Empty
/// without lines.
pub(crate) fn inflations(
    cells: &Cells,
    split: Option<&Split>,
    people: impl Iterator<Item = usize>,
    weights: &[WeighedCondition],
) -> Vec<f64> {
    let Some(lines) = &cells.lines else { return Vec::new() };
    let groups = match split {
        Some(split) => split.by_level(people.map(|participant| (participant, participant))),
        None => vec![people.collect()],
    };
    groups.iter().map(|people| lines.inflation(people, weights)).collect()
}

/// Why nothing is claimed, though there is an estimate.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Refused {
    /// A group is too small.
    TooFew {
        /// Its people.
        n: usize,
        /// The group.
        group: String,
    },
    /// The order of the modes leaves practice and modes hardly apart: a line over trials makes the variance so many
    /// times larger.
    Ordered(f64),
}

impl Refused {
    /// Whether the smallest of the groups, which has `n` people, is too small.
    pub(crate) fn too_few(n: usize, group: &str) -> Option<Self> {
        (n < LEAST_FOR_A_CLAIM).then(|| Self::TooFew { n, group: group.to_owned() })
    }

    /// Whether lines over trials tell practice and a weighted sum of conditions apart in each of the groups that are
    /// compared, of which these are the [`inflations`].
    pub(crate) fn ordered(inflations: impl Iterator<Item = f64>) -> Option<Self> {
        let largest = inflations.fold(1.0, f64::max);
        (largest > MOST_INFLATED).then_some(Self::Ordered(largest))
    }

    /// Whether there is a p value all the same.
    pub(crate) fn has_p(&self) -> bool {
        match self {
            Self::TooFew { n, .. } => *n >= LEAST_FOR_A_P,
            Self::Ordered(_) => true,
        }
    }
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (n, group) = match self {
            Self::TooFew { n, group } => (*n, group),
            Self::Ordered(times) => {
                return write!(
                    f,
                    "no claim: the order of the modes makes the variance beside a line over trials {times:.1} times \
                     larger"
                );
            }
        };
        let people = counted(n, "participants");
        match self.has_p() {
            true => write!(
                f,
                "no claim: {group} has {people}, and with {n} Welch's test finds an effect in up to 7 % \
                 of studies without one"
            ),
            false => write!(f, "no test: {group} has {people}, {LEAST_FOR_A_P} are needed"),
        }
    }
}
