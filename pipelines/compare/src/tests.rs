//! Comparisons of small tables, against numbers that R gives for the same data.

use super::*;
use zwidth_results::{GivenAnswer, Row, TrialKey};
use zwidth_stats::null::Sampling;
use zwidth_study::{AnswerValue, Compare, Contrast, Families, Perception, Source};
use zwidth_tables::{Column, NoteKind, Table, of_metric};

/// One trial: participant, session, mode, repeat, value.
pub(crate) type Trial = (&'static str, &'static str, &'static str, u32, Option<f64>);

pub(crate) fn metrics(trials: &[Trial]) -> Measured {
    let key = |(number, of): (u32, &Trial)| TrialKey {
        participant: of.0.parse().unwrap(),
        session: of.1.parse().unwrap(),
        trial: number,
        repeat: of.3,
        environment: "spring".parse().unwrap(),
        mode: of.2.parse().unwrap(),
        source: Source::Recorded,
    };
    let keys: Vec<TrialKey> = (1..).zip(trials).map(key).collect();
    measured(&keys, trials.iter().map(|t| t.4))
}

/// The steps of trials.
pub(crate) fn measured(trials: &[TrialKey], steps: impl Iterator<Item = Option<f64>>) -> Measured {
    let mut columns = TrialKey::columns(trials);
    columns.push(Column::float("step_n", "N", "a step", steps));
    Measured::of(Table::new("metrics", "", columns).unwrap()).unwrap()
}

pub(crate) fn parameters() -> Parameters {
    let mode = |id: &str| id.parse().unwrap();
    let contrast = |with| Contrast { mode: mode("hybrid"), against: mode(with) };
    let step = MetricParameters {
        metric: "step_n".parse().unwrap(),
        chosen_after: None,
        primary: true,
        better: zwidth_study::Better::Lower,
        preregistered: None,
        bounds: vec![None],
        noticed: None,
    };
    Parameters {
        metrics: vec![step],
        environments: vec!["spring".parse().unwrap()],
        modes: ["active", "passive", "hybrid"].map(mode).to_vec(),
        contrasts: ["active", "passive"].map(contrast).to_vec(),
        families: Families::Metric,
        curve_claims: 0,
        alpha: 0.05,
        level: 0.95,
        effect_sizes: Compare::EFFECT_SIZES.to_vec(),
        groups: None,
        covariates: Vec::new(),
        over: None,
        effects: Vec::new(),
        dose_curves: Vec::new(),
        orders: Vec::new(),
    }
}

/// Four people, two repeats of each mode; P04 has no passive.
pub(crate) fn four() -> Vec<Trial> {
    let person = |who, values: &[(&'static str, [f64; 2])]| {
        let trials = values.iter().flat_map(|(mode, values)| {
            (1..).zip(values).map(move |(repeat, v)| (who, "S01", *mode, repeat, Some(*v)))
        });
        trials.collect::<Vec<Trial>>()
    };
    [
        person("P01", &[("active", [1.0, 1.2]), ("passive", [2.0, 2.2]), ("hybrid", [1.6, 1.4])]),
        person("P02", &[("active", [0.8, 1.0]), ("passive", [2.4, 2.2]), ("hybrid", [1.5, 1.7])]),
        person("P03", &[("active", [1.4, 1.2]), ("passive", [1.8, 2.0]), ("hybrid", [1.9, 1.9])]),
        person("P04", &[("active", [1.1, 1.3]), ("hybrid", [1.5, 1.3])]),
    ]
    .concat()
}

/// One trial of a participant in either mode.
fn both(who: &'static str, active: f64, hybrid: f64) -> [Trial; 2] {
    [("active", active), ("hybrid", hybrid)].map(|(mode, v)| (who, "S01", mode, 1, Some(v)))
}

/// Four people, and the trials of some of them again in a second session, which differ by this.
fn again(by: impl Fn(&Trial) -> Option<f64>) -> Vec<Trial> {
    let first = four();
    let later = first.iter().filter_map(|t| {
        let by = by(t)?;
        Some((t.0, "S02", t.2, t.3, t.4.map(|v| v + by)))
    });
    let later: Vec<Trial> = later.collect();
    [first, later].concat()
}

/// The only metric's tables, as they are printed.
pub(crate) struct Printed {
    pub(crate) cells: Table,
    pub(crate) means: Table,
    pub(crate) contrasts: Table,
    pub(crate) omnibus: Table,
    pub(crate) models: Table,
    pub(crate) participants: Table,
    pub(crate) sessions: Table,
    pub(crate) learning: Table,
    pub(crate) orders: Table,
}

pub(crate) fn compare(
    metrics: &Measured,
    parameters: &Parameters,
) -> Result<Printed, CompareError> {
    fn printed<R: Row>(found: &Comparison, rows: &[R]) -> Result<Table, CompareError> {
        Ok(of_metric(&Table::of_rows(rows)?, &found.metrics[0], &found.notes)?)
    }
    let found = super::compare(metrics, parameters)?;
    Ok(Printed {
        cells: printed(&found, &found.cells)?,
        means: printed(&found, &found.means)?,
        contrasts: printed(&found, &found.contrasts)?,
        omnibus: printed(&found, &found.omnibus)?,
        models: printed(&found, &found.models)?,
        participants: printed(&found, &found.participants)?,
        sessions: printed(&found, &found.sessions)?,
        learning: printed(&found, &found.learning)?,
        orders: printed(&found, &found.orders)?,
    })
}

fn floats(table: &Table, column: &str) -> Vec<f64> {
    table.floats(column).unwrap().into_iter().map(|v| v.unwrap_or(f64::NAN)).collect()
}

fn near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= 2e-8 * expected.abs().max(1e-3), "{found} {expected}");
    }
}

