//! The prototype's control sequence: scene → demanded force → inverse characteristic → voltages
//! (thesis Fig. 32, §4.2, §6.2.1).
//!
//! Signs: a demanded force above 0 resists, that is, it pushes towards −θ. The motor's force is odd
//! in its voltage, and a voltage above 0 pushes towards +θ, so resisting takes a negative voltage.
//! The brake has only a level.

use zwidth_study::{
    ActuatorKind, Calibration, Control, Environment, Flags, Mode, ModeLaw, Scene, Voltages,
};

/// The lever counts as moving forward from this velocity on, rad/s (5.7°/s): five times what one
/// flickering count of the prototype's sensor shows through the default velocity filter.
pub const FORWARD_RAD_S: f64 = 0.1;

/// A lever that moved forward counts as holding or going back from this velocity down, rad/s. Not
/// 0: the filter of a lever that stands still decays towards 0 and does not reach it, and the brake
/// would never let go.
pub const HOLDING_RAD_S: f64 = 0.05;

/// What a scene demands at an angle and a velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Demand {
    /// Resisting force u, N ([`zwidth_study::ForceLaw`]; the prototype commands none by velocity,
    /// thesis §4.3).
    force_n: f64,
    /// Behind the wall: the actuators get all the voltage they may have.
    wall: bool,
}

fn demand(scene: &Scene, theta_rad: f64, theta_dot_rad_s: f64) -> Demand {
    let law = scene.law();
    Demand {
        force_n: law.map_or(0.0, |law| law.force_n(theta_rad, theta_dot_rad_s)),
        wall: law.is_some_and(|law| law.is_past_wall(theta_rad)),
    }
}

/// The control law of one trial.
///
/// | mode | compressing (θ̇ > 0) | holding, releasing (θ̇ ≤ 0) |
/// |---|---|---|
/// | motor alone (active) | motor | motor |
/// | brake alone (passive) | brake | brake |
/// | both (hybrid) | brake | motor, once the user's force is below the let-go threshold; until then the brake |
///
/// Motor: −clamp(u, −F_m, F_m); brake: clamp(u, 0, F_b). From θ_wall on each gives all its mode
/// allows.
///
/// θ̇ > 0 is tested with hysteresis, because a counted angle makes a slow velocity flicker: forward
/// above [`FORWARD_RAD_S`], until it is down to [`HOLDING_RAD_S`].
#[derive(Debug, Clone, PartialEq)]
pub struct Controller {
    scene: Scene,
    calibration: Calibration,
    motor_max_v: f64,
    brake_max_v: f64,
    let_go_n: f64,
    law: Option<ModeLaw>,
    /// θ̇ > 0, with hysteresis.
    forward: bool,
    /// Whether what is in charge is the one that is while compressing.
    compressing: bool,
}

impl Controller {
    /// For an environment, a mode and the calibration in force.
    pub fn new(
        control: &Control,
        environment: &Environment,
        mode: &Mode,
        calibration: &Calibration,
    ) -> Self {
        Self {
            scene: environment.scene,
            calibration: calibration.clone(),
            motor_max_v: mode.motor_max_v.unwrap_or(0.0),
            brake_max_v: mode.brake_max_v.unwrap_or(0.0),
            let_go_n: control.let_go_n,
            law: mode.law(),
            forward: false,
            compressing: false,
        }
    }

    /// The voltages for an angle, rad, a velocity, rad/s, and the user's force, N; with the flags
    /// [`Flags::SATURATED`] and [`Flags::PAST_WALL`] where they hold.
    pub fn step(
        &mut self,
        theta_rad: f64,
        theta_dot_rad_s: f64,
        force_n: f64,
    ) -> (Voltages, Flags) {
        let demand = demand(&self.scene, theta_rad, theta_dot_rad_s);
        self.forward = theta_dot_rad_s > if self.forward { HOLDING_RAD_S } else { FORWARD_RAD_S };
        let brakes = self.law.is_some_and(|law| law.drives()[0] == ActuatorKind::Brake);
        let holds = brakes && self.compressing && force_n >= self.let_go_n;
        self.compressing = self.forward || holds;
        let flags = Flags::default().with(Flags::PAST_WALL, demand.wall);
        let Some(drive) = self.drive() else { return (Voltages::OFF, flags) };
        let (voltages, saturated) = match drive {
            ActuatorKind::Motor => self.motor(demand),
            ActuatorKind::Brake => self.brake(demand),
        };
        (voltages, flags.with(Flags::SATURATED, saturated))
    }

    /// The resisting force voltages stand for, by the calibration, N; above 0 pushes towards −θ.
    pub(crate) fn force_n(&self, voltages: Voltages) -> f64 {
        self.calibration.brake.force_n(voltages.brake_v)
            - self.calibration.motor.force_n(voltages.motor_v)
    }

