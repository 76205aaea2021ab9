//! Whole curves compared: Student's t at every node, against how far its largest value goes over all of
//! them by chance.

use crate::bootstrap::stream;
use crate::error::{all_finite, same_length};
use crate::groups::{Permuted, arranged, difference, group};
use crate::null::{Null, SAME, Sampling};
use crate::paired::ROUNDINGS;
use crate::sign_flip::smallest_p;
use crate::student_t::critical_value;
use crate::tested::at_least;
use crate::welch::Group;
use crate::{StatsError, Tested, Unestimable};
use rand_chacha::rand_core::Rng;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use zwidth_numerics::moments::Moments;

/// With fewer people all flips of signs together reach no p below 0.05 (of five 2/2⁵), and the band is
/// pointwise.
pub const LEAST_FOR_A_CLAIM: usize = 6;

/// With a median |skewness| above this a claim needs the largest mean to show the effect, too: the largest |t| of
/// skewed differences finds one in up to 33 % of studies without one (docs/statistics-tried.md).
pub const SKEWED: f64 = 0.7;

/// Up to so many people every flip of signs is counted, beyond these they are drawn.
const ALL_FLIPS_UP_TO: usize = 14;

/// People's differences at a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// Their mean, in their unit; of groups the difference of means.
    pub mean: f64,
    /// Its standard error.
    pub std_error: f64,
    /// Student's t, of groups Welch's; `None` at a node without scatter, which is left out.
    pub statistic: Option<f64>,
    /// The ends of the band, or of the pointwise interval where there is no band.
    pub ends: Option<[f64; 2]>,
}

/// Neighbouring nodes where |t| exceeds the pointwise critical value, t having one sign.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Run {
    /// Its first node.
    pub first: usize,
    /// Its last node.
    pub last: usize,
    /// Sum of |t| over its nodes.
    pub mass: f64,
    /// Share of flips whose largest run has that mass or more.
    pub p_value: f64,
}

/// The test of a curve of paired differences.
#[derive(Debug, Clone, PartialEq)]
pub struct CurveTest {
    /// Every node, in its order.
    pub nodes: Vec<Node>,
    /// The node with the largest |t|.
    pub largest: usize,
    /// The share of flips whose largest |t| is that or more, the smallest that there can be, and how it was
    /// found.
    pub flipped: Permuted,
    /// The same of the largest mean, not divided by its standard error.
    pub p_unstudentised: f64,
    /// The |t| that the largest of all nodes exceeds by chance in a share 1 − level of flips.
    pub critical: f64,
    /// Half the band's width in standard errors; `None` where the interval is pointwise.
    pub band: Option<f64>,
    /// Median over nodes of the differences' |skewness|: above [`SKEWED`] `p_unstudentised` counts too.
    pub skewness: f64,
    /// Where |t| exceeds the pointwise critical value, in the order of nodes.
    pub runs: Vec<Run>,
}

impl CurveTest {
    /// The p value that a claim rests on: where differences are skewed both tests must find the effect, and it is the
    /// larger one; `None` of fewer people than a claim takes.
    pub fn p_claimed(&self, people: usize) -> Option<f64> {
        let p = self.flipped.p_value;
        let p = if self.skewness > SKEWED { p.max(self.p_unstudentised) } else { p };
        (people >= LEAST_FOR_A_CLAIM).then_some(p)
    }
}

/// What one flip of signs gives: the largest |t|, the largest mass of a run, the largest |sum|, and the largest
/// |t| of the differences from their mean.
#[derive(Debug, Clone, Copy)]
struct Flip {
    t: f64,
    mass: f64,
    mean: f64,
    of_residuals: f64,
}

/// People's curves of differences, ready for other signs.
///
/// The sum of flipped differences is that of their distances from the mean, and the mean as often as there are more
/// plus signs than minus: one pass over the people serves every statistic.
struct Flipped<'a> {
    /// Each person's distances from the nodes' means; 0 at nodes without scatter, which are left out of every
    /// statistic.
    rows: Vec<Vec<f64>>,
    nodes: Vec<Scale>,
    lengths: &'a [usize],
    /// Above this |t| a node belongs to a run.
    pointwise: f64,
}

/// What a sum over people is to a node.
#[derive(Debug, Clone, Copy)]
struct Scale {
    mean: f64,
    /// One over the root of the differences' sum of squares, which flips leave as it is: t is then a function of the
    /// sum alone.
    per_size: f64,
    /// The same of the distances from the mean.
    per_residual: f64,
}