/// R: `t.test(c(1.5,1.6,1.9,1.4) - c(1.1,.9,1.3,1.2))` and, without P04,
/// `t.test(c(1.5,1.6,1.9) - c(2.1,2.3,1.9))`; `p.adjust(…, "holm")`.
#[test]
fn each_participant_gives_one_difference_and_who_lacks_a_mode_leaves_that_contrast() {
    let compared = compare(&metrics(&four()), &parameters()).unwrap();
    let table = &compared.contrasts;
    assert_eq!(table.integers("n").unwrap(), [Some(4), Some(3)]);
    near(&floats(table, "difference_n"), &[0.475, -0.433_333_333_333_333]);
    near(&floats(table, "difference_ci_low_n"), &[0.122_169_214_106_93, -1.373_812_692_225_08]);
    near(&floats(table, "p_value"), &[0.023_365_405_115_362_9, 0.185_908_421_589_306]);
    near(&floats(table, "p_adjusted"), &[0.046_730_810_230_725_8, 0.185_908_421_589_306]);
    let left_out = table.notes().iter().find(|note| note.contains("P04")).unwrap();
    assert_eq!(left_out, "spring, hybrid − passive: without P04 (no trial of passive).");
    assert_eq!(table.texts("unit_of_analysis").unwrap()[0].as_deref(), Some("participants"));
}

/// P01's trials of passive have no value; P02 has passive and hybrid, but in two sessions; P04 has
/// no passive at all.
#[test]
fn the_note_on_who_is_left_out_says_what_each_of_them_lacks() {
    let mut trials = four();
    for trial in &mut trials {
        match (trial.0, trial.2) {
            ("P01", "passive") => trial.4 = None,
            ("P02", "passive") => trial.1 = "S02",
            _ => {}
        }
    }
    let table = compare(&metrics(&trials), &parameters()).unwrap().contrasts;
    let left_out = table.notes().iter().find(|note| note.contains("without P")).unwrap();
    assert_eq!(
        left_out,
        "spring, hybrid − passive: without P02 (no session with both modes); P04 (no trial of \
         passive); P01 (no trial of passive with step_n)."
    );
}

