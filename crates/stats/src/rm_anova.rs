//! Repeated-measures analysis of variance of participants' means: one row per participant, one
//! column per mode.
//!
//! F compares the modes with the interaction of participant × mode. It assumes that the differences
//! between all pairs of modes have one variance (sphericity); ε says how far this holds, and
//! degrees of freedom multiplied by ε make the test nearly valid anyway.

use crate::anova::two_way;
use crate::f_distribution::upper_p;
use crate::tested::{FTest, Unestimable, not_constant};
use zwidth_numerics::dense::Matrix;

/// A repeated-measures analysis of variance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RmAnova {
    /// The test with (k − 1) and (n − 1)(k − 1) degrees of freedom.
    pub test: FTest,
    /// Greenhouse & Geisser (1959)'s ε, from 1 / (k − 1) to 1.
    pub greenhouse_geisser: f64,
    /// Huynh & Feldt (1976)'s ε, at most 1. For one group of participants Lecoutre (1991)'s
    /// correction of it leaves it as it is.
    pub huynh_feldt: f64,
    /// p with both degrees of freedom times Greenhouse & Geisser's ε.
    pub p_greenhouse_geisser: f64,
    /// p with both degrees of freedom times Huynh & Feldt's ε.
    pub p_huynh_feldt: f64,
}

/// The analysis of `table`: a row per participant, a column per mode, complete.
///
/// # Errors
/// Fewer than two participants or modes, rows of different lengths, a value that is not finite,
/// modes that differ alike in all participants.
pub fn rm_anova(table: &[Vec<f64>]) -> Result<RmAnova, Unestimable> {
    let sums = two_way(table, ["participants", "modes", "differences of modes"])?;
    let n = table.len() as f64;
    let k = table[0].len() as f64;
    let df_num = k - 1.0;
    let df_den = (n - 1.0) * (k - 1.0);
    let statistic = sums.columns / df_num / (sums.error / df_den);
    let greenhouse_geisser = greenhouse_geisser(table);
    let huynh_feldt = huynh_feldt(greenhouse_geisser, n, k);
    let [p_value, p_greenhouse_geisser, p_huynh_feldt] = [1.0, greenhouse_geisser, huynh_feldt]
        .map(|epsilon| upper_p(statistic, epsilon * df_num, epsilon * df_den));
    Ok(RmAnova {
        test: FTest { statistic, df_num, df_den, p_value: p_value? },
        greenhouse_geisser,
        huynh_feldt,
        p_greenhouse_geisser: p_greenhouse_geisser?,
        p_huynh_feldt: p_huynh_feldt?,
    })
}

/// The analysis of one effect of a factorial design: of the part of `table`, whose columns are conditions,
/// in which the effect's `contrasts` lie (a weight for each column, adding up to 0). In a complete
/// design this is the line of that effect in an analysis of variance with its own error stratum.
///
/// Only that part of a row is analysed, with as many degrees of freedom k as contrasts do not depend
/// on each other: F = MS(effect) / MS(effect × participant), k and k (n − 1) degrees of freedom, and
/// ε = (tr C)² / (k tr C²) of the part's covariance matrix C.
///
/// # Errors
/// As [`rm_anova`]; contrasts that are all zero.
pub fn effect(table: &[Vec<f64>], contrasts: &[Vec<f64>]) -> Result<RmAnova, Unestimable> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    // An orthonormal basis of what the contrasts span (modified Gram–Schmidt).
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for contrast in contrasts {
        let mut rest = contrast.clone();
        for direction in &basis {
            let along = dot(&rest, direction);
            rest.iter_mut().zip(direction).for_each(|(rest, one)| *rest -= along * one);
        }
        let [length, whole] = [&rest, contrast].map(|vector| dot(vector, vector).sqrt());
        if length > DEPENDENT * whole {
            basis.push(rest.into_iter().map(|value| value / length).collect());
        }
    }
    // Contrasts see no constant; without it no digits are lost far from zero.
    let constant = table.first().and_then(|row| row.first()).copied().unwrap_or_default();
    let near: Vec<Vec<f64>> =
        table.iter().map(|row| row.iter().map(|value| value - constant).collect()).collect();
    let part = |row: &Vec<f64>| {
        basis.iter().fold(vec![0.0; row.len()], |mut part, direction| {
            let along = dot(row, direction);
            part.iter_mut().zip(direction).for_each(|(part, one)| *part += along * one);
            part
        })
    };
    let parts: Vec<Vec<f64>> = near.iter().map(part).collect();
    let whole = rm_anova(&parts)?;
    // What is left of values that only differ in other respects is their rounding.
    let mean = |k: usize| parts.iter().map(|row| row[k]).sum::<f64>() / parts.len() as f64;
    let means: Vec<f64> = (0..parts[0].len()).map(mean).collect();
    let squares = parts.iter().flat_map(|row| row.iter().zip(&means)).map(|(v, m)| (v - m).powi(2));
    let all: f64 = near.iter().map(|row| dot(row, row)).sum();
    not_constant("participants' effects", squares.sum::<f64>() <= ROUNDING * all)?;
    // The columns' sums of squares are those of the part: the ratio of mean squares is the same with k
    // degrees of freedom, and so is k ε.
    let (n, k) = (table.len() as f64, basis.len() as f64);
    let FTest { statistic, df_num: columns, .. } = whole.test;
    let greenhouse_geisser = whole.greenhouse_geisser * columns / k;
    let huynh_feldt = huynh_feldt(greenhouse_geisser, n, k + 1.0);
    let df_den = k * (n - 1.0);
    let [p_value, p_huynh_feldt] =
        [1.0, huynh_feldt].map(|epsilon| upper_p(statistic, epsilon * k, epsilon * df_den));
    Ok(RmAnova {
        test: FTest { statistic, df_num: k, df_den, p_value: p_value? },
        greenhouse_geisser,
        huynh_feldt,
        p_huynh_feldt: p_huynh_feldt?,
        p_greenhouse_geisser: whole.p_greenhouse_geisser,
    })
}

