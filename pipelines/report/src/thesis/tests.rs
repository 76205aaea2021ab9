//! The statements judged by hand-made studies.

use super::{replayed_columns, statements, told};
use crate::columns::metric_columns;
use crate::evidence::{Derived, Known, notes};
use crate::gallery::Gallery;
use std::borrow::Cow;
use std::collections::BTreeSet;
use zwidth_results::{
    Causality, ClaimVerdict, GivenAnswer, JudgedStatement, ModelPlant, ReplayedModel, Row as _,
    TrialKey,
};
use zwidth_study::{Basis, Calibration, Coordinate, Setup, Source};
use zwidth_tables::{Column, Measured, Table};

/// A trial: participant, environment, mode, and its numbers by column.
type Trial<'a> = (&'a str, &'a str, &'a str, &'a [(&'static str, f64)]);

/// So many numbers of a trial, by column.
type Numbers<const N: usize> = [(&'static str, f64); N];

const COLUMNS: [&str; 20] = [
    "stiffness_n_per_rad",
    "saturation_force_n",
    "discrepancy_user_mean_n",
    "discrepancy_user_step_n",
    "returned_energy_share",
    "return_force_n",
    "theta_max_rad",
    "onset_s",
    "reversal_s",
    "end_s",
    "wall_past_max_rad",
    "wall_still_s",
    "wall_force_max_n",
    "wall_force_rise_n",
    "peak_error_rad",
    "peak_time_error_s",
    "discrepancy_actuator_mean_n",
    "discrepancy_actuator_step_n",
    "velocity_sd_ratio",
    "velocity_nrmse",
];

/// Metrics of trials, and what replays driven by force say of them, in one table.
fn trials(of: &[Trial], source: &str) -> Table {
    let key = |(number, trial): (u32, &Trial)| TrialKey {
        participant: trial.0.parse().unwrap(),
        session: "S01".parse().unwrap(),
        trial: number,
        repeat: number,
        environment: trial.1.parse().unwrap(),
        mode: trial.2.parse().unwrap(),
        source: Source::from_word(source).unwrap(),
    };
    let mut columns = TrialKey::columns(&(1..).zip(of).map(key).collect::<Vec<_>>());
    let by_eye = ReplayedModel { causality: Causality::ForceDriven, model: ModelPlant::ByEye };
    columns.extend(ReplayedModel::columns(&vec![by_eye; of.len()]));
    columns.push(Column::text("recorded_stability", "", of.iter().map(|_| Some("smooth"))));
    columns.push(Column::integer("wall_brake_releases", "1", "", of.iter().map(|_| Some(1))));
    let value = |trial: &Trial, name: &str| {
        trial.3.iter().find(|(column, _)| *column == name).map(|(_, value)| *value)
    };
    columns.extend(
        COLUMNS.map(|name| Column::float(name, "1", "", of.iter().map(|t| value(t, name)))),
    );
    Table::new("metrics", "", columns).unwrap()
}

fn study() -> Setup {
    Setup::of(&zwidth_testing::study())
}

fn judged(
    study: &Setup,
    metrics: Option<&Table>,
    answers: Option<&[GivenAnswer]>,
) -> Vec<JudgedStatement> {
    let gallery = Gallery {
        figures: BTreeSet::from(["modes.P01.S01.spring".to_owned()]),
        only_session: Some(["P01", "S01"].map(str::to_owned)),
        ..Gallery::default()
    };
    let calibration = Calibration::thesis();
    // As they are read from their files: what is looked at and not listed is not there.
    let read = |all: &Table, listed: &[Cow<str>]| {
        let columns = all.columns().iter().filter(|column| listed.contains(&column.field.name));
        Measured::of(Table::new(all.name(), "", columns.cloned().collect()).unwrap()).unwrap()
    };
    let keys = TrialKey::fields().into_iter().map(|field| field.name);
    let listed: Vec<_> = keys.chain(metric_columns().into_iter().map(Cow::from)).collect();
    let replays = metrics.map(|all| read(all, &replayed_columns()));
    let metrics = metrics.map(|all| read(all, &listed));
    let known = Known { study, calibration: &calibration, metrics: metrics.as_ref() };
    let derived = Derived {
        known,
        basis: Basis::Swept,
        replays: replays.as_ref(),
        answers,
        tally: None,
        gallery: &gallery,
        level: 0.95,
    };
    statements(&derived).unwrap()
}

/// The statement of that key.
fn of<'a>(statements: &'a [JudgedStatement], key: &str) -> &'a JudgedStatement {
    statements.iter().find(|statement| statement.key == key).unwrap()
}

