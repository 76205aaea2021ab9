//! Facts about the figures of trials, on small made-up data.

use crate::course::data::AT_THE_ANGLE;
use crate::{
    About, EnvironmentData, ModeData, Repeat, SIGNALS, average_columns, loop_columns, loops, modes,
    rendering_range, repeats,
};
use std::sync::LazyLock;
use zwidth_draw::{Axis, Figure, Layer, Line, Range, style};
use zwidth_results::{Gate, Proof, TradeChoice, TradeSetting};
use zwidth_store::{Samples, Signal, Trial};
use zwidth_study::{Alignment, Environment, Source, TrialMeta};
use zwidth_tables::{Column, Table};

/// A setting of the scene `s` of which nothing is known.
pub(crate) fn trade_setting(solver: &str) -> TradeSetting {
    TradeSetting {
        scene: "s".into(),
        mode: "hybrid".into(),
        model: "no finger".into(),
        solver: solver.into(),
        step_s: None,
        tolerance: None,
        verdict: "smooth".into(),
        gate: Gate::Verdict,
        theta_error_max_rad: None,
        theta_error_rms_rad: None,
        theta_dot_error_max_rad_s: None,
        theta_dot_error_rms_rad_s: None,
        force_error_max_n: None,
        force_error_rms_n: None,
        impulse_error_ns: None,
        event_error_s: None,
        peak_error_rad: None,
        felt_force_share: None,
        felt_angle_share: None,
        felt_vibration_share: None,
        vibration_hz: None,
        vibration_m: None,
        reversals: None,
        swings: None,
        swing_amplitude_rad: None,
        creep_rad: None,
        steps: None,
        rejected: None,
        evaluations: None,
        factorisations: None,
        work: None,
        on_front: false,
        metric: None,
        metric_share: None,
        metrics_felt: None,
        metrics_lost: None,
    }
}

/// The scene `s`, for which nothing is recommended.
pub(crate) fn trade_choice() -> TradeChoice {
    TradeChoice {
        scene: "s".into(),
        mode: "hybrid".into(),
        model: "no finger".into(),
        yardstick: Proof::Proven,
        by: "exact".into(),
        against: "dormand_prince".into(),
        apart_rad: None,
        apart_s: None,
        motion_changes: 3,
        solver: None,
        step_s: None,
        tolerance: None,
        work: None,
        neighbours: None,
        passed: None,
        next_cheaper: None,
        why_not: None,
    }
}

/// The template, as figures see it.
struct Studied {
    about: About,
    environments: Vec<Environment>,
}

fn study() -> Studied {
    let study = zwidth_testing::study();
    Studied { about: About::of(&study), environments: study.environments }
}

/// A movement from −45° to 35° with a force of 3 N.
fn trial(source: Source, signals: &[Signal]) -> Trial {
    let mut samples = Samples::default();
    samples.set(Signal::Time, (0..81).map(f64::from).collect());
    for signal in signals {
        let value = |i: i32| match signal {
            Signal::Theta => f64::from(i - 45).to_radians(),
            _ => 3.0,
        };
        samples.set(*signal, (0..81).map(value).collect());
    }
    let meta = TrialMeta {
        environment: "spring_wall".parse().unwrap(),
        source,
        ..zwidth_testing::meta(1, "active")
    };
    Trial { meta, file: Default::default(), samples }
}

/// The mean of `trial` alone, against time and against the angle, as the stage `average` names its
/// columns.
fn average(trial: &Trial) -> Table {
    let column = |name, signal| {
        let values = trial.samples.get(signal).unwrap().iter().copied().map(Some);
        Column::float(name, "", "", values.collect::<Vec<_>>())
    };
    let none = |name| Column::float(name, "", "", vec![None; 81]);
    let mut columns = vec![column("t_s", Signal::Time)];
    columns.push(Column::integer("n", "1", "", vec![Some(1); 81]));
    columns.push(column("theta_mean_rad", Signal::Theta));
    columns.push(column("force_ex_mean_n", Signal::ForceEx));
    let bands =
        ["theta_ci_low_rad", "theta_ci_high_rad", "force_ex_ci_low_n", "force_ex_ci_high_n"];
    columns.extend(bands.map(none));
    columns.push(Column::text("participant", "", vec![Some("P01"); 81]));
    columns.push(column("theta_sd_rad", Signal::Theta));
    columns.push(Column::text("branch", "", vec![Some("in"); 81]));
    columns.push(column("theta_rad", Signal::Theta));
    Table::new("average", "Average", columns).unwrap()
}

