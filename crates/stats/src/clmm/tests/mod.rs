//! Gradients against differences, quadrature against a tensor rule, and simulated studies.

mod gauss_hermite;

use super::cell::Levels;
use super::laplace::{Effects, laplace};
use super::likelihood::Likelihood;
use super::model::Cells;
use super::point::Point;
use super::quadrature::integrate;
use super::*;
use crate::Unestimable;
use crate::answers::Answers;
use crate::bootstrap::{normal, uniform};
use crate::clm;
use gauss_hermite::rule;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// A study: 1 to 5, modes by treatment columns, two sessions.
struct Study {
    answers: Vec<u8>,
    columns: Vec<Column>,
    participants: Vec<usize>,
    modes: Vec<usize>,
}

const THETA: [f64; 4] = [-2.0, -0.5, 0.7, 2.2];
const BETA: [f64; 3] = [0.8, -0.4, 0.3];

/// `people` × 3 modes × 2 sessions × `repeats` answers.
fn study(seed: u64, people: usize, repeats: usize, sd: [f64; 2]) -> Study {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut study = Study { answers: vec![], columns: vec![], participants: vec![], modes: vec![] };
    let mut x = vec![vec![]; 3];
    for participant in 0..people {
        let u = sd[0] * normal(&mut rng);
        for mode in 0..3 {
            let w = sd[1] * normal(&mut rng);
            for session in 0..2 {
                let row = [mode == 1, mode == 2, session == 1].map(|b| f64::from(u8::from(b)));
                let eta = row.iter().zip(BETA).map(|(x, b)| x * b).sum::<f64>() + u + w;
                for _ in 0..repeats {
                    let latent = eta + crate::logistic::logit(uniform(&mut rng));
                    let answer = 1 + THETA.iter().filter(|&&t| t < latent).count();
                    study.answers.push(answer as u8);
                    study.participants.push(participant);
                    study.modes.push(mode);
                    x.iter_mut().zip(row).for_each(|(x, value)| x.push(value));
                }
            }
        }
    }
    let names = ["mode 2", "mode 3", "session 2"];
    let column = |(values, name): (Vec<f64>, &str)| Column { name: name.to_owned(), values };
    study.columns = x.into_iter().zip(names).map(column).collect();
    study
}

impl Study {
    fn ratings(&self) -> Ratings<'_> {
        Ratings {
            answers: &self.answers,
            points: 5,
            columns: &self.columns,
            participants: &self.participants,
            modes: &self.modes,
        }
    }

    fn model(&self, terms: Terms) -> Model {
        Model::new(&self.ratings(), terms).unwrap()
    }
}

/// A study of modes without names.
fn of_modes<'a>(
    answers: &'a [u8],
    participants: &'a [usize],
    modes: &'a [usize],
    sessions: &'a [usize],
) -> ModeStudy<'a> {
    ModeStudy { answers, points: 5, participants, modes, sessions, mode_names: &[] }
}

fn point(sd: [f64; 2]) -> Point {
    Point { theta: THETA.to_vec(), beta: BETA.to_vec(), sd }
}

/// Each component of a gradient against central differences of fourth order.
fn check_gradient(at: &Point, tolerance: f64, mut f: impl FnMut(&Point) -> (f64, Point)) {
    let gradient = f(at).1.list();
    let (thresholds, columns) = (at.theta.len(), at.beta.len());
    for (i, slope) in gradient.iter().enumerate() {
        let mut value = |step: f64| {
            let mut list = at.list();
            list[i] += step;
            let (theta, rest) = list.split_at(thresholds);
            let (beta, sd) = rest.split_at(columns);
            f(&Point { theta: theta.to_vec(), beta: beta.to_vec(), sd: [sd[0], sd[1]] }).0
        };
        let h = 1e-3;
        let near = (value(h) - value(-h)) / (2.0 * h);
        let far = (value(2.0 * h) - value(-2.0 * h)) / (4.0 * h);
        let difference = (4.0 * near - far) / 3.0;
        assert!((difference - slope).abs() < tolerance, "{i}: {difference} {slope}");
    }
}

