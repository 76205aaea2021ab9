use super::design::reduce;
use super::profile::profile;
use super::trials::{Dosed, Term, Trials, fit_doses, fit_trials};
use super::*;
use crate::tested::{Tested, Unestimable};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Standard normal numbers by Box & Muller.
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let uniform = |rng: &mut ChaCha8Rng| (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let (u, v) = (1.0 - uniform(rng), uniform(rng));
    (-2.0 * libm::log(u)).sqrt() * libm::cos(2.0 * core::f64::consts::PI * v)
}

/// A study's tidy table.
#[derive(Default, Clone)]
struct Table {
    participant: Vec<usize>,
    session: Vec<usize>,
    mode: Vec<usize>,
    value: Vec<f64>,
}

impl Table {
    fn trials(&self) -> Trials<'_> {
        Trials {
            participant: &self.participant,
            session: &self.session,
            mode: &self.mode,
            value: &self.value,
        }
    }

    fn push(&mut self, participant: usize, session: usize, mode: usize, value: f64) {
        self.participant.push(participant);
        self.session.push(session);
        self.mode.push(mode);
        self.value.push(value);
    }

    fn without(&self, dropped: impl Fn(usize, usize, usize) -> bool) -> Self {
        let mut left = Self::default();
        for row in 0..self.value.len() {
            let (p, s, m) = (self.participant[row], self.session[row], self.mode[row]);
            if !dropped(p, s, m) {
                left.push(p, s, m, self.value[row]);
            }
        }
        left
    }
}

/// SDs of participant, × mode, × session, × session × mode and residual.
type Sds = [f64; 5];

fn simulate(seed: u64, [people, sessions, modes, repeats]: [usize; 4], sds: Sds) -> Table {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut table = Table::default();
    for p in 0..people {
        let own = sds[0] * normal(&mut rng);
        let by_mode: Vec<f64> = (0..modes).map(|_| sds[1] * normal(&mut rng)).collect();
        for s in 0..sessions {
            let by_session = sds[2] * normal(&mut rng);
            for (m, by_mode) in by_mode.iter().enumerate() {
                let by_both = sds[3] * normal(&mut rng);
                for _ in 0..repeats {
                    let value = m as f64 + own + by_mode + by_session + by_both;
                    table.push(p, s, m, value + sds[4] * normal(&mut rng));
                }
            }
        }
    }
    table
}

fn model_of(table: &Table, terms: usize) -> Model {
    let product = |a: &[usize], b: &[usize]| a.iter().zip(b).map(|(a, b)| a * 10 + b).collect();
    let all = [
        RandomTerm::intercept("participant", vec![0; table.value.len()]),
        RandomTerm::intercept("participant × mode", table.mode.clone()),
        RandomTerm::intercept("participant × session", table.session.clone()),
        RandomTerm::intercept("participant × session × mode", product(&table.session, &table.mode)),
    ];
    let indicator = |mode: usize| Column {
        name: format!("mode {mode}"),
        values: table.mode.iter().map(|m| f64::from(u8::from(*m == mode))).collect(),
    };
    Model {
        response: table.value.clone(),
        fixed: (0..3).map(indicator).collect(),
        group: table.participant.clone(),
        random: all[..terms].to_vec(),
    }
}

/// Straight lines of people with their own intercepts and slopes.
fn lines(seed: u64, people: usize) -> Model {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut response, mut time, mut group) = (Vec::new(), Vec::new(), Vec::new());
    for p in 0..people {
        let (a, b) = (normal(&mut rng), normal(&mut rng));
        for t in 0..8 {
            let t = f64::from(t);
            response.push(10.0 + 2.0 * a + (3.0 + 0.7 * a + 0.7 * b) * t + 0.5 * normal(&mut rng));
            time.push(t);
            group.push(p);
        }
    }
    let ones = vec![1.0; time.len()];
    Model {
        fixed: vec![
            Column { name: "level".into(), values: ones.clone() },
            Column { name: "time".into(), values: time.clone() },
        ],
        random: vec![RandomTerm {
            name: "time | participant".into(),
            level: vec![0; time.len()],
            columns: vec![ones, time],
        }],
        response,
        group,
    }
}

fn relative(found: f64, expected: f64) -> f64 {
    (found / expected - 1.0).abs()
}

