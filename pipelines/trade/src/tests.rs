//! The results of the thesis' scene.

use crate::*;
use crate::{choice as choice_of, settings as settings_of};
use zwidth_dynamics::{DriveMode, Environment, Gravity, Input, RunVerdict, table3};
use zwidth_results::{Gate, Proof, TradeChoice, TradeMetric, TradeSetting};
use zwidth_study::{Measured, Perception};

fn sticking() -> ModelScene {
    table3::scene(DriveMode::Hybrid, Input::sine(2.15))
}

fn made(scene: &ModelScene, fan: Fan, neighbours: usize) -> Trade {
    let parameters = Parameters { perception: Perception::default(), fan, neighbours };
    trade(scene, &parameters, None, &|| ()).unwrap()
}

fn find<'a>(trade: &'a Trade, solver: &str, size: f64) -> &'a Cell {
    let is_it = |cell: &&Cell| {
        cell.setting.solver == solver && (cell.setting.size() - size).abs() <= 1e-9 * size
    };
    trade.cells.iter().find(is_it).unwrap()
}

/// 0.128 ms to 33 ms.
fn reduced(scene: &ModelScene) -> Trade {
    made(scene, Fan::reduced(scene.step_s), 0)
}

#[test]
fn the_yardstick_of_the_sticking_scene_is_proven_and_has_three_motion_changes() {
    let yardstick = Yardstick::of(&sticking(), &Perception::default()).unwrap();
    assert_eq!(yardstick.proof, Proof::Proven, "{:?} {:?}", yardstick.apart_rad, yardstick.apart_s);
    assert_eq!(yardstick.story.motion_changes(), 3, "forward, stick, backward, forward");
}

#[test]
fn a_curved_scene_is_proven_by_two_adaptive_solvers() {
    let mut scene = sticking();
    scene.environment = Environment::spring(4.0, 1.0, -0.785);
    scene.mode = DriveMode::Active;
    scene.motor.max_n = 100.0;
    scene.duration_s = 1.0;
    scene.terms.set(Gravity { mass_kg: 0.02, radius_m: 0.05 });
    let yardstick = Yardstick::of(&scene, &Perception::default()).unwrap();
    assert_eq!((yardstick.by, yardstick.against), ("dormand_prince", "tr_bdf2"));
    assert!(yardstick.apart_rad.unwrap() < 1e-7, "{:?}", yardstick.apart_rad);
}

#[test]
fn the_thesis_setting_chatters_by_0_76_and_3_53_degrees_and_is_felt_through_its_verdict() {
    let trade = reduced(&sticking());
    for (solver, degrees, reversals) in [("rk4_per_stage", 0.763, 2), ("rk4_per_step", 3.529, 38)] {
        let cell = find(&trade, solver, 8.3e-3);
        assert_eq!(cell.judgement.verdict, RunVerdict::NumericalChattering);
        assert_eq!((cell.gate, cell.reversals), (Gate::Verdict, reversals));
        let peak = cell.errors.unwrap().peak_rad.to_degrees();
        assert!((peak - degrees).abs() < 2e-3, "{solver}: {peak}");
    }
}

#[test]
fn a_setting_that_lets_a_held_lever_creep_is_not_recommended_and_its_way_is_in_the_table() {
    let mut scene = sticking();
    scene.environment = Environment::free();
    scene.input = Input::constant(0.05);
    scene.friction =
        Some(zwidth_dynamics::Friction { static_n: 0.1, kinetic_n: 0.1, viscous_ns_per_rad: 0.0 });
    scene.start.theta_rad = 0.0;
    let trade = reduced(&scene);
    let cell = find(&trade, "rk4_per_stage", 8.3e-3);
    assert_eq!(cell.judgement.verdict, RunVerdict::NumericalCreep);
    assert_eq!(cell.gate, Gate::Verdict);
    assert!(cell.judgement.creep_rad > 0.01, "{:?}", cell.judgement);
    for setting in settings_of(&[trade]) {
        let held = ["exact", "moreau_jean"].contains(&&*setting.solver);
        assert!(setting.creep_rad.is_some_and(|way| !held || way < 1e-300), "{setting:?}");
    }
}

