//! The parameters, and the coordinates in which they are searched.
//!
//! Coordinates: θ₁, ln(θₖ − θₖ₋₁), β, and the two SDs with any sign. The likelihood is even in each
//! SD, so there is no bound to search along, and an SD of zero is an ordinary stationary point.

/// Parameters, or a gradient by them.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Point {
    /// θ, ascending.
    pub(super) theta: Vec<f64>,
    /// β.
    pub(super) beta: Vec<f64>,
    /// SD of the participants' effects, then of those of participant and mode; signs do not matter.
    pub(super) sd: [f64; 2],
}

impl Point {
    /// All zero.
    pub(super) fn zero(thresholds: usize, columns: usize) -> Self {
        Self { theta: vec![0.0; thresholds], beta: vec![0.0; columns], sd: [0.0; 2] }
    }

    /// The point at some coordinates.
    pub(super) fn at(coordinates: &[f64], thresholds: usize) -> Self {
        let (steps, rest) = coordinates.split_at(thresholds);
        let (beta, sd) = rest.split_at(rest.len() - 2);
        let mut height = steps[0];
        let mut theta = vec![height];
        for step in &steps[1..] {
            height += libm::exp(*step);
            theta.push(height);
        }
        Self { theta, beta: beta.to_vec(), sd: [sd[0], sd[1]] }
    }

    /// The coordinates of this point.
    pub(super) fn coordinates(&self) -> Vec<f64> {
        let steps = self.theta.windows(2).map(|t| libm::log(t[1] - t[0]));
        let all = self.theta[..1].iter().copied().chain(steps);
        all.chain(self.beta.iter().copied()).chain(self.sd).collect()
    }

    /// The gradient by the coordinates, for `self` as the gradient by the parameters.
    pub(super) fn by_coordinates(&self, coordinates: &[f64]) -> Vec<f64> {
        let thresholds = self.theta.len();
        let mut by = vec![0.0; thresholds];
        // The step to a threshold lifts it and all above.
        let mut above = 0.0;
        for k in (0..thresholds).rev() {
            above += self.theta[k];
            by[k] = if k == 0 { above } else { above * libm::exp(coordinates[k]) };
        }
        by.into_iter().chain(self.beta.iter().copied()).chain(self.sd).collect()
    }

    /// Adds another gradient.
    pub(super) fn add(&mut self, other: &Self) {
        let to = self.theta.iter_mut().chain(&mut self.beta).chain(&mut self.sd);
        let from = other.theta.iter().chain(&other.beta).chain(&other.sd);
        to.zip(from).for_each(|(to, from)| *to += from);
    }
}

#[cfg(test)]
impl Point {
    /// The parameters as one list: θ, β, the SDs.
    pub(super) fn list(&self) -> Vec<f64> {
        self.theta.iter().chain(&self.beta).chain(&self.sd).copied().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_lead_back_to_their_point() {
        let point = Point { theta: vec![-1.0, 0.5, 0.75], beta: vec![2.0, -3.0], sd: [0.5, -0.25] };
        let back = Point::at(&point.coordinates(), 3);
        for (a, b) in point.list().iter().zip(back.list()) {
            assert!((a - b).abs() < 1e-15);
        }
    }

    #[test]
    fn the_chain_rule_agrees_with_differences() {
        // f = Σ cᵢ pᵢ over the list of parameters
        let by_parameters = Point { theta: vec![3.0, -1.0, 2.0], beta: vec![5.0], sd: [7.0, -4.0] };
        let f = |coordinates: &[f64]| {
            let list = Point::at(coordinates, 3).list();
            by_parameters.list().iter().zip(list).map(|(c, p)| c * p).sum::<f64>()
        };
        let here = [-0.5, 0.2, -0.7, 1.0, 0.3, 0.4];
        for (i, slope) in by_parameters.by_coordinates(&here).iter().enumerate() {
            let (mut low, mut high) = (here, here);
            low[i] -= 1e-6;
            high[i] += 1e-6;
            assert!(((f(&high) - f(&low)) / 2e-6 - slope).abs() < 1e-8, "{i}");
        }
    }
}
