//! The plan that lies beside a study's data, and whether study, data and analysis are as planned.

use crate::page::people;
use serde::Serialize;
use serde_json::{Value, json};
use std::io::ErrorKind;
use std::path::PathBuf;
use zwidth_compare::Preregistered;
use zwidth_store::{Layout, StoreError, StudyData, hex_blake3, read_regular};
use zwidth_study::{Affects, Curve, Kind, Study, StudyChange, study_changes};

/// Where a study keeps the plan that was deposited before its data were taken.
pub fn plan_file(layout: &Layout) -> PathBuf {
    layout.raw().join("plan.json")
}

/// The covariates as study.toml names them; none is as in a plan of an earlier version.
fn covariates(study: &Study) -> Option<Vec<String>> {
    let compare = &study.compare;
    let over = compare.over.map(|over| over.as_str().to_owned());
    let all: Vec<String> =
        over.into_iter().chain(compare.covariates.iter().map(ToString::to_string)).collect();
    (!all.is_empty()).then_some(all)
}

/// The parts of a study on which its claims rest, as a plan keeps them: what is compared, in which
/// design.
pub fn analysis(study: &Study) -> Value {
    let compare = &study.compare;
    json!({
        "environments": study.environments.iter().map(|e| e.id.as_str()).collect::<Vec<_>>(),
        "modes": study.modes.iter().map(|m| m.id.as_str()).collect::<Vec<_>>(),
        "repeats": study.design.repeats,
        "contrasts": compare.contrasts,
        "primary": compare.primary,
        "metrics": compare.metrics,
        "curve_nodes": compare.primary.curves().next().map(|_| compare.curve_nodes),
        "bounds": compare.bounds,
        "alpha": compare.alpha,
        "level": compare.level,
        "families": compare.families,
        "groups": compare.groups,
        "effects": (!study.factors.is_empty()).then_some(&compare.effects),
        "trend": (!compare.trend.is_empty()).then_some(&compare.trend),
        "weighted": (!compare.weighted.is_empty()).then_some(&compare.weighted),
        "covariates": covariates(study),
        "scores": (!study.scores.is_empty()).then_some(&study.scores),
    })
}

/// The largest plan and the largest study.toml that are read, bytes.
const MOST_BYTES: u64 = 1 << 20;

/// A plan as its file has it.
#[derive(Serialize)]
struct Deposited<'a, P> {
    #[serde(flatten)]
    plan: &'a P,
    /// BLAKE3 of this file, with nothing between these quotation marks.
    blake3: &'a str,
}

/// The text of a plan's file: the plan, and a hash of all of it, so that an edit shows.
///
/// # Errors
/// A plan that is not an object, or has a number that is not finite.
pub fn plan_text(plan: &impl Serialize) -> serde_json::Result<String> {
    // Of the text with an empty hash, because a text cannot hold its own: `checked` empties it again.
    let text = serde_json::to_string_pretty(&Deposited { plan, blake3: "" })? + "\n";
    let blake3 = &*hex_blake3(text.as_bytes());
    Ok(serde_json::to_string_pretty(&Deposited { plan, blake3 })? + "\n")
}

/// What is wrong with a study's plan as a file: damaged, edited, or of another study. Nothing if it is
/// whole, or if there is none.
pub fn plan_finding(layout: &Layout) -> Option<StoreError> {
    let fault = read_plan(layout)?.err()?.1;
    let remedy = "restore the copy that was deposited; without one, move the file elsewhere";
    Some(StoreError::new(&plan_file(layout), fault, remedy))
}

/// What is wrong with a file that is no plan.
const NO_PLAN: &str = "the file holds no plan as `zwidth power --plan` writes it";

/// A plan that is whole and of this study.
struct Plan {
    /// BLAKE3 of its file.
    blake3: String,
    content: Value,
}

/// The study's plan, or the hash of its file as far as it can be read, and what is wrong with it;
/// `None` without a plan.
fn read_plan(layout: &Layout) -> Option<Result<Plan, (String, String)>> {
    let bytes = match read_regular(&plan_file(layout), MOST_BYTES) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == ErrorKind::NotFound => return None,
        Err(error) => {
            return Some(Err((String::new(), format!("the file cannot be read: {error}"))));
        }
    };
    let blake3 = hex_blake3(&bytes);
    Some(match checked(&bytes, layout.study().as_str()) {
        Ok(content) => Ok(Plan { blake3, content }),
        Err(fault) => Err((blake3, fault)),
    })
}

