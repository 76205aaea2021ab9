//! Stage: modes, participants and sessions compared, one metric at a time.
//!
//! [`compare`] turns the table of metrics (one row per trial) into rows of [`zwidth_results`]. Nothing
//! here reads a file or a clock.
//!
//! # What is estimated
//! The unweighted mean over participants of (mean in one mode − mean in the other), sessions
//! averaged with equal weight, per environment. Repeats of one person are not people: with several
//! participants n counts participants, and each contributes one difference, tested by Student's t
//! with n − 1 degrees of freedom (the differences have their own variance, so no sphericity is
//! assumed). With one participant, n counts trials, every statement is "within this participant",
//! and claims rest on randomisation over the orders that the design could have drawn; Welch's
//! interval (sessions as strata) is given beside it as a description.
//!
//! # Families
//! The contrasts of the primary metric over all environments are one family of claims, adjusted
//! after Holm; so are those of several primary metrics together. Every other metric is a family of its
//! own, and exploratory. Intervals are not adjusted.

mod answers;
mod cells;
mod contrasts;
mod differences;
mod drawn;
mod error;
mod learning;
mod means;
mod measure;
mod models;
mod notes;
mod omnibus;
mod orders;
mod parameters;
mod people;
mod preregistered;
mod quantity;
mod repeats;
mod sessions;
#[cfg(test)]
mod tests;
mod together;
mod trials;

pub use answers::{AnswerParameters, AnswersCompared, answers_table, compare_answers};
pub use drawn::{DrawnOrder, SessionOrder};
pub use error::CompareError;
pub use parameters::{MetricParameters, Noticed, Parameters};
pub use preregistered::Preregistered;
pub use together::together;

use cells::Cells;
use measure::Measure;
use orders::SharpNull;
use rayon::prelude::*;
use trials::Trials;
use zwidth_results::{
    Cell, Compared, Learning, Mean, MetricNote, ModeDifference, Model, Omnibus, OrderTest,
    PersonDifference, RedrawnDifference, RepeatMean, Role, SessionChange, UnitOfAnalysis,
};
use zwidth_study::Families;
use zwidth_tables::Measured;

/// Version of the algorithms here: a change of any number they give raises it.
pub const VERSION: u32 = 14;

/// All metrics compared, one after the other.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Comparison {
    /// The metrics.
    pub metrics: Vec<Compared>,
    /// Each participant's mean by session and condition.
    pub cells: Vec<Cell>,
    /// Mean over the units of analysis by condition.
    pub means: Vec<Mean>,
    /// Differences between modes.
    pub contrasts: Vec<ModeDifference>,
    /// Whether any mode differs from another.
    pub omnibus: Vec<Omnibus>,
    /// The same differences by mixed models.
    pub models: Vec<Model>,
    /// Each participant's differences.
    pub participants: Vec<PersonDifference>,
    /// Changes between sessions.
    pub sessions: Vec<SessionChange>,
    /// Changes from repeat to repeat.
    pub learning: Vec<Learning>,
    /// Means at each repeat.
    pub repeats: Vec<RepeatMean>,
    /// Differences between modes against other orders of the trials.
    pub orders: Vec<OrderTest>,
    /// These differences in the other orders.
    pub redrawn: Vec<RedrawnDifference>,
    /// The notes below the rows of each metric.
    pub notes: Vec<MetricNote>,
}