#[test]
fn the_gradient_of_laplace_agrees_with_differences() {
    let model = study(1, 3, 4, [1.0, 0.7]).model(Terms::ParticipantAndMode);
    for sd in [[1.1, 0.6], [-0.4, 2.0], [0.0, 0.9], [1.3, 0.0], [0.0, 0.0]] {
        for cells in &model.participants {
            let mut effects = Effects::none(cells);
            check_gradient(&point(sd), 1e-8, |p| laplace(cells, p, &mut effects));
        }
    }
}

#[test]
fn the_gradient_of_the_whole_likelihood_agrees_with_differences() {
    let model = study(2, 5, 3, [1.0, 0.7]).model(Terms::ParticipantAndMode);
    for integral in [Integral::Laplace, Integral::Quadrature] {
        let mut likelihood = Likelihood::new(&model, integral);
        check_gradient(&point([0.9, 0.5]), 2e-8, |p| likelihood.at(p));
    }
}

/// Laplace's approximation from its definition: h minimised by coordinate bisections, its second
/// derivatives by differences, a dense determinant.
#[test]
fn laplace_is_what_its_definition_says() {
    let model = study(3, 1, 5, [1.0, 0.7]).of_one();
    let cells = &model.participants[0];
    let point = point([0.8, 0.6]);
    let h = |v: &[f64]| minus_log_joint(cells, &point, v);
    let mut v = vec![0.0; 4];
    for _ in 0..200 {
        for i in 0..4 {
            let slope = |x: f64| {
                let mut at = v.clone();
                at[i] = x + 1e-5;
                let high = h(&at);
                at[i] = x - 1e-5;
                high - h(&at)
            };
            let (mut low, mut high) = (-10.0, 10.0);
            for _ in 0..60 {
                let middle = (low + high) / 2.0;
                if slope(middle) > 0.0 { high = middle } else { low = middle }
            }
            v[i] = low;
        }
    }
    let step = 1e-3;
    let bend = |i: usize, j: usize| {
        let at = |a: f64, b: f64| {
            let mut at = v.clone();
            at[i] += a * step;
            at[j] += b * step;
            h(&at)
        };
        (at(1.0, 1.0) - at(1.0, -1.0) - at(-1.0, 1.0) + at(-1.0, -1.0)) / (4.0 * step * step)
    };
    let hessian = zwidth_numerics::dense::Matrix::from_fn(4, 4, bend);
    let l = hessian.cholesky(0.0).unwrap();
    let half_log_determinant: f64 = (0..4).map(|i| libm::log(l[(i, i)])).sum();
    let (found, _) = laplace(cells, &point, &mut Effects::none(cells));
    assert!((found - (-h(&v) - half_log_determinant)).abs() < 1e-6, "{found}");
}

impl Study {
    /// The model of a study of one participant, which has no estimates but a likelihood.
    fn of_one(&self) -> Model {
        let answers = Answers::new(&self.answers, 5, &self.columns).unwrap();
        let places = self.participants.iter().copied().zip(self.modes.iter().copied()).collect();
        Model::of(answers, places, Terms::ParticipantAndMode, 3)
    }
}

/// |v|²/2 − ln P(answers | v), effects in SDs: the participant's, then one per mode.
fn minus_log_joint(cells: &Cells, point: &Point, v: &[f64]) -> f64 {
    let mut sum = v.iter().map(|v| v * v / 2.0).sum::<f64>();
    for (m, group) in cells.groups.iter().enumerate() {
        for cell in group.clone() {
            let fixed: f64 = cells.x[cell].iter().zip(&point.beta).map(|(x, b)| x * b).sum();
            let eta = fixed + point.sd[0] * v[0] + point.sd[1] * v[1 + m];
            sum -= Levels::new(&point.theta).slopes(cells, cell, eta, None).value;
        }
    }
    sum
}

