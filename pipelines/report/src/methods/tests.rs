use super::*;
use std::collections::BTreeMap;
use zwidth_study::{GroupContrast, GroupsCompared, LevelId, Source};

fn recorded(participants: usize) -> Recorded {
    Recorded {
        participants,
        sessions: participants,
        trials: 36 * participants,
        sampled: true,
        sources: BTreeMap::from([(Source::Twin, 36 * participants)]),
        compared: ["discrepancy_user_mean_n", "duration_s"].map(str::to_owned).to_vec(),
        answers: true,
        replayed: true,
        identified: true,
        ..Recorded::default()
    }
}

fn text(study: &Study, recorded: &Recorded) -> String {
    MethodsForm::Markdown.written(&methods(study, recorded, "1.2.3"))
}

#[test]
fn numbers_of_the_study_stand_in_its_methods() {
    let mut study = zwidth_testing::study();
    study.control.rate_hz = 517.0;
    study.analysis.grid_points = 313;
    study.compare.alpha = 0.013;
    study.design.repeats = 9;
    let said = text(&study, &recorded(3));
    for number in ["517 Hz", "313", "below 0.013", "9 times", "zwidth 1.2.3"] {
        assert!(said.contains(number), "{number} in {said}");
    }
    assert!(said.contains("All data are simulated"), "{said}");
}

#[test]
fn a_rule_for_trials_that_did_not_meet_the_protocol_is_told_with_how_many_of_each_mode_it_befell() {
    let mut study = zwidth_testing::study();
    assert!(!text(&study, &recorded(3)).contains("done again"));
    study.design.redo_unmet = 2;
    let none = text(&study, &recorded(3));
    assert!(none.contains("at most 2 times; this befell no trial."), "{none}");
    let unmet = BTreeMap::from([("Active".to_owned(), 1), ("Passive".to_owned(), 8)]);
    let some = text(&study, &Recorded { unmet, ..recorded(3) });
    let told = "at most 2 times; this befell 1 trial of 'Active', 8 trials of 'Passive'.";
    assert!(some.contains(told), "{some}");
}

#[test]
fn axes_have_their_low_pass_and_their_thresholds_in_the_methods() {
    let mut study = zwidth_testing::study();
    assert!(!text(&study, &recorded(3)).contains("in space"));
    study.axes = Some(zwidth_study::Axes {
        frame: "x right".to_owned(),
        push: [0.0, 0.0, -1.0],
        low_pass_hz: 7.5,
        onset_m_s: 0.03,
        offset_m_s: 0.02,
    });
    let said = text(&study, &recorded(3));
    for words in ["7.5 Hz; Winter 2009", "0.03 m/s", "0.02 m/s", "Wiley"] {
        assert!(said.contains(words), "{words} in {said}");
    }
    assert!(!said.contains("Smoothness"), "there is no θ: {said}");
    let made_by_import = ["theta_rad = (x_m, y_m, z_m) · push".to_owned()].into();
    let projected = text(&study, &Recorded { made_by_import, ..recorded(3) });
    assert!(projected.contains("on the push. A movement began"), "{projected}");
}

#[test]
fn methods_of_groups_name_the_tests_of_groups_alone() {
    let mut study = zwidth_testing::study();
    assert!(text(&study, &recorded(12)).contains("Fisher 1935"));
    let levels: Vec<LevelId> = ["novice", "expert"].map(|id| id.parse().unwrap()).to_vec();
    study.compare.groups = Some(GroupsCompared {
        column: "group".parse().unwrap(),
        contrasts: vec![GroupContrast { group: levels[1].clone(), against: levels[0].clone() }],
        levels,
        assigned: false,
    });
    let said = text(&study, &recorded(12));
    assert!(said.contains("Welch") && said.contains("Satterthwaite"), "{said}");
    for test in ["Fisher 1935", "Wilcoxon", "Edgington"] {
        assert!(!said.contains(test), "{test} in {said}");
    }
}

#[test]
fn of_one_participant_nothing_is_said_of_people() {
    let study = zwidth_testing::study();
    let (one, three) = (text(&study, &recorded(1)), text(&study, &recorded(3)));
    assert!(one.contains("describes this participant alone") && !one.contains("Student's t"));
    assert!(three.contains("Student's t") && !three.contains("alone"));
}

#[test]
fn a_question_for_the_mode_is_told_with_its_choices_and_its_index() {
    let mut study = zwidth_testing::study();
    let asked = |study: &Study| {
        text(study, &Recorded { guesses: study.questions.len() > 2, ..recorded(1) })
    };
    assert!(!asked(&study).contains("blinding index"));
    study.questions.push(zwidth_study::Question {
        id: "guess".parse().unwrap(),
        text: "Which mode was it?".to_owned(),
        scale: zwidth_study::AnswerScale::Modes(["A", "B"].map(str::to_owned).to_vec()),
        ..study.questions[0].clone()
    });
    let said = asked(&study);
    assert!(said.contains("A, B or “do not know”") && said.contains("blinding index"), "{said}");
    assert!(
        said.contains("Bang, Ni") && !said.contains("averaged over participants with"),
        "{said}"
    );
}

