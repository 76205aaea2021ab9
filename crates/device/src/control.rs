//! The prototype's control sequence: scene → demanded force → inverse characteristic → voltages
//! (thesis Fig. 32, §4.2, §6.2.1).
//!
//! Signs: a demanded force above 0 resists, that is, it pushes towards −θ. The motor's force is odd
//! in its voltage, and a voltage above 0 pushes towards +θ, so resisting takes a negative voltage.
//! The brake has only a level.

use std::collections::VecDeque;
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
    environment: Environment,
    late: DelayLine,
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

/// What was demanded and is still to be rendered: an environment with a delay is that of some ticks ago. What is not
/// delayed is which actuator is in charge: that is the device's, and follows the lever as it is.
#[derive(Debug, Clone, PartialEq)]
struct DelayLine {
    ticks: usize,
    waiting: VecDeque<Demand>,
}

impl DelayLine {
    /// No tick allocates up to this many ticks of delay: a second at the fastest rate that a study may ask for.
    const RESERVED: usize = 1 << 17;

    fn new(ticks: usize) -> Self {
        Self { ticks, waiting: VecDeque::new() }
    }

    /// What was demanded so many ticks ago, for what is demanded now; nothing until then, as before the trial.
    fn pass(&mut self, now: Demand) -> Demand {
        if self.ticks == 0 {
            return now;
        }
        self.waiting.push_back(now);
        match self.waiting.len() > self.ticks {
            true => self.waiting.pop_front().unwrap_or(now),
            false => Demand { force_n: 0.0, wall: false },
        }
    }
}

impl Controller {
    /// For an environment, a mode and the calibration in force. A delay is rendered in ticks of the control loop of the
    /// study; [`Controller::begin`] tells it another rate.
    pub fn new(
        control: &Control,
        environment: &Environment,
        mode: &Mode,
        calibration: &Calibration,
    ) -> Self {
        Self {
            environment: environment.clone(),
            late: DelayLine::new(environment.delay_ticks(control.rate_hz)),
            calibration: calibration.clone(),
            motor_max_v: mode.motor_max_v.unwrap_or(0.0),
            brake_max_v: mode.brake_max_v.unwrap_or(0.0),
            let_go_n: control.let_go_n,
            law: mode.law(),
            forward: false,
            compressing: false,
        }
    }

    /// Before the first tick of a trial, in a loop of that rate, Hz: what is late is so by whole ticks of it, and nothing
    /// of an earlier trial is left. No tick allocates afterwards.
    pub fn begin(&mut self, rate_hz: f64) {
        let ticks = self.environment.delay_ticks(rate_hz);
        self.late = DelayLine::new(ticks);
        if ticks > 0 {
            self.late.waiting.reserve(ticks.saturating_add(1).min(DelayLine::RESERVED));
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
        let now = demand(&self.environment.scene, theta_rad, theta_dot_rad_s);
        let demand = self.late.pass(now);
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

    fn late(scene: Scene, delay_s: f64) -> Controller {
        let environment = Environment { delay_s, ..environment(scene) };
        let mut late = crate::trial::tests::controller(&environment, &mode_of(Some(16.0), None));
        late.begin(1000.0);
        late
    }

    #[test]
    fn a_delayed_springs_force_is_the_springs_at_that_much_earlier() {
        let theta = |tick: i32| -0.4 + 0.3 * libm::sin(0.02 * f64::from(tick));
        let (mut at_once, mut delayed) = (active(spring()), late(spring(), 0.02));
        let mut forces = Vec::new();
        for tick in 0..200 {
            let (voltages, _) = at_once.step(theta(tick), 0.0, 1.0);
            forces.push(at_once.force_n(voltages));
            let (voltages, _) = delayed.step(theta(tick), 0.0, 1.0);
            let expect = if tick < 20 { 0.0 } else { forces[tick as usize - 20] };
            close(delayed.force_n(voltages), expect);
        }
        assert!(forces.iter().all(|force_n| *force_n > 0.1), "or nothing was late");
        // A trial begins with nothing of the one before.
        delayed.begin(500.0);
        let mut rendered = (0..12).map(|_| delayed.step(0.0, 0.0, 1.0).0.motor_v != 0.0);
        assert_eq!(rendered.position(|is_rendered| is_rendered), Some(10), "at half the rate");
    }

    #[test]
    fn a_wall_that_is_late_begins_and_ends_late() {
        let mut walled = late(walled(), 0.003);
        let mut past = |theta_rad| walled.step(theta_rad, 0.0, 1.0).1.has(Flags::PAST_WALL);
        assert_eq!([0.5; 4].map(&mut past), [false, false, false, true]);
        assert_eq!([0.0; 4].map(&mut past), [true, true, true, false]);
    }

    #[test]
    fn a_constant_force_is_rendered_at_every_angle_as_far_as_the_actuator_can() {
        let force = |force_n| Scene::Force { force_n };
        let mut resisting = active(force(1.5));
        for past_rest_rad in [-0.2, 0.0, 1.3] {
            close(force_n(&mut resisting, past_rest_rad, 0.0, 1.0), 1.5);
            close(force_n(&mut active(force(-1.5)), past_rest_rad, 0.0, 1.0), -1.5);
            close(force_n(&mut passive(force(1.5)), past_rest_rad, 0.0, 1.0), 1.5);
            close(force_n(&mut passive(force(-1.5)), past_rest_rad, 0.0, 1.0), 0.0);
        }
        assert!(active(force(5.0)).step(0.0, 0.0, 1.0).1.has(Flags::SATURATED));
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
