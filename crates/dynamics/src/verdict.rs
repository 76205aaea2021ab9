//! What a run is worth: smooth, chattering of the method, a cycle of the device, or a step that is
//! too long.
//!
//! Switching on the sign of θ̇ chatters where the exact motion sticks; the amplitude falls with the
//! step and the count grows. A cycle of the device keeps both. A step outside the method's
//! stability region is found from the regions that were visited, also where saturation or a stop
//! keeps the run bounded.

use std::cmp::Ordering;

use zwidth_numerics::expm::{Ladder, spectral_radius};

use crate::error::DynamicsError;
use crate::solve::{Grid, Solver};
use crate::system::linear::LinearPart;
use crate::system::region::Motion;
use crate::system::transition::EventKind;
use crate::system::{OMEGA, System, THETA};
use crate::trajectory::Trajectory;

/// How a run went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RunVerdict {
    /// Nothing swings fast.
    Smooth,
    /// Fast swings that vanish with the step: the method's own.
    NumericalChattering,
    /// Fast swings that stay as the step goes to zero: the model's own.
    LimitCycle,
    /// The step lies outside the method's stability region somewhere on the way.
    UnstableStep,
    /// The run ended in an error.
    Failed,
}

/// Fast swings of a run: reversals that follow the one before within a tenth of a second.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Swings {
    /// How many.
    pub count: usize,
    /// Median angle between two reversals, rad; 0 without any.
    pub amplitude_rad: f64,
}

/// A verdict and what it rests on.
#[derive(Debug, Clone, PartialEq)]
pub struct Judgement {
    /// The verdict.
    pub verdict: RunVerdict,
    /// Fast swings with the step, half of it, and a quarter.
    pub swings: [Swings; 3],
    /// Largest growth of a step over the visited regions, per step, over the exact flow's own
    /// growth; above 1 the step is unstable. 1 for methods without a limit.
    pub amplification: f64,
    /// What went wrong, if the run failed.
    pub error: Option<DynamicsError>,
}

/// A method may amplify this much more than the exact flow: rounding of the estimate.
const STABLE: f64 = 1.0 + 1e-6;

/// Runs a system with a step, half of it and a quarter, and judges.
pub fn judge(solver: &dyn Solver, system: &System, step_s: f64) -> Judgement {
    let runs = [step_s, step_s / 2.0, step_s / 4.0]
        .map(|h| solver.run(system, &Grid::filling(system.scene.duration_s, h)));
    match runs {
        [Ok(a), Ok(b), Ok(c)] => {
            let amplification = amplification(solver, system, &a, step_s);
            let swings = [fast_swings(&a), fast_swings(&b), fast_swings(&c)];
            let verdict =
                if amplification > STABLE { RunVerdict::UnstableStep } else { compare(&swings) };
            Judgement { verdict, swings, amplification, error: None }
        }
        runs => {
            let error = runs.into_iter().find_map(Result::err);
            Judgement {
                verdict: RunVerdict::Failed,
                swings: Default::default(),
                amplification: 1.0,
                error,
            }
        }
    }
}

/// By how the swings change from the first step to its quarter.
fn compare(swings: &[Swings; 3]) -> RunVerdict {
    /// Fewer fast swings are an impact or a transient.
    const FEW: usize = 6;
    /// Chattering falls with the step, to a quarter here; a cycle that keeps half of its amplitude
    /// is real.
    const KEPT: f64 = 0.5;
    let (coarse, fine) = (swings[0], swings[2]);
    if coarse.count < FEW && fine.count < FEW {
        return RunVerdict::Smooth;
    }
    let grows = fine.count > coarse.count + coarse.count / 2;
    let vanishes = fine.count < FEW || fine.amplitude_rad < KEPT * coarse.amplitude_rad;
    if grows || vanishes { RunVerdict::NumericalChattering } else { RunVerdict::LimitCycle }
}