static STUDY: LazyLock<Studied> = LazyLock::new(study);
static TRIAL: LazyLock<Trial> = LazyLock::new(|| trial(Source::Recorded, &ALL));
static MEAN: LazyLock<Table> = LazyLock::new(|| average(&TRIAL));

fn with_mean() -> EnvironmentData<'static> {
    scene(&STUDY, &TRIAL, Some(&*MEAN))
}

fn without_mean() -> EnvironmentData<'static> {
    scene(&STUDY, &TRIAL, None)
}

fn scene<'a>(
    study: &'a Studied,
    trial: &'a Trial,
    average: Option<&'a Table>,
) -> EnvironmentData<'a> {
    let repeats = vec![Repeat { trial, onset_s: Some(1.0), warped_s: None }];
    EnvironmentData {
        about: &study.about,
        environment: &study.environments[1],
        who: "P01 S01".to_owned(),
        modes: vec![ModeData {
            index: 0,
            label: "Active",
            repeats,
            average,
            loop_average: average,
        }],
        alignment: Alignment::Onset,
        notes: Vec::new(),
    }
}

fn lines(figure: &Figure, panel: usize) -> Vec<&Line> {
    figure.panels[panel].lines().collect()
}

const ALL: [Signal; 3] = [Signal::Theta, Signal::ThetaDot, Signal::ForceEx];

#[test]
fn the_mean_is_dotted_exactly_where_it_lies_past_the_wall() {
    let figure = modes(&with_mean(), &[]).unwrap();
    let curve = lines(&figure, 0).into_iter().find(|l| !l.dotted.is_empty()).unwrap();
    for (theta_deg, dotted) in curve.y.iter().zip(&curve.dotted) {
        assert_eq!(*dotted, *theta_deg >= 26.6, "{theta_deg}");
    }
    assert!(curve.dotted.contains(&true) && curve.dotted.contains(&false));
}

#[test]
fn time_counts_from_onset_and_angles_stand_in_degrees() {
    let figure = modes(&without_mean(), &[]).unwrap();
    let curve = lines(&figure, 0)[0];
    assert!((curve.x[0] + 1.0).abs() < 1e-12);
    assert!((curve.y[0] + 45.0).abs() < 1e-12 && (curve.y[80] - 35.0).abs() < 1e-12);
}

#[test]
fn a_repeat_stands_at_the_times_that_it_was_stretched_to() {
    let stretched: Vec<f64> = (0..81).map(f64::from).collect();
    let mut scene = without_mean();
    scene.modes[0].repeats[0].warped_s = Some(&stretched);
    assert_eq!(lines(&modes(&scene, &[]).unwrap(), 0)[0].x, stretched);
}

#[test]
fn loops_say_what_their_dots_mean() {
    let mut scene = with_mean();
    let twice = scene.modes[0].repeats[0];
    scene.modes[0].repeats.push(twice);
    let notes = |scene: &EnvironmentData| {
        loops(scene.about, std::slice::from_ref(scene)).unwrap().footnotes
    };
    let means = format!("Lines: the one repeat that could be placed (1 trial), {AT_THE_ANGLE}");
    let dots = "; dotted: at the wall or past it";
    let whose = notes(&scene).last().cloned().unwrap();
    assert!(whose.starts_with("*F*: the user's force."), "{whose}");
    assert_eq!(notes(&scene), [format!("{means}{dots}."), whose.clone()]);
    scene.environment = &STUDY.environments[0];
    assert_eq!(notes(&scene), [format!("{means}."), whose], "no wall, no dots");
}

/// What the command line reads for a figure is less than there is.
#[test]
fn figures_of_trials_need_no_more_than_the_signals_and_the_columns_they_name() {
    let mut whole = TRIAL.clone();
    for signal in Signal::all().filter(|s| *s != Signal::Time) {
        let values = whole.samples.get(Signal::Theta).unwrap().to_vec();
        if whole.samples.get(signal).is_none() {
            whole.samples.set(signal, values);
        }
    }
    let mut few = whole.clone();
    few.samples = zwidth_store::Samples::default();
    for signal in SIGNALS.into_iter().chain([Signal::Time]) {
        few.samples.set(signal, whole.samples.get(signal).unwrap().to_vec());
    }
    let all = average(&whole);
    let names = [average_columns(), loop_columns()].concat();
    let columns =
        all.columns().iter().filter(|c| names.iter().any(|name| *name == c.field.name)).cloned();
    let some = Table::new("average", "Average", columns.collect()).unwrap();
    let of = |trial, average| {
        let scene = scene(&STUDY, trial, Some(average));
        let loops = loops(scene.about, std::slice::from_ref(&scene)).unwrap();
        [modes(&scene, &[]).unwrap(), repeats(&scene, &scene.modes[0]), loops]
    };
    assert_eq!(of(&whole, &all), of(&few, &some));
}

