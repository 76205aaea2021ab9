//! What becomes of scenes at the extremes: each ends in finite numbers or in an error that names
//! what is wrong, and none hangs. The page that shows it is written by a long run.

#![allow(clippy::unwrap_used, clippy::panic)] // helpers outside of a test function are test code too

mod scenes;

use rayon::prelude::*;
use scenes::{Kind, scene};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;
use zwidth_dynamics::{
    DormandPrince, DynamicsError, Exact, Grid, Input, ModelScene, MoreauJean, NAMED_SOLVERS,
    Reference, Rk4, Series, Solver, Switching, SymplecticEuler, System, Tolerances, TrBdf2, table3,
};

/// The seed of every run.
const SEED: u64 = 16;
/// Scenes of a test.
const SCENES: u64 = 10_000;
/// Every so many scenes one is judged too: a verdict takes some hundred runs, and its reference up
/// to three million steps a run.
const JUDGED: u64 = 10_000;
/// Length of a run and its samples, s.
const RUN: (f64, f64) = (0.2, 0.008);

/// Seven methods, each with a limit on its work that ends a run in an error of its own.
fn solvers() -> Vec<Box<dyn Solver>> {
    let tolerances = Tolerances { most_steps: 300, ..Tolerances::of(1e-5) };
    vec![
        Box::new(Exact { most_events: 100, most_pieces: 2_000, energy: false }),
        Box::new(DormandPrince { tolerances }),
        Box::new(TrBdf2 { tolerances }),
        Box::new(MoreauJean::default()),
        Box::new(SymplecticEuler),
        Box::new(Rk4 { switching: Switching::PerStage }),
        Box::new(Rk4 { switching: Switching::PerStep }),
    ]
}

/// What became of a scene.
type Counts = BTreeMap<(Kind, String), u64>;

fn word(error: &DynamicsError) -> &'static str {
    match error {
        DynamicsError::Parameter { .. } => "refused: a number",
        DynamicsError::Combination { .. } => "refused: two parts",
        DynamicsError::NotPiecewiseAffine { .. } => "not for `exact`",
        DynamicsError::NotFinite { .. } => "no longer finite",
        DynamicsError::TooMuchWork { .. } => "too much work",
        DynamicsError::Toml(_) => "no scene",
    }
}

/// Runs a scene with one method; every word for what came of it.
fn outcome(number: u64) -> (Kind, String) {
    let (kind, scene) = scene(SEED, number);
    let solvers = solvers();
    let solver = &solvers[(number % solvers.len() as u64) as usize];
    (kind, ended(&scene, solver.as_ref(), number))
}

fn ended(scene: &ModelScene, solver: &dyn Solver, number: u64) -> String {
    let run = System::new(scene.clone())
        .and_then(|system| Ok((solver.run(&system, &Grid::filling(RUN.0, RUN.1))?, system)));
    match run {
        Ok((run, system)) => {
            let finite = run.states.iter().all(|x| x.is_finite());
            let forces = (0..run.len()).map(|i| run.forces(&system, i));
            let known = forces.into_iter().all(|f| (f.motor_n + f.brake_n + f.stop_n).is_finite());
            assert!(finite && known, "scene {number}: {} gives no number", solver.name());
            "result".to_owned()
        }
        Err(error) => {
            let text = error.to_string();
            let names = !matches!(error, DynamicsError::NotFinite { .. }) || text.contains(" = ");
            assert!(names && !text.is_empty(), "scene {number}: {text}");
            word(&error).to_owned()
        }
    }
}

/// The verdict on a scene that can be run, with the same limits on work.
fn verdict(number: u64) -> Option<(Kind, String)> {
    let (kind, mut scene) = scene(SEED, number);
    (scene.duration_s, scene.step_s) = RUN;
    let named = &NAMED_SOLVERS[(number / JUDGED) as usize % NAMED_SOLVERS.len()];
    let system = System::new(scene).ok()?;
    let judged = Reference::of(&system).judge((named.make)(1e-5).as_ref(), RUN.1);
    Some((kind, judged.verdict.as_str().to_owned()))
}

