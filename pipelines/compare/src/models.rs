//! The mixed model beside the paired differences: one row per environment and contrast.
//!
//! Trials are the rows, participants and their combinations with mode and session are random, as
//! many as the design can tell apart. Who lacks a mode stays in the model (missing at random).

use crate::cells::{KEYS, whole};
use crate::measure::Measure;
use crate::unit::Unit;
use crate::{CompareError, Parameters, columns};
use std::collections::BTreeSet;
use zwidth_stats::lmm::trials::{Term, TrialFit, Trials, fit_trials};
use zwidth_stats::{Tested, Unestimable};
use zwidth_study::Contrast;
use zwidth_tables::{Column, NoteKind, Table};

/// The trials of one environment that have the metric, by the places of their names.
#[derive(Debug, Clone, PartialEq, Default)]
struct Rows {
    participant: Vec<usize>,
    session: Vec<usize>,
    mode: Vec<usize>,
    value: Vec<f64>,
}

/// One contrast by the model of its environment.
struct Row<'a> {
    environment: usize,
    contrast: &'a Contrast,
    trials: usize,
    /// The fit, if there is one.
    fit: Option<&'a TrialFit>,
    /// After Kenward and Roger.
    tested: Result<Tested, Unestimable>,
    /// After Satterthwaite.
    satterthwaite: Option<Tested>,
}

/// Every contrast by the mixed model of its environment; no row with one participant.
pub(crate) fn table(
    metrics: &Table,
    unit: &Unit,
    measure: &Measure,
    parameters: &Parameters,
) -> Result<Table, CompareError> {
    let environments = match unit {
        Unit::Participants => by_environment(metrics, measure, parameters)?,
        Unit::Trials { .. } => Vec::new(),
    };
    let fits: Vec<Result<TrialFit, Unestimable>> = environments.iter().map(fit).collect();
    let mut rows = Vec::new();
    for (environment, (trials, fit)) in environments.iter().zip(&fits).enumerate() {
        let contrasts = parameters.contrasts.iter();
        let there = contrasts.filter(|contrast| {
            [&contrast.mode, &contrast.against]
                .iter()
                .all(|mode| trials.mode.contains(&place(&parameters.modes, mode)))
        });
        rows.extend(there.map(|contrast| row(environment, contrast, trials, fit, parameters)));
    }
    as_table(&rows, measure, parameters)
}

/// The place of a name; one beyond the last for an unknown one.
fn place<T: PartialEq>(names: &[T], name: &T) -> usize {
    names.iter().position(|known| known == name).unwrap_or(names.len())
}

fn by_environment(
    metrics: &Table,
    measure: &Measure,
    parameters: &Parameters,
) -> Result<Vec<Rows>, CompareError> {
    let [participants, sessions, environments, modes] = KEYS.map(|key| metrics.texts(key));
    let (participants, sessions) = (participants?, sessions?);
    let (environments, modes) = (environments?, modes?);
    let values = metrics.floats(&measure.name)?;
    let sorted = |names: &[Option<String>]| -> Vec<Option<String>> {
        names.iter().cloned().collect::<BTreeSet<_>>().into_iter().collect()
    };
    let (people, times) = (sorted(&participants), sorted(&sessions));
    let mut found = vec![Rows::default(); parameters.environments.len()];
    for row in 0..metrics.height() {
        let is = |id: &str, of: &[Option<String>]| of[row].as_deref() == Some(id);
        let environment =
            parameters.environments.iter().position(|e| is(e.as_str(), &environments));
        let mode = parameters.modes.iter().position(|m| is(m.as_str(), &modes));
        let (Some(environment), Some(mode), Some(value)) = (environment, mode, values[row]) else {
            continue;
        };
        let rows = &mut found[environment];
        rows.participant.push(place(&people, &participants[row]));
        rows.session.push(place(&times, &sessions[row]));
        rows.mode.push(mode);
        rows.value.push(value);
    }
    Ok(found)
}

fn fit(rows: &Rows) -> Result<TrialFit, Unestimable> {
    fit_trials(Trials {
        participant: &rows.participant,
        session: &rows.session,
        mode: &rows.mode,
        value: &rows.value,
    })
}

fn row<'a>(
    environment: usize,
    contrast: &'a Contrast,
    trials: &Rows,
    fit: &'a Result<TrialFit, Unestimable>,
    parameters: &Parameters,
) -> Row<'a> {
    let modes = [&contrast.mode, &contrast.against].map(|mode| place(&parameters.modes, mode));
    let weights = |fit: &TrialFit| fit.difference(modes[0], modes[1]);
    let tested = fit
        .as_ref()
        .map_err(Clone::clone)
        .and_then(|fit| fit.fit.kenward_roger()?.test(&weights(fit)?, parameters.level));
    let satterthwaite = fit.as_ref().ok().and_then(|fit| {
        fit.fit.satterthwaite().ok()?.test(&weights(fit).ok()?, parameters.level).ok()
    });
    let (trials, fit) = (trials.value.len(), fit.as_ref().ok());
    Row { environment, contrast, trials, fit, tested, satterthwaite }
}

