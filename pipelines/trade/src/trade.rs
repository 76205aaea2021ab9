//! A scene's trade: every setting, the cheapest that is good enough, and the settings that no other
//! beats.

use crate::TradeError;
use crate::cells::{Cell, cells};
use crate::choice::{Choice, choose};
use crate::measured::Metrics;
use crate::setting::{Fan, Fineness, Setting};
use rayon::prelude::*;
use serde::Serialize;
use zwidth_dynamics::{Finger, FingerLaw, ModelScene, Reference};
use zwidth_judge::Yardstick;
use zwidth_results::Proof;
use zwidth_study::Perception;

/// What a trade is made of.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameters {
    /// What a person can feel.
    pub perception: Perception,
    /// Steps and tolerances.
    pub fan: Fan,
    /// Neighbours of the scene on which a choice is confirmed.
    pub neighbours: usize,
}

impl Parameters {
    /// The full trade of a scene.
    pub fn full(scene: &ModelScene, perception: &Perception) -> Self {
        /// Neighbours.
        const NEIGHBOURS: usize = 100;
        let fan = Fan::full(scene.step_s);
        Self { perception: perception.clone(), fan, neighbours: NEIGHBOURS }
    }

    /// The reduced one of every run of a study; its choices are not confirmed.
    pub fn reduced(scene: &ModelScene, perception: &Perception) -> Self {
        let fan = Fan::reduced(scene.step_s);
        Self { perception: perception.clone(), fan, neighbours: 0 }
    }

    /// How many settings are run on a scene.
    pub fn settings(&self, scene: &ModelScene) -> usize {
        self.fan.settings().iter().map(|settings| possible(scene, settings).len()).sum()
    }
}

/// The trade of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Trade {
    /// The scene.
    pub scene: ModelScene,
    /// How far the right answer is proven.
    pub proof: Proof,
    /// By which solver, and against which.
    pub solvers: [&'static str; 2],
    /// How far the two are apart in angle, rad.
    pub apart_rad: Option<f64>,
    /// And in the times of events, s.
    pub apart_s: Option<f64>,
    /// How often the lever changes its way of moving in the right answer.
    pub motion_changes: usize,
    /// Every setting, solver by solver, the finest first.
    pub cells: Vec<Cell>,
    /// The one that is recommended.
    pub choice: Option<Choice>,
}

/// Runs every setting on a scene; `progress` is called after each. With `metrics` each run's are
/// compared with those of the right run. The same bits on any number of threads.
///
/// # Errors
/// A scene that makes no sense or is too long, or that neither the exact solver nor an adaptive one
/// can run.
pub fn trade(
    scene: &ModelScene,
    parameters: &Parameters,
    metrics: Option<&Metrics<'_>>,
    progress: &(dyn Fn() + Sync),
) -> Result<Trade, TradeError> {
    let yardstick = Yardstick::of(scene, &parameters.perception)?;
    let reference = Reference::of(&yardstick.system);
    // A task per solver: within one, each setting's judgement needs the runs of the finer ones.
    let solvers: Vec<Vec<Cell>> = parameters
        .fan
        .settings()
        .iter()
        .map(|settings| possible(scene, settings))
        .collect::<Vec<_>>()
        .par_iter()
        .map(|settings| cells(scene, &yardstick, &reference, settings, metrics, progress))
        .collect::<Result<_, _>>()?;
    let proof = yardstick.proof;
    let neighbours = parameters.neighbours;
    let choice = choose(scene, proof, &solvers, &parameters.perception, neighbours);
    Ok(Trade {
        scene: scene.clone(),
        proof,
        solvers: [yardstick.by, yardstick.against],
        apart_rad: yardstick.apart_rad,
        apart_s: yardstick.apart_s,
        motion_changes: yardstick.story.motion_changes(),
        cells: solvers.into_iter().flatten().collect(),
        choice,
    })
}

/// The settings that a scene of its length has room for: no step is longer than a tenth of it, and
/// none so short that the run would fill the memory.
fn possible(scene: &ModelScene, settings: &[Setting]) -> Vec<Setting> {
    let fitting = settings.iter().filter(|setting| match setting.fineness {
        Fineness::StepS(step_s) => {
            step_s <= 0.1 * scene.duration_s && crate::cells::grid(scene, step_s).is_ok()
        }
        _ => true,
    });
    fitting.copied().collect()
}

/// The models that a scene can be run with: as it is, and, if it has a finger, without the finger
/// and with the finger's other law.
pub fn models(scene: &ModelScene) -> Vec<ModelScene> {
    let mut models = vec![scene.clone()];
    if let Some(finger) = scene.finger {
        let law = match finger.law {
            FingerLaw::Thesis => FingerLaw::Consistent,
            FingerLaw::Consistent => FingerLaw::Thesis,
        };
        models.push(ModelScene { finger: None, ..scene.clone() });
        models.push(ModelScene { finger: Some(Finger { law, ..finger }), ..scene.clone() });
    }
    models
}

/// The pairs of cost and error that no other beats in both, the cheapest first; a pair that is not
/// a number is left out. Of equal pairs the first stays.
pub fn pareto_front(pairs: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> =
        (0..pairs.len()).filter(|i| pairs[*i].0.is_finite() && pairs[*i].1.is_finite()).collect();
    order.sort_by(|a, b| {
        let a = pairs[*a];
        let b = pairs[*b];
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let mut least = f64::INFINITY;
    order.retain(|i| {
        let better = pairs[*i].1 < least;
        least = least.min(pairs[*i].1);
        better
    });
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_on_the_front_is_beaten_in_both() {
        let pairs = [
            (1.0, 9.0),
            (2.0, 3.0),
            (2.0, 4.0),
            (3.0, 3.0),
            (5.0, 1.0),
            (4.0, f64::NAN),
            (0.5, 9.0),
        ];
        assert_eq!(pareto_front(&pairs), [6, 1, 4]);
        assert!(pareto_front(&[]).is_empty());
    }

    #[test]
    fn of_points_on_a_falling_line_all_are_on_the_front_and_on_a_rising_one_the_first() {
        let line = |slope: f64| -> Vec<(f64, f64)> {
            (0..9).map(|i| (f64::from(i), slope * f64::from(i))).collect()
        };
        assert_eq!(pareto_front(&line(-1.0)).len(), 9);
        assert_eq!(pareto_front(&line(1.0)), [0]);
    }
}