/// ∫ over all effects at once: 60 fixed nodes for each, around 0 and as wide as the effects.
fn tensor(cells: &Cells, point: &Point) -> f64 {
    let rule = rule(60);
    let nodes: Vec<(f64, f64)> = rule
        .nodes
        .iter()
        .zip(&rule.weights)
        .map(|(x, w)| (core::f64::consts::SQRT_2 * x, w / core::f64::consts::PI.sqrt()))
        .collect();
    let size = 1 + cells.groups.len();
    let mut sum = 0.0;
    let mut index = vec![0; size];
    loop {
        let v: Vec<f64> = index.iter().map(|&i| nodes[i].0).collect();
        let weight: f64 = index.iter().map(|&i| nodes[i].1).product();
        sum += weight * libm::exp(-minus_log_joint(cells, point, &v));
        let Some(place) = index.iter().position(|&i| i + 1 < nodes.len()) else { break };
        index[..place].fill(0);
        index[place] += 1;
    }
    libm::log(sum)
}

#[test]
fn sums_over_the_lattice_agree_with_a_tensor_rule_of_sixty_nodes() {
    // A mode less than in other tests: 60³ values of the integrand per participant.
    let mut study = study(4, 4, 2, [0.8, 0.6]);
    let kept: Vec<usize> = (0..study.answers.len()).filter(|&i| study.modes[i] != 1).collect();
    study.answers = kept.iter().map(|&i| study.answers[i]).collect();
    study.modes = kept.iter().map(|&i| study.modes[i] / 2).collect();
    study.participants = kept.iter().map(|&i| study.participants[i]).collect();
    study.columns.remove(0);
    for column in &mut study.columns {
        column.values = kept.iter().map(|&i| column.values[i]).collect();
    }
    let point = |sd| Point { theta: THETA.to_vec(), beta: BETA[1..].to_vec(), sd };
    let answers = Answers::new(&study.answers, 5, &study.columns).unwrap();
    let places = study.participants.iter().copied().zip(study.modes.iter().copied()).collect();
    let model = Model::of(answers, places, Terms::ParticipantAndMode, 3);
    for sd in [[0.8, 0.6], [1.2, 0.0], [0.3, 1.0]] {
        for cells in &model.participants {
            let exact = tensor(cells, &point(sd));
            let (found, _) = integrate(cells, &point(sd), &mut Effects::none(cells));
            assert!((found - exact).abs() < 1e-8, "{sd:?}: {found} {exact}");
        }
    }
}

/// Newton's steps alone go from 0 to 5 and back for ever: an answer is a steep step of the effect.
#[test]
fn quadrature_settles_where_people_differ_by_many_logits() {
    let theta = vec![-18.568, -12.273, -9.372, -3.174];
    let point = Point { theta, beta: vec![-4.865, -2.0, -2.223], sd: [7.07, 0.0] };
    let column = |of: usize| Column {
        name: of.to_string(),
        values: (0..4).map(|mode| f64::from(u8::from(mode == of))).collect(),
    };
    // All five points are in use, by a second participant.
    let answers = [4, 4, 4, 5, 1, 2, 3, 3];
    let columns: Vec<Column> = (0..3).map(column).map(|c| twice(&c)).collect();
    let answers = Answers::new(&answers, 5, &columns).unwrap();
    let places = (0..8).map(|row| (row / 4, row % 4)).collect();
    let model = Model::of(answers, places, Terms::Participant, 4);
    for cells in &model.participants {
        let (low, step) = (-9.0, 0.01);
        let at = |i: u32| {
            let v = [low + step * f64::from(i), 0.0, 0.0, 0.0, 0.0];
            libm::exp(-minus_log_joint(cells, &point, &v))
        };
        let exact = libm::log((0..=1800).map(at).sum::<f64>() * step)
            - libm::log(2.0 * core::f64::consts::PI) / 2.0;
        for start in [0.0, 5.0, -5.0] {
            let mut effects = Effects { participant: start, modes: vec![0.0; 4] };
            let (found, _) = integrate(cells, &point, &mut effects);
            assert!((found - exact).abs() < 1e-8, "{start}: {found} {exact}");
        }
    }
}

