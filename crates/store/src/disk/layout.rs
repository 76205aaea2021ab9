//! Where everything is under the root (`docs/data.md`, "Layout").

use std::path::{Path, PathBuf};
use zwidth_study::{ActuatorId, MetricId, ParticipantId, PeopleForm, SessionId, StreamId, StudyId};

/// The three data folders under one root, for one study.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    root: PathBuf,
    study: StudyId,
}

impl Layout {
    /// The layout of `study` under `root`.
    pub fn new(root: &Path, study: StudyId) -> Self {
        Self { root: root.to_owned(), study }
    }

    /// The study's id.
    pub fn study(&self) -> &StudyId {
        &self.study
    }

    /// The folder that holds `raw/`, `derived/` and `reports/`.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// `raw/<study>`: only acquisition and import write here.
    pub fn raw(&self) -> PathBuf {
        self.root.join("raw").join(self.study.as_str())
    }

    /// `derived/<study>`: written by stages, safe to delete.
    pub fn derived(&self) -> PathBuf {
        self.root.join("derived").join(self.study.as_str())
    }

    /// `reports/<study>`: figures, tables, the summary.
    pub fn reports(&self) -> PathBuf {
        self.root.join("reports").join(self.study.as_str())
    }

    /// `analysis/<study>`: programs of the study's own, which zwidth only reads.
    pub fn analysis(&self) -> PathBuf {
        self.root.join("analysis").join(self.study.as_str())
    }

    /// The study's `study.toml`.
    pub fn study_toml(&self) -> PathBuf {
        self.raw().join("study.toml")
    }

    /// The study's participants' file, in the form that it has.
    pub fn people(&self, form: PeopleForm) -> PathBuf {
        self.raw().join(match form {
            PeopleForm::Toml => "participants.toml",
            PeopleForm::Csv => "participants.csv",
        })
    }

    /// The tree that holds trial files and nothing else.
    pub fn trials(&self) -> PathBuf {
        self.raw().join("trials")
    }

    /// The tree that holds sweep files and nothing else.
    pub fn sweeps(&self) -> PathBuf {
        self.raw().join("sweeps")
    }

    /// The folder of session records and event logs.
    pub fn sessions(&self) -> PathBuf {
        self.raw().join("sessions")
    }

    /// The folder of one session's trials.
    pub(crate) fn trials_of(&self, participant: &ParticipantId, session: &SessionId) -> PathBuf {
        let folder = self.trials().join(format!("participant={participant}"));
        folder.join(format!("session={session}"))
    }

    /// One trial's file.
    pub fn trial(&self, participant: &ParticipantId, session: &SessionId, trial: u32) -> PathBuf {
        self.trials_of(participant, session).join(format!("trial-{trial:03}.parquet"))
    }

    /// One sweep's file.
    pub fn sweep(&self, actuator: &ActuatorId, sweep: u32) -> PathBuf {
        self.sweeps().join(format!("actuator={actuator}")).join(format!("sweep-{sweep:02}.parquet"))
    }

    /// One session's record.
    pub fn session(&self, participant: &ParticipantId, session: &SessionId) -> PathBuf {
        self.sessions().join(format!("{participant}_{session}.json"))
    }

    /// One session's copy of `study.toml`: its exact bytes when the session was set up.
    pub fn study_copy(&self, participant: &ParticipantId, session: &SessionId) -> PathBuf {
        self.sessions().join(format!("{participant}_{session}.study.toml"))
    }

    /// The log of the study's sweeps.
    pub fn sweep_events(&self) -> PathBuf {
        self.raw().join("sweeps.events.jsonl")
    }

    /// The folder of tables of metrics that other programs computed.
    pub fn own(&self) -> PathBuf {
        self.raw().join("own")
    }

    /// One table of such a metric.
    pub fn own_table(&self, metric: &MetricId, table: u32) -> PathBuf {
        self.own().join(format!("{metric}.{table:04}.parquet"))
    }

    /// The log of those tables.
    pub fn own_events(&self) -> PathBuf {
        self.raw().join("own.events.jsonl")
    }

    /// The tree of streams that other programs recorded beside sessions.
    pub fn beside(&self) -> PathBuf {
        self.raw().join("beside")
    }

    /// One table of such a stream.
    pub fn beside_table(
        &self,
        participant: &ParticipantId,
        session: &SessionId,
        stream: &StreamId,
        table: u32,
    ) -> PathBuf {
        let folder = self.beside().join(format!("participant={participant}"));
        folder.join(format!("session={session}")).join(format!("{stream}.{table:04}.parquet"))
    }

    /// One session's event log.
    pub fn events(&self, participant: &ParticipantId, session: &SessionId) -> PathBuf {
        self.sessions().join(format!("{participant}_{session}.events.jsonl"))
    }

    /// The folder of journals: trials in progress, or cut short and not yet recovered.
    pub fn journals(&self) -> PathBuf {
        self.raw().join("journal")
    }

    /// The journal of a trial in progress.
    pub fn journal(&self, participant: &ParticipantId, session: &SessionId, trial: u32) -> PathBuf {
        self.journals().join(format!("{participant}_{session}.trial-{trial:03}.journal"))
    }

    /// The list of what a change of several files is about to write; it is there while one is made,
    /// and after one that was cut short.
    pub fn unfinished(&self) -> PathBuf {
        self.raw().join("unfinished.json")
    }

    /// The lock that only one writer of the study can hold.
    pub(crate) fn lock(&self) -> PathBuf {
        self.raw().join(".lock")
    }

    /// The file by which a participant's screen finds the session that is being recorded.
    pub(crate) fn port(&self) -> PathBuf {
        self.raw().join(".participant")
    }

    /// A path as shown to people: relative to the root if it is below it.
    pub fn shown<'a>(&self, path: &'a Path) -> &'a Path {
        path.strip_prefix(&self.root).unwrap_or(path)
    }
}
