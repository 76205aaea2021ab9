//! Agreement of sessions (or devices, or raters): intraclass correlations, the error of
//! measurement, and limits of agreement.
//!
//! A table has one row per participant and one column per session. McGraw & Wong (1996), Psychol.
//! Methods 1:30, model 2 (sessions are a sample: A) and 3 (these sessions: C); the names in
//! brackets are those of Shrout & Fleiss (1979), Psychol. Bull. 86:420.

use crate::anova::two_way;
use crate::error::{all_finite, check_level};
use crate::f_distribution::quantile;
use crate::interval::{Estimate, t_interval};
use crate::tested::{Unestimable, not_constant};
use zwidth_numerics::moments::Moments;

/// Limits of agreement hold about 95 % of differences, as Bland & Altman (1999) have them.
pub(crate) const LIMIT: f64 = 1.96;

/// A correlation with its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Correlation {
    /// The estimate; negative where participants differ less than their sessions scatter.
    pub estimate: f64,
    /// Lower end.
    pub ci_low: f64,
    /// Upper end.
    pub ci_high: f64,
}

/// Agreement of the sessions of a complete table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Agreement {
    /// ICC(A,1) \[ICC(2,1)\]: absolute agreement of single sessions.
    pub a1: Correlation,
    /// ICC(C,1) \[ICC(3,1)\]: consistency of single sessions, whatever their levels.
    pub c1: Correlation,
    /// ICC(A,k) \[ICC(2,k)\]: absolute agreement of means over the k sessions.
    pub ak: Correlation,
    /// ICC(C,k) \[ICC(3,k)\]: consistency of means over the k sessions.
    pub ck: Correlation,
    /// Variance between participants; an estimate below zero is 0.
    pub participant_variance: f64,
    /// Variance between sessions; an estimate below zero is 0.
    pub session_variance: f64,
    /// Variance of the rest.
    pub error_variance: f64,
    /// Standard error of measurement √(session + error variance), unit of the values.
    pub sem: f64,
    /// Minimal detectable change 1.96 √2 SEM: two measurements that differ by more differ, 95 %.
    pub mdc: f64,
}

/// Agreement of the sessions of `table`, a row per participant and a column per session, with
/// intervals at `level`.
///
/// # Errors
/// Fewer than two participants or sessions, rows of different lengths, a value that is not finite,
/// sessions without any scatter, `level` outside (0, 1).
pub fn agreement(table: &[Vec<f64>], level: f64) -> Result<Agreement, Unestimable> {
    check_level(level)?;
    let sums = two_way(table, ["participants", "sessions", "differences of sessions"])?;
    let n = table.len() as f64;
    let k = table[0].len() as f64;
    let rows = sums.rows / (n - 1.0);
    let columns = sums.columns / (k - 1.0);
    let error = sums.error / ((n - 1.0) * (k - 1.0));
    let squares = Squares { n, k, rows, columns, error };
    let c1 = consistency(&squares, level)?;
    let a1 = absolute(&squares, level)?;
    let session_variance = ((columns - error) / n).max(0.0);
    let sem = (session_variance + error).sqrt();
    Ok(Agreement {
        a1,
        c1,
        ak: averaged(a1, k),
        ck: averaged(c1, k),
        participant_variance: ((rows - error) / k).max(0.0),
        session_variance,
        error_variance: error,
        sem,
        mdc: LIMIT * core::f64::consts::SQRT_2 * sem,
    })
}

/// Mean squares of n participants and k sessions.
struct Squares {
    n: f64,
    k: f64,
    rows: f64,
    columns: f64,
    error: f64,
}

/// ICC(C,1) = (MSR − MSE) / (MSR + (k − 1) MSE), exact interval from MSR / MSE.
fn consistency(squares: &Squares, level: f64) -> Result<Correlation, Unestimable> {
    let Squares { n, k, rows, error, .. } = squares;
    let df_rows = n - 1.0;
    let df_error = (n - 1.0) * (k - 1.0);
    let f = rows / error;
    let end = (1.0 + level) / 2.0;
    let low = f / quantile(end, df_rows, df_error)?;
    // The reciprocal of an F has its degrees of freedom the other way round.
    let high = f * quantile(end, df_error, df_rows)?;
    let [estimate, ci_low, ci_high] = [f, low, high].map(|f| (f - 1.0) / (f + k - 1.0));
    Ok(Correlation { estimate, ci_low, ci_high })
}

