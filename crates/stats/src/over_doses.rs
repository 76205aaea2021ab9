//! Somebody's own slope, or bend, over those levels of a dose that they have.

use zwidth_numerics::dense::dot;
use zwidth_study::OverDose;

/// Who lacks a level has a line over the others if it is at least this certain: the spread of their doses over that of all.
/// A line over a few near ones would count as much as any other, and scatter many times as far.
const LEAST_SPREAD: f64 = 0.5;

/// A coefficient of somebody's own line or parabola.
#[derive(Debug, Clone, PartialEq)]
pub struct OwnCoefficient {
    /// The means of the levels that they have, each with its weight.
    pub terms: Vec<Term>,
    /// Whether they lack a level.
    pub lacks_levels: bool,
}

/// A mean in a weighted sum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Term {
    /// Its weight, per step of the dose (of a bend its square).
    pub weight: f64,
    /// The mean, in the metric's unit.
    pub mean: f64,
}

/// A coefficient (1 the slope, 2 the bend) of the line, or parabola, by least squares over somebody's means of the levels, from the
/// lowest dose on; `None` stands for a level that they lack. None of who has too few for a line that could leave something, or
/// too near ones; and of who lacks any where the line bends, because the slope over some of the levels is another one than that
/// over all.
pub fn own_coefficient(
    over: &OverDose,
    coefficient: usize,
    means: &[Option<f64>],
) -> Option<OwnCoefficient> {
    let (places, means): (Vec<usize>, Vec<f64>) =
        means.iter().enumerate().filter_map(|(place, mean)| Some((place, (*mean)?))).unzip();
    let lacks_levels = places.len() < over.doses.len();
    let degree = usize::from(over.trend.degree);
    let weights = over.coefficient(&places, coefficient)?;
    if lacks_levels {
        // A sum of squared weights is the coefficient's variance over that of a level's mean.
        let all: Vec<usize> = (0..over.doses.len()).collect();
        let whole = over.coefficient(&all, coefficient)?;
        let is_near = dot(&whole, &whole) < LEAST_SPREAD * dot(&weights, &weights);
        if places.len() < degree + 2 || coefficient < degree || is_near {
            return None;
        }
    }
    let terms = weights.into_iter().zip(means).map(|(weight, mean)| Term { weight, mean });
    Some(OwnCoefficient { terms: terms.collect(), lacks_levels })
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_study::{DoseScale, Trend};

    fn over(degree: u8, doses: &[f64]) -> OverDose {
        OverDose {
            trend: Trend { degree, scale: DoseScale::Linear },
            doses: doses.to_vec(),
            unit: "1".to_owned(),
            levels: vec![Vec::new(); doses.len()],
        }
    }

    fn found(over: &OverDose, coefficient: usize, means: &[Option<f64>]) -> Option<(f64, bool)> {
        let own = own_coefficient(over, coefficient, means)?;
        Some((own.terms.iter().map(|term| term.weight * term.mean).sum(), own.lacks_levels))
    }

    #[test]
    fn a_slope_over_three_of_four_levels_is_the_same_and_over_two_or_near_ones_none() {
        let line = over(1, &[1.0, 2.0, 4.0, 8.0]);
        let means = [1.0, 2.0, 4.0, 8.0].map(|dose| Some(3.0 + 0.5 * dose));
        let without = |lacking: &[usize]| {
            let mut means = means;
            lacking.iter().for_each(|place| means[*place] = None);
            found(&line, 1, &means)
        };
        for (lacking, lacks) in [(&[][..], false), (&[2], true), (&[0], true)] {
            let (slope, said) = without(lacking).unwrap();
            assert!((slope - 0.5).abs() < 1e-12 && said == lacks, "{lacking:?}");
        }
        // Two levels leave nothing, and without the highest the others lie too near each other.
        assert_eq!((without(&[0, 1]), without(&[3])), (None, None));
    }

    #[test]
    fn where_a_line_bends_its_slope_takes_every_level_and_its_bend_four() {
        let parabola = over(2, &[1.0, 2.0, 3.0, 4.0, 5.0]);
        let mut means = [1.0, 2.0, 3.0, 4.0, 5.0].map(|dose: f64| Some(dose * dose));
        means[1] = None;
        assert_eq!(found(&parabola, 1, &means), None);
        let (bend, lacks) = found(&parabola, 2, &means).unwrap();
        assert!((bend - 1.0).abs() < 1e-12 && lacks);
        means[2] = None;
        assert_eq!(found(&parabola, 2, &means), None);
    }
}