impl<'a> Flipped<'a> {
    fn new(
        curves: &[Vec<f64>],
        here: &[Moments],
        scatters: &[bool],
        lengths: &'a [usize],
        pointwise: f64,
    ) -> Self {
        let mut rows = curves.to_vec();
        let nodes = (0..here.len()).map(|node| {
            let mean = here[node].mean;
            let size = rows.iter().map(|row| row[node] * row[node]).sum::<f64>().sqrt();
            rows.iter_mut()
                .for_each(|row| row[node] = if scatters[node] { row[node] - mean } else { 0.0 });
            let left = rows.iter().map(|row| row[node] * row[node]).sum::<f64>().sqrt();
            match scatters[node] {
                true => Scale { mean, per_size: 1.0 / size, per_residual: 1.0 / left },
                false => Scale { mean: 0.0, per_size: 0.0, per_residual: 0.0 },
            }
        });
        let nodes = nodes.collect();
        Self { rows, nodes, lengths, pointwise }
    }

    /// Every flip in which the last person keeps the sign, the one without a turned sign first.
    fn all(&self) -> Vec<Flip> {
        /// So many people's signs go through all their values one turn at a time (Gray's code): a flip is then the
        /// one before with one person's row added twice. Rounding adds up over no more.
        const TURNED: usize = 6;
        let turned = TURNED.min(self.rows.len() - 1);
        let blocks = 1_u64 << (self.rows.len() - 1 - turned);
        let of_block = |block: u64| {
            let (mut sums, mut signs) = self.sums(|person| block << turned >> person & 1 == 1);
            let mut flips = vec![self.flip(&sums, signs)];
            let mut is_turned = [false; TURNED];
            for number in 1..1_u64 << turned {
                let person = number.trailing_zeros() as usize;
                is_turned[person] = !is_turned[person];
                let twice = if is_turned[person] { -2.0 } else { 2.0 };
                let row = &self.rows[person];
                sums.iter_mut().zip(row).for_each(|(sum, away)| *sum += twice * away);
                signs += twice;
                flips.push(self.flip(&sums, signs));
            }
            flips
        };
        (0..blocks).into_par_iter().flat_map_iter(of_block).collect()
    }

    /// Flips by chance.
    fn drawn(&self, sampling: Sampling) -> Vec<Flip> {
        let of_draw = |number: u64| {
            let mut rng = stream(sampling.seed, number);
            let bits: Vec<u64> =
                (0..self.rows.len().div_ceil(64)).map(|_| rng.next_u64()).collect();
            let (sums, signs) = self.sums(|person| bits[person / 64] >> (person % 64) & 1 == 1);
            self.flip(&sums, signs)
        };
        (0..sampling.draws as u64).into_par_iter().map(of_draw).collect()
    }

    /// The sums of flipped distances from the mean, and how many more plus signs there are than minus.
    fn sums(&self, is_turned: impl Fn(usize) -> bool) -> (Vec<f64>, f64) {
        let mut sums = vec![0.0; self.nodes.len()];
        let mut signs = 0.0;
        for (person, row) in self.rows.iter().enumerate() {
            let sign = if is_turned(person) { -1.0 } else { 1.0 };
            sums.iter_mut().zip(row).for_each(|(sum, away)| *sum += sign * away);
            signs += sign;
        }
        (sums, signs)
    }

    fn flip(&self, sums: &[f64], signs: f64) -> Flip {
        let (mut mean, mut scaled, mut residual) = (0.0_f64, 0.0_f64, 0.0_f64);
        for (sum, node) in sums.iter().zip(&self.nodes) {
            let plain = (sum + node.mean * signs).abs();
            mean = mean.max(plain);
            scaled = scaled.max(plain * node.per_size);
            residual = residual.max((sum * node.per_residual).abs());
        }
        let t = self.t(scaled);
        // Most flips have no run.
        let mass = match t > self.pointwise {
            true => runs(&self.t_of(sums, signs), self.lengths, self.pointwise)
                .map(|(_, _, mass)| mass)
                .fold(0.0, f64::max),
            false => 0.0,
        };
        Flip { t, mass, mean, of_residuals: self.t(residual) }
    }

    /// Student's t of every node.
    fn t_of(&self, sums: &[f64], signs: f64) -> Vec<f64> {
        let nodes = sums.iter().zip(&self.nodes);
        nodes.map(|(sum, node)| self.t((sum + node.mean * signs) * node.per_size)).collect()
    }

    /// Student's t of a sum over the root of the sum of squares.
    fn t(&self, sum: f64) -> f64 {
        let people = self.rows.len() as f64;
        let left = (people - sum * sum).max(people * f64::EPSILON);
        sum * ((people - 1.0) / left).sqrt()
    }
}