/// ICC(A,1) = (MSR − MSE) / (MSR + (k − 1) MSE + k (MSC − MSE) / n); its interval takes
/// Satterthwaite's degrees of freedom of a MSC + b MSE (their table 7).
fn absolute(squares: &Squares, level: f64) -> Result<Correlation, Unestimable> {
    let Squares { n, k, rows, columns, error } = *squares;
    let estimate = (rows - error) / (rows + (k - 1.0) * error + k * (columns - error) / n);
    // a and b, both times 1 − ICC: their ratio is all that counts.
    let a = k * estimate / n * columns;
    let b = (1.0 - estimate + k * estimate * (n - 1.0) / n) * error;
    let v = (a + b) * (a + b) / (a * a / (k - 1.0) + b * b / ((n - 1.0) * (k - 1.0)));
    let end = (1.0 + level) / 2.0;
    let rest = k * columns + (k * n - k - n) * error;
    let low = quantile(end, n - 1.0, v)?;
    let high = quantile(end, v, n - 1.0)?;
    Ok(Correlation {
        estimate,
        ci_low: n * (rows - low * error) / (low * rest + n * rows),
        ci_high: n * (high * rows - error) / (rest + n * high * rows),
    })
}

/// The correlation of means over k sessions, k ρ / (1 + (k − 1) ρ) (Spearman & Brown), which turns
/// the ends of an interval into those of the mean's, too.
pub(crate) fn averaged(single: Correlation, k: f64) -> Correlation {
    let [estimate, ci_low, ci_high] = [single.estimate, single.ci_low, single.ci_high]
        .map(|rho| k * rho / (1.0 + (k - 1.0) * rho));
    Correlation { estimate, ci_low, ci_high }
}

/// Limits of agreement of two measurements of the same participants. Unit of the values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlandAltman {
    /// Participants.
    pub n: usize,
    /// The mean difference, with its interval.
    pub bias: Estimate,
    /// SD of the differences.
    pub sd: f64,
    /// bias − 1.96 sd, with its interval.
    pub lower: Estimate,
    /// bias + 1.96 sd, with its interval.
    pub upper: Estimate,
}