/// The fast swings of a run.
pub fn fast_swings(run: &Trajectory) -> Swings {
    /// No hand reverses faster than this, s: 5 Hz.
    const FAST_S: f64 = 0.1;
    let turns = if run.events.is_empty() { sampled_turns(run) } else { event_turns(run) };
    let mut swings: Vec<f64> = turns
        .windows(2)
        .filter(|pair| pair[1].0 - pair[0].0 < FAST_S)
        .map(|pair| (pair[1].1 - pair[0].1).abs())
        .collect();
    swings.sort_by(f64::total_cmp);
    let amplitude_rad = swings.get(swings.len() / 2).copied().unwrap_or(0.0);
    Swings { count: swings.len(), amplitude_rad }
}

/// Time and angle at the events that end a motion.
fn event_turns(run: &Trajectory) -> Vec<(f64, f64)> {
    let turns = run.events.iter().filter(|event| event.kind == EventKind::Reversal);
    turns.map(|event| (event.t_s, event.theta_rad)).collect()
}

/// Time and angle of the samples at which a motion has ended: the velocity changed its sign or
/// became zero.
fn sampled_turns(run: &Trajectory) -> Vec<(f64, f64)> {
    let mut last = Some(Ordering::Equal);
    let mut turns = Vec::new();
    for (t, z) in run.t_s.iter().zip(run.states.chunks_exact(run.layout.n)) {
        let now = z[OMEGA].partial_cmp(&0.0);
        if last != Some(Ordering::Equal) && now != last {
            turns.push((*t, z[THETA]));
        }
        last = now;
    }
    turns
}

/// Largest growth per step in the regions of motion that a run visited, over the exact flow's.
fn amplification(solver: &dyn Solver, system: &System, run: &Trajectory, h: f64) -> f64 {
    let moving = run.regions.iter().filter(|region| region.motion != Motion::Rest);
    moving.filter_map(|region| growth(solver, &system.linear_part(region), h)).fold(1.0, f64::max)
}

