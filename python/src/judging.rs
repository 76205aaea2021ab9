//! A trajectory of any program beside the right answer of its scene.

use crate::calling::{Fault, call};
use crate::given::{beside, times, velocities};
use crate::scene::{Given, varied};
use crate::table::Table;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use zwidth_judge::{Allowed, Candidate, Judged, Yardstick, judge as judge_one};
use zwidth_study::Perception;
use zwidth_tables::Table as Rows;

/// What a trajectory is worth.
#[pyclass(module = "zwidth", frozen)]
pub(crate) struct Judgement {
    judged: Judged,
}

#[pymethods]
impl Judgement {
    /// "right", "stands", or the gravest fault: "late", "creeps", "energy made", …
    #[getter]
    fn verdict(&self) -> &'static str {
        self.judged.trajectory.verdict.as_str()
    }

    /// One row: errors, energy, creep, how far the right answer is proven.
    #[getter]
    fn table(&self) -> PyResult<Table> {
        let rows = std::slice::from_ref(&self.judged.trajectory);
        Ok(Table::new(Rows::of_rows(rows).map_err(Fault::said)?)?)
    }

    /// A row for each fault, the gravest first.
    #[getter]
    fn faults(&self) -> PyResult<Table> {
        Ok(Table::new(Rows::of_rows(&self.judged.faults).map_err(Fault::said)?)?)
    }

    fn __repr__(&self) -> String {
        format!("<zwidth.Judgement {:?}: {} faults>", self.verdict(), self.judged.faults.len())
    }

    fn _repr_html_(&self) -> PyResult<String> {
        let rows = std::slice::from_ref(&self.judged.trajectory);
        let table = Rows::of_rows(rows).map_err(Fault::said)?.without_empty_columns();
        Ok(Table::new(table)?.html()?)
    }
}

/// Judges a trajectory that another program computed for a scene, as `zwidth judge` does.
///
/// `t` in s from the scene's start, `theta` in rad, `velocity` in rad/s (computed by central differences if it is not given),
/// `force` that the program applied, N. `tolerance_rad` and `tolerance_s` are allowed of the angle and of an event's time.
/// Keyword arguments change numbers of the scene, as for `simulate`.
#[pyfunction]
#[pyo3(signature = (scene, t, theta, velocity = None, *, force = None, tolerance_rad = None, tolerance_s = None, **parameters))]
#[expect(clippy::too_many_arguments, reason = "they are keyword arguments of Python")]
pub(crate) fn judge(
    py: Python<'_>,
    scene: &Bound<'_, PyAny>,
    t: &Bound<'_, PyAny>,
    theta: &Bound<'_, PyAny>,
    velocity: Option<&Bound<'_, PyAny>>,
    force: Option<&Bound<'_, PyAny>>,
    tolerance_rad: Option<f64>,
    tolerance_s: Option<f64>,
    parameters: Option<&Bound<'_, PyDict>>,
) -> PyResult<Judgement> {
    let given = Given::new(scene)?;
    let varied = varied(parameters)?;
    if crate::scene::runs(&varied) > 1 {
        return Err(
            Fault::new("several scenes for one trajectory", "give a number for each key").into()
        );
    }
    let t_s = times("t", t)?;
    let theta_rad = beside("theta", theta, "t", t_s.len())?;
    let force_ex_n = force.map(|force| beside("force", force, "t", t_s.len())).transpose()?;
    let theta_dot_rad_s = velocities(&t_s, &theta_rad, velocity)?;
    let velocity_computed = velocity.is_none();
    let usual = Allowed::default();
    let allowed = Allowed {
        theta_rad: allowance("tolerance_rad", tolerance_rad, usual.theta_rad)?,
        event_s: allowance("tolerance_s", tolerance_s, usual.event_s)?,
        ..usual
    };
    call(py, move |_| {
        let scene = given.with(&varied, 0)?;
        let perception = Perception::default();
        let yardstick = Yardstick::of(&scene, &perception).map_err(|e| given.error(&e.into()))?;
        let candidate =
            Candidate { t_s, theta_rad, theta_dot_rad_s, velocity_computed, force_ex_n };
        let judged = judge_one(&yardstick, &candidate, &allowed, &perception);
        Ok(Judgement { judged: judged.map_err(Fault::said)? })
    })
}

/// What is allowed: a number above 0.
fn allowance(name: &str, given: Option<f64>, usual: f64) -> Result<f64, Fault> {
    match given.unwrap_or(usual) {
        allowed if allowed > 0.0 && allowed.is_finite() => Ok(allowed),
        other => {
            Err(Fault::new(format!("{other} is no tolerance"), "give a number above 0")
                .in_column(name))
        }
    }
}
