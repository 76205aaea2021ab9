//! Several axes: which columns need a study with axes, and projections on the push.

use super::mapping::{Origin, PushOrigin, Rule, SignalFrom};
use std::path::Path;
use zwidth_store::{Signal, StoreError};
use zwidth_study::{Axes, Schema, Study};

pub(super) const POSITIONS: [Signal; 3] = [Signal::X, Signal::Y, Signal::Z];
pub(super) const FORCES: [Signal; 3] = [Signal::ForceX, Signal::ForceY, Signal::ForceZ];

/// Words of a column of the orientation.
pub(super) const ORIENTATION: [&str; 19] = [
    "roll",
    "pitch",
    "yaw",
    "quat",
    "quaternion",
    "orientation",
    "rot",
    "rotation",
    "euler",
    "qx",
    "qy",
    "qz",
    "qw",
    "rx",
    "ry",
    "rz",
    "azimuth",
    "elevation",
    "attitude",
];
/// Words of a column of a moment about an axis.
pub(super) const MOMENTS: [&str; 12] = [
    "tx", "ty", "tz", "mx", "my", "mz", "torquex", "torquey", "torquez", "momentx", "momenty",
    "momentz",
];

/// Why a column that a mapping names is not among ours, if it is one of a pose or of a wrench.
pub(super) fn not_recorded(name: &str) -> Option<String> {
    let lower = name.to_lowercase();
    let words: Vec<&str> = lower
        .split(|letter: char| !letter.is_alphanumeric())
        .filter(|word| !word.is_empty())
        .collect();
    let has = |listed: &[&str]| words.iter().any(|word| listed.contains(word));
    let is_moment = has(&MOMENTS) || (has(&["torque", "moment"]) && has(&["x", "y", "z"]));
    let what = if has(&ORIENTATION) {
        "orientation"
    } else if is_moment {
        "a moment about an axis"
    } else {
        return None;
    };
    Some(format!(
        "'{name}' is {what}, for which a trial has no column: keep it as a channel ([[channels]] of study.toml, and \
         [[channel]] here); [[metrics]] of study.toml makes metrics of channels"
    ))
}

/// Checks that a study has axes if the mapping has columns of axes.
///
/// # Errors
/// A study without axes: one error, however many columns there are.
pub(super) fn check_axes(
    study: &Study,
    mapping: &Path,
    columns: &[SignalFrom],
) -> Result<(), StoreError> {
    let in_axes = columns.iter().find(|column| {
        let is_projection = matches!(column.origin, Origin::Derived(Rule::AlongPush(_)));
        is_projection || column.to.schema() >= Schema::Three
    });
    let Some(column) = in_axes.filter(|_| study.axes.is_none()) else { return Ok(()) };
    let schema = match study.schema {
        Schema::Two => " and schema = 2",
        Schema::Three => "",
    };
    let what = format!("{} needs axes, and study.toml has no [axes]{schema}", column.to.name());
    let remedy = "write schema = 3, and under [axes] frame and push, before the first trial; or keep the columns as channels \
                  ([[channels]] of study.toml, and [[channel]] here)";
    Err(StoreError::new(mapping, what, remedy).column(column.to.name()))
}

/// A projection on the push: Σ part · axis, less where it is 0, per a length.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Projection {
    to: Signal,
    /// The axes that are mapped, and the part of the push along each.
    pub(super) parts: Vec<(Signal, f64)>,
    push: [f64; 3],
    origin: PushOrigin,
    /// What is subtracted; the first value of the trial if there is none.
    pub(super) zero: Option<f64>,
    /// What it is divided by: the lever's length, which makes an angle of a way; 1 of a force.
    pub(super) per: f64,
}

