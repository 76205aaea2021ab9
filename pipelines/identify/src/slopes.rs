//! Errors of a trial and their slopes by the parameters, from runs of the model.

use serde::{Serialize, Serializer};
use zwidth_results::PlantParameter;

/// A parameter of the model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Parameter {
    /// Its name.
    #[serde(serialize_with = "word")]
    pub name: PlantParameter,
    /// Its unit.
    pub unit: &'static str,
    /// The value chosen by eye.
    pub by_eye: f64,
    /// Smallest value allowed.
    pub lower: f64,
    /// Largest value allowed.
    pub upper: f64,
}

/// A parameter as tables name it.
fn word<S: Serializer>(name: &PlantParameter, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(name.as_str())
}

/// Share of a parameter's size by which it is changed to see a slope: its square is lost to
/// curvature.
const SHARE: f64 = 1e-4;
/// The change as a share of the distance between its bounds, for a parameter that is 0.
const SHARE_OF_RANGE: f64 = 1e-7;

/// Prediction less recording; infinite where the model does not run, which a fit steps back from.
pub(crate) fn errors<const P: usize>(
    predict: impl Fn(&[[f64; P]]) -> Vec<Option<Vec<f64>>>,
    observed: &[f64],
    at: &[f64; P],
) -> Vec<f64> {
    match predict(&[*at]).pop().flatten().filter(|p| p.len() == observed.len()) {
        Some(predicted) => predicted.iter().zip(observed).map(|(p, o)| p - o).collect(),
        None => vec![f64::INFINITY; observed.len()],
    }
}

/// Slopes of `samples` errors, from runs of the model to either side of `at`; one that cannot be
/// seen is 0.
pub(crate) fn slopes<const P: usize>(
    predict: impl Fn(&[[f64; P]]) -> Vec<Option<Vec<f64>>>,
    samples: usize,
    parameters: &[Parameter; P],
    at: &[f64; P],
) -> Vec<[f64; P]> {
    let mut moving = Vec::new();
    let mut points = Vec::new();
    for (j, parameter) in parameters.iter().enumerate() {
        let step = SHARE * at[j].abs() + SHARE_OF_RANGE * (parameter.upper - parameter.lower);
        let low = (at[j] - step).max(parameter.lower);
        let high = (at[j] + step).min(parameter.upper);
        // One that is held at one value does not move.
        if low < high {
            moving.push((j, [low, high]));
            for value in [low, high] {
                let mut point = *at;
                point[j] = value;
                points.push(point);
            }
        }
    }
    let mut slopes = vec![[0.0; P]; samples];
    // All at once, so that a model may share work between points.
    let predicted = predict(&points);
    for ((j, [low, high]), sides) in moving.into_iter().zip(predicted.chunks(2)) {
        let [Some(below), Some(above)] = sides else { continue };
        for (slope, (below, above)) in slopes.iter_mut().zip(below.iter().zip(above)) {
            slope[j] = (above - below) / (high - low);
        }
    }
    slopes
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: [f64; 3] = [0.0, 1.0, 2.0];

    fn parameter(lower: f64) -> Parameter {
        Parameter { name: PlantParameter::Mass, unit: "1", by_eye: 1.0, lower, upper: 10.0 }
    }

    #[test]
    fn slopes_are_those_of_the_model_also_at_a_bound() {
        let one = |p: &[f64; 2]| Some(X.iter().map(|x| p[0] * p[0] * x + p[1]).collect());
        let predict = |points: &[[f64; 2]]| points.iter().map(one).collect();
        for at in [[3.0, 0.5], [3.0, 0.0]] {
            let values = errors(predict, &[1.0; 3], &at);
            let slopes = slopes(predict, 3, &[parameter(0.0); 2], &at);
            for (i, x) in X.iter().enumerate() {
                assert!((values[i] - (9.0 * x + at[1] - 1.0)).abs() < 1e-12);
                assert!((slopes[i][0] - 6.0 * x).abs() < 1e-6 && (slopes[i][1] - 1.0).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn a_model_that_does_not_run_has_infinite_errors_and_no_slopes() {
        let predict = |points: &[[f64; 1]]| vec![None; points.len()];
        assert_eq!(errors(predict, &[1.0; 2], &[1.0]), [f64::INFINITY; 2]);
        assert_eq!(slopes(predict, 2, &[parameter(0.0)], &[1.0]), [[0.0]; 2]);
    }
}
