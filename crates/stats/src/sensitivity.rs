//! Variance-based sensitivity: how much of an output's variance each input causes.
//!
//! With V the variance of f(x) over independent inputs, the first-order index of input i is
//! S_i = Var(E(f | x_i))/V, its total effect S_Ti = E(Var(f | all but x_i))/V, and the second-order
//! index S_ij what i and j cause together and neither causes alone. Σ S_i ≤ 1 ≤ Σ S_Ti, with
//! equality where f is a sum of functions of one input each. I. M. Sobol', Math. Comput. Simul. 55
//! (2001) 271–280; A. Saltelli et al., Comput. Phys. Commun. 181 (2010) 259–270.

use zwidth_numerics::moments::Moments;

/// Indices of an output, one number per input.
#[derive(Debug, Clone, PartialEq)]
pub struct Indices {
    /// S_i.
    pub first: Vec<f64>,
    /// S_Ti.
    pub total: Vec<f64>,
}

/// The indices by Jansen's estimators, from two independent sets of as many points, A and B:
/// S_Ti = Σ (f(A) − f(A_Bi))² / (2 n V) and S_i = 1 − Σ (f(B) − f(A_Bi))² / (2 n V), where A_Bi is
/// A with input i from B, and V the variance of f over both sets. The two halves of Sobol' points
/// of twice as many coordinates serve as sets. `None` for fewer than two points, sets that differ
/// in size, or an output that does not vary.
///
/// M. J. W. Jansen, Comput. Phys. Commun. 117 (1999) 35–43; Saltelli 2010, Table 2.
pub fn jansen(f: impl Fn(&[f64]) -> f64, a: &[Vec<f64>], b: &[Vec<f64>]) -> Option<Indices> {
    let inputs = a.first()?.len();
    let alike = a.len() == b.len() && a.iter().chain(b).all(|x| x.len() == inputs);
    (a.len() >= 2 && alike).then_some(())?;
    let [at_a, at_b] = [a, b].map(|points| points.iter().map(|x| f(x)).collect::<Vec<f64>>());
    let spread =
        2.0 * a.len() as f64 * Moments::of(&[at_a.as_slice(), &at_b].concat()).mean_square();
    (spread > 0.0).then_some(())?;
    let mut indices = Indices { first: Vec::new(), total: Vec::new() };
    for i in 0..inputs {
        let mut at_ab = Vec::with_capacity(a.len());
        for (a, b) in a.iter().zip(b) {
            let mut x = a.clone();
            x[i] = b[i];
            at_ab.push(f(&x));
        }
        indices.first.push(1.0 - squares(&at_b, &at_ab) / spread);
        indices.total.push(squares(&at_a, &at_ab) / spread);
    }
    Some(indices)
}

/// Σ (x − y)².
fn squares(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| (x - y) * (x - y)).sum()
}

/// Parts of the variance that switches make, each on or off with equal chance and independent, from
/// every one of their 2^k settings: nothing is estimated.
///
/// An output is Σ β_U Π_{i ∈ U} ±1 over the sets U of switches (the Walsh–Hadamard transform), and
/// β_U² is the variance that the set U makes together. Parts of several outputs, or of one at
/// several times, may be added: their indices are then those of all of them together (M. Lamboni,
/// H. Monod & D. Makowski, Reliab. Eng. Syst. Saf. 96 (2011) 450–459).
#[derive(Debug, Clone, PartialEq)]
pub struct SwitchVariance {
    switches: usize,
    /// β_U², by the set's bits; that of the empty set, which is no variance, is 0.
    parts: Vec<f64>,
}

impl SwitchVariance {
    /// No variance yet.
    pub fn none(switches: usize) -> Self {
        Self { switches, parts: vec![0.0; 1 << switches] }
    }

    /// Adds an output's values in all settings: bit i of a setting's number says whether switch i
    /// is on. Values of another number are not added.
    pub fn add(&mut self, values: &[f64]) {
        if values.len() != self.parts.len() {
            return;
        }
        let mut beta = values.to_vec();
        transform(&mut beta);
        let settings = values.len() as f64;
        // The part of the empty set is the mean.
        for (part, beta) in self.parts.iter_mut().zip(&beta).skip(1) {
            *part += (beta / settings) * (beta / settings);
        }
    }

    /// Adds parts of as many switches.
    pub fn merge(&mut self, other: &Self) {
        for (part, more) in self.parts.iter_mut().zip(&other.parts) {
            *part += more;
        }
    }

    /// V: the variance that all switches make.
    pub fn variance(&self) -> f64 {
        self.parts.iter().sum()
    }

    /// S_Ti of a switch; `None` where nothing varies.
    pub fn total(&self, switch: usize) -> Option<f64> {
        self.share(|set| set >> switch & 1 == 1)
    }

    /// S_i of a switch.
    pub fn first(&self, switch: usize) -> Option<f64> {
        self.share(|set| set == 1 << switch)
    }

    /// S_ij of two switches.
    pub fn second(&self, one: usize, other: usize) -> Option<f64> {
        self.share(|set| one != other && set == 1 << one | 1 << other)
    }

    /// Number of switches.
    pub fn switches(&self) -> usize {
        self.switches
    }

    /// The share of the sets that count in V; `None` where nothing varies.
    fn share(&self, counts: impl Fn(usize) -> bool) -> Option<f64> {
        let all = self.variance();
        let sets = (0..self.parts.len()).filter(|set| counts(*set));
        (all > 0.0).then(|| sets.map(|set| self.parts[set]).sum::<f64>() / all)
    }
}

