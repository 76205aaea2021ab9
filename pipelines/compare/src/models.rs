//! The mixed model beside the paired differences: one row per environment and contrast.
//!
//! Trials are the rows; participants and their combinations with mode and session are random, as
//! many as the design can separate. A participant who lacks a mode stays in the model (missing at
//! random).

use crate::Parameters;
use crate::measure::Measure;
use crate::split::Split;
use crate::trials::Trials;
use std::collections::BTreeSet;
use zwidth_results::{
    DoseModel, EffectLevels, GroupEffect, GroupModel, GroupModelTest, Model, UnitOfAnalysis,
};
use zwidth_stats::lmm::Tests;
use zwidth_stats::lmm::trials::{self as lmm, Dosed, Term, TrialFit, fit_doses, fit_trials};
use zwidth_stats::{FTest, Unestimable};
use zwidth_study::LevelContrast;

/// The trials of one environment that have the metric, by the places of their names.
#[derive(Debug, Clone, PartialEq, Default)]
struct Rows {
    participant: Vec<usize>,
    session: Vec<usize>,
    mode: Vec<usize>,
    /// The group and the mode, each combination a number: groups have means of their own.
    cell: Vec<usize>,
    value: Vec<f64>,
}

/// The trials by environment; of groups those of people who have one.
fn by_environment(trials: &Trials, split: Option<&Split>, parameters: &Parameters) -> Vec<Rows> {
    let mut environments = vec![Rows::default(); parameters.environments.len()];
    for trial in &trials.trials {
        let group = split.map_or(Some(0), |split| split.level(trial.participant));
        let (Some(value), Some(group)) = (trial.value, group) else { continue };
        let rows = &mut environments[trial.environment];
        rows.participant.push(trial.participant);
        rows.session.push(trial.session);
        rows.mode.push(trial.mode);
        rows.cell.push(group * parameters.modes.len() + trial.mode);
        rows.value.push(value);
    }
    environments
}

impl Rows {
    fn fit(&self) -> Result<TrialFit, Unestimable> {
        fit_trials(lmm::Trials {
            participant: &self.participant,
            session: &self.session,
            mode: &self.cell,
            value: &self.value,
        })
    }

    /// The groups that have trials here.
    fn groups(&self, parameters: &Parameters) -> BTreeSet<usize> {
        self.cell.iter().map(|cell| cell / parameters.modes.len()).collect()
    }
}

/// The sum of weights with these factors.
fn combined(each: &[(f64, Vec<f64>)]) -> Vec<f64> {
    let mut sum = vec![0.0; each.first().map_or(0, |(_, weights)| weights.len())];
    for (factor, weights) in each {
        sum.iter_mut().zip(weights).for_each(|(sum, weight)| *sum += factor * weight);
    }
    sum
}

/// Every contrast by the mixed model of its environment; no row with one participant. Groups have the same weight.
pub(crate) fn models(
    trials: &Trials,
    unit: &UnitOfAnalysis,
    split: Option<&Split>,
    measure: &Measure,
    parameters: &Parameters,
) -> Vec<Model> {
    if *unit != UnitOfAnalysis::Participants {
        return Vec::new();
    }
    let mut models = Vec::new();
    for (environment, rows) in by_environment(trials, split, parameters).iter().enumerate() {
        let fit = rows.fit();
        let groups = rows.groups(parameters);
        for contrast in &parameters.contrasts {
            let Some(modes) = parameters.modes_of(contrast) else { continue };
            if !modes.iter().all(|mode| rows.mode.contains(mode)) {
                continue;
            }
            let weights = |fit: &TrialFit| {
                let of_group = |group: &usize| {
                    let [a, b] = modes.map(|mode| group * parameters.modes.len() + mode);
                    Ok((1.0 / groups.len() as f64, fit.difference(a, b)?))
                };
                let each: Result<Vec<_>, Unestimable> = groups.iter().map(of_group).collect();
                each.map(|each| combined(&each))
            };
            let kenward_roger = fit
                .as_ref()
                .map_err(Clone::clone)
                .and_then(|fit| fit.fit.kenward_roger()?.test(&weights(fit)?, parameters.level));
            let fitted = fit.as_ref().ok();
            // Only beside Kenward and Roger's, so its failure leaves no remark.
            let satterthwaite = fitted.and_then(|fit| {
                fit.fit.satterthwaite().ok()?.test(&weights(fit).ok()?, parameters.level).ok()
            });
            let tested = kenward_roger.as_ref().ok();
            models.push(Model {
                metric: measure.parameters.metric.clone(),
                unit: measure.unit.clone(),
                environment: parameters.environments[environment].clone(),
                contrast: contrast.clone(),
                n: fitted.map(|fit| fit.fit.groups),
                trials: rows.value.len(),
                difference: tested.map(|t| t.estimate),
                difference_std_error: tested.map(|t| t.std_error),
                difference_ci_low: tested.map(|t| t.ci_low),
                difference_ci_high: tested.map(|t| t.ci_high),
                df: tested.map(|t| t.df),
                p_value: tested.map(|t| t.p_value),
                df_satterthwaite: satterthwaite.as_ref().map(|t| t.df),
                p_satterthwaite: satterthwaite.as_ref().map(|t| t.p_value),
                participant_sd: fitted.and_then(|fit| deviation(fit, Term::Participant)),
                participant_mode_sd: fitted.and_then(|fit| deviation(fit, Term::ParticipantMode)),
                residual_sd: fitted.map(|fit| fit.fit.residual_variance.sqrt()),
                random_terms: fitted.map(|fit| {
                    fit.structure.iter().map(|term| term.as_str()).collect::<Vec<_>>().join(", ")
                }),
                singular: fitted.map(|fit| fit.fit.singular),
                remark: kenward_roger.as_ref().err().map(|why| why.to_string().into()),
            });
        }
    }
    models
}

