//! What changed between two versions of a `study.toml`, and what each change affects.
//!
//! Both are compared by value: a comment, a blank line or a default that is written out is not a
//! change. A key counts as affecting the recording unless it is known to affect nothing.

use crate::Study;
use crate::file::value_of;
use std::collections::BTreeMap;
use toml::Value;

/// The effect of a change of `study.toml` on an earlier session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Affects {
    /// Nothing that is recorded: titles, labels, figures, numbers of the analysis.
    Nothing,
    /// What is recorded from here on is not what was recorded before: device, control, scene,
    /// design, modes, the wording of a question.
    Recording,
}

/// One value of a `study.toml` that changed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StudyChange {
    /// The key as a path, with ids in place of indices: `environments.spring.rest_deg`.
    pub key: String,
    /// The value before, as the file writes it; [`StudyChange::ABSENT`] if there was none.
    pub then: String,
    /// The value now, likewise.
    pub now: String,
    /// What the change affects.
    pub affects: Affects,
}

impl StudyChange {
    /// Stands for a value that is not there.
    pub const ABSENT: &'static str = "absent";
    /// Stands for an environment, a mode or a question that is there as a whole.
    pub const PRESENT: &'static str = "present";
}

impl std::fmt::Display for StudyChange {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} was {} and is {}", self.key, self.then, self.now)
    }
}

/// The lists of a study, whose elements have ids.
const LISTS: [&str; 10] = [
    "environments",
    "modes",
    "questions",
    "channels",
    "people",
    "metrics",
    "stage",
    "scores",
    "tasks",
    "factors",
];

/// Every value that differs between two versions of a study, by key. Empty if the two are equal: a
/// file whose bytes differ all the same differs in comments and form alone.
pub fn study_changes(then: &Study, now: &Study) -> Vec<StudyChange> {
    // One unit for both: in another coordinate an unchanged scene would have other keys.
    let same_kind =
        std::mem::discriminant(&then.coordinate) == std::mem::discriminant(&now.coordinate);
    let coordinate = if same_kind { now.coordinate } else { then.coordinate };
    let [before, after] = [flat(then), flat(&Study { coordinate, ..now.clone() })];
    let mut changes = differences(&before, &after);
    if !same_kind {
        const KIND: &str = "coordinate.kind";
        let [then, now] = [then, now].map(|study| flat(study).remove(KIND).unwrap_or_default());
        changes.push(change(KIND, then, now));
    }
    // Metrics that were given beside the recordings are no part of the file.
    let as_written = |study: &Study| Study { from_tables: Vec::new(), ..study.clone() };
    if changes.is_empty() && as_written(then) != as_written(now) {
        // Values are compared as the file writes them: to nine decimals.
        let now = "another by less than a billionth".to_owned();
        changes.push(change("study.toml", "one number".to_owned(), now));
    }
    for change in &mut changes {
        if asks_for_other_pairs(&change.key, then, now) {
            change.affects = Affects::Recording;
        }
    }
    changes.sort_by(|a, b| a.key.cmp(&b.key));
    changes
}

/// Whether a change of this key is one of what people are asked about the pairs of a score: a score with pairs that came
/// or went, other questions in it (their order is none of the pairs'), or other words.
fn asks_for_other_pairs(key: &str, then: &Study, now: &Study) -> bool {
    let parts: Vec<&str> = key.split('.').collect();
    let (["scores", id] | ["scores", id, "pairs" | "questions"]) = parts[..] else { return false };
    let [then, now] = [then, now].map(|study| {
        let score = study.scores.iter().find(|score| score.id.as_str() == id);
        score.filter(|score| score.pairs.is_some())
    });
    match [then, now] {
        [Some(then), Some(now)] => then.pairs != now.pairs || then.weighing() != now.weighing(),
        [then, now] => then.is_some() || now.is_some(),
    }
}

