//! Displacement control (thesis Fig. 7): the motion is given, the forces follow from the equations
//! of motion.

use crate::system::{OMEGA, System, THETA};
use crate::trajectory::Forces;

impl System {
    /// Forces for a given motion of the lever: θ (rad), θ̇ (rad/s), θ̈ (rad/s²). The user's force
    /// is the one that the motion needs, M_O L θ̈ minus the other forces on the lever; there is no
    /// finger and nothing lags.
    ///
    /// The motion determines everything: no force feeds back into it, so nothing can oscillate.
    pub fn prescribed(
        &self,
        theta_rad: f64,
        theta_dot_rad_s: f64,
        theta_ddot_rad_s2: f64,
    ) -> Forces {
        let (mut z, _) = self.start();
        z[THETA] = theta_rad;
        z[OMEGA] = theta_dot_rad_s;
        z[self.layout.force] = 0.0;
        let mut forces = self.forces(&self.direct_region(&z), &z);
        let on_lever = forces.motor_n + forces.brake_n + forces.friction_n + forces.terms_n;
        forces.external_n = self.inertia() * theta_ddot_rad_s2 - on_lever;
        forces.tip_n = forces.external_n;
        forces.tissue_n = forces.external_n;
        forces
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::actuators::DriveMode;
    use crate::scene::input::Input;
    use crate::scene::table3;

    #[test]
    fn a_slow_stroke_shows_the_bow_tie_of_brake_and_motor() {
        let system = System::new(table3::scene(DriveMode::Hybrid, Input::constant(0.0))).unwrap();
        let at = 32.0_f64.to_radians();
        let forward = system.prescribed(at, 1e-12, 0.0);
        let backward = system.prescribed(at, -1e-12, 0.0);
        let ideal = 4.0 * 77.0_f64.to_radians();
        assert!((forward.external_n - ideal).abs() < 1e-9, "{forward:?}");
        assert!((backward.external_n - table3::MOTOR_N).abs() < 1e-9);
        assert!((forward.brake_n + ideal).abs() < 1e-9 && forward.motor_n == 0.0);
    }

    #[test]
    fn the_force_for_an_acceleration_is_mass_times_lever_times_it() {
        let system = System::new(table3::scene(DriveMode::Active, Input::constant(0.0))).unwrap();
        let still = system.prescribed(-0.5, 0.0, 0.0).external_n;
        let moved = system.prescribed(-0.5, 0.0, 10.0).external_n;
        assert!((moved - still - 0.05).abs() < 1e-15);
    }
}
