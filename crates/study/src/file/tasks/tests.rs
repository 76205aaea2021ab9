//! What `[[tasks]]` may say, and every text that is refused.

use super::DOWN_OVER_UP;
use crate::tests::{CONSTANT, check_refused, check_round_trip, text, with_task as with};
use crate::{
    AnswerScale, Asks, Method, StaircasePlan, Study, Task, TaskEstimate, TaskLevel, TaskSigmoid,
};

/// A task of constant stimuli, with one line replaced or added.
fn constant(key: &str, line: &str) -> String {
    changed(CONSTANT, key, line)
}

/// Lines without the one of a key, and another one at their end.
fn changed(lines: &str, key: &str, line: &str) -> String {
    let kept: Vec<&str> =
        lines.lines().filter(|own| own.split(" = ").next() != Some(key)).collect();
    format!("{}\n{line}", kept.join("\n"))
}

fn staircase(key: &str, line: &str) -> String {
    let lines = constant("levels", "").replace("trials = 20", "").replace(
        "method = \"constant\"",
        "method = \"staircase\"\nrule = \"1up2down\"\nstart = 6.0\nup = 0.4\nlowest = 4.1\nhighest = 8.0",
    );
    changed(&lines, key, line)
}

fn adjustment(key: &str, line: &str) -> String {
    let lines = constant("levels", "")
        .replace("trials = 20", "")
        .replace("2ifc", "set")
        .replace(
            "method = \"constant\"",
            "method = \"adjustment\"\nstarts = [2.0, 6.0]\nstep = 0.2\nlowest = 1.0\nhighest = 7.0\nsettings = 6",
        );
    changed(&lines, key, line)
}

fn quest(key: &str, line: &str) -> String {
    let lines = constant("", "").replace(
        "method = \"constant\"",
        "method = \"quest_plus\"\npse = [2.0, 6.0, 0.1]\nsigma = [0.2, 2.0, 0.2]\nlapse = [0.0, 0.04, 0.02]",
    );
    changed(&lines, key, line)
}

fn read(keys: &str) -> Task {
    let study = with(keys).unwrap();
    check_round_trip(&study);
    study.tasks[0].clone()
}

