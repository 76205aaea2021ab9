//! The study's own metrics of a run, beside those of the right run.

use crate::TradeError;
use zwidth_dynamics::{System, Trajectory};
use zwidth_judge::{Yardstick, places};
use zwidth_study::{Measured, Perception, is_felt};

/// At most so many samples of a run are measured, evenly chosen: every 2 ms of four seconds.
const MOST_MEASURED: usize = 2_000;

/// A run as a study would have recorded it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Course {
    /// Times, s.
    pub t_s: Vec<f64>,
    /// Lever angle, rad.
    pub theta_rad: Vec<f64>,
    /// Lever velocity, rad/s.
    pub theta_dot_rad_s: Vec<f64>,
    /// User force, N.
    pub force_ex_n: Vec<f64>,
    /// What motor and brake resist with, N.
    pub feedback_n: Vec<f64>,
}

/// The metrics of a course, always the same ones in the same order.
pub type Measure<'a> = dyn Fn(&Course) -> Vec<Measured> + Sync + 'a;

/// What the metrics of runs are compared by.
#[derive(Clone, Copy)]
pub struct Metrics<'a> {
    /// The metrics.
    pub measure: &'a Measure<'a>,
    /// What a person can feel.
    pub bounds: &'a Perception,
}

/// A metric of a run and of the right one.
#[derive(Debug, Clone, PartialEq)]
pub struct MetricChange {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Of the right run.
    pub right: Option<f64>,
    /// Of the run.
    pub found: Option<f64>,
    /// Change relative to what is just felt; `None` if that is not known, or one of the two is
    /// missing.
    pub felt_share: Option<f64>,
}

impl MetricChange {
    /// How much it changes.
    pub fn change(&self) -> Option<f64> {
        Some(self.found? - self.right?)
    }

    /// The size of the change over the right value's; `None` where that is 0.
    pub fn relative(&self) -> Option<f64> {
        let right = self.right.filter(|right| right.abs() > 0.0)?;
        Some((self.change()? / right).abs())
    }

    /// Whether one run has it and the other one does not.
    pub fn is_lost(&self) -> bool {
        self.right.is_some() != self.found.is_some()
    }
}

/// Every metric of a run that describes something that can be felt, beside the right run's at the
/// same times.
pub(crate) fn changes(
    yardstick: &Yardstick,
    run: &Trajectory,
    metrics: &Metrics<'_>,
) -> Result<Vec<MetricChange>, TradeError> {
    let places = places(run, MOST_MEASURED);
    let right = yardstick.at(places.iter().map(|i| run.t_s[*i]).collect())?;
    let system = &yardstick.system;
    let lever_m = system.scene().plant.lever_m;
    let all: Vec<usize> = (0..right.len()).collect();
    let [own, right] = [(run, &places), (&right, &all)]
        .map(|(run, at)| (metrics.measure)(&course(system, run, at)));
    let pairs = own.into_iter().zip(right).filter(|(own, _)| is_felt(&own.name));
    Ok(pairs
        .map(|(own, right)| {
            let off = metrics.bounds.off(own.value, right.value, &own.unit, lever_m);
            let is_in_both = own.value.is_some() && right.value.is_some();
            let felt_share = off.filter(|off| off.is_finite() && is_in_both);
            let Measured { name, unit, value } = own;
            MetricChange { name, unit, right: right.value, found: value, felt_share }
        })
        .collect())
}

fn course(system: &System, run: &Trajectory, places: &[usize]) -> Course {
    let (theta, theta_dot): (Vec<f64>, Vec<f64>) =
        (run.theta_rad().collect(), run.theta_dot_rad_s().collect());
    let mut course = Course::default();
    for i in places {
        let forces = run.forces(system, *i);
        course.t_s.push(run.t_s[*i]);
        course.theta_rad.push(theta[*i]);
        course.theta_dot_rad_s.push(theta_dot[*i]);
        course.force_ex_n.push(forces.external_n);
        course.feedback_n.push(-(forces.motor_n + forces.brake_n));
    }
    course
}

#[cfg(test)]
mod tests {
    use super::*;

    fn change(right: Option<f64>, found: Option<f64>) -> MetricChange {
        let (name, unit) = ("peak_n".to_owned(), "N".to_owned());
        MetricChange { name, unit, right, found, felt_share: None }
    }

    #[test]
    fn a_change_is_of_the_right_value_and_what_one_of_them_lacks_is_lost() {
        let relative = change(Some(-4.0), Some(-5.0)).relative();
        assert!((relative.unwrap() - 0.25).abs() < 1e-15);
        assert_eq!(change(Some(0.0), Some(1.0)).relative(), None);
        assert!(change(Some(1.0), None).is_lost() && !change(None, None).is_lost());
    }
}
