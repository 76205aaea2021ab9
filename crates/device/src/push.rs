//! A lever let go of in a virtual wall, with all of safety in place: one push of a Z-width test at a rig.
//!
//! The lever rests wherever it is. The wall appears so that the lever stands a push deep in it, which is as if it were let
//! go of there: no hand is needed, and none changes what happens.

use crate::ramp::WATCHED_S;
use crate::timing::Pace;
use crate::trial::Output;
use crate::{Station, Trip};
use std::sync::atomic::{AtomicBool, Ordering};
use zwidth_study::{Calibration, Voltages};

/// A lever this many pushes away from the wall's surface swings ever further: the push ends.
const GROWN: f64 = 2.0;

/// A push against a bilateral wall, whose force is K x + B ẋ with ẋ the backward difference of x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Push {
    /// K, N/m.
    pub stiffness_n_per_m: f64,
    /// B, N s/m.
    pub damping_ns_per_m: f64,
    /// How deep in the wall the lever is at first, m; below 0 on its other side.
    pub push_m: f64,
    /// Length of the lever, m.
    pub lever_m: f64,
    /// What motor and brake may have, V; 0 of one that is not used. With both the brake acts while the lever goes deeper, and
    /// the motor drives it back.
    pub most: Voltages,
    /// How long it is followed, s.
    pub lasts_s: f64,
}

/// How a push ended; always at 0 V.
#[derive(Debug, Clone, PartialEq)]
pub enum PushEnd {
    /// It was followed for as long as was asked for.
    Followed,
    /// The lever swung further than twice the push.
    Grew,
    /// Somebody stopped it.
    Stopped,
    /// Nobody watched it any more.
    Unwatched,
    /// The guard gave less than was asked for.
    HeldBack,
    /// Safety took the voltages away.
    Tripped(Trip),
}

/// A push that was made.
#[derive(Debug, Clone, PartialEq)]
pub struct PushRun {
    /// How it ended.
    pub end: PushEnd,
    /// Since its beginning, s, and where the lever was from the wall's surface, m, in each tick.
    pub course: Vec<[f64; 2]>,
    /// Whether an actuator was to give more than it has.
    pub saturates: bool,
    /// ∫U² dt of the motor, V² s.
    pub motor_v2_s: f64,
}

impl Station<'_> {
    /// Makes a push from where the lever is. `watched` is asked in every tick whether somebody has said since the last time
    /// that they watch; without that for a second it goes to 0 V.
    pub fn push(
        &mut self,
        push: &Push,
        calibration: &Calibration,
        watched: &mut dyn FnMut() -> bool,
        stop: &AtomicBool,
    ) -> PushRun {
        let mut run = PushRun {
            end: PushEnd::Followed,
            course: Vec::with_capacity((push.lasts_s * self.rate_hz) as usize + 1),
            saturates: false,
            motor_v2_s: 0.0,
        };
        let ended = self.run_push(push, calibration, watched, stop, &mut run);
        run.end = ended.unwrap_or_else(|trip| PushEnd::Tripped(self.cause(trip)));
        run
    }

    fn run_push(
        &mut self,
        push: &Push,
        calibration: &Calibration,
        watched: &mut dyn FnMut() -> bool,
        stop: &AtomicBool,
        run: &mut PushRun,
    ) -> Result<PushEnd, Trip> {
        self.guard.arm_for_check(push.most, calibration)?;
        let start_s = self.clock.now_s();
        let mut pace = Pace::new(start_s, 1.0 / self.rate_hz);
        let mut output = Output::new(&mut *self.device, &mut self.guard, start_s);
        let mut watched_s = start_s;
        let mut surface_rad = None;
        let mut motor_v = 0.0;
        loop {
            let tick = pace.wait(&mut *self.clock);
            if stop.load(Ordering::Relaxed) {
                return Ok(PushEnd::Stopped);
            }
            if watched() {
                watched_s = tick.now_s;
            }
            if tick.now_s - watched_s > WATCHED_S {
                return Ok(PushEnd::Unwatched);
            }
            let (_, seen) = output.look(&tick)?;
            let surface_rad =
                *surface_rad.get_or_insert(seen.theta_rad - push.push_m / push.lever_m);
            let x_m = push.lever_m * (seen.theta_rad - surface_rad);
            let t_s = tick.now_s - start_s;
            let [before_s, before_m] = run.course.last().copied().unwrap_or([t_s, x_m]);
            run.motor_v2_s += motor_v * motor_v * (t_s - before_s);
            run.course.push([t_s, x_m]);
            if x_m.abs() > GROWN * push.push_m.abs() {
                return Ok(PushEnd::Grew);
            }
            if t_s >= push.lasts_s {
                return Ok(PushEnd::Followed);
            }
            let rate_m_s = if t_s > before_s { (x_m - before_m) / (t_s - before_s) } else { 0.0 };
            let (voltages, saturates) = push.voltages(x_m, rate_m_s, calibration);
            run.saturates |= saturates;
            motor_v = voltages.motor_v;
            let (_, is_less) = output.command(self.clock.now_s(), voltages)?;
            if is_less {
                return Ok(PushEnd::HeldBack);
            }
        }
    }
}

