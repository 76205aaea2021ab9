//! Psychometric functions: how the share of one of two answers grows with the level of a stimulus.
//!
//! A person answers trials at several levels x of a stimulus. The share of "more", "right" or "yes" is
//!
//! ψ(x) = γ + (1 − γ − λ) F((x − m)/σ),
//!
//! where F rises from 0 to 1 ([`Sigmoid`]), γ is the share of guesses at a level that nobody perceives and λ that of
//! lapses at one that nobody misses (Wichmann & Hill 2001, Perception & Psychophysics 63:1293). What was asked decides
//! about γ ([`Asks`]). Two numbers describe a person:
//!
//! * the **threshold**, x at F = ½. Of "which was more" it is the point of subjective equality (PSE);
//! * the **JND**, half of x(F = ¾) − x(F = ¼). Over the standard it is the Weber fraction.
//!
//! [`fit`](fit::fit) finds both with their intervals by maximum likelihood, or says by its [`Verdict`](fit::Verdict) why
//! there are none; [`deviance`] says whether the curve describes the answers; [`grid`] is psignifit's posterior beside it.
//! People are compared by their thresholds and ln JNDs ([`paired`](crate::paired)), or with weights
//! ([`heterogeneity`](crate::heterogeneity)).
//! [`staircase`] and [`quest`] choose the next level from the answers before it; [`adjustment`] takes levels that people set.

pub mod adjustment;
mod curve;
pub mod deviance;
pub mod fit;
pub mod grid;
mod likelihood;
mod marginal;
pub mod plans;
pub mod quest;
pub mod staircase;

pub use curve::{Asks, Curve, Sigmoid};
pub use marginal::Marginal;

use crate::error::StatsError;

/// The answers at one level of the stimulus.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelAnswers {
    /// The level, in the unit of the stimulus; levels less than 5e-7 apart are one.
    pub level: f64,
    /// Trials that were answered.
    pub trials: u64,
    /// Of these, "more", "right" or "yes".
    pub positive: u64,
}

/// An answer to one presentation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AnsweredLevel {
    /// The level that was presented, in the unit of the stimulus.
    pub level: f64,
    /// Whether it was "more", "right" or "yes".
    pub is_positive: bool,
}

/// Records hold levels as whole numbers of such parts of the unit, so that those nearer to each other are one level.
const PARTS: f64 = 1e6;

/// The answers in rising order of their levels, each level once, those without trials left out.
///
/// # Errors
/// A level that is not finite, more positive answers than trials.
fn by_level(answers: &[LevelAnswers]) -> Result<Vec<LevelAnswers>, StatsError> {
    let mut sorted: Vec<LevelAnswers> = Vec::with_capacity(answers.len());
    for (index, answer) in answers.iter().enumerate() {
        let LevelAnswers { level, trials, positive } = *answer;
        if !level.is_finite() {
            return Err(StatsError::NonFinite { index, value: level });
        }
        if positive > trials {
            return Err(StatsError::MoreThanTrials { index, trials, positive });
        }
        if trials > 0 {
            // −0 is 0.
            sorted.push(LevelAnswers { level: level + 0.0, ..*answer });
        }
    }
    sorted.sort_by(|a, b| a.level.total_cmp(&b.level));
    sorted.dedup_by(|later, first| {
        let is_same = (later.level - first.level) * PARTS < 0.5;
        if is_same {
            first.trials += later.trials;
            first.positive += later.positive;
        }
        is_same
    });
    Ok(sorted)
}

/// The smallest distance of neighbouring levels; infinite for fewer than two.
fn smallest_step(levels: &[f64]) -> f64 {
    levels.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests;
