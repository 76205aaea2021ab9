//! Every candidate fitted, judged and compared.

use crate::characteristic::{Candidate, Characteristic, Grouping, Parameter, Quality, Settings};
use crate::crossval::{LeftOut, cross_validate, folds};
use crate::error::CharacteriseError;
use crate::models::{self, Model, Quantity, break_range};
use crate::noise::noise;
use crate::samples::{Samples, Sweep};
use crate::uncertainty::resampled;
use crate::verdict::{self, Verdict, significant};
use core::ops::Range;
use zwidth_stats::aicc::aicc;
use zwidth_stats::autocorrelation::lag1;
use zwidth_stats::bootstrap::percentile_interval;
use zwidth_stats::interval::sd;

/// Commands are gathered into this many bins at most for AICc.
const BINS: usize = 50;

/// Fits every candidate of [`models::ALL`] to the sweeps, judges each and chooses one (rule: see the crate).
///
/// # Errors
/// Columns of unequal length, a NaN or infinity (with sweep and row), fewer than six points or three different
/// commands, sweeps of which none can be left out, a confidence level outside (0, 1).
pub fn characterise(sweeps: &[Sweep], settings: &Settings) -> Result<Characteristic, CharacteriseError> {
    let samples = Samples::new(sweeps)?;
    let noise = noise(&samples);
    let grouping = if samples.sweeps.len() > 1 { Grouping::Sweep } else { Grouping::Block };
    let folds = folds(&samples);
    let fitted = models::ALL.iter().map(|model| candidate(*model, &samples, &folds, noise, settings));
    let mut candidates = fitted.collect::<Result<Vec<_>, _>>()?;
    let left_out = format!("{} {}s", folds.len(), grouping.name());
    let (chosen, reason) = verdict::judge(&mut candidates, &left_out, &settings.response_unit)
        .ok_or(CharacteriseError::NothingFits { grouping })?;
    Ok(Characteristic {
        sweeps: samples.sweeps.len(),
        points: samples.len(),
        command_min: samples.levels[0],
        command_max: samples.levels[samples.levels.len() - 1],
        noise,
        grouping,
        folds: folds.len(),
        candidates,
        chosen,
        reason,
    })
}

/// One candidate without its verdict, which needs the others.
fn candidate(
    model: &dyn Model,
    samples: &Samples,
    folds: &[Range<usize>],
    noise: Option<f64>,
    settings: &Settings,
) -> Result<Candidate, CharacteriseError> {
    let mut candidate = Candidate {
        name: model.name(),
        formula: model.formula(),
        complexity: model.parameters().len(),
        parameters: Vec::new(),
        quality: None,
        verdict: Verdict::NotFitted,
        verdict_text: String::new(),
        resampled: Vec::new(),
    };
    let fitted = model.fit(&samples.points(&samples.response, &vec![1.0; samples.len()]));
    let left_out = cross_validate(model, samples, folds);
    if let Some((fitted, left_out)) = fitted.zip(left_out) {
        candidate.quality = Some(quality(model, samples, &fitted, left_out, noise));
        candidate.resampled = resampled(model, samples, &fitted, settings);
        candidate.parameters = parameters(model, samples, &fitted, &candidate.resampled, settings)?;
    }
    Ok(candidate)
}

fn quality(
    model: &dyn Model,
    samples: &Samples,
    fitted: &[f64],
    left_out: LeftOut,
    noise: Option<f64>,
) -> Quality {
    let residuals: Vec<f64> =
        samples.command.iter().zip(&samples.response).map(|(&x, y)| y - model.predict(fitted, x)).collect();
    let n = samples.len() as f64;
    let mean = samples.response.iter().sum::<f64>() / n;
    let rss: f64 = residuals.iter().map(|r| r * r).sum();
    let total: f64 = samples.response.iter().map(|y| (y - mean) * (y - mean)).sum();
    let by_sweep: Vec<&[f64]> = samples.sweeps.iter().map(|s| &residuals[s.clone()]).collect();
    let rms = (rss / n).sqrt();
    Quality {
        df: samples.len() - fitted.len(),
        rms,
        r2: (total > 0.0).then(|| 1.0 - rss / total),
        cv_rms: left_out.rms,
        cv_std_error: left_out.std_error,
        aicc: binned_aicc(samples, &residuals, fitted.len()),
        autocorrelation: lag1(&by_sweep),
        rms_over_noise: noise.filter(|&noise| noise > 0.0).map(|noise| rms / noise),
    }
}

