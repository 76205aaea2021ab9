//! Gradients against differences, quadrature against a tensor rule, and simulated studies.

use super::laplace::{Effects, laplace, slopes};
use super::likelihood::Likelihood;
use super::model::Cells;
use super::point::Point;
use super::quadrature::integrate;
use super::*;
use crate::answers::Answers;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use zwidth_numerics::gauss_hermite::rule;

/// A number in (0, 1).
fn uniform(rng: &mut ChaCha8Rng) -> f64 {
    ((rng.next_u64() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let radius = (-2.0 * libm::log(uniform(rng))).sqrt();
    radius * libm::cos(2.0 * core::f64::consts::PI * uniform(rng))
}

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
    for integral in [Integral::Laplace, Integral::Quadrature { nodes: 40 }] {
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
    let hessian: Vec<Vec<f64>> = (0..4).map(|i| (0..4).map(|j| bend(i, j)).collect()).collect();
    let l = crate::symmetric::cholesky(&hessian).unwrap();
    let half_log_determinant: f64 = (0..4).map(|i| libm::log(l[i][i])).sum();
    let (found, _) = laplace(cells, &point, &mut Effects::none(cells));
    assert!((found - (-h(&v) - half_log_determinant)).abs() < 1e-6, "{found}");
}

impl Study {
    /// The model of a study of one participant, which has no estimates but a likelihood.
    fn of_one(&self) -> Model {
        let answers = Answers::new(&self.answers, 5, &self.columns).unwrap();
        let places = self.participants.iter().copied().zip(self.modes.iter().copied()).collect();
        Model::of(answers, places, Terms::ParticipantAndMode)
    }
}

/// |v|²/2 − ln P(answers | v), effects in SDs: the participant's, then one per mode.
fn minus_log_joint(cells: &Cells, point: &Point, v: &[f64]) -> f64 {
    let mut sum = v.iter().map(|v| v * v / 2.0).sum::<f64>();
    for (m, group) in cells.groups.iter().enumerate() {
        for cell in group.clone() {
            let fixed: f64 = cells.x[cell].iter().zip(&point.beta).map(|(x, b)| x * b).sum();
            let eta = fixed + point.sd[0] * v[0] + point.sd[1] * v[1 + m];
            sum -= slopes(cells, cell, &point.theta, eta).value;
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
fn nested_quadrature_agrees_with_a_tensor_rule_of_sixty_nodes() {
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
    let model = Model::of(answers, places, Terms::ParticipantAndMode);
    for sd in [[0.8, 0.6], [1.2, 0.0], [0.3, 1.0]] {
        for cells in &model.participants {
            let exact = tensor(cells, &point(sd));
            let found =
                |nodes| integrate(cells, &point(sd), &rule(nodes), &mut Effects::none(cells)).0;
            println!(
                "{sd:?} {:e} {:e} {:e} {:e}",
                found(7) - exact,
                found(11) - exact,
                found(15) - exact,
                found(25) - exact
            );
            assert!((found(25) - exact).abs() < 1e-8, "{sd:?}: {} {exact}", found(25));
        }
    }
}