/// What a plan's file holds, once it is found to be whole and of this study.
///
/// # Errors
/// It is no plan, not as it was written, or of another study: why, in words.
fn checked(bytes: &[u8], study: &str) -> Result<Value, String> {
    let text = str::from_utf8(bytes).map_err(|_| NO_PLAN)?;
    let content: Value = serde_json::from_str(text).map_err(|_| NO_PLAN)?;
    if !content["analysis"].is_object() {
        return Err(NO_PLAN.to_owned());
    }
    match content["study"].as_str() {
        Some(name) if name == study => {}
        Some(name) => {
            return Err(format!("it is the plan of the study '{name}', and not of '{study}'"));
        }
        None => return Err(NO_PLAN.to_owned()),
    }
    // Plans of earlier versions have neither a hash of their own nor the study's text. The hash is of
    // the file with nothing in its place, as it was when the hash was computed.
    let is_edited = content.get("blake3").is_some_and(|own| {
        own.as_str().is_none_or(|own| hex_blake3(text.replacen(own, "", 1).as_bytes()) != own)
    });
    let study_toml = content["study_toml"].as_str();
    let is_of_another = study_toml.is_some_and(|toml| {
        content["study_blake3"].as_str() != Some(&*hex_blake3(toml.as_bytes()))
    });
    if is_edited || is_of_another {
        return Err(
            "it was changed since it was written: its content does not fit its own hash".to_owned()
        );
    }
    Ok(content)
}

/// What the study's plan says of study, data and analysis; `None` without a plan. `compared` are the
/// metrics and curves that are.
pub(crate) fn preregistered(data: &StudyData, compared: &[String]) -> Option<Preregistered> {
    let Plan { blake3, content } = match read_plan(&data.layout)? {
        Ok(plan) => plan,
        Err((blake3, fault)) => {
            let deviations = vec![fault];
            return Some(Preregistered { blake3, deviations, ..Preregistered::default() });
        }
    };
    let participants = content["participants"].as_u64();
    let trials_before = content["trials_before"].as_u64();
    let planned = content["study_toml"].as_str().and_then(|toml| Study::from_toml(toml).ok());
    let of_analysis = of_analysis(&content["analysis"], &analysis(&data.study));
    let mut deviations: Vec<String> = match &of_analysis {
        Some(changes) => changes.iter().map(|change| change.in_words.clone()).collect(),
        None => vec![NO_PLAN.to_owned()],
    };
    let of_analysis = of_analysis.unwrap_or_default();
    deviations.extend(of_study_toml(&content, planned.as_ref(), data, &of_analysis));
    // The power was computed for one metric, and there must be one to make claims of.
    let primary = &data.study.compare.primary;
    if let Some(planned) = content["metric"].as_str().filter(|metric| !primary.has(metric)) {
        let names: Vec<&str> = primary.names().iter().map(|name| name.as_str()).collect();
        let metrics = if primary.curves().next().is_none() { "metric" } else { "measure" };
        let are = if primary.are_several() { "s are" } else { " is" };
        deviations.push(format!(
            "the power was computed for {planned}, and the primary {metrics}{are} {}",
            names.join(", ")
        ));
    }
    if data.counting().next().is_some() {
        let lacking = primary.names().iter().filter(|name| !compared.contains(&name.to_string()));
        deviations.extend(lacking.map(|name| {
            let the = if primary.are_several() { "a" } else { "the" };
            let is_curve = Curve::from_word(name.as_str()).is_some();
            let what = if is_curve { "curve" } else { "metric" };
            format!("{the} primary {what}, {name}, could not be compared")
        }));
    }
    // Fewer participants than planned may still come.
    let took_part = people::participants(data) as u64;
    if let Some(planned) = participants.filter(|planned| took_part > *planned) {
        deviations
            .push(format!("{planned} participants were planned, and {took_part} have trials"));
    }
    // A plan foresees no trials that a person takes out of the analysis.
    let trials = data.trials.iter().filter(|trial| trial.meta.kind == Kind::Trial);
    match trials.filter(|trial| trial.excluded.is_some() && !trial.is_unmet).count() {
        0 => {}
        1 => deviations.push("1 trial was excluded by hand".to_owned()),
        n => deviations.push(format!("{n} trials were excluded by hand")),
    }
    // A plan of an earlier version has no study of its own: its sessions are held against today's.
    deviations.extend(of_sessions(planned.as_ref().unwrap_or(&data.study), data));
    let mut remarks = Vec::new();
    if content["blake3"].is_null() {
        let no_hash = "The plan has no hash of its own: only the copy that was deposited can show whether \
                       it was edited.";
        remarks.push(no_hash.to_owned());
    }
    Some(Preregistered { blake3, deviations, remarks, participants, trials_before })
}

/// Something that is otherwise than planned.
struct Deviation {
    key: String,
    in_words: String,
}

/// What of the analysis is otherwise than planned; `None` where there is no plan of one.
fn of_analysis(planned: &Value, actual: &Value) -> Option<Vec<Deviation>> {
    let planned = planned.as_object()?;
    let mut deviations = Vec::new();
    for (key, now) in actual.as_object().into_iter().flatten() {
        let then = planned.get(key).unwrap_or(&Value::Null);
        if then != now {
            let in_words = format!("{key} was {then}, is {now}");
            deviations.push(Deviation { key: key.clone(), in_words });
        }
    }
    Some(deviations)
}