/// The rows of a column once more.
fn twice(column: &Column) -> Column {
    Column { name: column.name.clone(), values: column.values.repeat(2) }
}

/// 20 people answer once in each of four modes, as in a questionnaire, and differ by 5 logits.
#[test]
fn one_answer_per_mode_of_people_who_differ_a_lot_has_all_its_intervals() {
    for seed in 0..10 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut answers = vec![];
        for _ in 0..20 {
            let u = 5.0 * normal(&mut rng);
            for mode in 0..4 {
                let latent = u + 0.5 * f64::from(mode) + crate::logistic::logit(uniform(&mut rng));
                let above = [-6.0, -2.0, 1.0, 4.0].iter().filter(|&&t| t < latent).count();
                answers.push(1 + above as u8);
            }
        }
        let (participants, modes): (Vec<usize>, Vec<usize>) =
            (0..80).map(|row| (row / 4, row % 4)).unzip();
        let study = of_modes(&answers, &participants, &modes, &[0; 80]);
        let found = compare_modes(&study, &[[3, 0], [3, 1], [3, 2]], 0.95, 1).unwrap();
        assert!(found.sd_participant > 2.0, "{}", found.sd_participant);
        for ratio in found.odds_ratios {
            let interval = &ratio.as_ref().unwrap().interval;
            let ends = [&interval.low, &interval.high];
            assert!(ends.iter().all(|end| end.value().is_some()), "seed {seed}: {ends:?}");
        }
    }
}

#[test]
fn people_who_are_alike_are_a_singular_fit_and_that_of_the_plain_model() {
    // Each person gives the same answers, so that nothing is left to vary between them.
    let one = study(5, 1, 5, [0.0, 0.0]);
    let people = 4;
    let again = |values: &[usize]| values.repeat(people);
    let rows = one.answers.len();
    let study = Study {
        answers: one.answers.repeat(people),
        columns: one
            .columns
            .iter()
            .map(|c| Column { name: c.name.clone(), values: c.values.repeat(people) })
            .collect(),
        participants: (0..people * rows).map(|i| i / rows).collect(),
        modes: again(&one.modes),
    };
    let plain = clm::Model::new(&study.answers, 5, &study.columns).unwrap();
    let plain = clm::fit(&plain).unwrap();
    for terms in [Terms::Participant, Terms::ParticipantAndMode] {
        for integral in [Integral::Laplace, Integral::Quadrature] {
            let found = fit(&study.model(terms), integral).unwrap();
            assert!(found.singular && found.sd_participant == 0.0);
            assert!(found.sd_participant_mode.is_none_or(|sd| sd == 0.0));
            assert!((found.log_likelihood - plain.log_likelihood).abs() < 1e-9);
            for (a, b) in found.coefficients.iter().zip(&plain.coefficients) {
                assert!((a - b).abs() < 1e-6, "{a} {b}");
            }
            for j in 0..3 {
                let (a, b) = (found.wald(j, 0.95).unwrap(), plain.wald(j, 0.95).unwrap());
                assert!((a.std_error / b.std_error - 1.0).abs() < 1e-5, "{a:?} {b:?}");
            }
        }
    }
}

#[test]
fn a_simulated_study_of_many_people_gives_back_its_truth() {
    let study = study(6, 300, 3, [1.0, 0.7]);
    let model = study.model(Terms::ParticipantAndMode);
    let found = fit(&model, Integral::Quadrature).unwrap();
    assert!(!found.singular);
    let near = |estimate: f64, truth: f64, error: f64| {
        assert!((estimate - truth).abs() < 3.3 * error, "{estimate} {truth} {error}");
    };
    for (j, truth) in BETA.into_iter().enumerate() {
        near(found.coefficients[j], truth, found.wald(j, 0.95).unwrap().std_error);
    }
    for (k, truth) in THETA.into_iter().enumerate() {
        near(found.thresholds[k], truth, found.covariance[k][k].sqrt());
    }
    // An SD from n values has a standard error of at least σ/√(2n).
    near(found.sd_participant, 1.0, 2.0 / 600_f64.sqrt());
    near(found.sd_participant_mode.unwrap(), 0.7, 2.0 * 0.7 / 1800_f64.sqrt());
}

