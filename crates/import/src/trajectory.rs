//! A file of another program's simulation → one motion in SI units, for whoever judges it. Nothing is
//! written, and no study is needed.

use super::errors::Errors;
use super::guess::trajectory_mapping;
use super::guess_read::{Looked, look};
use super::limits::{Budget, Take};
use super::mapping::{Content, Mapping, Rule};
use super::mend::unwrap_angle;
use super::plan::{Plan, plan, rate_times};
use super::recording::Recording;
use super::table::{Cell, ColumnRef};
use super::trials::check_turned;
use super::zero;
use std::collections::BTreeMap;
use std::path::Path;
use zwidth_numerics::series::{central_differences, cumulative_trapezoid};
use zwidth_store::{FirstErrors, Signal, StoreError};
use zwidth_study::{Coordinate, Study, StudyId, template};

/// A motion that another program computed.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trajectory {
    /// Times, s.
    pub t_s: Vec<f64>,
    /// θ at each, rad.
    pub theta_rad: Vec<f64>,
    /// θ̇ at each, rad/s.
    pub theta_dot_rad_s: Vec<f64>,
    /// Whether that was computed from the angles.
    pub velocity_computed: bool,
    /// The user's force on the lever's end, N, if the file has it.
    pub force_ex_n: Option<Vec<f64>>,
    /// Which column became what: `theta_rad ← angle_deg (deg)`.
    pub converted: Vec<String>,
}

/// Reads a trajectory of any format that an import reads. Without a mapping its columns are
/// recognised by their names and units; with one (`kind = "trials"`) it says which they are, and
/// whose trial it would be does not matter. Positions and torques become angles and forces by a lever
/// of `lever_m`.
///
/// # Errors
/// A file that cannot be read; no time or no angle in it, or without a unit; a cell that is no
/// number; a mapping of something else.
pub fn trajectory(
    path: &Path,
    mapping: Option<&Mapping>,
    lever_m: f64,
) -> Result<Trajectory, FirstErrors> {
    let guessed;
    let mapping = match mapping {
        Some(mapping) => mapping,
        None => {
            guessed = Mapping::from_toml(&trajectory_mapping(path)?, path)?;
            &guessed
        }
    };
    let Content::Trials(from) = &mapping.content else {
        let what = "it maps something else than recordings of a motion";
        let remedy = "set kind = \"trials\", with [time] and a [[column]] for the angle";
        return Err(StoreError::new(&mapping.path, what, remedy).into());
    };
    let study = lever(lever_m, path)?;
    let plan = plan(&study, &mapping.path, &from.time, &from.columns, &[])?;
    read(path, mapping, &plan)
}

/// A study of a lever: what a unit of length or of torque needs.
fn lever(lever_m: f64, path: &Path) -> Result<Study, StoreError> {
    // The template is valid: a test reads it.
    let study = StudyId::new("scene").ok().and_then(|id| Study::from_toml(&template(&id)).ok());
    let mut study = study.ok_or_else(|| {
        StoreError::new(path, "the template of a study is damaged", "install the program again")
    })?;
    study.device.lever_m = Some(lever_m);
    study.coordinate = Coordinate::Linear { lever_m };
    Ok(study)
}

fn read(path: &Path, mapping: &Mapping, plan: &Plan<'_>) -> Result<Trajectory, Errors> {
    let budget = Budget::default();
    let taken: Vec<&ColumnRef> = plan.columns().collect();
    let take = Take { turned: mapping.file.turned, ..Take::of(taken, &budget) };
    let mut recording = Recording::read(path, &mapping.file, mapping.name.as_ref(), &take)?;
    check_turned(mapping.file.turned, &recording)?;
    let numeric =
        plan.columns().map(|column| recording.find(column)).collect::<Result<Vec<_>, _>>()?;
    for (taken, place) in plan.taken.iter().zip(&numeric) {
        recording.check_unit(*place, taken.unit.0, taken.unit.1, &taken.line)?;
    }
    if let Some(time) = plan.time {
        recording.read_clock(time, time.from_first)?;
    }
    recording.height(&numeric, &[])?;
    let mut rows = recording.rows(&mapping.file, &numeric, &[])?;
    if let Some(time) = plan.time {
        recording.mend(time, &mut rows, &numeric, &[])?;
    }
    let mut signals: BTreeMap<Signal, Vec<f64>> = BTreeMap::new();
    if let Some(rate_hz) = plan.rate_hz {
        signals.insert(Signal::Time, rate_times(rate_hz, recording.places(&rows.kept)));
    }
    // The times come first: the zeros of others are taken at some of them.
    for (taken, place) in plan.taken.iter().zip(&numeric) {
        let mut values = recording.numbers(*place, &rows.kept)?;
        if let Some(wrap) = taken.wrap {
            unwrap_angle(&mut values, wrap);
        }
        let t_s = signals.get(&Signal::Time).map_or(&[][..], Vec::as_slice);
        let zero = zero::find(taken.line.zero, t_s, &values)
            .map_err(|what| recording.error(what, "name another stretch in zero"))?;
        taken.line.apply(&mut values, taken.factor, zero.value);
        signals.insert(taken.to, values);
    }
    let of = |signals: &BTreeMap<Signal, Vec<f64>>, signal: Signal| {
        signals.get(&signal).cloned().ok_or_else(|| {
            let what = format!("the mapping gives no {}", signal.name());
            recording.error(what, "add a [[column]] for it")
        })
    };
    let derivative = |t_s: &[f64], x: &[f64]| {
        let few = |_| recording.error("it has fewer than two samples", "simulate longer");
        central_differences(t_s, x).map_err(few)
    };
    for (to, rule) in &plan.derived {
        let source = match *rule {
            Rule::DerivativeOf(source) | Rule::IntegralOf(source) => source,
            Rule::AlongPush(_) => {
                let what = "its coordinate is to be a projection of several, and a scene has one";
                return Err(recording.error(what, "map the column of the angle").into());
            }
        };
        let [t_s, x] = [of(&signals, Signal::Time)?, of(&signals, source)?];
        let values = match rule {
            Rule::DerivativeOf(_) => derivative(&t_s, &x)?,
            _ => cumulative_trapezoid(&t_s, &x)
                .map_err(|e| recording.error(e.to_string(), "sort the rows by their time"))?,
        };
        signals.insert(*to, values);
    }
    let t_s = of(&signals, Signal::Time)?;
    let theta_rad = of(&signals, Signal::Theta)?;
    let own = signals.get(&Signal::ThetaDot).cloned();
    let velocity_computed =
        own.is_none() || plan.derived.iter().any(|(to, _)| *to == Signal::ThetaDot);
    Ok(Trajectory {
        theta_dot_rad_s: own.map_or_else(|| derivative(&t_s, &theta_rad), Ok)?,
        velocity_computed,
        force_ex_n: signals.remove(&Signal::ForceEx),
        converted: [plan.converted.clone(), plan.computed.clone()].concat(),
        t_s,
        theta_rad,
    })
}

