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
//! Where people are of several groups, each group has the same weight in such a difference, with
//! Satterthwaite's degrees of freedom, and groups differ by Welch's test: in people's mean over modes, and in
//! their differences between modes. A claim takes four people in each group.
//!
//! Where modes are combinations of factors, an effect is a weighted sum of everybody's means, tested likewise.
//!
//! # Families
//! The contrasts of the primary metric over all environments are one family of claims, adjusted
//! after Holm; so are those of several primary metrics together. Every other metric is a family of its
//! own, and exploratory. Intervals are not adjusted.

mod anova;
mod answers;
mod cells;
mod claim;
mod contrasts;
mod covariates;
mod curve_spread;
mod curves;
mod curves_within;
mod differences;
mod doses;
mod drawn;
mod effects;
mod error;
mod groups;
mod learning;
mod means;
mod measure;
mod models;
mod notes;
mod omnibus;
mod orders;
mod over_trials;
mod parameters;
mod peers;
mod people;
mod preregistered;
mod quantity;
mod relations;
mod repeats;
mod sessions;
mod split;
#[cfg(test)]
mod tests;
mod together;
mod trials;
mod weighed;
mod whole_curves;

pub use answers::{AnswerParameters, AnswersCompared, answers_table, compare_answers};
pub use curve_spread::{CurveSpread, curve_spreads};
pub use curves::{CurveParameters, Curves, SessionCurve};
pub use drawn::{DrawnOrder, SessionOrder};
pub use error::CompareError;
pub use parameters::{Covariate, Groups, MetricParameters, Noticed, Parameters};
pub use peers::peers;
pub use preregistered::Preregistered;
pub use relations::{Said, relations};
pub use together::together;
pub use whole_curves::compare_curves;

use cells::Cells;
use claim::{Claim, Judging, judge};
use measure::Measure;
use orders::SharpNull;
use rayon::prelude::*;
use split::Split;
use trials::Trials;
use zwidth_results::{
    AnyGroup, Cell, Compared, CovariateSlope, DoseModel, DosePoint, EffectDifference, FactorTest,
    GroupDifference, GroupMean, GroupMember, GroupModeDifference, GroupModel, GroupModelTest,
    Learning, Mean, MetricNote, ModeDifference, Model, Omnibus, OrderTest, PersonDifference,
    PersonValue, RedrawnDifference, RepeatMean, SessionChange, TrialSlope, UnitOfAnalysis,
};
use zwidth_study::Families;
use zwidth_tables::Measured;

/// Version of the algorithms here: a change of any number they give raises it.
pub const VERSION: u32 = 21;

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
    /// Differences between modes over numbers of people.
    pub covariates: Vec<CovariateSlope>,
    /// Changes along everybody's line over trials.
    pub over_trials: Vec<TrialSlope>,
    /// Who is of which group.
    pub group_members: Vec<GroupMember>,
    /// Everybody's effects of factors, and values in which groups are compared.
    pub person_values: Vec<PersonValue>,
    /// Means of groups by condition.
    pub group_means: Vec<GroupMean>,
    /// Differences between modes within groups.
    pub group_contrasts: Vec<GroupModeDifference>,
    /// Differences between groups.
    pub groups: Vec<GroupDifference>,
    /// Whether any group differs from another.
    pub any_group: Vec<AnyGroup>,
    /// Effects of factors.
    pub effects: Vec<EffectDifference>,
    /// Their analysis of variance.
    pub factor_tests: Vec<FactorTest>,
    /// Curves over doses.
    pub trend_curves: Vec<DosePoint>,
    /// Slopes over doses by mixed models.
    pub trend_models: Vec<DoseModel>,
    /// Groups by mixed models.
    pub group_models: Vec<GroupModel>,
    /// Whether groups differ in any difference between modes, by these models.
    pub group_model_tests: Vec<GroupModelTest>,
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

