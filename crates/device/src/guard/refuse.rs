//! Which modes are never allowed on a device.

use super::Refusal;
use crate::Capabilities;
use zwidth_study::{Calibration, Mode, Voltages};

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

/// The first reason against voltages on a device. The motor may give no more than the
/// limit of the study, and never more than [`MOTOR_FORCE_N`].
pub(super) fn refuse(
    device: &Capabilities,
    request: &Request<'_>,
    calibration: &Calibration,
    force_limit_n: f64,
    no_watchdog: bool,
) -> Result<(), Refusal> {
    let Voltages { motor_v, brake_v } = request.most;
    if motor_v > 0.0 && device.watchdog_s.is_none() && !no_watchdog {
        return Err(Refusal::NoWatchdog {
            device: device.name.clone(),
            mode: request.name.to_owned(),
        });
    }
    within(device, request, "motor", motor_v, device.motor_max_v)?;
    within(device, request, "brake", brake_v, device.brake_max_v)?;
    let force_n = calibration.motor.force_n(motor_v);
    let most_n = force_limit_n.min(MOTOR_FORCE_N);
    if exceeds(force_n, most_n) {
        let mode = request.name.to_owned();
        return Err(Refusal::MotorForce { mode, voltage_v: motor_v, force_n, most_n });
    }
    if request.switches_on_force && exceeds(FORCE_RATE_HZ, device.force_rate_hz) {
        let found_hz = device.force_rate_hz;
        let least_hz = FORCE_RATE_HZ;
        let device = device.name.clone();
        let mode = request.name.to_owned();
        return Err(Refusal::SlowForce { device, mode, found_hz, least_hz });
    }
    Ok(())
}

fn within(
    device: &Capabilities,
    request: &Request<'_>,
    actuator: &'static str,
    asked_v: f64,
    most_v: f64,
) -> Result<(), Refusal> {
    if asked_v >= 0.0 && !exceeds(asked_v, most_v) {
        return Ok(());
    }
    let device = device.name.clone();
    let mode = request.name.to_owned();
    Err(Refusal::Voltage { device, mode, actuator, asked_v, most_v })
}

/// What is not a number exceeds everything.
pub(super) fn exceeds(value: f64, most: f64) -> bool {
    value > most || value.is_nan() || most.is_nan()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mock;

    fn mode(motor_max_v: Option<f64>, brake_max_v: Option<f64>) -> Mode {
        Mode { id: "m".parse().unwrap(), label: String::new(), motor_max_v, brake_max_v, law: None }
    }

    fn refuse(
        capabilities: &Capabilities,
        mode: &Mode,
        calibration: &Calibration,
        force_limit_n: f64,
        no_watchdog: bool,
    ) -> Result<(), Refusal> {
        super::refuse(
            capabilities,
            &Request::of_mode(mode),
            calibration,
            force_limit_n,
            no_watchdog,
        )
    }

    fn refused(capabilities: &Capabilities, mode: &Mode) -> String {
        refuse(capabilities, mode, &Calibration::thesis(), 10.0, false).unwrap_err().to_string()
    }

    #[test]
    fn the_prototypes_three_modes_are_allowed() {
        for mode in [mode(Some(16.0), None), mode(None, Some(8.0)), mode(Some(8.0), Some(8.0))] {
            assert_eq!(
                refuse(&mock::capabilities(), &mode, &Calibration::thesis(), 10.0, false),
                Ok(())
            );
        }
    }

    #[test]
    fn the_motor_of_a_device_without_a_watchdog_is_refused_unless_the_risk_is_taken() {
        let capabilities = Capabilities { watchdog_s: None, ..mock::capabilities() };
        let active = mode(Some(16.0), None);
        assert!(refused(&capabilities, &active).contains("no watchdog"));
        assert_eq!(refuse(&capabilities, &active, &Calibration::thesis(), 10.0, true), Ok(()));
        assert_eq!(
            refuse(&capabilities, &mode(None, Some(8.0)), &Calibration::thesis(), 10.0, false),
            Ok(())
        );
    }

    #[test]
    fn a_mode_that_switches_on_a_slow_force_is_refused_and_one_that_does_not_is_allowed() {
        let capabilities = Capabilities { force_rate_hz: 10.0, ..mock::capabilities() };
        assert!(
            refused(&capabilities, &mode(Some(8.0), Some(8.0)))
                .contains("10 times per second; 80 are needed")
        );
        for mode in [mode(Some(16.0), None), mode(None, Some(8.0))] {
            assert_eq!(refuse(&capabilities, &mode, &Calibration::thesis(), 10.0, false), Ok(()));
        }
    }

    #[test]
    fn more_than_10_n_of_motor_is_refused() {
        let mut strong = Calibration::thesis();
        strong.motor.force_n[1] = 10.4;
        let refused = refuse(&mock::capabilities(), &mode(Some(16.0), None), &strong, 20.0, false)
            .unwrap_err();
        assert!(matches!(refused, Refusal::MotorForce { force_n, .. } if force_n > 10.39));
        assert_eq!(
            refuse(&mock::capabilities(), &mode(Some(15.0), None), &strong, 20.0, false),
            Ok(())
        );
        assert!(
            refuse(&mock::capabilities(), &mode(Some(15.0), None), &strong, 5.0, false).is_err()
        );
    }

    #[test]
    fn more_voltage_than_there_is_is_refused_and_so_is_less_than_none_and_what_is_not_a_number() {
        for (motor_v, brake_v, key) in
            [(16.1, 8.0, "motor_max_v"), (8.0, 8.1, "brake_max_v"), (-1.0, 8.0, "motor_max_v")]
        {
            let refused = refused(&mock::capabilities(), &mode(Some(motor_v), Some(brake_v)));
            assert!(refused.contains(key), "{refused}");
        }
        let nan = refuse(
            &mock::capabilities(),
            &mode(None, Some(f64::NAN)),
            &Calibration::thesis(),
            10.0,
            false,
        );
        assert!(matches!(nan, Err(Refusal::Voltage { actuator: "brake", .. })));
    }
}
