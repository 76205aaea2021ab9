//! What other programs print of the same contrasts, with a sentence each on why it differs: one row per environment,
//! contrast and program.
//!
//! They are given the trials as they are: they know neither sessions nor groups of people nor lines over
//! trials.

use crate::measure::Measure;
use crate::trials::Trials;
use crate::{CompareError, Parameters};
use std::collections::BTreeSet;
use zwidth_results::{Distribution, EffectKind, ModeDifference, Model, Program, ProgramDifference};
use zwidth_stats::Unestimable;
use zwidth_stats::peers::{self, EMMEANS_LIMIT, Fitted, Peer, Printed, Reference};
use zwidth_study::MetricId;
use zwidth_tables::Measured;

/// The programs, in the order in which they are printed.
const PEERS: [(Peer, Program); 8] = [
    (Peer::LmerTest, Program::LmerTest),
    (Peer::LmerTestModes, Program::LmerTestModes),
    (Peer::Pbkrtest, Program::Pbkrtest),
    (Peer::Emmeans, Program::Emmeans),
    (Peer::Statsmodels, Program::Statsmodels),
    (Peer::Pingouin, Program::Pingouin),
    (Peer::Pyfixest, Program::Pyfixest),
    (Peer::PyfixestClustered, Program::PyfixestClustered),
];

/// The trials of an environment that have the metric, by the places of their names.
#[derive(Default)]
struct Rows {
    participant: Vec<usize>,
    mode: Vec<usize>,
    value: Vec<f64>,
}

/// The contrasts of a metric as zwidth has them, `contrasts` and `models`, and as other programs print them.
///
/// # Errors
/// A metric that is not compared; a table that lacks a column.
pub fn peers(
    tables: &[Measured],
    metric: &MetricId,
    contrasts: &[ModeDifference],
    models: &[Model],
    parameters: &Parameters,
) -> Result<Vec<ProgramDifference>, CompareError> {
    let has = |table: &&Measured| table.metric(metric.as_str()).is_some();
    let metrics = tables.iter().find(has).ok_or(CompareError::NoTable)?;
    let own = parameters.metrics.iter().find(|own| own.metric == *metric);
    let measure = Measure::new(metrics, own.ok_or(CompareError::NoTable)?)?;
    let trials = Trials::of(metrics, &measure, parameters)?;
    let mut all = Vec::new();
    for (place, environment) in parameters.environments.iter().enumerate() {
        let mut rows = Rows::default();
        for trial in trials.trials.iter().filter(|trial| trial.environment == place) {
            let Some(value) = trial.value else { continue };
            rows.participant.push(trial.participant);
            rows.mode.push(trial.mode);
            rows.value.push(value);
        }
        let Rows { participant, mode, value } = &rows;
        let fitted = Fitted::of(peers::Trials { participant, mode, value });
        let people: BTreeSet<usize> = participant.iter().copied().collect();
        let modes: BTreeSet<usize> = mode.iter().copied().collect();
        let names = |places: &[usize]| {
            let names = places.iter().map(|place| trials.participants[*place].to_string());
            (!places.is_empty()).then(|| names.collect::<Vec<_>>().join(", "))
        };
        for row in contrasts.iter().filter(|row| row.environment == *environment) {
            let Some(pair) = parameters.modes_of(&row.contrast) else { continue };
            let lacks_one = |person: &&usize| {
                let has = |wanted: &usize| {
                    participant.iter().zip(mode).any(|own| own == (*person, wanted))
                };
                !pair.iter().all(has)
            };
            let lacking: Vec<usize> = people.iter().filter(lacks_one).copied().collect();
            all.push(of_paired(row, names(&lacking), value.len()));
            let same = |model: &&Model| {
                model.environment == *environment && model.contrast == row.contrast
            };
            all.extend(models.iter().find(same).map(of_model));
            for (peer, program) in PEERS {
                let printed = fitted
                    .as_ref()
                    .map_err(Clone::clone)
                    .and_then(|fitted| fitted.printed(peer, pair, parameters.level));
                let left_out = printed.as_ref().ok().and_then(|printed| {
                    let is_out = |person: &&usize| !printed.participants.contains(person);
                    names(&people.iter().filter(is_out).copied().collect::<Vec<_>>())
                });
                let why = why(peer, &printed, modes.len());
                all.push(of_program(row, program, printed.ok(), left_out, why));
            }
        }
    }
    Ok(all)
}

/// The paired differences, on which claims rest.
fn of_paired(row: &ModeDifference, left_out: Option<String>, trials: usize) -> ProgramDifference {
    let why = "everybody's difference between the means of two modes is one value, whatever the number of their trials";
    ProgramDifference {
        metric: row.metric.clone(),
        unit: row.unit.clone(),
        environment: row.environment.clone(),
        contrast: row.contrast.clone(),
        program: Program::Zwidth,
        n: Some(row.n),
        trials: left_out.is_none().then_some(trials),
        left_out,
        difference: Some(row.difference),
        difference_std_error: row.difference_std_error,
        difference_ci_low: row.difference_ci_low,
        difference_ci_high: row.difference_ci_high,
        statistic: row.statistic,
        distribution: row.statistic.map(|_| Distribution::T),
        df: row.df,
        p_value: row.p_value,
        effect_size: row.g_av,
        effect: row.g_av.map(|_| EffectKind::GAv),
        why: match &row.remark {
            Some(remark) => format!("{why}; {remark}").into(),
            None => why.to_owned().into(),
        },
    }
}

