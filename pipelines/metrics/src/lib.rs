//! Stage: the metrics of a trial, one row per trial.
//!
//! [`trial_metrics`] turns one trial into a [`TrialMetrics`], and [`plant_metrics`] into
//! [`PlantMetrics`], once the plant is known; [`table`] and [`plant_table`] put rows together,
//! [`join_plant`] both. Nothing here reads a file or a clock, and sums run in the order of the samples, so the same trial gives the
//! same bits anywhere. Only trials that count may come in (`StudyData::counting`): the caller
//! filters.
//!
//! # Conventions
//! * θ grows into the object, and a force is positive where it pushes into the object, so that
//!   F dx > 0 is work of the user on the device. x = L θ, L the lever length; without one
//!   everything in metres or joules is null.
//! * **Compression** is onset → reversal, **decompression** reversal → end; the reversal is the
//!   first sample of the largest θ. Without a recorded velocity there is neither onset nor end, and
//!   the whole recording stands in for the movement.
//! * **The force** counts at the times at which its sensor gave new values, with straight lines
//!   between them, if the recording gives their age (`force_age_s`); else as recorded. A held value
//!   lags behind by half of the sensor's interval on average: it would make loops too small and an
//!   elastic spring look active.
//! * In a study with axes, θ L and the force are projections on the push, and all of this is along it;
//!   only [`Space`] is of all axes.
//! * A metric is null (`None`) if the recording lacks what it needs, or if it does not apply;
//!   missing data never give 0.
//!
//! The definitions are at the fields of [`Movement`], [`UserForce`], [`Discrepancy`],
//! [`SpringRendering`], [`WallContact`], [`Stability`], [`ElectricalEnergy`], [`StepResponse`],
//! [`Compliance`], [`Space`], [`ActuatorDiscrepancy`] and [`EnergyObserver`].

mod actuator;
mod branch;
mod by_mode;
mod columns;
mod compliance;
mod conditions;
mod discrepancy;
mod electricity;
mod energy;
mod error;
mod events;
mod force;
mod gap;
mod movement;
mod oscillation;
mod own;
mod parameters;
mod part;
mod plant;
mod plateau;
#[cfg(test)]
mod real_data;
mod resolution;
mod signals;
mod space;
mod spring;
mod stability;
mod step;
mod table;
#[cfg(test)]
mod testing;
mod wall;

pub use actuator::ActuatorDiscrepancy;
pub use by_mode::by_mode;
pub use columns::{
    VERSION, better, commanded, in_words, is_felt, is_number, is_of_answers, is_of_plant,
    is_possible, names, needs_lever, outside as outside_metrics, own as own_metrics, score_of,
    scores, taken,
};
pub use compliance::Compliance;
pub use conditions::{ConditionsError, by_condition, summarised};
pub use discrepancy::Discrepancy;
pub use electricity::ElectricalEnergy;
pub use energy::EnergyObserver;
pub use error::MetricsError;
pub use events::TimedEvent;
pub use force::UserForce;
pub use movement::Movement;
pub use oscillation::Swings;
pub use parameters::{Parameters, Plant, SIGNALS};
pub use plant::{PLANT_SIGNALS, PlantMetrics, plant_metrics};
pub use space::Space;
pub use spring::{Saturation, SpringRendering};
pub use stability::Stability;
pub use step::StepResponse;
pub use table::{OutsideColumn, join_outside, join_plant, join_sessions, plant_table, table};
pub use wall::WallContact;

use signals::Signals;
use zwidth_store::Recorded;
use zwidth_study::TrialMeta;

/// The metrics of one trial.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialMetrics {
    /// Which trial.
    pub meta: TrialMeta,
    /// When and how fast it moved.
    pub movement: Movement,
    /// The user's force, with or without a movement.
    pub force: UserForce,
    /// How far compression and decompression differ in the user's force; all null where the
    /// environment has no spring.
    pub discrepancy: Discrepancy,
    /// How the spring was rendered; all null if the environment has no spring.
    pub spring: SpringRendering,
    /// What happened at the wall; all null if the environment has no wall.
    pub wall: WallContact,
    /// How steadily the device behaved.
    pub stability: Stability,
    /// What it took from the supply, where currents were recorded, and at most.
    pub electricity: ElectricalEnergy,
    /// How the angle follows a step of its reference, where one was recorded.
    pub step: StepResponse,
    /// Whether the trial was what the protocol asks for.
    pub compliance: Compliance,
    /// Movement and force in several axes; all null in a study without axes.
    pub space: Space,
    /// The study's own, in the order of study.toml.
    pub own: Vec<Option<f64>>,
    /// What happened when.
    pub events: Vec<TimedEvent>,
}