/// What of study.toml is otherwise than when the plan was made, each in words. `planned` is the study
/// as it was then, if the plan has it; `listed` are the deviations that are already listed.
fn of_study_toml(
    content: &Value,
    planned: Option<&Study>,
    data: &StudyData,
    listed: &[Deviation],
) -> Vec<String> {
    let Ok(now) = read_regular(&data.layout.study_toml(), MOST_BYTES) else {
        return vec!["study.toml cannot be read".to_owned()];
    };
    if content["study_blake3"].as_str() == Some(&*hex_blake3(&now)) {
        return Vec::new();
    }
    let another = "study.toml is not the file that the plan was made for";
    let Some(planned) = planned else { return vec![another.to_owned()] };
    let changes = study_changes(planned, &data.study);
    if changes.is_empty() {
        return vec![format!("{another}, although they differ in comments and form alone")];
    }
    let mut sentences = Vec::new();
    for change in changes.iter().filter(|change| !is_listed(change, listed)) {
        let StudyChange { key, then, now, .. } = change;
        sentences.push(format!("{key} was {then}, is {now}"));
    }
    sentences
}

/// Whether a change of `compare.alpha` is already listed as one of `alpha`, and one of
/// `compare.bounds.duration_s` as one of `bounds`.
fn is_listed(change: &StudyChange, listed: &[Deviation]) -> bool {
    let mut parts = change.key.split('.');
    let name = match (parts.next(), parts.next()) {
        (Some("compare" | "design"), Some(name)) => name,
        // `scores[load].kind`
        (Some(list), _) => list.split('[').next().unwrap_or(list),
        (None, _) => return false,
    };
    listed.iter().any(|deviation| deviation.key == name)
}

/// Sessions that were recorded in another way than planned. An imported session has neither a study
/// nor an order of its own, and counts as planned.
fn of_sessions(planned: &Study, data: &StudyData) -> Vec<String> {
    let all = data.sessions.len();
    let mut deviations = Vec::new();
    // What was recorded may depend on it; a label or a figure that changed since changes nothing there.
    let by_another_study = data.sessions.iter().filter(|log| {
        log.study.as_deref().is_some_and(|own| {
            let changes = study_changes(own, planned);
            changes.iter().any(|change| change.affects == Affects::Recording)
        })
    });
    let n = by_another_study.count();
    if n > 0 {
        deviations.push(format!(
            "{n} of {all} sessions were recorded by another study.toml than the plan's"
        ));
    }
    let scheme = planned.design.order;
    let in_another_order = data
        .sessions
        .iter()
        .filter(|log| log.record.order.is_some_and(|order| order.scheme != scheme));
    let n = in_another_order.count();
    if n > 0 {
        deviations
            .push(format!("the modes' order was drawn by another scheme in {n} of {all} sessions"));
    }
    deviations
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_testing::study;

    #[test]
    fn the_analysis_that_was_planned_deviates_in_nothing_and_another_says_in_what() {
        let planned = analysis(&study());
        assert!(of_analysis(&planned, &planned).unwrap().is_empty());
        let mut other = study();
        other.compare.alpha = 0.01;
        other.design.repeats = 5;
        let found = of_analysis(&planned, &analysis(&other)).unwrap();
        let found: Vec<&str> = found.iter().map(|change| change.in_words.as_str()).collect();
        assert_eq!(found, ["alpha was 0.05, is 0.01", "repeats was 6, is 5"]);
        assert!(of_analysis(&json!("no plan"), &planned).is_none());
    }

    /// A plan for a study.toml, with the hash of one, as its file has it.
    fn plan(study_toml: &str, hashed: &str) -> String {
        plan_text(&json!({
            "study": "s",
            "study_toml": study_toml,
            "study_blake3": hex_blake3(hashed.as_bytes()),
            "analysis": analysis(&study()),
            "power": 0.1 + 0.2,
        }))
        .unwrap()
    }

    #[test]
    fn a_plan_fits_its_own_hash_until_anything_in_it_is_changed() {
        let text = plan("title = \"\"", "title = \"\"");
        let check = |text: &str| checked(text.as_bytes(), "s").map(drop);
        assert_eq!(check(&text), Ok(()));
        let edits = [
            ("0.05", "0.01"),
            ("0.30000000000000004", "0.3"),
            ("title", "tale"),
            ("\n", "\r\n"),
            ("\"blake3\": \"", "\"blake3\": \"0"),
            ("\"blake3\": \"", "\"blake3\": 5, \"other\": \""),
        ];
        for (from, to) in edits {
            let edited = text.replacen(from, to, 1);
            assert_ne!(edited, text);
            assert!(check(&edited).unwrap_err().contains("its own hash"), "{edited}");
        }
        assert!(checked(text.as_bytes(), "other").unwrap_err().contains("of the study 's'"));
        let without = text.replace("\"analysis\"", "\"analyses\"");
        for damaged in ["", "{", "[]", "{}", "null", "{\"analysis\": {}}", &without] {
            assert!(check(damaged).unwrap_err().contains("holds no plan"), "{damaged}");
        }
        assert!(checked(&[0xff, 0xfe], "s").is_err());
    }

    #[test]
    fn a_plan_whose_study_toml_was_exchanged_is_not_whole_even_with_a_new_hash() {
        let exchanged = plan("title = \"x\"", "title = \"\"");
        let fault = checked(exchanged.as_bytes(), "s").unwrap_err();
        assert!(fault.contains("its own hash"), "{fault}");
    }
}
