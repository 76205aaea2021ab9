//! The crate `diffsol`: its implicit methods and its explicit one, with its root finding and its
//! interpolation. The problem is built once for all runs; a solver is made for each phase.

use std::cell::Cell;
use std::rc::Rc;

use diffsol::error::DiffsolError;
use diffsol::{
    NalgebraContext, NalgebraLU, NalgebraMat, NalgebraVec, OdeBuilder, OdeEquations,
    OdeEquationsImplicit, OdeSolverMethod, OdeSolverProblem, OdeSolverStopReason,
};

use crate::dopri::Aim;
use crate::scene::{END_S, Phase, START, STICKING, Samples, State};

type Matrix = NalgebraMat<f64>;
type Solver = NalgebraLU<f64>;

/// Which of its methods.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Method {
    Bdf,
    TrBdf2,
    Esdirk34,
    Tsit45,
}

/// What the closures of a problem read.
struct Shared {
    phase: Cell<Phase>,
    start: Cell<State>,
    evaluations: Cell<u64>,
}

impl Shared {
    fn count(&self) {
        self.evaluations.set(self.evaluations.get() + 1);
    }
}

fn problem<const N: usize>(
    shared: &Rc<Shared>,
    tolerance: f64,
) -> Result<
    OdeSolverProblem<
        impl OdeEquationsImplicit<T = f64, V = NalgebraVec<f64>, M = Matrix, C = NalgebraContext>
        + use<N>,
    >,
    DiffsolError,
> {
    let [a, b, c, d] = std::array::from_fn(|_| Rc::clone(shared));
    OdeBuilder::<Matrix>::new()
        .rtol(tolerance)
        .atol([tolerance; N])
        .rhs_implicit(
            move |y, _, t, slope| {
                a.count();
                slope.copy_from_slice(&a.phase.get().slope::<N>(&STICKING, t, &array(y)));
            },
            move |_, _, _, v, product| {
                b.count();
                product.copy_from_slice(&b.phase.get().jacobian_times::<N>(&STICKING, &array(v)));
            },
        )
        .init(move |_, t, y| y.copy_from_slice(&STICKING.full::<N>(t, c.start.get())), N)
        .root(
            move |y, _, _, guards| {
                guards.copy_from_slice(&d.phase.get().guards(&STICKING, [y[0], y[1]]))
            },
            2,
        )
        .build()
}

fn array<const N: usize>(y: &[f64]) -> [f64; N] {
    std::array::from_fn(|i| y[i])
}

/// Runs of the scene with a method and a tolerance; each returns the number of evaluations of the
/// right-hand side and of its derivative.
pub(crate) fn prepare<const N: usize>(
    method: Method,
    aim: Aim,
) -> Result<impl FnMut(&mut Samples) -> Result<u64, String>, String> {
    let (_, start, phase) = START;
    let shared = Rc::new(Shared {
        phase: Cell::new(phase),
        start: Cell::new(start),
        evaluations: Cell::new(0),
    });
    let mut problem = problem::<N>(&shared, aim.tolerance).map_err(|error| error.to_string())?;
    Ok(move |out: &mut Samples| {
        run(method, &mut problem, &shared, out).map_err(|error| error.to_string())
    })
}

fn run<E>(
    method: Method,
    problem: &mut OdeSolverProblem<E>,
    shared: &Shared,
    out: &mut Samples,
) -> Result<u64, DiffsolError>
where
    E: OdeEquationsImplicit<T = f64, V = NalgebraVec<f64>, M = Matrix, C = NalgebraContext>,
{
    out.clear();
    shared.evaluations.set(0);
    let (mut t, mut y, mut phase) = START;
    while t < END_S {
        if phase == Phase::Stick {
            let (until, next) = STICKING.release(t, y[0]);
            out.hold(y[0], until);
            (t, phase) = (until, next);
            continue;
        }
        shared.phase.set(phase);
        shared.start.set(y);
        problem.t0 = t;
        let event = match method {
            Method::Bdf => smooth(problem.bdf::<Solver>()?, out)?,
            Method::TrBdf2 => smooth(problem.tr_bdf2::<Solver>()?, out)?,
            Method::Esdirk34 => smooth(problem.esdirk34::<Solver>()?, out)?,
            Method::Tsit45 => smooth(problem.tsit45()?, out)?,
        };
        let Some((at, state, guard)) = event else { break };
        (t, y) = (at, state);
        phase = phase.next(&STICKING, guard, t, &mut y);
    }
    Ok(shared.evaluations.get())
}

/// One phase: samples until a root, which is returned with its state and number, or until all are
/// there.
fn smooth<'a, E>(
    mut solver: impl OdeSolverMethod<'a, E>,
    out: &mut Samples,
) -> Result<Option<(f64, State, usize)>, DiffsolError>
where
    E: OdeEquations<T = f64, V = NalgebraVec<f64>, M = Matrix, C = NalgebraContext> + 'a,
{
    let mut y = solver.interpolate(solver.state().t)?;
    while out.next_s().is_finite() {
        let reason = solver.step()?;
        let root = if let OdeSolverStopReason::RootFound(t, guard) = reason {
            Some((t, guard))
        } else {
            None
        };
        let until = root.map_or(solver.state().t, |(t, _)| t);
        while out.next_s() <= until {
            solver.interpolate_inplace(out.next_s(), &mut y)?;
            out.push([y.batch_as_slice(0)[0], y.batch_as_slice(0)[1]]);
        }
        if let Some((t, guard)) = root {
            solver.interpolate_inplace(t, &mut y)?;
            return Ok(Some((t, [y.batch_as_slice(0)[0], y.batch_as_slice(0)[1]], guard)));
        }
    }
    Ok(None)
}