/// Tests whether the mean of people's curves of differences is zero everywhere. `curves` has one row per
/// person and `lengths` the number of nodes of each branch, which a run does not pass. The largest |t| over
/// nodes is compared with those of other signs of people's whole curves: all of them up to 14 people, else
/// as `sampling` draws them. That holds the level over all nodes together, however they hang together
/// (Westfall & Young 1993, *Resampling-Based Multiple Testing*; Nichols & Holmes 2002, Human Brain Mapping
/// 15:1). A run says that there is a difference somewhere in it, not where it begins (Sassenhagen & Draschkow
/// 2019, Psychophysiology 56:e13335). The band d̄ ± c s/√n takes c from flips of the differences from their
/// mean, so that it covers the whole curve at `level`.
///
/// # Errors
/// Fewer than two people; no node; rows of different length; a value that is not finite; no node with scatter.
pub fn differences(
    curves: &[Vec<f64>],
    lengths: &[usize],
    level: f64,
    sampling: Sampling,
) -> Result<CurveTest, Unestimable> {
    let n = curves.len();
    at_least("participants", n, 2)?;
    let nodes = checked(curves, lengths)?;
    let pointwise = critical_value(level, (n - 1) as f64)?;
    let here: Vec<Moments> = (0..nodes).map(|node| Moments::of(&column(curves, node))).collect();
    let scatters: Vec<bool> = here.iter().map(|m| scatters(m, n)).collect();
    if !scatters.contains(&true) {
        return Err(Unestimable::Constant { units: "differences" });
    }
    let flipped = Flipped::new(curves, &here, &scatters, lengths, pointwise);
    // A flip and its mirror have one |t|: the last person keeps the sign.
    let all = n <= ALL_FLIPS_UP_TO;
    let flips: Vec<Flip> = match all {
        true => flipped.all(),
        false => flipped.drawn(sampling),
    };
    let (sums, signs) = flipped.sums(|_| false);
    let t = flipped.t_of(&sums, signs);
    let observed = flipped.flip(&sums, signs);
    let share = |of: fn(&Flip) -> f64, observed: f64| {
        let extreme = flips.iter().filter(|flip| of(flip) >= observed * (1.0 - SAME)).count();
        match all {
            true => extreme as f64 / flips.len() as f64,
            false => (1 + extreme) as f64 / (1 + flips.len()) as f64,
        }
    };
    // The value that a share of 1 − level of all exceed; a counted one stands for its mirror, too.
    let copies = if all { 2 } else { 1 };
    let quantile = |mut values: Vec<f64>| {
        values.sort_by(|a, b| b.total_cmp(a));
        let place = ((1.0 - level) * (copies * values.len()) as f64 + SAME).floor() as usize;
        values.get((place / copies).min(values.len().saturating_sub(1))).copied()
    };
    let critical = quantile(flips.iter().map(|flip| flip.t).collect()).unwrap_or(pointwise);
    // All as they are, or all turned, the residuals have no mean.
    let others = flips.iter().skip(usize::from(all));
    let band = quantile(others.map(|flip| flip.of_residuals).collect());
    let band = band.filter(|_| n >= LEAST_FOR_A_CLAIM);
    let nodes: Vec<Node> = here
        .iter()
        .zip(&scatters)
        .map(|(moments, scatters)| {
            let mean = moments.mean;
            let std_error = moments.sd().unwrap_or(0.0) / (n as f64).sqrt();
            let half = band.unwrap_or(pointwise) * std_error;
            Node {
                mean,
                std_error,
                statistic: scatters.then(|| mean / std_error),
                ends: scatters.then_some([mean - half, mean + half]),
            }
        })
        .collect();
    let found = runs(&t, lengths, pointwise).map(|(first, last, mass)| Run {
        first,
        last,
        mass,
        p_value: share(|flip| flip.mass, mass),
    });
    Ok(CurveTest {
        largest: place_of_largest(&t),
        flipped: Permuted {
            p_value: share(|flip| flip.t, observed.t),
            smallest_p: if all { smallest_p(n) } else { 1.0 / (1 + sampling.draws) as f64 },
            null: if all { Null::Exact } else { Null::Sampled { draws: sampling.draws } },
        },
        p_unstudentised: share(|flip| flip.mean, observed.mean),
        critical,
        band,
        skewness: median_skewness(curves, &here, &scatters),
        runs: found.collect(),
        nodes,
    })
}

/// The difference of two sets of curves: of two groups of people, or of one person's trials in two modes.
#[derive(Debug, Clone, PartialEq)]
pub struct UnpairedCurveTest {
    /// Every node, in its order, with Welch's t and its pointwise interval.
    pub nodes: Vec<Node>,
    /// The node with the largest |t|.
    pub largest: usize,
    /// The share of arrangements, of labels or of trials, whose largest |t| is that or more.
    pub permuted: Permuted,
}