impl Projection {
    /// That of positions or forces on the study's push.
    ///
    /// # Errors
    /// A push along an axis that is not mapped; no lever length.
    pub(super) fn of(
        study: &Study,
        mapping: &Path,
        to: Signal,
        origin: PushOrigin,
        columns: &[SignalFrom],
    ) -> Result<Self, StoreError> {
        let push = study.axes.as_ref().map_or([0.0; 3], |axes| axes.push);
        let axes = if to == Signal::Theta { POSITIONS } else { FORCES };
        let mut parts = Vec::new();
        for (axis, part) in axes.into_iter().zip(push) {
            if columns.iter().any(|column| column.to == axis) {
                parts.push((axis, part));
            } else if part.abs() > Axes::UNIT {
                let what = format!(
                    "{} is a projection on push = {push:?}, and {} is not mapped",
                    to.name(),
                    axis.name()
                );
                let remedy = "map this axis, or correct push under [axes] of study.toml";
                return Err(StoreError::new(mapping, what, remedy).column(to.name()));
            }
        }
        let per = match (to, study.device.lever_m) {
            (Signal::Theta, Some(lever_m)) => lever_m,
            (Signal::Theta, None) => {
                let what =
                    "theta_rad is the way along push per device.lever_m, which study.toml lacks";
                let remedy = "set lever_m under [device] (with coordinate.kind = \"linear\" everything is shown in mm again), or \
                              leave this column out: metrics of axes need none";
                return Err(StoreError::new(mapping, what, remedy).column(to.name()));
            }
            _ => 1.0,
        };
        let zero = match origin {
            PushOrigin::First => None,
            PushOrigin::Place(place) => {
                Some(place.into_iter().zip(push).fold(0.0, |sum, (place, part)| sum + place * part))
            }
        };
        Ok(Self { to, parts, push, origin, zero, per })
    }

    /// How it is computed, for the report and the files.
    pub(super) fn words(&self) -> String {
        let names: Vec<&str> = self.parts.iter().map(|(axis, _)| axis.name()).collect();
        let names = names.join(", ");
        let push = self.push;
        if self.to != Signal::Theta {
            return format!("({names}) · push {push:?}");
        }
        let origin = match self.origin {
            PushOrigin::First => "the first sample".to_owned(),
            PushOrigin::Place(place) => format!("{place:?} m"),
        };
        format!("(({names}) − {origin}) · push {push:?} / L with L = {} m", self.per)
    }
}

#[cfg(test)]
mod tests {
    use super::super::world::{ONE, World, close, column, template_once, trials_map};
    use super::*;
    use std::fmt::Write as _;

    const TIME: &str = "[time]\nfrom = \"t\"\nunit = \"s\"\n";
    const AXES: &str =
        "\n[axes]\nframe = \"x right, y up, z to the person\"\npush = [0, 0.6, -0.8]\n";
    const THETA: &str = "[[column]]\nto = \"theta_rad\"\nderive = \"along push\"\n";
    const FORCE: &str = "[[column]]\nto = \"force_ex_n\"\nderive = \"along push\"\n";

    fn study() -> String {
        format!("{}{AXES}", template_once().replacen("schema = 2", "schema = 3", 1))
    }

    /// Positions in mm and forces in lbf.
    fn pose() -> String {
        let mut text = String::new();
        for (axis, unit) in [("x", "mm"), ("y", "mm"), ("z", "mm")] {
            text += &column(&format!("{axis}_m"), axis, unit);
        }
        for axis in ["x", "y", "z"] {
            text += &column(&format!("force_{axis}_n"), &format!("f{axis}"), "lbf");
        }
        text
    }

    const CSV: &str =
        "t,x,y,z,fx,fy,fz\n0,1,100,50,1,0,0\n0.1,2,110,40,0,1,0\n0.2,3,120,20,0,0,-1\n";

    #[test]
    fn positions_and_forces_become_metres_and_newtons_and_projections_say_that_they_are_made() {
        let world = World::with(&study());
        let origin = THETA.to_owned() + "origin = [0.0, 0.1, 0.05]\n";
        let velocity =
            "[[column]]\nto = \"theta_dot_rad_s\"\nderive = \"derivative of theta_rad\"\n";
        let map = trials_map(&[ONE, TIME, &pose(), &origin, velocity, FORCE]);
        let report = world.import(&map, &[world.file("a.csv", CSV)]).unwrap();
        close(&world.column(1, Signal::Y), &[0.1, 0.11, 0.12]);
        let lbf = 4.448_221_615_260_5;
        close(&world.column(1, Signal::ForceZ), &[0.0, 0.0, -lbf]);
        // 0.6 Δy − 0.8 Δz, per lever of 45 mm.
        close(&world.column(1, Signal::Theta), &[0.0, 0.014 / 0.045, 0.036 / 0.045]);
        close(&world.column(1, Signal::ForceEx), &[0.0, 0.6 * lbf, 0.8 * lbf]);
        let made = world.computed(1);
        let words = "theta_rad = ((x_m, y_m, z_m) − [0.0, 0.1, 0.05] m) · push [0.0, 0.6, -0.8] / L with L = 0.045 m";
        assert!(made.contains(words), "{made}");
        assert!(made.contains("force_ex_n = (force_x_n, force_y_n, force_z_n) · push"), "{made}");
        assert!(report.to_string().contains("x_m ← x (mm)"), "{report}");
        let first = World::with(&study());
        let origin = THETA.to_owned() + "origin = \"first\"\n";
        let map = trials_map(&[ONE, TIME, &pose(), &origin]);
        first.import(&map, &[first.file("a.csv", CSV)]).unwrap();
        close(&first.column(1, Signal::Theta), &[0.0, 0.014 / 0.045, 0.036 / 0.045]);
    }