/// The integral over u and w with both on a grid of their own, as fine for any SD: 24,000 times
/// 24,000 places would take as long, so one SD is large and the other small, or there is one alone.
#[test]
fn neither_large_nor_small_sds_cost_digits() {
    let model = study(7, 3, 3, [1.2, 0.8]).model(Terms::ParticipantAndMode);
    for sd in [[12.0, 0.0], [29.0, 0.0], [0.003, 0.0], [9.0, 0.02], [0.02, 9.0], [6.0, 5.0]] {
        for cells in &model.participants {
            let (found, exact) = (
                integrate(cells, &point(sd), &mut Effects::none(cells)).0,
                fine(cells, &point(sd)),
            );
            assert!((found - exact).abs() < 1e-9, "{sd:?}: {found} {exact}");
            check_gradient(&point(sd), 1e-7, |p| integrate(cells, p, &mut Effects::none(cells)));
        }
    }
}

/// Nested midpoint sums from −9 to 9 SDs, steps an SD's 70th or 0.07 logits, whichever is finer.
fn fine(cells: &Cells, point: &Point) -> f64 {
    let grid = |sd: f64| -> Vec<(f64, f64)> {
        let steps = if sd > 0.0 { (18.0 * f64::max(7.0, sd / 0.07)).round() } else { 1.0 };
        let step = 18.0 / steps;
        let node = |k: usize| (k as f64 + 0.5) * step - 9.0;
        let weight = |v: f64| step * libm::exp(-v * v / 2.0) / libm::sqrt(core::f64::consts::TAU);
        match sd > 0.0 {
            true => (0..steps as usize).map(|k| (sd * node(k), weight(node(k)))).collect(),
            false => vec![(0.0, 1.0)],
        }
    };
    let levels = Levels::new(&point.theta);
    let x_beta = |c: usize| -> f64 { cells.x[c].iter().zip(&point.beta).map(|(x, b)| x * b).sum() };
    let probability = |m: usize, effect: f64| {
        let of = |c: usize| levels.slopes(cells, c, x_beta(c) + effect, None).value;
        libm::exp(cells.groups[m].clone().map(of).sum())
    };
    let inner = grid(point.sd[1]);
    let mode = |m, u| inner.iter().map(|(w, weight)| weight * probability(m, u + w)).sum::<f64>();
    let all = |u| (0..cells.groups.len()).map(|m| mode(m, u)).product::<f64>();
    libm::log(grid(point.sd[0]).iter().map(|(u, weight)| weight * all(*u)).sum())
}

#[test]
fn a_search_by_sums_over_the_lattice_ends_flat() {
    let found =
        fit(&study(7, 8, 3, [1.2, 0.8]).model(Terms::ParticipantAndMode), Integral::Quadrature);
    assert!(found.unwrap().slope < 1e-6);
}

#[test]
fn one_thread_gives_the_bits_of_many() {
    let study = study(8, 150, 2, [1.0, 0.5]);
    let model = study.model(Terms::ParticipantAndMode);
    let small = self::study(9, 5, 2, [0.7, 0.5]).model(Terms::ParticipantAndMode);
    let run = || {
        let fits = [Integral::Laplace, Integral::Quadrature]
            .map(|integral| fit(&model, integral).unwrap());
        (fits, bootstrap(&small, Integral::Laplace, &[0, 1], 20, 3).unwrap())
    };
    let on = |threads| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run)
    };
    assert_eq!(on(1), on(4));
}

