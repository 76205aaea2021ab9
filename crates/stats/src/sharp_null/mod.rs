//! Randomisation over the orders of trials: had the trials come in another order that the design
//! could have drawn, would the modes have differed as much?
//!
//! This tests the sharp null hypothesis that *no trial of anyone* depended on mode, carry-over
//! included. It does not test an average effect: if the effects of participants cancel, the sharp
//! null is false, and the test rejects it. Fisher (1935), *The Design of Experiments*; Edgington &
//! Onghena (2007), *Randomization Tests*.
//!
//! This crate knows no design: the caller redraws orders with the rules and the probabilities that
//! drew the actual one, all participants jointly.

use crate::Unestimable;
use crate::bootstrap::stream;
use crate::error::{StatsError, all_finite, same_length};
use crate::null::{Null, SAME, Sampling};
use crate::paired::difference;
use crate::tested::{at_least, not_constant};
use rand_chacha::rand_core::Rng;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// A statistic of an order that is large if modes differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Statistic {
    /// Mean of the first mode − mean of the second, in the unit of the values: extreme to either side.
    Difference(usize, usize),
    /// The sum of squares between modes, Σ n_m (mean_m − mean)², in the unit of the values squared.
    BetweenModes,
}

/// The values of trials, in whatever order; an order of a design says the mode of each. What no
/// order changes (the person, the session, the environment) is their block.
#[derive(Debug, Clone, PartialEq)]
pub struct Trials {
    /// The values, less the mean of their block: those that no order tells apart, together.
    together: Vec<Together>,
    /// Σ of the squares of these values.
    squares: f64,
    /// Number of modes.
    modes: usize,
    /// The mode of each of `together` as it was, from 0.
    actual: Vec<usize>,
}

/// Values that have one mode in every order.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Together {
    sum: f64,
    count: usize,
}

/// A test by randomisation over orders.
#[derive(Debug, Clone, PartialEq)]
pub struct Randomised {
    /// The statistic of the actual order.
    pub statistic: f64,
    /// p value of "no trial of anyone depended on mode".
    pub p_value: f64,
    /// The p value that the most extreme of the orders would have had: no data recorded in these
    /// values reach a smaller one.
    pub smallest_p: f64,
    /// The statistics of the orders at the middles of a hundred equal shares of them, from the least
    /// on: what an order is like under the hypothesis.
    pub percentiles: Vec<f64>,
    /// Whether all orders were counted or some drawn.
    pub null: Null,
}

impl Trials {
    /// Trials with their `values`, the number of the `block` of each, and the mode of each in the
    /// `actual` order, from 0 to `modes` − 1.
    ///
    /// Each value is taken from the mean of its block, which no order changes: differences between
    /// blocks then do not blur the modes if trials are missing, and nothing changes if none is
    /// missing. A trial without a value is left out here and from every order alike.
    ///
    /// # Errors
    /// No trial; a value that is not finite; lists of different lengths; a mode not below `modes`.
    pub fn new(
        values: &[f64],
        block: &[usize],
        actual: &[usize],
        modes: usize,
    ) -> Result<Trials, Unestimable> {
        all_finite(values)?;
        at_least("trials", values.len(), 1)?;
        same_length("the list of blocks", values.len(), block.len())?;
        check_order(actual, values.len(), modes)?;
        let mut blocks: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
        for (value, block) in values.iter().zip(block) {
            let (sum, count) = blocks.entry(*block).or_default();
            (*sum, *count) = (*sum + value, *count + 1.0);
        }
        let mut centred = Vec::with_capacity(values.len());
        for (value, block) in values.iter().zip(block) {
            let mean = blocks.get(block).map_or(0.0, |(sum, count)| sum / count);
            centred.push(difference(*value, mean));
        }
        Ok(Trials {
            squares: centred.iter().map(|value| value * value).sum(),
            together: centred.into_iter().map(|sum| Together { sum, count: 1 }).collect(),
            modes,
            actual: actual.to_vec(),
        })
    }