/// Six people whose hybrid is 0, 1, 1, 2, 3 and 4 above their active.
#[test]
fn a_difference_of_zero_raises_the_smallest_p_of_the_exact_tests_and_the_note_says_how_far() {
    let people = ["P01", "P02", "P03", "P04", "P05", "P06"];
    let trials: Vec<Trial> = people
        .into_iter()
        .zip([0.0, 1.0, 1.0, 2.0, 3.0, 4.0])
        .flat_map(|(who, apart)| both(who, 1.0, 1.0 + apart))
        .collect();
    let table = compare(&metrics(&trials), &parameters()).unwrap().contrasts;
    near(&floats(&table, "p_sign_flip"), &[0.0625]);
    near(&floats(&table, "p_signed_rank"), &[0.0625]);
    let note = "spring, hybrid − active: 1 of 6 differences is 0, and a zero has no sign. So no exact test \
                (sign flip, signed rank) has a p below 0.0625; without zeros it could be 0.03125.";
    assert!(table.notes().iter().any(|n| n == note), "{:?}", table.notes());
    let whole = compare(&metrics(&whole_study()), &parameters()).unwrap().contrasts;
    assert!(whole.notes().iter().all(|note| !note.contains("has no sign")));
}

/// 6 people, 3 modes and 6 repeats whose people differ less than their repeats.
#[test]
fn where_a_variance_is_zero_the_note_explains_the_two_degrees_of_freedom() {
    let people = ["P01", "P02", "P03", "P04", "P05", "P06"];
    let mut trials = Vec::new();
    for (p, who) in people.into_iter().enumerate() {
        for (m, mode) in ["active", "passive", "hybrid"].into_iter().enumerate() {
            for repeat in 0..6_u32 {
                // Every participant's repeats are the same six numbers, in another order.
                let place = (p + m + repeat as usize) % 6;
                let value = m as f64 + 0.1 * place as f64;
                trials.push((who, "S01", mode, repeat, Some(value)));
            }
        }
    }
    let models = compare(&metrics(&trials), &parameters()).unwrap().models;
    near(&floats(&models, "df"), &[10.0, 10.0]);
    near(&floats(&models, "df_satterthwaite"), &[105.0, 105.0]);
    let note = models.notes().iter().find(|note| note.starts_with("Where singular")).unwrap();
    assert!(note.contains("(here 10.0 and 105.0)"), "{note}");
    assert!(note.ends_with("are Kenward and Roger's, and they count."), "{note}");
}

/// P04 has no passive. Ranks (1, 3, 2), (1, 3, 2), (1, 2.5, 2.5): 12 of the 6³ orders within rows
/// have sums as far apart. SciPy `friedmanchisquare`; F, ε and p by NumPy from their definitions,
/// SciPy's F.
#[test]
fn whether_any_mode_differs_is_told_of_complete_participants() {
    let table = compare(&metrics(&four()), &parameters()).unwrap().omnibus;
    assert_eq!(table.integers("n").unwrap(), [Some(3)]);
    near(&floats(&table, "friedman"), &[5.636363636363634]);
    near(&floats(&table, "kendall_w"), &[0.939393939393939]);
    near(&floats(&table, "p_friedman"), &[12.0 / 216.0]);
    near(&floats(&table, "f"), &[13.857142857142863]);
    near(&floats(&table, "p_f"), &[0.015907799691583464]);
    near(&floats(&table, "epsilon_gg"), &[0.6153254741158383]);
    near(&floats(&table, "p_gg"), &[0.046604181707783535]);
    near(&floats(&table, "epsilon_hf"), &[1.0]);
}

#[test]
fn one_participant_has_no_test_of_any_difference_over_participants() {
    let trials: Vec<Trial> = four().into_iter().filter(|trial| trial.0 == "P01").collect();
    assert_eq!(compare(&metrics(&trials), &parameters()).unwrap().omnibus.height(), 0);
}

#[test]
fn one_participant_speaks_of_trials_and_of_nobody_else() {
    let trials: Vec<Trial> = four().into_iter().filter(|trial| trial.0 == "P01").collect();
    let compared = compare(&metrics(&trials), &parameters()).unwrap();
    let units = compared.contrasts.texts("unit_of_analysis").unwrap();
    assert_eq!(units, [Some("trials of P01".to_owned()), Some("trials of P01".to_owned())]);
    assert_eq!(compared.contrasts.integers("n").unwrap(), [Some(4), Some(4)]);
    assert!(compared.contrasts.notes()[0].contains("nothing is said of anybody else"));
    assert!(compared.contrasts.column("d_av").is_err());
}

