//! Groups of people whose variances differ: differences and means by Welch, Welch's F, and labels
//! permuted.

use crate::bootstrap::{index_below, stream};
use crate::effect::{Effect, standardised};
use crate::error::{all_finite, check_level, same_length};
use crate::f_distribution::upper_p;
use crate::null::{Null, SAME, Sampling};
use crate::paired::ROUNDINGS;
use crate::tested::{at_least, not_constant};
use crate::welch::{Group, combined};
use crate::{FTest, Tested, Unestimable};
use core::f64::consts::SQRT_2;
use rayon::prelude::*;
use std::collections::BTreeMap;
use zwidth_numerics::moments::Moments;

/// With fewer people in a group no claim rests on Welch's test: with 3 it finds an effect in up to
/// 7 % of studies without one, with 4 in up to 5.9 (docs/statistics-tried.md: 3 + 9 and 4 + 8 people, standard
/// deviations 3 : 1).
pub const LEAST_FOR_A_CLAIM: usize = 4;

/// With fewer people in a group there is no p value.
pub const LEAST_FOR_A_P: usize = 3;

/// Up to so many arrangements of labels are counted, each of them.
const MOST_ARRANGEMENTS: u64 = 20_000;

/// How errors call the people of a group.
const PEOPLE: &str = "participants of a group";

/// Size, mean and standard deviation of a group's `values`; 0 for what it does not have.
pub fn group(values: &[f64]) -> Group {
    let found = Moments::of(values);
    let mean = if values.is_empty() { 0.0 } else { found.mean };
    Group { n: values.len(), mean, sd: found.sd().unwrap_or(0.0) }
}

/// mean(a) − mean(b), Welch's test: the variances may differ. Units as the values. Welch, B. L. (1947),
/// Biometrika 34:28–35.
///
/// # Errors
/// A group of fewer than two; groups without scatter beyond rounding; `level` outside (0, 1).
pub fn difference([a, b]: [Group; 2], level: f64) -> Result<Tested, Unestimable> {
    tested(&[(1.0, a), (-1.0, b)], level)
}

/// The mean over groups of their means, each group with the same weight 1/G: SE² = Σ s²_g / (n_g G²),
/// degrees of freedom of Satterthwaite (1946, Biometrics Bulletin 2:110–114). Units as the values.
///
/// # Errors
/// As those of [`difference`]; no group.
pub fn mean(groups: &[Group], level: f64) -> Result<Tested, Unestimable> {
    // Without groups `combined` refuses: the weight is only to be finite.
    let weight = 1.0 / groups.len().max(1) as f64;
    tested(&groups.iter().map(|group| (weight, *group)).collect::<Vec<_>>(), level)
}

fn tested(terms: &[(f64, Group)], level: f64) -> Result<Tested, Unestimable> {
    let fewest = terms.iter().map(|(_, group)| group.n).min().unwrap_or(0);
    check_level(level)?;
    at_least(PEOPLE, fewest, 2)?;
    let largest = terms.iter().fold(0.0_f64, |most, (_, group)| most.max(group.mean.abs()));
    let scatter = terms.iter().fold(0.0_f64, |most, (_, group)| most.max(group.sd));
    not_constant(PEOPLE, scatter <= ROUNDINGS * f64::EPSILON * largest)?;
    combined(terms, PEOPLE, level)
}