/// What the mixed models say of groups.
#[derive(Default)]
pub(crate) struct ByGroup {
    /// Differences between two groups.
    pub(crate) differences: Vec<GroupModel>,
    /// Whether groups differ in any difference between modes.
    pub(crate) tests: Vec<GroupModelTest>,
}

/// Groups compared by the mixed model of their environment, in which each has means of its own: in the mean over modes,
/// in every difference between modes, and in all of these together.
pub(crate) fn of_groups(
    trials: &Trials,
    split: &Split,
    measure: &Measure,
    parameters: &Parameters,
) -> ByGroup {
    let modes = parameters.modes.len();
    let mut models = Vec::new();
    let mut interactions = Vec::new();
    for (environment, rows) in by_environment(trials, Some(split), parameters).iter().enumerate() {
        if rows.value.is_empty() {
            continue;
        }
        let fit = rows.fit();
        let tests = fit.as_ref().map_err(Clone::clone).and_then(|fit| fit.fit.kenward_roger());
        let own: BTreeSet<usize> = rows.mode.iter().copied().collect();
        let all = match (own.len(), own.first()) {
            (1, Some(mode)) => GroupEffect::In(parameters.modes[*mode].clone()),
            _ => GroupEffect::OverModes,
        };
        let contrasts = parameters.contrasts.iter().filter(|contrast| {
            let modes = parameters.modes_of(contrast);
            modes.is_some_and(|modes| modes.iter().all(|mode| own.contains(mode)))
        });
        let effects = contrasts.map(|contrast| GroupEffect::Of(contrast.clone()));
        for effect in [all].into_iter().chain(effects) {
            for groups in &split.groups.compared.contrasts {
                let place = |id| split.groups.compared.levels.iter().position(|own| own == id);
                let (Some(group), Some(against)) = (place(&groups.group), place(&groups.against))
                else {
                    continue;
                };
                let of_group = |fit: &TrialFit, group: usize| match &effect {
                    GroupEffect::Of(contrast) => {
                        let pair = parameters.modes_of(contrast).unwrap_or_default();
                        fit.difference(group * modes + pair[0], group * modes + pair[1])
                    }
                    _ => {
                        let share = 1.0 / own.len() as f64;
                        let mean = |mode: &usize| Ok((share, fit.mean(group * modes + mode)?));
                        let each: Result<Vec<_>, Unestimable> = own.iter().map(mean).collect();
                        each.map(|each| combined(&each))
                    }
                };
                let tested = fit.as_ref().map_err(Clone::clone).and_then(|fit| {
                    let (first, second) = (of_group(fit, group)?, of_group(fit, against)?);
                    let weights = combined(&[(1.0, first), (-1.0, second)]);
                    tests.as_ref().map_err(Clone::clone)?.test(&weights, parameters.level)
                });
                let found = tested.as_ref().ok();
                models.push(GroupModel {
                    metric: measure.parameters.metric.clone(),
                    unit: measure.unit.clone(),
                    environment: parameters.environments[environment].clone(),
                    effect: effect.clone(),
                    groups: groups.clone(),
                    trials: rows.value.len(),
                    difference: found.map(|t| t.estimate),
                    difference_std_error: found.map(|t| t.std_error),
                    difference_ci_low: found.map(|t| t.ci_low),
                    difference_ci_high: found.map(|t| t.ci_high),
                    df: found.map(|t| t.df),
                    p_value: found.map(|t| t.p_value),
                    remark: tested.as_ref().err().map(|why| why.to_string().into()),
                });
            }
        }
        let groups = rows.groups(parameters);
        if groups.len() < 2 || own.len() < 2 {
            continue;
        }
        let cells: Vec<Vec<usize>> = groups
            .iter()
            .map(|group| own.iter().map(|mode| group * modes + mode).collect())
            .collect();
        let lacking = cells.iter().flatten().find(|cell| !rows.cell.contains(cell));
        let tested = match (&fit, &tests, lacking) {
            (_, _, Some(cell)) => Err(format!(
                "nobody of the group {} has trials in the mode {}",
                split.groups.compared.levels[cell / modes],
                parameters.modes[cell % modes]
            )),
            (Err(why), ..) | (_, Err(why), _) => Err(why.to_string()),
            (Ok(fit), Ok(tests), None) => {
                group_by_mode(fit, tests, &cells).map_err(|why| why.to_string())
            }
        };
        let found = tested.as_ref().ok();
        let people: BTreeSet<usize> = rows.participant.iter().copied().collect();
        interactions.push(GroupModelTest {
            metric: measure.parameters.metric.clone(),
            unit: measure.unit.clone(),
            environment: parameters.environments[environment].clone(),
            groups: groups.len(),
            modes: own.len(),
            n: people.len(),
            trials: rows.value.len(),
            f: found.map(|f| f.statistic),
            df_effect: found.map(|f| f.df_num),
            df_error: found.map(|f| f.df_den),
            p_value: found.map(|f| f.p_value),
            remark: tested.as_ref().err().map(|why| why.clone().into()),
        });
    }
    ByGroup { differences: models, tests: interactions }
}