/// A number without a unit says so by its name: a count, or names instead of numbers.
#[test]
fn every_axis_with_a_label_has_a_unit() {
    let scene = with_mean();
    let calibration = zwidth_study::Calibration::thesis();
    let figures = [
        modes(&scene, &[]).unwrap(),
        repeats(&scene, &scene.modes[0]),
        loops(scene.about, std::slice::from_ref(&scene)).unwrap(),
        rendering_range(scene.about, &calibration, "", &[]).unwrap(),
    ];
    let axes: Vec<&Axis> =
        figures.iter().flat_map(|f| &f.panels).flat_map(|p| [&p.x, &p.y]).collect();
    let labelled: Vec<_> = axes.into_iter().filter(|a| !a.label.is_empty()).collect();
    assert_eq!(labelled.len(), 18, "6 of modes and repeats each, 2 of loops, 4 of figure 25");
    for axis in labelled {
        assert!(!axis.unit.is_empty(), "{} has no unit", axis.label);
    }
}

/// What runs along the wall is drawn on the wall's line, not under it.
#[test]
fn the_line_of_the_wall_lies_behind_the_data() {
    let scene = with_mean();
    for figure in [modes(&scene, &[]).unwrap(), repeats(&scene, &scene.modes[0])] {
        let of_wall = |l: &Layer| matches!(l, Layer::Reference(_));
        let with_wall: Vec<_> =
            figure.panels.iter().filter(|p| p.layers.iter().any(of_wall)).collect();
        assert_eq!(with_wall.len(), 2, "force against angle, and angle against time");
        assert!(with_wall.iter().all(|p| of_wall(&p.layers[0])));
    }
}

#[test]
fn a_figure_of_means_says_how_they_are_aligned_and_of_how_many_repeats() {
    for (alignment, words, axis) in [
        (Alignment::Onset, "aligned at movement onset", "time since movement onset"),
        (Alignment::Landmarks, "aligned by landmarks", "time since onset, by landmarks"),
    ] {
        let mut scene = EnvironmentData { alignment, ..with_mean() };
        let twice = scene.modes[0].repeats[0];
        scene.modes[0].repeats.push(twice);
        let figure = modes(&scene, &[]).unwrap();
        assert!(figure.footnotes[0].contains(words), "{figure:?}");
        assert_eq!(figure.panels[2].x.label, axis);
        let names: Vec<_> =
            lines(&figure, 0).into_iter().filter_map(|l| l.name.as_deref()).collect();
        assert_eq!(names, ["Active (1 of 2 trials)"]);
    }
    let both = modes(&with_mean(), &[]).unwrap();
    let words =
        "against time aligned at movement onset; force against angle averaged at each angle";
    assert!(both.footnotes[0].contains(words), "{}", both.footnotes[0]);
    let alignment = Alignment::Landmarks;
    let without = EnvironmentData { alignment, ..without_mean() };
    let without = modes(&without, &[]).unwrap();
    assert_eq!(without.panels[2].x.label, "time since movement onset", "there is no mean");
}

#[test]
fn a_figure_without_the_set_point_that_was_recorded_says_so() {
    let says = |scene: &EnvironmentData| {
        let notes = modes(scene, &[]).unwrap().footnotes;
        notes.iter().any(|note| note.contains("reference_rad"))
    };
    assert!(!says(&without_mean()));
    let mut study = study();
    study.about.has_reference = true;
    assert!(says(&scene(&study, &TRIAL, None)));
}

