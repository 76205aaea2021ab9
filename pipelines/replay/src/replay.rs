//! One trial in three causalities.

use crate::compare::{compare, compare_velocities};
use crate::{Course, Drive, Parameters, Rendering, ReplayError};
use zwidth_dynamics::DynamicsError;
use zwidth_numerics::activity::activity;
use zwidth_numerics::phases::phases;
use zwidth_results::{Causality, ModelPlant, ReplayOutcome, ReplayedTrial};
use zwidth_store::Trial;
use zwidth_study::Analysis;

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
) -> Result<Vec<ReplayedTrial>, ReplayError> {
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
) -> Result<Vec<ReplayedTrial>, ReplayError> {
    let drive = match Drive::new(trial, rendering) {
        Err(ReplayError::WhyNot(why)) => Err(why),
        other => Ok(other?),
    };
    let meta = &trial.meta;
    let mut replays = Vec::new();
    for causality in Causality::ALL.iter().copied() {
        let empty = ReplayedTrial {
            participant: meta.participant.clone(),
            session: meta.session.clone(),
            trial: meta.trial,
            repeat: meta.repeat,
            environment: meta.environment.clone(),
            mode: meta.mode.clone(),
            source: meta.source,
            causality,
            model: which,
            outcome: ReplayOutcome::Diverged,
            mass_kg: parameters.mass_kg,
            damping_n_s_per_rad: parameters.damping_ns_per_rad,
            friction_n: parameters.friction_n,
            nrmse: None,
            vaf: None,
            lag_s: None,
            rmse_rad: None,
            rmse_n: None,
            peak_recorded_rad: None,
            peak_error_rad: None,
            peak_recorded_n: None,
            peak_error_n: None,
            peak_time_recorded_s: None,
            peak_time_error_s: None,
            velocity_rmse_rad_s: None,
            velocity_nrmse: None,
            velocity_sd_ratio: None,
            reversal_recorded_s: None,
            reversal_error_s: None,
        };
        replays.push(match &drive {
            Err(why) => ReplayedTrial { outcome: (*why).into(), ..empty },
            Ok(drive) => replayed(drive, analysis, parameters, empty, force_driven)?,
        });
    }
    Ok(replays)
}