/// Tests whether two groups' mean curves, `a` − `b`, are equal everywhere: the largest of Welch's |t| over
/// nodes is compared with those of other labels of people's whole curves within their blocks, as
/// [`permuted_within`](crate::groups::permuted_within()) does with single values.
///
/// # Errors
/// A group of fewer than two people; not one block for each of them; rows of different length; a value that is not
/// finite; no node with scatter.
pub fn groups(
    [a, b]: [&[Vec<f64>]; 2],
    blocks: [&[usize]; 2],
    lengths: &[usize],
    level: f64,
    sampling: Sampling,
) -> Result<UnpairedCurveTest, Unestimable> {
    let (na, nb) = (a.len(), b.len());
    at_least("participants of a group", na.min(nb), 2)?;
    same_length("blocks", na, blocks[0].len())?;
    same_length("blocks", nb, blocks[1].len())?;
    let curves = [a, b].concat();
    checked(&curves, lengths)?;
    let nodes = welch([a, b], level);
    if nodes.iter().all(|node| node.statistic.is_none()) {
        return Err(Unestimable::Constant { units: "participants" });
    }
    let values = standardised(curves, |node| nodes[node].statistic.is_some());
    let all = sums(&values, 0..na + nb);
    // Welch's t² of every node, the largest.
    let largest_t2 = |first: &[usize]| {
        let own = sums(&values, first.iter().copied());
        let pairs = own.into_iter().zip(&all);
        let t2 =
            pairs.map(|(own, all)| welch_t2([own, [all[0] - own[0], all[1] - own[1]]], [na, nb]));
        t2.fold(0.0, f64::max)
    };
    let observed = largest_t2(&(0..na).collect::<Vec<usize>>());
    let found = arranged(&blocks.concat(), na, sampling, largest_t2);
    let extreme = found.of.iter().filter(|t2| **t2 >= observed * (1.0 - SAME)).count();
    let t: Vec<f64> = nodes.iter().map(|node| node.statistic.unwrap_or(0.0)).collect();
    Ok(UnpairedCurveTest {
        largest: place_of_largest(&t),
        permuted: Permuted {
            p_value: found.share(extreme),
            smallest_p: found.smallest_p,
            null: found.null,
        },
        nodes,
    })
}

/// One person's trials, each with its curve.
#[derive(Debug, Clone, Copy)]
pub struct TrialCurves<'a> {
    /// The values of each trial, node by node.
    pub curves: &'a [Vec<f64>],
    /// The number of nodes of each branch.
    pub lengths: &'a [usize],
    /// The mode of each trial, as a number.
    pub modes: &'a [usize],
    /// The number of each trial's session.
    pub sessions: &'a [usize],
}

impl TrialCurves<'_> {
    /// The trials of both modes, session by session, of the sessions that have both.
    pub fn strata(&self, pair: [usize; 2]) -> Vec<[Vec<usize>; 2]> {
        let mut sessions: BTreeMap<usize, [Vec<usize>; 2]> = BTreeMap::new();
        for (trial, (mode, session)) in self.modes.iter().zip(self.sessions).enumerate() {
            if let Some(side) = pair.iter().position(|own| own == mode) {
                sessions.entry(*session).or_default()[side].push(trial);
            }
        }
        sessions.into_values().filter(|sides| sides.iter().all(|own| !own.is_empty())).collect()
    }
}

/// Tests for each pair of modes whether no trial's curve depended on mode: the largest of Welch's |t| over nodes is
/// compared with those of the orders that `redraw` gives for a seed, each the modes of the trials, as
/// [`sharp_null`](crate::sharp_null) does with single values, each less the mean of its session, which no order changes. An
/// order is drawn once for all pairs; one that leaves a mode of the pair fewer than two trials counts as extreme, which can
/// only make p larger. Nodes have the difference, t and interval of the sessions that have both modes
/// ([`welch`](crate::welch)).
///
/// # Errors
/// Curves of different length; a value that is not finite. Of a pair: no session with both modes; a mode of fewer than two
/// trials; no node with scatter.
pub fn trials(
    trials: TrialCurves,
    pairs: &[[usize; 2]],
    level: f64,
    sampling: Sampling,
    redraw: impl Fn(u64) -> Vec<usize> + Sync,
) -> Result<Vec<Result<UnpairedCurveTest, Unestimable>>, Unestimable> {
    let TrialCurves { curves, lengths, modes, sessions } = trials;
    let number = checked(curves, lengths)?;
    same_length("the list of modes", curves.len(), modes.len())?;
    same_length("the list of sessions", curves.len(), sessions.len())?;
    let mut centred = curves.to_vec();
    for session in BTreeSet::from_iter(sessions) {
        let own: Vec<usize> = (0..curves.len()).filter(|at| sessions[*at] == *session).collect();
        for node in 0..number {
            let mean = own.iter().map(|at| curves[*at][node]).sum::<f64>() / own.len() as f64;
            own.iter().for_each(|at| centred[*at][node] -= mean);
        }
    }
    // Beyond rounding, of which centred values are left. What is left out may not depend on the order.
    let scatter: Vec<bool> = (0..number)
        .map(|node| {
            let [all, own] = [curves, &centred].map(|rows| Moments::of(&column(rows, node)));
            scatters(&Moments { mean: all.mean, ..own }, curves.len())
        })
        .collect();
    let values = standardised(centred, |node| scatter[node]);
    let t2 = |order: &[usize], pair: [usize; 2]| -> Option<Vec<f64>> {
        let of =
            |mode: usize| (0..values.len()).filter(move |trial| order.get(*trial) == Some(&mode));
        let n = pair.map(|mode| of(mode).count());
        let [a, b] = pair.map(|mode| sums(&values, of(mode)));
        let each = a.into_iter().zip(b).map(|(a, b)| welch_t2([a, b], n));
        (n[0] > 1 && n[1] > 1).then(|| each.collect())
    };
    let largest = |t2: Vec<f64>| t2.into_iter().fold(0.0, f64::max);
    let drawn = (0..sampling.draws as u64).into_par_iter().map(|number| {
        let order = redraw(stream(sampling.seed, number).next_u64());
        let each = pairs.iter().map(|pair| t2(&order, *pair).map_or(f64::INFINITY, largest));
        each.collect::<Vec<f64>>()
    });
    let drawn: Vec<Vec<f64>> = drawn.collect();
    let tested = pairs.iter().enumerate().map(|(place, pair)| {
        let strata = trials.strata(*pair);
        at_least("sessions with both modes", strata.len(), 1)?;
        let of_mode = |side: usize| strata.iter().map(|sides| sides[side].len()).sum::<usize>();
        at_least("trials of a mode", of_mode(0).min(of_mode(1)), 2)?;
        let at = |node: usize| {
            let values =
                |own: &Vec<usize>| own.iter().map(|at| curves[*at][node]).collect::<Vec<f64>>();
            let groups: Vec<[Group; 2]> = strata
                .iter()
                .map(|sides| sides.each_ref().map(|own| group(&values(own))))
                .collect();
            let mean = |side: usize| {
                groups.iter().map(|own| own[side].mean).sum::<f64>() / groups.len() as f64
            };
            let mean = mean(0) - mean(1);
            Node::of(mean, crate::welch::difference(&groups, level).ok())
        };
        let observed = t2(modes, *pair).filter(|_| scatter.contains(&true));
        let observed = observed.ok_or(Unestimable::Constant { units: "trials" })?;
        let most = |least: f64| {
            let extreme = drawn.iter().filter(|t2| t2[place] >= least * (1.0 - SAME)).count();
            (1 + extreme) as f64 / (1 + drawn.len()) as f64
        };
        let all = drawn.iter().map(|t2| t2[place]).filter(|t2| t2.is_finite());
        Ok(UnpairedCurveTest {
            nodes: (0..number).map(at).collect(),
            largest: place_of_largest(&observed),
            permuted: Permuted {
                p_value: most(largest(observed.clone())),
                smallest_p: most(all.fold(largest(observed), f64::max)),
                null: Null::Sampled { draws: drawn.len() },
            },
        })
    });
    Ok(tested.collect())
}