    /// The same trials, of which those with one number in `group` have one mode in every order that
    /// the design draws: participants who share their order, say. From here on an order is a list
    /// of the groups' modes, in the order of their numbers, and costs as much as there are groups.
    ///
    /// # Errors
    /// Not one number per trial; a trial with another actual mode than its group.
    pub fn moving_together(&self, group: &[usize]) -> Result<Trials, Unestimable> {
        same_length("the list of groups", self.together.len(), group.len())?;
        let mut groups: BTreeMap<usize, (Together, usize)> = BTreeMap::new();
        for (trial, group) in group.iter().enumerate() {
            let one = self.together[trial];
            let mode = self.actual[trial];
            let (all, of_group) = groups.entry(*group).or_insert((Together::default(), mode));
            if *of_group != mode {
                return Err(Unestimable::Refused(StatsError::Apart { trial }));
            }
            (all.sum, all.count) = (all.sum + one.sum, all.count + one.count);
        }
        let (together, actual) = groups.into_values().unzip();
        Ok(Trials { together, actual, ..*self })
    }

    /// p = (1 + orders at least as extreme) / (1 + orders drawn) for each of several statistics,
    /// where `redraw` gives the modes of the trials in the order that the design draws for a seed.
    /// Each order is drawn once for all of them.
    ///
    /// Orders are drawn on as many threads as there are and counted: one seed of `sampling`, one p
    /// value. Statistics that differ by less than 1e-9 of the largest possible count as equal. An
    /// order that leaves one of the tested modes without a value counts as extreme, which can only
    /// make p larger.
    ///
    /// There is no p of a mode without a trial in the actual order; of trials of one value only; of
    /// an order with another number of trials or with an unknown mode.
    pub fn each_against_drawn(
        &self,
        statistics: &[Statistic],
        sampling: Sampling,
        redraw: impl Fn(u64) -> Vec<usize> + Sync,
    ) -> Vec<Result<Randomised, Unestimable>> {
        let observed: Vec<_> =
            statistics.iter().map(|statistic| self.observed(*statistic)).collect();
        // Drawing takes long, and without an observed statistic it is for nothing.
        let draws = if observed.iter().any(Result::is_ok) { sampling.draws } else { 0 };
        let measured = (0..draws as u64).into_par_iter().map(|number| {
            let order = redraw(stream(sampling.seed, number).next_u64());
            check_order(&order, self.together.len(), self.modes)?;
            Ok(statistics.iter().map(|statistic| self.measure(*statistic, &order)).collect())
        });
        let drawn: Result<Vec<Vec<f64>>, StatsError> = measured.collect();
        let tests = observed.into_iter().enumerate().map(|(place, observed)| {
            let observed = observed?;
            let drawn = drawn.as_ref().map_err(Clone::clone)?;
            let drawn: Vec<f64> = drawn.iter().map(|values| values[place]).collect();
            Ok(self.sampled(statistics[place], observed, drawn))
        });
        tests.collect()
    }

    /// The test by the statistics of orders drawn. The actual order counts among them, so that p is
    /// never 0.
    fn sampled(&self, statistic: Statistic, observed: f64, drawn: Vec<f64>) -> Randomised {
        let most_extreme = largest(&drawn).max(observed.abs());
        let [p_value, smallest_p] = [observed, most_extreme].map(|value| {
            (1 + self.as_extreme(statistic, &drawn, value)) as f64 / (1 + drawn.len()) as f64
        });
        Randomised {
            statistic: observed,
            p_value,
            smallest_p,
            null: Null::Sampled { draws: drawn.len() },
            percentiles: percentiles(drawn),
        }
    }

