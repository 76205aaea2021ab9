//! Bland–Altman agreement of peaks and times, trial by trial.
//!
//! Bland & Altman (1986), Lancet 327:307; intervals of the limits: Bland & Altman (1999), Stat.
//! Methods Med. Res. 8:135.

use crate::ReplayError;
use crate::table::own_model;
use core::f64::consts::PI;
use zwidth_results::{
    AgreementOf, AgreementVerdict, Causality, ModelPlant, ReplayAgreement, ReplayedPeak,
};
use zwidth_stats::interval::{Estimate, mean, t_interval};
use zwidth_study::ModeId;
use zwidth_tables::Table;

/// Standard deviations between bias and limits: 95 % of normal differences lie between the limits.
const LIMIT_SDS: f64 = 1.96;

/// A number of a trial, if it has one.
type Number = fn(&ReplayedPeak) -> Option<f64>;

/// The bound below which a difference does not matter.
#[derive(Clone, Copy)]
enum Bound {
    /// One bound for every trial.
    Fixed(f64),
    /// A share of the mean of a recorded number.
    ShareOf(Number, f64),
}

/// The smallest change of a finger joint's angle that can be told: 2.5° (Tan, Srinivasan, Eberman &
/// Cheng 1994, ASME DSC 55-1:353), taken for the lever's angle.
const ANGLE: Bound = Bound::Fixed(2.5 * PI / 180.0);
/// The smallest change of a force that a finger can tell, between 2.5 and 10 N: 7 % (Pang, Tan &
/// Durlach 1991, Percept. Psychophys. 49:531).
const FORCE: Bound = Bound::ShareOf(|row| row.peak_recorded_n, 0.07);
/// A tenth of a second: assumed.
const TIME: Bound = Bound::Fixed(0.1);

/// The quantities that are compared: the unit, the difference of each trial, and the bound.
const QUANTITIES: [(AgreementOf, &str, Number, Bound); 4] = [
    (AgreementOf::PeakAngle, "rad", |row| row.peak_error_rad, ANGLE),
    (AgreementOf::PeakForce, "N", |row| row.peak_error_n, FORCE),
    (AgreementOf::PeakTime, "s", |row| row.peak_time_error_s, TIME),
    (AgreementOf::ReversalTime, "s", |row| row.reversal_error_s, TIME),
];

const NOTES: [&str; 2] = [
    "Trials are taken for independent; repeats of one person are not, so intervals are too narrow for people in general.",
    "Verdict: alike, both limits within the bound; off, the bias beyond it; scattered, the bias within it and a limit \
     beyond. Bounds: 2.5 degrees, the just noticeable difference of a finger joint's angle (Tan 1994), 7 % of the mean \
     recorded peak force (Pang 1991), 0.1 s (assumed).",
];

/// The note on closed loop.
const OPEN: &str = "Closed loop: given force and voltages, nothing in the model brings an error of the angle back, so \
    that what is wrong with its plant adds up along a trial.";

/// The verdict on bias, lower and upper limit.
fn verdict([bias, low, high]: [Option<Estimate>; 3], bound: Option<f64>) -> AgreementVerdict {
    let (Some(bias), Some(low), Some(high), Some(bound)) = (bias, low, high, bound) else {
        return AgreementVerdict::TooFew;
    };
    let [bias, low, high] = [bias, low, high].map(|value| value.estimate.abs() <= bound);
    match (bias, low && high) {
        (true, true) => AgreementVerdict::Alike,
        (false, _) => AgreementVerdict::Off,
        (true, false) => AgreementVerdict::Scattered,
    }
}

