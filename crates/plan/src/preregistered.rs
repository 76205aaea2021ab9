//! The plan that lies beside a study's data, and whether the analysis is the one that was planned.

use serde_json::{Value, json};
use std::io::ErrorKind;
use std::path::PathBuf;
use zwidth_compare::Preregistered;
use zwidth_store::{Layout, StudyData, hex_blake3, read_regular};
use zwidth_study::Study;

/// Where a study keeps the plan that was deposited before its data were taken.
pub fn plan_file(layout: &Layout) -> PathBuf {
    layout.raw().join("plan.json")
}

/// What of a study its claims rest on, as a plan keeps it: what is compared, in which design.
pub fn analysis(study: &Study) -> Value {
    let compare = &study.compare;
    json!({
        "environments": study.environments.iter().map(|e| e.id.as_str()).collect::<Vec<_>>(),
        "modes": study.modes.iter().map(|m| m.id.as_str()).collect::<Vec<_>>(),
        "repeats": study.design.repeats,
        "contrasts": compare.contrasts,
        "primary": compare.primary,
        "metrics": compare.metrics,
        "bounds": compare.bounds,
        "alpha": compare.alpha,
        "level": compare.level,
        "families": compare.families,
    })
}

/// The largest plan that is read, bytes.
const MOST_BYTES: u64 = 1 << 20;

/// What the study's plan says of its analysis; `None` without a plan.
pub(crate) fn preregistered(data: &StudyData) -> Option<Preregistered> {
    let bytes = match read_regular(&plan_file(&data.layout), MOST_BYTES) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == ErrorKind::NotFound => return None,
        Err(error) => {
            let deviations = vec![format!("the file cannot be read: {error}")];
            return Some(Preregistered { deviations, ..Preregistered::default() });
        }
    };
    let plan: Value = serde_json::from_slice(&bytes).unwrap_or_default();
    let number = |key: &str| plan[key].as_u64();
    Some(Preregistered {
        blake3: hex_blake3(&bytes),
        deviations: deviations(&plan["analysis"], &analysis(&data.study)),
        participants: number("participants"),
        trials_before: number("trials_before"),
    })
}

/// What is otherwise than planned, each in words.
fn deviations(planned: &Value, actual: &Value) -> Vec<String> {
    let Some(planned) = planned.as_object() else {
        return vec!["the file holds no plan as `zwidth power --plan` writes it".to_owned()];
    };
    let actual = actual.as_object().into_iter().flatten();
    actual
        .map(|(key, now)| (key, planned.get(key).unwrap_or(&Value::Null), now))
        .filter(|(_, then, now)| then != now)
        .map(|(key, then, now)| format!("{key} was {then}, is {now}"))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn study() -> Study {
        zwidth_testing::study()
    }

    #[test]
    fn the_analysis_that_was_planned_deviates_in_nothing_and_another_says_in_what() {
        let planned = analysis(&study());
        assert_eq!(deviations(&planned, &planned), [""; 0]);
        let mut other = study();
        other.compare.alpha = 0.01;
        other.design.repeats = 5;
        let found = deviations(&planned, &analysis(&other));
        assert_eq!(found, ["alpha was 0.05, is 0.01", "repeats was 6, is 5"]);
    }

    #[test]
    fn a_file_that_is_no_plan_is_called_none() {
        let found = deviations(&json!("no plan"), &analysis(&study()));
        assert!(found[0].contains("holds no plan"), "{found:?}");
    }
}
