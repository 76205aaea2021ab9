//! Whether a trial can be analysed by the present `study.toml`.

use crate::{StoreError, TrialEntry};
use zwidth_study::Study;

/// What keeps a trial from being analysed by this `study.toml`; it then does not count.
pub(crate) fn unfit(study: &Study, trial: &mut TrialEntry) -> Option<StoreError> {
    let meta = &trial.meta;
    let unknown = |what: &str, id: &str| {
        let remedy = format!("add the {what} to study.toml");
        (format!("{what} '{id}' is not in study.toml"), remedy, Some(what.to_owned()))
    };
    let (what, remedy, column) = if study.environment(&meta.environment).is_none() {
        unknown("environment", meta.environment.as_str())
    } else if study.mode(&meta.mode).is_none() && !is_told(trial) {
        unknown("mode", meta.mode.as_str())
    } else if let Some(lever) = trial.said.file.get("lever_m").filter(|l| !is_lever(study, l)) {
        let now = study.device.lever_m.map_or_else(|| "none".to_owned(), |l| format!("{l} m"));
        let what =
            format!("it was converted with a lever of {lever} m, and device.lever_m is {now}");
        (what, "put device.lever_m back, or import the recording again".to_owned(), None)
    } else {
        return None;
    };
    trial.excluded = Some(what.clone());
    let error = StoreError::new(&trial.path, format!("{what}: left out"), remedy);
    Some(match column {
        Some(column) => error.column(column),
        None => error,
    })
}

/// Whether it was told already why the trial's mode is a code.
fn is_told(trial: &TrialEntry) -> bool {
    trial.meta.mode.is_code() && (trial.sealed.is_some() || trial.excluded.is_some())
}

fn is_lever(study: &Study, text: &str) -> bool {
    study.device.lever_m.is_some_and(|lever_m| lever_m.to_string() == text)
}
