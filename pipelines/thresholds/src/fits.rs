//! What the answers of one person tell in one session and mode.

use crate::answered::Own;
use crate::{Answered, Response, levels};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;
use zwidth_results::{
    FitVerdict, FittedShare, LevelMethod, LevelTally, Presentation, PsychometricFit,
};
use zwidth_stats::interval;
use zwidth_stats::null::Sampling;
use zwidth_stats::psychometric::fit::{self, Fitted, Side, Verdict};
use zwidth_stats::psychometric::{
    AnsweredLevel, Curve, LevelAnswers, adjustment, deviance, grid, plans, quest, staircase,
};
use zwidth_study::{
    Method, ModeId, ParticipantId, QuestionId, SessionId, StaircasePlan, Task, TaskEstimate,
    TaskQuantity,
};

/// Draws of the deviance have this seed, so that a fit has one p value.
const SEED: u64 = 56;
/// Steps of a curve that is drawn.
const CURVE_STEPS: usize = 80;
/// The fewest settings that have a spread.
const FEWEST_SETTINGS: usize = 2;
/// The fewest staircases whose spread says how far their mean may be off.
const FEWEST_STAIRCASES: usize = 3;

/// What fits depend on besides the answers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameters {
    /// The tasks, in the study's order.
    pub tasks: Vec<Task>,
    /// The modes, likewise.
    pub modes: Vec<ModeId>,
    /// Level of every interval, as a fraction.
    pub level: f64,
    /// How often answers are drawn from each curve to see whether it describes those that were given; 0: not at all.
    pub draws: usize,
}

impl Parameters {
    /// Draws where nobody needs fewer.
    pub const DRAWS: usize = deviance::DRAWS;
}

/// What the answers tell.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Found {
    /// Every presentation that was answered.
    pub presentations: Vec<Presentation>,
    /// The answers by level; of people who set the level there are none.
    pub by_level: Vec<LevelTally>,
    /// Points of the curves that were fitted.
    pub curves: Vec<FittedShare>,
    /// What they tell of everybody in each session and mode.
    pub fits: Vec<PsychometricFit>,
}

/// Presentations, answers by level and fits, by task, participant, session and mode. Answers to a task that the study
/// does not have are left out.
pub fn thresholds(answers: &[Answered], parameters: &Parameters) -> Found {
    let place = |id: &QuestionId| parameters.tasks.iter().position(|task| task.id == *id);
    let mut groups: BTreeMap<(usize, &ParticipantId, &SessionId, usize), Own> = BTreeMap::new();
    for answer in answers {
        let (Some(at), Some(mode)) =
            (place(&answer.task), parameters.modes.iter().position(|mode| *mode == answer.mode))
        else {
            continue;
        };
        let task = &parameters.tasks[at];
        let key = (at, &answer.participant, &answer.session, mode);
        let own = groups.entry(key).or_insert_with(|| Own { task, answers: Vec::new() });
        own.answers.push(answer);
    }
    let mut groups: Vec<Own> = groups.into_values().collect();
    for own in &mut groups {
        own.answers.sort_by_key(|answer| (answer.track, answer.presentation, answer.trial));
    }
    // `par_iter` keeps the order, and each fit has its own draws: the same rows with any number of threads.
    let found: Vec<_> = groups.par_iter().map(|own| found(own, parameters)).collect();
    let mut all = Found::default();
    for (own, (fit, reversals)) in groups.iter().zip(found) {
        all.presentations.extend(presentations(own, &reversals));
        if !matches!(own.task.method, Method::Adjustment { .. }) {
            all.by_level.extend(levels::rows(own));
        }
        all.curves.extend(fit.iter().flat_map(|fit| curve(own, fit)));
        all.fits.extend(fit);
    }
    all
}

/// What one person's answers tell in one session and mode, and the places of its answers at which levels turned.
fn found(own: &Own, parameters: &Parameters) -> (Option<PsychometricFit>, Vec<usize>) {
    let Some(empty) = empty(own) else { return (None, Vec::new()) };
    let row = match &own.task.method {
        Method::Constant { .. } => of_curve(own, parameters, empty),
        Method::Staircase(plan) => {
            let (row, reversals) = of_staircases(own, plan, parameters.level, empty);
            return (Some(row), reversals);
        }
        Method::QuestPlus { .. } => of_quest(own, parameters.level, empty),
        Method::Adjustment { .. } => of_settings(own, parameters.level, empty),
    };
    (Some(row), Vec::new())
}