/// The texts of some columns of a table, row by row; a column that it does not have is empty
/// throughout.
///
/// # Errors
/// A file that cannot be read.
pub fn texts<const N: usize>(
    path: &Path,
    columns: [&str; N],
) -> Result<Vec<[String; N]>, StoreError> {
    let Looked { table, .. } = look(path)?;
    let places = columns.map(|name| table.find(&ColumnRef::Name(name.to_owned())).ok());
    let rows = places.iter().flatten().map(|place| table.columns[*place].len()).max().unwrap_or(0);
    let cell = |place: usize, row: usize| match table.columns[place].cell(row) {
        Cell::Empty => String::new(),
        cell => cell.to_string(),
    };
    Ok((0..rows)
        .map(|row| places.map(|place| place.map_or(String::new(), |at| cell(at, row))))
        .collect())
}

#[cfg(test)]
#[allow(clippy::float_cmp)]
mod tests {
    use super::super::world::World;
    use super::*;

    fn of(name: &str, text: &str, map: Option<&str>) -> Result<Trajectory, String> {
        let world = World::new();
        let file = world.file(name, text);
        let mapping = map.map(|map| Mapping::from_toml(map, Path::new("map.toml")).unwrap());
        trajectory(&file, mapping.as_ref(), 0.05)
            .map_err(|errors| errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
    }

    #[test]
    fn columns_are_recognised_by_their_names_and_units() {
        let text = "t_s,theta_rad,theta_dot_rad_s,force_ex_n,note\n0,0.1,0,1,a\n0.5,0.2,0.3,2,b\n";
        let found = of("a.csv", text, None).unwrap();
        assert_eq!((found.t_s, found.theta_rad), (vec![0.0, 0.5], vec![0.1, 0.2]));
        assert_eq!((found.theta_dot_rad_s, found.velocity_computed), (vec![0.0, 0.3], false));
        assert_eq!(found.force_ex_n, Some(vec![1.0, 2.0]));
        let found = of("a.csv", "time_ms;angle_deg\n0;0\n500;90\n1000;90\n", None).unwrap();
        assert_eq!(found.t_s, [0.0, 0.5, 1.0]);
        let half = std::f64::consts::FRAC_PI_2;
        assert_eq!((found.theta_rad[1], found.velocity_computed), (half, true));
        assert_eq!(found.theta_dot_rad_s, [2.0 * half, half, 0.0]);
    }

    #[test]
    fn a_mapping_says_what_other_columns_are() {
        let map = "kind = \"trials\"\nsimulated = true\n[trial]\nparticipant = \"P01\"\nsession = \"S01\"\n\
                   environment = \"any\"\nmode = \"any\"\n[time]\nfrom = \"step\"\nunit = \"ms\"\n\
                   [[column]]\nto = \"theta_rad\"\nfrom = \"qpos0\"\nunit = \"mm\"\n\
                   [[column]]\nto = \"theta_dot_rad_s\"\nderive = \"derivative of theta_rad\"\n";
        let found = of("a.csv", "step,qpos0\n0,0\n10,5\n", Some(map)).unwrap();
        assert_eq!(found.t_s, [0.0, 0.01]);
        assert!((found.theta_rad[1] - 0.1).abs() < 1e-15, "a lever of 50 mm");
        assert!((found.theta_dot_rad_s[0] - 10.0).abs() < 1e-12 && found.velocity_computed);
    }

    #[test]
    fn what_is_missing_or_no_number_is_said_with_its_place() {
        for (text, words) in [
            ("a,theta_rad\n0,1\n1,2\n", "no column of time"),
            ("t_s,a\n0,1\n1,2\n", "no column of the angle"),
            ("t_s,theta\n0,1\n1,2\n", "the unit of 'theta' is not known"),
            ("t_s,theta_rad\n0,1\n1,2\n2,3\n3,nan\n", "row 4"),
            ("t_s,theta_rad\n0,1\n1,2\n2,3\n3,x\n", "'x' is not a number"),
        ] {
            let error = of("a.csv", text, None).unwrap_err();
            assert!(error.contains(words), "{text}: {error}");
        }
        let likert = "kind = \"exclusions\"\n";
        let mapping = Mapping::from_toml(likert, Path::new("map.toml"));
        assert!(mapping.is_err() || of("a.csv", "t_s\n0\n", Some(likert)).is_err());
    }
}