    #[test]
    fn a_long_text_has_the_same_axes_and_projections_as_a_short_one() {
        let mut csv = "t,x,y,z,fx,fy,fz\n".to_owned();
        for i in 0..3000_u32 {
            let t = f64::from(i) / 100.0;
            let (sine, cosine) = (libm::sin(t), libm::cos(t));
            let _ = writeln!(csv, "{t},{},{},{},{sine},{cosine},1", 50.0 * sine, 50.0 * cosine, t);
        }
        let first = THETA.to_owned() + "origin = \"first\"\n";
        let velocity =
            "[[column]]\nto = \"theta_dot_rad_s\"\nderive = \"derivative of theta_rad\"\n";
        let map = trials_map(&[ONE, TIME, &pose(), &first, velocity, FORCE]);
        let [short, long] = [World::with(&study()), World::with(&study())];
        short.import(&map, &[short.file("a.csv", &csv)]).unwrap();
        long.import_streamed(&map, &[long.file("a.csv", &csv)]).unwrap();
        for signal in [Signal::X, Signal::ForceZ, Signal::Theta, Signal::ThetaDot, Signal::ForceEx]
        {
            assert_eq!(short.column(1, signal), long.column(1, signal), "{}", signal.name());
        }
    }

    #[test]
    fn a_study_without_axes_is_one_error_however_many_columns_there_are() {
        let map = trials_map(&[ONE, TIME, &pose(), FORCE]);
        let two = World::new();
        let file = two.file("a.csv", CSV);
        two.refuses(
            &map,
            &file,
            "x_m needs axes, and study.toml has no [axes] and schema = 2",
            None,
        );
        let three = World::with(&template_once().replacen("schema = 2", "schema = 3", 1));
        let file = three.file("a.csv", CSV);
        three.refuses(&map, &file, "x_m needs axes, and study.toml has no [axes];", None);
    }

    #[test]
    fn a_projection_needs_the_axes_of_its_push_a_lever_and_columns_above_it() {
        let world = World::with(&study());
        let file = world.file("a.csv", CSV);
        let x = column("x_m", "x", "mm");
        let map = trials_map(&[ONE, TIME, &x, THETA]);
        world.refuses(&map, &file, "and y_m is not mapped", None);
        let map = trials_map(&[ONE, TIME, THETA, &pose()]);
        world.refuses(&map, &file, "needs x_m, y_m, z_m, each mapped by a [[column]] above", None);
        let leverless = World::with(&study().replace("lever_m = 0.045", ""));
        let file = leverless.file("a.csv", CSV);
        let map = trials_map(&[ONE, TIME, &pose(), THETA]);
        leverless.refuses(&map, &file, "per device.lever_m, which study.toml lacks", None);
        for (columns, words) in [
            (FORCE.to_owned() + "origin = \"first\"\n", "a force has no origin"),
            (THETA.to_owned() + "origin = \"last\"\n", "a place in metres such as"),
            (THETA.to_owned() + "origin = [0, nan, 0]\n", "three finite numbers"),
            (THETA.replace("theta_rad", "theta_dot_rad_s"), "is the derivative of theta_rad"),
            (x.clone() + "origin = \"first\"\n", "beside derive = \"along push\" alone"),
            (column("roll_rad", "r", "rad"), "is orientation, for which a trial has no column"),
            (column("torque_x_nm", "tx", "N·m"), "is a moment about an axis"),
            (column("force_x_n", "tx", "N·m"), "does not fit force_x_n"),
        ] {
            let before = if columns.contains("force_x_n") || columns.contains("x_m\"\nfrom") {
                String::new()
            } else {
                pose()
            };
            let map = trials_map(&[ONE, TIME, &before, &columns]);
            let told = super::super::Mapping::from_toml(&map, Path::new("map.toml")).unwrap_err();
            assert_eq!(told.len(), 1, "{told:?}");
            assert!(told[0].to_string().contains(words), "{told:?}");
        }
    }
}