/// A row without an estimate; `None` without answers.
fn empty(own: &Own) -> Option<PsychometricFit> {
    let first = own.answers.iter().min_by_key(|answer| answer.trial)?;
    let levels = || own.answers.iter().map(|answer| answer.level);
    let (method, is_set) = match own.task.method {
        Method::Constant { .. } => (LevelMethod::Constant, false),
        Method::Staircase(_) => (LevelMethod::Staircase, false),
        Method::QuestPlus { .. } => (LevelMethod::QuestPlus, false),
        Method::Adjustment { .. } => (LevelMethod::Adjustment, true),
    };
    let quantity = if own.task.has_pse() { TaskQuantity::Pse } else { TaskQuantity::Threshold };
    let settings = own.answers.iter().filter(|answer| answer.response == Response::Set).count();
    Some(PsychometricFit {
        participant: first.participant.clone(),
        session: first.session.clone(),
        task: own.task.id.clone(),
        environment: first.environment.clone(),
        mode: first.mode.clone(),
        trial: first.trial,
        source: first.source,
        unit: own.task.unit().into(),
        method,
        quantity,
        verdict: FitVerdict::TooFew,
        levels: levels::counts(own).len(),
        lowest_level: levels().min()?.value(),
        highest_level: levels().max()?.value(),
        trials: own.answers.len(),
        threshold: None,
        threshold_ci_low: None,
        threshold_ci_high: None,
        threshold_std_error: None,
        jnd: None,
        jnd_ci_low: None,
        jnd_ci_high: None,
        ln_jnd_std_error: None,
        weber_fraction: None,
        location: None,
        sigma: None,
        guess: None,
        lapse: None,
        dispersion: None,
        deviance: None,
        deviance_p_value: None,
        grid_threshold: None,
        grid_threshold_ci_low: None,
        grid_threshold_ci_high: None,
        grid_jnd: None,
        grid_jnd_ci_low: None,
        grid_jnd_ci_high: None,
        target: None,
        turns: is_set.then_some(settings),
        is_at_bound: false,
        remark: None,
    })
}

/// The same row with the reason why the answers cannot be those of the task.
fn refused(row: PsychometricFit, why: impl std::fmt::Display) -> PsychometricFit {
    let remark = Some(why.to_string().into());
    PsychometricFit { verdict: FitVerdict::Refused, remark, ..row }
}

/// Constant stimuli: the curve with its intervals, and whether it describes the answers.
fn of_curve(own: &Own, parameters: &Parameters, row: PsychometricFit) -> PsychometricFit {
    let Some(model) = plans::model(own.task) else {
        return refused(row, "the person set the level, which constant stimuli do not allow");
    };
    let answers = levels::answers(own);
    let fit = match fit::fit(&answers, &model, parameters.level) {
        Ok(fit) => fit,
        Err(error) => return refused(row, error),
    };
    let row = PsychometricFit { verdict: verdict(fit.verdict), ..row };
    let row = match own.task.estimate {
        TaskEstimate::Grid => with_grid(row, &answers, &model, parameters.level),
        TaskEstimate::Likelihood => row,
    };
    let Some(fitted) = fit.fitted else { return row };
    let sampling = Sampling { draws: parameters.draws, seed: SEED };
    let p_value = deviance::p_value(&answers, &model, &fitted.curve, sampling);
    let p_value = p_value.ok().filter(|_| parameters.draws > 0);
    let Fitted { curve, threshold, jnd, .. } = fitted;
    PsychometricFit {
        threshold: Some(threshold.estimate),
        threshold_ci_low: threshold.ci_low,
        threshold_ci_high: threshold.ci_high,
        threshold_std_error: fitted.threshold_error,
        jnd: Some(jnd.estimate),
        jnd_ci_low: jnd.ci_low,
        jnd_ci_high: jnd.ci_high,
        ln_jnd_std_error: fitted.ln_jnd_error,
        dispersion: Some(fitted.dispersion),
        deviance: Some(fitted.deviance),
        deviance_p_value: p_value,
        ..with_curve(own, row, &curve)
    }
}

