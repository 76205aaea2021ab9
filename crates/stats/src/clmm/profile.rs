//! Profile intervals of fixed effects.

use super::fit::Fit;
use super::likelihood::Integral;
use super::model::Model;
use super::search::{Peak, Start, climb};
use crate::error::StatsError;
use crate::profile::end;
use crate::student_t::critical_value;
use crate::tested::Unestimable;

/// Ends are searched up to this distance from the estimate, in logits: an odds ratio that is 7 ·
/// 10¹⁰ times as large or as small.
const FARTHEST: f64 = 25.0;

/// The values of a coefficient that its likelihood-ratio test does not reject.
#[derive(Debug, Clone, PartialEq)]
pub struct ProfileInterval {
    /// The lower end.
    pub low: End,
    /// The upper end.
    pub high: End,
}

/// One end of a profile interval.
#[derive(Debug, Clone, PartialEq)]
pub enum End {
    /// Here the test begins to reject.
    At(f64),
    /// The answers set no end: 25 logits from the estimate, beyond any effect that matters, the
    /// likelihood has still not fallen as far as the test asks. With few answers per person large
    /// SDs explain away any effect.
    Open,
    /// The search failed: there may be an end or none.
    NotFound(Unestimable),
}

impl End {
    /// The end, where there is one and it was found.
    pub fn value(&self) -> Option<f64> {
        match self {
            Self::At(value) => Some(*value),
            Self::Open | Self::NotFound(_) => None,
        }
    }

    /// Why there is no value of this end, called by its `name`.
    fn missing(&self, name: &str) -> Option<String> {
        match self {
            Self::At(_) => None,
            Self::Open => Some(format!("no {name} end: the answers set none")),
            Self::NotFound(why) => Some(format!("{name} end not found: {why}")),
        }
    }
}

impl ProfileInterval {
    /// In words, why an end has no value: that the answers set none, or that the search for it
    /// failed. `None` where both ends have one.
    pub fn remark(&self) -> Option<String> {
        let side = match (&self.low, &self.high) {
            (End::At(_), End::At(_)) => return None,
            (End::Open, End::At(_)) => "from above only: no lower end",
            (End::At(_), End::Open) => "from below only: no upper end",
            (End::Open, End::Open) => "on neither side: no ends",
            (low, high) => {
                let missing = [low.missing("lower"), high.missing("upper")];
                return Some(missing.into_iter().flatten().collect::<Vec<_>>().join("; "));
            }
        };
        Some(format!("the answers bound the effect {side}"))
    }

    /// The interval of e^(−β) for the one of β: the odds ratio with the sides changed.
    pub(super) fn of_turned_odds(self) -> Self {
        let [low, high] = [self.high, self.low].map(|end| match end {
            End::At(value) => End::At(libm::exp(-value)),
            other => other,
        });
        Self { low, high }
    }
}

/// The profile interval of the coefficient of `column`: where twice the log-likelihood, maximised
/// over all else, is at most t² below its maximum, t the critical value at confidence `level` of
/// Student's t with `df` degrees of freedom. So the interval holds what the test referred to
/// F(1, `df`) does not reject.
///
/// # Errors
/// `level` outside (0, 1), `df` not positive.
pub fn profile_interval(
    model: &Model,
    integral: Integral,
    fit: &Fit,
    column: usize,
    level: f64,
    df: f64,
) -> Result<ProfileInterval, StatsError> {
    let critical = critical_value(level, df)?;
    let place = model.thresholds() + column;
    let peak = &fit.start.coordinates;
    let std_error = fit.start.covariance[place][place].sqrt();
    let [low, high] = [-1.0, 1.0].map(|sign| {
        let mut start = Start::again(model, peak, &fit.start.covariance);
        let fall = |distance: f64| {
            start.hold_at(place, peak[place] + sign * distance * std_error);
            let held = climb(model, integral, &start)?;
            // The next search is near by: it begins where this one ended.
            start.coordinates = held.coordinates;
            Ok((2.0 * (fit.log_likelihood - held.log_likelihood).max(0.0)).sqrt())
        };
        match end(fall, critical, FARTHEST / std_error) {
            Ok(Some(distance)) => End::At(peak[place] + sign * distance * std_error),
            Ok(None) => End::Open,
            Err(why) => End::NotFound(why),
        }
    });
    Ok(ProfileInterval { low, high })
}

/// The only end of the profile interval of a coefficient that `model` holds at its infinite limit,
/// because the answers are separated along its column: the value below which, in size, the test
/// begins to reject. `peak` is the maximum at the limit.
pub(super) fn bound_at_limit(
    model: &Model,
    integral: Integral,
    peak: &Peak,
    column: usize,
    critical: f64,
) -> End {
    let place = model.thresholds() + column;
    let held = peak.coordinates[place];
    let mut start = Start::new(model);
    start.coordinates.clone_from(&peak.coordinates);
    // Of a distance from infinity no unit is natural: it is counted in logits.
    let fall = |distance: f64| {
        start.hold_at(place, held - distance * held.signum());
        let reached = climb(model, integral, &start)?;
        start.coordinates = reached.coordinates;
        Ok((2.0 * (peak.log_likelihood - reached.log_likelihood).max(0.0)).sqrt())
    };
    match end(fall, critical, held.abs() + FARTHEST) {
        Ok(Some(distance)) => End::At(held - distance * held.signum()),
        Ok(None) => End::Open,
        Err(why) => End::NotFound(why),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_end_without_a_value_says_whether_there_is_none_or_it_was_not_found() {
        let words = |low: End, high: End| ProfileInterval { low, high }.remark();
        let failed =
            || End::NotFound(Unestimable::NotConverged { what: "thresholds", slope: 0.25 });
        assert_eq!(words(End::At(-1.0), End::At(2.0)), None);
        for (low, high, expect) in [
            (End::Open, End::At(1.0), "the answers bound the effect from above only: no lower end"),
            (End::At(1.0), End::Open, "the answers bound the effect from below only: no upper end"),
            (End::Open, End::Open, "the answers bound the effect on neither side: no ends"),
            (
                failed(),
                End::Open,
                "lower end not found: the search for thresholds found no optimum (slope 2.5e-1 \
                 left); no upper end: the answers set none",
            ),
        ] {
            assert_eq!(words(low, high).as_deref(), Some(expect));
        }
    }

    #[test]
    fn turned_odds_change_their_sides() {
        let turned = ProfileInterval { low: End::At(0.0), high: End::Open }.of_turned_odds();
        assert_eq!(turned, ProfileInterval { low: End::Open, high: End::At(1.0) });
    }
}