/// Whether any group's mean differs from another's, variances free: Welch's F. Welch, B. L. (1951),
/// Biometrika 38:330–336.
///
/// # Errors
/// Fewer than two groups; a group of fewer than two or without scatter.
pub fn any_difference(groups: &[Group]) -> Result<FTest, Unestimable> {
    at_least("groups", groups.len(), 2)?;
    at_least(PEOPLE, groups.iter().map(|group| group.n).min().unwrap_or(0), 2)?;
    not_constant(PEOPLE, groups.iter().any(|group| group.sd <= 0.0))?;
    let number = groups.len() as f64;
    let weights: Vec<f64> = groups.iter().map(|g| g.n as f64 / (g.sd * g.sd)).collect();
    let all: f64 = weights.iter().sum();
    let mean = groups.iter().zip(&weights).map(|(g, w)| w * g.mean).sum::<f64>() / all;
    let between: f64 = groups.iter().zip(&weights).map(|(g, w)| w * (g.mean - mean).powi(2)).sum();
    let spent: f64 =
        groups.iter().zip(&weights).map(|(g, w)| (1.0 - w / all).powi(2) / (g.n - 1) as f64).sum();
    let squares = number * number - 1.0;
    let df_num = number - 1.0;
    let statistic = between / df_num / (1.0 + 2.0 * (number - 2.0) / squares * spent);
    let df_den = squares / (3.0 * spent);
    all_finite(&[statistic, df_den])?;
    Ok(FTest { statistic, df_num, df_den, p_value: upper_p(statistic, df_num, df_den)? })
}

/// The difference of two groups in standard deviations of people within a group: d = (ā − b̄) / s_av with
/// s_av² = (s²_a + s²_b) / 2. For g, ν = (s²_a + s²_b)² / (s⁴_a/(n_a − 1) + s⁴_b/(n_b − 1)); the interval is
/// that of Welch's noncentral t, times its standard error over s_av.
///
/// # Errors
/// As those of [`difference`].
pub fn effect([a, b]: [Group; 2], level: f64) -> Result<Effect, Unestimable> {
    let tested = difference([a, b], level)?;
    let scatter = libm::hypot(a.sd, b.sd) / SQRT_2;
    // In units of 2 s²_av: fourth powers of small values would be 0.
    let [of_a, of_b] = [a, b].map(|group| (group.sd / scatter).powi(2) / 2.0);
    let df =
        (of_a + of_b).powi(2) / (of_a * of_a / (a.n - 1) as f64 + of_b * of_b / (b.n - 1) as f64);
    Ok(standardised(&tested, scatter, df, level))
}

/// Two groups' labels permuted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Permuted {
    /// The share of arrangements of the labels with |Welch's t| ≥ the observed one.
    pub p_value: f64,
    /// The smallest p that as many people can reach.
    pub smallest_p: f64,
    /// How the p value was found.
    pub null: Null,
}

/// Tests whether the labels of two groups could be any others, by |Welch's t|, which holds its level
/// better than the difference of means where groups scatter differently (Chung & Romano 2013, Ann. Stat.
/// 41:484). Up to 20,000 arrangements are counted, beyond these they are drawn by `sampling`.
///
/// # Errors
/// A group of fewer than two; a value that is not finite; people who are all alike.
pub fn permuted(a: &[f64], b: &[f64], sampling: Sampling) -> Result<Permuted, Unestimable> {
    permuted_within([a, b], [&vec![0; a.len()], &vec![0; b.len()]], sampling)
}

