//! Power of a planned comparison of whole curves, by simulating people's curves of differences and testing them as
//! real ones are.

use crate::bootstrap::stream;
use crate::curve::differences;
use crate::error::{all_finite, check_level, same_length};
use crate::null::Sampling;
use crate::power::{Power, normal};
use crate::tested::{Unestimable, at_least};
use core::ops::RangeInclusive;
use rayon::prelude::*;
use zwidth_numerics::moments::Moments;

/// Flips of signs of a simulated study of more people than all are counted of, unless its level is so small that p
/// could hardly be below it; no more than a real study has, whose p is never smaller.
const DRAWS: RangeInclusive<usize> = 999..=9_999;

/// A planned study of whole curves.
#[derive(Debug, Clone, PartialEq)]
pub struct CurvePlan {
    /// Curves of differences of people who took part, a row each: simulated ones scatter about the true difference
    /// as these do about their mean.
    pub known: Vec<Vec<f64>>,
    /// Nodes of each branch.
    pub lengths: Vec<usize>,
    /// Where there is a true difference, node by node.
    pub differs: Vec<bool>,
    /// The true difference there, in the unit of the curves; elsewhere it is 0.
    pub difference: f64,
    /// Participants.
    pub participants: usize,
}

impl CurvePlan {
    /// Median over the nodes that differ, and where people scatter, of the standard error of participants' mean
    /// difference; 0 where they scatter nowhere.
    pub fn difference_std_error(&self) -> f64 {
        let nodes = (0..self.differs.len()).filter(|node| self.differs[*node]);
        let mut sds: Vec<f64> = nodes
            .filter_map(|node| {
                let column: Vec<f64> = self.known.iter().map(|row| row[node]).collect();
                Moments::of(&column).sd().filter(|sd| *sd > 0.0)
            })
            .collect();
        sds.sort_by(f64::total_cmp);
        sds.get(sds.len() / 2).map_or(0.0, |sd| sd / (self.participants as f64).sqrt())
    }
}

/// The share of `studies` simulated studies in which a difference is claimed somewhere, p being below `alpha`.
/// Everybody's curve is the true difference and a normal course with the covariance of the known people's curves: the
/// sum of their differences from their mean, each times a standard normal number over √(n − 1). Each study draws from
/// its own stream, keyed with the seed, so that the same seed draws the same people at any difference.
///
/// # Errors
/// Fewer than two known people, one participant, no study, rows of another length than their branches, values that are
/// not finite, `alpha` outside (0, 1).
pub fn curve_power(
    plan: &CurvePlan,
    alpha: f64,
    studies: usize,
    seed: u64,
) -> Result<Power, Unestimable> {
    let CurvePlan { known, lengths, differs, difference, participants } = plan;
    let nodes = lengths.iter().sum();
    check_level(1.0 - alpha)?;
    at_least("known participants", known.len(), 2)?;
    at_least("participants", *participants, 2)?;
    at_least("simulated studies", studies, 1)?;
    all_finite(&[*difference])?;
    same_length("nodes", nodes, differs.len())?;
    for row in known {
        same_length("nodes", nodes, row.len())?;
        all_finite(row)?;
    }
    let mean = |node: usize| known.iter().map(|row| row[node]).sum::<f64>() / known.len() as f64;
    let means: Vec<f64> = (0..nodes).map(mean).collect();
    let scale = 1.0 / ((known.len() - 1) as f64).sqrt();
    let draws = ((10.0 / alpha).ceil() as usize).clamp(*DRAWS.start(), *DRAWS.end());
    let claims = (0..studies as u64).into_par_iter().map(|study| {
        let mut rng = stream(seed, study);
        let curves = (0..*participants).map(|_| {
            let true_ones = differs.iter().map(|differs| if *differs { *difference } else { 0.0 });
            let mut curve: Vec<f64> = true_ones.collect();
            for row in known {
                let share = scale * normal(&mut rng);
                for ((value, own), mean) in curve.iter_mut().zip(row).zip(&means) {
                    *value += share * (own - mean);
                }
            }
            curve
        });
        let curves: Vec<Vec<f64>> = curves.collect();
        let tested = differences(&curves, lengths, 1.0 - alpha, Sampling { draws, seed: study });
        // A study without a test claims nothing.
        tested.is_ok_and(|test| test.p_claimed(*participants).is_some_and(|p| p < alpha))
    });
    Power::of(&claims.collect::<Vec<bool>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::power::{Plan, PlannedTest, Simulation, power};

    /// Known curves of one node of which everybody has another value, with a variance of 1.
    fn plan(difference: f64, participants: usize) -> CurvePlan {
        let values = [-1.5, -0.5, 0.5, 1.5].map(|value| vec![value * (3.0_f64 / 5.0).sqrt()]);
        CurvePlan {
            known: values.to_vec(),
            lengths: vec![1],
            differs: vec![true],
            difference,
            participants,
        }
    }

    /// Of one node it is the test by flips of single differences, whose power at 20 people is nearly that of t.
    #[test]
    fn the_power_of_a_curve_of_one_node_is_that_of_a_value() {
        let found = curve_power(&plan(0.6, 20), 0.05, 2000, 1).unwrap();
        let values = Plan {
            participant_sd: 0.0,
            interaction_sd: 0.5_f64.sqrt(),
            residual_sd: 0.0,
            repeats: 1,
            modes: 2,
            difference: 0.6,
            participants: 20,
        };
        let simulation =
            Simulation { test: PlannedTest::PairedT, alpha: 0.05, studies: 20_000, seed: 2 };
        let of_t = power(&values, &simulation).unwrap();
        assert!((found.estimate - of_t.estimate).abs() < 0.04, "{found:?} {of_t:?}");
        assert!((plan(0.6, 16).difference_std_error() - 0.25).abs() < 1e-12);
    }

    #[test]
    fn without_a_difference_it_is_no_more_than_alpha_and_with_a_large_one_all() {
        let none = curve_power(&plan(0.0, 8), 0.05, 2000, 3).unwrap();
        assert!(none.ci_low < 0.05, "{none:?}");
        assert!(curve_power(&plan(50.0, 8), 0.05, 100, 3).unwrap().estimate > 0.99);
        // With five people nothing is claimed, however large it is; nor where no flip reaches the level.
        assert_eq!(curve_power(&plan(50.0, 5), 0.05, 100, 3).unwrap().claims, 0);
        assert_eq!(curve_power(&plan(50.0, 6), 0.02, 100, 3).unwrap().claims, 0);
    }

    #[test]
    fn a_difference_in_few_nodes_is_found_less_often_and_always_by_the_same_studies() {
        let wave =
            |person: f64, node: f64| (0.3 * node + person).sin() + (0.1 * node * person).cos();
        let known =
            (1..=7).map(|who| (0..30).map(|node| wave(f64::from(who), f64::from(node))).collect());
        let of_part = |nodes: usize| CurvePlan {
            known: known.clone().collect(),
            lengths: vec![20, 10],
            differs: (0..30).map(|node| node < nodes).collect(),
            difference: 0.8,
            participants: 10,
        };
        let [all, few] = [30, 4].map(|nodes| curve_power(&of_part(nodes), 0.05, 300, 4).unwrap());
        assert!(all.estimate > few.estimate + 0.1, "{all:?} {few:?}");
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| curve_power(&of_part(30), 0.05, 300, 4).unwrap())
        };
        assert_eq!(on(1), on(3));
        let other = CurvePlan { lengths: vec![29], ..of_part(30) };
        assert!(curve_power(&other, 0.05, 300, 4).is_err());
        assert!(curve_power(&of_part(30), 0.0, 300, 4).is_err());
    }
}
