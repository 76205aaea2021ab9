//! The answers of one cell as a function of its linear predictor η.
//!
//! The odds of an answer above threshold j are e^(η − θⱼ) = e^η e^(−θⱼ): one exponential per η
//! serves all thresholds. With F = 1 / (1 + odds) and z = θⱼ − η the terms of
//! [`crate::logistic`] are nⱼ z − Nⱼ (z + ln(1 + odds)).

use super::model::Cells;
use super::point::Point;
use zwidth_numerics::dense::dot;

/// A threshold or predictor farther out counts as if it were here: the odds are 10^±130, and the
/// products of two of them finite. Only steps of a search that are taken back go there.
const FARTHEST: f64 = 300.0;
/// e^±[`FARTHEST`].
const FARTHEST_ODDS: f64 = 1.942_426_395_241_255_8e130;
const NEAREST_ODDS: f64 = 1.0 / FARTHEST_ODDS;

/// The thresholds with their odds at η = 0.
#[derive(Debug, Clone)]
pub(super) struct Levels {
    theta: Vec<f64>,
    odds: Vec<f64>,
}

/// Value, slope and bend by η.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Slopes {
    /// ln P(answers), but for the widths of inner categories.
    pub(super) value: f64,
    /// d ln P / dη.
    pub(super) slope: f64,
    /// −d² ln P / dη².
    pub(super) bend: f64,
}

impl Slopes {
    pub(super) fn add(&mut self, other: Self) {
        self.value += other.value;
        self.slope += other.slope;
        self.bend += other.bend;
    }
}

impl Levels {
    pub(super) fn new(theta: &[f64]) -> Self {
        let theta: Vec<f64> = theta.iter().map(|theta| near(*theta)).collect();
        Self { odds: theta.iter().map(|theta| libm::exp(-theta)).collect(), theta }
    }

    pub(super) fn thresholds(&self) -> usize {
        self.theta.len()
    }

    /// F(θⱼ − η), threshold by threshold.
    pub(super) fn shares(&self, eta: f64) -> impl Iterator<Item = f64> {
        let lift = libm::exp(near(eta));
        self.odds.iter().map(move |odds| 1.0 / (1.0 + lift * odds))
    }

    /// P(answers) of one cell (without the widths of inner categories), of e^η at many places: no logarithm and no
    /// exponential, at the price that many answers leave the range of numbers and give 0. With F = 1 / (1 + odds) it
    /// is Π Fⱼ^nⱼ (1 − Fⱼ)^(Nⱼ − nⱼ), where nⱼ of Nⱼ answers next to the threshold lie below it. `shares` are
    /// multiplied with it, place by place; nⱼ − Nⱼ F is pushed for each threshold next to which there are answers,
    /// as by `slopes`.
    pub(super) fn multiply_by_probability(
        &self,
        cells: &Cells,
        cell: usize,
        lifts: &[f64],
        shares: &mut [f64],
        residuals: &mut Vec<Residual>,
    ) {
        let (below, beside) = (&cells.below[cell], &cells.beside[cell]);
        let thresholds: Vec<usize> = (0..self.odds.len()).filter(|j| beside[*j] > 0.0).collect();
        let first = residuals.len();
        residuals.extend(thresholds.iter().map(|j| Residual {
            cell,
            threshold: *j,
            places: Vec::with_capacity(lifts.len() + LANES),
        }));
        for (lifts, shares) in lifts.chunks(LANES).zip(shares.chunks_mut(LANES)) {
            let mut lanes = [1.0; LANES];
            lanes[..lifts.len()].copy_from_slice(lifts);
            let lifts = lanes.map(|lift| lift.clamp(NEAREST_ODDS, FARTHEST_ODDS));
            let mut product = [1.0; LANES];
            for (residual, j) in residuals[first..].iter_mut().zip(&thresholds) {
                let odds = lifts.map(|lift| lift * self.odds[*j]);
                let share = odds.map(|odds| 1.0 / (1.0 + odds));
                let above = std::array::from_fn(|lane| odds[lane] * share[lane]);
                // Counts are whole numbers, and exact as such.
                let ways =
                    [power(share, below[*j] as u32), power(above, (beside[*j] - below[*j]) as u32)];
                for lane in 0..LANES {
                    product[lane] *= ways[0][lane] * ways[1][lane];
                }
                residual.places.extend(share.map(|share| below[*j] - beside[*j] * share));
            }
            shares.iter_mut().zip(product).for_each(|(share, product)| *share *= product);
        }
        residuals[first..].iter_mut().for_each(|own| own.places.truncate(lifts.len()));
    }