/// Fills in one causality's replay of a trial.
fn replayed(
    drive: &Drive,
    analysis: &Analysis,
    parameters: &Parameters,
    empty: ReplayedTrial,
    force_driven: &dyn Fn(&Drive) -> Result<Course, ReplayError>,
) -> Result<ReplayedTrial, ReplayError> {
    let recorded = drive.recorded();
    let turned_s = reversal_s(recorded, analysis);
    let empty = ReplayedTrial { reversal_recorded_s: turned_s.map(|t| t + drive.began_s), ..empty };
    let run = match empty.causality {
        Causality::ForceDriven => force_driven(drive),
        other => drive.run(other, parameters),
    };
    let model = match run {
        Ok(model) if has_diverged(&model) => return Ok(empty),
        // A model that runs away may end in numbers that are not finite, or in ever shorter events.
        Err(ReplayError::Dynamics(
            DynamicsError::NotFinite { .. } | DynamicsError::TooMuchWork { .. },
        )) => return Ok(empty),
        Err(ReplayError::WhyNot(why)) => return Ok(ReplayedTrial { outcome: why.into(), ..empty }),
        other => other?,
    };
    // Where θ is given, the force comes out, and neither velocity nor reversal can depart.
    let moves = empty.causality != Causality::PositionDriven;
    let [recorded_signal, model_signal] =
        [recorded, &model].map(|course| if moves { &course.theta_rad } else { &course.force_ex_n });
    let found = compare(&recorded.t_s, recorded_signal, model_signal)?;
    let velocity = moves
        .then(|| compare_velocities(&recorded.t_s, &recorded.theta_rad, &model.theta_rad))
        .transpose()?;
    let turns = reversal_s(&model, analysis).zip(turned_s).filter(|_| moves);
    Ok(ReplayedTrial {
        outcome: ReplayOutcome::Replayed,
        nrmse: found.nrmse,
        vaf: found.vaf,
        lag_s: found.lag_s,
        rmse_rad: moves.then_some(found.rmse),
        rmse_n: (!moves).then_some(found.rmse),
        peak_recorded_rad: moves.then_some(found.peak_recorded),
        peak_error_rad: moves.then_some(found.peak_error),
        peak_recorded_n: (!moves).then_some(found.peak_recorded),
        peak_error_n: (!moves).then_some(found.peak_error),
        // A drive counts from its first sample, the table by the trial's clock.
        peak_time_recorded_s: Some(found.peak_time_recorded_s + drive.began_s),
        peak_time_error_s: Some(found.peak_time_error_s),
        velocity_rmse_rad_s: velocity.map(|velocity| velocity.rmse_rad_s),
        velocity_nrmse: velocity.and_then(|velocity| velocity.nrmse),
        velocity_sd_ratio: velocity.and_then(|velocity| velocity.sd_ratio),
        reversal_error_s: turns.map(|(model, recorded)| model - recorded),
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
    use crate::testing::{delayed, rendering, replayed_with, replays, simulated};
    use zwidth_store::Signal;

    #[test]
    fn a_trial_of_the_same_model_replays_without_error_or_lag() {
        for mode in ["active", "passive", "hybrid"] {
            let row = &replays(&simulated(mode, &Parameters::BY_EYE))[0];
            assert!(row.vaf.unwrap() > 1.0 - 1e-9, "{mode}: {row:?}");
            for error in [
                row.lag_s,
                row.peak_error_rad,
                row.peak_time_error_s,
                row.reversal_error_s,
                row.velocity_rmse_rad_s,
            ] {
                assert!(error.unwrap().abs() < 1e-9, "{mode}: {row:?}");
            }
            assert!((row.velocity_sd_ratio.unwrap() - 1.0).abs() < 1e-9, "{mode}: {row:?}");
        }
    }

    #[test]
    fn the_plant_s_own_commands_move_it_as_it_moved() {
        for mode in ["active", "passive"] {
            let row = &replays(&simulated(mode, &Parameters::BY_EYE))[2];
            // commands are held for 5 ms where the model's own follow the spring at once
            assert!(row.vaf.unwrap() > 0.99, "{mode}: {row:?}");
        }
    }

    #[test]
    fn the_motion_gives_the_force_that_made_it() {
        let row = &replays(&simulated("active", &Parameters::BY_EYE))[1];
        assert!(row.vaf.unwrap() > 0.999, "{row:?}");
        assert_eq!(row.reversal_error_s, None);
        let velocity = [row.velocity_rmse_rad_s, row.velocity_nrmse, row.velocity_sd_ratio];
        assert_eq!(velocity, [None; 3]);
    }

    /// Given the motion, a motor that takes 53 µs gives what one without a lag gives.
    #[test]
    fn lags_do_not_take_the_actuators_out_of_the_force_that_a_motion_needs() {
        let plant = Parameters { motor_lag_s: 53e-6, brake_on_s: 0.015, ..Parameters::BY_EYE };
        let trial = simulated("active", &Parameters::BY_EYE);
        let row = &replayed_with(&trial, &rendering("active"), &plant)[1];
        assert!(row.vaf.unwrap() > 0.999, "{row:?}");
    }

    #[test]
    fn a_motion_that_was_recorded_late_has_a_model_that_comes_early() {
        for samples in [4, 20] {
            let row = &replays(&delayed(&simulated("active", &Parameters::BY_EYE), samples))[0];
            let found = row.lag_s.unwrap();
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
        let row = &replays(&simulated("active", &heavy))[0];
        assert!(row.vaf.unwrap() < 0.999 && row.rmse_rad.unwrap() > 1e-3, "{row:?}");
    }

    #[test]
    fn what_is_missing_is_a_word_in_the_row() {
        let whole = simulated("active", &Parameters::BY_EYE);
        let words = |trial: &Trial, rendering: &Rendering| {
            let rows = replayed_with(trial, rendering, &Parameters::BY_EYE);
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
        let late = Rendering { delay_s: 0.02, ..calibrated };
        assert_eq!(words(&whole, &late), ["delayed", "delayed", "replayed"]);
    }

    #[test]
    fn a_constant_force_asks_for_itself_wherever_the_lever_is() {
        let rendered = zwidth_study::Scene::Force { force_n: 1.25 };
        let constant = Rendering { rendered, ..rendering("active") };
        let trial = simulated("active", &Parameters::BY_EYE);
        let drive = Drive::new(&trial, &constant).unwrap();
        let course = drive.run(Causality::PositionDriven, &Parameters::BY_EYE).unwrap();
        let feedback_n = course.feedback_n.unwrap();
        assert!(feedback_n.iter().all(|force_n| (force_n - 1.25).abs() < 1e-12));
    }

    #[test]
    fn a_lever_that_runs_away_has_diverged() {
        let (stops_rad, rendered) = (None, zwidth_study::Scene::Free);
        let free = Rendering { stops_rad, rendered, ..rendering("active") };
        let trial = simulated("active", &Parameters::BY_EYE);
        let light = Parameters { damping_ns_per_rad: 1e-3, ..Parameters::BY_EYE };
        let rows = replayed_with(&trial, &free, &light);
        let row = &rows[0];
        assert_eq!(row.outcome, ReplayOutcome::Diverged);
        let errors = [row.rmse_rad, row.peak_error_rad, row.peak_time_error_s];
        assert_eq!([[row.vaf, row.nrmse, row.lag_s], errors], [[None; 3]; 2]);
    }
}
