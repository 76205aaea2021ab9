//! The chosen candidate, and the verdict on each.

use crate::characteristic::{Candidate, Quality};
use crate::crossval::mean_and_error;
use crate::models::Model;
use zwidth_results::CandidateVerdict;

/// Residuals that exceed the noise by more than this show that the curve is wrong.
const LACK_OF_FIT: f64 = 1.5;

/// A candidate whose error exceeds the smallest by more standard errors of the difference than this
/// is worse: one in forty is by chance.
const STD_ERRORS: f64 = 2.0;

/// Two errors closer than this share of themselves are the same but for rounding.
const SAME: f64 = 1e-9;

/// Chooses a candidate, writes every verdict, and gives the chosen one's index with the reason in a
/// sentence. `left_out` says what cross-validation left out (`10 blocks`), `unit` is that of the
/// response. `None` if no candidate could be fitted.
pub(crate) fn judge(
    candidates: &mut [Candidate],
    left_out: &str,
    unit: &str,
) -> Option<(usize, String)> {
    let (best, chosen) = choose(candidates)?;
    let reason = reason(candidates, best, chosen, left_out, unit);
    let winner = candidates[chosen].clone(); // the others are judged against it while all change
    for (index, candidate) in candidates.iter_mut().enumerate() {
        candidate.verdict = verdict(candidate, &winner, index == chosen);
        candidate.reason = words(candidate, &winner, unit);
    }
    Some((chosen, reason))
}

/// The indices of the candidate with the smallest cross-validated RMS (the simplest of equals), and
/// of the simplest that is as good within the standard errors. A curve that is not a law takes part
/// only if every law lacks fit.
fn choose(candidates: &[Candidate]) -> Option<(usize, usize)> {
    let laws_fail =
        candidates.iter().filter(|c| is_law(c)).filter_map(|c| c.quality).all(|q| lacks_fit(&q));
    let fitted: Vec<usize> = (0..candidates.len())
        .filter(|&i| candidates[i].quality.is_some() && (laws_fail || is_law(&candidates[i])))
        .collect();
    let error = |i: usize| candidates[i].quality.map_or(f64::INFINITY, |q| q.cv_rms);
    let smallest = fitted.iter().map(|&i| error(i)).min_by(f64::total_cmp)?;
    // Candidates come by complexity: the first within rounding is the simplest of equals.
    let best = *fitted.iter().find(|&&i| error(i) <= smallest * (1.0 + SAME))?;
    let good = fitted.into_iter().filter(|&i| is_as_good(&candidates[i], &candidates[best]));
    let chosen = good.min_by(|&i, &j| {
        candidates[i].complexity.cmp(&candidates[j].complexity).then(error(i).total_cmp(&error(j)))
    })?;
    Some((best, chosen))
}

/// Whether the error on what was left out is within one standard error of that of `best`, and the
/// mean square within two standard errors of the difference. The difference is taken part by part:
/// what makes a part hard for every candidate (a sweep of another gain, say) then does not count,
/// and a small misfit in every sweep does.
fn is_as_good(candidate: &Candidate, best: &Candidate) -> bool {
    let Some((q, smallest)) = candidate.quality.zip(best.quality) else { return false };
    let differences: Vec<f64> = candidate
        .left_out
        .iter()
        .zip(&best.left_out)
        .map(|(square, of_best)| square - of_best)
        .collect();
    let (excess, std_error) = mean_and_error(&differences);
    let rounding = SAME * smallest.cv_rms * smallest.cv_rms;
    q.cv_rms <= smallest.cv_rms * (1.0 + SAME) + smallest.cv_std_error
        && excess <= STD_ERRORS * std_error + rounding
}

fn is_law(candidate: &Candidate) -> bool {
    Model::of(candidate.name).shape.is_law()
}

