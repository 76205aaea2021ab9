//! Effect sizes of a paired difference: d_z, in standard deviations of the differences, and d_av,
//! in standard deviations of people within a mode; each also as Hedges' g, without its bias in
//! small samples.

use crate::error::{all_finite, check_level};
use crate::paired::{self, ROUNDINGS};
use crate::{Tested, Unestimable};
use core::f64::consts::SQRT_2;
use zwidth_numerics::moments::Moments;

/// A standardised difference. No unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effect {
    /// The estimate d, which is too large on average where people are few.
    pub d: f64,
    /// g = d J(ν), without that bias: J(ν) = Γ(ν/2) / (Γ((ν − 1)/2) √(ν/2)) (Hedges 1981, J. Educ.
    /// Stat. 6:107); `None` for ν ≤ 1.
    pub g: Option<f64>,
    /// The interval of d, from the noncentral t distribution of the contrast's t (Steiger & Fouladi
    /// 1997); `None` where the differences have no t.
    pub interval: Option<[f64; 2]>,
}

/// d_z of `pairs` [A, B]: d̄ / s_d, with the interval at confidence `level`; ν = n − 1.
///
/// # Errors
/// As [`paired::mean_difference`].
pub fn d_z(pairs: &[[f64; 2]], level: f64) -> Result<Effect, Unestimable> {
    let tested = paired::mean_difference(&paired::differences(pairs), level)?;
    let root_n = (pairs.len() as f64).sqrt();
    let interval = noncentrality(&tested, level).map(|end| end / root_n);
    let d = tested.statistic / root_n;
    Ok(Effect { d, g: unbiased(d, tested.df), interval: Some(interval) })
}

/// d_av of `pairs` [A, B]: (Ā − B̄) / s_av with s_av² = (s²_A + s²_B) / 2 (Cumming 2012, *Understanding
/// the New Statistics*, eq. 11.9), with the interval at confidence `level`. For g, ν = (n − 1)
/// (s²_A + s²_B)² / (s⁴_A + s⁴_B + 2 cov²): the degrees of freedom of s²_av, whose two terms belong
/// to the same people.
///
/// # Errors
/// Fewer than two pairs; participants who do not differ in either mode; a value that is not finite;
/// `level` outside (0, 1).
pub fn d_av(pairs: &[[f64; 2]], level: f64) -> Result<Effect, Unestimable> {
    check_level(level)?;
    let [a, b] = [0, 1].map(|side| pairs.iter().map(|pair| pair[side]).collect::<Vec<f64>>());
    all_finite(&a)?;
    all_finite(&b)?;
    let [of_a, of_b] = [&a, &b].map(|values| Moments::of(values));
    let (Some(sd_a), Some(sd_b)) = (of_a.sd(), of_b.sd()) else {
        return Err(Unestimable::TooFew { units: "participants", found: pairs.len(), needed: 2 });
    };
    let scatter = libm::hypot(sd_a, sd_b) / SQRT_2;
    if scatter <= ROUNDINGS * f64::EPSILON * of_a.mean.abs().max(of_b.mean.abs()) {
        return Err(Unestimable::Constant { units: "participants' means within each mode" });
    }
    let d = (of_a.mean - of_b.mean) / scatter;

    let spare = (pairs.len() - 1) as f64;
    // In units of 2 s²_av: fourth powers of small values would be 0.
    let [share_a, share_b] = [sd_a / scatter, sd_b / scatter].map(|share| share * share / 2.0);
    let products =
        pairs.iter().map(|[a, b]| (a - of_a.mean) / scatter * ((b - of_b.mean) / scatter));
    let covariance = products.sum::<f64>() / spare / 2.0;
    let squares = share_a * share_a + share_b * share_b + 2.0 * covariance * covariance;
    let df = spare * (share_a + share_b).powi(2) / squares;

    // Differences that are all equal have no t, and d_av has a value nevertheless.
    let tested = paired::mean_difference(&paired::differences(pairs), level).ok();
    let interval = tested
        .map(|tested| noncentrality(&tested, level).map(|end| end * tested.std_error / scatter));
    Ok(Effect { d, g: unbiased(d, df), interval })
}

/// A tested difference in units of `scatter`, whose variance has `df` degrees of freedom.
pub(crate) fn standardised(tested: &Tested, scatter: f64, df: f64, level: f64) -> Effect {
    let d = tested.estimate / scatter;
    let interval = noncentrality(tested, level).map(|end| end * tested.std_error / scatter);
    Effect { d, g: unbiased(d, df), interval: Some(interval) }
}

/// Hedges' g of `d`; see [`Effect::g`].
fn unbiased(d: f64, df: f64) -> Option<f64> {
    /// Of two people ν is 1, and their covariance leaves its rounding.
    const MORE_THAN_ONE: f64 = 1.0 + 1e-9;
    (df > MORE_THAN_ONE).then(|| {
        let log_ratio = libm::lgamma(df / 2.0) - libm::lgamma((df - 1.0) / 2.0);
        d * libm::exp(log_ratio) / (df / 2.0).sqrt()
    })
}

/// The noncentralities λ between which the observed t lies within the middle `level` of the
/// noncentral t distribution.
fn noncentrality(tested: &Tested, level: f64) -> [f64; 2] {
    /// From here on λ / t no longer depends on t, to 1e-4 of the interval's width.
    const LARGE: f64 = 1000.0;
    let beyond = (tested.statistic.abs() / LARGE).max(1.0);
    let t = tested.statistic / beyond;
    let noncentral = NoncentralT::new(t, tested.df);
    // P(T ≤ t) falls as λ grows.
    [f64::midpoint(1.0, level), f64::midpoint(1.0, -level)].map(|share| {
        let reach = 10.0 + 10.0 * t.abs();
        let mut low = t - reach;
        let mut high = t + reach;
        while high - low > 1e-10 * high.abs().max(low.abs()).max(1.0) {
            let middle = f64::midpoint(low, high);
            match noncentral.below(middle) > share {
                true => low = middle,
                false => high = middle,
            }
        }
        beyond * f64::midpoint(low, high)
    })
}

