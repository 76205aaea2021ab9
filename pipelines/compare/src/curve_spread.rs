//! How people's curves scatter in what is compared, from which another study is planned.

use crate::curves::{Comparison, CurveParameters, People, SessionCurve, compared};
use zwidth_results::GroupEffect;
use zwidth_study::{Curve, EnvironmentId};

/// People's differences in one comparison of whole curves.
#[derive(Debug, Clone, PartialEq)]
pub struct CurveSpread {
    /// What is compared.
    pub effect: GroupEffect,
    /// The environment in which it is; `None` of an effect over several.
    pub environment: Option<EnvironmentId>,
    /// Everybody's differences, node by node, in the unit of the curve.
    pub differences: Vec<Vec<f64>>,
    /// The number of nodes of each branch.
    pub lengths: Vec<usize>,
    /// The angle (rad) or the time (s) of each node.
    pub places: Vec<f64>,
}

/// What is compared of everybody's curves, in the order of the tables, with everybody's differences.
pub fn curve_spreads(
    sessions: &[SessionCurve],
    curve: Curve,
    parameters: &CurveParameters,
) -> Vec<CurveSpread> {
    let own: Vec<&SessionCurve> = sessions.iter().filter(|one| one.curve == curve).collect();
    let comparisons = compared(&own, parameters).into_iter().filter(Comparison::is_of_everybody);
    let spread = |comparison: Comparison| {
        let people = People::of(&own, &comparison.weights, parameters);
        CurveSpread {
            effect: comparison.effect,
            environment: comparison.environment,
            differences: people.differences(),
            lengths: people.shared.lengths(),
            places: people.shared.nodes().map(|(_, place)| place).collect(),
        }
    };
    comparisons.map(spread).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare_curves;
    use crate::curves::tests::{parameters, people};

    /// The mean of the differences is what the comparison finds, node by node.
    #[test]
    fn the_spread_is_of_what_is_compared() {
        let (sessions, parameters) = (people(7), parameters());
        let spreads = curve_spreads(&sessions, Curve::ForceOverAngle, &parameters);
        let [hybrid, passive] = spreads.as_slice() else { panic!("{spreads:?}") };
        assert_eq!(hybrid.differences.len(), 7);
        assert_eq!((passive.differences.len(), passive.places.len()), (0, 0));
        let found = compare_curves(&sessions, &parameters).unwrap();
        assert_eq!((hybrid.places.len(), &hybrid.lengths[..]), (found.points.len(), &[11, 11][..]));
        for (node, point) in found.points.iter().enumerate() {
            let mean = hybrid.differences.iter().map(|row| row[node]).sum::<f64>() / 7.0;
            assert!((mean - point.difference).abs() < 1e-12, "{node}");
            assert_eq!(Some(hybrid.places[node]), point.theta_rad);
        }
        assert!(curve_spreads(&sessions, Curve::ThetaOverTime, &parameters).is_empty());
    }
}
