//! Two sessions of the same people: as alike as sessions of real people, and not copies.

use super::rehearsal::*;
use crate::{Person, Twin, TwinParameters};
use zwidth_study::ModeLaw;

const PEOPLE: u64 = 160;
const TRIALS: u32 = 4;

/// Of a trial: onset, s; greatest speed, rad/s; from onset to the end, s; the answer.
type Numbers = [f64; 4];

fn numbers(trial: &Rehearsal) -> Numbers {
    let moves = |row: &RehearsedTick| row.state.theta_dot_rad_s.abs() > 10_f64.to_radians();
    let first = trial.rows.iter().position(moves).unwrap();
    let last = trial.rows.iter().rposition(moves).unwrap();
    let fastest = trial.rows.iter().map(|row| row.state.theta_dot_rad_s).fold(0.0, f64::max);
    let [onset_s, end_s] = [first, last].map(|i| trial.rows[i].sample.t_s);
    [onset_s, fastest, end_s - onset_s, f64::from(trial.answer)]
}

/// The trials of a person in a session.
fn session(person: u64, day: u64) -> Vec<Numbers> {
    let somebody = Person::draw(person).in_session(1000 * (1 + day) + person, 36 * day as u32);
    let mut twin = Twin::new(TwinParameters::default(), somebody, 7 * person + day).unwrap();
    let one = |trial| numbers(&rehearse(&mut twin, ModeLaw::Hybrid, &spring(), 120.0, trial));
    (10..10 + TRIALS).map(one).collect()
}

fn mean(trials: &[Numbers], i: usize) -> f64 {
    trials.iter().map(|trial| trial[i]).sum::<f64>() / trials.len() as f64
}

/// Pearson's r.
fn correlation(pairs: &[[f64; 2]]) -> f64 {
    let n = pairs.len() as f64;
    let mean = [0, 1].map(|i| pairs.iter().map(|pair| pair[i]).sum::<f64>() / n);
    let sum = |i: usize, j: usize| -> f64 {
        pairs.iter().map(|pair| (pair[i] - mean[i]) * (pair[j] - mean[j])).sum()
    };
    sum(0, 1) / (sum(0, 0) * sum(1, 1)).sqrt()
}

/// Little et al. 2015, Table 3, right arm, a week apart, 95 % intervals: reaction time 0.84 (0.68
/// to 0.92), greatest speed 0.83 (0.66 to 0.92), movement time 0.76 (0.53 to 0.88). Answers: kappas
/// of rating scales asked twice are 0.50 to 0.64, within a point 0.84 to 0.95 (Tourangeau et al.
/// 2019).
#[test]
fn two_sessions_of_a_person_are_as_alike_as_two_days_and_no_copies() {
    let people: Vec<[Vec<Numbers>; 2]> =
        (0..PEOPLE).map(|person| [0, 1].map(|day| session(person, day))).collect();
    let expected = [[0.68, 0.92], [0.66, 0.92], [0.53, 0.88], [0.45, 0.95]];
    for (i, [low, high]) in expected.into_iter().enumerate() {
        let means: Vec<[f64; 2]> =
            people.iter().map(|days| [0, 1].map(|day| mean(&days[day], i))).collect();
        let between = correlation(&means);
        assert!((low..high).contains(&between), "{i}: {between}");
        let off = |days: &[Vec<Numbers>; 2], trial: usize| {
            [0, 1].map(|day: usize| days[day][trial][i] - mean(&days[day], i))
        };
        let repeats: Vec<[f64; 2]> = people
            .iter()
            .flat_map(|days| (0..TRIALS as usize).map(move |trial| off(days, trial)))
            .collect();
        let within = correlation(&repeats);
        assert!(within.abs() < 0.25, "{i}: {within}");
    }
}