#[test]
fn repeats_do_not_count_as_people_and_sessions_have_equal_weight() {
    let mut trials = four();
    // A second session of P01 with many repeats: one mean, as the first.
    for repeat in 1..=9 {
        trials.push(("P01", "S02", "active", repeat, Some(3.0 + 0.1 * repeat as f64)));
        trials.push(("P01", "S02", "hybrid", repeat, Some(4.0 + 0.1 * repeat as f64)));
    }
    let compared = compare(&metrics(&trials), &parameters()).unwrap();
    assert_eq!(compared.contrasts.integers("n").unwrap(), [Some(4), Some(3)]);
    let first = floats(&compared.participants, "difference_n")[0];
    assert!((first - (0.4 + 1.0) / 2.0).abs() < 1e-12, "{first}");
    assert_eq!(compared.participants.integers("sessions").unwrap()[0], Some(2));
}

#[test]
fn a_trial_without_the_metric_does_not_count_and_is_told() {
    let mut trials = four();
    trials.push(("P02", "S01", "hybrid", 3, None));
    let compared = compare(&metrics(&trials), &parameters()).unwrap();
    let note = "spring × hybrid: 8 of 9 trials have the metric; the mean is among those.";
    assert!(compared.means.notes().iter().any(|n| n == note), "{:?}", compared.means.notes());
    let whole = compare(&metrics(&four()), &parameters()).unwrap();
    assert_eq!(floats(&compared.means, "mean_n"), floats(&whole.means, "mean_n"));
}

#[test]
fn sessions_are_compared_person_by_person() {
    let changes = [("P01", 0.1), ("P02", 0.2), ("P03", 0.3)];
    let trials = again(|t| Some(changes.iter().find(|(who, _)| *who == t.0)?.1));
    let sessions = compare(&metrics(&trials), &parameters()).unwrap().sessions;
    assert_eq!(sessions.height(), 3);
    near(&floats(&sessions, "change_n"), &[0.2; 3]);
    assert_eq!(sessions.integers("n").unwrap(), [Some(3); 3]);
    assert_eq!(sessions.texts("sessions").unwrap()[0].as_deref(), Some("S02 − S01"));
}

/// P04 comes once: changes are of three, the agreement of the hybrid mode is of all four.
#[test]
fn who_lacks_a_session_counts_for_agreement_and_not_for_change() {
    let changes = [("P01", [0.1, -0.2]), ("P02", [0.3, 0.1]), ("P03", [-0.1, 0.2])];
    let trials = again(|t| {
        let own = changes.iter().find(|(who, _)| *who == t.0 && t.2 == "hybrid")?;
        Some(own.1[t.3 as usize - 1])
    });
    let sessions = compare(&metrics(&trials), &parameters()).unwrap().sessions;
    assert_eq!(sessions.integers("n").unwrap(), [Some(3)]);
    assert!(sessions.notes()[0].contains("those who lack a session"), "{:?}", sessions.notes());
    let all = [
        vec![Some(1.45), Some(1.5)],
        vec![Some(1.8), Some(1.6)],
        vec![Some(1.95), Some(1.9)],
        vec![None, Some(1.4)],
    ];
    let sampling = Sampling { draws: 999, seed: 1 };
    let expected = zwidth_stats::incomplete::incomplete_agreement(&all, 0.95, sampling).unwrap();
    near(&floats(&sessions, "icc_a1"), &[expected.agreement.a1.estimate]);
    near(&floats(&sessions, "icc_a1_ci_low"), &[expected.agreement.a1.ci_low]);
}

