//! The crate `ode_solvers`: Dopri5 with its continuous output. It has no events, so a run is
//! stopped by its `solout` once a guard is below 0, the event is located on the continuous output,
//! and a new run starts there.

use std::cell::Cell;

use ode_solvers::continuous_output_model::ContinuousOutputModel;
use ode_solvers::{Dopri5, OutputType, SVector, System};

use crate::dopri::{Aim, crossing};
use crate::scene::{END_S, Phase, START, STICKING, Samples, State};

struct Segment<'a> {
    phase: Phase,
    /// Start of the last step, s.
    from_s: &'a Cell<f64>,
}

impl<const N: usize> System<f64, SVector<f64, N>> for Segment<'_> {
    fn system(&self, t: f64, y: &SVector<f64, N>, slope: &mut SVector<f64, N>) {
        *slope = self.phase.slope(&STICKING, t, &y.data.0[0]).into();
    }

    fn solout(&mut self, t: f64, y: &SVector<f64, N>, _: &SVector<f64, N>) -> bool {
        let left = self.phase.guards(&STICKING, [y[0], y[1]]).iter().any(|guard| *guard < 0.0);
        if !left {
            self.from_s.set(t);
        }
        left
    }
}

/// Runs the scene; returns the number of evaluations.
pub(crate) fn run(aim: Aim, out: &mut Samples) -> Result<u64, String> {
    out.clear();
    let (mut t, mut y, mut phase) = START;
    let mut evaluations = 0;
    while t < END_S {
        if phase == Phase::Stick {
            let (until, next) = STICKING.release(t, y[0]);
            out.hold(y[0], until);
            (t, phase) = (until, next);
        } else {
            let smooth = if aim.sine_joins { smooth::<4> } else { smooth::<2> };
            evaluations += smooth(aim, &mut t, &mut y, &mut phase, out)?;
        }
    }
    Ok(evaluations)
}

/// One phase, to its end.
fn smooth<const N: usize>(
    aim: Aim,
    t: &mut f64,
    y: &mut State,
    phase: &mut Phase,
    out: &mut Samples,
) -> Result<u64, String> {
    let from_s = Cell::new(*t);
    let segment = Segment { phase: *phase, from_s: &from_s };
    let largest = if aim.largest_step_s.is_finite() { aim.largest_step_s } else { END_S };
    // The crate's own defaults but for the largest step; its stiffness test would only end the run.
    let mut stepper = Dopri5::from_param(
        segment,
        *t,
        END_S,
        0.0,
        SVector::from(STICKING.full::<N>(*t, *y)),
        aim.tolerance,
        aim.tolerance,
        0.9,
        0.04,
        0.2,
        10.0,
        largest,
        0.0,
        100_000,
        u32::MAX,
        OutputType::Continuous,
    );
    let mut model = ContinuousOutputModel::new();
    let stats = stepper
        .integrate_with_continuous_output_model(&mut model)
        .map_err(|error| error.to_string())?;
    let (_, end) = model.bounds();
    let at = |t: f64| -> State { model.evaluate(t).map_or([f64::NAN; 2], |y| [y[0], y[1]]) };
    let below =
        phase.guards(&STICKING, stepper.y_out().last().map_or([f64::NAN; 2], |y| [y[0], y[1]]));
    let time = |share: f64| (from_s.get() + share * (end - from_s.get())).min(end);
    let root = |i: usize| {
        if below[i] < 0.0 {
            time(crossing(|share| phase.guards(&STICKING, at(time(share)))[i]))
        } else {
            f64::INFINITY
        }
    };
    let roots = [root(0), root(1)];
    let first = usize::from(roots[1] < roots[0]);
    let until = roots[first].min(end);
    while out.next_s() <= until {
        out.push(at(out.next_s()));
    }
    (*t, *y) = (until, at(until));
    if roots[first].is_finite() {
        *phase = phase.next(&STICKING, first, *t, y);
    }
    Ok(u64::from(stats.num_eval))
}