fn as_table(
    rows: &[Row],
    measure: &Measure,
    parameters: &Parameters,
) -> Result<Table, CompareError> {
    let texts = |name, description, of: &dyn Fn(&Row) -> Option<String>| {
        Column::text(name, description, rows.iter().map(of))
    };
    let tested = |of: fn(&Tested) -> f64| {
        rows.iter().map(move |row| row.tested.as_ref().ok().map(of)).collect::<Vec<_>>()
    };
    let second = |of: fn(&Tested) -> f64| {
        rows.iter().map(move |row| row.satterthwaite.as_ref().map(of)).collect::<Vec<_>>()
    };
    let deviation = |term: Term| {
        rows.iter()
            .map(move |row| row.fit.and_then(|fit| standard_deviation(fit, term)))
            .collect::<Vec<_>>()
    };
    let number = |name, description, values| Column::float(name, "1", description, values);
    let residual = rows.iter().map(|row| row.fit.map(|fit| fit.fit.residual_variance.sqrt()));
    let difference: Vec<Option<Tested>> = rows.iter().map(|row| row.tested.clone().ok()).collect();
    let mut all = vec![
        columns::environments(parameters, rows.iter().map(|row| row.environment)),
        columns::contrasts(rows.iter().map(|row| row.contrast)),
        Column::integer(
            "n",
            "1",
            "participants",
            rows.iter().map(|row| row.fit.and_then(|fit| whole(fit.fit.groups))),
        ),
        Column::integer("trials", "1", "trials", rows.iter().map(|row| whole(row.trials))),
    ];
    all.extend(columns::tested(measure, "difference", "mean difference", &difference));
    all.extend([
        number("df", "degrees of freedom (Kenward–Roger)", tested(|t| t.df)),
        number("p_value", "p value of no difference, not adjusted", tested(|t| t.p_value)),
        number("df_satterthwaite", "degrees of freedom (Satterthwaite)", second(|t| t.df)),
        number("p_satterthwaite", "p value with those", second(|t| t.p_value)),
        measure.column(
            "participant_sd",
            "standard deviation of participants",
            deviation(Term::Participant),
        ),
        measure.column(
            "participant_mode_sd",
            "standard deviation of participants' own effects of a mode",
            deviation(Term::ParticipantMode),
        ),
        measure.column("residual_sd", "standard deviation of repeats", residual),
        texts("random_terms", "what is random beside the residual", &|row| {
            let terms = row.fit?.structure.iter().map(|term| term.name());
            Some(terms.collect::<Vec<_>>().join(", "))
        }),
        Column::flag(
            "singular",
            "whether a variance was estimated as zero (pooled at the bound)",
            rows.iter().map(|row| row.fit.map(|fit| fit.fit.singular)),
        ),
        texts("remark", "why there is no test", &|row| {
            row.tested.as_ref().err().map(ToString::to_string)
        }),
    ]);
    let title = format!("Mixed model (for comparison): {}", measure.description);
    let table = Table::new(&format!("models_{}", measure.name), &title, all)?;
    let table = table.with_note(
        "REML over all trials, with the largest random structure that the design supports; \
         Kenward and Roger 1997. The claims rest on the table of contrasts.",
    );
    let singular = rows.iter().any(|row| row.fit.is_some_and(|fit| fit.fit.singular));
    Ok(if singular { table.with_note_of(NoteKind::Care, pooled(rows)) } else { table })
}

/// What a variance of zero does to the degrees of freedom, with those of the row where they are
/// furthest apart.
fn pooled(rows: &[Row]) -> String {
    let singular = rows.iter().filter(|row| row.fit.is_some_and(|fit| fit.fit.singular));
    let pairs = singular
        .filter_map(|row| Some([row.tested.as_ref().ok()?.df, row.satterthwaite.as_ref()?.df]));
    let furthest = pairs.max_by(|a, b| (a[1] / a[0]).total_cmp(&(b[1] / b[0])));
    let apart = furthest.map_or(String::new(), |[kenward_roger, satterthwaite]| {
        format!(" (here {kenward_roger:.1} and {satterthwaite:.1})")
    });
    format!(
        "Where singular, a variance was estimated as zero. Satterthwaite's degrees of freedom take \
         this zero as certain, so that they count repeats as if each were another participant's, \
         while Kenward and Roger's keep the variance as unknown{apart}: p_value and the interval \
         are Kenward and Roger's, and they count."
    )
}

/// The standard deviation of a term; `None` for one that the model does not have.
fn standard_deviation(fit: &TrialFit, term: Term) -> Option<f64> {
    let place = fit.structure.iter().position(|of| *of == term)?;
    let variance = *fit.fit.terms.get(place)?.covariance.first()?.first()?;
    Some(variance.max(0.0).sqrt())
}
