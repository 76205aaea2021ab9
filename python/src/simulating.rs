//! Runs of a scene.

use crate::calling::{Fault, call};
use crate::scene::{Given, Varied, runs, varied};
use crate::table::Table;
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use zwidth_results::ModelRun;
use zwidth_simulate::{
    Run, SOLVERS, highest, model_run, simulate as judged_run, solver as solver_of, unjudged,
};
use zwidth_tables::{Column, Field, Table as Rows, Type, Values};

/// More numbers are not kept (1 GiB).
const MOST_NUMBERS: usize = 1 << 27;
/// Numbers of a sample that are kept, at most: time, state, forces, and a few terms.
const NUMBERS: usize = 16;

/// Runs of a scene, one for each value of the keys that were varied.
#[pyclass(module = "zwidth", frozen)]
pub(crate) struct Runs {
    table: Rows,
    trajectories: Vec<ModelRun>,
}

#[pymethods]
impl Runs {
    /// A row for each run: the keys that were varied, the largest angle and when, the state at the end, events, and if the
    /// runs were judged, the verdict.
    #[getter]
    fn table(&self) -> PyResult<Table> {
        Ok(Table::new(self.table.clone())?)
    }

    /// The samples of a run, counted from 0: time, state, forces by part. Only where `samples=True` asked for them.
    fn trajectory(&self, run: isize) -> PyResult<Table> {
        let count = isize::try_from(self.trajectories.len()).unwrap_or(isize::MAX);
        let place = usize::try_from(if run < 0 { run + count } else { run }).ok();
        let Some(found) = place.and_then(|place| self.trajectories.get(place)) else {
            let why = match self.trajectories.is_empty() {
                true => "no samples were kept; simulate with samples=True".to_owned(),
                false => format!("there are {count} runs"),
            };
            return Err(PyIndexError::new_err(why));
        };
        Ok(Table::new(Rows::of_run(found).map_err(Fault::said)?)?)
    }

    fn __len__(&self) -> usize {
        self.table.height()
    }

    fn __repr__(&self) -> String {
        format!("<zwidth.Runs: {} runs>", self.table.height())
    }

    fn _repr_html_(&self) -> PyResult<String> {
        Ok(Table::new(self.table.clone())?.html()?)
    }
}

/// One run in a few numbers, and its samples where they are kept.
struct Outcome {
    theta_max_rad: f64,
    theta_max_s: f64,
    theta_end_rad: f64,
    theta_dot_end_rad_s: f64,
    events: usize,
    samples: usize,
    verdict: Option<&'static str>,
    trajectory: Option<ModelRun>,
}

/// How each scene is run.
#[derive(Clone)]
struct How {
    solver: String,
    tolerance: f64,
    judged: bool,
    samples: bool,
}

/// Runs a scene, once or for each value of some of its keys.
///
/// `scene` is the path of a scene's file, or a dict as `tomllib.load` gives it. Keyword arguments name numbers of the scene,
/// sections apart by two underscores (`plant__mass_kg=0.06`, `environment__zones__0__from_rad=…`), in the units of its file:
/// a number for all runs, or arrays of float64 of one length with a value for each run. `step_s` is the time between samples.
///
/// `solver` is one of those of `zwidth simulate`, `tolerance` its relative error per step where it adapts its step. `judged`
/// says what each run is worth, which takes several times as long; `samples` keeps the samples.
///
/// Runs go side by side on all cores, without the GIL. Ctrl-C ends them. More than 2**27 numbers are refused.
#[pyfunction]
#[pyo3(signature = (scene, *, solver = "exact", tolerance = 1e-9, judged = false, samples = false, **parameters))]
pub(crate) fn simulate(
    py: Python<'_>,
    scene: &Bound<'_, PyAny>,
    solver: &str,
    tolerance: f64,
    judged: bool,
    samples: bool,
    parameters: Option<&Bound<'_, PyDict>>,
) -> PyResult<Runs> {
    let given = Given::new(scene)?;
    let varied = varied(parameters)?;
    if !SOLVERS.contains(&solver) {
        let what = format!("there is no solver {solver:?}");
        return Err(Fault::new(what, &format!("choose one of {}", SOLVERS.join(", "))).into());
    }
    if !(tolerance > 0.0 && tolerance < 1.0) {
        return Err(
            Fault::new(format!("a tolerance of {tolerance}"), "give one between 0 and 1").into()
        );
    }
    let how = How { solver: solver.to_owned(), tolerance, judged, samples };
    call(py, move |stop| {
        let count = runs(&varied);
        check_size(&given, &varied, count, &how)?;
        let one = |run: usize| match stop.is_wanted() {
            true => Err(Fault::said("interrupted")),
            false => {
                outcome(&given, &varied, run, &how).map_err(|fault| numbered(fault, run, count))
            }
        };
        let outcomes = (0..count).into_par_iter().map(one).collect::<Result<Vec<_>, _>>()?;
        let table = table(&given, &varied, &outcomes)?;
        let trajectories = outcomes.into_iter().filter_map(|outcome| outcome.trajectory);
        Ok(Runs { table, trajectories: trajectories.collect() })
    })
}