/// Welch's t of each node, and its pointwise interval.
fn welch(curves: [&[Vec<f64>]; 2], level: f64) -> Vec<Node> {
    let number = curves[0].first().map_or(0, Vec::len);
    let at = |node| {
        let [a, b] = curves.map(|rows| group(&column(rows, node)));
        Node::of(a.mean - b.mean, difference([a, b], level).ok())
    };
    (0..number).map(at).collect()
}

impl Node {
    /// The node of two means, with their test, where there is one.
    fn of(mean: f64, tested: Option<Tested>) -> Self {
        Self {
            mean,
            std_error: tested.as_ref().map_or(0.0, |tested| tested.std_error),
            statistic: tested.as_ref().map(|tested| tested.statistic),
            ends: tested.map(|tested| [tested.ci_low, tested.ci_high]),
        }
    }
}

/// The same curves about their mean, over their scatter, so that sums of squares keep their digits; 0 at nodes that are not
/// tested.
fn standardised(mut curves: Vec<Vec<f64>>, is_tested: impl Fn(usize) -> bool) -> Vec<Vec<f64>> {
    for node in 0..curves.first().map_or(0, Vec::len) {
        let moments = Moments::of(&column(&curves, node));
        let scale = moments.squares.sqrt();
        let is_tested = is_tested(node) && scale > 0.0;
        for row in &mut curves {
            row[node] = if is_tested { (row[node] - moments.mean) / scale } else { 0.0 };
        }
    }
    curves
}

/// Sum and sum of squares of some of the rows, node by node.
fn sums(rows: &[Vec<f64>], some: impl Iterator<Item = usize>) -> Vec<[f64; 2]> {
    let mut sums = vec![[0.0, 0.0]; rows.first().map_or(0, Vec::len)];
    for row in some {
        for (sum, value) in sums.iter_mut().zip(&rows[row]) {
            *sum = [sum[0] + value, sum[1] + value * value];
        }
    }
    sums
}

/// The square of Welch's t of two sums with their sums of squares, each of so many.
fn welch_t2([a, b]: [[f64; 2]; 2], n: [usize; 2]) -> f64 {
    let within =
        |[sum, squares]: [f64; 2], n: f64| (squares - sum * sum / n).max(0.0) / (n - 1.0) / n;
    let [of_a, of_b] = n.map(|n| n as f64);
    let difference = a[0] / of_a - b[0] / of_b;
    let variance = within(a, of_a) + within(b, of_b);
    difference * difference / variance.max(f64::MIN_POSITIVE)
}

