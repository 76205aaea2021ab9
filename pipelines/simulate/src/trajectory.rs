//! A run as tables: its samples with the forces by part, and its events.

use crate::Run;
use crate::summary::verdict_meaning;
use zwidth_dynamics::{Contact, Event, EventKind, Forces, Motion, Term};
use zwidth_tables::{Column, Table, TableError};

/// A part of the force on the lever: column, meaning, how to pick it.
type Part = (&'static str, &'static str, fn(&Forces) -> f64);

/// The samples of a run: time, state, forces by part (N, above 0 they push into the object, +θ),
/// and how the lever moves. A part that the scene does not have has no column.
///
/// # Errors
/// None that a finished run can cause: solvers give no value that is not finite.
pub fn trajectory_table(run: &Run) -> Result<Table, TableError> {
    let of = &run.trajectory;
    let forces: Vec<Forces> = (0..of.len()).map(|i| of.forces(&run.system, i)).collect();
    let float = |name, unit, about, values: Vec<f64>| {
        Column::float(name, unit, about, values.into_iter().map(Some))
    };
    let mut columns = vec![
        float("t_s", "s", "time", of.t_s.clone()),
        float("theta_rad", "rad", "lever angle", of.theta_rad().collect()),
        float("theta_dot_rad_s", "rad/s", "lever velocity", of.theta_dot_rad_s().collect()),
    ];
    if run.system.scene().finger.is_some() {
        columns.push(float(
            "finger_m",
            "m",
            "compression of the fingertip's tissue",
            of.finger_m().collect(),
        ));
    }
    for (name, about, part) in parts(run) {
        columns.push(float(name, "N", about, forces.iter().map(part).collect()));
    }
    columns.extend(term_columns(run));
    let motions =
        of.region.iter().map(|&i| Some(motion_word(of.regions[usize::from(i)].motion).to_owned()));
    columns.push(Column::text("motion", "how the lever moves: forward, rest or backward", motions));
    let table = Table::new("trajectory", &run.system.scene().name, columns)?;
    Ok(notes(run).into_iter().fold(table, Table::with_note))
}

/// The parts that the scene has.
fn parts(run: &Run) -> Vec<Part> {
    let scene = run.system.scene();
    let finger = scene.finger.is_some();
    let all: [(bool, Part); 7] = [
        (true, ("force_ex_n", "force of the user", |f| f.external_n)),
        (finger, ("force_tip_n", "what arrives of it at the lever", |f| f.tip_n)),
        (finger, ("force_tissue_n", "share of the finger's tissue", |f| f.tissue_n)),
        (true, ("force_motor_n", "force of the motor", |f| f.motor_n)),
        (true, ("force_brake_n", "force of the brake", |f| f.brake_n)),
        (
            scene.friction.is_some(),
            ("force_friction_n", "friction of the drive train", |f| f.friction_n),
        ),
        (
            scene.plant.stops_rad.is_some(),
            ("force_stop_n", "force of a mechanical stop", |f| f.stop_n),
        ),
    ];
    all.into_iter().filter_map(|(there, part)| there.then_some(part)).collect()
}

/// The force of each of the scene's terms: `force_pull_n`, `force_gravity_n`, …
fn term_columns(run: &Run) -> Vec<Column> {
    let of = &run.trajectory;
    let rows: Vec<Vec<f64>> =
        (0..of.len()).map(|i| run.system.term_forces_n(of.state(i)).collect()).collect();
    let column = |(k, term): (usize, &dyn Term)| {
        let values = rows.iter().map(|row| Some(row[k]));
        let mut column = Column::float(term.name(), "N", term.about(), values);
        column.field.name = format!("force_{}_n", term.name()).into();
        column
    };
    run.system.scene().terms.iter().enumerate().map(column).collect()
}

/// What is to be read with a run's numbers.
fn notes(run: &Run) -> [String; 2] {
    let step_ms = run.system.scene().step_s * 1e3;
    [
        format!(
            "A model run, not a measurement: solver {}, a sample every {step_ms} ms, {}.",
            run.solver,
            verdict_meaning(run.judgement.verdict)
        ),
        "Forces on the lever's end; above 0 they push into the object (+θ).".to_owned(),
    ]
}

/// The events of a run, in order of time. Empty for solvers that do not look for events.
///
/// # Errors
/// None that a finished run can cause.
pub fn events_table(run: &Run) -> Result<Table, TableError> {
    let events = &run.trajectory.events;
    let float = |name, unit, about, get: fn(&Event) -> f64| {
        Column::float(name, unit, about, events.iter().map(|event| Some(get(event))))
    };
    let text = |name, about, get: fn(&Event) -> &'static str| {
        Column::text(name, about, events.iter().map(|event| Some(get(event).to_owned())))
    };
    let mut columns = vec![
        float("t_s", "s", "when it happened", |event| event.t_s),
        text("event", "what happened", |event| event_word(event.kind)),
        float("theta_rad", "rad", "lever angle there", |event| event.theta_rad),
        text("motion", "how the lever moves from then on", |event| {
            motion_word(event.region.motion)
        }),
    ];
    if run.system.scene().finger.is_some() {
        columns.push(text("tissue", "the fingertip from then on", |event| {
            contact_word(event.region.contact)
        }));
    }
    let table = Table::new("events", &format!("{}: events", run.system.scene().name), columns)?;
    Ok(table.with_note(notes(run)[0].clone()))
}