/// With k values of each of m groups the REML estimates are those of the analysis of variance:
/// σ² = MS within, σ_b² = (MS between − MS within) / k, and the mean has m − 1 degrees of freedom.
#[test]
fn balanced_groups_have_the_variances_of_the_analysis_of_variance() {
    let table = simulate(1, [7, 1, 1, 5], [1.5, 0.0, 0.0, 0.0, 0.8]);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let people: Vec<f64> = table.value.chunks(5).map(mean).collect();
    let total = mean(&people);
    let between = 5.0 * people.iter().map(|m| (m - total) * (m - total)).sum::<f64>() / 6.0;
    let square = |(row, v): (usize, &f64)| (v - people[row / 5]) * (v - people[row / 5]);
    let within = table.value.iter().enumerate().map(square).sum::<f64>() / 28.0;
    let found = fit_trials(table.trials()).unwrap();
    assert_eq!(found.structure, [Term::Participant]);
    assert!(relative(found.fit.residual_variance, within) < 1e-9);
    assert!(relative(found.fit.terms[0].covariance[0][0], (between - within) / 5.0) < 1e-9);
    let test = found.fit.kenward_roger().unwrap().test(&[1.0], 0.95).unwrap();
    assert!(relative(test.std_error, (between / 35.0).sqrt()) < 1e-9);
    assert!(relative(test.df, 6.0) < 1e-9 && relative(test.estimate, total) < 1e-12);
    let second = found.fit.satterthwaite().unwrap().test(&[1.0], 0.95).unwrap();
    assert!(relative(second.df, 6.0) < 1e-7, "{}", second.df);
}

#[test]
fn the_gradient_is_that_of_finite_differences() {
    let table = simulate(2, [6, 2, 3, 3], [1.0, 0.7, 0.5, 0.3, 0.6])
        .without(|p, s, m| (p, s, m) == (1, 0, 2) || (p == 3 && s == 1));
    let models =
        [(model_of(&table, 4), vec![0.9, 0.4, -0.6, 0.2]), (lines(3, 5), vec![0.8, 0.3, 1.2])];
    for (model, theta) in models {
        let design = reduce(&model).unwrap();
        for reml in [false, true] {
            let at = |theta: &[f64]| profile(&design, reml, theta).unwrap();
            let gradient = at(&theta).gradient;
            for j in 0..theta.len() {
                let step = 1e-5;
                let (mut up, mut down) = (theta.clone(), theta.clone());
                (up[j], down[j]) = (up[j] + step, down[j] - step);
                let numeric = (at(&up).deviance - at(&down).deviance) / (2.0 * step);
                assert!((gradient[j] - numeric).abs() < 1e-6 * (1.0 + numeric.abs()), "{reml} {j}");
            }
        }
    }
}

/// Groups of one design are summed before anything is computed; nudging a column of the design by
/// 1e-13 makes each a design of its own.
#[test]
fn groups_that_share_a_design_give_what_they_give_alone() {
    let table = simulate(4, [9, 2, 3, 2], [1.0, 0.7, 0.5, 0.3, 0.6]);
    let shared = model_of(&table, 4);
    let mut alone = shared.clone();
    for (row, p) in table.participant.iter().enumerate() {
        alone.random[0].columns[0][row] += *p as f64 * 1e-13;
    }
    assert_eq!(reduce(&shared).unwrap().patterns.len(), 1);
    assert_eq!(reduce(&alone).unwrap().patterns.len(), 9);
    let [shared, alone] = [shared, alone].map(|model| fit(&model, Criterion::Reml).unwrap());
    assert!((shared.deviance - alone.deviance).abs() < 1e-9);
    let test = |fit: &Fit| fit.kenward_roger().unwrap().test(&[1.0, -1.0, 0.0], 0.95).unwrap();
    assert!(relative(test(&shared).df, test(&alone).df) < 1e-6);
    assert!(relative(test(&shared).std_error, test(&alone).std_error) < 1e-8);
}

#[test]
fn what_was_simulated_is_found_again() {
    let sds = [1.2, 0.8, 0.5, 0.3, 0.6];
    let found = fit_trials(simulate(5, [1500, 2, 3, 3], sds).trials()).unwrap();
    assert_eq!(found.structure.len(), 4);
    for (term, sd) in found.fit.terms.iter().zip(sds) {
        let estimate = term.covariance[0][0].sqrt();
        assert!(relative(estimate, sd) < 0.06, "{}: {estimate} for {sd}", term.name);
    }
    assert!(relative(found.fit.residual_variance, 0.36) < 0.03 && !found.fit.singular);
    let fitted = fit(&lines(6, 2000), Criterion::Reml).unwrap();
    let covariance = &fitted.terms[0].covariance;
    for (found, expected) in [
        (covariance[0][0], 4.0),
        (covariance[0][1], 1.4),
        (covariance[1][0], 1.4),
        (covariance[1][1], 0.98),
        (fitted.residual_variance, 0.25),
    ] {
        assert!(relative(found, expected) < 0.1, "{found} {expected}");
    }
    assert!((fitted.coefficients[1] - 3.0).abs() < 0.1);
}