/// Of three sessions P04 lacks the last.
#[test]
fn three_sessions_have_one_icc_beside_those_of_the_pairs() {
    let mut trials = Vec::new();
    for (p, who) in ["P01", "P02", "P03", "P04"].into_iter().enumerate() {
        for (s, session) in ["S01", "S02", "S03"].into_iter().enumerate() {
            let value = 0.4 * p as f64 + 0.05 * ((p * 37 + s * s * 53 + p * s * 11) % 17) as f64;
            if (p, s) != (3, 2) {
                trials.push((who, session, "hybrid", 1, Some(value)));
            }
        }
    }
    let table = |trials: &[Trial]| compare(&metrics(trials), &parameters()).unwrap().sessions;
    let means: Vec<Vec<Option<f64>>> = (0..4)
        .map(|p| (0..3).map(|s| trials.get(p * 3 + s).and_then(|trial| trial.4)).collect())
        .collect();
    let sampling = Sampling { draws: 999, seed: 1 };
    let expected = zwidth_stats::incomplete::incomplete_agreement(&means, 0.95, sampling).unwrap();
    let expected = expected.agreement.a1;
    let sessions = table(&trials);
    assert_eq!(sessions.height(), 2);
    near(&floats(&sessions, "icc_a1_all"), &[expected.estimate; 2]);
    near(&floats(&sessions, "icc_a1_all_ci_low"), &[expected.ci_low; 2]);
    near(&floats(&sessions, "icc_a1_all_ci_high"), &[expected.ci_high; 2]);
    assert!(sessions.notes().iter().any(|note| note.starts_with("icc_a1_all is one number")));

    // Of two sessions the pair is all there is.
    trials.retain(|trial| trial.1 != "S03");
    assert!(table(&trials).column("icc_a1_all").is_err());
}

#[test]
fn a_change_from_repeat_to_repeat_is_each_participants_slope() {
    let learning = compare(&metrics(&four()), &parameters()).unwrap().learning;
    // active: +0.2, +0.2, −0.2, +0.2
    near(&floats(&learning, "change_n")[..1], &[0.1]);
    assert_eq!(learning.integers("n").unwrap()[0], Some(4));
}

#[test]
fn differences_that_are_all_rounding_or_all_equal_have_no_test_and_say_why() {
    // Each pair is one number, computed in two ways.
    let rounding =
        [both("P01", 0.1 + 0.2, 0.3), both("P02", 0.7 + 0.1, 0.8), both("P03", 0.5, 0.5)];
    let equal = ["P01", "P02", "P03"].map(|who| both(who, 1.0, 2.0));
    for (trials, difference, words) in [
        (rounding, 0.0, "there is no difference beyond the rounding of the values"),
        (equal, 1.0, "all differences are equal, so nothing tells how far they scatter"),
    ] {
        let contrasts = compare(&metrics(&trials.concat()), &parameters()).unwrap().contrasts;
        assert_eq!(floats(&contrasts, "difference_n"), [difference]);
        assert!(contrasts.column("statistic").is_err());
        assert_eq!(contrasts.texts("verdict").unwrap()[0].as_deref(), Some("not tested"));
        assert_eq!(contrasts.texts("remark").unwrap()[0].as_deref(), Some(words));
    }
}

#[test]
fn a_study_without_a_trial_gives_empty_tables() {
    let compared = compare(&metrics(&[]), &parameters()).unwrap();
    let heights = [&compared.cells, &compared.means, &compared.contrasts, &compared.learning]
        .map(Table::height);
    assert_eq!(heights, [0; 4]);
}

/// Six people, three modes, four repeats, two sessions: a study with everything in it.
fn whole_study() -> Vec<Trial> {
    let people = ["P01", "P02", "P03", "P04", "P05", "P06"];
    let mut trials = Vec::new();
    for (p, who) in people.into_iter().enumerate() {
        for (s, session) in ["S01", "S02"].into_iter().enumerate() {
            for (m, mode) in ["active", "passive", "hybrid"].into_iter().enumerate() {
                for repeat in 1..=4 {
                    // Numbers without a pattern, the same on any machine.
                    let place = (p * 37 + s * 53 + m * 71 + repeat as usize * 29) % 17;
                    let value = 1.0 + 0.3 * m as f64 + 0.1 * p as f64 + 0.02 * place as f64;
                    trials.push((who, session, mode, repeat, Some(value)));
                }
            }
        }
    }
    trials
}