/// The reason of the choice, in a sentence.
fn reason(
    candidates: &[Candidate],
    best: usize,
    chosen: usize,
    left_out: &str,
    unit: &str,
) -> String {
    let winner = &candidates[chosen];
    let best = &candidates[best];
    let error = best.quality.map(|q| left_out_error(&q, unit)).unwrap_or_default();
    let smallest = format!("the smallest cross-validated RMS ({error}, {left_out})");
    let simplest = candidates.iter().all(|c| c.complexity >= winner.complexity);
    let name = winner.name.as_str();
    match (winner.name == best.name, simplest) {
        (true, true) => format!("{name} is the simplest candidate and has {smallest}."),
        (true, false) => format!(
            "{name} has {smallest}; no simpler candidate is as good within the standard errors."
        ),
        (false, _) => format!(
            "{name} is the simplest candidate as good, within the standard errors, as that with {smallest}, {}.",
            best.name.as_str()
        ),
    }
}

fn verdict(candidate: &Candidate, winner: &Candidate, chosen: bool) -> CandidateVerdict {
    match candidate.quality {
        None => CandidateVerdict::NotFitted,
        Some(_) if chosen => CandidateVerdict::Chosen,
        Some(q) if candidate.complexity > winner.complexity && !fits_worse(&q, winner.quality) => {
            CandidateVerdict::NotNeeded
        }
        Some(_) => CandidateVerdict::Rejected,
    }
}

/// The reason of a candidate's verdict.
fn words(candidate: &Candidate, winner: &Candidate, unit: &str) -> String {
    let Some((q, best)) = candidate.quality.zip(winner.quality) else {
        return format!(
            "too few points, less those left out, for {} parameters",
            candidate.complexity
        );
    };
    let against = format!("{} against {}", left_out_error(&q, unit), left_out_error(&best, unit));
    let name = winner.name.as_str();
    match candidate.verdict {
        CandidateVerdict::Chosen if lacks_fit(&q) => format!(
            "{}; lack of fit: the best of these curves, yet not the whole story",
            residuals(&q, unit)
        ),
        CandidateVerdict::Chosen => residuals(&q, unit),
        CandidateVerdict::NotNeeded if !is_law(candidate) && is_law(winner) => {
            let fit = if lacks_fit(&best) { "fits as well" } else { "leaves the noise alone" };
            format!("{name} is a law and {fit} (RMS on data left out {against})")
        }
        CandidateVerdict::Rejected if fits_worse(&q, Some(best)) => residuals(&q, unit),
        _ => format!("RMS on data left out {against} for {name}"),
    }
}

/// `RMS 3.09 mN·m is 8.6 times the noise, residual autocorrelation 0.98`.
fn residuals(q: &Quality, unit: &str) -> String {
    let ratio = q.rms_over_noise.map(|r| format!(" is {r:.1} times the noise")).unwrap_or_default();
    let alike =
        q.autocorrelation.map(|r| format!(", residual autocorrelation {r:.2}")).unwrap_or_default();
    format!("RMS {} {unit}{ratio}{alike}", significant(q.rms))
}

/// `0.471 ± 0.096 mN·m`.
fn left_out_error(q: &Quality, unit: &str) -> String {
    format!("{} ± {} {unit}", significant(q.cv_rms), significant(q.cv_std_error))
}

fn lacks_fit(q: &Quality) -> bool {
    q.rms_over_noise.is_some_and(|ratio| ratio > LACK_OF_FIT)
}

/// Whether a candidate lacks fit where the chosen curve does not, or lacks less.
fn fits_worse(q: &Quality, winner: Option<Quality>) -> bool {
    /// Residuals that differ by less are alike.
    const WORSE: f64 = 1.05;
    lacks_fit(q) && winner.is_none_or(|best| q.rms > WORSE * best.rms)
}