/// On complete data without a variance at zero the F of Kenward & Roger is that of the
/// participants' means, its degrees of freedom (m − 1) and (n − 1)(m − 1).
#[test]
fn complete_data_have_the_f_of_participants_means() {
    let (n, modes) = (8, 3);
    let table = simulate(7, [n, 1, modes, 4], [1.0, 0.9, 0.0, 0.0, 0.5]);
    let mean = |rows: &[f64]| rows.iter().sum::<f64>() / rows.len() as f64;
    let cells: Vec<f64> = table.value.chunks(4).map(mean).collect();
    let cell = |p: usize, m: usize| cells[p * modes + m];
    let of_person = |p: usize| (0..modes).map(|m| cell(p, m)).sum::<f64>() / modes as f64;
    let of_mode = |m: usize| (0..n).map(|p| cell(p, m)).sum::<f64>() / n as f64;
    let total = mean(&cells);
    let between: f64 = (0..modes).map(|m| (of_mode(m) - total).powi(2)).sum::<f64>() * n as f64;
    let error: f64 = (0..n)
        .flat_map(|p| (0..modes).map(move |m| (p, m)))
        .map(|(p, m)| (cell(p, m) - of_person(p) - of_mode(m) + total).powi(2))
        .sum();
    let f = (between / 2.0) / (error / 14.0);
    let found = fit_trials(table.trials()).unwrap();
    assert_eq!(found.structure, [Term::Participant, Term::ParticipantMode]);
    let weights = found.differences().unwrap();
    let weights: Vec<&[f64]> = weights.iter().map(Vec::as_slice).collect();
    let tests = [
        found.fit.kenward_roger().unwrap().test_all(&weights).unwrap(),
        found.fit.satterthwaite().unwrap().test_all(&weights).unwrap(),
    ];
    for test in tests {
        assert!(relative(test.statistic, f) < 1e-8, "{} {f}", test.statistic);
        assert!(
            relative(test.df_num, 2.0) < 1e-12 && relative(test.df_den, 14.0) < 1e-6,
            "{}",
            test.df_den
        );
    }
}

/// Dyestuff2's case: MS between below MS within. The variance is exactly zero, the criterion's
/// slope in it is upwards, and Kenward & Roger keep it as a parameter.
#[test]
fn a_variance_at_zero_is_an_outcome_and_keeps_its_degrees_of_freedom() {
    let mut table = simulate(8, [6, 1, 1, 5], [0.0, 0.0, 0.0, 0.0, 1.0]);
    for rows in table.value.chunks_mut(5) {
        let mean = rows.iter().sum::<f64>() / 5.0;
        rows.iter_mut().for_each(|v| *v -= 0.9 * mean);
    }
    let found = fit_trials(table.trials()).unwrap().fit;
    assert!(found.singular && found.bound_slope.unwrap() > 0.0 && found.slope < 1e-6);
    assert_eq!(found.terms[0].covariance[0][0].to_bits(), 0.0_f64.to_bits());
    let df = |test: Tested| test.df;
    assert!(relative(df(found.kenward_roger().unwrap().test(&[1.0], 0.95).unwrap()), 5.0) < 1e-9);
    assert!(relative(df(found.satterthwaite().unwrap().test(&[1.0], 0.95).unwrap()), 29.0) < 1e-9);
}

#[test]
fn the_structure_is_the_largest_that_the_design_supports() {
    use Term::{Participant, ParticipantMode, ParticipantSession, ParticipantSessionMode};
    let sds = [1.0, 0.7, 0.5, 0.3, 0.6];
    let cases: [([usize; 4], &[Term]); 5] = [
        ([6, 2, 3, 3], &[Participant, ParticipantMode, ParticipantSession, ParticipantSessionMode]),
        ([6, 2, 3, 1], &[Participant, ParticipantMode, ParticipantSession]),
        ([6, 1, 3, 2], &[Participant, ParticipantMode]),
        ([6, 2, 1, 2], &[Participant, ParticipantSession]),
        ([6, 1, 3, 1], &[Participant]),
    ];
    for (size, structure) in cases {
        let found = fit_trials(simulate(9, size, sds).trials()).unwrap();
        assert_eq!(found.structure, structure, "{size:?}");
    }
}