/// P(T ≤ t) of the noncentral t distribution, T = (Z + λ) / S with S² = χ²_ν / ν, as a function of
/// λ: E Φ(t S − λ), the sum over a lattice of ln S, which converges faster than any power of its
/// step (Trefethen & Weideman 2014, SIAM Review 56:385).
struct NoncentralT {
    /// t S and its share, node by node.
    nodes: Vec<[f64; 2]>,
}

impl NoncentralT {
    fn new(t: f64, df: f64) -> Self {
        /// Density, against its largest, that no longer counts: exp of this.
        const NOTHING: f64 = -40.0;
        let step = (0.1 / df.max(1.0).sqrt()).min(0.2 / t.abs().max(1.0));
        let mut nodes = Vec::new();
        // 0 is on the right side alone.
        for (sign, first) in [(1.0, 0_u32), (-1.0, 1)] {
            for i in first.. {
                let u = sign * f64::from(i) * step;
                let log_density = df * (u - (libm::exp(2.0 * u) - 1.0) / 2.0);
                if log_density.is_nan() || log_density <= NOTHING {
                    break;
                }
                nodes.push([t * libm::exp(u), libm::exp(log_density)]);
            }
        }
        let all: f64 = nodes.iter().map(|[_, share]| share).sum();
        nodes.iter_mut().for_each(|[_, share]| *share /= all);
        Self { nodes }
    }

    /// P(T ≤ t) at a noncentrality λ.
    fn below(&self, noncentrality: f64) -> f64 {
        let shares = self.nodes.iter().map(|[x, share]| {
            let x = x - noncentrality;
            share * (libm::erfc(-x / SQRT_2) / 2.0)
        });
        shares.sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: f64, expected: f64) {
        assert!((found - expected).abs() <= 1e-8 * expected.abs(), "{found} {expected}");
    }

    const PAIRS: [[f64; 2]; 6] =
        [[5.1, 4.6], [4.8, 4.9], [6.2, 5.1], [5.5, 5.2], [4.9, 4.1], [6.0, 5.6]];

    /// SciPy 1.17: `brentq(lambda l: nct.cdf(t, 5, l) - p, ...)`.
    #[test]
    fn effects_and_their_intervals_are_those_of_the_noncentral_t() {
        let d_z = d_z(&PAIRS, 0.95).unwrap();
        near(d_z.d, 1.205_607_055_426_029_4);
        near(d_z.g.unwrap(), 1.013_612_543_413_54);
        let [low, high] = d_z.interval.unwrap();
        near(low, 0.095_464_264_839_904_5);
        near(high, 2.255_881_609_612_531);
        let d_av = d_av(&PAIRS, 0.95).unwrap();
        near(d_av.d, 0.904_369_617_839_224_8);
        near(d_av.g.unwrap(), 0.795_728_350_204_743_3);
        let [low, high] = d_av.interval.unwrap();
        near(low, 0.071_611_210_569_814_1);
        near(high, 1.692_218_687_667_587_3);
    }

    /// SciPy 1.17: `nct.cdf(t, df, l)`.
    #[test]
    fn the_noncentral_t_is_that_of_scipy() {
        for (t, df, noncentrality, expected) in [
            (2.0, 5.0, 1.5, 0.631_449_247_255_671_8),
            (-1.0, 1.0, 0.3, 0.173_057_675_890_274_15),
            (0.0, 3.0, 1.0, 0.158_655_253_931_457_07),
            (12.0, 11.0, 10.0, 0.730_898_557_455_129_2),
            (30.0, 2.0, 12.0, 0.851_500_568_541_863_3),
            (0.5, 200.0, -1.0, 0.933_051_224_578_822_7),
        ] {
            let found = NoncentralT::new(t, df).below(noncentrality);
            assert!((found - expected).abs() < 1e-11, "{t} {df} {noncentrality}: {found}");
        }
    }

    #[test]
    fn differences_of_one_value_have_no_interval_and_two_people_no_g() {
        let constant = d_av(&[[2.0, 1.0], [3.0, 2.0], [5.0, 4.0]], 0.95).unwrap();
        assert!(constant.interval.is_none() && constant.g.unwrap() < constant.d);
        assert!(d_z(&[[2.0, 1.0], [4.0, 2.0]], 0.95).unwrap().g.is_none());
        let two = [[6.604742914038921, 7.328893968625454], [6.634081964843192, 7.2033464743174225]];
        assert!(d_av(&two, 0.95).unwrap().g.is_none());
        assert!(d_av(&[[1.0, 2.0], [f64::INFINITY, 1.0]], 0.95).is_err());
        assert!(matches!(d_av(&[[2.0, 1.0]], 0.95), Err(Unestimable::TooFew { found: 1, .. })));
        assert!(matches!(d_av(&[[2.0, 1.0]; 4], 0.95), Err(Unestimable::Constant { .. })));
    }

    #[test]
    fn a_huge_t_has_an_interval_about_it() {
        let pairs = PAIRS.map(|[a, b]| [1e5 + (a - b), 0.1 * b]);
        let Effect { d, interval: Some([low, high]), .. } = d_z(&pairs, 0.95).unwrap() else {
            panic!("no interval");
        };
        assert!(0.3 * d < low && low < d && d < high && high < 2.0 * d, "{low} {d} {high}");
    }
}
