//! Whether a trial can be analysed by the present `study.toml`.

use crate::{StoreError, TrialEntry};
use zwidth_study::Study;

/// What keeps a trial from being analysed by this `study.toml`; it then does not count.
pub(crate) fn unfit(study: &Study, trial: &mut TrialEntry) -> Option<StoreError> {
    let meta = &trial.meta;
    // Why its mode is a code was reported with the seal, or with what excludes it.
    let is_reported = meta.mode.is_code() && (trial.sealed.is_some() || trial.excluded.is_some());
    let unknown = if study.environment(&meta.environment).is_none() {
        Some(("environment", meta.environment.as_str()))
    } else if study.mode(&meta.mode).is_none() && !is_reported {
        Some(("mode", meta.mode.as_str()))
    } else {
        None
    };
    let column = unknown.map(|(kind, _)| kind);
    let lever_m = study.device.lever_m;
    let (what, remedy) = if let Some((kind, id)) = unknown {
        (format!("{kind} '{id}' is not in study.toml"), format!("add the {kind} to study.toml"))
    } else {
        // As text: the footer has the number as it was written then.
        let lever = trial.said.file.get("lever_m");
        let lever =
            lever.filter(|text| lever_m.is_none_or(|lever_m| lever_m.to_string() != **text))?;
        let now = lever_m.map_or_else(|| "none".to_owned(), |lever_m| format!("{lever_m} m"));
        let what =
            format!("it was converted with a lever of {lever} m, and device.lever_m is {now}");
        (what, "put device.lever_m back, or import the recording again".to_owned())
    };
    trial.excluded = Some(what.clone());
    let error = StoreError::new(&trial.path, format!("{what}: left out"), remedy);
    Some(StoreError { column: column.map(str::to_owned), ..error })
}
