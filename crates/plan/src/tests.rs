//! What tests of several stages look at.

use std::path::Path;
use std::sync::Arc;
use zwidth_store::{Layout, Said, Signal, StudyData, TrialEntry, TrialFile};

/// Two trials of the template's spring in its hybrid mode, of which no sample is needed.
pub(crate) fn data() -> StudyData {
    let mut study = zwidth_testing::study();
    study.control.rate_hz = 120.0;
    let signals = vec![Signal::Time, Signal::Theta, Signal::ForceEx];
    let (file, form) = (TrialFile::new(), study.trial_form());
    let said = Arc::new(Said { file, form, signals });
    let entry = |trial: u32| TrialEntry {
        path: Path::new("").into(),
        meta: zwidth_testing::meta(trial, "hybrid"),
        said: said.clone(),
        rows: 0,
        blake3: String::new(),
        superseded_by: None,
        excluded: None,
        is_unmet: false,
        sealed: None,
    };
    StudyData {
        layout: Layout::new(Path::new("."), "demo".parse().unwrap()),
        trials: vec![entry(1), entry(2)],
        study,
        people: zwidth_study::People::default(),
        sweeps: Vec::new(),
        outside: Vec::new(),
        beside: Vec::new(),
        sessions: Vec::new(),
        problems: Vec::new(),
        warnings: Vec::new(),
        answers: Vec::new(),
        answers_left_out: Vec::new(),
    }
}