fn differences(
    before: &BTreeMap<String, String>,
    after: &BTreeMap<String, String>,
) -> Vec<StudyChange> {
    let mut changes = Vec::new();
    for key in before.keys().chain(after.keys().filter(|key| !before.contains_key(*key))) {
        // Orders stand apart: an element that came or went would change them, too.
        if !key.ends_with(ORDER) && before.get(key) != after.get(key) {
            let [then, now] = [before, after].map(|values| {
                values.get(key).cloned().unwrap_or_else(|| StudyChange::ABSENT.to_owned())
            });
            changes.push(change(key, then, now));
        }
    }
    // An element that came or went is one change, not one for each of its keys.
    let whole = changes.iter().filter(|change| {
        let element = change.key.split_once('.');
        element.is_some_and(|(list, id)| LISTS.contains(&list) && !id.contains('.'))
    });
    let whole: Vec<String> = whole.map(|change| format!("{}.", change.key)).collect();
    changes.retain(|c| !whole.iter().any(|element| c.key.starts_with(element)));
    for list in LISTS {
        // Elements that are in both, in another order: sessions are drawn by the place in the list.
        let [then, now] = [(before, after), (after, before)].map(|(values, others)| {
            let ids = values.get(&format!("{list}{ORDER}")).map(String::as_str).unwrap_or_default();
            let both = ids.split(", ").filter(|id| others.contains_key(&format!("{list}.{id}")));
            both.collect::<Vec<_>>().join(", ")
        });
        if then != now {
            changes.push(change(list, then, now));
        }
    }
    changes
}

fn change(key: &str, then: String, now: String) -> StudyChange {
    StudyChange { key: key.to_owned(), then, now, affects: affects(key) }
}

/// What a change of this key affects. A question's order, group and direction belong to the tally;
/// its wording and its place belong to what the participant was asked. So do the pairs of a score, of which the key alone does
/// not tell ([`asks_for_other_pairs`]).
fn affects(key: &str) -> Affects {
    let parts: Vec<&str> = key.split('.').collect();
    match parts.as_slice() {
        ["study", "title"]
        | ["coordinate", ..]
        | ["masses", ..]
        | ["resistances", ..]
        | ["analysis", ..]
        | ["compare", ..]
        | ["perception", ..]
        | ["people" | "metrics" | "stage" | "scores" | "factors", ..]
        | ["axes", "low_pass_hz" | "onset_m_s" | "offset_m_s"]
        | ["replay", ..]
        | ["figures" | "scenes", ..] => Affects::Nothing,
        ["environments" | "modes", _, "label" | "factors", ..]
        | ["questions", _, "group" | "reversed"]
        | ["tasks", _, "fit" | "estimate", ..]
        | ["questions"] => Affects::Nothing,
        // A key that nobody thought of here is better asked about in vain than overlooked.
        _ => Affects::Recording,
    }
}

/// Where the order of a list stands among the flat keys; no id has such a character.
const ORDER: &str = "#";

/// A study as keys and values. Elements of lists go by their id.
fn flat(study: &Study) -> BTreeMap<String, String> {
    let mut values = BTreeMap::new();
    flatten("", &value_of(study), &mut values);
    values
}