/// AICc of the residuals' means in equal bins of the command; empty bins do not count.
fn binned_aicc(samples: &Samples, residuals: &[f64], parameters: usize) -> Option<f64> {
    let bins = BINS.min(samples.levels.len());
    let (low, high) = (samples.levels[0], samples.levels[samples.levels.len() - 1]);
    let mut sums = vec![(0.0, 0.0); bins];
    for (x, r) in samples.command.iter().zip(residuals) {
        let bin = ((x - low) / (high - low) * bins as f64) as usize;
        let (n, sum) = &mut sums[bin.min(bins - 1)];
        (*n, *sum) = (*n + 1.0, *sum + r);
    }
    let means: Vec<f64> = sums.iter().filter(|(n, _)| *n > 0.0).map(|(n, sum)| sum / n).collect();
    aicc(means.len(), means.iter().map(|m| m * m).sum(), parameters)
}

fn parameters(
    model: &dyn Model,
    samples: &Samples,
    fitted: &[f64],
    resampled: &[Vec<f64>],
    settings: &Settings,
) -> Result<Vec<Parameter>, CharacteriseError> {
    let mut parameters = Vec::with_capacity(fitted.len());
    for (j, &(name, quantity)) in model.parameters().iter().enumerate() {
        let values: Vec<f64> = resampled.iter().map(|p| p[j]).collect();
        let interval = percentile_interval(&values, settings.level)?;
        let unit = quantity.unit(&settings.command_unit, &settings.response_unit);
        let note = match quantity {
            Quantity::Break => break_note(&samples.levels, fitted[j], interval, &unit),
            _ => None,
        };
        let (estimate, std_error) = (fitted[j], sd(&values));
        let (ci_low, ci_high) = interval.unzip();
        parameters.push(Parameter { name, quantity, unit, estimate, std_error, ci_low, ci_high, note });
    }
    Ok(parameters)
}