/// The test referred to F(1, df) and the interval cut at its quantile say the same: at level
/// 1 − p an end of the interval is zero.
#[test]
fn a_profile_interval_at_the_level_of_its_test_ends_at_zero() {
    let model = study(10, 6, 4, [1.0, 0.4]).model(Terms::ParticipantAndMode);
    for integral in [Integral::Laplace, Integral::Quadrature] {
        let fit = fit(&model, integral).unwrap();
        let df = model.mode_df();
        assert!((df - 10.0).abs() < 1e-15);
        for column in 0..2 {
            let test = test_columns(&model, integral, &fit, &[column], df).unwrap();
            let level = 1.0 - test.f.p_value;
            let found = profile_interval(&model, integral, &fit, column, level, df).unwrap();
            let (low, high) = (found.low.value().unwrap(), found.high.value().unwrap());
            let nearest = if fit.coefficients[column] > 0.0 { low } else { high };
            assert!(nearest.abs() < 1e-5, "{found:?}");
            assert!(low < fit.coefficients[column] && fit.coefficients[column] < high);
            assert!((test.chi_square.statistic - test.f.statistic).abs() < 1e-15);
            assert!(test.chi_square.p_value < test.f.p_value);
        }
    }
}

#[test]
fn coding_by_another_reference_changes_the_sign_of_an_effect_and_nothing_else() {
    let study = study(11, 6, 3, [1.0, 0.4]);
    let model = study.model(Terms::ParticipantAndMode);
    let first = fit(&model, Integral::Laplace).unwrap();
    let first_interval = profile_interval(&model, Integral::Laplace, &first, 0, 0.9, 10.0).unwrap();
    // Mode 1 is now the reference: its column gives way to one of mode 0.
    let zero = study.modes.iter().map(|&m| f64::from(u8::from(m == 0))).collect();
    let mut columns = study.columns.clone();
    columns[0] = Column { name: "mode 0".to_owned(), values: zero };
    let turned =
        Model::new(&Ratings { columns: &columns, ..study.ratings() }, model.terms).unwrap();
    let second = fit(&turned, Integral::Laplace).unwrap();
    let second_interval =
        profile_interval(&turned, Integral::Laplace, &second, 0, 0.9, 10.0).unwrap();
    let value = |end: &End| end.value().unwrap();
    assert!((first.log_likelihood - second.log_likelihood).abs() < 1e-10);
    assert!((first.coefficients[0] + second.coefficients[0]).abs() < 1e-5);
    assert!((value(&first_interval.low) + value(&second_interval.high)).abs() < 1e-5);
    assert!((value(&first_interval.high) + value(&second_interval.low)).abs() < 1e-5);
}

#[test]
fn modes_are_compared_against_the_reference_for_one_person() {
    let study = study(12, 6, 4, [0.8, 0.3]);
    let sessions: Vec<usize> =
        study.columns[2].values.iter().map(|&second| 1 + second as usize).collect();
    let modes = of_modes(&study.answers, &study.participants, &study.modes, &sessions);
    let found = compare_modes(&modes, &[[1, 0], [1, 2]], 0.95, 4).unwrap();
    assert_eq!((found.participants, found.odds_ratios.len()), (6, 2));
    assert_eq!(found.integral, Integral::Quadrature);
    // The same model with columns of our own: mode 1 against 0.
    let model = study.model(Terms::ParticipantAndMode);
    let fit = fit(&model, found.integral).unwrap();
    let ratio = found.odds_ratios[0].as_ref().unwrap();
    let estimate = ratio.estimate.unwrap();
    assert!((libm::log(estimate) - fit.coefficients[0]).abs() < 1e-5);
    let [low, high] = [&ratio.interval.low, &ratio.interval.high].map(|end| end.value().unwrap());
    assert!(low < estimate && estimate < high);
    assert!((found.log_likelihood - fit.log_likelihood).abs() < 1e-9);
    assert_eq!((found.test.f.df_num, found.test.f.df_den), (2.0, 10.0));
    let drawn = found.bootstrap.unwrap();
    assert_eq!((drawn.resamples, found.p_value()), (999, drawn.p_value));
    // Bootstrap and F are two answers to one question.
    assert!((drawn.p_value - found.test.f.p_value).abs() < 0.05, "{found:?}");
    let unknown = &compare_modes(&modes, &[[7, 0]], 0.95, 4).unwrap().odds_ratios[0];
    assert!(matches!(unknown, Err(Unestimable::Confounded { .. })), "{unknown:?}");
}

