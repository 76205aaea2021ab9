//! A straight line, as in the thesis.

use crate::shape::{Points, Quantity, Shape, weighted_line};
use zwidth_results::CurveSymbol;

/// y = a + b x.
#[derive(Debug, Clone, Copy)]
pub struct Line;

impl Shape for Line {
    fn formula(&self) -> &'static str {
        "y = a + b x"
    }

    fn parameters(&self) -> &'static [(CurveSymbol, Quantity)] {
        &[(CurveSymbol::A, Quantity::Response), (CurveSymbol::B, Quantity::Slope)]
    }

    fn fit(&self, points: &Points, _near: Option<&[f64]>) -> Option<Vec<f64>> {
        if !points.can_determine(self.complexity()) {
            return None;
        }
        weighted_line(points.at.iter().map(|p| (p.command, p.response, p.weight)))
            .map(|(a, b)| vec![a, b])
    }

    fn predict(&self, parameters: &[f64], command: f64) -> f64 {
        parameters[0] + parameters[1] * command
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::{Point, check};

    #[test]
    fn a_line_is_recovered() {
        check::recovers(&Line, &[1.06768, -0.42852]);
        check::recovers(&Line, &[1e6, 0.1]);
    }

    #[test]
    fn a_weight_of_two_is_the_point_twice() {
        let point = |command: f64, response, weight| Point { command, response, weight };
        let at = [point(0.0, 1.0, 1.0), point(1.0, 4.0, 2.0), point(2.0, 5.0, 1.0)];
        let found =
            Line.fit(&Points { at: &at, samples: 4, levels: &[0.0, 1.0, 2.0] }, None).unwrap();
        // By hand: x̄ = 1, ȳ = 3.5, Σ w dx dy = 4, Σ w dx² = 2.
        assert!((found[0] - 1.5).abs() < 1e-14 && (found[1] - 2.0).abs() < 1e-14);
    }

    #[test]
    fn two_samples_cannot_be_tested_against_their_line() {
        assert_eq!(check::fit(&Line, &[0.0, 1.0], &[0.0, 1.0]), None);
    }
}