/// psignifit's posterior beside it, in which answers may scatter more than binomial ones; nothing where it has none.
fn with_grid(
    row: PsychometricFit,
    answers: &[LevelAnswers],
    model: &fit::Model,
    level: f64,
) -> PsychometricFit {
    let grid = grid::Grid { asks: model.asks, sigmoid: model.sigmoid, is_overdispersed: true };
    let Ok(posterior) = grid::posterior(answers, &grid, level) else { return row };
    PsychometricFit {
        grid_threshold: Some(posterior.threshold.mean),
        grid_threshold_ci_low: Some(posterior.threshold.ci_low),
        grid_threshold_ci_high: Some(posterior.threshold.ci_high),
        grid_jnd: Some(posterior.jnd.mean),
        grid_jnd_ci_low: Some(posterior.jnd.ci_low),
        grid_jnd_ci_high: Some(posterior.jnd.ci_high),
        ..row
    }
}

fn with_curve(own: &Own, row: PsychometricFit, curve: &Curve) -> PsychometricFit {
    PsychometricFit {
        weber_fraction: weber_fraction(own, curve.jnd()),
        location: Some(curve.location),
        sigma: Some(curve.scale),
        guess: Some(curve.guess),
        lapse: Some(curve.lapse),
        ..row
    }
}

/// The JND over the standard, where that is above 0.
fn weber_fraction(own: &Own, jnd: f64) -> Option<f64> {
    let standard = own.task.standard?.value();
    (standard > 0.0).then(|| jnd / standard)
}

fn verdict(of_fit: Verdict) -> FitVerdict {
    match of_fit {
        Verdict::Estimated => FitVerdict::Estimated,
        Verdict::Outside(Side::Below) => FitVerdict::Below,
        Verdict::Outside(Side::Above) => FitVerdict::Above,
        Verdict::Steep => FitVerdict::Steep,
        Verdict::Falling => FitVerdict::Falling,
        Verdict::Flat => FitVerdict::Flat,
        Verdict::TooFew => FitVerdict::TooFew,
    }
}

/// One staircase of a person.
struct Turned {
    /// The places of its answers at which the level turned.
    places: Vec<usize>,
    /// The mean of its last reversals.
    threshold: Option<f64>,
    is_at_bound: bool,
    /// Whether its levels are those that plan and answers give.
    follows_plan: bool,
}

/// Staircases: the mean of their last reversals, of several their mean, on the scale of their steps, from three on with
/// Student's t interval. They have no JND: the slope of answers that gather around one level is found two times too steep after 60 trials.
fn of_staircases(
    own: &Own,
    plan: &StaircasePlan,
    level: f64,
    row: PsychometricFit,
) -> (PsychometricFit, Vec<usize>) {
    let target =
        staircase::target(plan.up_after.into(), plan.down_after.into(), down_over_up(plan)).ok();
    let mut all = Vec::new();
    let mut first = 0;
    for track in own.answers.chunk_by(|a, b| a.track == b.track) {
        match turned(plan, track, first) {
            Ok(own) => all.push(own),
            Err(error) => return (refused(row, error), Vec::new()),
        }
        first += track.len();
    }
    let reversals: Vec<usize> = all.iter().flat_map(|own| own.places.iter().copied()).collect();
    let found: Vec<f64> = all.iter().filter_map(|own| own.threshold).collect();
    let is_at_bound = all.iter().any(|own| own.is_at_bound);
    let turns = Some(reversals.len());
    let row = PsychometricFit { target, turns, is_at_bound, ..row };
    if found.len() < all.len() {
        let remark = format!(
            "{} of {} staircases ended before {} reversals",
            all.len() - found.len(),
            all.len(),
            plan.reversals
        );
        return (PsychometricFit { remark: Some(remark.into()), ..row }, reversals);
    }
    let scaled = |value: &f64| if plan.is_factor { libm::log(*value) } else { *value };
    let back = |value: f64| if plan.is_factor { libm::exp(value) } else { value };
    let values: Vec<f64> = found.iter().map(scaled).collect();
    let interval = interval::mean(&values, level).ok().and_then(|mean| mean.interval);
    // Staircases that end at one level tell nothing of how far off it is.
    let interval = interval.filter(|own| values.len() >= FEWEST_STAIRCASES && own.std_error > 0.0);
    let threshold = mean(&found, plan.is_factor);
    // Of a logarithm's error that of the threshold, to first order.
    let error_of = |error: f64| if plan.is_factor { threshold * error } else { error };
    let remark = if !all.iter().all(|own| own.follows_plan) {
        let words =
            "the levels are not those that plan and answers give; reversals are where they turned";
        Some(words.into())
    } else if is_at_bound {
        Some("a staircase came to a bound of its levels: the threshold may lie beyond".into())
    } else {
        None
    };
    let row = PsychometricFit {
        verdict: FitVerdict::Estimated,
        threshold: Some(threshold),
        threshold_ci_low: interval.map(|interval| back(interval.ci_low)),
        threshold_ci_high: interval.map(|interval| back(interval.ci_high)),
        threshold_std_error: interval.map(|interval| error_of(interval.std_error)),
        remark,
        ..row
    };
    (row, reversals)
}