/// Refuses runs whose numbers fill the memory.
fn check_size(given: &Given, varied: &[Varied], count: usize, how: &How) -> Result<(), Fault> {
    let mut numbers = count.saturating_mul(NUMBERS);
    if how.samples {
        for run in 0..count {
            let scene = given.with(varied, run)?;
            let samples = (scene.duration_s / scene.step_s).min(MOST_NUMBERS as f64);
            numbers = numbers.saturating_add(NUMBERS.saturating_mul(samples.max(0.0) as usize));
        }
    }
    if numbers <= MOST_NUMBERS {
        return Ok(());
    }
    let what = format!("{count} runs would keep more than {MOST_NUMBERS} numbers");
    Err(Fault::new(what, "simulate without samples=True, with a longer step_s, or in parts"))
}

fn outcome(given: &Given, varied: &[Varied], run: usize, how: &How) -> Result<Outcome, Fault> {
    let scene = given.with(varied, run)?;
    let solver = solver_of(&how.solver, how.tolerance).map_err(|e| given.error(&e))?;
    let (system, trajectory, judgement) = if how.judged || how.samples {
        let Run { system, trajectory, judgement, .. } =
            judged_run(scene, solver.as_ref()).map_err(|e| given.error(&e))?;
        (system, trajectory, Some(judgement))
    } else {
        let (system, trajectory) = unjudged(scene, solver.as_ref()).map_err(|e| given.error(&e))?;
        (system, trajectory, None)
    };
    let (theta_max_rad, theta_max_s) = highest(&trajectory);
    let theta_end_rad = trajectory.theta_rad().last().unwrap_or_default();
    let theta_dot_end_rad_s = trajectory.theta_dot_rad_s().last().unwrap_or_default();
    let (events, samples) = (trajectory.events.len(), trajectory.len());
    let verdict = judgement.as_ref().map(|judgement| judgement.verdict.as_str());
    let kept = judgement
        .filter(|_| how.samples)
        .map(|judgement| model_run(&Run { system, solver: solver.name(), trajectory, judgement }));
    Ok(Outcome {
        theta_max_rad,
        theta_max_s,
        theta_end_rad,
        theta_dot_end_rad_s,
        events,
        samples,
        verdict,
        trajectory: kept,
    })
}

/// Of many runs the one that failed.
fn numbered(fault: Fault, run: usize, count: usize) -> Fault {
    if count > 1 { fault.in_row0(run) } else { fault }
}

/// A row for each run.
fn table(given: &Given, varied: &[Varied], outcomes: &[Outcome]) -> Result<Rows, Fault> {
    let count = outcomes.len();
    let mut columns: Vec<Column> = varied
        .iter()
        .map(|Varied { key, values }| {
            let values =
                (0..count).map(|run| Some(if values.len() == 1 { values[0] } else { values[run] }));
            let field = Field {
                name: key.clone().into(),
                unit: "".into(),
                description: format!("{key} of the scene").into(),
                kind: Type::Float,
            };
            Column { field, values: Values::Float(values.collect()) }
        })
        .collect();
    let float = |name, unit, about, of: fn(&Outcome) -> f64| {
        Column::float(name, unit, about, outcomes.iter().map(|outcome| Some(of(outcome))))
    };
    let whole = |name, about, of: fn(&Outcome) -> usize| {
        let count = |outcome| i64::try_from(of(outcome)).ok();
        Column::integer(name, "1", about, outcomes.iter().map(count))
    };
    columns.extend([
        float("theta_max_rad", "rad", "the largest angle, samples and events", |o| o.theta_max_rad),
        float("theta_max_s", "s", "when it was reached first", |o| o.theta_max_s),
        float("theta_end_rad", "rad", "the angle at the end", |o| o.theta_end_rad),
        float("theta_dot_end_rad_s", "rad/s", "the velocity at the end", |o| o.theta_dot_end_rad_s),
        whole("events", "events; none of solvers that do not look for them", |o| o.events),
        whole("samples", "samples", |o| o.samples),
    ]);
    let verdicts = outcomes.iter().map(|outcome| outcome.verdict.map(str::to_owned));
    columns.push(Column::text(
        "verdict",
        "what the run is worth; null where it was not judged",
        verdicts,
    ));
    let name = given.scene().map_or_else(|_| "runs".to_owned(), |scene| scene.name);
    let table = Rows::new("runs", &name, columns).map_err(Fault::said)?;
    Ok(table.with_note("Model runs, not measurements."))
}
