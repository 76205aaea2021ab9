//! Creep under half the friction: what each solver, at each step, makes of a lever that stands.

use crate::setting::{Fan, Setting};
use zwidth_dynamics::{
    DynamicsError, Environment, Friction, Grid, Input, ModelScene, Plant, Start, System, Terms,
};
use zwidth_results::{Row, SolverCreep};
use zwidth_tables::{Table, TableError};

/// Friction of a scene that has none, N: a tenth of a newton holds its lever.
const FRICTION_N: f64 = 0.2;
/// Steps of a run; the speed is that of its second half.
const STEPS: usize = 512;
/// Length of a run of a solver without a step of its own, s.
const LENGTH_S: f64 = 1.0;

/// The scene's lever under half of its dry friction, and nothing else: no environment, stops, finger or
/// lag. A scene without dry friction gets 0.2 N.
pub fn half_friction(scene: &ModelScene) -> ModelScene {
    let own = scene.friction.filter(|friction| friction.static_n > 0.0);
    let given = Friction { static_n: FRICTION_N, kinetic_n: FRICTION_N, viscous_ns_per_rad: 0.0 };
    let friction = own.unwrap_or(given);
    ModelScene {
        environment: Environment::force(0.0),
        plant: Plant { stops_rad: None, ..scene.plant },
        input: Input::constant(0.5 * friction.static_n),
        start: Start::default(),
        finger: None,
        friction: Some(friction),
        terms: Terms::default(),
        motor: zwidth_dynamics::Motor { lag_s: None, ..scene.motor },
        brake: zwidth_dynamics::Brake { lag_on_off_s: None, let_go_n: None, ..scene.brake },
        ..scene.clone()
    }
}

/// How fast the lever moves under half its friction, by every solver at every step or tolerance: the
/// right answer is 0. A solver that cannot run it has no row.
///
/// # Errors
/// A scene that makes no sense.
pub fn creeps(scene: &ModelScene, fan: &Fan) -> Result<Vec<SolverCreep>, DynamicsError> {
    let system = System::new(half_friction(scene))?;
    let settings = fan.settings().into_iter().flatten();
    let rows = settings.filter_map(|setting| {
        Some(SolverCreep {
            scene: scene.name.as_str().into(),
            solver: setting.solver.into(),
            step_s: setting.step_s(),
            tolerance: setting.tolerance(),
            creep_rad_s: creep_rad_s(&system, &setting)?,
        })
    });
    Ok(rows.collect())
}

/// The mean speed over the second half of a run.
fn creep_rad_s(system: &System, setting: &Setting) -> Option<f64> {
    let step_s = setting.step_s().unwrap_or(LENGTH_S / STEPS as f64);
    let run = setting.solver().run(system, &Grid::Even { step_s, steps: STEPS }).ok()?;
    let theta: Vec<f64> = run.theta_rad().collect();
    let half = STEPS / 2;
    Some((theta[STEPS] - theta[half]) / (run.t_s[STEPS] - run.t_s[half]))
}

/// The table of [`creeps`].
///
/// # Errors
/// None that its rows can cause.
pub fn creeps_table(title: &str, rows: &[SolverCreep]) -> Result<Table, TableError> {
    let table = Table::of_rows(rows)?.called(SolverCreep::NAME, title);
    Ok(table
        .with_note("The lever of the scene alone, under half of its dry friction (0.2 N where it has none): it stands.")
        .with_note("The mean speed over the second half of 512 steps (of 1 s for solvers without a step of their own).")
        .with_note(crate::table::MODEL))
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_dynamics::{DriveMode, table3};

    #[test]
    fn solvers_that_find_rest_stand_and_one_that_switches_within_a_step_creeps() {
        let scene = table3::scene(DriveMode::Hybrid, Input::sine(2.15));
        let rows = creeps(&scene, &Fan::reduced(scene.step_s)).unwrap();
        let fastest = |solver: &str| {
            let own = rows.iter().filter(|row| *row.solver == *solver);
            let speeds: Vec<f64> = own.map(|row| row.creep_rad_s.abs()).collect();
            assert!(!speeds.is_empty(), "{solver}");
            speeds.into_iter().fold(0.0, f64::max)
        };
        for solver in ["exact", "dormand_prince", "tr_bdf2", "moreau_jean"] {
            assert!(fastest(solver) < 1e-15, "{solver}: {}", fastest(solver));
        }
        assert!(fastest("rk4_per_stage") > 1e-3, "{}", fastest("rk4_per_stage"));
    }

    #[test]
    fn the_lever_of_a_scene_stands_under_half_of_its_own_friction() {
        let scene = table3::scene(DriveMode::Hybrid, Input::sine(2.15));
        let own = Friction { static_n: 0.6, kinetic_n: 0.5, viscous_ns_per_rad: 0.1 };
        let half = half_friction(&ModelScene { friction: Some(own), ..scene.clone() });
        assert_eq!((half.friction, half.input), (Some(own), Input::constant(0.3)));
        assert_eq!(half_friction(&scene).input, Input::constant(0.1));
    }
}
