//! Metrics of one's own arrays.

use crate::calling::{Fault, call};
use crate::given::{beside, numbers, times, velocities};
use crate::table::Table;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use zwidth_average::{Parameters as AverageParameters, loop_table, mean_loop};
use zwidth_metrics::{Parameters, table, trial_metrics as metrics_of};
use zwidth_numerics::activity::activity;
use zwidth_numerics::smoothness::spectral_arc_length;
use zwidth_results::{ConditionKey, Row as _, TrialKey};
use zwidth_store::{Samples, Signal, Trial, TrialFile};
use zwidth_study::{
    Analysis, Kind, Resistances, Scene, SceneKind, Source, Spring, Status, TrialMeta,
};

/// Every metric of one movement: a table of one row, the columns of `metrics.parquet` without those that name a trial.
///
/// `t` in s, `theta` in rad, `force` of the user in N (above 0 pushes into the object), `velocity` in rad/s; without it
/// central differences of `theta` are taken, which show the steps of an angle sensor. `lever_m` is the lever's length: without
/// it there is no work in J. `scene` says what was rendered: `{"kind": "spring", "stiffness_n_per_rad": 4.0, "rest_rad":
/// -0.78}`, kinds free, spring, wall (`wall_rad`), spring_wall, force (`force_n`); free without it.
#[pyfunction]
#[pyo3(signature = (t, theta, force, *, velocity = None, lever_m = None, scene = None))]
pub(crate) fn trial_metrics(
    py: Python<'_>,
    t: &Bound<'_, PyAny>,
    theta: &Bound<'_, PyAny>,
    force: &Bound<'_, PyAny>,
    velocity: Option<&Bound<'_, PyAny>>,
    lever_m: Option<f64>,
    scene: Option<&Bound<'_, PyDict>>,
) -> PyResult<Table> {
    let trial = trial(1, t, theta, force, velocity)?;
    if let Some(lever_m) = lever_m.filter(|lever_m| !(*lever_m > 0.0 && lever_m.is_finite())) {
        let what = format!("a lever of {lever_m} m");
        return Err(Fault::new(what, "give its length in m, above 0").in_column("lever_m").into());
    }
    let parameters = Parameters {
        analysis: Analysis::default(),
        scene: rendered(scene)?,
        lever_m,
        theta_min_rad: None,
        theta_max_rad: None,
        force_rate_hz: None,
        trial_limit_s: f64::MAX,
        uses_motor: true,
        uses_brake: false,
        resistances: Resistances::default(),
        axes: None,
        own: Vec::new(),
    };
    call(py, move |_| {
        let metrics = metrics_of(&trial, &parameters).map_err(Fault::said)?;
        let rows = table(&[metrics], &[], false).map_err(Fault::said)?;
        let keys = TrialKey::fields();
        let keys: Vec<&str> = keys.iter().map(|field| &*field.name).collect();
        Table::without(&rows, &keys)
    })
}

/// Smoothness of a movement: the spectral arc length of its speed (SPARC; Balasubramanian et al. 2015), dimensionless and
/// below 0; a minimum-jerk movement has −1.40. None for fewer than three samples, fewer than 20 a second, or no movement.
///
/// `t` in s, `velocity` in any unit; its sign does not count.
#[pyfunction]
pub(crate) fn smoothness(
    py: Python<'_>,
    t: &Bound<'_, PyAny>,
    velocity: &Bound<'_, PyAny>,
) -> PyResult<Option<f64>> {
    let t = times("t", t)?;
    let velocity = beside("velocity", velocity, "t", t.len())?;
    call(py, move |_| {
        let speed: Vec<f64> = velocity.into_iter().map(f64::abs).collect();
        Ok(spectral_arc_length(&t, &speed))
    })
}

/// When a movement begins and ends, s: the first time with a speed above `onset_rad_s`, and the first one below
/// `offset_rad_s` after the speed was last above `onset_rad_s`; None where there is none.
///
/// `t` in s, `velocity` in rad/s; thresholds without a value are those of a study, 10 °/s and 5 °/s.
#[pyfunction]
#[pyo3(signature = (t, velocity, *, onset_rad_s = None, offset_rad_s = None))]
pub(crate) fn onset(
    t: &Bound<'_, PyAny>,
    velocity: &Bound<'_, PyAny>,
    onset_rad_s: Option<f64>,
    offset_rad_s: Option<f64>,
) -> PyResult<(Option<f64>, Option<f64>)> {
    let t = times("t", t)?;
    let velocity = beside("velocity", velocity, "t", t.len())?;
    let usual = Analysis::default();
    let on = onset_rad_s.unwrap_or(usual.onset_rad_s);
    let off = offset_rad_s.unwrap_or(usual.offset_rad_s);
    if !(on.is_finite() && on >= off && off > 0.0) {
        let what = format!("thresholds of {on} and {off} rad/s");
        return Err(Fault::new(
            what,
            "give two numbers above 0, the onset's not below the offset's",
        )
        .into());
    }
    let found = activity(&velocity, on, off);
    Ok((found.map(|found| t[found.onset]), found.and_then(|found| found.end).map(|end| t[end])))
}

