//! Scenes whose answer is known.

use crate::ladder::ladder;
use crate::model::{Loop, model};
use crate::ranges::Point;
use crate::run::{Frame, run};
use crate::{
    Course, Ladder, LadderError, Settings, chosen, effects, effects_table, interactions,
    interactions_table, models, models_table, own, possible, told,
};
use zwidth_device::Velocity;
use zwidth_dynamics::{
    Brake, BrakeLaw, DriveMode, Environment, Exact, Grid, Input, ModelScene, Motor, Plant, Solver,
    Start, System, Terms,
};
use zwidth_results::{LadderModel, LadderTerm, TermEffect, TermPair, TermSet};
use zwidth_study::{Perception, VelocityFilter};

/// A lever of the prototype's size on a spring, pushed slowly by the motor's side.
fn scene(mode: DriveMode, environment: Environment, input: Input) -> ModelScene {
    ModelScene {
        name: "known".to_owned(),
        mode,
        duration_s: 2.0,
        step_s: 0.001,
        environment,
        plant: Plant { mass_kg: 0.0973, lever_m: 0.045, stops_rad: Some([-0.785, 0.785]) },
        motor: Motor { max_n: 4.16, lag_s: None },
        brake: Brake {
            max_n: 13.0,
            law: BrakeLaw::Coulomb,
            dead_zone_n: 0.0,
            lag_on_off_s: None,
            let_go_n: None,
        },
        input,
        start: Start { theta_rad: -0.785, theta_dot_rad_s: 0.0 },
        finger: None,
        friction: None,
        terms: Terms::default(),
    }
}

fn looped(period_s: f64) -> Loop {
    let velocity = Velocity::new(VelocityFilter::SecondOrder { cutoff_hz: 40.0 }).unwrap();
    Loop { period_s, velocity }
}

fn settings(period_s: f64, points: usize, offered: TermSet) -> Settings {
    Settings { looped: looped(period_s), points, bounds: Perception::default(), offered }
}

fn climbed(scene: &ModelScene, period_s: f64, points: usize, offered: TermSet) -> Ladder {
    ladder(scene, &settings(period_s, points, offered), &own, &|| ()).unwrap()
}

/// No force, no start: the lever lies on its stop, whatever the model.
fn at_rest() -> ModelScene {
    scene(DriveMode::Active, Environment::spring(4.0, 0.0, -0.785), Input::constant(0.0))
}

/// A slow push of up to 2 N into the motor's spring: friction holds the lever back, and nothing is
/// quick enough for a lag, a fast loop or its sensors to matter.
fn pushed() -> ModelScene {
    let input = Input::Ramp { magnitude: 1.0, period_s: 4.0 };
    scene(DriveMode::Active, Environment::spring(4.0, 0.0, -0.785), input)
}

/// Everything but what a push of 2 N feels however slow it is: weight and finger.
const DRIVE: TermSet = TermSet::ALL.without(LadderTerm::Gravity).without(LadderTerm::Finger);

#[test]
fn a_scene_in_which_nothing_happens_needs_none_of_the_terms() {
    let found = climbed(&at_rest(), 0.0083, 4, TermSet::ALL);
    assert_eq!(found.rungs.len(), TermSet::COUNT);
    assert_eq!(found.choice().unwrap().set, TermSet::NONE);
    let theta = &found.quantities[0];
    // Sensors see up to a count below the stop, and the motor pushes by its spring.
    let samples = 4.0 * (2.0_f64 / 0.0083).floor();
    let spread_rad = (theta.variance.variance() / samples).sqrt();
    assert!(theta.name == "theta_rad" && spread_rad < 0.01 * 2_f64.to_radians(), "{spread_rad}");
}

#[test]
fn a_slow_push_into_a_spring_needs_friction_alone() {
    let found = climbed(&pushed(), 0.001, 4, DRIVE);
    let choice = found.choice().unwrap();
    assert_eq!(choice.set, TermSet::NONE.with(LadderTerm::Friction), "{}", choice.set);
    let theta = &found.quantities[0].variance;
    let friction = found.switch(LadderTerm::Friction).unwrap();
    assert!(theta.total(friction).unwrap() > 0.8, "{:?}", theta.total(friction));
    assert!(!found.next_smaller(choice.set).unwrap().is_enough());
}

