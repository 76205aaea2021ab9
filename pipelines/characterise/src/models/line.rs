//! A straight line, as in the thesis.

use super::{Model, Points, Quantity, weighted_line};

/// y = a + b x.
#[derive(Debug, Clone, Copy)]
pub struct Line;

impl Model for Line {
    fn name(&self) -> &'static str {
        "line"
    }

    fn formula(&self) -> &'static str {
        "y = a + b x"
    }

    fn parameters(&self) -> &'static [(&'static str, Quantity)] {
        &[("a", Quantity::Response), ("b", Quantity::Slope)]
    }

    fn fit(&self, points: &Points) -> Option<Vec<f64>> {
        if !points.can_determine(self.parameters().len()) {
            return None;
        }
        weighted_line(points.weighted()).map(|(a, b)| vec![a, b])
    }

    fn predict(&self, parameters: &[f64], command: f64) -> f64 {
        parameters[0] + parameters[1] * command
    }
}

#[cfg(test)]
mod tests {
    use super::super::check;
    use super::*;

    #[test]
    fn a_line_is_recovered() {
        check::recovers(&Line, &[1.06768, -0.42852]);
        check::recovers(&Line, &[1e6, 0.1]);
    }

    #[test]
    fn a_sample_of_weight_zero_does_not_count() {
        let x = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        let found =
            check::fit(&Line, &x, &[1.0, 3.0, 5.0, 7.0, 9.0, 1e6], &[1.0, 1.0, 1.0, 1.0, 1.0, 0.0]).unwrap();
        assert!((found[0] - 1.0).abs() < 1e-14 && (found[1] - 2.0).abs() < 1e-14);
        assert_eq!(check::fit(&Line, &x, &x, &[1.0, 1.0, 0.0, 0.0, 0.0, 0.0]), None);
    }
}
