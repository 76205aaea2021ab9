//! Curves over doses: the mean of everybody's own line, or parabola, from the lowest dose to the highest.

use crate::Parameters;
use crate::cells::Cells;

use crate::measure::Measure;
use crate::weighed::{Placed, averaged, levels_of, of_people, weighed};
use zwidth_results::{DosePoint, UnitOfAnalysis};
use zwidth_stats::curve;
use zwidth_stats::null::Sampling;
use zwidth_stats::student_t::critical_value;
use zwidth_study::{Effect, LevelContrast, OverDose};

/// Points of a curve.
const POINTS: usize = 61;

/// Flips that are drawn where there are too many participants to count all.
const SAMPLING: Sampling = Sampling { draws: 9_999, seed: 1 };

/// Everybody's means of all levels of a dose; of who lacks a level a curve would go beyond what they felt.
fn means_of_levels(
    over: &OverDose,
    effect: &Effect,
    cells: &Cells,
    parameters: &Parameters,
) -> Vec<Vec<f64>> {
    let levels: Vec<Vec<Placed>> = levels_of(over, cells, parameters);
    let people = averaged(&of_people(cells, effect.is_by_session()), |own| {
        levels.iter().map(|level| weighed(level, own)).collect()
    });
    people.into_values().collect()
}

/// The sum of a person's means of levels with these weights.
fn at(weights: &[f64], means: &[f64]) -> f64 {
    weights.iter().zip(means).map(|(weight, mean)| weight * mean).sum()
}

/// The curves of a metric over doses; none of groups, which have no mean curve together, nor of one participant.
pub(crate) fn curves(
    cells: &Cells,
    unit: &UnitOfAnalysis,
    measure: &Measure,
    parameters: &Parameters,
) -> Vec<DosePoint> {
    if *unit != UnitOfAnalysis::Participants || parameters.groups.is_some() {
        return Vec::new();
    }
    let mut rows = Vec::new();
    for effect in parameters.effects.iter().filter(|effect| effect.is_claimed) {
        // One curve of a line and its bend.
        let is_slope = !effect.levels.iter().any(LevelContrast::is_bend);
        let Some(over) = effect.over.as_ref().filter(|_| is_slope) else { continue };
        let people = means_of_levels(over, effect, cells, parameters);
        let doses: Vec<f64> =
            (0..POINTS).map(|point| over.along(point as f64 / (POINTS - 1) as f64)).collect();
        let weights: Vec<Vec<f64>> = doses.iter().map(|dose| over.at(*dose)).collect();
        let curves: Vec<Vec<f64>> = people
            .iter()
            .map(|means| weights.iter().map(|weights| at(weights, means)).collect())
            .collect();
        let tested = curve::differences(&curves, &[POINTS], parameters.level, SAMPLING);
        let pointwise = critical_value(parameters.level, people.len() as f64 - 1.0);
        let (Ok(tested), Ok(pointwise)) = (tested, pointwise) else { continue };
        rows.extend(doses.into_iter().zip(&tested.nodes).map(|(dose, node)| {
            let band = node.ends.filter(|_| tested.band.is_some());
            DosePoint {
                metric: measure.parameters.metric.clone(),
                unit: measure.unit.clone(),
                environment: effect.environment.clone(),
                effect: effect.term.clone(),
                dose,
                dose_unit: over.unit.clone(),
                n: people.len(),
                mean: node.mean,
                std_error: node.std_error,
                ci_low: node.mean - pointwise * node.std_error,
                ci_high: node.mean + pointwise * node.std_error,
                band_low: band.map(|ends| ends[0]),
                band_high: band.map(|ends| ends[1]),
            }
        }));
    }
    rows
}

/// Where the mean parabola turns, in the unit of the dose; only between the lowest and the highest, and if all `n` whose
/// bend was tested have every level.
pub(crate) fn turns_at(
    effect: &Effect,
    n: usize,
    cells: &Cells,
    parameters: &Parameters,
) -> Option<f64> {
    let over = effect.over.as_ref()?;
    let people = means_of_levels(over, effect, cells, parameters);
    if people.len() != n {
        return None;
    }
    let mean = |share: f64| {
        let weights = over.at(over.along(share));
        people.iter().map(|means| at(&weights, means)).sum::<f64>() / people.len() as f64
    };
    // Three points of a parabola say where it turns.
    let [low, middle, high] = [mean(0.0), mean(0.5), mean(1.0)];
    let share = 0.5 + 0.25 * (low - high) / (low - 2.0 * middle + high);
    (0.0..=1.0).contains(&share).then(|| over.along(share))
}
