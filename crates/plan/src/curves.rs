//! Stage `compare`, of whole curves: one job, and a figure for each curve and environment.

use crate::average::{aligned, looped};
use crate::compare::{
    STAGE, claims_of_both, compares_curves, environments_of_curves, groups, has_group_differences,
    is_of_one, order,
};
use crate::figures::drawing::{Drawing, Figured};
use crate::shared::conditions::{sessions, trial_sources};
use crate::shared::handle::{Derived, write_named};
use crate::shared::making::derived;
use crate::shared::trials::{OfTrials, Recordings, files, open_all};
use crate::tables::printed::Printed;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::PathBuf;
use zwidth_average::{Alignment, AverageError, Parameters as AverageParameters};
use zwidth_compare::{CurveParameters, CurveSpread, SessionCurve, compare_curves, curve_spreads};
use zwidth_figures::{About, CURVES_COMPARED, CurvesShown, IN_GROUPS, curves_compared};
use zwidth_results::{CurveDifference, CurveNode, CurveRun, OVER_SEVERAL};
use zwidth_runner::{Inputs, Job, JobError, Made, Making};
use zwidth_store::{OpenTrial, StudyData, TrialEntry};
use zwidth_study::{Curve, Environment, EnvironmentId, Source};
use zwidth_tables::{Table, TableError};

/// The results of the job.
#[derive(Clone)]
pub(crate) struct OfCurves {
    points: Derived<CurveNode>,
    pub(crate) tests: Derived<CurveDifference>,
    pub(crate) runs: Derived<CurveRun>,
}

impl Inputs for OfCurves {
    fn files(&self) -> Vec<PathBuf> {
        let Self { points, tests, runs } = self;
        [points.path(), tests.path(), runs.path()].map(ToOwned::to_owned).to_vec()
    }
}

/// What the job depends on besides tables.
#[derive(Serialize)]
struct Comparing {
    stage: CurveParameters,
    simulated: bool,
}

/// The results, if curves are compared: there is something to compare.
pub(crate) fn of_study(data: &StudyData) -> Option<OfCurves> {
    let folder = derived(&data.layout, "compare");
    compares_curves(data).then(|| OfCurves {
        points: Derived::within(&folder),
        tests: Derived::within(&folder),
        runs: Derived::within(&folder),
    })
}

/// The tests of whole curves, as people read them.
pub fn compared_curves(data: &StudyData) -> Option<Printed> {
    of_study(data).map(|own| Printed::without_empty_columns(own.tests.path()))
}

/// The tables that people read.
pub(crate) fn tables(data: &StudyData) -> Vec<Printed> {
    let Some(results) = of_study(data) else { return Vec::new() };
    // One participant's trials have no runs.
    let runs = (!is_of_one(data)).then(|| Printed::without_empty_columns(results.runs.path()));
    [Printed::without_empty_columns(results.tests.path())].into_iter().chain(runs).collect()
}

/// The means of every condition over the angle, and over the time.
type Means = (Vec<PathBuf>, Vec<PathBuf>);

/// The files that the study's curves are read from.
fn means(data: &StudyData) -> Means {
    let (study, compare) = (&data.study, &data.study.compare);
    let has =
        |over_angle: bool| compare.curves.iter().any(|curve| curve.is_over_angle() == over_angle);
    let mut means = Means::default();
    for session in sessions(data) {
        for environment in environments_of_curves(data) {
            for mode in &study.modes {
                let Some(repeats) = session.repeats(environment, mode) else { continue };
                means.0.extend(has(true).then(|| looped(&data.layout, &repeats)));
                let at_onset = || aligned(&data.layout, &repeats, Alignment::Onset);
                means.1.extend(has(false).then(at_onset));
            }
        }
    }
    means
}