/// What to say of a break with one command or none to one side of it, or whose interval reaches there.
fn break_note(levels: &[f64], at: f64, interval: Option<(f64, f64)>, unit: &str) -> Option<String> {
    let (_, highest) = break_range(levels)?;
    let at_low_edge = |x: f64| x < levels[1];
    let at_high_edge = |x: f64| x >= highest;
    if at_low_edge(at) {
        return Some(format!("≤ {} {unit} (edge of the data): not identifiable", significant(levels[1])));
    }
    if at_high_edge(at) {
        return Some(format!("≥ {} {unit} (edge of the data): not identifiable", significant(highest)));
    }
    let (low, high) = interval?;
    (at_low_edge(low) || at_high_edge(high)).then(|| "its interval reaches the edge of the data".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::{Hinge, Line, PowerLaw};

    fn settings() -> Settings {
        let (command_unit, response_unit) = ("V".to_owned(), "N".to_owned());
        Settings { resamples: 100, seed: 5, level: 0.95, command_unit, response_unit }
    }

    /// Uniform noise in ±`half`, the same for one seed.
    fn scatter(n: usize, half: f64, seed: u64) -> Vec<f64> {
        let values: Vec<f64> = (-500..=500).map(|i| half * f64::from(i) / 500.0).collect();
        let drawn =
            zwidth_stats::bootstrap::resample(&values, n, 1, seed, |d| d.iter().map(|v| **v).collect());
        drawn.into_iter().next().unwrap()
    }

    /// `sweeps` ramps of 0 … 10 V through `model` with uniform noise of ± 0.2 N.
    fn simulate(model: &dyn Model, truth: &[f64], sweeps: u64) -> Characteristic {
        let command: Vec<f64> = (0..=200).map(|i| f64::from(i) * 0.05).collect();
        let run = |seed| {
            let noise = scatter(command.len(), 0.2, seed);
            command.iter().zip(noise).map(|(&x, e)| model.predict(truth, x) + e).collect::<Vec<f64>>()
        };
        let responses: Vec<Vec<f64>> = (1..=sweeps).map(run).collect();
        let sweeps: Vec<_> = responses.iter().map(|response| Sweep { command: &command, response }).collect();
        characterise(&sweeps, &settings()).unwrap()
    }

    /// The model that made the data is chosen, its intervals hold the truth and its errors are the noise.
    #[test]
    fn what_made_the_data_is_chosen_and_recovered() {
        let cases: [(&dyn Model, &[f64]); 3] =
            [(&Line, &[0.3, 0.8]), (&Hinge, &[0.3, 0.8, 3.02]), (&PowerLaw, &[0.3, 0.1, 1.2, 2.1])];
        for (model, truth) in cases {
            for sweeps in [1, 8] {
                let found = simulate(model, truth, sweeps);
                let chosen = &found.candidates[found.chosen];
                assert_eq!(chosen.name, model.name(), "{}", found.reason);
                for (p, truth) in chosen.parameters.iter().zip(truth) {
                    let (low, high) = (p.ci_low.unwrap(), p.ci_high.unwrap());
                    assert!(low <= *truth && *truth <= high, "{sweeps} sweeps: {p:?} for {truth}");
                }
                let q = chosen.quality.unwrap();
                assert!((q.rms / (0.2 / 3.0_f64.sqrt()) - 1.0).abs() < 0.15);
                assert!(
                    (q.rms_over_noise.unwrap() - 1.0).abs() < 0.15 && q.autocorrelation.unwrap().abs() < 0.2
                );
            }
        }
    }

    #[test]
    fn a_curve_that_is_too_simple_is_rejected_for_its_residuals_and_one_too_many_is_not_needed() {
        let found = simulate(&Hinge, &[0.0, 1.0, 4.0], 3);
        let verdicts: Vec<Verdict> = found.candidates.iter().map(|c| c.verdict).collect();
        assert_eq!(verdicts, [Verdict::Rejected, Verdict::Chosen, Verdict::NotNeeded]);
        let text = &found.candidates[0].verdict_text;
        assert!(
            text.starts_with("rejected: RMS ") && text.contains(" times the noise, residual auto"),
            "{text}"
        );
        assert_eq!((found.grouping, found.folds, found.sweeps, found.points), (Grouping::Sweep, 3, 3, 603));
    }

    /// Up and down branches 1 N apart: no curve of the command alone can follow both.
    #[test]
    fn hysteresis_shows_as_lack_of_fit() {
        let up: Vec<f64> = (0..100).map(f64::from).collect();
        let command: Vec<f64> = up.iter().chain(up.iter().rev()).copied().collect();
        let noise = scatter(200, 0.05, 9);
        let response: Vec<f64> =
            (0..200).map(|i| command[i] + if i < 100 { 0.0 } else { 1.0 } + noise[i]).collect();
        let found = characterise(&[Sweep { command: &command, response: &response }], &settings()).unwrap();
        assert!(found.candidates[found.chosen].verdict_text.contains("lack of fit"));
    }

    #[test]
    fn a_break_at_the_edge_is_not_identifiable() {
        let found = simulate(&Line, &[0.0, 1.0], 2);
        let notes: Vec<Option<&str>> =
            found.candidates[1].parameters.iter().map(|p| p.note.as_deref()).collect();
        assert_eq!(notes[..2], [None, None]);
        assert!(notes[2].unwrap().contains("edge of the data"), "{notes:?}");
    }

    #[test]
    fn seven_points_make_a_line_and_too_few_for_a_power_law() {
        let x = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let y = [0.02, 1.01, 1.97, 3.0, 4.02, 4.97, 6.01];
        let sweep = Sweep { command: &x, response: &y };
        let found = characterise(&[sweep], &settings()).unwrap();
        assert_eq!((found.chosen, found.folds), (0, 3));
        assert_eq!(found.candidates[2].verdict, Verdict::NotFitted);
        assert!(found.candidates[2].parameters.is_empty());
    }

    #[test]
    fn sweeps_that_cannot_be_left_out_are_an_error() {
        let (x, still) = ([0.0, 1.0, 2.0, 3.0], [1.0, 1.0, 1.0]);
        let sweeps = [Sweep { command: &x, response: &x }, Sweep { command: &still, response: &still }];
        let error = characterise(&sweeps, &settings()).unwrap_err();
        assert_eq!(error, CharacteriseError::NothingFits { grouping: Grouping::Sweep });
    }
}