/// For each causality, mode, model and quantity: n trials, the bias (mean of model less recording),
/// the limits of agreement (bias ± 1.96 SD) with their t intervals at `level`, and a verdict; null
/// below two trials. Trials of one person are taken for independent, so with few people the
/// intervals are too narrow. Numbers are in the unit of their row.
///
/// # Errors
/// A level outside (0, 1).
pub fn agreement(
    replays: &[ReplayedPeak],
    level: f64,
) -> Result<Vec<ReplayAgreement>, ReplayError> {
    let mut agreements = Vec::new();
    for group in groups(replays) {
        let values = |number: Number| -> Vec<f64> {
            replays.iter().filter(|row| group.has(row)).filter_map(number).collect()
        };
        for (quantity, unit, difference, bound) in QUANTITIES {
            let differences = values(difference);
            if differences.is_empty() {
                continue;
            }
            let all = limits(&differences, level)?;
            let bound = match bound {
                Bound::Fixed(bound) => Some(bound),
                Bound::ShareOf(number, share) => {
                    mean(&values(number), level)?.estimate.map(|mean| share * mean.abs())
                }
            };
            let [bias, low, high] = all;
            agreements.push(ReplayAgreement {
                causality: group.causality,
                mode: group.mode.clone(),
                model: group.model,
                quantity,
                unit: unit.into(),
                n: differences.len(),
                verdict: verdict(all, bound),
                bound,
                bias: bias.map(|e| e.estimate),
                bias_ci_low: bias.map(|e| e.ci_low),
                bias_ci_high: bias.map(|e| e.ci_high),
                limit_low: low.map(|e| e.estimate),
                limit_low_ci_low: low.map(|e| e.ci_low),
                limit_low_ci_high: low.map(|e| e.ci_high),
                limit_high: high.map(|e| e.estimate),
                limit_high_ci_low: high.map(|e| e.ci_low),
                limit_high_ci_high: high.map(|e| e.ci_high),
            });
        }
    }
    Ok(agreements)
}

/// The agreement as a table, with notes on it and on its replays.
///
/// # Errors
/// A number that is none.
pub fn agreement_table(
    rows: &[ReplayAgreement],
    replays: &[ReplayedPeak],
) -> Result<Table, ReplayError> {
    let is_open = rows.iter().any(|row| row.causality == Causality::ClosedLoop);
    let notes = NOTES.into_iter().chain(is_open.then_some(OPEN));
    let notes = notes.chain(own_model(replays.iter().map(|row| row.source)));
    Ok(notes.fold(Table::of_rows(rows)?, Table::with_note))
}

/// Bias, lower and upper limit. The variance of a limit is s² / n + z² s² / (2 (n − 1)).
fn limits(differences: &[f64], level: f64) -> Result<[Option<Estimate>; 3], ReplayError> {
    let mean = mean(differences, level)?;
    let Some((sd, bias)) = mean.sd.zip(mean.interval) else { return Ok([None; 3]) };
    let (n, df) = (mean.n as f64, mean.n as f64 - 1.0);
    let std_error = sd * (1.0 / n + LIMIT_SDS * LIMIT_SDS / (2.0 * df)).sqrt();
    let [low, high] = [-LIMIT_SDS, LIMIT_SDS]
        .map(|sds| t_interval(bias.estimate + sds * sd, std_error, df, level));
    Ok([Some(bias), Some(low?), Some(high?)])
}

/// The key by which rows belong to one agreement.
#[derive(PartialEq)]
struct Group<'a> {
    causality: Causality,
    mode: &'a ModeId,
    model: ModelPlant,
}

impl Group<'_> {
    fn has(&self, row: &ReplayedPeak) -> bool {
        row.causality == self.causality && row.mode == *self.mode && row.model == self.model
    }
}

