//! Variance-based sensitivity: how much of an output's variance each input causes.
//!
//! With V the variance of f(x) over independent inputs, the first-order index of input i is
//! S_i = Var(E(f | x_i))/V, its total effect S_Ti = E(Var(f | all but x_i))/V, and the second-order
//! index S_ij what i and j cause together and neither causes alone. Σ S_i ≤ 1 ≤ Σ S_Ti, with
//! equality where f is a sum of functions of one input each. I. M. Sobol', Math. Comput. Simul. 55
//! (2001) 271–280; A. Saltelli et al., Comput. Phys. Commun. 181 (2010) 259–270.

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
    use zwidth_numerics::moments::Moments;

    fn close(found: &[f64], expect: &[f64], by: f64) {
        let off = found.iter().zip(expect).map(|(f, e)| (f - e).abs()).fold(0.0, f64::max);
        assert!(off < by, "{found:?} instead of {expect:?}");
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