#[test]
fn on_complete_data_the_mixed_model_has_the_difference_of_the_participants() {
    let compared = compare(&metrics(&whole_study()), &parameters()).unwrap();
    let [paired, modelled] =
        [&compared.contrasts, &compared.models].map(|table| floats(table, "difference_n"));
    near(&modelled, &paired);
    assert_eq!(compared.models.integers("n").unwrap(), [Some(6), Some(6)]);
    assert_eq!(compared.models.integers("trials").unwrap(), [Some(144), Some(144)]);
    let terms = compared.models.texts("random_terms").unwrap()[0].clone().unwrap();
    assert!(terms.starts_with("participant, participant × mode"), "{terms}");
}

#[test]
fn one_participant_has_no_mixed_model() {
    let trials: Vec<Trial> = whole_study().into_iter().filter(|t| t.0 == "P01").collect();
    assert_eq!(compare(&metrics(&trials), &parameters()).unwrap().models.height(), 0);
}

#[test]
fn sessions_have_limits_and_a_share_of_agreement() {
    let sessions = compare(&metrics(&whole_study()), &parameters()).unwrap().sessions;
    assert_eq!(sessions.height(), 3);
    let of = |name: &str| floats(&sessions, name)[0];
    assert!(of("limit_low_n") < of("change_n") && of("change_n") < of("limit_high_n"));
    assert!(of("icc_a1") > 0.5 && of("icc_a1") <= of("icc_ak"), "{}", of("icc_a1"));
    assert!((of("mdc_n") - 1.96 * 2_f64.sqrt() * of("sem_n")).abs() < 1e-9);
}

/// The comparison of these participants' answers in hybrid and in active.
fn answered(given: &[(&str, &[f64], &[f64])], parameters: &AnswerParameters) -> Table {
    let answer = |who: &str, mode: &str, answer: f64| GivenAnswer {
        participant: who.parse().unwrap(),
        session: "S01".parse().unwrap(),
        trial: 1,
        environment: "spring".parse().unwrap(),
        mode: mode.parse().unwrap(),
        question: "felt".parse().unwrap(),
        answer: AnswerValue::new(answer).unwrap(),
        answer_time_s: None,
        counts: true,
        why_not: None,
    };
    let mut answers = Vec::new();
    for (who, hybrid, active) in given {
        answers.extend(hybrid.iter().map(|value| answer(who, "hybrid", *value)));
        answers.extend(active.iter().map(|value| answer(who, "active", *value)));
    }
    answers_table(&compare_answers(&answers, parameters).unwrap().contrasts, &parameters.contrasts)
        .unwrap()
}

fn answer_parameters() -> AnswerParameters {
    let of = parameters();
    let question = zwidth_study::Question {
        id: "felt".parse().unwrap(),
        text: String::new(),
        group: None,
        reversed: false,
        scale: zwidth_study::AnswerScale::FivePoint,
        label: None,
        is_weight: false,
    };
    AnswerParameters {
        environments: of.environments,
        modes: of.modes,
        questions: vec![question],
        contrasts: of.contrasts[..1].to_vec(),
        level: of.level,
    }
}

/// Pairs by hand: P01 hybrid 4, 3 against active 2, 3: wins 3, ties 1 of 4; P02 hybrid 5, 5 against
/// 5, 4: wins 2, ties 2.
#[test]
fn answers_are_compared_pair_by_pair_within_each_participant() {
    let given: [(&str, &[f64], &[f64]); 2] =
        [("P01", &[4.0, 3.0], &[2.0, 3.0]), ("P02", &[5.0, 5.0], &[5.0, 4.0])];
    let table = answered(&given, &answer_parameters());
    assert_eq!(table.integers("n").unwrap(), [Some(2)]);
    assert_eq!(table.integers("answers").unwrap(), [Some(8)]);
    near(&floats(&table, "superiority"), &[(0.875 + 0.75) / 2.0]);
}

/// With factors modes are not compared by default: the table that is then empty says so.
#[test]
fn without_contrasts_the_table_of_answers_says_why_it_is_empty() {
    let given: [(&str, &[f64], &[f64]); 2] = [("P01", &[4.0], &[2.0]), ("P02", &[5.0], &[4.0])];
    let table =
        answered(&given, &AnswerParameters { contrasts: Vec::new(), ..answer_parameters() });
    assert_eq!(table.height(), 0);
    let mut why = table.notes_by_kind().filter(|(kind, _)| *kind == NoteKind::LeftOut);
    assert!(why.next().is_some_and(|(_, note)| note.contains("kind \"mean\" of one question")));
}