/// Squares that are no more than this share of all are those of rounding.
const ROUNDING: f64 = 1e-24;

/// A contrast of which no more than this share is new depends on those before.
const DEPENDENT: f64 = 1e-9;

/// ε̂ = (tr C)² / ((k − 1) tr C²), with C the modes' covariance matrix centred by rows and columns.
fn greenhouse_geisser(table: &[Vec<f64>]) -> f64 {
    let n = table.len();
    let k = table[0].len();
    let origin = &table[0];
    // Rows without their participant's level. The first row is subtracted from all before, because
    // far from zero digits would be lost.
    let centred: Vec<Vec<f64>> = table
        .iter()
        .map(|row| {
            let level = row.iter().zip(origin).map(|(v, o)| v - o).sum::<f64>() / k as f64;
            row.iter().zip(origin).map(|(v, o)| v - o - level).collect()
        })
        .collect();
    let mean: Vec<f64> =
        (0..k).map(|j| centred.iter().map(|row| row[j]).sum::<f64>() / n as f64).collect();
    let mut covariance = Matrix::zeros(k, k);
    for row in &centred {
        let rest: Vec<f64> = row.iter().zip(&mean).map(|(v, m)| v - m).collect();
        covariance.add_outer(1.0, &rest, &rest);
    }
    let trace: f64 = covariance.diagonal().iter().sum();
    // Above 1 by rounding alone.
    (trace * trace / ((k - 1) as f64 * covariance.dot(&covariance))).min(1.0)
}