/// Three significant digits.
pub(crate) fn significant(value: f64) -> String {
    let magnitude = if value == 0.0 { 0.0 } else { libm::floor(libm::log10(value.abs())) };
    let decimals = (2.0 - magnitude).clamp(0.0, 12.0) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_results::CurveModel;

    #[test]
    fn numbers_have_three_significant_digits() {
        for (value, text) in [
            (3.086, "3.09"),
            (0.32613, "0.326"),
            (1234.5, "1234"),
            (0.0, "0.00"),
            (4e-5, "0.0000400"),
        ] {
            assert_eq!(significant(value), text);
        }
    }

    /// A candidate with these squared errors on the parts left out, and that RMS over the noise.
    fn candidate(name: CurveModel, left_out: &[f64], rms_over_noise: f64) -> Candidate {
        let (mean, std_error) = mean_and_error(left_out);
        let rms = mean.sqrt();
        let quality = Quality {
            df: 10,
            rms,
            r2: None,
            cv_rms: rms,
            cv_std_error: std_error / (2.0 * rms),
            aicc: None,
            autocorrelation: None,
            rms_over_noise: Some(rms_over_noise),
        };
        let model = Model::of(name);
        Candidate {
            name,
            formula: model.formula(),
            complexity: model.complexity(),
            parameters: vec![],
            quality: Some(quality),
            verdict: CandidateVerdict::NotFitted,
            reason: String::new(),
            left_out: left_out.to_vec(),
            independent: None,
            resampled: vec![],
        }
    }

    fn check(candidates: &[(&'static str, [f64; 4], f64)], chosen: &str, reason: &str) {
        let mut candidates: Vec<Candidate> = candidates
            .iter()
            .map(|(name, errors, ratio)| {
                candidate(CurveModel::from_word(name).unwrap(), errors, *ratio)
            })
            .collect();
        let (found, why) = judge(&mut candidates, "4 sweeps", "N").unwrap();
        assert_eq!((candidates[found].name.as_str(), why.as_str()), (chosen, reason));
    }

    /// The misfit is in one block only, and large there: the difference varies from block to block
    /// as much.
    #[test]
    fn a_large_misfit_in_one_part_counts_too() {
        let line = ("line", [1.0, 1.0, 1.0, 9.0], 1.0);
        let reason = "hinge has the smallest cross-validated RMS (1.00 ± 0.00 N, 4 sweeps); no simpler candidate is as \
                      good within the standard errors.";
        check(&[line, ("hinge", [1.0; 4], 1.0)], "hinge", reason);
    }

    /// The sweeps differ more from each other than the candidates do; yet one of these is worse on
    /// every sweep.
    #[test]
    fn candidates_are_compared_sweep_by_sweep() {
        check(
            &[("line", [1.2, 4.2, 9.2, 2.2], 1.0), ("hinge", [1.0, 4.0, 9.0, 2.0], 1.0)],
            "hinge",
            "hinge has the smallest cross-validated RMS (2.00 ± 0.445 N, 4 sweeps); no simpler candidate is \
             as good within the standard errors.",
        );
        check(
            &[("line", [1.2, 4.2, 9.2, 2.1], 1.0), ("hinge", [1.0, 4.4, 9.0, 2.0], 1.0)],
            "line",
            "line is the simplest candidate as good, within the standard errors, as that with the smallest \
             cross-validated RMS (2.02 ± 0.440 N, 4 sweeps), hinge.",
        );
        check(
            &[("line", [1.0; 4], 1.0), ("hinge", [1.0; 4], 1.0)],
            "line",
            "line is the simplest candidate and has the smallest cross-validated RMS (1.00 ± 0.00 N, 4 sweeps).",
        );
    }

    #[test]
    fn of_equally_simple_candidates_the_better_is_chosen() {
        let better = "power_law is the simplest candidate and has the smallest cross-validated RMS (1.00 ± 0.00 N, 4 sweeps).";
        let saturation = ("saturation", [0.5, 1.0, 1.5, 1.1], 1.0);
        check(&[saturation, ("power_law", [1.0; 4], 1.0)], "power_law", better);
    }

    #[test]
    fn a_spline_is_chosen_only_where_every_law_lacks_fit() {
        let error = |rms: &str| format!("the smallest cross-validated RMS ({rms} N, 4 sweeps)");
        let simplest = format!("line is the simplest candidate and has {}.", error("1.00 ± 0.00"));
        check(&[("line", [1.0; 4], 1.2), ("spline", [0.25; 4], 0.8)], "line", &simplest);
        let spline = format!(
            "spline has {}; no simpler candidate is as good within the standard errors.",
            error("0.500 ± 0.00")
        );
        check(&[("line", [1.0; 4], 1.6), ("spline", [0.25; 4], 0.8)], "spline", &spline);
    }
}