/// The number of nodes of curves that are all as long as their branches.
fn checked(curves: &[Vec<f64>], lengths: &[usize]) -> Result<usize, Unestimable> {
    let nodes = lengths.iter().sum();
    at_least("nodes", nodes, 1)?;
    for (row, values) in curves.iter().enumerate() {
        if values.len() != nodes {
            return Err(StatsError::Ragged { row, expected: nodes, found: values.len() }.into());
        }
        all_finite(values)?;
    }
    Ok(nodes)
}

fn column(curves: &[Vec<f64>], node: usize) -> Vec<f64> {
    curves.iter().map(|row| row[node]).collect()
}

/// Whether values scatter beyond their rounding.
fn scatters(moments: &Moments, n: usize) -> bool {
    let std_error = moments.sd().unwrap_or(0.0) / (n as f64).sqrt();
    std_error > ROUNDINGS * f64::EPSILON * moments.mean.abs()
}

fn place_of_largest(t: &[f64]) -> usize {
    (0..t.len()).max_by(|i, j| t[*i].abs().total_cmp(&t[*j].abs()).then(j.cmp(i))).unwrap_or(0)
}

/// First node, last node and mass of each run of neighbours with |t| above `critical` and one sign.
fn runs<'a>(
    t: &'a [f64],
    lengths: &'a [usize],
    critical: f64,
) -> impl Iterator<Item = (usize, usize, f64)> + 'a {
    let mut begin = 0;
    let branches = lengths.iter().map(move |length| {
        begin += length;
        begin - length..begin
    });
    // Above, below or between: the critical value is positive.
    let side = move |t: f64| (t > critical, t < -critical);
    branches.flat_map(move |nodes| {
        let (mut at, branch) = (nodes.start, &t[nodes]);
        branch.chunk_by(move |a, b| side(*a) == side(*b)).filter_map(move |run| {
            let first = at;
            at += run.len();
            (run[0].abs() > critical).then(|| (first, at - 1, run.iter().map(|t| t.abs()).sum()))
        })
    })
}