fn flatten(path: &str, value: &Value, values: &mut BTreeMap<String, String>) {
    match value {
        Value::Table(table) => {
            for (key, inner) in table {
                let key = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                flatten(&key, inner, values);
            }
        }
        Value::Array(elements) if LISTS.contains(&path) => {
            let ids: Vec<&str> = elements.iter().filter_map(|e| e.get("id")?.as_str()).collect();
            values.insert(format!("{path}{ORDER}"), ids.join(", "));
            for (id, element) in ids.iter().zip(elements) {
                values.insert(format!("{path}.{id}"), StudyChange::PRESENT.to_owned());
                flatten(&format!("{path}.{id}"), element, values);
            }
        }
        value => _ = values.insert(path.to_owned(), value.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{demo, text, with, with_pairs};

    fn changes(from: &str, to: &str) -> Vec<StudyChange> {
        assert!(text().contains(from), "the template lost '{from}'");
        let now = text().replacen(from, to, 1);
        study_changes(&demo(), &Study::from_toml(&now).unwrap())
    }

    #[track_caller]
    fn check(from: &str, to: &str, expect: &[(&str, &str, &str, Affects)]) {
        let found = changes(from, to);
        let found: Vec<_> = found
            .iter()
            .map(|c| (c.key.as_str(), c.then.as_str(), c.now.as_str(), c.affects))
            .collect();
        assert_eq!(found, expect);
    }

    /// One value by another, where the key first stands in the template.
    #[track_caller]
    fn check_value(key: &str, then: &str, now: &str, affects: Affects) {
        let name = key.rsplit('.').next().unwrap();
        let [from, to] = [then, now].map(|value| format!("{name} = {value}"));
        check(&from, &to, &[(key, then, now, affects)]);
    }

    #[test]
    fn comments_blank_lines_and_defaults_written_out_are_no_change() {
        check("# Practice trials", "\n# Trials to practise", &[]);
        check("rate_hz = 1000.0\n", "", &[]);
        check(
            "# [figures]\n# alignment = \"onset\"\n",
            "[figures]\nalignment = \"onset\"\n",
            &[("figures.alignment", "absent", "\"onset\"", Affects::Nothing)],
        );
    }

    #[test]
    fn what_is_compared_affects_nothing_that_is_recorded() {
        let with = |compare: &str| with("[compare]", compare).unwrap();
        for (then, now, key) in [
            ("", "contrasts = [[\"active\", \"passive\"]]", "compare.contrasts"),
            ("", "metrics = []", "compare.metrics"),
            ("metrics = [\"a_s\"]", "metrics = [\"b_s\"]", "compare.metrics"),
            ("", "primary = \"a_s\"", "compare.primary"),
            ("bounds.a_s = 1.0", "bounds.a_s = 2.0", "compare.bounds.a_s"),
            ("bounds.a_s.weber = 0.1", "bounds.a_s.weber = 0.2", "compare.bounds.a_s.weber"),
            (
                "metrics = [\"a_s\"]\nbetter.a_s = \"lower\"",
                "metrics = [\"a_s\"]\nbetter.a_s = \"higher\"",
                "compare.better.a_s",
            ),
            ("", "alpha = 0.01", "compare.alpha"),
        ] {
            let found = study_changes(&with(then), &with(now));
            let keys: Vec<&str> = found.iter().map(|c| c.key.as_str()).collect();
            assert!(keys.contains(&key), "{found:?}");
            assert!(found.iter().all(|c| c.affects == Affects::Nothing), "{found:?}");
        }
    }

    #[test]
    fn the_frame_and_the_push_of_axes_are_recorded_and_their_low_pass_is_not() {
        let with = |push: &str, low_pass: &str| {
            let text = text().replacen("schema = 2", "schema = 3", 1);
            let axes = format!("frame = \"x right\"\npush = {push}\nlow_pass_hz = {low_pass}\n");
            Study::from_toml(&format!("{text}\n[axes]\n{axes}")).unwrap()
        };
        let usual = with("[0, 0, 1]", "10");
        let [filter] = study_changes(&usual, &with("[0, 0, 1]", "6")).try_into().unwrap();
        assert_eq!((&*filter.key, filter.affects), ("axes.low_pass_hz", Affects::Nothing));
        let [push] = study_changes(&usual, &with("[0, 1, 0]", "10")).try_into().unwrap();
        assert_eq!((&*push.key, push.affects), ("axes.push", Affects::Recording));
    }

    #[test]
    fn titles_labels_figures_masses_and_numbers_of_the_analysis_affect_nothing() {
        use Affects::Nothing;
        for (key, then, now) in [
            ("study.title", "\"Coupling a motor and a brake: demo\"", "\"T\""),
            ("environments.spring.label", "\"Spring\"", "\"Feder\""),
            ("modes.active.label", "\"Active\"", "\"Motor\""),
            ("masses.motor_g", "88.0", "90.0"),
            ("masses.brake_g", "27.0", "28.0"),
            ("resistances.motor_ohm", "30.4", "31.0"),
            ("analysis.onset_deg_s", "10.0", "12.0"),
            ("analysis.offset_deg_s", "5.0", "4.0"),
            ("analysis.slope_from_deg", "0.0", "1.5"),
            ("analysis.grid_points", "401", "201"),
            ("analysis.confidence", "0.95", "0.99"),
        ] {
            check_value(key, then, now, Nothing);
        }
        for (from, to, key, then, now) in [
            (
                "# [figures]\n# alignment = \"onset\"",
                "[figures]\nalignment = \"landmarks\"",
                "figures.alignment",
                "absent",
                "\"landmarks\"",
            ),
            (
                "id = \"felt_wall\"",
                "id = \"felt_wall\"\ngroup = \"g\"",
                "questions.felt_wall.group",
                "absent",
                "\"g\"",
            ),
            (
                "id = \"felt_wall\"",
                "id = \"felt_wall\"\nreversed = true",
                "questions.felt_wall.reversed",
                "false",
                "true",
            ),
        ] {
            check(from, to, &[(key, then, now, Nothing)]);
        }
    }

    #[test]
    fn device_control_scene_design_modes_and_wording_affect_the_recording() {
        use Affects::Recording;
        for (key, then, now) in [
            ("design.repeats", "6", "5"),
            ("design.familiarisation", "3", "2"),
            ("design.trial_limit_s", "4.0", "6.0"),
            ("design.pause_s", "5.0", "0.0"),
            ("design.order", "\"williams\"", "\"constrained\""),
            ("design.blinded", "false", "true"),
            ("device.name", "\"motor and brake on a capstan lever\"", "\"d\""),
            ("device.lever_m", "0.045", "0.05"),
            ("device.theta_min_deg", "-45.0", "-44.0"),
            ("device.theta_max_deg", "45.0", "44.0"),
            ("device.force_rate_hz", "80.0", "10.0"),
            ("control.rate_hz", "1000.0", "120.0"),
            ("control.let_go_n", "2.0", "1.0"),
            ("control.force_limit_n", "10.0", "8.0"),
            ("control.velocity_cutoff_hz", "40.0", "20.0"),
            ("environments.spring.stiffness_n_per_rad", "4.0", "5.0"),
            ("environments.spring.rest_deg", "-45.0", "-40.0"),
            ("environments.spring_wall.wall_deg", "26.6", "26.5"),
            ("modes.active.motor_max_v", "16.0", "12.0"),
            ("modes.passive.brake_max_v", "8.0", "6.0"),
        ] {
            check_value(key, then, now, Recording);
        }
        let redone = ("design.redo_unmet", "0", "2", Recording);
        check("pause_s = 5.0", "pause_s = 5.0\nredo_unmet = 2", &[redone]);
        let question = ("environments.spring.question", "\"felt_spring\"", "absent", Recording);
        check("question = \"felt_spring\"", "", &[question]);
        let [worded] = changes("linear stiffness.\"", "spring.\"").try_into().unwrap();
        assert_eq!(worded.key, "questions.felt_spring.text");
        assert_eq!(worded.affects, Recording);
        let words = changes(
            "velocity = \"second_order\"\nvelocity_cutoff_hz = 40.0",
            "velocity = \"difference\"",
        );
        assert!(words.len() == 2 && words.iter().all(|c| c.affects == Recording), "{words:?}");
    }

    #[test]
    fn asking_for_pairs_affects_the_recording_and_another_score_does_not() {
        let [then, now, other] =
            ["pairs = \"A?\"", "pairs = \"B?\"", "pairs = \"A?\"\nlabel = \"Load\""]
                .map(with_pairs);
        let [found] = study_changes(&then, &now).try_into().unwrap();
        assert_eq!((found.key.as_str(), found.affects), ("scores.load.pairs", Affects::Recording));
        assert_eq!(study_changes(&then, &other)[0].affects, Affects::Nothing);
    }

    #[test]
    fn a_score_with_pairs_that_comes_or_goes_affects_the_recording_and_one_without_does_not() {
        let score = with_pairs("pairs = \"A?\"");
        let mut none = score.clone();
        none.scores.clear();
        none.questions.retain(|question| !question.is_pair());
        let mut raw = none.clone();
        raw.scores = score.scores.clone();
        raw.scores[0].kind = crate::ScoreKind::NasaTlxRaw;
        raw.scores[0].pairs = None;
        for (then, now, affects) in [
            (&none, &score, Affects::Recording),
            (&score, &none, Affects::Recording),
            (&none, &raw, Affects::Nothing),
            (&raw, &none, Affects::Nothing),
        ] {
            let [found] = study_changes(then, now).try_into().unwrap();
            assert_eq!((found.key.as_str(), found.affects), ("scores.load", affects));
        }
        let changes = study_changes(&score, &raw);
        let pairs = changes.iter().find(|change| change.key == "scores.load.pairs").unwrap();
        assert_eq!(pairs.affects, Affects::Recording);
    }

    #[test]
    fn other_questions_of_a_score_with_pairs_affect_the_recording_and_their_order_does_not() {
        let then = with_pairs("pairs = \"A?\"");
        let mut turned = then.clone();
        turned.scores[0].questions.reverse();
        let mut other = then.clone();
        other.scores[0].questions[5] = "felt_wall".parse().unwrap();
        for (now, affects) in [(turned, Affects::Nothing), (other, Affects::Recording)] {
            let [found] = study_changes(&then, &now).try_into().unwrap();
            assert_eq!((found.key.as_str(), found.affects), ("scores.load.questions", affects));
        }
    }

    #[test]
    fn an_element_that_comes_or_goes_is_one_change_and_another_order_is_one() {
        use Affects::{Nothing, Recording};
        let passive = "[[modes]]\nid = \"passive\"\nlabel = \"Passive\"\nbrake_max_v = 8.0\n";
        check(passive, "", &[("modes.passive", "present", "absent", Recording)]);
        check(
            "[[questions]]",
            "[[questions]]\nid = \"new\"\ntext = \"?\"\n\n[[questions]]",
            &[("questions.new", "absent", "present", Recording)],
        );
        let active = "[[modes]]\nid = \"active\"\nlabel = \"Active\"\nmotor_max_v = 16.0\n";
        let both = format!("{active}\n{passive}");
        check(
            &both,
            &format!("{passive}\n{active}"),
            &[("modes", "active, passive, hybrid", "passive, active, hybrid", Recording)],
        );
        let mut now = demo();
        now.questions.reverse();
        assert_eq!(study_changes(&demo(), &now)[0].affects, Nothing);
    }

    #[test]
    fn another_kind_of_scene_tells_each_of_its_keys() {
        let found = changes(
            "kind = \"spring\"\nstiffness_n_per_rad = 4.0\nrest_deg = -45.0",
            "kind = \"free\"",
        );
        let keys: Vec<_> = found.iter().map(|c| c.key.as_str()).collect();
        let names = ["kind", "rest_deg", "stiffness_n_per_rad"];
        assert_eq!(keys, names.map(|name| format!("environments.spring.{name}")));
    }

    #[test]
    fn the_same_scene_in_another_coordinate_changes_the_figures_alone() {
        let then = demo();
        let now =
            Study { coordinate: crate::Coordinate::Linear { lever_m: 0.045 }, ..then.clone() };
        for (then, now) in [(&then, &now), (&now, &then)] {
            let [found] = study_changes(then, now).try_into().unwrap();
            assert_eq!((found.key.as_str(), found.affects), ("coordinate.kind", Affects::Nothing));
        }
    }

    #[test]
    fn a_change_too_small_to_be_written_is_told_and_affects_the_recording() {
        let then = demo();
        let mut now = then.clone();
        now.device.theta_max_rad = now.device.theta_max_rad.map(f64::next_up);
        let [found] = study_changes(&then, &now).try_into().unwrap();
        assert_eq!(found.affects, Affects::Recording);
        assert_eq!(study_changes(&then, &then), []);
    }

    #[test]
    fn a_change_reads_as_a_sentence() {
        let [found] = changes("repeats = 6", "repeats = 5").try_into().unwrap();
        assert_eq!(found.to_string(), "design.repeats was 6 and is 5");
    }
}
