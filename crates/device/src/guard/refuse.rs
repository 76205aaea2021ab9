//! A request for voltages, and the limits that it is held against.

use zwidth_study::{Mode, Voltages};

/// The most a motor may push one finger with, N (Wang et al. 2019, as the thesis quotes it).
pub const MOTOR_FORCE_N: f64 = 10.0;

/// The least rate of a force sensor that a control law switches on, Hz: the faster of the HX711's
/// two.
pub const FORCE_RATE_HZ: f64 = 80.0;

/// Voltages that are to be allowed, and for whom.
pub(super) struct Request<'a> {
    /// The mode's id, or what else is to use the actuators.
    pub(super) name: &'a str,
    /// Highest voltages.
    pub(super) most: Voltages,
    /// The loop is closed over the force sensor.
    pub(super) switches_on_force: bool,
}

impl<'a> Request<'a> {
    /// A mode with both actuators switches between them on the user's force.
    pub(super) fn of_mode(mode: &'a Mode) -> Self {
        let motor_v = mode.motor_max_v.unwrap_or(0.0);
        let brake_v = mode.brake_max_v.unwrap_or(0.0);
        Self {
            name: mode.id.as_str(),
            most: Voltages { motor_v, brake_v },
            switches_on_force: motor_v > 0.0 && brake_v > 0.0,
        }
    }
}

/// What is not a number exceeds everything.
pub(super) fn exceeds(value: f64, most: f64) -> bool {
    value > most || value.is_nan() || most.is_nan()
}

#[cfg(test)]
mod tests {
    use super::super::Refusal;
    use crate::trial::tests::{LIMITS, mode_of};
    use crate::{Capabilities, Guard, Limits, mock};
    use zwidth_study::{Calibration, Mode};

    fn admit(capabilities: &Capabilities, mode: &Mode) -> Result<(), Refusal> {
        Guard::new(capabilities, LIMITS, false).admit(mode, &Calibration::thesis())
    }

    fn refused(capabilities: &Capabilities, mode: &Mode) -> String {
        admit(capabilities, mode).unwrap_err().to_string()
    }

    #[test]
    fn the_prototypes_three_modes_are_allowed() {
        for mode in
            [mode_of(Some(16.0), None), mode_of(None, Some(8.0)), mode_of(Some(8.0), Some(8.0))]
        {
            assert_eq!(admit(&mock::capabilities(), &mode), Ok(()));
        }
    }

    #[test]
    fn the_motor_of_a_device_without_a_watchdog_is_refused_unless_the_risk_is_taken() {
        let capabilities = Capabilities { watchdog_s: None, ..mock::capabilities() };
        let active = mode_of(Some(16.0), None);
        assert!(refused(&capabilities, &active).contains("no watchdog"));
        let guard = Guard::new(&capabilities, LIMITS, true);
        assert_eq!(guard.admit(&active, &Calibration::thesis()), Ok(()));
        assert_eq!(admit(&capabilities, &mode_of(None, Some(8.0))), Ok(()));
    }

    #[test]
    fn a_mode_that_switches_on_a_slow_force_is_refused_and_one_that_does_not_is_allowed() {
        let capabilities = Capabilities { force_rate_hz: 10.0, ..mock::capabilities() };
        let refused = refused(&capabilities, &mode_of(Some(8.0), Some(8.0)));
        assert!(refused.contains("10 times per second; 80 are needed"), "{refused}");
        for mode in [mode_of(Some(16.0), None), mode_of(None, Some(8.0))] {
            assert_eq!(admit(&capabilities, &mode), Ok(()));
        }
    }

    #[test]
    fn more_than_10_n_of_motor_is_refused() {
        let mut strong = Calibration::thesis();
        strong.motor.force_n[1] = 10.4;
        let admit = |motor_v, force_n| {
            let limits = Limits { force_n, ..LIMITS };
            let guard = Guard::new(&mock::capabilities(), limits, false);
            guard.admit(&mode_of(Some(motor_v), None), &strong)
        };
        let refused = admit(16.0, 20.0).unwrap_err().to_string();
        assert!(refused.contains("give 10.40 N of motor force"), "{refused}");
        assert_eq!(admit(15.0, 20.0), Ok(()));
        assert!(admit(15.0, 5.0).is_err());
    }

    #[test]
    fn more_voltage_than_there_is_is_refused_and_so_is_less_than_none_and_what_is_not_a_number() {
        for (motor_v, brake_v, key) in
            [(16.1, 8.0, "motor_max_v"), (8.0, 8.1, "brake_max_v"), (-1.0, 8.0, "motor_max_v")]
        {
            let refused = refused(&mock::capabilities(), &mode_of(Some(motor_v), Some(brake_v)));
            assert!(refused.contains(key), "{refused}");
        }
        let nan = refused(&mock::capabilities(), &mode_of(None, Some(f64::NAN)));
        assert!(nan.contains("NaN V of the brake"), "{nan}");
    }
}