fn counted(outcomes: impl ParallelIterator<Item = (Kind, String)>) -> Counts {
    let one = |mut counts: Counts, key| {
        *counts.entry(key).or_default() += 1;
        counts
    };
    let join = |mut a: Counts, b: Counts| {
        b.into_iter().for_each(|(key, n)| *a.entry(key).or_default() += n);
        a
    };
    outcomes.fold(Counts::new, one).reduce(Counts::new, join)
}

#[test]
fn ten_thousand_scenes_at_the_extremes_end_in_numbers_or_in_errors_that_say_what_is_wrong() {
    let counts = counted((0..SCENES).into_par_iter().map(outcome));
    assert_eq!(counts.values().sum::<u64>(), SCENES);
    let all =
        |word: &str| -> u64 { counts.iter().filter(|((_, w), _)| w == word).map(|(_, n)| n).sum() };
    for word in ["result", "refused: a number", "too much work", "no longer finite"] {
        assert!(all(word) > 0, "{word} never happens: {counts:?}");
    }
}

#[test]
fn a_scene_within_a_factor_of_ten_is_refused_for_parts_that_do_not_fit_alone() {
    for number in 0..600 {
        let (kind, scene) = scene(SEED, number);
        if kind != Kind::Near {
            continue;
        }
        // Friction at rest may have been drawn below that in motion.
        match System::new(scene) {
            Ok(_) | Err(DynamicsError::Combination { .. }) => {}
            Err(error) => assert!(error.to_string().contains("friction.static_n"), "{error}"),
        }
    }
}

/// The page of a long run; its length by the environment, a million scenes by default.
#[test]
#[ignore = "a million scenes; writes docs/extremes.md anew"]
fn write_the_page() {
    let asked = std::env::var("ZWIDTH_EXTREMES").ok().and_then(|text| text.parse().ok());
    let scenes: u64 = asked.unwrap_or(1_000_000);
    let ends = counted((0..scenes).into_par_iter().map(outcome));
    let verdicts =
        counted((0..scenes / JUDGED).into_par_iter().filter_map(|i| verdict(i * JUDGED)));
    let long = long_runs(10_000_000);
    std::fs::write(path(), page(scenes, &ends, &verdicts, &long)).unwrap();
}

/// Time between two samples of a long run, s.
const SAMPLE_S: f64 = 1e-4;

/// Table 3's hybrid drive under an input for so many samples.
fn long_scene(input: Input, samples: usize) -> System {
    let mut scene = table3::scene(zwidth_dynamics::DriveMode::Hybrid, input);
    scene.duration_s = SAMPLE_S * samples as f64;
    System::new(scene).unwrap()
}

/// A recorded force: a value a millisecond in single precision, every seventh of them as small as
/// that has, or smaller.
fn single_precision(samples: usize) -> Series {
    let values = samples / 10 + 2;
    let value = |i: usize| match i % 7 {
        0 => f64::from(f32::from_bits(1 + (i % 1000) as u32)),
        3 => 5e-324,
        _ => f64::from((2.15 * (1.0 + libm::sin(1.6e-3 * i as f64))) as f32),
    };
    let time = |i: usize| if i == 0 { 0.0 } else { f64::from((i as f32) * 1e-3_f32) };
    // Beyond some hours neighbours in single precision are one: two equal times are a jump.
    let t_s = (0..values).map(time).collect();
    Series { t_s, value: (0..values).map(value).collect() }
}