#[test]
fn a_contrast_averages_the_sessions_equally_whatever_their_trials() {
    let table = simulate(10, [8, 2, 3, 4], [1.0, 0.4, 0.3, 0.2, 0.5]);
    let mut copy = table.without(|p, s, m| s == 1 && m == 2 && p == 7);
    copy.push(3, 1, 1, 1.3);
    let found = fit_trials(copy.trials()).unwrap();
    let weights = found.difference(2, 0).unwrap();
    let cells = [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2)];
    assert_eq!(
        (found.cells.as_slice(), weights.as_slice()),
        (&cells[..], &[-0.5, 0.0, 0.5, -0.5, 0.0, 0.5][..])
    );
    let lone = fit_trials(table.without(|_, s, m| s == 1 && m == 2).trials()).unwrap();
    assert_eq!(lone.difference(2, 0).unwrap(), [-1.0, 0.0, 1.0, 0.0, 0.0]);
}

#[test]
fn what_the_data_cannot_say_is_said_in_words() {
    let table = simulate(11, [5, 1, 3, 3], [1.0, 0.5, 0.0, 0.0, 0.5]);
    let one = table.without(|p, _, _| p > 0);
    assert!(matches!(fit_trials(one.trials()), Err(Unestimable::TooFew { found: 1, .. })));
    let mut constant = table.clone();
    constant.value.fill(3.25);
    assert!(matches!(fit_trials(constant.trials()), Err(Unestimable::Constant { .. })));
    let mut copied = table.clone();
    for rows in copied.value.chunks_mut(3) {
        rows.fill(rows[0]);
    }
    assert_eq!(
        fit_trials(copied.trials()).unwrap_err(),
        Unestimable::Constant { units: "repeats" }
    );
    let single = simulate(12, [5, 1, 1, 1], [1.0, 0.5, 0.0, 0.0, 0.5]);
    assert!(matches!(fit_trials(single.trials()), Err(Unestimable::Confounded { .. })));
    let mut nan = table.clone();
    nan.value[4] = f64::NAN;
    assert!(matches!(fit_trials(nan.trials()), Err(Unestimable::Refused(_))));
    let mut twice = model_of(&table, 1);
    twice.fixed.push(twice.fixed[0].clone());
    assert!(matches!(fit(&twice, Criterion::Reml), Err(Unestimable::Confounded { .. })));
    let mut aliased = model_of(&table, 2);
    aliased.random.push(aliased.random[1].clone());
    let refused = fit(&aliased, Criterion::Reml).unwrap_err();
    assert!(matches!(refused, Unestimable::Confounded { .. }), "{refused}");
    let fitted = fit(&model_of(&table, 2), Criterion::Reml).unwrap().kenward_roger().unwrap();
    assert!(fitted.test(&[0.0, 0.0, 0.0], 0.95).is_err() && fitted.test(&[1.0], 0.95).is_err());
    assert!(fitted.test_all(&[]).is_err() && fitted.test(&[1.0, 0.0, 0.0], 95.0).is_err());
    assert!(fitted.test_all(&[&[1.0, -1.0, 0.0], &[-2.0, 2.0, 0.0]]).is_err());
}

/// Values a million away from zero, and a millionth in size, change nothing but the unit.
#[test]
fn the_unit_and_the_origin_of_the_values_do_not_matter() {
    let table = simulate(13, [7, 2, 3, 3], [1.0, 0.7, 0.5, 0.3, 0.6]);
    let mut other = table.clone();
    other.value.iter_mut().for_each(|v| *v = 1e-6 * (*v + 1e4));
    let test = |table: &Table| {
        let found = fit_trials(table.trials()).unwrap();
        found.fit.kenward_roger().unwrap().test(&found.difference(1, 0).unwrap(), 0.95).unwrap()
    };
    let (a, b) = (test(&table), test(&other));
    assert!(relative(a.df, b.df) < 1e-6 && relative(a.statistic, b.statistic) < 1e-7);
    assert!(relative(a.estimate * 1e-6, b.estimate) < 1e-9);
}