/// A sampled wall's spring that a delay of up to a period drives unstable and a lag of the motor
/// delays further: each alone does less than the two together.
#[test]
fn delay_and_lag_work_together_where_a_loop_is_near_its_limit() {
    let input = Input::Ramp { magnitude: 1.5, period_s: 4.0 };
    let mut scene = scene(DriveMode::Active, Environment::spring(14.0, 0.0, -0.785), input);
    scene.motor.lag_s = Some(0.004);
    let offered =
        [LadderTerm::Friction, LadderTerm::MotorLag, LadderTerm::Sampling, LadderTerm::Delay];
    let offered = offered.into_iter().fold(TermSet::NONE, TermSet::with);
    let found = climbed(&scene, 0.0083, 16, offered);
    let theta = &found.quantities[0].variance;
    let [lag, delay] = [LadderTerm::MotorLag, LadderTerm::Delay].map(|t| found.switch(t).unwrap());
    assert!(theta.second(lag, delay).unwrap() > 0.01, "{:?}", theta.second(lag, delay));
    let free = climbed(&pushed(), 0.001, 16, offered);
    let apart = free.quantities[0].variance.second(lag, delay).unwrap();
    assert!(apart < 1e-3, "{apart}");
}

#[test]
fn a_model_without_a_loop_is_the_exact_solvers_and_one_with_fine_ticks_comes_close_to_it() {
    let input = Input::Ramp { magnitude: 1.5, period_s: 4.0 };
    let scene = scene(DriveMode::Active, Environment::spring(4.0, 0.0, -0.785), input);
    let frame = Frame::of(scene.duration_s, 0.0083);
    let course = |set: TermSet, period_s: f64| -> Course {
        let mut model = model(&scene, set, &Point::usual(), period_s);
        model.delay_s = 0.0;
        run(&model, &looped(period_s), &frame).unwrap().0
    };
    let friction = TermSet::NONE.with(LadderTerm::Friction);
    let truth = course(friction, 0.0083);
    let usual = model(&scene, friction, &Point::usual(), 0.0083);
    let system = System::new(usual.scene).unwrap();
    let grid = Grid::Even { step_s: frame.step_s(), steps: frame.steps };
    let exact: Vec<f64> = Exact::default().run(&system, &grid).unwrap().theta_rad().collect();
    assert_eq!(truth.theta_rad, exact);
    // Held commands are late by half a tick, 0.5 ms: at most that much of the fastest motion.
    let fine = course(friction.with(LadderTerm::Delay), 0.0083);
    let off = fine.theta_rad.iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 5e-3 && off > 0.0, "{off}");
}

#[test]
fn the_ladder_is_the_same_on_one_thread_and_on_many() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| climbed(&pushed(), 0.0083, 3, DRIVE))
    };
    assert_eq!(on(1), on(4));
}

#[test]
fn a_term_that_is_out_costs_nothing() {
    let usual = Point::usual();
    let scene = pushed();
    let frame = Frame::of(scene.duration_s, 0.0083);
    let cost = |set| run(&model(&scene, set, &usual, 0.0083), &looped(0.0083), &frame).unwrap().1;
    let rigid = cost(TermSet::NONE);
    let system = System::new(model(&scene, TermSet::NONE, &usual, 0.0083).scene).unwrap();
    let grid = Grid::Even { step_s: frame.step_s(), steps: frame.steps };
    let own = Exact::default().run(&system, &grid).unwrap();
    assert_eq!((rigid.work, rigid.decisions), (own.work, 0));
}