/// The Walsh–Hadamard transform in place: Σ ± values, − for each switch of the set that is off.
fn transform(values: &mut [f64]) {
    let mut half = 1;
    while half < values.len() {
        for at in (0..values.len()).filter(|at| at & half == 0) {
            let off = values[at];
            let on = values[at + half];
            (values[at], values[at + half]) = (on + off, on - off);
        }
        half *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;
    use zwidth_numerics::sobol::sobol_points;

    /// A and B: the halves of Sobol' points.
    fn sets(inputs: usize, n: usize) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
        let points = sobol_points(2 * inputs, n).unwrap();
        points.into_iter().map(|x| (x[..inputs].to_vec(), x[inputs..].to_vec())).unzip()
    }

    fn close(found: &[f64], expect: &[f64], by: f64) {
        let off = found.iter().zip(expect).map(|(f, e)| (f - e).abs()).fold(0.0, f64::max);
        assert!(off < by, "{found:?} instead of {expect:?}");
    }

    /// sin x₁ + 7 sin² x₂ + 0.1 x₃⁴ sin x₁ over [−π, π]³ (Ishigami & Homma 1990): V = a²/8 +
    /// bπ⁴/5 + b²π⁸/18 + 1/2.
    #[test]
    fn the_indices_of_ishigamis_function_are_those_in_closed_form() {
        let (a, b) = (7.0, 0.1);
        let f = |u: &[f64]| {
            let x: Vec<f64> = u.iter().map(|u| PI * (2.0 * u - 1.0)).collect();
            x[0].sin() + a * x[1].sin().powi(2) + b * x[2].powi(4) * x[0].sin()
        };
        let v1 = 0.5 * (1.0 + b * PI.powi(4) / 5.0).powi(2);
        let v2 = a * a / 8.0;
        let v13 = b * b * PI.powi(8) * (1.0 / 18.0 - 1.0 / 50.0);
        let v = v1 + v2 + v13;
        let (points, others) = sets(3, 1 << 13);
        let found = jansen(f, &points, &others).unwrap();
        close(&found.first, &[v1 / v, v2 / v, 0.0], 0.01);
        close(&found.total, &[(v1 + v13) / v, v2 / v, v13 / v], 0.01);
    }

    /// Σ c_i x_i: V_i = c_i²/12, and no input does anything together with another.
    #[test]
    fn an_additive_function_has_total_effects_that_are_its_first_and_add_up_to_one() {
        let c = [1.0, 2.0, 4.0];
        let f = |x: &[f64]| x.iter().zip(c).map(|(x, c)| c * x).sum();
        let (a, b) = sets(3, 1 << 12);
        let found = jansen(f, &a, &b).unwrap();
        let expect = c.map(|c| c * c / 21.0);
        close(&found.total, &expect, 2e-3);
        close(&found.first, &expect, 5e-3);
    }

    #[test]
    fn an_output_that_does_not_vary_and_sets_that_differ_have_no_indices() {
        let (a, b) = sets(2, 8);
        assert_eq!(jansen(|_| 1.0, &a, &b), None);
        assert_eq!(jansen(|x| x[0], &a, &b[1..]), None);
        assert_eq!(jansen(|x| x[0], &[], &[]), None);
    }

    fn settings(k: usize, f: impl Fn(&dyn Fn(usize) -> f64) -> f64) -> SwitchVariance {
        let mut variance = SwitchVariance::none(k);
        let value = |set: usize| f(&|i| f64::from(u8::from(set >> i & 1 == 1)));
        variance.add(&(0..1 << k).map(value).collect::<Vec<_>>());
        variance
    }

    /// x₀ + 2 x₁ + 4 x₀ x₂ of switches 0 or 1 is 3 x₀ + … ± 1: β = (3, 2, 2; 2 for both of 0 and
    /// 2)/2.
    #[test]
    fn switches_that_add_up_and_one_that_works_through_another_are_told_apart() {
        let found = settings(4, |x| x(0) + 2.0 * x(1) + 4.0 * x(0) * x(2));
        let all = 9.0 + 4.0 + 4.0 + 4.0;
        assert!((found.variance() - all / 4.0).abs() < 1e-14);
        let totals: Vec<f64> = (0..4).filter_map(|i| found.total(i)).collect();
        close(&totals, &[13.0 / all, 4.0 / all, 8.0 / all, 0.0], 1e-14);
        assert!((found.second(0, 2).unwrap() - 4.0 / all).abs() < 1e-14);
        assert_eq!((found.second(0, 1), found.second(1, 1)), (Some(0.0), Some(0.0)));
        assert!((found.first(0).unwrap() - 9.0 / all).abs() < 1e-14);
    }

    /// Jansen's mean over all pairs that differ in one switch: S_Ti = mean (f(on) − f(off))²/4 / V.
    #[test]
    fn the_total_effect_of_a_switch_is_jansens_over_all_pairs() {
        let f = |set: usize| ((set * 7 + 3) % 11) as f64;
        let values: Vec<f64> = (0..32).map(f).collect();
        let mut found = SwitchVariance::none(5);
        found.add(&values);
        assert!((found.variance() - Moments::of(&values).mean_square()).abs() < 1e-12);
        for i in 0..5 {
            let pairs = (0..32).filter(|set| set >> i & 1 == 0);
            let sum: f64 = pairs.map(|set| (f(set) - f(set | 1 << i)).powi(2)).sum();
            let expect = sum / 16.0 / 4.0 / Moments::of(&values).mean_square();
            assert!((found.total(i).unwrap() - expect).abs() < 1e-12);
        }
    }

    #[test]
    fn what_nothing_changes_has_no_index() {
        assert_eq!(settings(3, |_| 5.0).total(0), None);
    }
}