/// The step down over the step up, of factors over their logarithms.
fn down_over_up(plan: &StaircasePlan) -> f64 {
    if plan.is_factor { libm::log(plan.down) / libm::log(plan.up) } else { plan.down / plan.up }
}

/// The mean, of steps that are factors the geometric one.
fn mean(values: &[f64], is_factor: bool) -> f64 {
    let n = values.len() as f64;
    match is_factor {
        true => libm::exp(values.iter().map(|value| libm::log(*value)).sum::<f64>() / n),
        false => values.iter().sum::<f64>() / n,
    }
}

/// Where a staircase turned: as its plan has it of the levels that were presented (an answer that does not count leaves
/// them as they were). Those of another program may follow another rule; then it is where they turned. `first` is the
/// place of its first answer among all.
fn turned(
    plan: &StaircasePlan,
    answers: &[&Answered],
    first: usize,
) -> Result<Turned, zwidth_stats::StatsError> {
    let levels: Vec<f64> = answers.iter().map(|answer| answer.level.value()).collect();
    let presented = answers.iter().zip(&levels).map(|(answer, level)| AnsweredLevel {
        level: *level,
        is_positive: answer.response == Response::Positive,
    });
    let presented: Vec<AnsweredLevel> = presented.collect();
    let number = answers.first().map_or(0, |answer| answer.track);
    let Some(planned) = plans::staircase(plan, number) else {
        return Err(zwidth_stats::StatsError::Staircase);
    };
    let right: Vec<bool> = presented.iter().map(|answer| answer.is_positive).collect();
    let is_of_rule = answers.iter().all(|answer| !answer.source.is_imported())
        || staircase::track(&planned, &right).is_ok_and(|track| track.levels == levels);
    // Answers beyond the end are those of another plan.
    if let Ok(track) = staircase::track_presented(&planned, &presented)
        && is_of_rule
    {
        let mut ends = Vec::new();
        for place in 0..presented.len() {
            // The number of reversals grows with the answer at which it turns.
            let so_far = staircase::track_presented(&planned, &presented[..=place])?;
            if so_far.reversals.len() > ends.len() {
                ends.push(first + place);
            }
        }
        return Ok(Turned {
            places: ends,
            threshold: track.threshold,
            is_at_bound: track.is_at_bound,
            follows_plan: true,
        });
    }
    let mut places = Vec::new();
    let mut last_is_up = None;
    for (place, two) in levels.windows(2).enumerate() {
        if two[0].total_cmp(&two[1]).is_eq() {
            continue;
        }
        let is_up = two[1] > two[0];
        if last_is_up.is_some_and(|last| last != is_up) {
            places.push(first + place);
        }
        last_is_up = Some(is_up);
    }
    let [lowest, highest] = planned.bounds;
    let turns: Vec<f64> = places.iter().map(|place| levels[place - first]).collect();
    let last = &turns[turns.len().saturating_sub(planned.of_last)..];
    let has_all = turns.len() >= planned.of_last && !last.is_empty();
    Ok(Turned {
        threshold: has_all.then(|| mean(last, plan.is_factor)),
        is_at_bound: last.iter().any(|level| *level <= lowest || *level >= highest),
        places,
        follows_plan: false,
    })
}

