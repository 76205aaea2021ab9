//! The model: sigmoids, what γ is, and the two numbers that a curve is read for.

use core::f64::consts::{FRAC_1_SQRT_2, LN_2, PI};

use crate::logistic::softplus_and_share;

/// The standard normal quantile of ¾ (Abramowitz & Stegun 1964, table 26.1).
pub(super) const NORMAL_QUARTILE: f64 = 0.674_489_750_196_081_7;
/// ln 3, the logistic quantile of ¾.
const LOGISTIC_QUARTILE: f64 = 1.098_612_288_668_109_8;
/// ln(4/3) / ln 2: Weibull levels at F = ¼ and F = ½ are in this ratio to the power of the scale.
const WEIBULL_QUARTER: f64 = 0.415_037_499_278_843_8;
/// ln ln 2, where F of the Weibull sigmoid is ½.
const WEIBULL_HALF: f64 = -0.366_512_920_581_664_3;

/// The shape of F.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sigmoid {
    /// The normal distribution function of (x − m)/σ. Its JND is 0.6745 σ.
    Norm,
    /// 1/(1 + e^(−z)) of z = (x − m)/σ. Its JND is ln 3 σ.
    Logistic,
    /// 1 − e^(−(x/α)^β), for levels from 0 on; here with m = ln α and σ = 1/β, so that F = 1 − e^(−e^z) of
    /// z = (ln x − m)/σ. At 0 it is 0.
    Weibull,
}

/// F at one place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shares {
    /// F.
    pub(super) below: f64,
    /// 1 − F, with its own digits.
    pub(super) above: f64,
    /// dF/dz.
    pub(super) density: f64,
}

impl Shares {
    /// ψ and 1 − ψ, each with its own digits.
    pub(super) fn answers(self, guess: f64, lapse: f64) -> [f64; 2] {
        [
            guess * self.above + (1.0 - lapse) * self.below,
            lapse * self.below + (1.0 - guess) * self.above,
        ]
    }
}

impl Sigmoid {
    /// What the sigmoid is symmetrical or steep in: x, or ln x of Weibull's.
    pub(super) fn coordinate(self, level: f64) -> f64 {
        if self == Self::Weibull { libm::log(level) } else { level }
    }

    /// The level of a coordinate.
    pub(super) fn level(self, coordinate: f64) -> f64 {
        if self == Self::Weibull { libm::exp(coordinate) } else { coordinate }
    }

    /// F, 1 − F and their slope at z.
    pub(super) fn shares(self, z: f64) -> Shares {
        match self {
            Self::Norm => Shares {
                below: 0.5 * libm::erfc(-z * FRAC_1_SQRT_2),
                above: 0.5 * libm::erfc(z * FRAC_1_SQRT_2),
                density: libm::exp(-0.5 * z * z) / libm::sqrt(2.0 * PI),
            },
            Self::Logistic => {
                let (below, above) = (softplus_and_share(z).1, softplus_and_share(-z).1);
                Shares { below, above, density: below * above }
            }
            Self::Weibull => {
                let hazard = libm::exp(z);
                let above = libm::exp(-hazard);
                // Far out the hazard is infinite, where the share above is 0.
                let density = if above > 0.0 { hazard * above } else { 0.0 };
                Shares { below: -libm::expm1(-hazard), above, density }
            }
        }
    }

    /// z at F = ½.
    pub(super) fn middle(self) -> f64 {
        if self == Self::Weibull { WEIBULL_HALF } else { 0.0 }
    }

    /// The JND of a curve with this scale, and its derivative by the scale. Weibull's JND is proportional to the
    /// threshold, and given as a share of it.
    pub(super) fn jnd_and_slope(self, scale: f64) -> (f64, f64) {
        match self {
            Self::Norm => (NORMAL_QUARTILE * scale, NORMAL_QUARTILE),
            Self::Logistic => (LOGISTIC_QUARTILE * scale, LOGISTIC_QUARTILE),
            Self::Weibull => {
                // x(F = ¾) and x(F = ¼) as shares of x(F = ½); expm1, because both are near 1 for small scales.
                let quarter = libm::log(WEIBULL_QUARTER);
                let spread = libm::expm1(scale * LN_2) - libm::expm1(scale * quarter);
                let slope = LN_2 * libm::exp(scale * LN_2) - quarter * libm::exp(scale * quarter);
                (spread / 2.0, slope / 2.0)
            }
        }
    }
}

/// What was asked, which decides about γ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Asks {
    /// Which of two was more, or whether one was more than the standard: a lapse is as often one answer as the other,
    /// so γ = λ.
    WhichWasMore,
    /// Which of two had the stimulus, right or wrong: γ = ½.
    RightOrWrong,
    /// Whether there was a stimulus: γ is free from 0 to ½, and known from trials without one.
    YesNo,
}

/// A psychometric function.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Curve {
    /// Its shape.
    pub sigmoid: Sigmoid,
    /// m, in the unit of the stimulus; ln α for Weibull's.
    pub location: f64,
    /// σ, above 0, in the unit of the stimulus; 1/β for Weibull's.
    pub scale: f64,
    /// γ, the lowest share of positive answers.
    pub guess: f64,
    /// λ: the highest share is 1 − λ.
    pub lapse: f64,
}

impl Curve {
    /// ψ: the share of positive answers at a level.
    pub fn share(&self, level: f64) -> f64 {
        self.shares(level)[0]
    }