    /// The terms of one cell. If there are `residuals`, nⱼ − Nⱼ F is pushed per threshold: the
    /// derivatives by the thresholds.
    pub(super) fn slopes(
        &self,
        cells: &Cells,
        cell: usize,
        eta: f64,
        mut residuals: Option<&mut Vec<f64>>,
    ) -> Slopes {
        let eta = near(eta);
        let lift = libm::exp(eta);
        let mut sum = Slopes::default();
        let counts = cells.below[cell].iter().zip(&cells.beside[cell]);
        for ((theta, odds), (below, beside)) in self.theta.iter().zip(&self.odds).zip(counts) {
            let odds = lift * odds;
            let share = 1.0 / (1.0 + odds);
            // Most cells have answers next to few thresholds: this spares the other logarithms.
            if *beside > 0.0 {
                let z = theta - eta;
                sum.value += below * z - beside * (z + libm::log(1.0 + odds));
                sum.slope += beside * share - below;
                sum.bend += beside * share * odds * share;
            }
            if let Some(residuals) = residuals.as_deref_mut() {
                residuals.push(below - beside * share);
            }
        }
        sum
    }
}

/// Places that are gone through side by side.
const LANES: usize = 8;

/// nⱼ − Nⱼ F of one cell and threshold, place by place.
#[derive(Debug, Clone)]
pub(super) struct Residual {
    pub(super) cell: usize,
    pub(super) threshold: usize,
    pub(super) places: Vec<f64>,
}

/// Each xⁿ by squares: the same bits on any machine.
fn power(mut x: [f64; LANES], mut n: u32) -> [f64; LANES] {
    let mut product = [1.0; LANES];
    while n > 0 {
        if n & 1 == 1 {
            product.iter_mut().zip(&x).for_each(|(product, x)| *product *= x);
        }
        x.iter_mut().for_each(|x| *x *= *x);
        n >>= 1;
    }
    product
}

/// A logit, moved to the farthest that counts.
pub(super) fn near(logit: f64) -> f64 {
    logit.clamp(-FARTHEST, FARTHEST)
}

/// xβ of each cell.
pub(super) fn fixed(cells: &Cells, point: &Point) -> Vec<f64> {
    cells.x.iter().map(|x| dot(x, &point.beta)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::logistic::softplus_and_share;

    /// A mode's only cell.
    fn cell(below: &[f64], beside: &[f64]) -> Cells {
        let groups = std::iter::once(0..1).collect();
        Cells {
            groups,
            x: vec![vec![]],
            below: vec![below.to_vec()],
            beside: vec![beside.to_vec()],
        }
    }

    #[test]
    fn the_terms_of_a_cell_are_those_of_the_logistic_model() {
        let cells = cell(&[2.0, 1.0, 4.0], &[3.0, 5.0, 7.0]);
        let theta = [-1.5, 0.25, 3.0];
        for eta in [-40.0, -2.0, 0.0, 0.7, 35.0] {
            let mut residuals = Vec::new();
            let found = Levels::new(&theta).slopes(&cells, 0, eta, Some(&mut residuals));
            let mut expect = Slopes::default();
            for (j, theta) in theta.iter().enumerate() {
                let (below, beside) = (cells.below[0][j], cells.beside[0][j]);
                let (softplus, share) = softplus_and_share(theta - eta);
                expect.value += below * (theta - eta) - beside * softplus;
                expect.slope += beside * share - below;
                expect.bend += beside * share * (1.0 - share);
                assert!((residuals[j] - below + beside * share).abs() < 1e-14);
                let shares: Vec<f64> = Levels::new(&[*theta]).shares(eta).collect();
                assert!((shares[0] - share).abs() < 1e-15);
            }
            let (mut again, mut shares) = (Vec::new(), [1.0; LANES + 1]);
            let levels = Levels::new(&theta);
            let lifts = [libm::exp(eta); LANES + 1];
            levels.multiply_by_probability(&cells, 0, &lifts, &mut shares, &mut again);
            let probability = shares[LANES];
            let error = (libm::log(probability) - expect.value).abs();
            assert!(error < 1e-13 * (1.0 + expect.value.abs()), "{error}");
            assert_eq!(again.len(), theta.len());
            for (own, residual) in again.iter().zip(&residuals) {
                assert_eq!(own.places.len(), lifts.len());
                assert!((own.places[LANES] - residual).abs() < 1e-14);
            }
            assert!((found.value - expect.value).abs() < 1e-13 * (1.0 + expect.value.abs()));
            assert!((found.slope - expect.slope).abs() < 1e-14);
            assert!((found.bend - expect.bend).abs() < 1e-14);
        }
    }

    #[test]
    fn no_logit_is_too_far_out_for_a_number() {
        let cells = cell(&[2.0], &[3.0]);
        for (theta, eta) in [(-1e9, 1e9), (1e9, -1e9), (1e300, 1e300)] {
            let found = Levels::new(&[theta]).slopes(&cells, 0, eta, None);
            assert!(found.value.is_finite() && found.slope.is_finite() && found.bend >= 0.0);
            assert!(found.value <= 0.0, "{found:?}");
            let (lifts, mut shares) = ([libm::exp(near(eta))], [1.0]);
            let levels = Levels::new(&[theta]);
            levels.multiply_by_probability(&cells, 0, &lifts, &mut shares, &mut Vec::new());
            assert!((0.0..=1.0).contains(&shares[0]), "{shares:?}");
        }
    }
}
