//! Which candidate is chosen, and what is said of each.

use crate::characteristic::{Candidate, Quality};

/// Residuals that exceed the noise by more than this show that the curve is wrong.
const LACK_OF_FIT: f64 = 1.5;

/// Two errors closer than this share of themselves are the same but for rounding.
const SAME: f64 = 1e-9;

/// What became of a candidate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// It is the one to use.
    Chosen,
    /// Its residuals exceed the noise, or it predicts worse than the chosen one by more than a standard error.
    Rejected,
    /// It predicts no better than the chosen one, with more parameters.
    NotNeeded,
    /// There are too few points for its parameters.
    NotFitted,
}

impl Verdict {
    /// The verdict as a table says it: `chosen`, `rejected`, `not_needed`, `not_fitted`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Chosen => "chosen",
            Self::Rejected => "rejected",
            Self::NotNeeded => "not_needed",
            Self::NotFitted => "not_fitted",
        }
    }
}

/// Chooses a candidate, writes every verdict, and gives the chosen one's index with the reason in a sentence.
/// `left_out` says what cross-validation left out (`10 blocks`), `unit` is that of the response. `None` if no
/// candidate could be fitted.
pub(crate) fn judge(candidates: &mut [Candidate], left_out: &str, unit: &str) -> Option<(usize, String)> {
    let (best, chosen) = choose(candidates)?;
    let reason = reason(candidates, best, chosen, left_out, unit);
    let winner = candidates[chosen].clone();
    for (index, candidate) in candidates.iter_mut().enumerate() {
        candidate.verdict = verdict(candidate, &winner, index == chosen);
        candidate.verdict_text = words(candidate, &winner, unit);
    }
    Some((chosen, reason))
}

/// The candidate with the smallest cross-validated RMS (the simplest of equals), and the simplest within one
/// standard error of it.
fn choose(candidates: &[Candidate]) -> Option<(usize, usize)> {
    let errors = || candidates.iter().filter_map(|c| c.quality).map(|q| (q.cv_rms, q.cv_std_error));
    let (smallest, std_error) = errors().min_by(|(a, _), (b, _)| a.total_cmp(b))?;
    let simplest_within = |limit: f64| {
        let within = |c: &&Candidate| c.quality.is_some_and(|q| q.cv_rms <= limit);
        let simplest = candidates.iter().filter(within).min_by_key(|c| c.complexity)?;
        candidates.iter().position(|c| c.name == simplest.name)
    };
    Some((simplest_within(smallest * (1.0 + SAME))?, simplest_within(smallest + std_error)?))
}

fn reason(candidates: &[Candidate], best: usize, chosen: usize, left_out: &str, unit: &str) -> String {
    let (winner, best) = (&candidates[chosen], &candidates[best]);
    let error = best.quality.map(|q| left_out_error(&q, unit)).unwrap_or_default();
    let smallest = format!("the smallest cross-validated RMS ({error}, {left_out})");
    let simplest = candidates.iter().all(|c| c.complexity >= winner.complexity);
    match (winner.name == best.name, simplest) {
        (true, true) => format!("{} is the simplest candidate and has {smallest}.", winner.name),
        (true, false) => {
            format!(
                "{} has {smallest}; no simpler candidate is within one standard error of it.",
                winner.name
            )
        }
        (false, _) => format!(
            "{} is the simplest candidate within one standard error of {smallest}, that of {}.",
            winner.name, best.name
        ),
    }
}

fn verdict(candidate: &Candidate, winner: &Candidate, chosen: bool) -> Verdict {
    match candidate.quality {
        None => Verdict::NotFitted,
        Some(_) if chosen => Verdict::Chosen,
        Some(q) if candidate.complexity > winner.complexity && !fits_worse(&q, winner.quality) => {
            Verdict::NotNeeded
        }
        Some(_) => Verdict::Rejected,
    }
}