    /// ψ and 1 − ψ at a level, each with its own digits.
    pub(super) fn shares(&self, level: f64) -> [f64; 2] {
        let z = (self.sigmoid.coordinate(level) - self.location) / self.scale;
        self.sigmoid.shares(z).answers(self.guess, self.lapse)
    }

    /// The level at F = ½ (the PSE of "which was more"), in the unit of the stimulus.
    pub fn threshold(&self) -> f64 {
        self.sigmoid.level(self.location + self.scale * self.sigmoid.middle())
    }

    /// Half of x(F = ¾) − x(F = ¼), in the unit of the stimulus.
    pub fn jnd(&self) -> f64 {
        let jnd = self.sigmoid.jnd_and_slope(self.scale).0;
        if self.sigmoid == Sigmoid::Weibull { self.threshold() * jnd } else { jnd }
    }

    /// The JND over the standard; `None` of a standard that is not above 0.
    pub fn weber_fraction(&self, standard: f64) -> Option<f64> {
        (standard > 0.0).then(|| self.jnd() / standard)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIGMOIDS: [Sigmoid; 3] = [Sigmoid::Norm, Sigmoid::Logistic, Sigmoid::Weibull];

    fn curve(sigmoid: Sigmoid) -> Curve {
        Curve { sigmoid, location: 0.4, scale: 0.3, guess: 0.0, lapse: 0.0 }
    }

    /// The level where F has a value, by halving: the definition, and no formula of the product.
    fn level_at(curve: &Curve, share: f64) -> f64 {
        let (mut low, mut high) = (1e-6, 20.0);
        for _ in 0..100 {
            let middle = (low + high) / 2.0;
            if curve.share(middle) < share { low = middle } else { high = middle }
        }
        low
    }

    #[test]
    fn thresholds_and_jnds_are_distances_along_the_curve() {
        for sigmoid in SIGMOIDS {
            let curve = curve(sigmoid);
            assert!((curve.threshold() - level_at(&curve, 0.5)).abs() < 1e-12, "{sigmoid:?}");
            let jnd = (level_at(&curve, 0.75) - level_at(&curve, 0.25)) / 2.0;
            assert!((curve.jnd() - jnd).abs() < 1e-12, "{sigmoid:?}");
            assert!((curve.weber_fraction(2.0).unwrap() - jnd / 2.0).abs() < 1e-12);
            assert_eq!(curve.weber_fraction(0.0), None);
        }
    }

    /// SciPy: `norm.cdf(1.2)`, `expit(1.2)`, `weibull_min.cdf(x, β, scale=α)`.
    #[test]
    fn shares_are_those_of_scipy() {
        let curve =
            |sigmoid, location, scale| Curve { sigmoid, location, scale, guess: 0.1, lapse: 0.02 };
        let share = |f: f64| 0.1 + 0.88 * f;
        let norm = curve(Sigmoid::Norm, 1.0, 2.0).share(3.4);
        assert!((norm - share(0.884_930_329_778_291_8)).abs() < 1e-15);
        let logistic = curve(Sigmoid::Logistic, 1.0, 2.0).share(3.4);
        assert!((logistic - share(0.768_524_783_499_017_7)).abs() < 1e-15);
        // α = 0.08, β = 2: 1 − exp(−(0.06/0.08)²)
        let weibull = curve(Sigmoid::Weibull, libm::log(0.08), 0.5);
        assert!((weibull.share(0.06) - share(0.430_217_175_269_077)).abs() < 1e-14);
        assert!((weibull.share(0.0) - 0.1).abs() < 1e-16);
    }

    #[test]
    fn both_shares_keep_their_digits() {
        let curve = Curve { guess: 0.5, ..curve(Sigmoid::Norm) };
        let [share, rest] = curve.shares(0.4 + 0.3 * 9.0);
        assert!((share - 1.0).abs() < 1e-15);
        // SciPy: half of `norm.sf(9)`.
        assert!((rest / 5.642_942_029_769_211e-20 - 1.0).abs() < 1e-12, "{rest}");
    }

    #[test]
    fn slopes_agree_with_differences_and_both_tails_keep_their_digits() {
        for sigmoid in SIGMOIDS {
            for z in [-3.0, -0.2, 0.4, 1.1] {
                let (low, high) = (sigmoid.shares(z - 1e-5), sigmoid.shares(z + 1e-5));
                let slope = (high.below - low.below) / 2e-5;
                assert!((slope - sigmoid.shares(z).density).abs() < 1e-9, "{sigmoid:?} {z}");
                let shares = sigmoid.shares(z);
                assert!((shares.below + shares.above - 1.0).abs() < 1e-15);
            }
            let (low, high) = (sigmoid.shares(-20.0), sigmoid.shares(3.6));
            assert!(low.below > 0.0 && high.above > 0.0, "{sigmoid:?}");
            let ends = [sigmoid.shares(-1e300), sigmoid.shares(1e300)];
            assert!(ends.iter().all(|s| s.density == 0.0 && s.below.is_finite()), "{ends:?}");
            for scale in [0.01, 0.3, 2.0] {
                let jnd = |scale: f64| sigmoid.jnd_and_slope(scale).0;
                let slope = (jnd(scale + 1e-6) - jnd(scale - 1e-6)) / 2e-6;
                assert!((slope - sigmoid.jnd_and_slope(scale).1).abs() < 1e-8);
            }
        }
    }
}