/// Compares the modes, participants and sessions in each metric of a table.
///
/// # Errors
/// A table that lacks a column; a level or bound that cannot be one.
pub fn compare(metrics: &Measured, parameters: &Parameters) -> Result<Comparison, CompareError> {
    compare_tables(std::slice::from_ref(metrics), parameters)
}

/// The same of metrics each of which one of several tables has, such as scores of answers beside metrics of trials.
///
/// # Errors
/// Those of [`compare`]; no table.
pub fn compare_tables(
    tables: &[Measured],
    parameters: &Parameters,
) -> Result<Comparison, CompareError> {
    let (claiming, others) = parameters
        .metrics
        .iter()
        .partition::<Vec<_>, _>(|metric| metric.primary && parameters.families == Families::Study);
    let tested = claiming.par_iter().map(|metric| Tested::of(tables, metric, parameters));
    // `par_iter` keeps the order of the metrics, so rows are the same with any number of threads.
    let mut tested = tested.collect::<Result<Vec<Tested>, CompareError>>()?;
    let Parameters { families, alpha, curve_claims: elsewhere, .. } = *parameters;
    let judging = Judging { families, alpha, elsewhere };
    judge(tested.iter_mut().flat_map(Tested::claims).collect(), judging)?;
    let found = tested.into_par_iter().map(|metric| metric.judged(parameters));
    let others = others.par_iter().map(|metric| {
        let mut metric = Tested::of(tables, metric, parameters)?;
        judge(metric.claims().collect(), Judging { elsewhere: 0, ..judging })?;
        metric.judged(parameters)
    });
    let mut all = Comparison::default();
    if let Some(groups) = &parameters.groups {
        let members = groups.levels_of.iter().map(|(who, level)| GroupMember {
            participant: who.clone(),
            group: groups.compared.levels[*level].clone(),
        });
        all.group_members.extend(members);
    }
    // Primary metrics stand first among the parameters, too.
    for metric in found.chain(others).collect::<Result<Vec<Comparison>, CompareError>>()? {
        all.metrics.extend(metric.metrics);
        all.cells.extend(metric.cells);
        all.means.extend(metric.means);
        all.contrasts.extend(metric.contrasts);
        all.omnibus.extend(metric.omnibus);
        all.models.extend(metric.models);
        all.participants.extend(metric.participants);
        all.covariates.extend(metric.covariates);
        all.over_trials.extend(metric.over_trials);
        all.person_values.extend(metric.person_values);
        all.group_means.extend(metric.group_means);
        all.group_contrasts.extend(metric.group_contrasts);
        all.groups.extend(metric.groups);
        all.any_group.extend(metric.any_group);
        all.effects.extend(metric.effects);
        all.factor_tests.extend(metric.factor_tests);
        all.trend_curves.extend(metric.trend_curves);
        all.trend_models.extend(metric.trend_models);
        all.group_models.extend(metric.group_models);
        all.group_model_tests.extend(metric.group_model_tests);
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
    split: Option<Split<'a>>,
    groups: Vec<groups::Row<'a>>,
    effects: Vec<effects::Row<'a>>,
}

impl<'a> Tested<'a> {
    fn of(
        tables: &[Measured],
        metric: &'a MetricParameters,
        parameters: &'a Parameters,
    ) -> Result<Self, CompareError> {
        let has = |table: &&Measured| table.metric(metric.metric.as_str()).is_some();
        // The first one says that it has no such column.
        let metrics = tables.iter().find(has).or(tables.first()).ok_or(CompareError::NoTable)?;
        let measure = Measure::new(metrics, metric)?;
        let trials = Trials::of(metrics, &measure, parameters)?;
        let cells = Cells::of(metrics, &measure, &trials, parameters)?;
        let unit = cells.unit();
        let orders = orders::sharp_nulls(&trials, parameters, orders::SAMPLING);
        let split = Split::of(&cells, parameters);
        let contrasts = contrasts::rows(&cells, &orders, split.as_ref(), &measure, parameters)?;
        let effects = effects::rows(&cells, split.as_ref(), &measure, parameters)?;
        let groups = match &split {
            Some(split) => groups::rows(split, &cells, &contrasts, &effects, &measure, parameters)?,
            None => Vec::new(),
        };
        Ok(Self { measure, cells, trials, unit, orders, contrasts, split, groups, effects })
    }

    fn claims(&mut self) -> impl Iterator<Item = &mut Claim> {
        let of_modes = self.contrasts.iter_mut().map(|row| &mut row.claim);
        let of_groups = self.groups.iter_mut().map(|row| &mut row.claim);
        of_modes.chain(of_groups).chain(self.effects.iter_mut().map(|row| &mut row.claim))
    }

    /// The rows of a metric whose contrasts have their verdicts.
    fn judged(self, parameters: &Parameters) -> Result<Comparison, CompareError> {
        let Self { measure, cells, trials, unit, orders, contrasts, split, groups, effects } =
            &self;
        let split = split.as_ref();
        let means = means::means(cells, split, unit, measure, parameters)?;
        let models = models::models(trials, unit, split, measure, parameters);
        let by_group = split
            .map(|split| models::of_groups(trials, split, measure, parameters))
            .unwrap_or_default();
        let sessions = sessions::changes(cells, measure, parameters);
        let notes = [
            notes::means(measure, &means, split, unit),
            notes::contrasts(contrasts, cells, split, unit, measure, parameters),
            notes::groups(cells, split, measure),
            notes::effects(effects, split, measure, parameters),
            notes::omnibus(measure),
            notes::models(measure, &models),
            notes::sessions(measure, &sessions),
            notes::covariates(measure),
            notes::over_trials(cells, trials, measure, parameters),
            notes::same_order(trials, unit, measure, parameters),
            notes::learning(measure),
            notes::repeats(measure, unit),
            notes::order_tests(measure),
        ];
        Ok(Comparison {
            metrics: vec![Compared {
                metric: measure.parameters.metric.clone(),
                unit: measure.unit.clone(),
                words: measure.words.clone(),
                role: measure.parameters.role(),
                better: measure.parameters.better,
                unit_of_analysis: unit.clone(),
            }],
            cells: cells.rows(measure, parameters),
            means,
            contrasts: contrasts::named(contrasts, unit, split.is_some(), measure, parameters),
            omnibus: omnibus::tests(cells, measure, parameters),
            models,
            participants: people::differences(contrasts, cells, measure, parameters),
            covariates: covariates::slopes(contrasts, cells, measure, parameters),
            over_trials: over_trials::slopes(cells.lines.as_ref(), unit, measure, parameters),
            group_members: Vec::new(),
            person_values: match split {
                Some(split) => {
                    groups::values(split, cells, contrasts, effects, measure, parameters)
                }
                None => effects::values(effects, cells, measure),
            },
            group_means: match split {
                Some(split) => groups::means(split, cells, measure, parameters)?,
                None => Vec::new(),
            },
            group_contrasts: split
                .map(|split| groups::within(split, contrasts, measure, parameters))
                .unwrap_or_default(),
            groups: groups::named(groups, measure, parameters),
            any_group: split
                .map(|split| groups::any(split, cells, contrasts, effects, measure, parameters))
                .unwrap_or_default(),
            effects: effects::named(effects, cells, unit, split, measure, parameters),
            factor_tests: anova::tests(cells, split, measure, parameters),
            trend_curves: doses::curves(cells, unit, split, measure, parameters),
            trend_models: models::of_doses(trials, unit, measure, parameters),
            group_models: by_group.differences,
            group_model_tests: by_group.tests,
            sessions: sessions.rows,
            learning: learning::changes(trials, unit, measure, parameters),
            repeats: repeats::means(trials, measure, parameters)?,
            orders: orders::rows(orders, measure, parameters),
            redrawn: orders::redrawn_differences(orders, measure, parameters),
            notes: notes.concat(),
        })
    }
}