/// The mixed model beside them.
fn of_model(row: &Model) -> ProgramDifference {
    let why = match (&row.remark, &row.random_terms) {
        (Some(remark), _) => format!("there is no test: {remark}"),
        (None, Some(terms)) => {
            format!("{terms} are random; Kenward and Roger's degrees of freedom")
        }
        (None, None) => "Kenward and Roger's degrees of freedom".to_owned(),
    };
    let statistic = row.difference.zip(row.difference_std_error).map(|(d, error)| d / error);
    ProgramDifference {
        metric: row.metric.clone(),
        unit: row.unit.clone(),
        environment: row.environment.clone(),
        contrast: row.contrast.clone(),
        program: Program::ZwidthModel,
        n: row.n,
        trials: Some(row.trials),
        left_out: None,
        difference: row.difference,
        difference_std_error: row.difference_std_error,
        difference_ci_low: row.difference_ci_low,
        difference_ci_high: row.difference_ci_high,
        statistic,
        distribution: statistic.map(|_| Distribution::T),
        df: row.df,
        p_value: row.p_value,
        effect_size: None,
        effect: None,
        why: why.into(),
    }
}

/// What a program prints of the contrast of a row.
fn of_program(
    row: &ModeDifference,
    program: Program,
    printed: Option<Printed>,
    left_out: Option<String>,
    why: String,
) -> ProgramDifference {
    let printed = printed.as_ref();
    let effect_size = printed.and_then(|printed| printed.effect_size);
    let interval = printed.and_then(|printed| printed.interval);
    ProgramDifference {
        metric: row.metric.clone(),
        unit: row.unit.clone(),
        environment: row.environment.clone(),
        contrast: row.contrast.clone(),
        program,
        n: printed.map(|printed| printed.participants.len()),
        trials: printed.map(|printed| printed.trials),
        left_out,
        difference: printed.map(|printed| printed.estimate),
        difference_std_error: printed.and_then(|printed| printed.std_error),
        difference_ci_low: interval.map(|ends| ends[0]),
        difference_ci_high: interval.map(|ends| ends[1]),
        statistic: printed.map(|printed| printed.statistic),
        distribution: printed.map(|printed| match printed.reference {
            Reference::T => Distribution::T,
            Reference::Normal => Distribution::Normal,
            Reference::StudentisedRange(_) => Distribution::StudentisedRange,
        }),
        df: printed.map(|printed| printed.df).filter(|df| df.is_finite()),
        p_value: printed.map(|printed| printed.p_value),
        effect_size,
        effect: effect_size.map(|_| match program {
            Program::Emmeans => EffectKind::ResidualDeviations,
            _ => EffectKind::GAvApproximate,
        }),
        why: why.into(),
    }
}

/// Why the numbers of a program differ from ours, or why it prints none, of so many modes.
fn why(peer: Peer, printed: &Result<Printed, Unestimable>, modes: usize) -> String {
    let printed = match printed {
        Ok(printed) => printed,
        Err(why) => return format!("it prints no number: {why}"),
    };
    let pairs = modes * (modes - 1) / 2;
    match peer {
        Peer::LmerTest if printed.singular => {
            "it takes the participants' variance of zero as certain, so it counts trials".to_owned()
        }
        Peer::LmerTest => {
            "it takes modes to differ alike for everybody, so it counts trials".to_owned()
        }
        Peer::LmerTestModes if printed.singular => {
            "Satterthwaite's degrees of freedom take a variance of zero as certain, so repeats count as people".to_owned()
        }
        Peer::LmerTestModes => {
            "Satterthwaite's degrees of freedom; who has fewer trials weighs less".to_owned()
        }
        Peer::Pbkrtest => {
            "Kenward and Roger's degrees of freedom keep a variance of zero as unknown; who has fewer trials weighs less"
                .to_owned()
        }
        Peer::Emmeans => {
            let tukey = match pairs {
                1 => "as pbkrtest: of two modes there is one pair, so nothing is adjusted".to_owned(),
                _ => format!("p and interval are adjusted for all {pairs} pairs of modes, compared or not (Tukey)"),
            };
            match printed.trials > EMMEANS_LIMIT {
                true => format!("{tukey}; of more than {EMMEANS_LIMIT} trials it has no degrees of freedom"),
                false => tukey,
            }
        }
        Peer::Statsmodels => {
            "the normal distribution, as if there were any number of people; modes differ alike for everybody"
                .to_owned()
        }
        Peer::Pingouin => {
            "means as ours, sessions taken together; who lacks any mode is left out of every pair".to_owned()
        }
        Peer::Pyfixest => {
            "participants are constants and their trials the units, so it counts trials".to_owned()
        }
        Peer::PyfixestClustered => {
            "errors of one participant may be correlated in any way; participants weigh by their trials".to_owned()
        }
    }
}