/// A movement that a wall holds half a degree past it, and one that goes far past.
#[test]
fn where_a_mode_stays_near_the_wall_a_panel_shows_what_it_does_there() {
    let up_to = |most_deg: f64| {
        let mut trial = TRIAL.clone();
        let theta: Vec<f64> = trial.samples.get(Signal::Theta).unwrap().to_vec();
        let held = theta.iter().map(|theta| theta.min(most_deg.to_radians())).collect();
        trial.samples.set(Signal::Theta, held);
        trial
    };
    let (held, far) = (up_to(27.1), up_to(33.0));
    let panels = |trial: &Trial| modes(&scene(&STUDY, trial, None), &[]).unwrap().panels;
    assert_eq!(panels(&far).len(), 4, "what lies far past the wall is read as it is");
    let near = panels(&held);
    let Range::Fixed(from, to) = near[4].x.range else { panic!("{:?}", near[4].x) };
    assert!(from < 26.6 && to > 27.1 && to - from < 1.5, "{from} to {to}");
    assert_eq!((near[3].cell.rows, near[4].cell.row), (2, 2));
    assert!(lines(&Figure { panels: near, ..Figure::default() }, 4)[0].dotted.is_empty());
    let one = scene(&STUDY, &held, None);
    let figure = repeats(&one, &one.modes[0]);
    assert_eq!(figure.panels.len(), 4);
    assert!(zwidth_draw::draw(&figure).is_ok());
    let free = EnvironmentData { environment: &STUDY.environments[0], ..one };
    assert_eq!(modes(&free, &[]).unwrap().panels.len(), 4, "no wall");
}

#[test]
fn figures_of_environments_that_are_compared_have_the_same_axes() {
    let mut slow = TRIAL.clone();
    let force = slow.samples.get(Signal::ForceEx).unwrap().iter().map(|f| 2.0 * f).collect();
    slow.samples.set(Signal::ForceEx, force);
    let (spring, wall) = (scene(&STUDY, &slow, None), without_mean());
    let ranges = |figure: Figure| -> Vec<Range> {
        figure.panels.iter().take(4).flat_map(|panel| [panel.x.range, panel.y.range]).collect()
    };
    let first = ranges(modes(&spring, std::slice::from_ref(&wall)).unwrap());
    assert_eq!(first, ranges(modes(&wall, std::slice::from_ref(&spring)).unwrap()));
    assert_eq!(first[3], Range::Holding(3.0, 6.0), "the forces of both");
}

/// In print without colour the modes are told apart by their dashes.
#[test]
fn modes_differ_by_their_dashes_and_environments_of_a_loop_too() {
    let mut scene = with_mean();
    for index in [1, 2] {
        scene.modes.push(ModeData { index, ..scene.modes[0].clone() });
    }
    let figure = modes(&scene, &[]).unwrap();
    // of the velocity there is no mean here
    for panel in [0, 1, 3] {
        let means = lines(&figure, panel).into_iter().filter(|line| line.name.is_some());
        let mut dashes: Vec<style::Dash> = means.map(|line| line.stroke.dash).collect();
        dashes.dedup();
        assert_eq!(dashes.len(), 3, "panel {panel}");
    }
}

#[test]
fn a_mean_without_a_band_draws_none() {
    let figure = modes(&with_mean(), &[]).unwrap();
    assert!(!figure.panels.iter().flat_map(|p| &p.layers).any(|l| matches!(l, Layer::Band(_))));
}

#[test]
fn a_signal_that_was_not_recorded_leaves_a_panel_that_says_so() {
    let trial = trial(Source::Imported, &[Signal::ThetaDot, Signal::TorqueEx]);
    let figure = modes(&scene(&STUDY, &trial, None), &[]).unwrap();
    assert_eq!(figure.panels[0].note.as_deref(), Some("no angle was recorded"));
    assert_eq!(figure.panels[3].note.as_deref(), Some("no angle was recorded"));
    assert_eq!(figure.panels[1].y.unit, "N·m", "torque stays torque");
}

#[test]
fn every_figure_of_a_simulated_trial_says_so_and_none_of_a_measured_one() {
    for (source, marked) in
        [(Source::Twin, true), (Source::Recorded, false), (Source::Imported, false)]
    {
        let trial = trial(source, &ALL);
        let scene = scene(&STUDY, &trial, None);
        let figures = [
            modes(&scene, &[]).unwrap(),
            repeats(&scene, &scene.modes[0]),
            loops(scene.about, std::slice::from_ref(&scene)).unwrap(),
        ];
        assert!(figures.iter().all(|f| f.mark.is_some() == marked), "{source:?}");
    }
}

#[test]
fn stars_and_underscores_in_names_are_no_markup() {
    let mut study = study();
    study.environments[1].label = "a*b*_c".to_owned();
    let figure = modes(&scene(&study, &TRIAL, None), &[]).unwrap();
    assert!(zwidth_draw::markup::plain(&figure.title.unwrap()).ends_with("a*b*_c (P01\u{a0}S01)"));
}