fn motion_word(motion: Motion) -> &'static str {
    match motion {
        Motion::Forward => "forward",
        Motion::Backward => "backward",
        Motion::Rest => "rest",
    }
}

fn contact_word(contact: Contact) -> &'static str {
    match contact {
        Contact::Free => "free",
        Contact::Pressed => "fully pressed",
        Contact::Stretched => "fully stretched",
    }
}

fn event_word(kind: EventKind) -> &'static str {
    match kind {
        EventKind::Reversal => "reversal",
        EventKind::Zone => "next zone",
        EventKind::Stop => "stop",
        EventKind::SaturatedLow => "lower limit",
        EventKind::SaturatedHigh => "upper limit",
        EventKind::Unsaturated => "off the limit",
        EventKind::DepartUp => "departs forward",
        EventKind::DepartDown => "departs backward",
        EventKind::LetGo => "brake's let-go threshold",
        EventKind::Bottomed => "tissue fully pressed",
        EventKind::LiftedOff => "tissue springs back",
        EventKind::Input => "input jumps",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DEFAULT_TOLERANCE, simulate, solver};
    use zwidth_dynamics::{DriveMode, Gravity, Input, ModelScene, Pull, table3};

    fn run(scene: ModelScene) -> Run {
        simulate(scene, solver("exact", DEFAULT_TOLERANCE).unwrap().as_ref()).unwrap()
    }

    fn sticking() -> ModelScene {
        table3::scene(DriveMode::Hybrid, Input::sine(2.15))
    }

    fn column(table: &Table, name: &str) -> Vec<f64> {
        table.floats(name).unwrap().into_iter().map(Option::unwrap).collect()
    }

    #[test]
    fn the_forces_by_part_balance_while_the_lever_rests() {
        let table = trajectory_table(&run(sticking())).unwrap();
        let parts = ["force_ex_n", "force_motor_n", "force_brake_n", "force_stop_n"];
        let parts = parts.map(|name| column(&table, name));
        let motions = table.texts("motion").unwrap();
        let rests: Vec<usize> =
            (0..table.height()).filter(|&i| motions[i].as_deref() == Some("rest")).collect();
        assert!(rests.len() > 20, "{}", rests.len());
        for i in rests {
            let sum: f64 = parts.iter().map(|part| part[i]).sum();
            assert!(sum.abs() < 1e-12, "sample {i}: {sum} N are left over");
        }
    }

    #[test]
    fn a_part_that_the_scene_lacks_has_no_column() {
        let names = |scene| {
            let table = trajectory_table(&run(scene)).unwrap();
            table.fields().map(|f| f.name.to_string()).collect::<Vec<_>>()
        };
        let bare = names(sticking());
        assert!(
            !bare.iter().any(|n| n.contains("tissue") || n == "finger_m" || n.contains("gravity"))
        );
        assert!(names(table3::with_finger(sticking())).contains(&"force_tissue_n".to_owned()));
    }

    #[test]
    fn each_term_has_a_column_of_its_own() {
        let mut scene = ModelScene { duration_s: 0.5, ..sticking() };
        scene.terms.set(Pull { stiffness_n_per_rad: 2.0, displacement: Input::constant(0.1) });
        scene.terms.set(Gravity { mass_kg: 0.02, radius_m: 0.04 });
        let solver = solver("dormand_prince", DEFAULT_TOLERANCE).unwrap();
        let table = trajectory_table(&simulate(scene, solver.as_ref()).unwrap()).unwrap();
        let (theta, pull) = (column(&table, "theta_rad"), column(&table, "force_pull_n"));
        let gravity = column(&table, "force_gravity_n");
        for (i, theta) in theta.iter().enumerate() {
            assert!((pull[i] - 2.0 * (0.1 - theta)).abs() < 1e-12);
            assert!((gravity[i] - 0.02 * 9.80665 * 0.04 * theta.sin()).abs() < 1e-12);
        }
    }

    #[test]
    fn the_events_tell_the_story_of_the_sticking_lever() {
        let table = events_table(&run(sticking())).unwrap();
        let mut motions: Vec<String> =
            table.texts("motion").unwrap().into_iter().flatten().collect();
        motions.dedup();
        assert_eq!(motions, ["forward", "rest", "backward", "forward"]);
    }
}
