//! Fits, judges and compares every candidate.

use crate::characteristic::{Candidate, Characteristic, Quality, Settings};
use crate::crossval::{cross_validate, folds};
use crate::error::CharacteriseError;
use crate::models::{self, Model, way};
use crate::noise::noise;
use crate::samples::{Samples, Sweep};
use crate::shape::{Quantity, break_range};
use crate::uncertainty::resampled;
use crate::verdict::{self, significant};
use core::ops::Range;
use rayon::prelude::*;
use zwidth_numerics::moments::Moments;
use zwidth_results::{CandidateVerdict, FittedParameter};
use zwidth_stats::aicc::aicc;
use zwidth_stats::autocorrelation::lag1;

/// Commands are gathered into this many bins at most for AICc.
const BINS: usize = 50;

/// Fits every candidate of [`models::all`] to the sweeps, judges each and chooses one (rule: see
/// the crate). Candidates with hysteresis are there only if the command went both up and down.
///
/// # Errors
/// Columns of unequal length, a NaN or infinity (with sweep and row), fewer than six points or
/// three different commands, sweeps of which none can be left out, a confidence level outside (0,
/// 1).
pub fn characterise(
    sweeps: &[Sweep],
    settings: &Settings,
) -> Result<Characteristic, CharacteriseError> {
    let samples = Samples::new(sweeps)?;
    let noise = noise(&samples);
    let grouping = if samples.sweeps.len() > 1 { "sweep" } else { "block" };
    let folds = folds(&samples);
    // If the command goes one way only, the other way's curve cannot be fitted.
    let both = samples.has_both_branches();
    let models: Vec<Model> = models::all().filter(|model| both || !model.hysteresis).collect();
    let fitted = models.par_iter().map(|model| candidate(model, &samples, &folds, noise, settings));
    let mut candidates = fitted.collect::<Result<Vec<_>, _>>()?;
    let left_out = format!("{} {grouping}s", folds.len());
    let (chosen, reason) = verdict::judge(&mut candidates, &left_out, &settings.response_unit)
        .ok_or_else(|| {
            CharacteriseError::Refused(format!(
                "no line can be fitted with one {grouping} left out: the others need two different commands between them"
            ))
        })?;
    let (command_min, command_max) = samples.command_range();
    Ok(Characteristic {
        sweeps: samples.sweeps.len(),
        points: samples.len(),
        command_min,
        command_max,
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
    model: &Model,
    samples: &Samples,
    folds: &[Range<usize>],
    noise: Option<f64>,
    settings: &Settings,
) -> Result<Candidate, CharacteriseError> {
    let mut candidate = Candidate {
        name: model.name,
        formula: model.formula(),
        complexity: model.complexity(),
        parameters: Vec::new(),
        quality: None,
        verdict: CandidateVerdict::NotFitted,
        reason: String::new(),
        left_out: Vec::new(),
        independent: (samples.sweeps.len() > 1).then_some(samples.sweeps.len()),
        resampled: Vec::new(),
    };
    let fitted = model.fit(&samples.gathered(), None);
    let left_out = cross_validate(model, samples, folds);
    let Some((fitted, left_out)) = fitted.zip(left_out) else { return Ok(candidate) };
    let residuals: Vec<f64> = (0..samples.len())
        .map(|i| {
            samples.response[i] - model.predict(&fitted, samples.command[i], samples.branch[i])
        })
        .collect();
    let n = samples.len() as f64;
    let mean = samples.response.iter().sum::<f64>() / n;
    let rss: f64 = residuals.iter().map(|r| r * r).sum();
    let total: f64 = samples.response.iter().map(|y| (y - mean) * (y - mean)).sum();
    // Neighbours across two sweeps were not recorded one after the other.
    let by_sweep: Vec<&[f64]> = samples.sweeps.iter().map(|s| &residuals[s.clone()]).collect();
    let rms = (rss / n).sqrt();
    candidate.quality = Some(Quality {
        df: samples.len() - model.complexity(),
        rms,
        r2: (total > 0.0).then(|| 1.0 - rss / total),
        cv_rms: left_out.rms,
        cv_std_error: left_out.std_error,
        aicc: binned_aicc(samples, &residuals, model.complexity()),
        autocorrelation: lag1(&by_sweep),
        rms_over_noise: noise.filter(|&noise| noise > 0.0).map(|noise| rms / noise),
    });
    candidate.left_out = left_out.squares;
    candidate.resampled = resampled(model, samples, &fitted, settings);
    candidate.parameters = parameters(model, samples, &fitted, &candidate, settings)?;
    Ok(candidate)
}

/// AICc of the residuals' means in equal bins of the command; empty bins do not count.
fn binned_aicc(samples: &Samples, residuals: &[f64], parameters: usize) -> Option<f64> {
    let bins = BINS.min(samples.steps.levels.len());
    let (low, high) = samples.command_range();
    let mut sums = vec![(0.0, 0.0); bins];
    for (x, r) in samples.command.iter().zip(residuals) {
        let bin = ((x - low) / (high - low) * bins as f64) as usize;
        // The highest command belongs to the last bin.
        let (n, sum) = &mut sums[bin.min(bins - 1)];
        (*n, *sum) = (*n + 1.0, *sum + r);
    }
    let means: Vec<f64> = sums.iter().filter(|(n, _)| *n > 0.0).map(|(n, sum)| sum / n).collect();
    aicc(means.len(), means.iter().map(|m| m * m).sum(), parameters)
}

/// The parameters of a fit, with their intervals from the candidate's resamples.
fn parameters(
    model: &Model,
    samples: &Samples,
    fitted: &[f64],
    candidate: &Candidate,
    settings: &Settings,
) -> Result<Vec<FittedParameter>, CharacteriseError> {
    let mut parameters = Vec::with_capacity(fitted.len());
    for (j, (branch, name, quantity)) in model.parameters().into_iter().enumerate() {
        let is_set = quantity == Quantity::Knot;
        let values: Vec<f64> =
            candidate.resampled.iter().map(|p| p[j]).filter(|_| !is_set).collect();
        let interval = candidate
            .interval(&values, settings.level)?
            // A parameter at the edge of the data may have all resamples to one side.
            .map(|(low, high)| (low.min(fitted[j]), high.max(fitted[j])));
        let unit = quantity.unit(&settings.command_unit, &settings.response_unit);
        let note = note(quantity, &samples.steps.levels, fitted[j], interval, &unit);
        let (ci_low, ci_high) = interval.unzip();
        parameters.push(FittedParameter {
            model: model.name,
            parameter: name,
            branch: way(branch),
            estimate: fitted[j],
            std_error: Moments::of(&values).sd(),
            ci_low,
            ci_high,
            unit: unit.into(),
            note: note.map(Into::into),
        });
    }
    Ok(parameters)
}

/// The caution about a parameter that the data set or bound, if one is due.
fn note(
    quantity: Quantity,
    levels: &[f64],
    at: f64,
    interval: Option<(f64, f64)>,
    unit: &str,
) -> Option<String> {
    // The first and the last place where the data could show a break or plateau: beyond, one
    // command or none lies to one side of it.
    let (low, high) = match quantity {
        Quantity::Break => (levels[1], break_range(levels)?.1),
        Quantity::Plateau => (levels[2], levels[levels.len() - 2]),
        Quantity::Knot => return Some("set by the range of the data".to_owned()),
        _ => return None,
    };
    let (sign, edge) = match at {
        _ if at < low => ("≤", low),
        _ if at >= high => ("≥", high),
        _ => {
            let is_at_edge = interval.is_some_and(|(from, to)| from < low || to >= high);
            return is_at_edge.then(|| "its interval reaches the edge of the data".to_owned());
        }
    };
    Some(format!("{sign} {} {unit} (edge of the data): not identifiable", significant(edge)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_numerics::branch::branches;
    use zwidth_results::{CurveModel, CurveSymbol};

    /// At 95 % one of the many intervals below would miss its truth.
    fn settings() -> Settings {
        Settings { level: 0.99, ..crate::characteristic::tests::settings(300, 5) }
    }

    /// Uniform noise in ±`half`, the same for one seed.
    fn scatter(n: usize, half: f64, seed: u64) -> Vec<f64> {
        let values: Vec<f64> = (-500..=500).map(|i| half * f64::from(i) / 500.0).collect();
        let drawn = zwidth_stats::bootstrap::resample(&values, n, 1, seed, |d| {
            d.iter().map(|v| **v).collect()
        });
        drawn.into_iter().next().unwrap()
    }

    fn candidate<'a>(found: &'a Characteristic, name: &str) -> &'a Candidate {
        found.candidates.iter().find(|c| c.name.as_str() == name).unwrap()
    }

    /// 0 … `top` and back, in steps of 0.05.
    fn up_and_down(top: f64) -> Vec<f64> {
        let n = (top / 0.05) as i32;
        (0..=n).chain((0..n).rev()).map(|i| 0.05 * f64::from(i)).collect()
    }

    /// `sweeps` of these commands through the model of that name with uniform noise of ± 0.2.
    fn simulate(name: &str, truth: &[f64], sweeps: u64, command: &[f64]) -> Characteristic {
        let (model, branch) = (Model::of(CurveModel::from_word(name).unwrap()), branches(command));
        let run = |seed| {
            let noise = scatter(command.len(), 0.2, seed);
            let at = |i: usize| model.predict(truth, command[i], branch[i]) + noise[i];
            (0..command.len()).map(at).collect::<Vec<f64>>()
        };
        let responses: Vec<Vec<f64>> = (1..=sweeps).map(run).collect();
        let sweeps: Vec<_> = responses.iter().map(|response| Sweep { command, response }).collect();
        characterise(&sweeps, &settings()).unwrap()
    }

    /// The model that made the data is chosen, its intervals hold the truth and its errors are the
    /// noise.
    fn check_recovered(name: &str, truth: &[f64], sweeps: u64, command: &[f64]) {
        let found = simulate(name, truth, sweeps, command);
        let chosen = &found.candidates[found.chosen];
        assert_eq!(chosen.name.as_str(), name, "{}", found.reason);
        for (p, truth) in chosen.parameters.iter().zip(truth) {
            let (low, high) = (p.ci_low.unwrap(), p.ci_high.unwrap());
            assert!(low <= *truth && *truth <= high, "{sweeps} sweeps: {p:?} for {truth}");
        }
        let q = chosen.quality.unwrap();
        assert!((q.rms / (0.2 / 3.0_f64.sqrt()) - 1.0).abs() < 0.15);
        assert!(
            (q.rms_over_noise.unwrap() - 1.0).abs() < 0.15
                && q.autocorrelation.unwrap().abs() < 0.2
        );
    }

    #[test]
    fn what_made_the_data_is_chosen_and_recovered() {
        let ramp: Vec<f64> = (0..=200).map(|i| f64::from(i) * 0.05).collect();
        for sweeps in [1, 8] {
            check_recovered("line", &[0.3, 0.8], sweeps, &ramp);
            check_recovered("hinge", &[0.3, 0.8, 3.02], sweeps, &ramp);
            check_recovered("saturation", &[0.3, 0.8, 2.02, 7.54], sweeps, &ramp);
            check_recovered("power_law", &[0.3, 0.1, 1.2, 2.1], sweeps, &ramp);
        }
    }

    /// The thesis' device: 15 sweeps of the motor, 0.26 N/V, 30 of the brake, 13 N at 8 V from 1 V
    /// on.
    #[test]
    fn the_prototypes_motor_and_brake_are_recovered() {
        check_recovered("line", &[0.02, 0.26], 15, &up_and_down(16.0));
        check_recovered("hinge", &[0.05, 13.0 / 7.0, 1.0], 30, &up_and_down(8.0));
    }

    /// A brake that takes hold at 1 V and lets go at 0.6 V; a motor with friction.
    #[test]
    fn hysteresis_is_recovered_branch_by_branch() {
        let truth = [0.05, 13.0 / 7.0, 1.02, 0.05, 13.0 / 7.4, 0.61];
        check_recovered("hinge_up_down", &truth, 12, &up_and_down(8.0));
        check_recovered("line_up_down", &[-0.1, 0.26, 0.1, 0.26], 12, &up_and_down(16.0));
    }

    #[test]
    fn a_curve_that_is_too_simple_is_rejected_for_its_residuals_and_one_too_many_is_not_needed() {
        let found = simulate("hinge", &[0.0, 1.0, 4.0], 3, &up_and_down(10.0));
        let verdict = |name| candidate(&found, name).verdict;
        assert_eq!(
            ["line", "hinge", "power_law", "hinge_up_down"].map(verdict),
            [
                CandidateVerdict::Rejected,
                CandidateVerdict::Chosen,
                CandidateVerdict::NotNeeded,
                CandidateVerdict::NotNeeded
            ]
        );
        let text = &candidate(&found, "line").reason;
        assert!(
            text.starts_with("RMS ") && text.contains(" times the noise, residual auto"),
            "{text}"
        );
        assert_eq!(
            (found.grouping, found.folds, found.sweeps, found.points),
            ("sweep", 3, 3, 1203)
        );
    }

    /// A law that none of the others knows: the spline is chosen, and says nothing of a break.
    #[test]
    fn an_unknown_monotone_law_is_left_to_the_spline() {
        let command = up_and_down(10.0);
        let law =
            |x: f64| 8.0 * libm::tanh(0.4 * x) + 3.0 * libm::exp(-0.5 * (9.0 - x) * (9.0 - x));
        let noise = scatter(command.len(), 0.2, 3);
        let law = |x: f64| if x < 9.0 { law(x) } else { law(9.0) + 2.0 * (x - 9.0) };
        let response: Vec<f64> = command.iter().zip(&noise).map(|(x, e)| law(*x) + e).collect();
        let found =
            characterise(&[Sweep { command: &command, response: &response }], &settings()).unwrap();
        assert_eq!(found.candidates[found.chosen].name, CurveModel::Spline, "{}", found.reason);
    }

    #[test]
    fn one_way_sweeps_have_no_candidates_with_hysteresis() {
        let ramp: Vec<f64> = (0..=200).map(|i| f64::from(i) * 0.05).collect();
        let found = simulate("hinge", &[0.0, 1.0, 4.0], 3, &ramp);
        assert!(found.candidates.iter().all(|c| !c.name.has_hysteresis()));
    }

    /// A brake that does not slip below 2 V: those samples were not recorded.
    #[test]
    fn what_was_left_out_of_the_recording_leaves_the_rest_as_it_is() {
        let slips: Vec<f64> = up_and_down(8.0).into_iter().filter(|x| *x > 2.0).collect();
        check_recovered("line_up_down", &[-1.9, 1.9, -1.2, 1.8], 8, &slips);
    }

    #[test]
    fn one_thread_gives_the_bits_of_many() {
        let run = || simulate("saturation", &[0.0, 1.0, 2.0, 7.0], 3, &up_and_down(10.0));
        let on = |threads| {
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run)
        };
        assert_eq!(on(1), on(4));
    }

    #[test]
    fn a_break_at_the_edge_is_not_identifiable() {
        let found = simulate("line", &[0.0, 1.0], 2, &up_and_down(10.0));
        let parameters = |name| candidate(&found, name).parameters.iter();
        let notes: Vec<_> = parameters("hinge").map(|p| &p.note).collect();
        assert!(notes[..2].iter().all(|note| note.is_none()), "{notes:?}");
        let plateau = parameters("saturation").find(|p| p.parameter == CurveSymbol::X1).unwrap();
        for note in [notes[2], &plateau.note] {
            assert!(note.as_ref().unwrap().to_string().contains("edge of the data"), "{note:?}");
        }
    }

    #[test]
    fn seven_points_make_a_line_and_too_few_for_a_power_law() {
        let x = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let y = [0.02, 1.01, 1.97, 3.0, 4.02, 4.97, 6.01];
        let sweep = Sweep { command: &x, response: &y };
        let found = characterise(&[sweep], &settings()).unwrap();
        assert_eq!((found.chosen, found.folds), (0, 3));
        assert_eq!(found.candidates[3].verdict, CandidateVerdict::NotFitted);
        assert!(found.candidates[3].parameters.is_empty());
    }

    #[test]
    fn sweeps_that_cannot_be_left_out_are_an_error() {
        let (x, still) = ([0.0, 1.0, 2.0, 3.0], [1.0, 1.0, 1.0]);
        let sweeps =
            [Sweep { command: &x, response: &x }, Sweep { command: &still, response: &still }];
        let error = characterise(&sweeps, &settings()).unwrap_err();
        assert_eq!(
            error.to_string(),
            "no line can be fitted with one sweep left out: the others need two different commands between them"
        );
    }
}