/// Bland & Altman (1999), Stat. Methods Med. Res. 8:135: limits of agreement of `differences`, one
/// per participant, with t intervals at `level`; a limit's variance is s² (1/n + 1.96² / (2 (n −
/// 1))).
///
/// # Errors
/// Fewer than two differences, differences that are all equal, a value that is not finite, `level`
/// outside (0, 1).
pub fn bland_altman(differences: &[f64], level: f64) -> Result<BlandAltman, Unestimable> {
    all_finite(differences)?;
    let n = differences.len();
    let moments = Moments::of(differences);
    let Some(sd) = moments.sd() else {
        return Err(Unestimable::TooFew { units: "participants", found: n, needed: 2 });
    };
    // Not by the SD: of equal values it may be rounding instead of 0.
    not_constant("differences", differences.iter().all(|d| d.total_cmp(&differences[0]).is_eq()))?;
    let count = n as f64;
    let limit_error = sd * (1.0 / count + LIMIT * LIMIT / (2.0 * (count - 1.0))).sqrt();
    let [bias, lower, upper] = [
        (moments.mean, sd / count.sqrt()),
        (moments.mean - LIMIT * sd, limit_error),
        (moments.mean + LIMIT * sd, limit_error),
    ]
    .map(|(centre, error)| t_interval(centre, error, count - 1.0, level));
    Ok(BlandAltman { n, bias: bias?, sd, lower: lower?, upper: upper? })
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Table 2 of Shrout & Fleiss (1979): six targets by four judges.
    pub(crate) fn shrout_fleiss() -> Vec<Vec<f64>> {
        [
            [9.0, 2.0, 5.0, 8.0],
            [6.0, 1.0, 3.0, 2.0],
            [8.0, 4.0, 6.0, 8.0],
            [7.0, 1.0, 2.0, 6.0],
            [10.0, 5.0, 6.0, 9.0],
            [6.0, 2.0, 4.0, 7.0],
        ]
        .map(Vec::from)
        .to_vec()
    }

    /// Estimates: their table 4 (0.29, 0.71, 0.62, 0.91), and pingouin 0.7 to all digits;
    /// intervals: pingouin, which gives two digits.
    #[test]
    fn shrout_and_fleiss_table_has_its_published_correlations() {
        let found = agreement(&shrout_fleiss(), 0.95).unwrap();
        for (found, estimate, low, high) in [
            (found.a1, 0.289763779527559, 0.02, 0.76),
            (found.c1, 0.714840714840715, 0.34, 0.95),
            (found.ak, 0.620050547598989, 0.07, 0.93),
            (found.ck, 0.909315542377070, 0.68, 0.99),
        ] {
            assert!((found.estimate / estimate - 1.0).abs() < 1e-12, "{found:?}");
            assert!((found.ci_low - low).abs() < 0.005, "{found:?}");
            assert!((found.ci_high - high).abs() < 0.005, "{found:?}");
        }
    }

    /// MSC 32.486…, MSE 1.0194…, n 6: σ²_session = (MSC − MSE) / n.
    #[test]
    fn the_error_of_measurement_adds_sessions_and_the_rest() {
        let found = agreement(&shrout_fleiss(), 0.95).unwrap();
        let (columns, error) = (97.458_333_333_333_33 / 3.0, 15.291_666_666_666_66 / 15.0);
        let variance = (columns - error) / 6.0 + error;
        assert!((found.sem - f64::sqrt(variance)).abs() < 1e-12);
        assert!((found.mdc / found.sem - 1.96 * f64::sqrt(2.0)).abs() < 1e-12);
    }

    #[test]
    fn sessions_that_only_differ_in_level_are_consistent_and_do_not_agree() {
        let shifted: Vec<Vec<f64>> = (0..8)
            .map(|i| {
                let (x, noise) = (f64::from(i), f64::from(i * i % 3) * 1e-3);
                vec![x, x + 5.0 + noise]
            })
            .collect();
        let found = agreement(&shifted, 0.95).unwrap();
        assert!(found.c1.estimate > 0.999 && found.a1.estimate < 0.4);
        assert!(found.a1.ci_low < found.a1.estimate && found.a1.estimate < found.a1.ci_high);
    }

    /// Eight differences with mean 1 and SD √(8/7).
    #[test]
    fn limits_of_agreement_lie_two_sds_about_the_bias() {
        let found = bland_altman(&[0.0, 2.0, 0.0, 2.0, 0.0, 2.0, 0.0, 2.0], 0.95).unwrap();
        let sd = f64::sqrt(8.0 / 7.0);
        assert!((found.bias.estimate - 1.0).abs() < 1e-15 && (found.sd - sd).abs() < 1e-15);
        assert!((found.upper.estimate - 1.0 - 1.96 * sd).abs() < 1e-14);
        let error = sd * f64::sqrt(1.0 / 8.0 + 1.96 * 1.96 / 14.0);
        assert!((found.lower.std_error - error).abs() < 1e-15);
        assert_eq!((found.n, found.lower.df), (8, 7.0));
    }

    #[test]
    fn what_cannot_be_said_is_said() {
        let same = vec![vec![1.0, 1.0], vec![2.0, 2.0], vec![3.0, 3.0]];
        assert!(matches!(agreement(&same, 0.95), Err(Unestimable::Constant { .. })));
        assert!(matches!(agreement(&same[..1], 0.95), Err(Unestimable::TooFew { .. })));
        assert!(matches!(agreement(&shrout_fleiss(), 95.0), Err(Unestimable::Refused(_))));
        assert!(matches!(bland_altman(&[1.0], 0.95), Err(Unestimable::TooFew { .. })));
        assert!(matches!(bland_altman(&[1.0, 1.0], 0.95), Err(Unestimable::Constant { .. })));
    }
}
