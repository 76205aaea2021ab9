//! What a stage of the study's own depends on besides files.

use crate::shared::trials::TrialLabel;
use serde::Serialize;
use zwidth_results::TrialKey;
use zwidth_study::{
    EnvironmentId, GivenFigure, GivenMetric, OutsideMetric, OwnStage, ParticipantId, SessionId,
    Source, StageFormat, StageId, StudyId, TrialMeta,
};

/// A trial that a stage gets.
#[derive(Debug, Clone, Serialize)]
pub(super) struct StageTrial {
    pub(super) participant: ParticipantId,
    pub(super) session: SessionId,
    pub(super) environment: EnvironmentId,
    pub(super) source: Source,
    #[serde(flatten)]
    pub(super) label: TrialLabel,
}

impl StageTrial {
    /// What its file says of it, with the labels that it has now: of an unsealed session only the log knows the modes.
    pub(super) fn labelled(&self, meta: TrialMeta) -> TrialMeta {
        let (repeat, mode) = (self.label.repeat, self.label.mode.clone());
        TrialMeta { repeat, mode, environment: self.environment.clone(), ..meta }
    }

    /// Its key, the first columns of tables.
    pub(super) fn key(&self) -> TrialKey {
        TrialKey {
            participant: self.participant.clone(),
            session: self.session.clone(),
            trial: self.label.trial,
            repeat: self.label.repeat,
            environment: self.environment.clone(),
            mode: self.label.mode.clone(),
            source: self.source,
        }
    }
}

/// What a stage's job depends on besides files.
#[derive(Serialize)]
pub(super) struct Parameters {
    pub(super) command: Vec<String>,
    pub(super) inputs: Vec<StageId>,
    pub(super) columns: Vec<String>,
    pub(super) format: StageFormat,
    pub(super) gives: Vec<GivenMetric>,
    pub(super) figures: Vec<GivenFigure>,
    pub(super) trials: Vec<StageTrial>,
    pub(super) simulated: bool,
    /// What changes nothing that it gives: its id and its name, its files (whose content is in the
    /// key), and when it is ended.
    #[serde(skip)]
    pub(super) stage: OwnStage,
    #[serde(skip)]
    pub(super) study: StudyId,
    /// The metrics that it gives, as metrics of the study.
    #[serde(skip)]
    pub(super) metrics: Vec<OutsideMetric>,
}
