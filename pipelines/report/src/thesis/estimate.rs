//! A mean, or the difference of two, with its interval: over participants if there are several,
//! else over the trials of the only one.

use crate::trials::{People, mean_of_one};
use zwidth_numerics::moments::Moments;
use zwidth_stats::welch::{self, Group};
use zwidth_stats::{Tested, Unestimable, paired};

/// How far an estimate may be off.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Spread {
    Interval([f64; 2]),
    /// All values are one: there is no scatter to judge by, and nothing but the value.
    Equal,
    /// Too few values, in words.
    Unknown(String),
}

/// A number, and what it is over. Unit as the values.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Estimated {
    pub(crate) value: f64,
    pub(crate) spread: Spread,
    pub(crate) n: usize,
    /// The unit of analysis: `participants`, or `trials of P01`.
    pub(crate) over: String,
}

/// The mean over participants of each one's mean, sessions with equal weight, with its t interval
/// at `level`; of one participant the mean of the sessions' means, with that of Welch, sessions as
/// strata. None without a value.
pub(crate) fn mean(people: &People, level: f64) -> Option<Estimated> {
    let (who, sessions) = people.first_key_value()?;
    if people.len() > 1 {
        return Some(over_participants(people.values().map(mean_of_one).collect(), level));
    }
    let groups: Vec<Group> = sessions.values().map(|values| group(values)).collect();
    let n = groups.iter().map(|group| group.n).sum();
    let value = mean_of_one(sessions);
    let spread = spread(welch::mean(&groups, level));
    Some(Estimated { value, spread, n, over: format!("trials of {who}") })
}

/// The mean of `a` less that of `b`, within each participant who has both ([`paired`]); of one
/// participant by Welch within each session that has both. None where nobody has both.
pub(crate) fn difference(a: &People, b: &People, level: f64) -> Option<Estimated> {
    let both: Vec<_> = a.iter().filter_map(|(who, a)| Some((who, a, b.get(who)?))).collect();
    let (who, of_a, of_b) = *both.first()?;
    if both.len() > 1 {
        let pairs = both.iter().map(|(_, a, b)| [mean_of_one(a), mean_of_one(b)]);
        return Some(over_participants(paired::differences(&pairs.collect::<Vec<_>>()), level));
    }
    let strata: Vec<[Group; 2]> = of_a
        .iter()
        .filter_map(|(session, a)| Some([group(a), group(of_b.get(session)?)]))
        .collect();
    let differences = strata.iter().map(|[a, b]| a.mean - b.mean);
    let value = differences.sum::<f64>() / strata.len() as f64;
    let n = strata.iter().flatten().map(|group| group.n).sum();
    let spread = spread(welch::difference(&strata, level));
    // Without a session in common the value above is 0 / 0, and is not given out.
    (!strata.is_empty()).then(|| Estimated { value, spread, n, over: format!("trials of {who}") })
}

fn over_participants(values: Vec<f64>, level: f64) -> Estimated {
    Estimated {
        value: values.iter().sum::<f64>() / values.len() as f64,
        spread: spread(paired::mean_difference(&values, level)),
        n: values.len(),
        over: "participants".to_owned(),
    }
}

fn group(values: &[f64]) -> Group {
    let moments = Moments::of(values);
    Group { n: values.len(), mean: moments.mean, sd: moments.sd().unwrap_or_default() }
}

fn spread(tested: Result<Tested, Unestimable>) -> Spread {
    match tested {
        Ok(tested) => Spread::Interval([tested.ci_low, tested.ci_high]),
        Err(Unestimable::Constant { .. } | Unestimable::NoDifference) => Spread::Equal,
        Err(why) => Spread::Unknown(why.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn people(values: &[(&str, &str, &[f64])]) -> People {
        let mut people = People::new();
        for (who, session, values) in values {
            let sessions = people.entry(who.parse().unwrap()).or_default();
            sessions.insert(session.parse().unwrap(), values.to_vec());
        }
        people
    }

    fn near(found: &Estimated, value: f64, ends: [f64; 2]) {
        let Spread::Interval(found_ends) = found.spread else { panic!("{found:?}") };
        let all = [(found.value, value), (found_ends[0], ends[0]), (found_ends[1], ends[1])];
        assert!(all.iter().all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
    }

    /// R: `t.test(c(2, 4, 9))`: each participant counts once, and within her each session.
    #[test]
    fn several_participants_are_the_units_whatever_their_trials() {
        let of = [
            ("P01", "S01", &[1.0, 3.0][..]),
            ("P02", "S01", &[3.0]),
            ("P02", "S02", &[5.0, 5.0, 5.0]),
            ("P03", "S01", &[9.0]),
        ];
        let found = mean(&people(&of), 0.95).unwrap();
        near(&found, 5.0, [-3.956_685_895, 13.956_685_895]);
        assert_eq!((found.n, found.over.as_str()), (3, "participants"));
    }

    /// R: `t.test(c(1, 2, 3, 6))` and `t.test(c(1, 2, 3, 6), c(4, 5, 7))`.
    #[test]
    fn one_participant_has_the_interval_of_her_trials_and_it_is_said() {
        let a = people(&[("P01", "S01", &[1.0, 2.0, 3.0, 6.0])]);
        let found = mean(&a, 0.95).unwrap();
        near(&found, 3.0, [-0.437_434_882, 6.437_434_882]);
        assert_eq!((found.n, found.over.as_str()), (4, "trials of P01"));
        let b = people(&[("P01", "S01", &[4.0, 5.0, 7.0])]);
        let found = difference(&a, &b, 0.95).unwrap();
        near(&found, -7.0 / 3.0, [-5.917_838_445, 1.251_171_778]);
        assert_eq!(found.n, 7);
    }

    #[test]
    fn without_scatter_or_with_one_value_there_is_no_interval() {
        let of = |values: &[f64]| mean(&people(&[("P01", "S01", values)]), 0.95).unwrap().spread;
        assert_eq!(of(&[2.0, 2.0]), Spread::Equal);
        assert!(matches!(of(&[2.0]), Spread::Unknown(why) if why.contains('2')));
        assert_eq!(mean(&People::new(), 0.95), None);
        let [a, b] = ["P01", "P02"].map(|who| people(&[(who, "S01", &[1.0, 2.0])]));
        assert_eq!(difference(&a, &b, 0.95), None);
    }
}