#[test]
fn a_source_is_listed_where_it_is_cited_and_nowhere_else() {
    let study = zwidth_testing::study();
    let said = text(&study, &recorded(1));
    for (_, short, whole) in sources::SOURCES {
        let whole = zwidth_tables::escape_markdown(whole);
        let short = zwidth_tables::escape_markdown(&format!("({short})"));
        assert_eq!(said.contains(&short), said.contains(&whole), "{short} in {said}");
    }
}

#[test]
fn what_a_study_lacks_has_no_sentence() {
    let mut study = zwidth_testing::study();
    let walled = text(&study, &recorded(1));
    study.environments.retain(|environment| environment.scene.wall_rad().is_none());
    let without = text(&study, &recorded(1));
    assert!(walled.contains("wall is the largest") && !without.contains("wall is the largest"));
    let nothing = text(&study, &Recorded::default());
    for heading in ["## Data", "## Measures", "## Model", "## Statistics", "## Sources"] {
        assert!(walled.contains(heading) && !nothing.contains(heading), "{heading}");
    }
}

#[test]
fn a_constant_force_and_a_delay_are_told() {
    let mut study = zwidth_testing::study();
    study.environments[0].scene = zwidth_study::Scene::Force { force_n: -1.5 };
    study.environments[1].delay_s = 0.012;
    let told = text(&study, &recorded(1)).replace('\u{a0}', " ");
    for words in ["a constant force of 1.5 N into the object", "12 ms late"] {
        assert!(told.contains(words), "{words} is not in {told}");
    }
}

#[test]
fn texts_of_a_study_are_escaped_in_every_form() {
    let mut study = zwidth_testing::study();
    "a_b\\input{x} #eval(\"y\")".clone_into(&mut study.device.name);
    let parts = methods(&study, &recorded(1), "1");
    let latex = MethodsForm::Latex.written(&parts);
    assert!(latex.contains(r"\textbackslash{}input\{x\}") && !latex.contains(r"\input"));
    let typst = MethodsForm::Typst.written(&parts);
    assert!(typst.contains(r#"#eval(\"y\")"#), "{typst}");
    assert!(typst.lines().all(|l| l.is_empty() || l.starts_with("== ") || l.starts_with("#(\"")));
}

#[test]
fn of_recordings_of_others_no_loop_and_no_order_is_told() {
    let study = zwidth_testing::study();
    let own = text(&study, &recorded(1));
    let foreign = Recorded { sources: BTreeMap::from([(Source::Imported, 36)]), ..recorded(1) };
    let foreign = text(&study, &foreign);
    for words in ["control loop ran", "Williams", "A trial took at most"] {
        assert!(own.contains(words) && !foreign.contains(words), "{words}");
    }
    assert!(foreign.contains("TODO: describe how they were taken"), "{foreign}");
}

#[test]
fn how_thresholds_were_found_is_told_by_task_and_method() {
    use zwidth_study::{Asks, Bound, Method, Task, TaskEstimate, TaskFit, TaskLevel};
    let mut study = zwidth_testing::study();
    assert!(!text(&study, &recorded(8)).contains("## Thresholds"));
    let level = |value| TaskLevel::nearest(value).unwrap();
    study.tasks = vec![Task {
        id: "stiffer".parse().unwrap(),
        text: "Which one was stiffer?".to_owned(),
        asks: Asks::MoreOfTwo,
        environment: study.environments[0].id.clone(),
        varies: "stiffness_n_per_rad".to_owned(),
        standard: Some(level(4.0)),
        method: Method::Constant { levels: vec![level(3.0), level(4.0), level(5.0)], trials: 20 },
        catch: 0.0,
        feedback: false,
        fit: TaskFit::default(),
        estimate: TaskEstimate::Likelihood,
    }];
    let said = text(&study, &recorded(8));
    for words in ["3 levels with 20 presentations", "Wichmann", "from 0 to 0.06", "Paule"] {
        assert!(said.contains(words), "{words} in {said}");
    }
    let compare = Recorded { compared: vec!["ln_jnd_stiffer".to_owned()], ..recorded(8) };
    study.compare.bounds =
        [("ln_jnd_stiffer".parse().unwrap(), Bound::Absolute(0.25_f64.ln_1p()))].into();
    let said = text(&study, &compare);
    assert!(said.contains("against the bounds a factor of 1.25 either way ("), "{said}");
    study.compare.bounds.clear();
    study.tasks[0].asks = Asks::Set;
    study.tasks[0].method = Method::Adjustment {
        starts: [level(2.0), level(6.0)],
        step: level(0.5),
        bounds: [level(1.0), level(8.0)],
        settings: 6,
        most_trials: 40,
    };
    let said = text(&study, &recorded(1));
    assert!(said.contains("0.6745") && said.contains("Gescheider"), "{said}");
    assert!(!said.contains("Wichmann") && !said.contains("Paule"), "{said}");
}