/// Of 8 people, mode 2 is answered by 5 alone, the others by anything.
#[test]
fn a_separated_mode_has_a_bound_and_a_ratio_test_and_leaves_the_others_their_estimates() {
    let mut apart = study(17, 8, 3, [0.6, 0.4]);
    for (answer, mode) in apart.answers.iter_mut().zip(&apart.modes) {
        *answer = if *mode == 2 { 5 } else { *answer };
    }
    let sessions = vec![1; apart.answers.len()];
    let modes = of_modes(&apart.answers, &apart.participants, &apart.modes, &sessions);
    let pairs = [[2, 0], [1, 0], [0, 2], [1, 2]];
    let found = compare_modes(&modes, &pairs, 0.95, 4).unwrap();
    let [above, others, below, above_1] =
        [0, 1, 2, 3].map(|k| found.odds_ratios[k].as_ref().unwrap());

    // The answers of a mode that is certain say nothing of the others.
    let kept: Vec<usize> = (0..apart.answers.len()).filter(|i| apart.modes[*i] != 2).collect();
    let pick = |values: &[usize]| kept.iter().map(|i| values[*i]).collect::<Vec<_>>();
    let answers: Vec<u8> = kept.iter().map(|i| apart.answers[*i]).collect();
    let (people, two, once) = (pick(&apart.participants), pick(&apart.modes), pick(&sessions));
    let pair = of_modes(&answers, &people, &two, &once);
    let alone = compare_modes(&pair, &[[1, 0]], 0.95, 4).unwrap();
    let expect = alone.odds_ratios[0].as_ref().unwrap();
    assert!((found.log_likelihood - alone.log_likelihood).abs() < 1e-7, "{found:?} {alone:?}");
    let relative = others.estimate.unwrap() / expect.estimate.unwrap();
    assert!((relative - 1.0).abs() < 1e-4, "{others:?} {expect:?}");
    let ratios = [others, expect].map(|ratio| ratio.test.chi_square.statistic);
    assert!((ratios[0] - ratios[1]).abs() < 1e-6, "{ratios:?}");

    for ratio in [above, below, above_1] {
        assert_eq!(ratio.estimate, None);
        assert!(ratio.test.chi_square.p_value < 1e-6, "{ratio:?}");
        assert!(ratio.remark().unwrap().contains("separate"), "{ratio:?}");
    }
    let low = above.interval.low.value().unwrap();
    assert!(low > 2.0 && above.interval.high == End::Open, "{above:?}");
    let high = below.interval.high.value().unwrap();
    assert!((low * high - 1.0).abs() < 1e-4 && below.interval.low == End::Open, "{below:?}");
    assert!((above.test.f.statistic - below.test.f.statistic).abs() < 1e-5);
}

#[test]
fn answers_that_two_modes_do_not_share_at_all_are_bounded_too() {
    let answers = [5, 4, 1, 2, 5, 4, 1, 2, 5, 4, 1, 2, 5, 5, 2, 2];
    let participants: Vec<usize> = (0..16).map(|i| i / 4).collect();
    let modes: Vec<usize> = (0..16).map(|i| i % 4 / 2).collect();
    let sessions = [1; 16];
    let study = of_modes(&answers, &participants, &modes, &sessions);
    let found = compare_modes(&study, &[[0, 1]], 0.95, 4).unwrap();
    let ratio = found.odds_ratios[0].as_ref().unwrap();
    assert_eq!(ratio.estimate, None);
    assert!(ratio.interval.low.value().is_some(), "{ratio:?}");
    assert!(ratio.test.chi_square.p_value < 1e-3, "{ratio:?}");
}