fn words(candidate: &Candidate, winner: &Candidate, unit: &str) -> String {
    let Some((q, best)) = candidate.quality.zip(winner.quality) else {
        return format!(
            "not fitted: too few points, less those left out, for {} parameters",
            candidate.complexity
        );
    };
    let against = || format!("{} against {}", left_out_error(&q, unit), left_out_error(&best, unit));
    match candidate.verdict {
        Verdict::Chosen => format!("chosen: {}{}", residuals(&q, unit), warning(&q)),
        Verdict::NotNeeded => format!("not needed: RMS on data left out {} for {}", against(), winner.name),
        _ if fits_worse(&q, Some(best)) => format!("rejected: {}", residuals(&q, unit)),
        _ => format!("rejected: RMS on data left out {} for {}", against(), winner.name),
    }
}

/// `RMS 3.09 mN·m is 8.6 times the noise, residual autocorrelation 0.98`.
fn residuals(q: &Quality, unit: &str) -> String {
    let ratio = q.rms_over_noise.map(|r| format!(" is {r:.1} times the noise")).unwrap_or_default();
    let alike = q.autocorrelation.map(|r| format!(", residual autocorrelation {r:.2}")).unwrap_or_default();
    format!("RMS {} {unit}{ratio}{alike}", significant(q.rms))
}

/// `0.471 ± 0.096 mN·m`.
fn left_out_error(q: &Quality, unit: &str) -> String {
    format!("{} ± {} {unit}", significant(q.cv_rms), significant(q.cv_std_error))
}

fn lacks_fit(q: &Quality) -> bool {
    q.rms_over_noise.is_some_and(|ratio| ratio > LACK_OF_FIT)
}

/// Lack of fit that the chosen curve does not share.
fn fits_worse(q: &Quality, winner: Option<Quality>) -> bool {
    /// Residuals that differ by less are alike.
    const WORSE: f64 = 1.05;
    lacks_fit(q) && winner.is_none_or(|best| q.rms > WORSE * best.rms)
}

fn warning(q: &Quality) -> &'static str {
    if lacks_fit(q) { "; lack of fit: the best of these curves, yet not the whole story" } else { "" }
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

    #[test]
    fn numbers_have_three_significant_digits() {
        for (value, text) in
            [(3.086, "3.09"), (0.32613, "0.326"), (1234.5, "1234"), (0.0, "0.00"), (4e-5, "0.0000400")]
        {
            assert_eq!(significant(value), text);
        }
    }

    fn candidate(name: &'static str, complexity: usize, cv_rms: f64, cv_std_error: f64) -> Candidate {
        let quality = Quality {
            df: 10,
            rms: cv_rms,
            r2: None,
            cv_rms,
            cv_std_error,
            aicc: None,
            autocorrelation: None,
            rms_over_noise: None,
        };
        Candidate {
            name,
            formula: "",
            complexity,
            parameters: vec![],
            quality: Some(quality),
            verdict: Verdict::NotFitted,
            verdict_text: String::new(),
            resampled: vec![],
        }
    }

    fn check(errors: [(f64, f64); 3], chosen: usize, reason: &str) {
        let names = [("line", 2), ("hinge", 3), ("power_law", 4)];
        let mut candidates: Vec<Candidate> =
            names.iter().zip(errors).map(|((name, p), (rms, se))| candidate(name, *p, rms, se)).collect();
        assert_eq!(judge(&mut candidates, "4 sweeps", "N"), Some((chosen, reason.to_owned())));
    }

    #[test]
    fn the_simplest_within_one_standard_error_of_the_best_is_chosen() {
        check(
            [(3.0, 0.1), (1.05, 0.3), (1.0, 0.1)],
            1,
            "hinge is the simplest candidate within one standard error of the smallest cross-validated RMS \
             (1.00 ± 0.100 N, 4 sweeps), that of power_law.",
        );
        check(
            [(3.0, 0.1), (1.15, 0.3), (1.0, 0.1)],
            2,
            "power_law has the smallest cross-validated RMS (1.00 ± 0.100 N, 4 sweeps); no simpler candidate is \
             within one standard error of it.",
        );
        check(
            [(1.0, 0.1), (1.0, 0.3), (1.0, 0.1)],
            0,
            "line is the simplest candidate and has the smallest cross-validated RMS (1.00 ± 0.100 N, 4 sweeps).",
        );
    }
}