fn plan(keys: &str) -> StaircasePlan {
    match read(keys).method {
        Method::Staircase(plan) => plan,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_task_is_a_question_that_is_no_rating_and_survives_a_round_trip() {
    let study = with(&constant("", "")).unwrap();
    check_round_trip(&study);
    let task = &study.tasks[0];
    let Method::Constant { levels, trials: 20 } = &task.method else { panic!("{task:?}") };
    assert_eq!((levels.len(), levels[0].value()), (7, 2.8));
    assert_eq!((task.presentations(), task.catches()), (140, 0));
    let question = study.question(&task.id).unwrap();
    assert_eq!(question.scale, AnswerScale::Task(Asks::MoreOfTwo));
    assert_eq!(question.scale.worded(2), "2 (the second)");
    assert!(question.is_of_task() && !question.is_rating() && !question.is_pair());
    let at = study.environment_at(task, levels[6]).unwrap();
    assert!((at.scene.spring().unwrap().stiffness_n_per_rad - 5.2).abs() < 1e-15);
}

#[test]
fn a_task_asks_for_no_column_of_answers_and_takes_none_away() {
    let one = text().replacen("schema = 2", "schema = 3", 1);
    let place = one.find("[[questions]]").unwrap();
    let question = "[[questions]]\nid = \"felt_wall\"\ntext = \"Felt?\"\n";
    let without = one[..place]
        .replace("question = \"felt_spring\"\n", "")
        .replace("question = \"felt_spring_wall\"", "question = \"felt_wall\"");
    let study = |more: &str| {
        Study::from_toml(&format!("{without}{question}{more}")).unwrap_or_else(|e| panic!("{e:?}"))
    };
    let task = format!("[[tasks]]\n{}", constant("", ""));
    assert_eq!(study("").questions.len() + 1, study(&task).questions.len());
    assert!(study("").trial_form().likert && study(&task).trial_form().likert);
}

#[test]
fn every_method_has_its_defaults_and_survives_a_round_trip() {
    let two_down = plan(&staircase("", ""));
    assert_eq!((two_down.up_after, two_down.down_after), (1, 2));
    assert_eq!((two_down.reversals, two_down.of_last, two_down.most_trials), (12, 8, 120));
    assert!((two_down.down - 0.4 * DOWN_OVER_UP[1]).abs() < 1e-15);
    let factor = plan(&staircase("up", "up = 1.25\nscale = \"factor\""));
    assert!((factor.down.ln() - 1.25_f64.ln() * DOWN_OVER_UP[1]).abs() < 1e-15);
    let several = plan(&staircase("start", "start = [7.0, 4.5]"));
    assert_eq!(several.starts.len(), 2);
    assert_eq!(plan(&staircase("", "interleaved = 3")).starts.len(), 3);
    let weighted = staircase("rule", "target = 0.75").replace("\"staircase\"", "\"weighted\"");
    let weighted = plan(&weighted);
    assert!((weighted.down - 0.4 / 3.0).abs() < 1e-15);
    assert_eq!((weighted.up_after, weighted.down_after), (1, 1));
    assert_eq!(read(&quest("", "")).presentations(), 20);
    let set = read(&adjustment("", ""));
    assert_eq!(set.presentations(), 6 * 60);
    let fitted = read(&constant(
        "",
        "fit = { sigmoid = \"logistic\", lapse = [0.0, 0.04] }\nestimate = \"grid\"\ncatch = 0.1\nfeedback = true",
    ));
    assert_eq!(fitted.fit.sigmoid, TaskSigmoid::Logistic);
    assert_eq!((fitted.estimate, fitted.feedback), (TaskEstimate::Grid, true));
    assert_eq!(fitted.catches(), 16); // of 156 in all
    let nothing = "asks = \"yes_no\"\nstandard = 0.0\ncatch = 0.2".to_owned();
    let yes_no = constant("asks", &nothing).replacen("standard = 4.0\n", "", 1);
    assert_eq!(read(&yes_no).standard, Some(TaskLevel::ZERO));
}

#[test]
fn what_cannot_be_meant_is_one_error_with_its_key() {
    let check = |keys: &str, key: &str, words: &str| {
        check_refused(with(keys), &format!("tasks[0].{key}"), words);
    };
    let line = |key: &str, line: &str| constant(key, line);
    check(&line("levels", "levels = [2.8, 3.2, 3.2]"), "levels[2]", "stands twice");
    check(&line("levels", "levels = [2.8, 3.6, 3.2]"), "levels[2]", "must rise");
    check(&line("levels", "levels = [2.8, 3.2000001, 3.6]"), "levels[1]", "write 3.2");
    check(&line("levels", "levels = [2.8, 3.2]"), "levels", "at least 3");
    check(&line("levels", ""), "levels", "is missing");
    check(&line("levels", "levels = [-2.8, 3.2, 3.6]"), "levels[0]", "0 or a number above");
    check(&line("levels", "levels = [nan, 3.2, 3.6]"), "levels[0]", "finite");
    check(&line("trials", ""), "trials", "is missing");
    check(&line("trials", "trials = 0"), "trials", "from 1 to");
    check(&line("standard", ""), "standard", "is missing");
    check(&line("standard", "standard = -1.0"), "standard", "0 or a number above");
    check(&line("text", "text = \" \""), "text", "is empty");
    check(&line("id", "id = \"felt_spring\""), "id", "choose another id");
    check(&line("id", "id = \"Felt_spring\""), "id", "choose another id");
    check(&line("environment", "environment = \"sprung\""), "environment", "not the id of any");
    check(
        &line("environment", "environment = \"spring_wall\""),
        "environment",
        "take the question out",
    );
    check(
        &line("varies", "varies = \"stiffness_n_per_mm\""),
        "varies",
        "there are stiffness_n_per_rad",
    );
    check(&line("varies", "varies = \"force_n\""), "varies", "has no number");
    check(&line("", "step = 0.2"), "step", "not used with method = \"constant\"");
    check(&line("", "settings = 2"), "settings", "not used with method");
    check(&line("", "catch = 0.7"), "catch", "a share from 0 to 0.5");
    check(&line("asks", "asks = \"set\""), "method", "belong together");
    check(
        &line("method", "method = \"adjustment\"").replace("levels", "# ").replace("trials", "# "),
        "method",
        "belong together",
    );
    check(&line("asks", "asks = \"yes_no\""), "levels[0]", "below the standard, 4");
    check(
        &line("asks", "asks = \"yes_no\"").replace("standard = 4.0", "standard = 0.0"),
        "asks",
        "needs trials at nothing",
    );
    check(&line("asks", "asks = \"2afc\""), "levels[0]", "above the standard, 4");
    let detected = line("asks", "asks = \"2afc\"").replace("standard = 4.0", "standard = 0.0");
    check(&format!("{detected}\ncatch = 0.1"), "catch", "neither is right");
    let weibull = "fit = { sigmoid = \"weibull\" }\nlevels = [0.0, 3.2, 3.6]";
    check(&line("levels", weibull), "levels[0]", "above 0 for sigmoid");
    check(&line("", "fit = { lapse = [0.0, 0.5] }"), "fit.lapse", "below 0.5");
    check(&line("", "fit = { lapse = [0.1, 0.0] }"), "fit.lapse", "below 0.5");
}

#[test]
fn what_a_staircase_cannot_mean_is_one_error_with_its_key() {
    let check = |keys: &str, key: &str, words: &str| {
        check_refused(with(keys), &format!("tasks[0].{key}"), words);
    };
    check(&staircase("rule", ""), "rule", "such as \"1up2down\"");
    check(&staircase("rule", "rule = \"1up5down\""), "rule", "each from 1 to 4");
    check(&staircase("rule", "rule = \"2down1up\""), "rule", "each from 1 to 4");
    check(&staircase("rule", "rule = \"2up1down\""), "down", "name the step down");
    check(&staircase("start", "start = 9.0"), "start", "between lowest and highest");
    check(&staircase("start", "start = [5.0, 9.0]"), "start[1]", "between lowest and highest");
    check(&staircase("start", ""), "start", "is missing");
    check(
        &staircase("start", "start = [5.0, 6.0]\ninterleaved = 3"),
        "interleaved",
        "one for each",
    );
    check(&staircase("", "interleaved = 17"), "interleaved", "from 1 to 16");
    check(&staircase("up", "up = 1.0\nscale = \"factor\""), "up", "a factor above 1");
    check(&staircase("up", "up = 0.0"), "up", "a step in the unit");
    check(&staircase("up", ""), "up", "is missing");
    check(
        &staircase("highest", "highest = 4.0").replace("start = 6.0", "start = 4.1"),
        "highest",
        "above lowest",
    );
    check(&staircase("lowest", ""), "lowest", "is missing");
    check(
        &staircase("lowest", "lowest = 0.0\nscale = \"factor\"").replace("up = 0.4", "up = 1.25"),
        "lowest",
        "above 0 for scale",
    );
    check(&staircase("", "reversals = 0"), "reversals", "from 1 to");
    check(&staircase("", "of_last = 13"), "of_last", "from 1 to 12");
    check(&staircase("", "most_trials = 10"), "most_trials", "cannot turn 12 times");
    check(&staircase("", "target = 0.75"), "target", "not used with method");
    let weighted =
        |target: &str| staircase("rule", target).replace("\"staircase\"", "\"weighted\"");
    check(&weighted(""), "target", "is missing");
    check(&weighted("target = 1.0"), "target", "from 0.01 to 0.99");
    let of_two = weighted("target = 0.5").replace("2ifc", "2afc");
    check(&of_two, "target", "right by chance");
}

#[test]
fn what_other_methods_cannot_mean_is_one_error_with_its_key() {
    let check = |keys: &str, key: &str, words: &str| {
        check_refused(with(keys), &format!("tasks[0].{key}"), words);
    };
    check(&adjustment("step", ""), "step", "above 0 with at most six decimals");
    check(&adjustment("step", "step = 0.0"), "step", "above 0 with at most six decimals");
    check(&adjustment("starts", "starts = [6.0, 2.0]"), "starts", "a lower and a higher");
    check(&adjustment("starts", "starts = [0.5, 6.0]"), "starts[0]", "between lowest");
    check(&adjustment("settings", "settings = 1"), "settings", "at least 2");
    check(&adjustment("", "fit = { sigmoid = \"norm\" }"), "fit", "nothing is fitted");
    check(&adjustment("", "feedback = true"), "feedback", "nothing is fitted");
    check(&quest("pse", ""), "pse", "is missing");
    check(&quest("pse", "pse = [6.0, 2.0, 0.1]"), "pse", "no higher than to");
    check(&quest("pse", "pse = [2.0, 6.0, 0.0]"), "pse", "a step above 0");
    check(&quest("sigma", "sigma = [0.0, 2.0, 0.2]"), "sigma", "above 0");
    check(&quest("lapse", "lapse = [0.0, 0.5, 0.1]"), "lapse", "below 0.5");
    check(&quest("pse", "pse = [2.0, 6.0, 0.00001]\n"), "levels", "longer steps");
    let yes_no = quest("asks", "asks = \"yes_no\"").replace("standard = 4.0", "standard = 0.0");
    check(&yes_no, "method", "says yes to nothing");
}

#[test]
fn a_level_that_the_device_cannot_have_is_refused() {
    let walled = |levels: &str| {
        let text = text().replacen("schema = 2", "schema = 3", 1).replacen(
            "question = \"felt_wall\"\n",
            "",
            1,
        );
        let keys = constant("levels", levels)
            .replace("environment = \"spring\"", "environment = \"spring_wall\"")
            .replace("stiffness_n_per_rad", "wall_deg");
        Study::from_toml(&format!("{text}\n[[tasks]]\n{keys}\n"))
    };
    assert!(walled("levels = [-45.0, 20.0, 45.0]").is_ok());
    check_refused(
        walled("levels = [20.0, 40.0, 45.5]"),
        "tasks[0].levels[2]",
        "work space, from -45 to 45",
    );
    let force = with(
        &constant("levels", "levels = [-2.0, 0.0, 10.5]").replace("stiffness_n_per_rad", "force_n"),
    );
    assert!(force.is_err(), "a spring has no force of its own");
}

#[test]
fn a_study_of_schema_2_has_no_tasks_and_no_session_has_trials_without_end() {
    let two = text().replacen("question = \"felt_spring\"\n", "", 1);
    let two = Study::from_toml(&format!("{two}\n[[tasks]]\n{}\n", constant("", "")));
    check_refused(two, "schema", "no columns for [[tasks]]; write schema = 3");
    check_refused(with(&constant("trials", "trials = 10000")), "tasks", "trials in a session");
    let twice = format!("{}\n[[tasks]]\n{}", constant("", ""), constant("id", "id = \"STIFFER\""));
    check_refused(with(&twice), "tasks[1].id", "stands twice");
}

#[test]
fn what_tasks_measure_has_a_metric_each() {
    let id = |id: &str| constant("id", &format!("id = \"{id}\""));
    let two = format!("{}\n[[tasks]]\n{}", id("how-stiff"), id("how_stiff"));
    check_refused(with(&two), "tasks[1].id", "compared as pse_how_stiff, too");
    check_refused(with(&id(&"x".repeat(30))), "tasks[0].id", "choose a shorter id");
}

#[test]
fn what_others_varied_has_the_name_that_they_give_it() {
    let imported = |varies: &str| {
        let text = crate::template_of_imports(&"demo".parse().unwrap()).replacen(
            "schema = 2",
            "schema = 3",
            1,
        );
        let id = Study::from_toml(&crate::template_of_imports(&"demo".parse().unwrap()))
            .unwrap()
            .environments[0]
            .id
            .clone();
        let keys = constant("varies", varies)
            .replace("environment = \"spring\"", &format!("environment = \"{id}\""));
        Study::from_toml(&format!("{text}\n[[tasks]]\n{keys}\n"))
    };
    let study = imported("varies = \"grating_um\"").unwrap();
    assert_eq!(study.task_unit(&study.tasks[0]), "µm");
    check_refused(imported("varies = \"Grating\""), "tasks[0].varies", "end in its unit");
    let own = with(&constant("", "")).unwrap();
    assert_eq!(own.task_unit(&own.tasks[0]), "N/rad");
}