#[test]
fn rk4_is_of_order_four_where_nothing_switches_and_euler_of_order_one() {
    // A damped spring that a motor without limits renders, pushed by a sine, from rest at its rest.
    let mut scene = sticking();
    scene.mode = DriveMode::Active;
    scene.motor.max_n = 1e6;
    scene.plant = zwidth_dynamics::Plant { mass_kg: 0.1, lever_m: 1.0, stops_rad: None };
    scene.environment = Environment::spring(40.0, 0.5, 0.0);
    scene.start.theta_rad = 0.02;
    let steps: Vec<f64> = (0..4).map(|k| 0.5e-3 * f64::from(1 << k)).collect();
    let fan = Fan { doubled_s: steps, further_s: vec![], tolerances: vec![1e-6] };
    let trade = made(&scene, fan, 0);
    for (solver, order) in [("rk4_per_stage", 4.0), ("symplectic_euler", 1.0)] {
        let error = |step: f64| find(&trade, solver, step).errors.unwrap().theta_rad.largest;
        let found = (error(4e-3) / error(2e-3)).log2();
        assert!((found - order).abs() < 0.15, "{solver}: order {found}");
    }
}

#[test]
fn what_is_recommended_passes_the_gates_on_its_neighbours_and_what_is_cheaper_does_not() {
    let scene = sticking();
    let trade = made(&scene, Fan::reduced(scene.step_s), 5);
    let choice = trade.choice.as_ref().unwrap();
    assert_eq!(choice.confirmed, (5, 5));
    let chosen = find(&trade, choice.setting.solver, choice.setting.size());
    assert!(chosen.is_good());
    assert!(!choice.setting.solver.starts_with("rk4"), "{choice:?}: it chatters");
    let text = recommended_scene(&trade).unwrap().unwrap();
    let read = ModelScene::from_toml(&text).unwrap();
    let step_s = choice.setting.step_s().unwrap_or(scene.step_s);
    assert_eq!(read, ModelScene { step_s, ..scene });
}

#[test]
fn tables_have_a_row_a_setting_and_a_row_a_scene() {
    let trade = reduced(&sticking());
    let settings = settings_of(std::slice::from_ref(&trade));
    assert_eq!(settings.len(), trade.cells.len());
    assert!(settings.iter().any(|setting| setting.on_front));
    let table = settings_table("Trade", &settings).unwrap();
    assert_eq!((table.name(), table.title()), ("trade", "Trade"));
    assert_eq!(table.to_rows::<TradeSetting>().unwrap(), settings);
    let choices = [choice_of(&trade)];
    assert_eq!(choices[0].yardstick, Proof::Proven);
    assert!(choices[0].why_not.is_some(), "{choices:?}");
    let table = choices_table("Trade", &choices).unwrap();
    assert_eq!(table.to_rows::<TradeChoice>().unwrap(), choices);
}

/// The largest angle and the mean of the user's force, the second in a unit without a bound.
fn measured(course: &Course) -> Vec<Measured> {
    let number = |name: &str, unit: &str, value: f64| Measured {
        name: name.to_owned(),
        unit: unit.to_owned(),
        value: Some(value),
    };
    let top = course.theta_rad.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mean = course.force_ex_n.iter().sum::<f64>() / course.t_s.len() as f64;
    vec![number("theta_max_rad", "rad", top), number("push", "1", mean)]
}

#[test]
fn a_study_s_metrics_of_a_setting_are_held_against_those_of_the_right_run() {
    let (scene, bounds) = (sticking(), Perception::default());
    let fan = Fan { doubled_s: vec![], further_s: vec![8.3e-3], tolerances: vec![] };
    let parameters = Parameters { perception: bounds.clone(), fan, neighbours: 0 };
    let metrics = Metrics { measure: &measured, bounds: &bounds };
    let trade = trade(&scene, &parameters, Some(&metrics), &|| ()).unwrap();
    let cell = find(&trade, "rk4_per_step", 8.3e-3);
    let (metric, share) = cell.furthest_metric().unwrap();
    // Its top is off by 3.53 degrees (thesis' switching), of which 2 are just felt.
    assert_eq!(metric.name, "theta_max_rad");
    assert!((share - 3.529 / 2.0).abs() < 0.01, "{share}");
    assert!(cell.metrics[1].change().unwrap().abs() < 1e-12, "the push is an input");
    assert!(find(&trade, "exact", 0.0).metrics.is_empty());
    let rows = crate::metrics(std::slice::from_ref(&trade));
    let cells = trade.cells.iter().filter(|cell| !cell.metrics.is_empty()).count();
    assert_eq!(rows.len(), 2 * cells);
    assert_eq!(metrics_table("M", &rows).unwrap().to_rows::<TradeMetric>().unwrap(), rows);
    let settings = settings_of(std::slice::from_ref(&trade));
    assert!(settings.iter().any(|s| s.metric.as_deref() == Some("theta_max_rad")));
}

#[test]
fn one_thread_and_many_give_the_same_table() {
    let scene = ModelScene { duration_s: 1.5, ..sticking() };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| reduced(&scene))
    };
    assert_eq!(on(1), on(3));
}
