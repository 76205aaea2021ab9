//! What the methods describe.

use std::collections::{BTreeMap, BTreeSet};
use zwidth_study::Source;

/// What was recorded for a study and made from it, as far as its methods describe it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Recorded {
    /// Participants with at least one trial that counts.
    pub participants: usize,
    /// Sessions of all participants together.
    pub sessions: usize,
    /// Trials that count.
    pub trials: usize,
    /// Trials that did not meet the protocol and were to be done again by the study's rule, by the mode's label.
    pub unmet: BTreeMap<String, usize>,
    /// Whether any of them has samples.
    pub sampled: bool,
    /// Sweeps of actuators and sensors.
    pub sweeps: usize,
    /// How many of these trials and sweeps come from where.
    pub sources: BTreeMap<Source, usize>,
    /// What an import computed because it was not recorded, each once.
    pub made_by_import: BTreeSet<String>,
    /// Metrics that modes are compared by, in order.
    pub compared: Vec<String>,
    /// What the primary metric and those measure, in words, by their names.
    pub words: BTreeMap<String, String>,
    /// Whether whole curves are compared.
    pub curves: bool,
    /// Whether there are answers that rate what was felt.
    pub answers: bool,
    /// Whether it was answered which mode it was.
    pub guesses: bool,
    /// Whether trials are replayed through the model.
    pub replayed: bool,
    /// Whether the plant is identified from trials.
    pub identified: bool,
    /// What the deposited plan says about them, in whole sentences; empty without a plan.
    pub plan: Vec<String>,
}

impl Recorded {
    /// What a metric measures; its name where that is not known.
    pub(super) fn in_words<'a>(&'a self, metric: &'a str) -> &'a str {
        self.words.get(metric).map_or(metric, String::as_str)
    }

    /// Whether others took all that there is: how, is not known.
    pub(super) fn is_foreign(&self) -> bool {
        !self.sources.is_empty()
            && !self.sources.keys().any(|source| matches!(source, Source::Recorded | Source::Twin))
    }
}

/// A number of study.toml with the digits that it has.
pub(super) fn plain(value: f64) -> String {
    zwidth_tables::number(value, None)
}