    /// Which actuator is in charge; none in a mode that has none.
    fn drive(&self) -> Option<ActuatorKind> {
        let [compressing, releasing] = self.law?.drives();
        Some(if self.compressing { compressing } else { releasing })
    }

    /// The motor's voltage, and whether more was demanded than it can give.
    fn motor(&self, demand: Demand) -> (Voltages, bool) {
        let most_n = self.calibration.motor.force_n(self.motor_max_v);
        let resisting_v = if demand.wall {
            self.motor_max_v
        } else {
            self.calibration
                .motor
                .voltage_v(demand.force_n)
                .clamp(-self.motor_max_v, self.motor_max_v)
        };
        // Never −0.0, which a recording would keep as another number than 0.
        let motor_v = if resisting_v == 0.0 { 0.0 } else { -resisting_v };
        (Voltages { motor_v, brake_v: 0.0 }, demand.wall || demand.force_n.abs() > most_n)
    }

    /// The brake's voltage, and whether more was demanded than it can give.
    fn brake(&self, demand: Demand) -> (Voltages, bool) {
        let most_n = self.calibration.brake.force_n(self.brake_max_v);
        let brake_v = if demand.wall {
            self.brake_max_v
        } else {
            self.calibration.brake.voltage_v(demand.force_n.max(0.0)).min(self.brake_max_v)
        };
        (Voltages { motor_v: 0.0, brake_v }, demand.wall || demand.force_n > most_n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::tests::{environment, mode_of};
    use proptest::prelude::*;
    use std::f64::consts::FRAC_PI_4;
    use zwidth_study::Spring;

    const WALL_RAD: f64 = 0.464_257; // 26.6 degrees

    fn spring() -> Scene {
        Scene::Spring(Spring { stiffness_n_per_rad: 4.0, rest_rad: -FRAC_PI_4 })
    }

    fn walled() -> Scene {
        let Some(spring) = spring().spring() else { unreachable!() };
        Scene::SpringWall { spring, wall_rad: WALL_RAD }
    }

    fn controller(scene: Scene, motor_max_v: Option<f64>, brake_max_v: Option<f64>) -> Controller {
        let environment = environment(scene);
        crate::trial::tests::controller(&environment, &mode_of(motor_max_v, brake_max_v))
    }

    fn active(scene: Scene) -> Controller {
        controller(scene, Some(16.0), None)
    }
    fn passive(scene: Scene) -> Controller {
        controller(scene, None, Some(8.0))
    }
    fn hybrid(scene: Scene) -> Controller {
        controller(scene, Some(8.0), Some(8.0))
    }

    /// The resisting force at such an angle past rest, a velocity and a user's force.
    fn force_n(controller: &mut Controller, past_rest_rad: f64, velocity: f64, user_n: f64) -> f64 {
        let (voltages, _) = controller.step(past_rest_rad - FRAC_PI_4, velocity, user_n);
        controller.force_n(voltages)
    }

    fn close(found: f64, expect: f64) {
        assert!((found - expect).abs() < 1e-12, "{found} instead of {expect}");
    }

    #[test]
    fn the_motor_gives_the_springs_force_in_both_directions_up_to_4_16_n() {
        let mut active = active(spring());
        for velocity in [1.0, 0.0, -1.0] {
            close(force_n(&mut active, 0.0, velocity, 1.0), 0.0);
            close(force_n(&mut active, 0.5, velocity, 1.0), 2.0);
            close(force_n(&mut active, 1.04, velocity, 1.0), 4.16);
            close(force_n(&mut active, 1.3, velocity, 1.0), 4.16);
            close(force_n(&mut active, -0.1, velocity, 1.0), -0.4);
        }
        let (voltages, flags) = active.step(0.5 - FRAC_PI_4, 1.0, 1.0);
        assert!(voltages.motor_v < 0.0 && voltages.brake_v == 0.0 && !flags.has(Flags::SATURATED));
        assert!(active.step(1.1 - FRAC_PI_4, 1.0, 1.0).1.has(Flags::SATURATED));
    }

    #[test]
    fn the_brake_keeps_its_level_going_back_and_never_pushes() {
        let mut passive = passive(spring());
        for velocity in [1.0, 0.0, -1.0] {
            close(force_n(&mut passive, 1.3, velocity, 0.0), 5.2);
            close(force_n(&mut passive, -0.1, velocity, 0.0), 0.0);
        }
    }

    #[test]
    fn hybrid_brakes_forward_and_drives_back() {
        let mut hybrid = hybrid(spring());
        close(force_n(&mut hybrid, 1.0, 1.0, 4.0), 4.0);
        close(force_n(&mut hybrid, 1.0, -1.0, 1.0), 2.08);
        close(force_n(&mut hybrid, 0.25, -1.0, 1.0), 1.0);
    }

    #[test]
    fn hybrids_brake_lets_go_only_at_rest_and_below_the_threshold() {
        let mut hybrid = hybrid(spring());
        let mut brakes = |velocity, user_n| hybrid.step(0.0, velocity, user_n).0.brake_v > 0.0;
        assert!(!brakes(0.0, 5.0)); // never forward yet
        assert!(brakes(1.0, 5.0));
        assert!(brakes(1.0, 0.5)); // forward without force
        assert!(brakes(0.0, 2.0)); // at rest, and not below the threshold
        assert!(!brakes(0.0, 1.999));
        assert!(!brakes(0.0, 5.0)); // once let go, only motion engages it
        assert!(brakes(1.0, 5.0));
    }

    #[test]
    fn a_velocity_that_flickers_by_a_count_does_not_switch() {
        let mut hybrid = hybrid(spring());
        for velocity in [0.021, 0.0, 0.021, -0.021, 0.09] {
            assert!(hybrid.step(0.0, velocity, 1.0).0.brake_v == 0.0);
        }
        hybrid.step(0.0, 0.2, 1.0);
        for velocity in [0.09, 0.06, 0.09] {
            assert!(hybrid.step(0.0, velocity, 1.0).0.brake_v > 0.0);
        }
        assert!(hybrid.step(0.0, 1e-300, 1.0).0.brake_v == 0.0);
    }

    #[test]
    fn from_the_wall_on_each_actuator_gives_all_its_mode_allows() {
        let at = |mut c: Controller, velocity| c.step(WALL_RAD, velocity, 5.0);
        let (voltages, flags) = at(active(walled()), 1.0);
        assert_eq!((voltages.motor_v, voltages.brake_v), (-16.0, 0.0));
        assert!(flags.has(Flags::PAST_WALL) && flags.has(Flags::SATURATED));
        assert_eq!(at(passive(walled()), -1.0).0, Voltages { motor_v: 0.0, brake_v: 8.0 });
        assert_eq!(at(hybrid(walled()), 1.0).0, Voltages { motor_v: 0.0, brake_v: 8.0 });
        assert_eq!(at(hybrid(walled()), -1.0).0, Voltages { motor_v: -8.0, brake_v: 0.0 });
        let Some(spring) = walled().spring() else { unreachable!() };
        let near = Scene::SpringWall { spring, wall_rad: -FRAC_PI_4 };
        let (voltages, flags) = active(near).step(-FRAC_PI_4, 0.0, 5.0); // the spring itself demands nothing there
        assert_eq!(voltages, Voltages { motor_v: -16.0, brake_v: 0.0 });
        assert!(flags.has(Flags::SATURATED));
        assert!(!active(walled()).step(WALL_RAD - 1e-9, 1.0, 5.0).1.has(Flags::PAST_WALL));
    }

    #[test]
    fn no_actuator_or_no_scene_is_no_voltage() {
        assert_eq!(controller(walled(), None, None).step(0.5, 1.0, 5.0).0, Voltages::OFF);
        for scene in [Scene::Free, Scene::None] {
            assert_eq!(hybrid(scene).step(0.5, 1.0, 5.0).0, Voltages::OFF);
        }
    }

    proptest! {
        #[test]
        fn whatever_is_read_each_mode_stays_within_its_voltages_and_uses_one_actuator_at_a_time(
            inputs in prop::collection::vec((-1e3..1e3_f64, -1e3..1e3_f64, -1e3..1e3_f64), 1..50),
        ) {
            for mut controller in [active(walled()), passive(walled()), hybrid(walled())] {
                for (theta_rad, theta_dot_rad_s, force_n) in &inputs {
                    let (voltages, _) = controller.step(*theta_rad, *theta_dot_rad_s, *force_n);
                    prop_assert!(voltages.motor_v.abs() <= controller.motor_max_v);
                    prop_assert!((0.0..=controller.brake_max_v).contains(&voltages.brake_v));
                    prop_assert!(voltages.motor_v == 0.0 || voltages.brake_v == 0.0);
                    prop_assert!(voltages.motor_v <= 0.0 || *theta_rad < -FRAC_PI_4); // it pushes towards rest
                }
            }
        }
    }

    #[test]
    fn an_angle_that_is_not_a_number_commands_nothing() {
        for mut controller in [active(walled()), passive(walled()), hybrid(walled())] {
            assert_eq!(controller.step(f64::NAN, 1.0, 1.0).0, Voltages::OFF);
        }
    }
}
