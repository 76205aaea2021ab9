//! A claim: the p value that it rests on, adjusted for the others of its family, and its verdict.

use zwidth_results::Verdict;
use zwidth_stats::{StatsError, holm, paired};
use zwidth_study::Families;

/// Whether there is a difference.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Claim {
    /// Index among the study's environments.
    pub(crate) environment: usize,
    /// The p value that it rests on, before it is adjusted; without one nothing is claimed.
    pub(crate) p: Option<f64>,
    /// The smallest that it can be, where the test counts orders.
    pub(crate) smallest_p: Option<f64>,
    /// The p value of "the difference is not within the bound", where there is a bound.
    pub(crate) p_not_equivalent: Option<f64>,
    /// How many claims are adjusted together, itself among them.
    pub(crate) together: usize,
    /// The p value, adjusted for the other claims of the family.
    pub(crate) p_adjusted: Option<f64>,
    /// The smallest that it can be, where the test counts orders.
    pub(crate) smallest_p_adjusted: Option<f64>,
    /// The verdict of these.
    pub(crate) verdict: Verdict,
}

impl Claim {
    /// A claim that is not judged yet.
    pub(crate) fn new(
        environment: usize,
        p: Option<f64>,
        smallest_p: Option<f64>,
        p_not_equivalent: Option<f64>,
    ) -> Self {
        Self {
            environment,
            p,
            smallest_p,
            p_not_equivalent,
            together: 0,
            p_adjusted: None,
            smallest_p_adjusted: None,
            verdict: Verdict::NotTested,
        }
    }

    /// The smallest adjusted p value, where it is not below `alpha`: no claim can be made.
    pub(crate) fn out_of_reach(&self, alpha: f64) -> Option<f64> {
        self.smallest_p_adjusted.filter(|p| *p >= alpha)
    }
}

/// How claims are judged.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Judging {
    pub(crate) families: Families,
    /// A claim needs an adjusted p value below this.
    pub(crate) alpha: f64,
    /// How many claims of another kind, at most, are primary besides: of curves beside those of metrics.
    pub(crate) elsewhere: usize,
}

/// Judges the claims of metrics that belong together, or of one metric: p values are adjusted (Holm)
/// family by family.
pub(crate) fn judge(mut claims: Vec<&mut Claim>, judging: Judging) -> Result<(), StatsError> {
    let whole = judging.families != Families::Environment;
    claims.sort_by_key(|claim| claim.environment);
    for family in claims.chunk_by_mut(|a, b| whole || a.environment == b.environment) {
        adjust(family, judging)?;
    }
    Ok(())
}

/// Adjusts the p values of one family, and the smallest that they can be: after Holm among each other, after
/// Bonferroni between these and the claims elsewhere, so that both together hold alpha.
fn adjust(
    claims: &mut [&mut Claim],
    Judging { alpha, elsewhere, .. }: Judging,
) -> Result<(), StatsError> {
    let p: Vec<f64> = claims.iter().filter_map(|claim| claim.p).collect();
    // Adjusted as well: how far orders reach depends on the other claims of the family, of which those
    // that do not rest on orders can have any p.
    let with_p = claims.iter().filter(|claim| claim.p.is_some());
    let smallest: Vec<f64> = with_p.map(|claim| claim.smallest_p.unwrap_or(0.0)).collect();
    let smallest = holm::adjusted(&smallest)?;
    let together = p.len() + elsewhere;
    let share = together as f64 / p.len().max(1) as f64;
    let with_p = claims.iter_mut().filter(|claim| claim.p.is_some());
    for ((claim, p), smallest) in with_p.zip(holm::adjusted(&p)?).zip(smallest) {
        let [p, smallest] = [p, smallest].map(|p| (p * share).min(1.0));
        claim.together = together;
        claim.p_adjusted = Some(p);
        claim.verdict = match paired::Verdict::new(p, claim.p_not_equivalent, alpha) {
            paired::Verdict::Different => Verdict::Different,
            paired::Verdict::DifferentBelowBound => Verdict::DifferentBelowBound,
            paired::Verdict::Equivalent => Verdict::Equivalent,
            paired::Verdict::Undecided => Verdict::Undecided,
        };
        claim.smallest_p_adjusted = claim.smallest_p.map(|_| smallest);
    }
    Ok(())
}