/// The groups of the rows: by causality, by mode in the order of the rows, by the model's word.
fn groups(replays: &[ReplayedPeak]) -> Vec<Group<'_>> {
    let (mut groups, mut modes): (Vec<Group>, Vec<&ModeId>) = (Vec::new(), Vec::new());
    for row in replays {
        if !groups.iter().any(|group| group.has(row)) {
            let ReplayedPeak { causality, mode, model, .. } = row;
            groups.push(Group { causality: *causality, mode, model: *model });
        }
        if !modes.contains(&&row.mode) {
            modes.push(&row.mode);
        }
    }
    groups.sort_by_key(|group| {
        let mode = modes.iter().position(|mode| *mode == group.mode);
        (group.causality, mode, group.model.as_str())
    });
    groups
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_study::Source;

    /// Plain Python with d = [0.1, 0.3, -0.2, 0.4, 0.15], m and s its mean and sample SD, t =
    /// 2.7764451051977987 (the tables' t for 4 degrees of freedom): m, m - t s / sqrt(5), m -
    /// 1.96 s, that ± t s sqrt(1/5 + 1.96² / 8), m + 1.96 s.
    #[test]
    fn bias_and_limits_are_those_of_the_formulas() {
        let [bias, low, high] =
            limits(&[0.1, 0.3, -0.2, 0.4, 0.15], 0.95).unwrap().map(Option::unwrap);
        let found =
            [bias.estimate, bias.ci_low, low.estimate, low.ci_low, low.ci_high, high.estimate];
        for (found, python) in found.iter().zip(PYTHON) {
            assert!((found - python).abs() < 1e-12, "{found} instead of {python}");
        }
    }

    const PYTHON: [f64; 6] = [
        0.15,
        -0.1345009634655928,
        -0.29909241810567233,
        -0.8237634147520515,
        0.22557857854070684,
        0.5990924181056723,
    ];

    #[test]
    fn one_trial_has_no_limits() {
        assert_eq!(limits(&[0.1], 0.95).unwrap(), [None; 3]);
    }

    /// Of the mode `active`, with these differences of the peak angle.
    fn peaks(
        causality: Causality,
        model: ModelPlant,
        source: Source,
        peak_error_rad: &[Option<f64>],
    ) -> Vec<ReplayedPeak> {
        let peak = |error: &Option<f64>| ReplayedPeak {
            mode: "active".parse().unwrap(),
            source,
            causality,
            model,
            peak_error_rad: *error,
            peak_recorded_n: None,
            peak_error_n: None,
            peak_time_error_s: None,
            reversal_error_s: None,
        };
        peak_error_rad.iter().map(peak).collect()
    }

    #[test]
    fn rows_are_by_causality_and_mode_and_null_differences_do_not_count() {
        let of = |causality, errors: &[Option<f64>]| {
            peaks(causality, ModelPlant::ByEye, Source::Recorded, errors)
        };
        let closed = of(Causality::ClosedLoop, &[Some(1.0)]);
        let driven = of(Causality::ForceDriven, &[Some(2.0), Some(4.0), None]);
        let whole = |row: ReplayedPeak| ReplayedPeak {
            peak_recorded_n: Some(40.0),
            peak_error_n: row.peak_error_rad,
            peak_time_error_s: row.peak_error_rad,
            reversal_error_s: row.peak_error_rad,
            ..row
        };
        let replays: Vec<ReplayedPeak> = closed.into_iter().chain(driven).map(whole).collect();
        let rows = agreement(&replays, 0.95).unwrap();
        assert_eq!(rows.len(), 8);
        assert_eq!((rows[0].causality, rows[0].n), (Causality::ForceDriven, 2));
        assert_eq!((rows[0].bias, rows[4].bias), (Some(3.0), None));
        let table = agreement_table(&rows, &replays).unwrap();
        assert_eq!(table.to_rows::<ReplayAgreement>().unwrap(), rows);
    }

    /// Differences of peak angles in degrees, and what is said of them.
    #[test]
    fn a_bias_or_a_scatter_beyond_what_can_be_told_is_said() {
        let verdict = |degrees: [f64; 4], source| {
            let errors = degrees.map(|d: f64| Some(d.to_radians()));
            let replays = peaks(Causality::ClosedLoop, ModelPlant::Fitted, source, &errors);
            let rows = agreement(&replays, 0.95).unwrap();
            (rows[0].verdict, agreement_table(&rows, &replays).unwrap().notes().join(" "))
        };
        let recorded = Source::Recorded;
        assert_eq!(verdict([0.1, -0.1, 0.2, 0.0], recorded).0, AgreementVerdict::Alike);
        assert_eq!(verdict([-59.0, -58.0, -60.0, -59.0], recorded).0, AgreementVerdict::Off);
        assert_eq!(verdict([4.0, -4.0, 3.0, -3.0], recorded).0, AgreementVerdict::Scattered);
        assert!(verdict([0.0; 4], recorded).1.contains("adds up along a trial"));
        assert!(!verdict([0.0; 4], recorded).1.contains("Simulated"));
        assert!(verdict([0.0; 4], Source::Twin).1.contains("Simulated trials"));
    }
}