impl Push {
    /// The voltages so deep in the wall, m, at that rate, m/s, and whether more was demanded than there is.
    fn voltages(&self, x_m: f64, rate_m_s: f64, calibration: &Calibration) -> (Voltages, bool) {
        let demand_n = self.stiffness_n_per_m * x_m + self.damping_ns_per_m * rate_m_s;
        let Voltages { motor_v, brake_v } = self.most;
        if brake_v > 0.0 && demand_n * rate_m_s > 0.0 {
            let most_n = calibration.brake.force_n(brake_v);
            let brake_v = calibration.brake.voltage_v(demand_n.abs()).min(brake_v);
            return (Voltages { motor_v: 0.0, brake_v }, demand_n.abs() > most_n);
        }
        let most_n = calibration.motor.force_n(motor_v);
        // A voltage above 0 pushes towards +θ.
        let pushes_v = -calibration.motor.voltage_v(demand_n).clamp(-motor_v, motor_v);
        (Voltages { motor_v: pushes_v, brake_v: 0.0 }, demand_n.abs() > most_n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ramp::tests::at_bench;
    use crate::{Faults, Hands};

    const PUSH: Push = Push {
        stiffness_n_per_m: 100.0,
        damping_ns_per_m: 0.0,
        push_m: 5e-3,
        lever_m: 0.045,
        most: Voltages { motor_v: 16.0, brake_v: 0.0 },
        lasts_s: 1.0,
    };

    /// A push at a lever that was carried to the middle and let go of, watched for so many ticks; and what is out after it.
    fn run(push: Push, watched_for: u32) -> (PushRun, Voltages) {
        let hands = [(Hands::Clamp(0.0), 3.0), (Hands::Away, 0.5)];
        at_bench(Faults::default(), &hands, watched_for, |station, watched, stop| {
            station.push(&push, &Calibration::thesis(), watched, stop)
        })
    }

    #[test]
    fn a_soft_wall_brings_the_lever_towards_its_surface_from_either_side_and_ends_at_0_v() {
        for push_m in [5e-3, -5e-3] {
            let (run, voltages) = run(Push { push_m, ..PUSH }, u32::MAX);
            assert_eq!((&run.end, voltages), (&PushEnd::Followed, Voltages::OFF));
            let [_, first] = run.course[0];
            let [last_s, last] = *run.course.last().unwrap();
            assert!((first - push_m).abs() < 1e-12 && last_s >= 1.0, "{first} {last_s}");
            assert!(last.abs() < 0.6 * push_m.abs(), "{last}");
            assert!(!run.saturates && run.motor_v2_s > 0.0, "{run:?}");
        }
    }

    #[test]
    fn a_wall_that_is_far_too_stiff_swings_further_or_goes_on_and_ends_at_0_v() {
        let (run, voltages) = run(Push { stiffness_n_per_m: 20_000.0, ..PUSH }, u32::MAX);
        assert_eq!(voltages, Voltages::OFF);
        assert!(run.saturates, "100 N are more than the motor has");
        let tail = &run.course[run.course.len() * 5 / 6..];
        let swing = tail.iter().map(|[_, x]| x.abs()).fold(0.0, f64::max);
        assert!(run.end == PushEnd::Grew || swing > 0.1 * PUSH.push_m, "{:?} {swing}", run.end);
    }

    #[test]
    fn a_push_that_nobody_watches_ends_within_a_second() {
        let (run, voltages) = run(Push { lasts_s: 5.0, ..PUSH }, 100);
        assert_eq!((&run.end, voltages), (&PushEnd::Unwatched, Voltages::OFF));
        let [last_s, _] = *run.course.last().unwrap();
        assert!((1.0..1.2).contains(&last_s), "{last_s}");
    }
}