/// The metrics of `trial`.
///
/// # Errors
/// Samples without time or of unequal length; a value that is not a number.
pub fn trial_metrics<'a>(
    trial: impl Into<Recorded<'a>>,
    parameters: &Parameters,
) -> Result<TrialMetrics, MetricsError> {
    let Recorded { meta, columns } = trial.into();
    let signals = Signals::of(columns, parameters)?;
    let analysis = &parameters.analysis;
    let spring = parameters.scene.spring();
    let wall_rad = parameters.scene.wall_rad();
    let discrepancy = spring
        .map(|_| discrepancy::discrepancy(&signals, analysis.grid_points, analysis.confidence));
    let rendering =
        spring.map(|spring| spring::spring_rendering(&signals, spring, wall_rad, analysis));
    let wall = wall_rad.map(|wall| wall::wall_contact(&signals, wall, analysis));
    let movement = movement::movement(&signals, parameters)?;
    Ok(TrialMetrics {
        meta: meta.clone(),
        events: events::trial_events(&signals, &movement, wall_rad)?,
        movement,
        force: force::user_force(&signals)?,
        discrepancy: discrepancy.transpose()?.unwrap_or_default(),
        spring: rendering.transpose()?.unwrap_or_default(),
        wall: wall.transpose()?.unwrap_or_default(),
        stability: stability::stability(&signals, parameters.force_rate_hz)?,
        electricity: electricity::electrical_energy(&signals, parameters),
        step: step::step_response(&signals),
        compliance: compliance::compliance(&signals, parameters),
        space: match &parameters.axes {
            Some(axes) => space::space(&signals, axes)?,
            None => Space::default(),
        },
        own: own::own_metrics(&signals, parameters)?,
    })
}