/// Runs of so many samples: what each was, and how it ended.
fn long_runs(samples: usize) -> Vec<(String, String)> {
    let sine = || long_scene(Input::sine(2.15), samples);
    let mut rows = vec![visited("sine", &sine(), samples)];
    let recorded = long_scene(Input::Series(single_precision(samples)), samples);
    rows.push(visited("recorded force in single precision, with denormals", &recorded, samples));
    let tolerances = Tolerances { most_steps: u64::MAX, ..Tolerances::of(1e-6) };
    let whole: [Box<dyn Solver>; 5] = [
        Box::new(MoreauJean::default()),
        Box::new(SymplecticEuler),
        Box::new(Rk4 { switching: Switching::PerStep }),
        Box::new(DormandPrince { tolerances }),
        Box::new(TrBdf2 { tolerances }),
    ];
    let grid = Grid::Even { step_s: SAMPLE_S, steps: samples };
    for solver in whole {
        let run = solver.run(&sine(), &grid).unwrap();
        let finite = run.states.iter().filter(|x| x.is_finite()).count();
        assert_eq!((run.len(), finite), (samples + 1, run.states.len()), "{}", solver.name());
        let highest = run.theta_rad().fold(f64::MIN, f64::max);
        rows.push((format!("`{}`, sine", solver.name()), largest(highest)));
    }
    let most_events = samples as u64 / 50_000;
    let bounded = Exact { most_events, most_pieces: u64::MAX, energy: false };
    let error = bounded
        .prepare(&sine(), &grid)
        .and_then(|mut run| run.visit(&grid, &mut |_, _| {}))
        .unwrap_err();
    assert!(matches!(error, DynamicsError::TooMuchWork { .. }), "{error}");
    rows.push((format!("`exact`, sine, at most {most_events} events"), format!("{error}")));
    rows
}

/// The exact solver, sample by sample, of which nothing is kept.
fn visited(what: &str, system: &System, samples: usize) -> (String, String) {
    let grid = Grid::Even { step_s: SAMPLE_S, steps: samples };
    let exact = Exact { most_events: u64::MAX, most_pieces: u64::MAX, energy: false };
    let (mut highest, mut finite) = (f64::MIN, 0_usize);
    exact
        .prepare(system, &grid)
        .and_then(|mut run| {
            run.visit(&grid, &mut |_, state| {
                finite += usize::from(state.iter().all(|x| x.is_finite()));
                highest = highest.max(state[0]);
            })
        })
        .unwrap();
    assert_eq!(finite, samples + 1, "{what}");
    (format!("`exact`, {what}"), largest(highest))
}

fn largest(theta_rad: f64) -> String {
    format!("result, largest θ {:.5}°", theta_rad.to_degrees())
}

/// The long runs of the page, a hundredth as long.
#[test]
fn long_runs_of_every_method_end_in_numbers_and_a_bound_on_events_in_its_error() {
    let rows = long_runs(100_000);
    assert_eq!(rows.len(), 8);
    assert!(rows[7].1.starts_with("more than 2 events"), "{:?}", rows[7]);
}

fn page(scenes: u64, ends: &Counts, verdicts: &Counts, long: &[(String, String)]) -> String {
    let mut text = include_str!("page.md").to_owned();
    let _ = writeln!(text, "\n## {scenes} scenes, seed {SEED}\n");
    text += &table(ends);
    let judged: u64 = verdicts.values().sum();
    let _ = writeln!(text, "\n## Verdicts on {judged} of them that can be run\n");
    text += &table(verdicts);
    text += "\n## Runs of 10,000,000 samples\n\nTable 3, hybrid, a sample every 0.1 ms, each state of each looked at.\n\n";
    text += "| run | ends in |\n|---|---|\n";
    for (what, end) in long {
        let _ = writeln!(text, "| {what} | {end} |");
    }
    text
}

fn table(counts: &Counts) -> String {
    let mut words: Vec<&String> = counts.keys().map(|(_, word)| word).collect();
    words.sort();
    words.dedup();
    let mut text = "| numbers |".to_owned();
    words.iter().for_each(|word| text += &format!(" {word} |"));
    text += "\n|---|";
    text += &"--:|".repeat(words.len());
    for kind in Kind::ALL {
        let _ = write!(text, "\n| {} |", kind.as_str());
        for word in &words {
            let count = counts.get(&(kind, (*word).clone()));
            text += &count.map_or(" |".to_owned(), |n| format!(" {n} |"));
        }
    }
    text + "\n"
}

fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../docs/extremes.md")
}