/// [`permuted`] with the arrangements that the drawing allowed: it gave each of some blocks of people as many of a group
/// as it has, so that labels change within blocks alone. `blocks` has the block of everybody of either group, any
/// numbers.
///
/// # Errors
/// Those of [`permuted`]; not one block for each value.
pub fn permuted_within(
    [a, b]: [&[f64]; 2],
    blocks: [&[usize]; 2],
    sampling: Sampling,
) -> Result<Permuted, Unestimable> {
    same_length("blocks", a.len(), blocks[0].len())?;
    same_length("blocks", b.len(), blocks[1].len())?;
    all_finite(a)?;
    all_finite(b)?;
    at_least(PEOPLE, a.len().min(b.len()), 2)?;
    let all = Moments::of(&[a, b].concat());
    // About their mean: sums of squares of values far from zero would lose their digits.
    let values: Vec<f64> = a.iter().chain(b).map(|value| value - all.mean).collect();
    not_constant(PEOPLE, all.squares.sqrt() <= ROUNDINGS * f64::EPSILON * all.mean.abs())?;
    let squares: f64 = values.iter().map(|v| v * v).sum();
    // Finite values may have squares that are not, and no arrangement would be as extreme as another.
    all_finite(&[squares])?;
    let sum: f64 = values.iter().sum();
    let (na, nb) = (a.len(), b.len());
    // t² of the arrangement whose first group has these values.
    let t2 = |first: &mut dyn Iterator<Item = f64>| {
        let [s, q] = first.fold([0.0, 0.0], |[s, q], v| [s + v, q + v * v]);
        let [mean_a, mean_b] = [s / na as f64, (sum - s) / nb as f64];
        let within = |q: f64, n: usize, mean: f64| {
            let n = n as f64;
            (q - n * mean * mean).max(0.0) / (n - 1.0) / n
        };
        let variance = within(q, na, mean_a) + within(squares - q, nb, mean_b);
        // Where nobody scatters, t has no end.
        (mean_a - mean_b).powi(2) / variance.max(f64::MIN_POSITIVE)
    };
    let observed = t2(&mut values[..na].iter().copied());
    let extreme = arranged(&blocks.concat(), na, sampling, |first| {
        t2(&mut first.iter().map(|i| values[*i])) >= observed * (1.0 - SAME)
    });
    let count = extreme.of.iter().filter(|extreme| **extreme).count();
    Ok(Permuted {
        p_value: extreme.share(count),
        smallest_p: extreme.smallest_p,
        null: extreme.null,
    })
}

/// What arrangements of the labels of two groups give.
pub(crate) struct Arranged<T> {
    /// Of each: of all of them, that which there is among them, or of those drawn.
    pub(crate) of: Vec<T>,
    /// How they were found.
    pub(crate) null: Null,
    /// The smallest p that so many people can reach.
    pub(crate) smallest_p: f64,
}

impl<T> Arranged<T> {
    /// The p value if so many of them are as extreme as what was observed.
    pub(crate) fn share(&self, extreme: usize) -> f64 {
        match self.null {
            Null::Sampled { draws } => (1 + extreme) as f64 / (1 + draws) as f64,
            Null::Exact | Null::Normal => extreme as f64 / self.of.len() as f64,
        }
    }
}

/// What `of` gives of each arrangement of the labels of people within their blocks, of whom the first `na` are of the first
/// group: it takes the places of those who would be. Up to 20,000 arrangements are counted, beyond these they are drawn
/// by `sampling`.
pub(crate) fn arranged<T: Send>(
    blocks: &[usize],
    na: usize,
    sampling: Sampling,
    of: impl Fn(&[usize]) -> T + Sync,
) -> Arranged<T> {
    // The people of each block, and how many of them are of the first group.
    let mut people: BTreeMap<usize, (Vec<usize>, usize)> = BTreeMap::new();
    for (place, block) in blocks.iter().enumerate() {
        let (own, of_first) = people.entry(*block).or_default();
        own.push(place);
        *of_first += usize::from(place < na);
    }
    let people: Vec<(Vec<usize>, usize)> = people.into_values().collect();
    let all = people.iter().try_fold(1_u64, |all, (own, of_first)| {
        let all = all * arrangements(own.len(), *of_first)?;
        (all <= MOST_ARRANGEMENTS).then_some(all)
    });
    let Some(all) = all else {
        let draws = (0..sampling.draws as u64).into_par_iter();
        let drawn = draws.map(|number| {
            let mut rng = stream(sampling.seed, number);
            let mut first = Vec::with_capacity(na);
            for (own, of_first) in &people {
                let mut order = own.clone();
                for place in 0..*of_first {
                    let other = place + index_below(&mut rng, order.len() - place);
                    order.swap(place, other);
                }
                first.extend(&order[..*of_first]);
            }
            of(&first)
        });
        let smallest_p = 1.0 / (1 + sampling.draws) as f64;
        let null = Null::Sampled { draws: sampling.draws };
        return Arranged { of: drawn.collect(), null, smallest_p };
    };
    let counted = people.iter().fold(vec![Vec::new()], |before: Vec<Vec<usize>>, (own, number)| {
        let more = choices(own, *number);
        let with = |first: &Vec<usize>| {
            let first = first.clone();
            more.iter().map(move |more| [&first[..], more].concat()).collect::<Vec<_>>()
        };
        before.iter().flat_map(with).collect()
    });
    // Where every block has as many of one as of the other an arrangement and its mirror have one t.
    let mirrored = people.iter().all(|(own, of_first)| own.len() == 2 * of_first);
    let smallest_p = if mirrored && all > 1 { 2.0 } else { 1.0 } / all as f64;
    Arranged { of: counted.iter().map(|first| of(first)).collect(), null: Null::Exact, smallest_p }
}