/// QUEST+: the means of its posterior, and the intervals that leave as much of it below as above.
fn of_quest(own: &Own, level: f64, row: PsychometricFit) -> PsychometricFit {
    let Some(plan) = plans::quest(own.task) else {
        return refused(row, "QUEST+ takes an answer of two");
    };
    if own.answers.len() < fit::FEWEST_ANSWERS as usize {
        return row;
    }
    // The posterior does not depend on the order of the answers, and takes their levels as they were.
    let answers = levels::answers(own);
    let posterior = match quest::posterior(&plan, &answers, level) {
        Ok(posterior) => posterior,
        Err(error) => return refused(row, error),
    };
    let curve = posterior.curve(&plan);
    // Of a grid with one threshold or one σ nothing is left to tell.
    let has_thresholds = posterior.threshold_sd > 0.0;
    let has_jnds = posterior.ln_jnd_sd > 0.0;
    let remark = if posterior.is_at_edge {
        Some("the posterior reaches an end of its grid: threshold or JND may lie beyond".into())
    } else if has_thresholds && is_narrow(&plan.thresholds, posterior.threshold_sd) {
        let words = "the threshold's posterior is narrower than a step of its grid, and its interval too wide";
        Some(words.into())
    } else {
        None
    };
    PsychometricFit {
        verdict: FitVerdict::Estimated,
        threshold: Some(posterior.threshold.mean),
        threshold_ci_low: has_thresholds.then_some(posterior.threshold.ci_low),
        threshold_ci_high: has_thresholds.then_some(posterior.threshold.ci_high),
        threshold_std_error: has_thresholds.then_some(posterior.threshold_sd),
        jnd: Some(curve.jnd()),
        jnd_ci_low: has_jnds.then_some(posterior.jnd.ci_low),
        jnd_ci_high: has_jnds.then_some(posterior.jnd.ci_high),
        ln_jnd_std_error: has_jnds.then_some(posterior.ln_jnd_sd),
        is_at_bound: posterior.is_at_edge,
        remark,
        ..with_curve(own, row, &curve)
    }
}

/// Whether a deviation is less than half of a step along an axis.
fn is_narrow(axis: &[f64], sd: f64) -> bool {
    axis.windows(2).any(|pair| sd < 0.5 * (pair[1] - pair[0]))
}

/// Settings: PSE = mean, JND = 0.6745 SD.
fn of_settings(own: &Own, level: f64, row: PsychometricFit) -> PsychometricFit {
    let set = own.answers.iter().filter(|answer| answer.response == Response::Set);
    let settings: Vec<f64> = set.map(|answer| answer.level.value()).collect();
    if settings.len() < FEWEST_SETTINGS {
        return row;
    }
    let found = match adjustment::adjustment(&settings, level) {
        Ok(found) => found,
        Err(error) => return refused(row, error),
    };
    let has_spread = found.jnd > 0.0;
    let alike = "all settings are alike: the JND is below the step from a level to the next";
    PsychometricFit {
        verdict: FitVerdict::Estimated,
        threshold: Some(found.threshold.estimate),
        threshold_ci_low: Some(found.threshold.ci_low),
        threshold_ci_high: Some(found.threshold.ci_high),
        threshold_std_error: has_spread.then_some(found.threshold.std_error),
        jnd: has_spread.then_some(found.jnd),
        jnd_ci_low: has_spread.then_some(found.jnd_interval[0]),
        jnd_ci_high: has_spread.then_some(found.jnd_interval[1]),
        ln_jnd_std_error: has_spread.then_some(found.ln_jnd_error),
        weber_fraction: weber_fraction(own, found.jnd).filter(|_| has_spread),
        remark: (!has_spread).then(|| alike.into()),
        ..row
    }
}

/// Points of the curve of an estimate, from the lowest to the highest level.
fn curve(own: &Own, fit: &PsychometricFit) -> Vec<FittedShare> {
    let (Some(location), Some(scale), Some(guess), Some(lapse)) =
        (fit.location, fit.sigma, fit.guess, fit.lapse)
    else {
        return Vec::new();
    };
    let curve = Curve { sigmoid: plans::sigmoid(own.task), location, scale, guess, lapse };
    let step = (fit.highest_level - fit.lowest_level) / CURVE_STEPS as f64;
    let points = (0..=CURVE_STEPS).map(|place| {
        let level = fit.lowest_level + step * place as f64;
        FittedShare {
            participant: fit.participant.clone(),
            session: fit.session.clone(),
            task: fit.task.clone(),
            mode: fit.mode.clone(),
            unit: fit.unit.clone(),
            level,
            share: curve.share(level),
        }
    });
    points.collect()
}

/// The rows of presentations, in the order of their sequences.
fn presentations(own: &Own, reversals: &[usize]) -> Vec<Presentation> {
    let rows = own.answers.iter().enumerate().map(|(place, answer)| Presentation {
        participant: answer.participant.clone(),
        session: answer.session.clone(),
        trial: answer.trial,
        task: answer.task.clone(),
        environment: answer.environment.clone(),
        mode: answer.mode.clone(),
        presentation: answer.presentation,
        sequence: usize::from(answer.track) + 1,
        unit: own.task.unit().into(),
        level: answer.level.value(),
        positive: match answer.response {
            Response::Positive => Some(true),
            Response::Negative => Some(false),
            Response::Set => None,
        },
        is_reversal: reversals.contains(&place),
    });
    rows.collect()
}