/// Kenward and Roger's F of group × mode: whether the differences of later modes from the first are those of the first group
/// in every later group, (groups − 1)(modes − 1) contrasts at once. `cells` has the means of each group, mode by mode, by their
/// numbers in the model; two groups and two modes at least.
fn group_by_mode(
    fit: &TrialFit,
    tests: &Tests,
    cells: &[Vec<usize>],
) -> Result<FTest, Unestimable> {
    let mut contrasts = Vec::new();
    for group in &cells[1..] {
        for mode in 1..group.len() {
            let own = fit.difference(group[mode], group[0])?;
            let of_first = fit.difference(cells[0][mode], cells[0][0])?;
            contrasts.push(combined(&[(1.0, own), (-1.0, of_first)]));
        }
    }
    tests.test_all(&contrasts.iter().map(Vec::as_slice).collect::<Vec<_>>())
}

/// The slope over a dose by a mixed model with everybody's own line and level, where each level is one condition and
/// everybody has one session.
pub(crate) fn of_doses(
    trials: &Trials,
    unit: &UnitOfAnalysis,
    measure: &Measure,
    parameters: &Parameters,
) -> Vec<DoseModel> {
    if *unit != UnitOfAnalysis::Participants
        || parameters.groups.is_some()
        || trials.sessions.len() > 1
    {
        return Vec::new();
    }
    let mut models = Vec::new();
    for effect in parameters.effects.iter().filter(|effect| effect.is_claimed) {
        let Some(over) = effect.over.as_ref() else { continue };
        let is_slope = !effect.levels.iter().any(LevelContrast::is_bend);
        let conditions: Vec<[usize; 2]> = over
            .levels
            .iter()
            .filter_map(|level| match level.as_slice() {
                [one] => parameters.condition(&one.environment, &one.mode),
                _ => None,
            })
            .collect();
        if !is_slope || conditions.len() != over.doses.len() {
            continue;
        }
        let doses = over.scaled();
        let (mut people, mut levels, mut dose, mut values) = (vec![], vec![], vec![], vec![]);
        for trial in &trials.trials {
            let own = conditions.iter().position(|own| *own == [trial.environment, trial.mode]);
            let (Some(level), Some(value)) = (own, trial.value) else { continue };
            people.push(trial.participant);
            levels.push(level);
            dose.push(doses[level]);
            values.push(value);
        }
        if values.is_empty() {
            continue;
        }
        let fit =
            fit_doses(Dosed { participant: &people, level: &levels, dose: &dose, value: &values });
        let fitted = fit.as_ref().ok();
        let tested = fit
            .as_ref()
            .map_err(Clone::clone)
            .and_then(|fit| fit.kenward_roger()?.test(&[0.0, 1.0], parameters.level));
        let found = tested.as_ref().ok();
        models.push(DoseModel {
            metric: measure.parameters.metric.clone(),
            unit: measure.unit.clone(),
            environment: effect.environment.clone(),
            effect: effect.term.clone(),
            levels: EffectLevels(effect.levels.clone()),
            n: fitted.map(|fit| fit.groups),
            trials: values.len(),
            slope: found.map(|t| t.estimate),
            slope_std_error: found.map(|t| t.std_error),
            slope_ci_low: found.map(|t| t.ci_low),
            slope_ci_high: found.map(|t| t.ci_high),
            df: found.map(|t| t.df),
            p_value: found.map(|t| t.p_value),
            singular: fitted.map(|fit| fit.singular),
            remark: tested.as_ref().err().map(|why| why.to_string().into()),
        });
    }
    models
}

/// The standard deviation of a term; `None` for one that the model does not have.
fn deviation(fit: &TrialFit, term: Term) -> Option<f64> {
    let place = fit.structure.iter().position(|t| *t == term)?;
    let variance = *fit.fit.terms.get(place)?.covariance.first()?.first()?;
    Some(variance.max(0.0).sqrt())
}