/// Every choice of `number` of these, in the order of a dictionary.
fn choices(of: &[usize], number: usize) -> Vec<Vec<usize>> {
    if number == 0 {
        return vec![Vec::new()];
    }
    let firsts = of.iter().enumerate().take(of.len() + 1 - number);
    let with_first = firsts.flat_map(|(place, first)| {
        let rest = choices(&of[place + 1..], number - 1).into_iter();
        rest.map(|rest| [&[*first][..], &rest].concat())
    });
    with_first.collect()
}

/// n over k, if no more than can be counted.
fn arrangements(n: usize, k: usize) -> Option<u64> {
    let k = k.min(n - k);
    let mut count = 1_u64;
    for i in 0..k as u64 {
        // Whole at each step: a product of i + 1 neighbours.
        count = count * (n as u64 - i) / (i + 1);
        if count > MOST_ARRANGEMENTS {
            return None;
        }
    }
    Some(count)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLING: Sampling = Sampling { draws: 9_999, seed: 1 };

    #[test]
    fn labels_within_blocks_are_those_of_every_subset_with_as_many_in_each_block() {
        let people: Vec<f64> =
            (0..11).map(|i| u([i, 3, 0]) + if i < 5 { 0.6 } else { 0.0 }).collect();
        let blocks = [0, 0, 1, 1, 2, 0, 0, 1, 1, 2, 2];
        let (a, b) = people.split_at(5);
        let found = permuted_within([a, b], [&blocks[..5], &blocks[5..]], SAMPLING).unwrap();
        // Every subset of five of eleven, by the bits of a number.
        let t2 = |is_first: &dyn Fn(usize) -> bool| {
            let side = |side: bool| -> Vec<f64> {
                (0..11).filter(|i| is_first(*i) == side).map(|i| people[i]).collect()
            };
            let [a, b] = [side(true), side(false)].map(|values| group(&values));
            difference([a, b], 0.95).unwrap().statistic.powi(2)
        };
        let observed = t2(&|i| i < 5);
        let allowed = (0..1_u32 << 11).filter(|bits| {
            let of_block = |block: usize| {
                (0..11).filter(|i| blocks[*i] == block && bits >> i & 1 == 1).count()
            };
            [0, 1, 2].map(of_block) == [2, 2, 1]
        });
        let all: Vec<f64> = allowed.map(|bits| t2(&|i| bits >> i & 1 == 1)).collect();
        assert_eq!(all.len(), 6 * 6 * 3);
        let extreme = all.iter().filter(|t2| **t2 >= observed * (1.0 - 1e-12)).count();
        assert!((found.p_value - extreme as f64 / all.len() as f64).abs() < 1e-15);
        assert_eq!((found.smallest_p, found.null), (1.0 / 108.0, Null::Exact));
        // Beyond what is counted they are drawn.
        let many: Vec<f64> =
            (0..40).map(|i| u([i, 5, 0]) + if i < 20 { 0.2 } else { 0.0 }).collect();
        let of = |i: usize| i % 20 / 2;
        let blocks: Vec<usize> = (0..40).map(of).collect();
        let drawn =
            permuted_within([&many[..20], &many[20..]], [&blocks[..20], &blocks[20..]], SAMPLING);
        assert_eq!(drawn.unwrap().null, Null::Sampled { draws: 9_999 });
        assert!(permuted_within([a, b], [&[0; 5], &[0; 5]], SAMPLING).is_err());
    }

    /// A number between −½ and ½ that anybody can make again: (h³ mod 9941)/9941 − ½.
    fn u(of: [u64; 3]) -> f64 {
        let h = 1 + 131 * of[0] + 173 * of[1] + 197 * of[2];
        (h * h * h % 9941) as f64 / 9941.0 - 0.5
    }

    /// Means of a person in a mode (0 active, 2 hybrid) over four repeats of values to three decimals, of
    /// twelve people of whom the last five are experts.
    fn mean_in(person: u64, mode: u64) -> f64 {
        let expert = if person > 7 { 1.0 } else { 0.0 };
        let hybrid = if mode == 2 { 1.0 } else { 0.0 };
        let repeats = (1..=4).map(|repeat| {
            let value = 2.0
                + 0.25 * mode as f64
                + (0.15 + 0.3 * expert) * hybrid
                + 0.8 * u([person, 0, 0])
                + 0.6 * (1.0 + 2.0 * expert) * u([person, mode + 1, 0])
                + 0.4 * u([person, mode + 1, repeat]);
            (value * 1000.0).round() / 1000.0
        });
        repeats.sum::<f64>() / 4.0
    }

    /// Experts and novices, by the value of a person.
    fn groups(value: impl Fn(u64) -> f64) -> [Vec<f64>; 2] {
        [(8..=12).map(&value).collect(), (1..=7).map(&value).collect()]
    }

    fn contrast(person: u64) -> f64 {
        mean_in(person, 2) - mean_in(person, 0)
    }

    fn near(found: f64, expected: f64) {
        assert!((found - expected).abs() <= 1e-6 * expected.abs(), "{found} {expected}");
    }

    #[track_caller]
    fn check(found: &Tested, expected: [f64; 7]) {
        let Tested { estimate, std_error, statistic, df, p_value, ci_low, ci_high } = *found;
        let found = [estimate, std_error, statistic, df, p_value, ci_low, ci_high];
        found.into_iter().zip(expected).for_each(|(found, expected)| near(found, expected));
    }

    /// R 4.2: `t.test(expert, novice)`; SciPy 1.17: the test of two independent samples without equal variances.
    #[test]
    fn differences_between_groups_are_those_of_r_and_scipy() {
        let of =
            |values: [Vec<f64>; 2]| difference(values.map(|values| group(&values)), 0.95).unwrap();
        check(
            &of(groups(contrast)),
            [
                0.0245571429,
                0.408888294,
                0.0600583172,
                4.33041842,
                0.954780048,
                -1.07733935,
                1.12645364,
            ],
        );
        check(
            &of(groups(|person| mean_in(person, 2))),
            [
                0.161135714,
                0.317231867,
                0.507943026,
                5.33019637,
                0.631813917,
                -0.639372133,
                0.961643561,
            ],
        );
        let over_modes = |person| (0..3).map(|mode| mean_in(person, mode)).sum::<f64>() / 3.0;
        check(
            &of(groups(over_modes)),
            [
                0.00707857143,
                0.227658336,
                0.0310929595,
                5.98639374,
                0.976206109,
                -0.550288365,
                0.564445508,
            ],
        );
    }

    /// The same numbers from R's `contrasts` of the two groups' means, and NumPy.
    #[test]
    fn each_group_has_the_same_weight_in_the_mean() {
        let found = mean(&groups(contrast).map(|values| group(&values)), 0.95).unwrap();
        near(found.estimate, 0.667921429);
        near(found.std_error, 0.204444147);
        near(found.statistic, 3.26701174);
        near(found.df, 4.33041842);
        near(found.p_value, 0.0274871718);
    }

    /// R: `oneway.test(c ~ band)`.
    #[test]
    fn the_test_of_three_groups_is_welchs_f_of_r() {
        let bands = [0, 1, 2].map(|band| {
            let people = (1..=12).filter(|person| person % 3 == band);
            group(&people.map(contrast).collect::<Vec<_>>())
        });
        let found = any_difference(&bands).unwrap();
        near(found.statistic, 1.58017655);
        near(found.df_den, 4.52137704);
        near(found.p_value, 0.301728201);
        assert!((found.df_num - 2.0).abs() < 1e-12);
        // Of two groups it is the square of Welch's t.
        let two = groups(contrast).map(|values| group(&values));
        let (f, t) = (any_difference(&two).unwrap(), difference(two, 0.95).unwrap());
        near(f.statistic, t.statistic * t.statistic);
        near(f.df_den, t.df);
        near(f.p_value, t.p_value);
    }

    /// Counted with Python's `itertools.combinations`: 742 and 531 of 792 arrangements.
    #[test]
    fn labels_are_permuted_in_every_arrangement() {
        let [a, b] = groups(contrast);
        let found = permuted(&a, &b, SAMPLING).unwrap();
        near(found.p_value, 742.0 / 792.0);
        near(found.smallest_p, 1.0 / 792.0);
        let [a, b] = groups(|person| mean_in(person, 2));
        near(permuted(&a, &b, SAMPLING).unwrap().p_value, 531.0 / 792.0);
        near(permuted(&b, &a, SAMPLING).unwrap().p_value, 531.0 / 792.0);
        // Three and three: twenty arrangements, of which each has its mirror.
        let found = permuted(&[1.0, 2.0, 3.0], &[11.0, 12.0, 13.0], SAMPLING).unwrap();
        near(found.p_value, 0.1);
        near(found.smallest_p, 0.1);
    }

    #[test]
    fn drawn_arrangements_come_near_the_counted_ones_and_are_the_same_on_any_number_of_threads() {
        let many: Vec<f64> = (1..=40).map(|person| u([person, 5, 0])).collect();
        let (a, b) = many.split_at(16);
        let run = || permuted(a, b, SAMPLING).unwrap();
        let on = |threads| {
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run)
        };
        assert_eq!(on(1), on(3));
        assert_eq!(on(1).null, Null::Sampled { draws: 9_999 });
        // Of so many people the distribution of labels is near that of t.
        let t = difference([group(a), group(b)], 0.95).unwrap();
        assert!((on(2).p_value - t.p_value).abs() < 0.02, "{} {}", on(2).p_value, t.p_value);
    }

    #[test]
    fn differences_between_groups_have_a_size_without_unit() {
        let found = effect(groups(contrast).map(|values| group(&values)), 0.95).unwrap();
        near(found.d, 0.0376880380);
        near(found.g.unwrap(), 0.0309151729);
        let [low, high] = found.interval.unwrap();
        near(low, -1.19457246);
        near(high, 1.26575650);
    }

    #[test]
    fn small_and_constant_groups_say_what_they_lack() {
        let of = |values: &[f64]| group(values);
        let alone = difference([of(&[1.0, 2.0]), of(&[3.0])], 0.95).unwrap_err();
        assert_eq!(alone.to_string(), "1 participant of a group, 2 are needed");
        let alike = difference([of(&[0.1 + 0.2, 0.3]), of(&[0.4, 0.4])], 0.95).unwrap_err();
        assert_eq!(alike, Unestimable::Constant { units: PEOPLE });
        assert!(mean(&[], 0.95).is_err() && any_difference(&[of(&[1.0, 2.0])]).is_err());
        assert!(any_difference(&[of(&[1.0, 1.0]), of(&[1.0, 2.0])]).is_err());
        assert!(permuted(&[1.0], &[1.0, 2.0], SAMPLING).is_err());
        assert!(permuted(&[2.0, 2.0], &[2.0, 2.0], SAMPLING).is_err());
        assert!(permuted(&[1e200, 2e200], &[3e200, -1e200], SAMPLING).is_err());
        assert!(permuted(&[f64::NAN, 2.0], &[2.0, 2.0], SAMPLING).is_err());
        assert!(difference([of(&[1.0, 2.0]), of(&[3.0, 4.0])], 1.0).is_err());
    }
}