/// A slider's decimals: rounded to whole numbers, P01 would have answered alike in both modes.
#[test]
fn answers_on_a_line_are_compared_by_their_own_numbers() {
    let mut parameters = answer_parameters();
    let line = zwidth_study::NumberScale { points: 101, from: 0, step: 1, labels: Vec::new() };
    parameters.questions[0].scale = zwidth_study::AnswerScale::Numbers(line);
    let table = answered(&[("P01", &[47.25], &[46.75]), ("P02", &[60.5], &[58.0])], &parameters);
    assert_eq!(table.integers("answers").unwrap(), [Some(4)]);
    assert_eq!(table.floats("difference").unwrap(), [Some(1.5)]);
    assert_eq!(table.floats("superiority").unwrap(), [Some(1.0)]);
}

#[test]
fn answers_that_separate_the_modes_have_a_bound_and_a_p_value_in_place_of_an_odds_ratio() {
    let one = |who| -> (&str, &[f64], &[f64]) { (who, &[5.0, 4.0], &[1.0, 2.0]) };
    let table = answered(&["P01", "P02", "P03"].map(one), &answer_parameters());
    assert_eq!(table.floats("odds_ratio").unwrap(), [None]);
    assert_eq!(table.floats("odds_ratio_ci_high").unwrap(), [None]);
    assert!(table.floats("p_value").unwrap()[0].unwrap() < 0.1);
    let remark = table.texts("remark").unwrap()[0].clone().unwrap();
    assert!(remark.starts_with("the answers separate the two modes, so"), "{remark}");
    near(&floats(&table, "superiority"), &[1.0]);
}

/// A force of 4 N has a just noticeable difference of 0.28 N.
#[test]
fn a_difference_has_its_size_in_what_is_just_noticed_from_the_mode_compared_with() {
    let by = |step: f64, scatter: f64| {
        let people = [("P01", -1.0), ("P02", 1.0), ("P03", -0.5), ("P04", 0.5)];
        let trials = people.map(|(who, side)| both(who, 4.0, 4.0 + step + side * scatter));
        let perception = Perception::default();
        let noticed =
            Some(Noticed { perception, lever_m: 0.1, is_slide: false, commanded: vec![None] });
        let mut parameters = parameters();
        parameters.metrics[0].noticed = noticed;
        let table = compare(&metrics(&trials.concat()), &parameters).unwrap().contrasts;
        let size = table.texts("size").unwrap()[0].clone().unwrap();
        (size, floats(&table, "difference_jnd")[0], floats(&table, "jnd_n")[0])
    };
    let (size, in_jnds, jnd_n) = by(0.7, 0.02);
    assert_eq!(size, "felt");
    near(&[in_jnds, jnd_n], &[2.5, 0.28]);
    assert_eq!(by(0.028, 0.02).0, "below what is felt");
    assert_eq!(by(-0.28, 0.1).0, "may be felt");
}

#[test]
fn an_effect_size_stands_beside_the_interval_of_its_d() {
    let table = compare(&metrics(&four()), &parameters()).unwrap().contrasts;
    assert!(table.column("d_av").is_err());
    let ends = (floats(&table, "d_av_ci_low"), floats(&table, "d_av_ci_high"));
    let g = floats(&table, "g_av");
    assert!(ends.0[0] < g[0] && g[0] < ends.1[0], "{g:?} {ends:?}");
    let none = Parameters { effect_sizes: Vec::new(), ..parameters() };
    let table = compare(&metrics(&four()), &none).unwrap().contrasts;
    assert!(table.column("g_av").is_err() && table.column("d_av_ci_low").is_err());
}

