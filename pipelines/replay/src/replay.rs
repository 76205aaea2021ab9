//! One trial in three causalities.

use crate::compare::{VelocityError, compare, compare_velocities};
use crate::{Comparison, Course, Drive, Parameters, Rendering, ReplayError};
use zwidth_dynamics::DynamicsError;
use zwidth_numerics::activity::activity;
use zwidth_numerics::phases::phases;
use zwidth_results::{Causality, ModelPlant, ReplayOutcome};
use zwidth_store::Trial;
use zwidth_study::{Analysis, TrialMeta};

/// One trial in one causality.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialReplay {
    /// The trial.
    pub meta: TrialMeta,
    /// The input and the output.
    pub causality: Causality,
    /// The origin of the model's plant.
    pub which: ModelPlant,
    /// The model's plant.
    pub parameters: Parameters,
    /// Whether it was replayed, or why not.
    pub outcome: ReplayOutcome,
    /// The signal that came out, θ (rad) or F_ex (N), against the recorded one; `None` unless it
    /// was replayed. Times are the trial's.
    pub comparison: Option<Comparison>,
    /// How far θ̇ departs; `None` where θ is given, or unless it was replayed.
    pub velocity: Option<VelocityError>,
    /// First time of the recording's largest θ between onset and end, s; `None` without movement.
    pub reversal_recorded_s: Option<f64>,
    /// That of the model, less it; `None` where θ is given, or one of the two does not move.
    pub reversal_error_s: Option<f64>,
}

/// A lever that turns by more than this, rad, has diverged: more than six times the prototype's
/// work space.
const DIVERGED_RAD: f64 = 10.0;

/// Replays a trial in every causality.
///
/// # Errors
/// Columns of unequal length; parameters that make no model.
pub fn replay(
    trial: &Trial,
    rendering: &Rendering,
    analysis: &Analysis,
    which: ModelPlant,
    parameters: &Parameters,
) -> Result<Vec<TrialReplay>, ReplayError> {
    replay_with(trial, rendering, analysis, which, parameters, &|drive| {
        drive.run(Causality::ForceDriven, parameters)
    })
}

/// [`replay`] with another model for the causality that is driven by force: its course must be at
/// the recording's times.
///
/// # Errors
/// As [`replay`], and those of the model.
pub fn replay_with(
    trial: &Trial,
    rendering: &Rendering,
    analysis: &Analysis,
    which: ModelPlant,
    parameters: &Parameters,
    force_driven: &dyn Fn(&Drive) -> Result<Course, ReplayError>,
) -> Result<Vec<TrialReplay>, ReplayError> {
    let drive = match Drive::new(trial, rendering) {
        Err(ReplayError::WhyNot(why)) => Err(why),
        other => Ok(other?),
    };
    let mut replays = Vec::new();
    for causality in Causality::ALL.iter().copied() {
        let empty = TrialReplay {
            meta: trial.meta.clone(),
            causality,
            which,
            parameters: *parameters,
            outcome: ReplayOutcome::Diverged,
            comparison: None,
            velocity: None,
            reversal_recorded_s: None,
            reversal_error_s: None,
        };
        replays.push(match &drive {
            Err(why) => TrialReplay { outcome: (*why).into(), ..empty },
            Ok(drive) => replayed(drive, analysis, empty, force_driven)?,
        });
    }
    Ok(replays)
}

/// Fills in one causality's replay of a trial.
fn replayed(
    drive: &Drive,
    analysis: &Analysis,
    empty: TrialReplay,
    force_driven: &dyn Fn(&Drive) -> Result<Course, ReplayError>,
) -> Result<TrialReplay, ReplayError> {
    let recorded = drive.recorded();
    let turned_s = reversal_s(recorded, analysis);
    let empty = TrialReplay { reversal_recorded_s: turned_s.map(|t| t + drive.began_s), ..empty };
    let run = match empty.causality {
        Causality::ForceDriven => force_driven(drive),
        other => drive.run(other, &empty.parameters),
    };
    let model = match run {
        Ok(model) if has_diverged(&model) => return Ok(empty),
        // A model that runs away may end in numbers that are not finite, or in ever shorter events.
        Err(ReplayError::Dynamics(
            DynamicsError::NotFinite { .. } | DynamicsError::TooMuchWork { .. },
        )) => {
            return Ok(empty);
        }
        Err(ReplayError::WhyNot(why)) => {
            return Ok(TrialReplay { outcome: why.into(), ..empty });
        }
        other => other?,
    };
    // Where θ is given, the force comes out, and neither velocity nor reversal can depart.
    let moves = empty.causality != Causality::PositionDriven;
    let [recorded_signal, model_signal] =
        [recorded, &model].map(|course| if moves { &course.theta_rad } else { &course.force_ex_n });
    let mut comparison = compare(&recorded.t_s, recorded_signal, model_signal)?;
    // A drive counts from its first sample, the table by the trial's clock.
    comparison.peak_time_recorded_s += drive.began_s;
    let velocity = match moves {
        true => Some(compare_velocities(&recorded.t_s, &recorded.theta_rad, &model.theta_rad)?),
        false => None,
    };
    let turns = reversal_s(&model, analysis).zip(turned_s).filter(|_| moves);
    let reversal_error_s = turns.map(|(model, recorded)| model - recorded);
    Ok(TrialReplay {
        outcome: ReplayOutcome::Replayed,
        comparison: Some(comparison),
        velocity,
        reversal_error_s,
        ..empty
    })
}

/// First time of the largest θ between onset and end, by the study's thresholds of θ̇.
fn reversal_s(course: &Course, analysis: &Analysis) -> Option<f64> {
    let active = activity(&course.theta_dot_rad_s, analysis.onset_rad_s, analysis.offset_rad_s)?;
    let last = course.t_s.len() - 1;
    Some(course.t_s[phases(&course.theta_rad, active.onset, active.end.unwrap_or(last)).reversal])
}