fn parameters(data: &StudyData) -> CurveParameters {
    let (study, compare) = (&data.study, &data.study.compare);
    CurveParameters {
        curves: compare.curves.clone(),
        primary: compare.primary.curves().collect(),
        metric_claims: claims_of_both(study)[1],
        nodes: compare.curve_nodes,
        environments: study.environments.iter().map(|e| e.id.clone()).collect(),
        modes: study.modes.iter().map(|m| m.id.clone()).collect(),
        contrasts: compare.contrasts.clone(),
        effects: study.effects(),
        groups: compare.groups.as_ref().map(|compared| groups(data, compared)),
        families: compare.families,
        alpha: compare.alpha,
        level: compare.level,
        orders: match is_of_one(data) {
            true => data.sessions.iter().map(|log| order(log, study)).collect(),
            false => Vec::new(),
        },
    }
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let Some(results) = of_study(data) else { return Vec::new() };
    let simulated = data.counting().any(|trial| trial.meta.source.is_simulated());
    let comparing = Comparing { stage: parameters(data), simulated };
    let name = "compare curves";
    if !is_of_one(data) {
        return vec![Job::new(STAGE, name, comparing, means(data), results.files(), make)];
    }
    let of_environment = |own: &Environment| {
        let analysis = data.study.analysis;
        (own.id.clone(), AverageParameters { analysis, scene: own.scene })
    };
    let averages: BTreeMap<_, _> = environments_of_curves(data).map(of_environment).collect();
    let own = data.counting().filter(|trial| {
        averages.contains_key(&trial.meta.environment)
            && data.study.mode(&trial.meta.mode).is_some()
    });
    let trials: Vec<&TrialEntry> = own.collect();
    let of_trials = OfTrials::new(ComparingTrials { comparing, averages }, &trials);
    vec![Job::new(STAGE, name, of_trials, files(&trials), results.files(), make_of_one)]
}

/// What the comparison of one participant's trials depends on besides recordings.
#[derive(Serialize)]
struct ComparingTrials {
    #[serde(flatten)]
    comparing: Comparing,
    /// How a trial's course is found, by environment.
    averages: BTreeMap<EnvironmentId, AverageParameters>,
}

/// The curves of trials, each as the mean of its one repeat.
fn make_of_one(
    parameters: &OfTrials<ComparingTrials>,
    files: &Recordings,
    making: &Making,
) -> Result<Made, JobError> {
    let ComparingTrials { comparing, averages } = &parameters.stage;
    let (trials, problems) = open_all(files, &parameters.trials)?;
    let curves = &comparing.stage.curves;
    let of_trial = |trial: &OpenTrial| -> Result<Vec<SessionCurve>, JobError> {
        let Some(own) = averages.get(&trial.meta.environment) else { return Ok(Vec::new()) };
        let one = std::slice::from_ref(trial);
        let of_curve = |curve: &Curve| -> Result<SessionCurve, JobError> {
            let table = if curve.is_over_angle() {
                match zwidth_average::mean_loop(one, own) {
                    Ok(mean) => zwidth_average::loop_table(&mean)?,
                    Err(AverageError::WhyNot(why)) => zwidth_average::no_loop(&why)?,
                    Err(error) => return Err(error.into()),
                }
            } else {
                match zwidth_average::average(one, own, Alignment::Onset) {
                    Ok(average) => zwidth_average::table(&[average])?,
                    Err(AverageError::WhyNot(why)) => zwidth_average::no_average(&why)?,
                    Err(error) => return Err(error.into()),
                }
            };
            Ok(SessionCurve::of_trial(&trial.meta, &table, *curve)?)
        };
        let found = curves.iter().map(of_curve).collect::<Result<Vec<_>, JobError>>()?;
        // A course without a column that could not be read is void.
        match trial.columns().failure() {
            Some(error) => Err(error.into()),
            None => Ok(found),
        }
    };
    let found: Vec<Vec<SessionCurve>> =
        trials.iter().map(of_trial).collect::<Result<_, JobError>>()?;
    write_compared(&found.concat(), comparing, making, problems)
}

/// Every session's mean curves in every condition.
fn read(curves: &[Curve], means: &Means) -> Result<Vec<SessionCurve>, TableError> {
    let mut sessions = Vec::new();
    for curve in curves {
        let files = if curve.is_over_angle() { &means.0 } else { &means.1 };
        let columns = SessionCurve::columns(*curve);
        let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
        // Of a large study the tables together would take far more memory than the curves.
        let own = files
            .par_iter()
            .map(|file| SessionCurve::of(&Table::columns_from_parquet(file, &columns)?, *curve));
        let own: Vec<_> = own.collect::<Result<_, TableError>>()?;
        sessions.extend(own.into_iter().flatten());
    }
    Ok(sessions)
}

/// How people's curves scatter in what is compared; nothing of a study without.
///
/// # Errors
/// Tables that do not exist.
pub fn spreads_of_curve(data: &StudyData, curve: Curve) -> Result<Vec<CurveSpread>, TableError> {
    if of_study(data).is_none() {
        return Ok(Vec::new());
    }
    Ok(curve_spreads(&read(&[curve], &means(data))?, curve, &parameters(data)))
}

fn make(comparing: &Comparing, means: &Means, making: &Making) -> Result<Made, JobError> {
    write_compared(&read(&comparing.stage.curves, means)?, comparing, making, Vec::new())
}