/// What the comparison says of the order of modes.
fn order_notes(trials: &[Trial], parameters: &Parameters) -> Vec<String> {
    let found = super::compare(&metrics(trials), parameters).unwrap();
    let limits = found.notes.iter().filter(|note| note.kind == zwidth_results::NoteKind::Limit);
    let notes = limits.map(|note| note.note.to_string());
    notes.filter(|note| note.contains("may be learning")).collect()
}

#[test]
fn modes_in_one_order_for_all_may_differ_by_learning() {
    let one_order = "spring: all had the modes in this order (active, passive, hybrid): the difference may be \
                     learning. `covariates = [\"trial\"]` under [compare] of study.toml sets practice apart as far as \
                     the order lets it.";
    // P04 lacks a mode, and has the others in that order.
    assert_eq!(order_notes(&four(), &parameters()), [one_order]);
    let adjusted = Parameters { over: Some(zwidth_study::OverTrials::Trial), ..parameters() };
    assert_eq!(order_notes(&four(), &adjusted), [""; 0]);
    let imported = SessionOrder {
        participant: "P01".parse().unwrap(),
        session: "S01".parse().unwrap(),
        drawn: None,
    };
    let imported = Parameters { orders: vec![imported], ..parameters() };
    let [hedged] = &order_notes(&four(), &imported)[..] else { panic!() };
    assert!(hedged.contains("by the trials' numbers") && hedged.contains("if that is how"));
}

#[test]
fn an_order_that_differs_between_people_or_is_balanced_within_them_is_not_told() {
    let mut other = four();
    let last = other.len() - 4;
    other[last..].reverse();
    assert_eq!(order_notes(&other, &parameters()), [""; 0], "P04 begins with hybrid");
    let alone: Vec<Trial> = four().into_iter().filter(|trial| trial.0 == "P01").collect();
    assert_eq!(order_notes(&alone, &parameters()), [""; 0], "one person, tested over orders");
    let around = |modes: [&'static str; 4]| -> Vec<Trial> {
        let of = |who: &'static str| {
            let trials = (1..).zip(modes);
            trials.map(move |(i, mode)| (who, "S01", mode, u32::div_ceil(i, 2), Some(f64::from(i))))
        };
        ["P01", "P02", "P03"].into_iter().flat_map(of).collect()
    };
    assert_eq!(
        order_notes(&around(["active", "hybrid", "hybrid", "active"]), &parameters()),
        [""; 0]
    );
    let [told] = &order_notes(&around(["active", "hybrid", "active", "hybrid"]), &parameters())[..]
    else {
        panic!()
    };
    assert!(told.contains("(active, hybrid)"), "{told}");
    // Half of them around the other way are balanced, too; beside a line as well.
    let mut both = around(["active", "hybrid", "hybrid", "active"]);
    both.truncate(8);
    both.extend(around(["hybrid", "active", "active", "hybrid"]).into_iter().skip(8));
    assert_eq!(order_notes(&both, &parameters()), [""; 0]);
    let adjusted = Parameters { over: Some(zwidth_study::OverTrials::Trial), ..parameters() };
    let notes = |trials: &[Trial]| {
        let found = super::compare(&metrics(trials), &adjusted).unwrap();
        found
            .notes
            .iter()
            .filter(|note| note.note.to_string().contains("in the same order"))
            .count()
    };
    assert_eq!(notes(&both), 0);
    assert!(notes(&around(["active", "active", "hybrid", "hybrid"])) > 0);
}

/// Three people had six trials of each of two modes in blocks; one did the first again at the end.
#[test]
fn a_trial_that_was_done_again_hides_no_order() {
    let of = |who: &'static str, again: bool| {
        let trials = (1..=12).map(move |i| {
            let mode = if i <= 6 { "active" } else { "hybrid" };
            (who, "S01", mode, (i - 1) % 6 + 1, Some(f64::from(i % 5)))
        });
        let mut trials: Vec<Trial> = trials.collect();
        if again {
            trials.remove(0);
            trials.push((who, "S01", "active", 1, Some(1.0)));
        }
        trials
    };
    let trials = [of("P01", false), of("P02", true), of("P03", false)].concat();
    let [told] = &order_notes(&trials, &parameters())[..] else { panic!() };
    assert!(told.contains("(active, hybrid)"), "{told}");
}