/// What is to be said of it.
fn remark(statements: &[JudgedStatement], key: &str) -> String {
    of(statements, key).remark.as_ref().map(ToString::to_string).unwrap_or_default()
}

fn verdict(statements: &[JudgedStatement], key: &str) -> &'static str {
    of(statements, key).verdict.as_str()
}

/// Three trials of one participant whose largest angles are these, in degrees.
fn angles(mode: &'static str, degrees: [f64; 3]) -> Vec<(&'static str, Numbers<1>)> {
    degrees.map(|d: f64| (mode, [("theta_max_rad", d.to_radians())])).to_vec()
}

fn of_angles(all: &[(&'static str, Numbers<1>)]) -> Table {
    let of: Vec<Trial> = all.iter().map(|(mode, v)| ("P01", "spring", *mode, &v[..])).collect();
    trials(&of, "recorded")
}

#[test]
fn a_number_within_its_range_supports_and_one_outside_contradicts() {
    let metrics = of_angles(
        &[angles("passive", [39.0, 40.0, 41.0]), angles("hybrid", [50.0, 51.0, 52.0])].concat(),
    );
    let table = judged(&study(), Some(&metrics), None);
    assert_eq!(verdict(&table, "passive_stops"), "supported");
    assert_eq!(verdict(&table, "hybrid_turns"), "contradicted");
    let stops = of(&table, "passive_stops");
    assert_eq!(stops.unit_of_analysis.as_deref(), Some("trials of P01"));
    assert_eq!(stops.unit.as_deref(), Some("°"));
    assert_eq!(stops.shown.as_deref(), Some("figures/modes.P01.S01.spring.png"));
    let value = stops.value.unwrap();
    assert!((value - 40.0).abs() < 1e-9, "{value}");
    assert_eq!(stops.n, Some(3));
}

#[test]
fn an_interval_that_reaches_over_the_edge_leaves_it_undecided() {
    let table = judged(&study(), Some(&of_angles(&angles("passive", [34.0, 40.0, 46.0]))), None);
    assert_eq!(verdict(&table, "passive_stops"), "undecided");
    let one = of_angles(&angles("passive", [40.0; 3])[..1]);
    let table = judged(&study(), Some(&one), None);
    assert_eq!(verdict(&table, "passive_stops"), "undecided");
    assert!(remark(&table, "passive_stops").contains("no interval"));
}

#[test]
fn what_a_study_does_not_hold_is_not_measured_and_it_is_said_why() {
    let table = judged(&study(), Some(&of_angles(&angles("passive", [40.0; 3]))), None);
    assert_eq!(verdict(&table, "hybrid_turns"), "not measured");
    assert_eq!(remark(&table, "hybrid_turns"), "there is no trial of hybrid, spring");
    assert!(remark(&table, "passive_renders").starts_with("no trial has a value"));
    assert_eq!(verdict(&table, "active_above_hybrid"), "not measured");
    let mut foreign = study();
    foreign.modes.retain(|mode| mode.id.as_str() == "hybrid");
    let table = judged(&foreign, None, None);
    let remark = remark(&table, "passive_stops");
    assert_eq!(remark, "the study has no mode with a brake alone");
}

#[test]
fn a_study_without_modes_of_known_actuators_has_no_verdict_at_all() {
    let mut foreign = study();
    foreign.masses = None;
    for mode in &mut foreign.modes {
        (mode.motor_max_v, mode.brake_max_v) = (None, None);
    }
    let table = judged(&foreign, Some(&of_angles(&angles("passive", [40.0; 3]))), None);
    assert!(table.iter().all(|of| of.verdict == ClaimVerdict::NotMeasured), "{table:?}");
    let (counts, judged) = told(&table, &[]);
    assert!(counts.contains("0 are supported") && judged.is_empty(), "{counts}");
}

#[test]
fn the_thesis_numbers_are_not_asked_of_another_spring_or_of_lengths() {
    let metrics = of_angles(&angles("passive", [39.0, 40.0, 41.0]));
    let mut weak = study();
    weak.modes[1].brake_max_v = Some(5.0);
    let table = judged(&weak, Some(&metrics), None);
    assert!(remark(&table, "passive_stops").contains("these are others"));
    let mut slide = study();
    slide.coordinate = Coordinate::Linear { lever_m: 1.0 };
    let table = judged(&slide, Some(&metrics), None);
    assert!(remark(&table, "passive_stops").contains("lengths"));
}

/// Way back of 1.5 ± 0.1 s with the hybrid and of 1.2 ± 0.1 s with the motor, as in the thesis; the
/// way in is as long.
#[test]
fn modes_are_compared_within_each_participant_where_there_are_several() {
    let numbers: Vec<(&str, &str, Numbers<3>)> = ["P01", "P02", "P03", "P04"]
        .iter()
        .zip([0.0, 0.5, 0.1, 0.3])
        .flat_map(|(who, slow)| {
            let of = |mode, back: f64| {
                (*who, mode, [("onset_s", slow), ("reversal_s", slow + 1.0), ("end_s", back)])
            };
            [of("active", slow + 2.2), of("hybrid", 1.1 * slow + 2.5)]
        })
        .collect();
    let all: Vec<Trial> = numbers.iter().map(|(w, m, v)| (*w, "spring", *m, &v[..])).collect();
    let table = judged(&study(), Some(&trials(&all, "recorded")), None);
    assert_eq!(verdict(&table, "hybrid_slower_return"), "supported");
    let slower = of(&table, "hybrid_slower_return");
    assert_eq!(slower.unit_of_analysis.as_deref(), Some("participants"));
    assert!(slower.metric.as_ref().unwrap().ends_with("hybrid − active"));
    assert_eq!(verdict(&table, "hybrid_earlier_reversal"), "contradicted");
    assert!(remark(&table, "hybrid_earlier_reversal").contains("alike"));
}

#[test]
fn a_brake_that_never_let_go_in_a_few_trials_leaves_sometimes_open() {
    let past = [("wall_past_max_rad", 0.004), ("wall_still_s", 0.6), ("wall_force_max_n", 8.0)];
    let six: [Trial; 6] = [("P01", "spring_wall", "hybrid", &past); 6];
    let table = judged(&study(), Some(&trials(&six, "recorded")), None);
    for key in ["wall_lets_go", "brake_lets_go_again"] {
        assert_eq!(verdict(&table, key), "undecided");
        assert_eq!(remark(&table, key), "0 of 6 trials");
    }
    // R: binom.test(0, 6)$conf.int
    let high = of(&table, "wall_lets_go").ci_high.unwrap();
    assert!((high - 45.925_812_64).abs() < 1e-6, "{high}");
}

#[test]
fn the_motor_s_force_at_48_v_is_held_against_the_brake_and_against_what_people_put_on_the_wall() {
    let of = |newton: f64| {
        let forces = [newton, newton + 0.2, newton - 0.2].map(|n| [("wall_force_max_n", n)]);
        let of: Vec<Trial> =
            forces.iter().map(|f| ("P01", "spring_wall", "passive", &f[..])).collect();
        judged(&study(), Some(&trials(&of, "recorded")), None)
    };
    // 0.26 N/V: 4.16 N at 16 V, 12.48 N at 48 V
    let table = of(8.0);
    assert_eq!(verdict(&table, "motor_force"), "supported");
    assert_eq!(verdict(&table, "short_of_brake"), "supported");
    assert_eq!(verdict(&table, "short_of_wall"), "contradicted", "12.48 N hold 8 N");
    assert_eq!(verdict(&table, "force_below_brake"), "supported");
    let table = of(13.4);
    assert_eq!(verdict(&table, "short_of_wall"), "supported");
}

fn answers(of: &[(&str, &str, [i16; 3])]) -> Vec<GivenAnswer> {
    let answer = |who: &str, mode: &str, value: i16| GivenAnswer {
        participant: who.parse().unwrap(),
        session: "S01".parse().unwrap(),
        trial: 1,
        environment: "spring".parse().unwrap(),
        mode: mode.parse().unwrap(),
        question: "felt_spring".parse().unwrap(),
        answer: value.into(),
        answer_time_s: None,
        counts: true,
        why_not: None,
    };
    of.iter().flat_map(|(who, mode, values)| values.map(|v| answer(who, mode, v))).collect()
}

#[test]
fn answers_of_one_person_are_ranked_without_an_interval_and_those_of_several_with_one() {
    let one = answers(&[
        ("P01", "active", [5, 5, 4]),
        ("P01", "hybrid", [4, 4, 4]),
        ("P01", "passive", [4, 4, 5]),
    ]);
    let table = judged(&study(), None, Some(&one));
    assert_eq!(verdict(&table, "active_above_hybrid"), "supported");
    let above = of(&table, "active_above_hybrid");
    assert_eq!(above.unit_of_analysis.as_deref(), Some("answers of P01"));
    assert!(remark(&table, "active_above_hybrid").starts_with("9 pairs, no interval"));
    assert_eq!(verdict(&table, "hybrid_above_passive"), "contradicted");
    let several = answers(&[
        ("P01", "active", [5, 5, 4]),
        ("P01", "hybrid", [4, 4, 4]),
        ("P02", "active", [2, 2, 3]),
        ("P02", "hybrid", [4, 4, 1]),
        ("P03", "active", [3, 3, 3]),
        ("P03", "hybrid", [3, 3, 2]),
    ]);
    let table = judged(&study(), None, Some(&several));
    assert_eq!(verdict(&table, "active_above_hybrid"), "undecided");
    let above = of(&table, "active_above_hybrid");
    assert_eq!(above.unit_of_analysis.as_deref(), Some("participants"));
}

#[test]
fn mechanics_against_perception_needs_both() {
    let like = [angles("active", [33.0, 33.1, 32.9]), angles("hybrid", [32.0, 32.1, 31.9])];
    let metrics = of_angles(&like.concat());
    let above = answers(&[("P01", "active", [5, 5, 5]), ("P01", "hybrid", [4, 4, 4])]);
    let table = judged(&study(), Some(&metrics), Some(&above));
    assert_eq!(verdict(&table, "mechanics_against_perception"), "supported");
    let below = answers(&[("P01", "active", [3, 3, 3]), ("P01", "hybrid", [4, 4, 4])]);
    let table = judged(&study(), Some(&metrics), Some(&below));
    assert_eq!(verdict(&table, "mechanics_against_perception"), "contradicted");
    let table = judged(&study(), Some(&metrics), None);
    assert_eq!(verdict(&table, "mechanics_against_perception"), "not measured");
}

#[test]
fn each_judged_statement_is_told_with_its_number_its_interval_its_n_and_where_it_is_seen() {
    let all = angles("passive", [39.0, 40.0, 41.0]);
    let of: Vec<Trial> = all.iter().map(|(mode, v)| ("P01", "spring", *mode, &v[..])).collect();
    let trials = trials(&of, "twin");
    let table = judged(&study(), Some(&trials), None);
    let (counts, judged) = told(&table, &notes(Some(&Measured::of(trials).unwrap())));
    assert!(counts.starts_with("Of ") && counts.contains("simulated"), "{counts}");
    assert!(counts.contains("those of one participant, P01"), "{counts}");
    let found = judged.iter().find(|t| t.text().contains("40°")).unwrap();
    assert_eq!(
        found.text(),
        "With the brake the lever stops at about 40° (§5.3.1.2): supported. Largest angle: 40.0° \
         (interval 37.5 to 42.5; n = 3 trials of P01); asked: 35 to 45°: as read off the thesis' \
         figure, to ±5°."
    );
    assert_eq!(found.path, "figures/modes.P01.S01.spring.png");
}

#[test]
fn a_study_with_nothing_recorded_still_knows_its_forces_and_masses() {
    let table = judged(&study(), None, None);
    let known = table.iter().filter(|of| of.verdict != ClaimVerdict::NotMeasured);
    let known: Vec<&str> = known.map(|of| of.key.as_str()).collect();
    assert_eq!(known, ["motor_force", "short_of_brake", "lighter"]);
}