/// ε̃ = (n (k − 1) ε̂ − 2) / ((k − 1) (n − 1 − (k − 1) ε̂)), at most 1. Of two participants nothing
/// can be said but ε̂.
fn huynh_feldt(epsilon: f64, n: f64, k: f64) -> f64 {
    /// Less than this is left by rounding alone.
    const NOTHING: f64 = 1e-9;
    let left = n - 1.0 - (k - 1.0) * epsilon;
    let over = n * (k - 1.0) * epsilon - 2.0;
    match (left > NOTHING, over > NOTHING) {
        (true, _) => (over / ((k - 1.0) * left)).max(epsilon).min(1.0),
        (false, true) => 1.0,
        (false, false) => epsilon,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::agreement::tests::shrout_fleiss;

    fn close(found: f64, expected: f64, digits: f64) {
        assert!((found / expected - 1.0).abs() < digits, "{found} for {expected}");
    }

    /// R 4.2: `anova(lm(d ~ 1), X = ~1, test = "Spherical")`; pingouin 0.7: `epsilon`.
    #[test]
    fn judges_as_modes_have_the_analysis_of_r_and_pingouin() {
        let found = rm_anova(&shrout_fleiss()).unwrap();
        close(found.test.statistic, 31.866485013624, 1e-12);
        close(found.test.p_value, 9.45426320247059e-07, 1e-8);
        close(found.greenhouse_geisser, 0.681724544594095, 1e-12);
        close(found.p_greenhouse_geisser, 3.84552635469624e-05, 1e-8);
        close(found.huynh_feldt, 1.0, 1e-15);
        close(found.p_huynh_feldt, 9.45426320247059e-07, 1e-8);
        // Whole numbers are exact far from zero, too.
        let far =
            shrout_fleiss().into_iter().map(|row| row.into_iter().map(|v| v + 1e12).collect());
        assert_eq!(rm_anova(&far.collect::<Vec<_>>()).unwrap().test, found.test);
    }

    /// With ε̂ = 0.6 of 8 participants and 4 modes: (8 · 3 · 0.6 − 2) / (3 (7 − 1.8)).
    #[test]
    fn huynh_and_feldts_epsilon_follows_from_the_other() {
        close(huynh_feldt(0.6, 8.0, 4.0), 12.4 / 15.6, 1e-14);
        close(huynh_feldt(0.5, 2.0, 3.0), 0.5, 1e-14);
    }

    /// Of two modes F is the square of the paired t, and there is nothing to correct.
    #[test]
    fn two_modes_are_the_paired_t_test() {
        let table = [[1.0, 2.5], [2.0, 2.9], [4.0, 5.5], [3.0, 3.1]].map(Vec::from);
        let found = rm_anova(&table).unwrap();
        let differences = zwidth_numerics::moments::Moments::of(&[1.5, 0.9, 1.5, 0.1]);
        let t = differences.mean / (differences.sd().unwrap() / 2.0);
        close(found.test.statistic, t * t, 1e-12);
        close(found.greenhouse_geisser, 1.0, 1e-12);
        close(found.p_greenhouse_geisser, found.test.p_value, 1e-8);
    }

    #[test]
    fn what_cannot_be_said_is_said() {
        let few = rm_anova(&[vec![1.0, 2.0]]);
        assert!(matches!(few, Err(Unestimable::TooFew { .. })));
        let alike = rm_anova(&[vec![1.0, 2.0], vec![3.0, 4.0], vec![7.0, 8.0]]);
        assert!(matches!(alike, Err(Unestimable::Constant { .. })));
        let ragged = rm_anova(&[vec![1.0, 2.0], vec![3.0]]);
        assert!(matches!(ragged, Err(Unestimable::Refused(_))));
    }

    /// Thirty people in 3 × 3 conditions by formula. R's `aov` with the strata p:v, p:h and p:v:h and its
    /// `anova.mlm(test = "Spherical")`, and pingouin's `rm_anova`, agree on F, ε and p.
    #[test]
    fn an_effect_of_a_design_of_two_factors_is_its_line_in_rs_analysis() {
        let u = |of: [u64; 2]| {
            let h = 1 + 131 * of[0] + 173 * of[1];
            (h * h * h % 9941) as f64 / 9941.0 - 0.5
        };
        let value = |person: u64, v: u64, h: u64| {
            let [fv, fh] = [v, h].map(|x| x as f64);
            let y = 3.0
                + 0.5 * fv
                + 0.8 * fh
                + 0.35 * fv * fh
                + 1.2 * u([person, 0])
                + 0.7 * fv * u([person, 1])
                + 0.5 * fh * u([person, 2])
                + 0.3 * fv * fh * u([person, 3])
                + 0.6 * u([person, 4 + 3 * v + h]);
            (y * 1000.0).round() / 1000.0
        };
        let table: Vec<Vec<f64>> = (1..=30)
            .map(|person| (0..9).map(|cell| value(person, cell / 3, cell % 3)).collect())
            .collect();
        let later = |level: usize, of: usize| {
            f64::from(u8::from(of == level)) - f64::from(u8::from(of == 0))
        };
        let contrast = |weight: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
            (0..9).map(|cell| weight(cell / 3, cell % 3)).collect()
        };
        let mut of = [Vec::new(), Vec::new(), Vec::new()];
        for one in 1..3 {
            of[0].push(contrast(&|v, _| later(one, v) / 3.0));
            of[1].push(contrast(&|_, h| later(one, h) / 3.0));
            for other in 1..3 {
                of[2].push(contrast(&|v, h| later(one, v) * later(other, h)));
            }
        }
        for (contrasts, df, f, epsilon, p) in [
            (&of[0], [2.0, 58.0], 395.4723939, 0.5969260076, 1.444004626e-21),
            (&of[1], [2.0, 58.0], 1206.650916, 0.704480785, 1.62934029e-34),
            (&of[2], [4.0, 116.0], 84.6593081, 0.7966493684, 3.612118049e-27),
        ] {
            let found = effect(&table, contrasts).unwrap();
            let FTest { df_num, df_den, .. } = found.test;
            assert!((df_num - df[0]).abs() + (df_den - df[1]).abs() < 1e-9, "{found:?}");
            assert!((found.test.statistic / f - 1.0).abs() < 1e-9, "{found:?}");
            assert!((found.greenhouse_geisser / epsilon - 1.0).abs() < 1e-9, "{found:?}");
            assert!((found.p_greenhouse_geisser / p - 1.0).abs() < 1e-7, "{found:?}");
        }
        // One contrast more than the effect has degrees of freedom adds nothing.
        let more = [&of[0][..], &[contrast(&|v, _| later(2, v) - later(1, v))]].concat();
        assert_eq!(effect(&table, &more).unwrap().test.df_num.to_bits(), 2.0_f64.to_bits());
        assert!(effect(&table, &[vec![0.0; 9]]).is_err());
        assert!(effect(&[vec![1.0; 9], vec![2.0; 8]], &of[0]).is_err(), "rows of two lengths");
        // Effects that everybody has alike, or not at all, have no error, although rounding leaves some.
        let added =
            |person: u64, cell: u64| (person + 2 * (cell / 3) + 3 * (cell % 3)) as f64 / 7.0;
        let alike: Vec<Vec<f64>> =
            (1..=5).map(|person| (0..9).map(|cell| added(person, cell)).collect()).collect();
        assert!(of.iter().all(|contrasts| effect(&alike, contrasts).is_err()));
    }
}