#[test]
fn the_tables_say_the_choice_and_read_it_back() {
    let found = climbed(&pushed(), 0.001, 2, DRIVE);
    let table = models_table(&found).unwrap();
    assert_eq!((table.name(), table.title()), ("ladder.models", "known: models"));
    let rows: Vec<LadderModel> = table.to_rows().unwrap();
    assert_eq!((rows.len(), &rows), (64, &models(&found)));
    assert_eq!(chosen(&rows), found.choice().map(|rung| rung.set));
    let effects: Vec<TermEffect> = effects_table(&found).unwrap().to_rows().unwrap();
    let reason = |row: usize| effects[row].reason.clone().unwrap().to_string();
    assert!(reason(0).starts_with("friction is kept: a model without it"), "{}", reason(0));
    assert!(reason(1).starts_with("motor lag is left out"), "{}", reason(1));
    let pairs: Vec<TermPair> = interactions_table(&found).unwrap().to_rows().unwrap();
    assert_eq!(pairs, interactions(&found));
    assert_eq!(pairs.len(), found.quantities.len() * 15, "of six terms there are 15 pairs");
}

#[test]
fn a_scene_is_not_offered_a_term_of_a_part_that_it_lacks() {
    let possible =
        |mode| possible(&scene(mode, Environment::spring(4.0, 0.0, -0.785), Input::constant(1.0)));
    let lacks = |set: TermSet| TermSet::ALL.terms().filter(|t| !set.has(*t)).collect::<Vec<_>>();
    assert_eq!(lacks(possible(DriveMode::Active)), [LadderTerm::Finger, LadderTerm::BrakeLag]);
    assert_eq!(lacks(possible(DriveMode::Passive)), [LadderTerm::Finger, LadderTerm::MotorLag]);
    assert_eq!(lacks(possible(DriveMode::Hybrid)), [LadderTerm::Finger]);
}

#[test]
fn what_the_scene_does_not_give_it_is_not_said_to_need() {
    let found = climbed(&pushed(), 0.001, 4, DRIVE);
    let choice = found.choice().unwrap();
    let words = told(&found, choice);
    assert!(words.contains("terms it needs none; with numbers of the simulated device"), "{words}");
    let given = Ladder { in_scene: TermSet::ALL, ..found.clone() };
    let words = told(&given, choice);
    assert!(words.contains("terms it needs friction; "), "{words}");
}

/// What stands in the figure is what the choice was made by: kept terms beyond what is felt, unless
/// they make a run cheaper, and all others below.
#[test]
fn the_number_that_decides_is_beyond_what_is_felt_of_kept_terms_alone() {
    let found = climbed(&pushed(), 0.001, 4, DRIVE);
    let choice = found.choice().unwrap();
    for term in found.offered.terms() {
        let (_, off) = found.deciding(choice, term).unwrap().furthest().unwrap();
        assert_eq!(off > 1.0, choice.set.has(term), "{}: {off}", term.as_str());
    }
    let off: Vec<Option<f64>> = effects(&found).iter().map(|row| row.deciding_off).collect();
    assert!(off.iter().all(Option::is_some), "{off:?}");
}

#[test]
fn what_makes_no_sense_is_refused_with_what_it_is() {
    let error = |points, period_s| {
        ladder(&at_rest(), &settings(period_s, points, TermSet::ALL), &own, &|| ()).unwrap_err()
    };
    assert!(matches!(error(0, 0.0083), LadderError::Points { points: 0, .. }));
    for period_s in [0.0, -1.0, f64::NAN, 1e-9, 100.0] {
        assert!(matches!(error(1, period_s), LadderError::Period { .. }), "{period_s}");
    }
    let mut scene = at_rest();
    scene.brake.law = BrakeLaw::Thesis;
    let error =
        ladder(&scene, &settings(0.0083, 1, TermSet::ALL), &own, &|| ()).unwrap_err().to_string();
    assert!(error.contains("brake.law"), "{error}");
}

#[test]
fn each_point_is_told_when_it_is_done() {
    let count = std::sync::atomic::AtomicUsize::new(0);
    let tell = || {
        count.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    };
    ladder(&at_rest(), &settings(0.0083, 4, TermSet::NONE), &own, &tell).unwrap();
    assert_eq!(count.into_inner(), 4);
}