#[test]
fn the_bootstrap_tells_an_effect_from_none() {
    let strong = study(13, 7, 6, [0.6, 0.2]).model(Terms::ParticipantAndMode);
    let effect = bootstrap(&strong, Integral::Laplace, &[0, 1], 99, 1).unwrap();
    assert!(effect.p_value <= 0.03, "{effect:?}");
    // Modes that are dealt at random within people make no difference.
    let mut none = study(13, 7, 6, [0.6, 0.2]);
    let rows = none.answers.len();
    none.answers = (0..rows).map(|i| none.answers[i / 36 * 36 + i * 7 % 36]).collect();
    let model = none.model(Terms::ParticipantAndMode);
    let chance = bootstrap(&model, Integral::Laplace, &[0, 1], 99, 1).unwrap();
    assert!(chance.p_value > 0.05, "{chance:?}");
    assert_eq!((effect.unfitted, chance.unfitted), (0, 0));
}

#[test]
fn studies_without_estimates_are_named_by_their_reason() {
    let check = |study: &Study, terms, expect: &str| {
        let found = Model::new(&study.ratings(), terms).and_then(|m| fit(&m, Integral::Laplace));
        assert_eq!(found.unwrap_err().to_string(), expect);
    };
    let one = study(14, 1, 6, [0.5, 0.5]);
    check(&one, Terms::Participant, "1 participant, 2 are needed");
    let mut split = study(15, 6, 4, [0.5, 0.5]);
    split.modes.clone_from(&split.participants);
    check(
        &split,
        Terms::ParticipantAndMode,
        "the data cannot tell participants and their modes apart",
    );
    // Everybody keeps to an answer of their own.
    let mut fixed = study(16, 5, 4, [0.5, 0.5]);
    fixed.answers = fixed.participants.iter().map(|&p| p as u8 + 1).collect();
    check(
        &fixed,
        Terms::Participant,
        "the answers separate participants completely, so the estimate has no end",
    );
    let mut apart = study(17, 5, 4, [0.5, 0.5]);
    let high = |(&mode, &answer): (&usize, &u8)| if mode == 2 { 5 } else { answer.min(4) };
    apart.answers = apart.modes.iter().zip(&apart.answers).map(high).collect();
    check(
        &apart,
        Terms::ParticipantAndMode,
        "the answers separate mode 3 completely, so the estimate has no end",
    );
}

/// Two to five people with few answers each: SDs are large or zero far from the estimates, where a
/// search that trusts a rule of fixed size gets lost.
#[test]
fn every_end_of_small_studies_is_found_or_open() {
    let (mut found, mut open) = (0, 0);
    for seed in 0..14 {
        let study = study(300 + seed, 2 + seed as usize % 4, 1 + seed as usize / 7, [1.5, 1.0]);
        let Ok(model) = Model::new(&study.ratings(), Terms::ParticipantAndMode) else { continue };
        let Ok(fit) = fit(&model, Integral::Quadrature) else { continue };
        let interval =
            profile_interval(&model, Integral::Quadrature, &fit, 0, 0.95, model.mode_df()).unwrap();
        for end in [interval.low, interval.high] {
            match end {
                End::At(_) => found += 1,
                End::Open => open += 1,
                End::NotFound(why) => panic!("{seed}: {why}"),
            }
        }
    }
    assert!(found >= 8 && open >= 1, "{found} found, {open} open");
}

/// Eight people who answered once in each of three modes, as questionnaires ask.
#[test]
fn one_answer_per_person_and_mode_is_compared_with_participants_alone() {
    let answers = [2, 3, 4, 1, 3, 5, 3, 3, 4, 2, 4, 3, 1, 2, 4, 3, 2, 5, 4, 4, 5, 2, 3, 3];
    let participants: Vec<usize> = (0..24).map(|row| row / 3).collect();
    let modes: Vec<usize> = (0..24).map(|row| row % 3).collect();
    let sessions = [1; 24];
    let study = of_modes(&answers, &participants, &modes, &sessions);
    let found = compare_modes(&study, &[[2, 0], [2, 1]], 0.95, 1).unwrap();
    assert_eq!(found.participants, 8);
    let estimate = found.odds_ratios[0].as_ref().unwrap().estimate;
    assert!(estimate.unwrap() > 1.0 && found.p_value() < 0.2, "{found:?}");
}