/// Compares the modes, participants and sessions in each metric.
///
/// # Errors
/// A table that lacks a column; a level or bound that cannot be one.
pub fn compare(metrics: &Measured, parameters: &Parameters) -> Result<Comparison, CompareError> {
    let (claiming, others) = parameters
        .metrics
        .iter()
        .partition::<Vec<_>, _>(|metric| metric.primary && parameters.families == Families::Study);
    let tested = claiming.par_iter().map(|metric| Tested::of(metrics, metric, parameters));
    // `par_iter` keeps the order of the metrics, so rows are the same with any number of threads.
    let mut tested = tested.collect::<Result<Vec<Tested>, CompareError>>()?;
    let family = tested.iter_mut().flat_map(|metric| &mut metric.contrasts);
    contrasts::judge(family.collect(), parameters)?;
    let found = tested.into_par_iter().map(|metric| metric.judged(parameters));
    let others = others.par_iter().map(|metric| {
        let mut metric = Tested::of(metrics, metric, parameters)?;
        contrasts::judge(metric.contrasts.iter_mut().collect(), parameters)?;
        metric.judged(parameters)
    });
    let mut all = Comparison::default();
    // Primary metrics stand first among the parameters, too.
    for metric in found.chain(others).collect::<Result<Vec<Comparison>, CompareError>>()? {
        all.metrics.extend(metric.metrics);
        all.cells.extend(metric.cells);
        all.means.extend(metric.means);
        all.contrasts.extend(metric.contrasts);
        all.omnibus.extend(metric.omnibus);
        all.models.extend(metric.models);
        all.participants.extend(metric.participants);
        all.sessions.extend(metric.sessions);
        all.learning.extend(metric.learning);
        all.repeats.extend(metric.repeats);
        all.orders.extend(metric.orders);
        all.redrawn.extend(metric.redrawn);
        all.notes.extend(metric.notes);
    }
    Ok(all)
}

/// A metric whose contrasts are tested, and not yet judged: others may belong to the same family of claims.
struct Tested<'a> {
    measure: Measure<'a>,
    cells: Cells,
    trials: Trials,
    unit: UnitOfAnalysis,
    orders: Vec<SharpNull>,
    contrasts: Vec<contrasts::Row>,
}

impl<'a> Tested<'a> {
    fn of(
        metrics: &Measured,
        metric: &'a MetricParameters,
        parameters: &Parameters,
    ) -> Result<Self, CompareError> {
        let measure = Measure::new(metrics, metric)?;
        let cells = Cells::of(metrics, &measure, parameters)?;
        let trials = Trials::of(metrics, &measure, parameters)?;
        let unit = cells.unit();
        let orders = orders::sharp_nulls(&trials, parameters, orders::SAMPLING);
        let contrasts = contrasts::rows(&cells, &orders, &unit, &measure, parameters)?;
        Ok(Self { measure, cells, trials, unit, orders, contrasts })
    }

    /// The rows of a metric whose contrasts have their verdicts.
    fn judged(self, parameters: &Parameters) -> Result<Comparison, CompareError> {
        let Self { measure, cells, trials, unit, orders, contrasts } = &self;
        let means = means::means(cells, unit, measure, parameters)?;
        let models = models::models(trials, unit, measure, parameters);
        let sessions = sessions::changes(cells, measure, parameters);
        let notes = [
            notes::means(measure, &means, unit),
            notes::contrasts(contrasts, cells, unit, measure, parameters),
            notes::omnibus(measure),
            notes::models(measure, &models),
            notes::sessions(measure, &sessions),
            notes::learning(measure),
            notes::repeats(measure, unit),
            notes::order_tests(measure),
        ];
        Ok(Comparison {
            metrics: vec![Compared {
                metric: measure.parameters.metric.clone(),
                unit: measure.unit.clone(),
                words: measure.words.clone(),
                role: if measure.parameters.primary { Role::Primary } else { Role::Exploratory },
                better: measure.parameters.better,
                unit_of_analysis: unit.clone(),
            }],
            cells: cells.rows(measure, parameters),
            means,
            contrasts: contrasts::named(contrasts, unit, measure, parameters),
            omnibus: omnibus::tests(cells, measure, parameters),
            models,
            participants: people::differences(contrasts, cells, measure, parameters),
            sessions: sessions.rows,
            learning: learning::changes(trials, unit, measure, parameters),
            repeats: repeats::means(trials, measure, parameters)?,
            orders: orders::rows(orders, measure, parameters),
            redrawn: orders::redrawn_differences(orders, measure, parameters),
            notes: notes.concat(),
        })
    }
}