/// Median over nodes with scatter of the |skewness| without its bias in normal samples, √(n(n − 1))/(n − 2) m₃/m₂^1.5, m
/// being means of powers of the differences from their mean (Joanes & Gill 1998, The Statistician 47:183).
fn median_skewness(curves: &[Vec<f64>], here: &[Moments], scatters: &[bool]) -> f64 {
    let n = curves.len() as f64;
    let nodes = (0..here.len()).filter(|node| scatters[*node]).map(|node| {
        let Moments { mean, squares, .. } = here[node];
        let sd = (squares / n).sqrt();
        let cubes = curves.iter().map(|row| ((row[node] - mean) / sd).powi(3));
        ((n * (n - 1.0)).sqrt() / (n - 2.0).max(1.0) * cubes.sum::<f64>() / n).abs()
    });
    let mut all: Vec<f64> = nodes.collect();
    all.sort_by(f64::total_cmp);
    match all.len() {
        0 => 0.0,
        n if n % 2 == 1 => all[n / 2],
        n => (all[n / 2 - 1] + all[n / 2]) / 2.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLING: Sampling = Sampling { draws: 9_999, seed: 1 };

    /// A number between −½ and ½ that anybody can make again: (h³ mod 9941)/9941 − ½.
    fn u(of: [u64; 3]) -> f64 {
        let h = 1 + 131 * of[0] + 173 * of[1] + 197 * of[2];
        (h * h * h % 9941) as f64 / 9941.0 - 0.5
    }

    /// A person's curve of 51 nodes, to three decimals.
    fn curve(person: u64) -> Vec<f64> {
        let at = |q: f64| {
            let waves = (1..=4).map(|k| {
                let phase = k as f64 * core::f64::consts::PI * q / 50.0 + 6.0 * u([person, k, 1]);
                u([person, k, 0]) * phase.cos()
            });
            let value = 0.7 * (-(q - 18.0).powi(2) / 60.0).exp()
                + 0.2 * u([person, 0, 0])
                + 0.6 * waves.sum::<f64>();
            (value * 1000.0).round() / 1000.0
        };
        (0..51).map(|q| at(f64::from(q))).collect()
    }

    fn near(found: f64, expected: f64) {
        assert!((found - expected).abs() <= 1e-6 * expected.abs(), "{found} {expected}");
    }

    /// t curve and flips: spm1d 0.4.55 and NumPy; order statistic, run and band: NumPy by definition.
    #[test]
    fn the_curve_of_eight_people_has_the_numbers_of_spm1d() {
        let curves: Vec<Vec<f64>> = (1..=8).map(curve).collect();
        let found = differences(&curves, &[51], 0.95, SAMPLING).unwrap();
        assert_eq!((found.largest, found.nodes.len()), (19, 51));
        near(found.nodes[19].statistic.unwrap(), 8.99151588);
        near(found.flipped.p_value, 2.0 / 256.0);
        near(found.flipped.smallest_p, 2.0 / 256.0);
        near(found.critical, 4.31275105);
        near(found.band.unwrap(), 3.95289411);
        let [run] = found.runs.as_slice() else { panic!("{:?}", found.runs) };
        assert_eq!((run.first, run.last), (11, 25));
        near(run.mass, 85.2011338);
        near(run.p_value, 2.0 / 256.0);
        let node = found.nodes[19];
        let [low, high] = node.ends.unwrap();
        near((high - low) / 2.0, 3.95289411 * node.std_error);
    }

    #[test]
    fn a_run_ends_where_its_branch_does_and_where_t_changes_its_sign() {
        let t = [3.0, 4.0, -3.0, 1.0, 5.0, 6.0, 0.0];
        let found: Vec<_> = runs(&t, &[5, 2], 2.0).collect();
        assert_eq!(found, [(0, 1, 7.0), (2, 2, 3.0), (4, 4, 5.0), (5, 5, 6.0)]);
        assert!(runs(&[], &[], 2.0).next().is_none());
    }

    #[test]
    fn more_people_are_flipped_at_random_and_the_same_on_any_number_of_threads() {
        let curves: Vec<Vec<f64>> = (1..=16).map(curve).collect();
        let run = || differences(&curves, &[20, 31], 0.95, SAMPLING).unwrap();
        let on = |threads| {
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run)
        };
        assert_eq!(on(1), on(3));
        let found = on(2);
        assert_eq!(found.flipped.null, Null::Sampled { draws: 9_999 });
        near(found.flipped.p_value, 1e-4);
        // The drawn band is near that of all flips.
        let (all, few) = (&curves[..14], Sampling { draws: 4_999, seed: 2 });
        let counted = differences(all, &[51], 0.95, few).unwrap().band.unwrap();
        let drawn = differences(&curves[..15], &[51], 0.95, few).unwrap().band.unwrap();
        assert!((counted - drawn).abs() < 0.3, "{counted} {drawn}");
    }

    #[test]
    fn of_few_people_the_interval_is_pointwise_and_no_p_is_small() {
        let curves: Vec<Vec<f64>> = (1..=5).map(curve).collect();
        let found = differences(&curves, &[51], 0.95, SAMPLING).unwrap();
        assert_eq!(found.band, None);
        assert!(found.flipped.p_value >= 0.0625);
        let node = found.nodes[3];
        let [low, high] = node.ends.unwrap();
        near((high - low) / 2.0, 2.7764451 * node.std_error);
    }

    #[test]
    fn nodes_without_scatter_are_left_out() {
        let mut curves: Vec<Vec<f64>> = (1..=8).map(curve).collect();
        let whole = differences(&curves, &[51], 0.95, SAMPLING).unwrap();
        for row in &mut curves {
            row[0] = 0.0;
            row[1] = 0.1 + 0.2;
        }
        let found = differences(&curves, &[51], 0.95, SAMPLING).unwrap();
        assert_eq!((found.nodes[0].statistic, found.nodes[1].ends), (None, None));
        assert_eq!((found.largest, found.runs.clone()), (whole.largest, whole.runs));
        let constant = vec![vec![1.0; 3]; 8];
        let why = differences(&constant, &[3], 0.95, SAMPLING).unwrap_err();
        assert_eq!(why, Unestimable::Constant { units: "differences" });
        assert!(differences(&curves, &[50], 0.95, SAMPLING).is_err());
        assert!(differences(&curves[..1], &[51], 0.95, SAMPLING).is_err());
        assert!(differences(&[vec![f64::NAN], vec![1.0]], &[1], 0.95, SAMPLING).is_err());
        // The unit of curves changes nothing.
        let tiny: Vec<Vec<f64>> =
            curves.iter().map(|row| row.iter().map(|v| v * 1e-100).collect()).collect();
        let small = differences(&tiny, &[51], 0.95, SAMPLING).unwrap();
        near(small.critical, found.critical);
        near(small.flipped.p_value, found.flipped.p_value);
    }

    /// A curve of one node is a value.
    #[test]
    fn groups_of_one_node_are_those_of_single_values() {
        let value = |person| vec![curve(person)[30]];
        let [a, b]: [Vec<Vec<f64>>; 2] =
            [(1..=5).map(value).collect(), (6..=12).map(value).collect()];
        let blocks = [&[0, 0, 1, 1, 2][..], &[0, 1, 1, 2, 2, 2, 2][..]];
        let found = groups([&a, &b], blocks, &[1], 0.95, SAMPLING).unwrap();
        let [first, second] = [a, b].map(|rows| column(&rows, 0));
        let alone = crate::groups::permuted_within([&first, &second], blocks, SAMPLING).unwrap();
        assert_eq!(found.permuted, alone);
        near(found.permuted.smallest_p, 1.0 / 90.0);
        let welch = difference([group(&first), group(&second)], 0.95).unwrap();
        assert_eq!(found.nodes[0].ends, Some([welch.ci_low, welch.ci_high]));
    }

    #[test]
    fn groups_differ_where_their_curves_do() {
        let shifted = |person: u64| -> Vec<f64> {
            let at = |(node, value): (usize, f64)| if node > 30 { value + 2.0 } else { value };
            curve(person).into_iter().enumerate().map(at).collect()
        };
        let [a, b]: [Vec<Vec<f64>>; 2] =
            [(1..=6).map(shifted).collect(), (7..=12).map(curve).collect()];
        let one = [&[0; 6][..], &[0; 6][..]];
        let found = groups([&a, &b], one, &[51], 0.95, SAMPLING).unwrap();
        assert!(found.largest > 30 && found.permuted.p_value < 0.01, "{:?}", found.permuted);
        near(found.permuted.smallest_p, 2.0 / 924.0);
        assert!(groups([&a[..1], &b], [&[0], one[1]], &[51], 0.95, SAMPLING).is_err());
        assert!(groups([&a, &b], [&[0; 5], one[1]], &[51], 0.95, SAMPLING).is_err());
        let alike = vec![vec![0.0; 3]; 6];
        assert!(groups([&alike, &alike], one, &[3], 0.95, SAMPLING).is_err());
    }

    /// Orders of complete randomisation are arrangements of labels: p agrees with that of groups, up to the draws. A curve of
    /// one node has the p value of its value.
    #[test]
    fn trials_in_orders_drawn_like_labels_have_the_p_of_labels() {
        let curves: Vec<Vec<f64>> = (1..=12).map(curve).collect();
        let modes: Vec<usize> = (0..12).map(|trial| trial / 4).collect();
        let shuffled = |seed: u64| {
            let mut order = modes.clone();
            let mut rng = stream(seed, 0);
            for last in (1..order.len()).rev() {
                order.swap(last, (rng.next_u64() % (last as u64 + 1)) as usize);
            }
            order
        };
        let sessions = &[0; 12];
        let own = TrialCurves { curves: &curves, lengths: &[20, 31], modes: &modes, sessions };
        let found = trials(own, &[[0, 1], [2, 0], [0, 7]], 0.95, SAMPLING, shuffled).unwrap();
        assert!(found[2].is_err(), "nobody has that mode");
        // Of two modes alone orders and labels are the same.
        let two = TrialCurves {
            curves: &curves[..8],
            lengths: &[51],
            modes: &modes[..8],
            sessions: &sessions[..8],
        };
        let of_two = |seed| shuffled(seed).into_iter().filter(|mode| *mode < 2).collect();
        let drawn = trials(two, &[[0, 1]], 0.95, SAMPLING, of_two).unwrap().remove(0).unwrap();
        let block = [0; 4];
        let counted =
            groups([&curves[..4], &curves[4..8]], [&block, &block], &[51], 0.95, SAMPLING).unwrap();
        assert_eq!((&drawn.nodes, drawn.largest), (&counted.nodes, counted.largest));
        let (drawn, counted) = (drawn.permuted, counted.permuted);
        assert!((drawn.p_value - counted.p_value).abs() < 0.02, "{drawn:?} {counted:?}");
        assert!((drawn.smallest_p - counted.smallest_p).abs() < 0.005, "{drawn:?} {counted:?}");
        let of = found[0].as_ref().unwrap();
        assert_eq!(of.nodes, welch([&curves[..4], &curves[4..8]], 0.95));
    }

    /// Three trials of one mode and one of the other in a session, and the other way round in the next, which is 100 higher:
    /// the difference is that within sessions, and a session with one mode alone is in none.
    #[test]
    fn a_session_adds_nothing_to_the_difference_of_its_modes() {
        let (modes, sessions) = ([0, 0, 0, 1, 0, 1, 1, 1, 0], [0, 0, 0, 0, 1, 1, 1, 1, 2]);
        let curves: Vec<Vec<f64>> = (0..9)
            .map(|trial| {
                let scatter = 0.01 * curve(trial as u64 + 1)[25];
                vec![100.0 * sessions[trial] as f64 + 2.0 * modes[trial] as f64 + scatter]
            })
            .collect();
        let own =
            TrialCurves { curves: &curves, lengths: &[1], modes: &modes, sessions: &sessions };
        let turned = |seed: u64| {
            let mut order = modes.to_vec();
            order[..4].rotate_left(seed as usize % 4);
            order[4..8].rotate_left(seed as usize / 4 % 4);
            order
        };
        let found = trials(own, &[[1, 0]], 0.95, SAMPLING, turned).unwrap().remove(0).unwrap();
        let node = found.nodes[0];
        assert!((node.mean - 2.0).abs() < 0.02, "{node:?}");
        assert_eq!(node.ends, None, "one trial of a mode in a session tells no scatter");
        // One order in sixteen.
        assert!((found.permuted.p_value - 1.0 / 16.0).abs() < 0.01, "{:?}", found.permuted);
        let apart = TrialCurves { modes: &[0, 0, 0, 0, 1, 1, 1, 1, 1], ..own };
        assert!(trials(apart, &[[1, 0]], 0.95, SAMPLING, turned).unwrap()[0].is_err());
    }
}