fn has_diverged(model: &Course) -> bool {
    let (low, high) =
        model.theta_rad.iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
    let finite = model.theta_rad.iter().chain(&model.force_ex_n).all(|x| x.is_finite());
    !finite || high - low > DIVERGED_RAD
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{delayed, rendering, simulated};
    use zwidth_store::Signal;

    fn rows(trial: &Trial) -> Vec<TrialReplay> {
        let rendering = rendering(trial.meta.mode.as_str());
        replay(trial, &rendering, &Analysis::default(), ModelPlant::ByEye, &Parameters::BY_EYE)
            .unwrap()
    }

    #[test]
    fn a_trial_of_the_same_model_replays_without_error_or_lag() {
        for mode in ["active", "passive", "hybrid"] {
            let row = &rows(&simulated(mode, &Parameters::BY_EYE))[0];
            let found = row.comparison.unwrap();
            assert!(found.vaf.unwrap() > 1.0 - 1e-9, "{mode}: {found:?}");
            assert!(found.lag_s.unwrap().abs() < 1e-9, "{mode}: {found:?}");
            assert!(found.peak_error.abs() < 1e-9 && found.peak_time_error_s.abs() < 1e-9);
            assert!(row.reversal_error_s.unwrap().abs() < 1e-9);
            let velocity = row.velocity.unwrap();
            assert!(velocity.rmse_rad_s < 1e-9, "{mode}: {velocity:?}");
            assert!((velocity.sd_ratio.unwrap() - 1.0).abs() < 1e-9, "{mode}: {velocity:?}");
        }
    }

    #[test]
    fn the_plant_s_own_commands_move_it_as_it_moved() {
        for mode in ["active", "passive"] {
            let row = &rows(&simulated(mode, &Parameters::BY_EYE))[2];
            // commands are held for 5 ms where the model's own follow the spring at once
            let found = row.comparison.unwrap();
            assert!(found.vaf.unwrap() > 0.99, "{mode}: {found:?}");
        }
    }

    #[test]
    fn the_motion_gives_the_force_that_made_it() {
        let row = &rows(&simulated("active", &Parameters::BY_EYE))[1];
        let found = row.comparison.unwrap();
        assert!(found.vaf.unwrap() > 0.999, "{found:?}");
        assert_eq!((row.reversal_error_s, row.velocity), (None, None));
    }

    /// Given the motion, a motor that takes 53 µs gives what one without a lag gives.
    #[test]
    fn lags_do_not_take_the_actuators_out_of_the_force_that_a_motion_needs() {
        let plant = Parameters { motor_lag_s: 53e-6, brake_on_s: 0.015, ..Parameters::BY_EYE };
        let trial = simulated("active", &Parameters::BY_EYE);
        let rendering = rendering("active");
        let which = ModelPlant::Fitted;
        let row = &replay(&trial, &rendering, &Analysis::default(), which, &plant).unwrap()[1];
        assert!(row.comparison.unwrap().vaf.unwrap() > 0.999, "{row:?}");
    }

    #[test]
    fn a_motion_that_was_recorded_late_has_a_model_that_comes_early() {
        for samples in [4, 20] {
            let row = &rows(&delayed(&simulated("active", &Parameters::BY_EYE), samples))[0];
            let found = row.comparison.unwrap().lag_s.unwrap();
            let expect = -(samples as f64) * crate::testing::STEP_S;
            assert!((found - expect).abs() < 5e-4, "{found} instead of {expect}");
        }
    }

    #[test]
    fn another_plant_departs() {
        let heavy = Parameters {
            mass_kg: 2.0,
            damping_ns_per_rad: 0.2,
            friction_n: 0.1,
            ..Parameters::BY_EYE
        };
        let found = rows(&simulated("active", &heavy))[0].comparison.unwrap();
        assert!(found.vaf.unwrap() < 0.999 && found.rmse > 1e-3, "{found:?}");
    }

    #[test]
    fn what_is_missing_is_a_word_in_the_row() {
        let whole = simulated("active", &Parameters::BY_EYE);
        let words = |trial: &Trial, rendering: &Rendering| {
            let analysis = Analysis::default();
            let rows = replay(trial, rendering, &analysis, ModelPlant::ByEye, &Parameters::BY_EYE)
                .unwrap();
            rows.iter().map(|r| r.outcome.as_str()).collect::<Vec<_>>()
        };
        let calibrated = rendering("active");
        let without = Rendering { calibration: None, ..calibrated.clone() };
        assert_eq!(words(&whole, &without), ["no_calibration"; 3]);
        let mut trial = whole.clone();
        trial.samples = crate::testing::without(&whole.samples, Signal::VoltageMotor);
        assert_eq!(words(&trial, &calibrated), ["replayed", "replayed", "no_voltages"]);
        trial.samples = crate::testing::without(&whole.samples, Signal::ForceEx);
        assert_eq!(words(&trial, &calibrated), ["no_force"; 3]);
    }

    #[test]
    fn a_lever_that_runs_away_has_diverged() {
        let (stops_rad, rendered) = (None, zwidth_study::Scene::Free);
        let free = Rendering { stops_rad, rendered, ..rendering("active") };
        let trial = simulated("active", &Parameters::BY_EYE);
        let light = Parameters { damping_ns_per_rad: 1e-3, ..Parameters::BY_EYE };
        let rows = replay(&trial, &free, &Analysis::default(), ModelPlant::ByEye, &light).unwrap();
        assert_eq!((rows[0].outcome, rows[0].comparison), (ReplayOutcome::Diverged, None));
    }
}