/// Mean force over the angle by branch (in, held, out), as a study's averages are made: at one angle the mean of the forces
/// of all movements, with SD and a pointwise interval.
///
/// `t`, `theta`, `force` and `velocity` are lists of arrays, one for each movement, in the units of `trial_metrics`; so is
/// `scene`, which may not be free.
#[pyfunction]
#[pyo3(signature = (t, theta, force, scene, *, velocity = None))]
pub(crate) fn means_by_branch(
    py: Python<'_>,
    t: Vec<Bound<'_, PyAny>>,
    theta: Vec<Bound<'_, PyAny>>,
    force: Vec<Bound<'_, PyAny>>,
    scene: &Bound<'_, PyDict>,
    velocity: Option<Vec<Bound<'_, PyAny>>>,
) -> PyResult<Table> {
    let count = t.len();
    for (name, found) in [("theta", theta.len()), ("force", force.len())]
        .into_iter()
        .chain(velocity.as_ref().map(|velocity| ("velocity", velocity.len())))
    {
        if found != count {
            let what = format!("{found} arrays, where t has {count}");
            return Err(Fault::new(what, "give an array for each movement").in_column(name).into());
        }
    }
    let trials = (0..count).map(|i| {
        let velocity = velocity.as_ref().map(|velocity| &velocity[i]);
        trial(i + 1, &t[i], &theta[i], &force[i], velocity)
    });
    let trials = trials.collect::<PyResult<Vec<Trial>>>()?;
    let parameters =
        AverageParameters { analysis: Analysis::default(), scene: rendered(Some(scene))? };
    call(py, move |_| {
        let mean = mean_loop(&trials, &parameters).map_err(Fault::said)?;
        let rows = loop_table(&mean).map_err(Fault::said)?;
        let keys = ConditionKey::fields();
        let keys: Vec<&str> = keys.iter().map(|field| &*field.name).collect();
        Table::without(&rows, &[keys.as_slice(), &["source"]].concat())
    })
}

/// A movement as a trial of nobody.
fn trial(
    number: usize,
    t: &Bound<'_, PyAny>,
    theta: &Bound<'_, PyAny>,
    force: &Bound<'_, PyAny>,
    velocity: Option<&Bound<'_, PyAny>>,
) -> PyResult<Trial> {
    let t = times("t", t)?;
    let theta = beside("theta", theta, "t", t.len())?;
    let force = beside("force", force, "t", t.len())?;
    if t.len() < 2 {
        let what = format!("{} samples", t.len());
        return Err(Fault::new(what, "give a movement of two samples or more")
            .in_column("t")
            .into());
    }
    let velocity = velocities(&t, &theta, velocity)?;
    let mut samples = Samples::default();
    let columns = [
        (Signal::Time, t),
        (Signal::Theta, theta),
        (Signal::ThetaDot, velocity),
        (Signal::ForceEx, force),
    ];
    columns.into_iter().for_each(|(signal, values)| samples.set(signal, values));
    Ok(Trial { meta: nobody(number)?, file: TrialFile::new(), samples })
}

/// What stands in the place of a trial's names.
fn nobody(number: usize) -> Result<TrialMeta, Fault> {
    let number = u32::try_from(number).map_err(Fault::said)?;
    Ok(TrialMeta {
        participant: "P01".parse().map_err(Fault::said)?,
        session: "S01".parse().map_err(Fault::said)?,
        trial: number,
        repeat: number,
        kind: Kind::Trial,
        status: Status::Complete,
        environment: "own".parse().map_err(Fault::said)?,
        mode: "own".parse().map_err(Fault::said)?,
        likert: None,
        source: Source::Imported,
        presented: None,
    })
}

/// What was rendered, as a dict says it.
fn rendered(given: Option<&Bound<'_, PyDict>>) -> PyResult<Scene> {
    let Some(given) = given else { return Ok(Scene::Free) };
    let mut left: Vec<String> = given.keys().extract()?;
    let remedy = "give kind, and the numbers of that kind: stiffness_n_per_rad and rest_rad of a spring, wall_rad of a wall, force_n of a force";
    let mut take = |key: &str| -> PyResult<Bound<'_, PyAny>> {
        left.retain(|name| name != key);
        let value = given.get_item(key)?;
        Ok(value.ok_or_else(|| Fault::new("the scene lacks it", remedy).in_column(key))?)
    };
    let word: String = take("kind")?.extract()?;
    let kind =
        SceneKind::from_word(&word).filter(|kind| *kind != SceneKind::None).ok_or_else(|| {
            Fault::new(
                format!("there is no kind {word:?}"),
                "choose free, spring, wall, spring_wall or force",
            )
            .in_column("kind")
        })?;
    let mut number = |key: &str| -> PyResult<f64> {
        let value: f64 = take(key)?.extract()?;
        match value.is_finite() {
            true => Ok(value),
            false => Err(Fault::new(format!("{value} is no number"), remedy).in_column(key).into()),
        }
    };
    let spring = |number: &mut dyn FnMut(&str) -> PyResult<f64>| -> PyResult<Spring> {
        Ok(Spring {
            stiffness_n_per_rad: number("stiffness_n_per_rad")?,
            rest_rad: number("rest_rad")?,
        })
    };
    let scene = match kind {
        SceneKind::None => Scene::None,
        SceneKind::Free => Scene::Free,
        SceneKind::Spring => Scene::Spring(spring(&mut number)?),
        SceneKind::Wall => Scene::Wall { wall_rad: number("wall_rad")? },
        SceneKind::SpringWall => {
            Scene::SpringWall { spring: spring(&mut number)?, wall_rad: number("wall_rad")? }
        }
        SceneKind::Force => Scene::Force { force_n: number("force_n")? },
    };
    match left.first() {
        None => Ok(scene),
        Some(key) => Err(Fault::new(format!("a scene of kind {word} has no such number"), remedy)
            .in_column(key)
            .into()),
    }
}

/// The numbers of several arrays.
pub(crate) fn each(name: &str, given: &[Bound<'_, PyAny>]) -> PyResult<Vec<Vec<f64>>> {
    given.iter().map(|array| numbers(name, array)).collect()
}