    /// p = the share of `orders` at least as extreme, where `orders` are all that the design can
    /// draw, each as often as it is likely; the actual one is among them.
    ///
    /// # Errors
    /// Where [`Trials::each_against_drawn`] has no p; `orders` without the actual one.
    pub fn against_all(
        &self,
        statistic: Statistic,
        orders: &[Vec<usize>],
    ) -> Result<Randomised, Unestimable> {
        let observed = self.observed(statistic)?;
        orders.iter().try_for_each(|order| check_order(order, self.together.len(), self.modes))?;
        if !orders.contains(&self.actual) {
            return Err(Unestimable::Refused(StatsError::OrderNotAmong { orders: orders.len() }));
        }
        let all: Vec<f64> = orders.par_iter().map(|order| self.measure(statistic, order)).collect();
        let [p_value, smallest_p] = [observed, largest(&all)]
            .map(|value| self.as_extreme(statistic, &all, value) as f64 / all.len() as f64);
        Ok(Randomised {
            statistic: observed,
            p_value,
            smallest_p,
            null: Null::Exact,
            percentiles: percentiles(all),
        })
    }

    /// The statistic of the actual order.
    fn observed(&self, statistic: Statistic) -> Result<f64, Unestimable> {
        let tested: Vec<usize> = match statistic {
            Statistic::Difference(a, b) => vec![a, b],
            Statistic::BetweenModes => (0..self.modes).collect(),
        };
        if tested.iter().any(|mode| !self.actual.contains(mode)) {
            return Err(Unestimable::TooFew { units: "trials of a mode", found: 0, needed: 1 });
        }
        not_constant("trials of each participant", self.squares <= 0.0)?;
        Ok(self.measure(statistic, &self.actual))
    }

    /// The statistic of an order; infinite where a tested mode has no trial.
    fn measure(&self, statistic: Statistic, order: &[usize]) -> f64 {
        let mut sums = vec![0.0; self.modes];
        let mut counts = vec![0_usize; self.modes];
        for (together, mode) in self.together.iter().zip(order) {
            sums[*mode] += together.sum;
            counts[*mode] += together.count;
        }
        let mean = |mode: usize| match counts[mode] {
            0 => f64::INFINITY,
            count => sums[mode] / count as f64,
        };
        match statistic {
            Statistic::Difference(a, b) if counts[a] == 0 || counts[b] == 0 => f64::INFINITY,
            Statistic::Difference(a, b) => mean(a) - mean(b),
            // The mean of all is zero. A mode without a trial has an infinite one, which 0 trials
            // must not turn into NaN.
            Statistic::BetweenModes => {
                (0..self.modes).map(|mode| counts[mode].max(1) as f64 * mean(mode).powi(2)).sum()
            }
        }
    }

    /// How many of `statistics` are as far from zero as `value` or farther, to rounding.
    fn as_extreme(&self, statistic: Statistic, statistics: &[f64], value: f64) -> usize {
        let possible = match statistic {
            Statistic::Difference(..) => self.squares.sqrt(),
            Statistic::BetweenModes => self.squares,
        };
        let threshold = value.abs() - SAME * possible;
        statistics.iter().filter(|s| s.abs() >= threshold).count()
    }
}

fn largest(statistics: &[f64]) -> f64 {
    statistics.iter().fold(0.0, |most, s| most.max(s.abs()))
}

/// Of the orders in which both modes have a value: the middle one of each hundredth of them, which
/// is the statistic of an order and no mean of two.
fn percentiles(mut statistics: Vec<f64>) -> Vec<f64> {
    statistics.retain(|s| s.is_finite());
    statistics.sort_by(f64::total_cmp);
    let middles = (0..100).map(|percent| (2 * percent + 1) * statistics.len() / 200);
    middles.filter_map(|place| statistics.get(place).copied()).collect()
}

/// Checks that an order has a known mode for each trial.
fn check_order(order: &[usize], trials: usize, modes: usize) -> Result<(), StatsError> {
    same_length("an order of modes", trials, order.len())?;
    match order.iter().position(|mode| *mode >= modes) {
        None => Ok(()),
        Some(trial) => Err(StatsError::Mode { trial, mode: order[trial], modes }),
    }
}

#[cfg(test)]
mod tests;