/// Whether `trial` was what the protocol asks for: as [`trial_metrics`] says it, without its other metrics.
///
/// # Errors
/// Those of [`trial_metrics`].
pub fn compliance_of<'a>(
    trial: impl Into<Recorded<'a>>,
    parameters: &Parameters,
) -> Result<Compliance, MetricsError> {
    let Recorded { columns, .. } = trial.into();
    Ok(compliance::compliance(&Signals::of(columns, parameters)?, parameters))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{REST_RAD, at_wall, in_spring, only, stroke, trial};
    use std::cell::RefCell;
    use std::sync::{Arc, Weak};
    use zwidth_store::{Columns, Samples, Signal, Values};
    use zwidth_study::{CURRENT_BRAKE, CURRENT_MOTOR, REFERENCE};

    #[test]
    fn free_motion_has_movement_and_nothing_that_was_not_rendered() {
        let mut parameters = in_spring(4.0, 0.0);
        parameters.scene = zwidth_study::Scene::Free;
        let row = trial_metrics(&trial(&stroke(1.0, 0.5), |_, v| v), &parameters).unwrap();
        assert!(row.movement.velocity_forward_peak_rad_s.is_some());
        let rest = (row.discrepancy, row.spring, row.wall);
        assert_eq!(
            rest,
            (Discrepancy::default(), SpringRendering::default(), WallContact::default())
        );
    }

    #[test]
    fn a_torque_only_recording_has_movement_and_null_forces() {
        let trial = trial(&stroke(1.0, 0.5), |_, _| 0.0);
        let mut trial = only(&trial, [Signal::Time, Signal::Theta, Signal::ThetaDot]);
        trial.samples.set(Signal::TorqueEx, vec![0.1; trial.samples.len()]);
        let row = trial_metrics(&trial, &in_spring(4.0, 0.0)).unwrap();
        assert!(row.movement.onset_s.is_some());
        assert_eq!(row.discrepancy, Discrepancy::default());
        assert_eq!(row.spring, SpringRendering::default());
    }

    /// A force sensor of one value every 12 ms on an elastic spring of 4 N/rad: held values lag by
    /// 5.5 ms on average, which makes a loop of −τ K L ∫θ̇² dt = −3.5 mJ; at the times at which
    /// they were taken they make none.
    #[test]
    fn a_held_force_counts_when_it_was_taken_and_makes_no_loop() {
        let points = stroke(1.2, 2.0);
        let index: Vec<usize> = (0..points.len()).map(|i| i - i % 12).collect();
        let mut trial = trial(&points, |_, _| 0.0);
        let rest = -core::f64::consts::FRAC_PI_4;
        trial
            .samples
            .set(Signal::ForceEx, index.iter().map(|&i| 4.0 * (points[i].1 - rest)).collect());
        let parameters = in_spring(4.0, rest);
        let held = trial_metrics(&trial, &parameters).unwrap();
        trial.samples.set(
            Signal::ForceAge,
            index.iter().zip(&points).map(|(&i, now)| now.0 - points[i].0).collect(),
        );
        let at_updates = trial_metrics(&trial, &parameters).unwrap();
        assert!((held.discrepancy.loop_area_j.unwrap() + 3.5e-3).abs() < 3e-4, "{held:?}");
        assert!(at_updates.discrepancy.loop_area_j.unwrap().abs() < 2e-5, "{at_updates:?}");
    }

    /// Samples that are lent column by column, as those of a long trial's file are.
    struct Lent<'a> {
        samples: &'a Samples,
        lent: RefCell<Vec<Weak<Vec<f64>>>>,
    }

    impl Lent<'_> {
        fn lend<'a>(&self, values: Option<Values<'_>>) -> Option<Values<'a>> {
            let values = Arc::new(values?.to_vec());
            let mut lent = self.lent.borrow_mut();
            lent.retain(|values| values.strong_count() > 0);
            lent.push(Arc::downgrade(&values));
            assert!(lent.len() <= 3, "{} columns at a time", lent.len());
            Some(Values::Read(values))
        }
    }

    impl Columns for Lent<'_> {
        fn rows(&self) -> usize {
            self.samples.rows()
        }

        fn column(&self, signal: Signal) -> Option<Values<'_>> {
            assert!(SIGNALS.contains(&signal), "{signal:?} is not among the signals read");
            self.lend(self.samples.column(signal))
        }

        fn has(&self, signal: Signal) -> bool {
            assert!(SIGNALS.contains(&signal), "{signal:?} is not among the signals read");
            self.samples.has(signal)
        }

        fn channel(&self, name: &str) -> Option<Values<'_>> {
            self.lend(Columns::channel(self.samples, name))
        }
    }

    #[test]
    fn no_metric_needs_more_than_three_columns_at_a_time_and_lent_ones_have_the_same_metrics() {
        let points = stroke(1.2, 2.0);
        let mut made = trial(&points, |theta, v| 4.0 * (theta - REST_RAD) + 0.3 * v.signum());
        let on = |from: f64| points.iter().map(|p| f64::from(u8::from(p.0 > from))).collect();
        made.samples.set(Signal::VoltageMotor, on(1.5));
        made.samples.set(Signal::VoltageBrake, on(1.0));
        made.samples.set(Signal::ForceCmd, points.iter().map(|p| 4.0 * p.1).collect());
        for name in [CURRENT_MOTOR, CURRENT_BRAKE, REFERENCE] {
            made.samples.set_channel(name.parse().unwrap(), on(0.7));
        }
        let plant = Plant {
            mass_kg: 0.4,
            damping_ns_per_rad: 0.15,
            friction_n: 0.2,
            covariance: [[0.0; 3]; 3],
            df: 12.0,
        };
        for parameters in [in_spring(4.0, REST_RAD), at_wall(4.0, REST_RAD, REST_RAD + 1.0)] {
            let columns = &Lent { samples: &made.samples, lent: RefCell::default() };
            let lent = Recorded { meta: &made.meta, columns };
            assert_eq!(trial_metrics(lent, &parameters), trial_metrics(&made, &parameters));
            let few = only(&made, PLANT_SIGNALS);
            let [lent, few, held] = [lent, (&few).into(), (&made).into()]
                .map(|trial| plant_metrics(trial, &parameters, Some(&plant)).unwrap());
            assert!(held.energy.closed_loops.is_some() && held.discrepancy.mean_n.is_some());
            assert_eq!(lent, held);
            assert_eq!(few, held, "nothing but these signals is looked at");
        }
    }

    #[test]
    fn samples_of_unequal_length_are_refused() {
        let mut trial = trial(&stroke(1.0, 0.5), |_, _| 0.0);
        trial.samples.set(Signal::ForceEx, vec![0.0]);
        let error = trial_metrics(&trial, &in_spring(4.0, 0.0)).unwrap_err();
        assert!(error.to_string().contains("force_ex_n"), "{error}");
    }
}