/// A number between −½ and ½ that anybody can make again: (h³ mod 9941)/9941 − ½.
fn by_formula(p: usize, a: usize, b: usize) -> f64 {
    let h = 1 + 131 * p + 173 * a + 197 * b;
    (h * h * h % 9941) as f64 / 9941.0 - 0.5
}

fn to_three_decimals(value: f64) -> f64 {
    (value * 1000.0).round() / 1000.0
}

/// lme4 1.1-31 (`REMLcrit`) and pbkrtest 0.5.2 (`KRmodcomp`) on twelve people of two groups in three modes, of whom the last five
/// scatter more: y ~ group * mode + (1 | participant) + (1 | participant:mode).
#[test]
fn two_groups_in_three_modes_have_lme4s_criterion_and_pbkrtests_f() {
    let mut table = Table::default();
    for p in 1..=12 {
        let expert = usize::from(p > 7);
        for m in 0..3 {
            let effect = if m == 2 { 0.15 + 0.3 * expert as f64 } else { 0.0 };
            let own =
                0.8 * by_formula(p, 0, 0) + 0.6 * (1 + 2 * expert) as f64 * by_formula(p, m + 1, 0);
            for r in 1..=4 {
                let value = 2.0 + 0.25 * m as f64 + effect + own + 0.4 * by_formula(p, m + 1, r);
                table.push(p, 0, 3 * expert + m, to_three_decimals(value));
            }
        }
    }
    let fit = fit_trials(table.trials()).unwrap().fit;
    assert!(relative(fit.deviance, -64.6760928) < 1e-8, "{}", fit.deviance);
    let interaction: [&[f64]; 2] =
        [&[1.0, -1.0, 0.0, -1.0, 1.0, 0.0], &[1.0, 0.0, -1.0, -1.0, 0.0, 1.0]];
    let joint = fit.kenward_roger().unwrap().test_all(&interaction).unwrap();
    assert!(relative(joint.statistic, 1.27123) < 1e-5, "{joint:?}");
    assert!((joint.df_num - 2.0).abs() < 1e-12 && relative(joint.df_den, 20.0) < 1e-8);
    assert!(relative(joint.p_value, 0.302193894) < 1e-5, "{joint:?}");
}

/// lme4 and pbkrtest on eight people at four doses: y ~ x + (1 + x | participant) + (1 | participant:level), and with a
/// random intercept alone, which takes repeats for people.
#[test]
fn lines_over_doses_have_lme4s_criterion_and_an_intercept_alone_is_far_too_sure() {
    const DOSES: [f64; 4] = [100.0, 150.0, 250.0, 400.0];
    let (mut people, mut levels, mut dose, mut values) = (vec![], vec![], vec![], vec![]);
    for p in 1..=8 {
        for (l, x) in (1..).zip(DOSES) {
            for r in 1..=3 {
                let mean = 0.5 + 0.004 * x - 0.000_003 * x * x;
                let own = 0.6 * by_formula(p, 0, 0) + 0.003 * by_formula(p, 7, 0) * x;
                let scatter = 0.3 * by_formula(p, l, 0) + 0.3 * by_formula(p, l, r);
                people.push(p);
                levels.push(l);
                dose.push(x / 100.0);
                values.push(to_three_decimals(mean + own + scatter));
            }
        }
    }
    let dosed = Dosed { participant: &people, level: &levels, dose: &dose, value: &values };
    let fitted = fit_doses(dosed).unwrap();
    assert!(relative(fitted.deviance, -117.67382) < 1e-7, "{}", fitted.deviance);
    let slope = fitted.kenward_roger().unwrap().test(&[0.0, 1.0], 0.95).unwrap();
    assert!(relative(slope.std_error, 0.0291889759) < 1e-5 && relative(slope.df, 7.0) < 1e-5);
    let alone = Model {
        fixed: vec![
            Column { name: "level".to_owned(), values: vec![1.0; values.len()] },
            Column { name: "slope".to_owned(), values: dose },
        ],
        random: vec![RandomTerm::intercept("participant", vec![0; values.len()])],
        response: values,
        group: people,
    };
    let alone = fit(&alone, Criterion::Reml).unwrap().kenward_roger().unwrap();
    let slope = alone.test(&[0.0, 1.0], 0.95).unwrap();
    assert!(relative(slope.std_error, 0.0123689614) < 1e-5, "{slope:?}");
    assert!(relative(slope.df, 87.0) < 1e-8, "{slope:?}");
}