/// ρ(method) / max(1, ρ(exact)) for one step of a linear system; `None` for methods without a
/// limit.
pub(crate) fn growth(solver: &dyn Solver, a: &LinearPart, h: f64) -> Option<f64> {
    let method = spectral_radius(&solver.amplification(a, h)?);
    let exact = spectral_radius(&Ladder::new(a.a, h).flow(h));
    Some(method / exact.max(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::actuators::DriveMode;
    use crate::scene::input::Input;
    use crate::scene::{ModelScene, table3};
    use crate::solve::Switching;
    use crate::solve::exact::Exact;
    use crate::solve::moreau_jean::MoreauJean;
    use crate::solve::rk4::Rk4;
    use crate::solve::symplectic_euler::SymplecticEuler;
    use crate::system::region::{Contact, Side};

    fn stage() -> Rk4 {
        Rk4 { switching: Switching::PerStage }
    }

    fn check(solver: &dyn Solver, scene: ModelScene, h: f64, expect: RunVerdict) {
        let judgement = judge(solver, &System::new(scene).unwrap(), h);
        assert_eq!(judgement.verdict, expect, "{} at {h}: {judgement:?}", solver.name());
    }

    fn sticking() -> ModelScene {
        table3::scene(DriveMode::Hybrid, Input::sine(2.15))
    }

    #[test]
    fn methods_that_switch_on_the_sign_chatter_where_the_lever_sticks_and_the_others_do_not() {
        for h in [8.3e-3, 0.83e-3, 0.2e-3] {
            check(&stage(), sticking(), h, RunVerdict::NumericalChattering);
            check(
                &Rk4 { switching: Switching::PerStep },
                sticking(),
                h,
                RunVerdict::NumericalChattering,
            );
            check(&SymplecticEuler, sticking(), h, RunVerdict::NumericalChattering);
            check(&MoreauJean::default(), sticking(), h, RunVerdict::Smooth);
            check(&Exact::default(), sticking(), h, RunVerdict::Smooth);
        }
    }

    #[test]
    fn a_brake_that_engages_late_makes_a_cycle_that_stays_as_the_step_goes_to_zero() {
        let mut scene = sticking();
        scene.brake.lag_on_off_s = Some([0.015, 0.010]);
        check(&Exact::default(), scene.clone(), 8.3e-3, RunVerdict::LimitCycle);
        check(&MoreauJean::default(), scene, 0.2e-3, RunVerdict::LimitCycle);
    }

    #[test]
    fn a_short_lever_makes_the_thesis_step_unstable_though_saturation_and_stops_bound_the_run() {
        for (lever_m, expect) in
            [(0.045, RunVerdict::UnstableStep), (0.58, RunVerdict::UnstableStep)]
        {
            let mut scene = sticking();
            scene.plant.lever_m = lever_m;
            check(&stage(), scene, 8.3e-3, expect);
        }
    }

    #[test]
    fn an_extreme_scene_that_ends_in_an_error_has_failed() {
        let mut scene = sticking();
        scene.environment = crate::scene::environment::Environment::spring(1e9, 0.0, 0.0);
        let few = Exact { most_events: 10, ..Exact::default() };
        check(&few, scene, 8.3e-3, RunVerdict::Failed);
    }

    /// Bisects for the value at which `stable` turns from false to true between two values.
    fn limit(mut unstable: f64, mut stable: f64, is_stable: impl Fn(f64) -> bool) -> f64 {
        for _ in 0..40 {
            let middle = 0.5 * (unstable + stable);
            if is_stable(middle) { stable = middle } else { unstable = middle }
        }
        0.5 * (unstable + stable)
    }

    /// The unsaturated system of a scene.
    fn unsaturated(mut scene: ModelScene) -> System {
        scene.mode = DriveMode::Active;
        scene.motor.max_n = 1e30;
        scene.plant.stops_rad = None;
        scene.input = Input::constant(1.0);
        System::new(scene).unwrap()
    }

    fn forward(system: &System) -> LinearPart {
        let (z, _) = system.start();
        system.linear_part(&system.moving_region(Side::Up, Contact::Free, &z))
    }

    fn analytic_stable(system: &System, h: f64) -> bool {
        let part = forward(system);
        growth(&stage(), &part, h).unwrap() <= 1.0 + 1e-12
    }

    /// Whether a run of 4,000 steps dies out or blows up.
    fn measured_stable(system: &System, h: f64) -> bool {
        let run = stage().run(system, &Grid::Even { step_s: h, steps: 4_000 });
        run.is_ok_and(|run| run.theta_dot_rad_s().last().unwrap().abs() < 1.0)
    }

    #[test]
    fn rk4_at_8_3_ms_is_stable_from_a_lever_of_0_5889_m_on() {
        let lever = |lever_m: f64| {
            let mut scene = sticking();
            scene.plant.lever_m = lever_m;
            unsaturated(scene)
        };
        let analytic = limit(0.3, 1.0, |l| analytic_stable(&lever(l), 8.3e-3));
        let measured = limit(0.3, 1.0, |l| measured_stable(&lever(l), 8.3e-3));
        assert!((analytic - 0.5889).abs() < 5e-5, "{analytic}");
        assert!((measured / analytic - 1.0).abs() < 5e-3, "{measured} instead of {analytic}");
    }

    #[test]
    fn rk4_runs_the_linear_two_mass_model_up_to_7_312_ms() {
        let system = unsaturated(table3::linear(DriveMode::Active, Input::constant(1.0), 13.0));
        let analytic = limit(9e-3, 5e-3, |h| analytic_stable(&system, h));
        let measured = limit(9e-3, 5e-3, |h| measured_stable(&system, h));
        assert!((analytic - 7.312e-3).abs() < 5e-7, "{analytic}");
        assert!((measured / analytic - 1.0).abs() < 5e-3, "{measured} instead of {analytic}");
        let part = forward(&system);
        assert!((growth(&stage(), &part, 8.3e-3).unwrap() - 1.721).abs() < 5e-4);
    }
}