fn write_compared(
    curves: &[SessionCurve],
    Comparing { stage, simulated }: &Comparing,
    making: &Making,
    problems: Vec<String>,
) -> Result<Made, JobError> {
    let found = compare_curves(curves, stage)?;
    let of_one = found.tests.iter().find_map(|test| test.within.as_ref());
    let tables = vec![
        Table::of_rows(&found.points)?,
        match (of_one, &stage.groups) {
            (Some(who), _) => Table::of_rows(&found.tests)?.with_note(format!(
                "n counts trials of {who}, who stands for nobody else. Test: the sharp null, that no trial's curve depended \
                 on mode, by other orders that the design could have drawn. Intervals are Welch's, of trials, at each node by \
                 itself, as a description."
            )),
            (None, None) => Table::of_rows(&found.tests)?,
            (None, Some(groups)) => Table::of_rows(&found.tests)?.with_note(format!(
                "Differences between groups are described, not claimed: {}. Their intervals are pointwise.",
                match groups.blocks.is_empty() {
                    true => {
                        "labels are permuted as if groups were exchangeable, and where they scatter differently that \
                         finds too many"
                    }
                    false => {
                        "labels are permuted within the blocks in which chance drew them, under the hypothesis that the \
                         group changed nobody's curve; as a test of means it finds too many where groups scatter \
                         differently"
                    }
                }
            )),
        },
        Table::of_rows(&found.runs)?.with_note(
            "A run says that there is a difference somewhere in it, not where it begins or ends.",
        ),
    ];
    Ok(Made { problems, ..write_named(tables, making, *simulated)? })
}

/// What a figure depends on besides tables.
#[derive(Serialize)]
struct Drawn {
    about: About,
    /// `None` of the effects over several.
    environment: Option<Environment>,
    curve: Curve,
    /// Whether groups are shown, or everybody.
    of_groups: bool,
    alpha: f64,
    level: f64,
    sources: Vec<Source>,
}

/// The figure of every curve in every environment, and of what is compared over several.
pub(crate) fn figures(data: &StudyData) -> Vec<Drawing> {
    let Some(results) = of_study(data) else { return Vec::new() };
    let has_groups = has_group_differences(data);
    let of_everybody = !data.study.compare.contrasts.is_empty() || !data.study.effects().is_empty();
    let mut drawings = Vec::new();
    let environments: Vec<&Environment> = environments_of_curves(data).collect();
    let is_moved = |id: &EnvironmentId| environments.iter().any(|own| own.id == *id);
    let is_over_several = !is_of_one(data)
        && data.study.effects().iter().any(|effect| {
            let is_drawn = effect.environment.is_none() && effect.is_claimed;
            is_drawn && effect.weights.iter().all(|weight| is_moved(&weight.environment))
        });
    let places = environments.iter().copied().map(Some).chain(is_over_several.then_some(None));
    for curve in &data.study.compare.curves {
        for environment in places.clone() {
            let own = data.counting().filter(|trial| {
                environment.is_none_or(|environment| environment.id == trial.meta.environment)
            });
            let n = own.count();
            for of_groups in [false, true] {
                let is_drawn = if of_groups { has_groups } else { of_everybody };
                if !is_drawn {
                    continue;
                }
                let drawn = Drawn {
                    about: About::of(&data.study),
                    environment: environment.cloned(),
                    curve: *curve,
                    of_groups,
                    alpha: data.study.compare.alpha,
                    level: data.study.compare.level,
                    sources: trial_sources(data),
                };
                let place = environment.map_or(OVER_SEVERAL, |environment| environment.id.as_str());
                let subject = [curve.as_str(), place].into_iter();
                let subject = subject.chain(of_groups.then_some(IN_GROUPS));
                let drawing =
                    Drawing::new(data, CURVES_COMPARED, subject, drawn, results.clone(), draw);
                drawings.push(drawing.of(n));
            }
        }
    }
    drawings
}

fn draw(drawn: &Drawn, tables: &OfCurves) -> Figured {
    let Drawn { about, environment, curve, of_groups, alpha, level, sources } = drawn;
    let is_own = |own: Curve, place: &Option<EnvironmentId>| {
        own == *curve && place.as_ref() == environment.as_ref().map(|own| &own.id)
    };
    let mut points = tables.points.read()?;
    points.retain(|row| is_own(row.curve, &row.environment));
    let mut tests = tables.tests.read()?;
    tests.retain(|row| is_own(row.curve, &row.environment) && row.groups.is_some() == *of_groups);
    let mut runs = tables.runs.read()?;
    runs.retain(|row| is_own(row.curve, &row.environment));
    let shown = CurvesShown {
        curve: *curve,
        points: &points,
        tests: &tests,
        runs: &runs,
        alpha: *alpha,
        level: *level,
    };
    Ok((curves_compared(about, environment.as_ref(), sources, &shown), Vec::new()))
}
